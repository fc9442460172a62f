//! From a surface to its field: the phases of a build, in order.

use surface::{Positions, TriangleSurface};

use crate::band::{self, Nearest};
use crate::carry;
use crate::compare::{THIN, compare};
use crate::convert::convert;
use crate::envelope::FAR;
use crate::field::DistanceField;
use crate::grid::{Grid, bounds, check_positive};
use crate::inside::Inside;
use crate::measure::measure;
use crate::memory::zeroed;
use crate::num::{coordinate, single};
use crate::options::{BuildOptions, Conversion, Method, NodeValues, SignRule, Storage, Transform};
use crate::par;
use crate::quasi::{MOST, quasi_interpolate};
use crate::report::{BuildReport, Phase, Warning};
use crate::sign::{Barrier, sign};
use crate::spread::MAX_REACH;
use crate::store::Store;
use crate::transform::transform;
use crate::units::Units;
use crate::{FieldError, winding::Winding};

/// Narrowest band whose nodes surround every cell that the surface crosses:
/// the diagonal of a cell, √3, and a little.
const LEAST_BAND: f64 = 1.75;

/// What single precision and the band's widening may take off a node's distance
/// \[spacings\].
const ROUNDING: f64 = 1e-5;

/// Cells that a surface should span along its longest axis.
const FEW_CELLS: f64 = 4.0;

/// Share of thin places that is worth a warning: less than this, or so, is the
/// edges of any solid.
const THIN_SHARE: f64 = 0.01;

/// Share of the enclosed volume that a flood may lose to its voxels without a
/// warning.
const LOST_SHARE: f64 = 0.5;

impl DistanceField {
    /// Builds the field of a surface at positions `x`.
    ///
    /// The result is the same to the bit whatever the number of threads.
    ///
    /// ```
    /// use distance_field::{BuildOptions, DistanceField, Interpolation};
    /// use surface::{TriangleSurface, glam::DVec3};
    ///
    /// let faces = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
    /// let x = [DVec3::ZERO, DVec3::X * 30.0, DVec3::Y * 30.0, DVec3::Z * 30.0];
    /// let tetrahedron = TriangleSurface::new(4, faces)?;
    ///
    /// let field = DistanceField::build(&tetrahedron, tetrahedron.positions(&x)?, &BuildOptions::default())?;
    /// let sample = field.sample(DVec3::new(8.0, 8.0, -2.0), Interpolation::Trilinear).unwrap();
    /// assert!((sample.distance - 2.0).abs() < 1e-5);
    /// assert!((sample.gradient + DVec3::Z).length() < 1e-5);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// - [`FieldError::Empty`] when there are no faces.
    /// - [`FieldError::Option`] with the first length that makes no sense.
    /// - [`FieldError::TooLarge`], before anything is allocated, when grid and
    ///   scratch exceed the budget, [`FieldError::TooLong`] when an axis has too
    ///   many nodes to count distances over; [`FieldError::OutOfMemory`] when the system
    ///   grants less.
    /// - [`FieldError::Sign`] when the sign rule needs a closed surface.
    /// - [`FieldError::StepTooSmall`] when 16-bit steps do not reach.
    pub fn build(
        surface: &TriangleSurface,
        x: Positions<'_>,
        options: &BuildOptions,
    ) -> Result<Self, FieldError> {
        if surface.faces().is_empty() {
            return Err(FieldError::Empty);
        }
        check(options)?;
        let bytes_per_node = bytes_per_node(options);
        let lengths = [options.spacing, options.padding];
        let grid = Grid::around(x.as_slice(), lengths, bytes_per_node, options.max_bytes)?;
        let report = BuildReport {
            peak_bytes: crate::num::floor_count(bytes_per_node * coordinate(grid.node_count())),
            ..BuildReport::default()
        };
        Build { surface, x, options, grid, report }.run()
    }
}

fn check(options: &BuildOptions) -> Result<(), FieldError> {
    if let Some(truncate) = options.truncate {
        check_positive("truncation", truncate)?;
    }
    match options.method {
        Method::ExactBand { band, .. } if !(band.is_finite() && band >= LEAST_BAND) => {
            let expected = "1.75 spacings or more, and finite";
            Err(FieldError::Option { name: "band", value: band, expected })
        }
        _ => Ok(()),
    }
}

/// Bytes that are held at once, a node.
fn bytes_per_node(options: &BuildOptions) -> f64 {
    let is_short = |limit: f64| limit <= coordinate(MAX_REACH) * options.spacing;
    let distances = match options.method {
        // Values, faces, and how near they came from.
        Method::ExactBand { .. } if options.truncate.is_some_and(is_short) => 4 + 4 + 2,
        Method::ExactBand { .. } => 4 + 4 + 4,
        // Voxels, squares, and the flood.
        Method::Seed { .. } => 1 + 4 + 1,
    };
    let stored = match options.storage {
        Storage::Dense => 4,
        Storage::Steps { .. } => 4 + 2,
        // All steps, and bricks of at most 729 / 512 as many.
        Storage::Bricks { .. } => 4 + 2 + 3,
    };
    f64::from(distances.max(stored))
}

/// A build under way.
struct Build<'a> {
    surface: &'a TriangleSurface,
    x: Positions<'a>,
    options: &'a BuildOptions,
    grid: Grid,
    report: BuildReport,
}

impl Build<'_> {
    fn run(mut self) -> Result<DistanceField, FieldError> {
        let BuildOptions { method, sign: rule, storage, .. } = *self.options;
        let (mut values, voxels) = match method {
            Method::ExactBand { band, relax, .. } => (self.exact_band(band, relax)?, None),
            Method::Seed { conversion, transform } => {
                let (values, voxels) = self.seed(conversion, transform)?;
                (values, Some(voxels))
            }
        };
        let (surface, x, grid) = (self.surface, self.x, self.grid);
        let barrier = voxels.as_deref().map_or(Barrier::Surface(&values), Barrier::Voxels);
        let signed = self.report.time(Phase::Sign, || sign(rule, surface, x, &grid, barrier))?;
        let limit = self.limit();
        self.report.time(Phase::Compose, || compose(&mut values, &signed.inside, &grid, limit));
        if let Method::ExactBand { band, nodes: NodeValues::QuasiInterpolating, .. } = method {
            // Beyond the band, what two faces that compete leave would be made more.
            let within = limit.min(single(band * grid.spacing()));
            self.report.time(Phase::Adjust, || quasi_interpolate(&mut values, &grid, within));
        }
        self.warn_about_size();
        self.warn_about_sign(&signed.inside, signed.winding.as_ref(), voxels.as_deref());
        drop(voxels);
        let store = self.report.time(Phase::Store, || Store::new(values, &grid, storage))?;
        let is_closed = signed.winding.as_ref().is_none_or(|winding| winding.chain == 0);
        self.report.certain = self.certain(is_closed, &store);
        let inverted = signed.winding.is_some_and(|winding| winding.inverted);
        self.compared(store, inverted)
    }

    /// The largest distance that is told apart.
    fn limit(&self) -> f32 {
        // What no face was found for is as far as can be on the grid.
        let grid = &self.grid;
        let farthest = grid.position(grid.dims()).distance(grid.origin());
        single(self.options.truncate.unwrap_or(farthest))
    }

    /// As [`BuildReport::certain`].
    fn certain(&self, is_closed: bool, store: &Store) -> Option<f64> {
        let is_exact = is_closed && matches!(self.options.method, Method::ExactBand { .. });
        let spacing = self.grid.spacing();
        // Squares and roots in single precision, at the width of the band and a cell.
        let rounding = ROUNDING * spacing + store.rounding();
        let given = match self.options.method.nodes() {
            NodeValues::Interpolating => 0.0,
            NodeValues::QuasiInterpolating => MOST * spacing,
        };
        is_exact.then(|| 0.5 * 3.0_f64.sqrt() * spacing + given + rounding)
    }

    /// Squared distances, in spacings, from the exact band.
    fn exact_band(&mut self, band: f64, relax: bool) -> Result<Vec<f32>, FieldError> {
        let (surface, x, grid) = (self.surface, self.x, self.grid);
        let dims = grid.dims();
        let limit = self.options.truncate.map(|limit| limit / grid.spacing());
        let report = &mut self.report;
        let (units, mut nearest) = report.time(Phase::Prepare, || {
            let units = Units::new(surface, x, &grid);
            let squared = zeroed(grid.node_count())?;
            let face = zeroed(grid.node_count())?;
            Ok((units, Nearest { squared, face }))
        })?;
        report.time(Phase::Band, || band::fill(&units, dims, band, &mut nearest));
        let carried =
            report.time(Phase::Carry, || carry::carry(&mut nearest, dims, band, limit))?;
        report.time(Phase::Measure, || measure(&units, &mut nearest, &carried, dims));
        if relax {
            report.time(Phase::Relax, || carry::relax(&units, &mut nearest, &carried, dims));
        }
        Ok(nearest.squared)
    }

    /// Squared distances, in spacings, to the nearest voxel that is switched on,
    /// and these voxels.
    fn seed(
        &mut self,
        conversion: Conversion,
        by: Transform,
    ) -> Result<(Vec<f32>, Vec<bool>), FieldError> {
        let (surface, x, grid) = (self.surface, self.x, self.grid);
        let dims = grid.dims();
        let units = self.report.time(Phase::Prepare, || Units::new(surface, x, &grid));
        let mut voxels = zeroed(grid.node_count())?;
        self.report.time(Phase::Convert, || convert(&units, dims, conversion, &mut voxels));
        let mut squared = zeroed(grid.node_count())?;
        self.report.time(Phase::Transform, || transform(&voxels, dims, by, &mut squared));
        Ok((squared.into_iter().map(square_as_float).collect(), voxels))
    }

    fn warn_about_size(&mut self) {
        let (lo, hi) = bounds(self.x.as_slice());
        let cells = (hi - lo).max_element() / self.grid.spacing();
        if cells < FEW_CELLS {
            self.report.warnings.push(Warning::SpansFewCells { cells });
        }
    }

    fn warn_about_sign(
        &mut self,
        inside: &Inside,
        winding: Option<&Winding>,
        voxels: Option<&[bool]>,
    ) {
        let nx = self.grid.dims()[0];
        let cell = self.grid.spacing().powi(3);
        let volume = |nodes: usize| coordinate(nodes) * cell;
        self.report.inside_volume = volume(inside.count(nx));
        if winding.is_some_and(|winding| winding.inverted) {
            self.report.warnings.push(Warning::Inverted);
        }
        if let Some(&Winding { chain: edges @ 1.., .. }) = winding {
            self.report.warnings.push(Warning::Open { edges });
        }
        if self.options.sign == SignRule::Flood {
            let on_surface = voxels.map_or(0, |voxels| voxels.iter().filter(|on| **on).count());
            // A voxel of the surface is half inside.
            let found = self.report.inside_volume + 0.5 * volume(on_surface);
            let enclosed = crate::winding::enclosed_volume(self.surface, self.x).abs();
            let share = 1.0 - found.min(enclosed) / enclosed;
            if share > LOST_SHARE {
                self.report.warnings.push(Warning::InteriorLost { share });
            }
        }
    }

    fn compared(self, store: Store, inverted: bool) -> Result<DistanceField, FieldError> {
        let Self { surface, x, options, grid, report } = self;
        let mut field = DistanceField::new(grid, store, report).with_nodes(options.method.nodes());
        if options.samples > 0 {
            let limit = options.truncate.unwrap_or(f64::INFINITY);
            let inward = if inverted { 1.0 } else { -1.0 };
            let mut report = std::mem::take(&mut field.report);
            let compared = report.time(Phase::Compare, || {
                compare(&field, (surface, x), options.samples, limit, inward)
            });
            if let Some(compared) = compared {
                report.comparison = Some(compared.comparison);
                if compared.thin > THIN_SHARE {
                    let limit = THIN * grid.spacing();
                    report.warnings.push(Warning::ThinnerThanGrid { share: compared.thin, limit });
                }
            }
            field.report = report;
        }
        Ok(field)
    }
}

#[expect(clippy::cast_precision_loss, reason = "24 bits hold squares up to 4096 spacings")]
fn square_as_float(squared: u32) -> f32 {
    if squared == FAR { f32::INFINITY } else { squared as f32 }
}

/// Squared distances in spacings to signed distances of at most `limit`.
fn compose(values: &mut [f32], inside: &Inside, grid: &Grid, limit: f32) {
    let ([nx, ny, _], spacing) = (grid.dims(), single(grid.spacing()));
    par::for_each(values.chunks_mut(nx * ny).collect(), |k, plane| {
        for (j, row) in plane.chunks_mut(nx).enumerate() {
            for value in row.iter_mut() {
                *value = (value.sqrt() * spacing).min(limit);
            }
            inside.sign(k * ny + j, row);
        }
    });
}
