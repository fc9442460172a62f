//! From a surface to its field: the phases of a build, in order.

use surface::{Positions, SurfaceError, TriangleSurface};

use crate::band::{self, Nearest};
use crate::carry;
use crate::compare::{THIN, compare};
use crate::convert::convert;
use crate::envelope::FAR;
use crate::field::DistanceField;
use crate::grid::{FieldGrid, bounds};
use crate::inside::Inside;
use crate::measure::measure;
use crate::memory::zeroed;
use crate::num::{coordinate, single};
use crate::par;
use crate::params::{FieldMethod, FieldParams, NodeValues, Storage, Voxelization};
use crate::quasi::{MOST, quasi_interpolate};
use crate::report::{FieldReport, FieldWarning};
use crate::spread::MAX_REACH;
use crate::store::Store;
use crate::transform::transform;
use crate::units::Units;
use crate::winding::{Winding, winding};
use crate::{FieldError, flood};

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
    /// use distance_field::{FieldParams, DistanceField, Interpolation};
    /// use surface::{TriangleSurface, glam::DVec3};
    ///
    /// let faces = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
    /// let x = [DVec3::ZERO, DVec3::X * 30.0, DVec3::Y * 30.0, DVec3::Z * 30.0];
    /// let tetrahedron = TriangleSurface::new(4, faces)?;
    ///
    /// let field = DistanceField::build(&tetrahedron, tetrahedron.positions(&x)?, &FieldParams::new(1.0))?;
    /// let sample = field.evaluate(DVec3::new(8.0, 8.0, -2.0), Interpolation::Trilinear).unwrap();
    /// assert!((sample.distance - 2.0).abs() < 1e-5);
    /// assert!((sample.gradient + DVec3::Z).length() < 1e-5);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// - [`FieldError::Empty`] when there are no faces.
    /// - [`FieldError::InvalidParam`] with the first length that makes no sense.
    /// - [`FieldError::TooLarge`], before anything is allocated, when grid and
    ///   scratch exceed the budget, [`FieldError::AxisTooLong`] when an axis has too
    ///   many nodes to count distances over; [`FieldError::OutOfMemory`] when the system
    ///   grants less.
    /// - [`FieldError::Sign`] when the sign rule needs a closed surface.
    /// - [`FieldError::StepTooSmall`] when 16-bit steps do not reach.
    pub fn build(
        surface: &TriangleSurface,
        x: Positions<'_>,
        params: &FieldParams,
    ) -> Result<Self, FieldError> {
        if surface.faces().is_empty() {
            return Err(FieldError::Empty);
        }
        params.validate()?;
        let bytes_per_node = bytes_per_node(params);
        let lengths = [params.spacing, params.padding];
        let grid = FieldGrid::around(x.as_slice(), lengths, bytes_per_node, params.max_bytes)?;
        let report = FieldReport {
            peak_bytes: crate::num::floor_count(bytes_per_node * coordinate(grid.node_count())),
            ..FieldReport::default()
        };
        Build { surface, x, params, grid, report }.run()
    }
}

/// Bytes that are held at once, a node.
fn bytes_per_node(params: &FieldParams) -> f64 {
    let is_short = |limit: f64| limit <= coordinate(MAX_REACH) * params.spacing;
    let distances = match params.method {
        // Values, faces, and how near they came from.
        FieldMethod::ExactBand { .. } if params.truncation.is_some_and(is_short) => 4 + 4 + 2,
        FieldMethod::ExactBand { .. } => 4 + 4 + 4,
        // Voxels, squares, and the flood.
        FieldMethod::Voxel { .. } => 1 + 4 + 1,
    };
    let stored = match params.storage {
        Storage::Float => 4,
        Storage::Quantized { .. } => 4 + 2,
    };
    f64::from(distances.max(stored))
}

/// A build under way.
struct Build<'a> {
    surface: &'a TriangleSurface,
    x: Positions<'a>,
    params: &'a FieldParams,
    grid: FieldGrid,
    report: FieldReport,
}

impl Build<'_> {
    fn run(mut self) -> Result<DistanceField, FieldError> {
        let FieldParams { method, storage, .. } = *self.params;
        let (mut values, signed) = match method {
            FieldMethod::ExactBand { band, relax, .. } => {
                (self.exact_band(band, relax)?, self.signed())
            }
            FieldMethod::Voxel { voxelization } => self.voxel(voxelization)?,
        };
        let grid = self.grid;
        let limit = self.limit();
        compose(&mut values, &signed.inside, &grid, limit);
        if let FieldMethod::ExactBand { band, node_values, .. } = method
            && node_values == NodeValues::QuasiInterpolating
        {
            // Beyond the band, what two faces that compete leave would be made more.
            let within = limit.min(single(band * grid.spacing()));
            quasi_interpolate(&mut values, &grid, within);
        }
        self.warn_about_size();
        let store = Store::new(values, &grid, storage)?;
        self.report.error_bound = self.error_bound(signed.is_closed, &store);
        Ok(self.compared(store, signed.is_inverted))
    }

    /// The largest distance that is told apart.
    fn limit(&self) -> f32 {
        // What no face was found for is as far as can be on the grid.
        let grid = &self.grid;
        let farthest = grid.position(grid.dims()).distance(grid.origin());
        single(self.params.truncation.unwrap_or(farthest))
    }

    /// As [`FieldReport::error_bound`].
    fn error_bound(&self, is_closed: bool, store: &Store) -> Option<f64> {
        let is_exact = is_closed && matches!(self.params.method, FieldMethod::ExactBand { .. });
        let spacing = self.grid.spacing();
        // Squares and roots in single precision, at the width of the band and a cell.
        let rounding = ROUNDING * spacing + store.rounding();
        let given = match self.params.method.node_values() {
            NodeValues::Interpolating => 0.0,
            NodeValues::QuasiInterpolating => MOST * spacing,
        };
        is_exact.then(|| 0.5 * 3.0_f64.sqrt() * spacing + given + rounding)
    }

    /// Squared distances, in spacings, from the exact band.
    fn exact_band(&self, band: f64, relax: bool) -> Result<Vec<f32>, FieldError> {
        let grid = self.grid;
        let dims = grid.dims();
        let limit = self.params.truncation.map(|limit| limit / grid.spacing());
        let units = Units::new(self.surface, self.x, &grid);
        let squared = zeroed(grid.node_count())?;
        let mut nearest = Nearest { squared, face: zeroed(grid.node_count())? };

        band::fill(&units, dims, band, &mut nearest);
        let carried = carry::carry(&mut nearest, dims, band, limit)?;
        measure(&units, &mut nearest, &carried, dims);
        if relax {
            carry::relax(&units, &mut nearest, &carried, dims);
        }
        Ok(nearest.squared)
    }

    /// Inside by winding number, with what it says of the surface.
    fn signed(&mut self) -> Signed {
        let Winding { inside, inverted, chain } = winding(self.surface, self.x, &self.grid);
        self.report.inside_volume = self.volume(inside.count(self.grid.dims()[0]));
        if inverted {
            self.report.warnings.push(FieldWarning::Inverted);
        }
        if chain > 0 {
            self.report.warnings.push(FieldWarning::Open { edges: chain });
        }
        Signed { inside, is_inverted: inverted, is_closed: chain == 0 }
    }

    /// Squared distances, in spacings, to the nearest voxel that is switched on, and
    /// what a flood does not reach.
    fn voxel(&mut self, voxelization: Voxelization) -> Result<(Vec<f32>, Signed), FieldError> {
        check_closed(self.surface)?;
        let grid = self.grid;
        let units = Units::new(self.surface, self.x, &grid);
        let mut voxels = zeroed(grid.node_count())?;
        convert(&units, grid.dims(), voxelization, &mut voxels);
        let mut squared = zeroed(grid.node_count())?;
        transform(&voxels, grid.dims(), &mut squared);
        let squared = squared.into_iter().map(square_as_float).collect();

        let mask = flood::behind_voxels(&voxels, grid.dims());
        let inside = Inside::from_mask(&mask, grid.dims()[0]);
        self.report.inside_volume = self.volume(inside.count(grid.dims()[0]));
        let on_surface = voxels.iter().filter(|on| **on).count();
        // A voxel of the surface is half inside.
        let found = self.report.inside_volume + 0.5 * self.volume(on_surface);
        let enclosed = crate::winding::enclosed_volume(self.surface, self.x).abs();
        let fraction = 1.0 - found.min(enclosed) / enclosed;
        if fraction > LOST_SHARE {
            self.report.warnings.push(FieldWarning::InteriorLost { fraction });
        }
        Ok((squared, Signed { inside, is_inverted: false, is_closed: true }))
    }

    fn volume(&self, nodes: usize) -> f64 {
        coordinate(nodes) * self.grid.spacing().powi(3)
    }

    fn warn_about_size(&mut self) {
        let (lo, hi) = bounds(self.x.as_slice());
        let cells = (hi - lo).max_element() / self.grid.spacing();
        if cells < FEW_CELLS {
            self.report.warnings.push(FieldWarning::SpansFewCells { cells });
        }
    }

    fn compared(self, store: Store, inverted: bool) -> DistanceField {
        let Self { surface, x, params, grid, report } = self;
        let node_values = params.method.node_values();
        let mut field = DistanceField::new(grid, store, report).with_node_values(node_values);
        if params.samples > 0 {
            let limit = params.truncation.unwrap_or(f64::INFINITY);
            let inward = if inverted { 1.0 } else { -1.0 };
            if let Some(compared) = compare(&field, (surface, x), params.samples, limit, inward) {
                field.report.measured_error = Some(compared.error);
                if compared.thin > THIN_SHARE {
                    let (fraction, thickness) = (compared.thin, THIN * grid.spacing());
                    let warning = FieldWarning::ThinnerThanGrid { fraction, thickness };
                    field.report.warnings.push(warning);
                }
            }
        }
        field
    }
}

/// Inside, and what it is worth.
struct Signed {
    inside: Inside,
    is_inverted: bool,
    is_closed: bool,
}

/// Checks that every edge has an even number of faces, so that nothing leads around the
/// surface.
fn check_closed(surface: &TriangleSurface) -> Result<(), FieldError> {
    let is_open = |edge: &u32| surface.edge_faces(*edge).len() % 2 == 1;
    let mut open = (0..).take(surface.edges().len()).filter(is_open);
    let Some(first) = open.next() else {
        return Ok(());
    };
    let [from, to] = surface.edges()[first as usize];
    let face = surface.edge_faces(first)[0];
    let source = SurfaceError::Open { count: 1 + open.count(), from, to, face };
    Err(FieldError::NotClosed { source })
}

#[expect(clippy::cast_precision_loss, reason = "24 bits hold squares up to 4096 spacings")]
fn square_as_float(squared: u32) -> f32 {
    if squared == FAR { f32::INFINITY } else { squared as f32 }
}

/// Squared distances in spacings to signed distances of at most `limit`.
fn compose(values: &mut [f32], inside: &Inside, grid: &FieldGrid, limit: f32) {
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
