//! Build of a field from a surface.

use glam::DVec3;
use surface::progress::{Interrupted, Progress};
use surface::{Positions, SurfaceError, TriangleSurface, parallel, triangle};

use crate::accuracy::{AccuracyParams, THIN, accuracy};
use crate::band::{self, BandParams, MAX_CORRECTION, quasi_interpolate};
use crate::deep::deep_error;
use crate::face_groups::FaceGroups;
use crate::num::{coordinate, floor_count, single};
use crate::sign::{Enclosed, InsideRule, Winding, enclosed, enclosures, winding};
use crate::store::NodeStore;
use crate::units::GridSurface;
use crate::voxel::{self, VoxelField};
use crate::{
    DistanceField, FieldError, FieldGrid, FieldMethod, FieldParams, FieldReport, FieldWarning,
    NodeValues, Storage, Voxelization,
};

/// Rounding of a distance in a narrow band, by single precision and by the widening of the band
/// \[spacings\].
const ROUNDING: f64 = 1e-5;

/// Share of a distance by which single precision rounds it: its square, the root of that, the
/// spacing and their product, by half a unit each.
const SINGLE_ROUNDING: f64 = 2.0 * f32::EPSILON as f64;

/// Number of cells that a surface should span along its longest axis.
const MIN_CELLS: f64 = 4.0;

/// Fraction of thin samples above which a warning is due: the edges of any solid are thin.
const MAX_THIN: f64 = 0.01;

/// Fraction of the enclosed volume that a flood may lose to its voxels without a warning.
const MAX_LOST: f64 = 0.5;

/// Samples near the surface per sample far from it, which costs as many times as much.
const DEEP_FRACTION: usize = 8;

impl DistanceField {
    /// Builds the field of a surface at positions `x`.
    ///
    /// The same input gives the same bits, whatever the number of threads.
    ///
    /// ```
    /// use distance_field::{DistanceField, FieldParams, Interpolation};
    /// use surface::{TriangleSurface, glam::DVec3, progress::Progress};
    ///
    /// let faces = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
    /// let x = [DVec3::ZERO, DVec3::X * 30.0, DVec3::Y * 30.0, DVec3::Z * 30.0];
    /// let tetrahedron = TriangleSurface::new(4, faces)?;
    /// let x = tetrahedron.positions(&x)?;
    ///
    /// let params = FieldParams::new(1.0);
    /// let field = DistanceField::build(&tetrahedron, x, &params, Progress::none())?;
    /// let sample = field.evaluate(DVec3::new(8.0, 8.0, -2.0), Interpolation::Trilinear).unwrap();
    /// assert!((sample.distance - 2.0).abs() < 1e-5);
    /// assert!((sample.gradient + DVec3::Z).length() < 1e-5);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// - [`FieldError::Empty`] when there are no faces.
    /// - [`FieldError::InvalidParam`] with the first parameter that is out of range.
    /// - [`FieldError::TooLarge`], before anything is allocated, when grid and scratch
    ///   memory exceed the budget; [`FieldError::AxisTooLong`] when squared distances along
    ///   an axis overflow; [`FieldError::OutOfMemory`] when the system grants less.
    /// - [`FieldError::NotClosed`] for an open surface and the voxel method.
    /// - [`FieldError::StepTooSmall`] when 16-bit steps do not reach.
    /// - [`FieldError::Interrupted`] when the progress handler ends the build.
    pub fn build(
        surface: &TriangleSurface,
        x: Positions<'_>,
        params: &FieldParams,
        progress: Progress<'_>,
    ) -> Result<Self, FieldError> {
        if surface.faces().is_empty() {
            return Err(FieldError::Empty);
        }
        params.validate()?;
        let bounds = surface.bounds(x);
        let (bytes, max_bytes) = (bytes_per_node(params), params.max_bytes);
        let grid = FieldGrid::around(bounds, params.spacing, params.padding, bytes, max_bytes)?;

        let mut report = FieldReport {
            peak_bytes: floor_count(bytes * coordinate(grid.node_count())),
            ..FieldReport::default()
        };
        let cells = bounds.sides().max_element() / grid.spacing();
        if cells < MIN_CELLS {
            report.warnings.push(FieldWarning::SpansFewCells { cells });
        }
        Build { surface, x, params, grid, report }.run(progress)
    }
}

/// Returns the bytes per node that a build holds at once.
fn bytes_per_node(params: &FieldParams) -> f64 {
    let distances = match params.method {
        FieldMethod::ExactBand { band, .. } => band::bytes_per_node(band_params(params, band)),
        FieldMethod::Voxel { .. } => voxel::BYTES_PER_NODE,
    };
    let stored = match params.storage {
        Storage::Float => 4.0,
        Storage::Quantized { .. } => 4.0 + 2.0,
    };
    distances.max(stored)
}

/// Returns the parameters of the exact band in spacings.
fn band_params(params: &FieldParams, band: f64) -> BandParams {
    let truncation = params.truncation.map(|truncation| truncation / params.spacing);
    BandParams { band, truncation }
}

/// State of a build.
struct Build<'a> {
    surface: &'a TriangleSurface,
    x: Positions<'a>,
    params: &'a FieldParams,
    grid: FieldGrid,
    report: FieldReport,
}

/// Distances without signs, with the set of inside nodes.
struct Unsigned {
    /// Squared distances in spacings.
    squared: Vec<f32>,
    /// Per node, true if it is inside.
    inside: Vec<bool>,
    /// Rule that the inside follows; `None` for an open surface, whose sign also changes where no
    /// surface is.
    rule: Option<InsideRule>,
    is_inverted: bool,
}

impl Build<'_> {
    fn run(mut self, progress: Progress<'_>) -> Result<DistanceField, FieldError> {
        let (early, late) = (progress.part(0.0, 0.8), progress.part(0.8, 0.9));
        let unsigned = match self.params.method {
            FieldMethod::ExactBand { band, .. } => self.exact_band(band, early)?,
            FieldMethod::Voxel { voxelization } => self.voxel(voxelization, early)?,
        };
        self.report.error_bound = self.error_bound(&unsigned);

        // From squares to signed values, and for the exact band on to coefficients.
        let mut values = unsigned.squared;
        let limit = self.limit();
        compose(&mut values, &unsigned.inside, &self.grid, limit);
        drop(unsigned.inside);
        if let FieldMethod::ExactBand { band, node_values, .. } = self.params.method
            && node_values == NodeValues::QuasiInterpolating
        {
            // Beyond the band, a correction would enlarge what competing faces leave.
            let limit = limit.min(single(band * self.grid.spacing()));
            quasi_interpolate(&mut values, &self.grid, limit, late)?;
        }

        let Self { surface, x, params, grid, report } = self;
        let store = NodeStore::new(values, &grid, params.storage)?;
        let field = DistanceField::new(grid, store, report);
        let mut field = field.with_node_values(params.method.node_values());
        if params.samples > 0 {
            let truncation = params.truncation.unwrap_or(f64::INFINITY);
            let Unsigned { rule, is_inverted, .. } = unsigned;
            let params = AccuracyParams { samples: params.samples, truncation, rule, is_inverted };
            field.measure_error(surface, x, params, progress.part(0.9, 1.0))?;
        }
        Ok(field)
    }

    /// Computes exact distances, signed by winding number.
    fn exact_band(&mut self, band: f64, progress: Progress<'_>) -> Result<Unsigned, FieldError> {
        let surface = GridSurface::new(self.surface, self.x, &self.grid);
        let params = band_params(self.params, band);
        let dims = self.grid.dims();
        let squared = band::squared_distances(&surface, dims, params, progress.part(0.0, 0.8))?;

        let signs = winding(self.surface, self.x, &self.grid, progress.part(0.8, 1.0))?;
        let Winding { inside, is_inverted, boundary_edges: edges } = signs;
        self.report.inside_volume = self.volume(voxel::count(&inside));
        let is_sheet = edges > 0 && self.report.inside_volume < self.sheet_volume();
        if is_inverted {
            self.report.warnings.push(FieldWarning::Inverted);
        }
        if edges > 0 {
            self.warn_of_boundary();
        }
        if is_sheet {
            self.report.warnings.push(FieldWarning::NoInside);
        }
        let rule = if is_inverted { InsideRule::Negative } else { InsideRule::Positive };
        Ok(Unsigned { squared, inside, rule: (edges == 0).then_some(rule), is_inverted })
    }

    /// Warns about the edges that bound the surface, counted as its inspection counts them.
    fn warn_of_boundary(&mut self) {
        if let Err(SurfaceError::Open { count: edges, .. }) = self.surface.require_closed() {
            self.report.warnings.push(FieldWarning::Open { edges });
        }
        if let Err(SurfaceError::Misoriented { count: edges, .. }) = self.surface.require_oriented()
        {
            self.report.warnings.push(FieldWarning::Misoriented { edges });
        }
    }

    /// Returns the volume of half a spacing over all faces: a solid of less would be thinner
    /// than a spacing.
    fn sheet_volume(&self) -> f64 {
        let mut area = 0.0;
        for &face in self.surface.faces() {
            area += triangle::area(self.x.corners(face));
        }
        0.5 * self.grid.spacing() * area
    }

    /// Computes distances from voxels, signed by flood fill and without cavities.
    fn voxel(
        &mut self,
        voxelization: Voxelization,
        progress: Progress<'_>,
    ) -> Result<Unsigned, FieldError> {
        let surface = GridSurface::new(self.surface, self.x, &self.grid);
        let (dims, most, rest) =
            (self.grid.dims(), progress.part(0.0, 0.95), progress.part(0.95, 1.0));
        let mut field = VoxelField::new(&surface, dims, voxelization, most)?;

        // With neighboring faces of opposite orientations, nothing is enclosed a whole number of
        // times: no cavity is told from the inside.
        let Enclosed { volume, boundary_edges } = enclosed(self.surface, self.x);
        let rule = (boundary_edges == 0).then_some(InsideRule::NonZero);
        if let Some(rule) = rule {
            let groups = FaceGroups::new(self.surface, self.x);
            field.remove_cavities(dims, |nodes| self.are_outside(nodes, &groups, rule, rest))?;
        }
        let VoxelField { squared, inside, surface_voxels } = field;

        // Half of each voxel of the surface is inside.
        self.report.inside_volume = self.volume(voxel::count(&inside));
        let found = self.report.inside_volume + 0.5 * self.volume(surface_voxels);
        let enclosed = volume.abs();
        let fraction = 1.0 - found.min(enclosed) / enclosed;
        if fraction > MAX_LOST {
            self.report.warnings.push(FieldWarning::InteriorLost { fraction });
        }
        Ok(Unsigned { squared, inside, rule, is_inverted: volume < 0.0 })
    }

    /// Returns true for each node that is outside by exact winding numbers.
    fn are_outside(
        &self,
        nodes: &[usize],
        groups: &FaceGroups<'_>,
        rule: InsideRule,
        progress: Progress<'_>,
    ) -> Result<Vec<bool>, Interrupted> {
        let [nx, ny, _] = self.grid.dims();
        let place =
            |&node: &usize| self.grid.position([node % nx, node / nx % ny, node / (nx * ny)]);
        let points: Vec<DVec3> = nodes.iter().map(place).collect();
        let counts = enclosures(groups, &points, progress)?;
        Ok(counts.into_iter().map(|count| !rule.holds(count)).collect())
    }

    /// Returns the bound of [`FieldReport::error_bound`].
    fn error_bound(&self, unsigned: &Unsigned) -> Option<f64> {
        let FieldMethod::ExactBand { band, node_values } = self.params.method else { return None };
        let correction = match node_values {
            NodeValues::Interpolating => 0.0,
            NodeValues::QuasiInterpolating => MAX_CORRECTION,
        };
        let storage = match self.params.storage {
            Storage::Float => 0.0,
            Storage::Quantized { step } => 0.5 * step,
        };
        let spacing = self.grid.spacing();
        let rounding = ROUNDING.max(SINGLE_ROUNDING * band) * spacing + storage;
        let bound = 0.5 * 3.0_f64.sqrt() * spacing + correction * spacing + rounding;
        unsigned.rule.is_some().then_some(bound)
    }

    /// Returns the largest distance that is stored: at most the diagonal of the grid, which
    /// nodes without a face take.
    fn limit(&self) -> f32 {
        let diagonal = self.grid.position(self.grid.dims()).distance(self.grid.origin());
        single(self.params.truncation.unwrap_or(diagonal))
    }

    /// Returns the volume of the cells around some nodes.
    fn volume(&self, nodes: usize) -> f64 {
        coordinate(nodes) * self.grid.spacing().powi(3)
    }
}

impl DistanceField {
    /// Measures the error of the field, and warns about thin parts.
    fn measure_error(
        &mut self,
        surface: &TriangleSurface,
        x: Positions<'_>,
        params: AccuracyParams,
        progress: Progress<'_>,
    ) -> Result<(), FieldError> {
        let (near, deep) = (progress.part(0.0, 0.5), progress.part(0.5, 1.0));
        let groups = FaceGroups::new(surface, x);
        let Some(accuracy) = accuracy(self, &groups, params, near)? else {
            return Ok(());
        };
        self.report.measured_error = Some(accuracy.error);
        let fraction = accuracy.thin_fraction;
        if fraction > MAX_THIN {
            let thickness = THIN * self.grid.spacing();
            self.report.warnings.push(FieldWarning::ThinnerThanGrid { fraction, thickness });
        }

        let params = AccuracyParams { samples: params.samples.div_ceil(DEEP_FRACTION), ..params };
        self.report.measured_deep_error = deep_error(self, &groups, params, deep)?;
        Ok(())
    }
}

/// Converts squared distances in spacings to signed distances of at most `limit`.
fn compose(values: &mut [f32], inside: &[bool], grid: &FieldGrid, limit: f32) {
    let ([nx, ny, _], spacing) = (grid.dims(), single(grid.spacing()));
    let planes = values.chunks_mut(nx * ny).zip(inside.chunks(nx * ny)).collect();
    parallel::for_each(planes, |_, (values, inside): (&mut [f32], &[bool])| {
        for (value, &is_inside) in values.iter_mut().zip(inside) {
            // Without a branch, which vectorizes.
            let distance = value.sqrt() * spacing;
            let distance = if distance < limit { distance } else { limit };
            *value = f32::from_bits(distance.to_bits() | u32::from(is_inside) << 31);
        }
    });
}
