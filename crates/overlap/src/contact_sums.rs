//! Results of a joint contact, and the sums over cells that they are made of.

use glam::DVec3;
use proximity::SurfaceTree;
use surface::UnionFind;

/// Contact of one surface with another.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct JointContact {
    /// Measures of all of it.
    pub total: ContactMeasures,
    /// Measures of each separate region, by falling area. Faces in contact that share a vertex are of
    /// one region.
    pub regions: Vec<ContactMeasures>,
    /// The faces in contact, ascending: a map on the mesh.
    pub faces: Vec<FaceContact>,
}

/// Measures of a contact, or of one region of it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct ContactMeasures {
    /// Area of the cells whose center is in contact.
    pub area: f64,
    /// Area that is certainly in contact.
    pub area_lower: f64,
    /// Area that no contact exceeds.
    pub area_upper: f64,
    /// Center of the area; zero without area.
    pub center: DVec3,
    /// Mean gap over the area, negative where the surfaces overlap; 0 without area.
    pub mean_gap: f64,
    /// Smallest gap of a cell center: within the resolution of the smallest of all. Infinite without
    /// area.
    pub min_gap: f64,
    /// Mean pressure over the area.
    pub mean_pressure: f64,
    /// Largest pressure at a cell center.
    pub max_pressure: f64,
    /// Sum of pressure over area, against the outward normals: the force on this surface.
    pub force: DVec3,
    /// Center of the area weighted by pressure; zero without pressure.
    pub center_of_pressure: DVec3,
}

/// Contact of one face.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct FaceContact {
    /// The face.
    pub face: u32,
    /// Its area in contact.
    pub area: f64,
    /// Mean gap over that area.
    pub mean_gap: f64,
    /// Mean pressure over that area.
    pub mean_pressure: f64,
    /// Its region, a number of [`JointContact::regions`].
    pub region: u32,
}

/// Values of one cell, at its center.
pub(crate) struct CellValues {
    pub(crate) area: f64,
    pub(crate) center: DVec3,
    pub(crate) gap: f64,
    pub(crate) pressure: f64,
    pub(crate) normal: DVec3,
}

/// Sums over the cells of a face, or of a region.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ContactSums {
    area: f64,
    pub(crate) area_lower: f64,
    pub(crate) area_upper: f64,
    /// Area times center, and times gap.
    moment: DVec3,
    gap: f64,
    min_gap: f64,
    /// Pressure times area.
    load: f64,
    load_moment: DVec3,
    max_pressure: f64,
    force: DVec3,
}

impl Default for ContactSums {
    fn default() -> Self {
        Self {
            area: 0.0,
            area_lower: 0.0,
            area_upper: 0.0,
            moment: DVec3::ZERO,
            gap: 0.0,
            min_gap: f64::INFINITY,
            load: 0.0,
            load_moment: DVec3::ZERO,
            max_pressure: 0.0,
            force: DVec3::ZERO,
        }
    }
}

impl ContactSums {
    pub(crate) fn add(&mut self, cell: &CellValues) {
        let load = cell.pressure * cell.area;
        self.area += cell.area;
        self.moment += cell.area * cell.center;
        self.gap += cell.area * cell.gap;
        self.min_gap = self.min_gap.min(cell.gap);
        self.load += load;
        self.load_moment += load * cell.center;
        self.max_pressure = self.max_pressure.max(cell.pressure);
        self.force -= load * cell.normal;
    }

    fn merge(&mut self, other: &Self) {
        self.area += other.area;
        self.area_lower += other.area_lower;
        self.area_upper += other.area_upper;
        self.moment += other.moment;
        self.gap += other.gap;
        self.min_gap = self.min_gap.min(other.min_gap);
        self.load += other.load;
        self.load_moment += other.load_moment;
        self.max_pressure = self.max_pressure.max(other.max_pressure);
        self.force += other.force;
    }

    fn measures(&self) -> ContactMeasures {
        let per_area = reciprocal(self.area);
        ContactMeasures {
            area: self.area,
            area_lower: self.area_lower,
            area_upper: self.area_upper,
            center: per_area * self.moment,
            mean_gap: per_area * self.gap,
            min_gap: self.min_gap,
            mean_pressure: per_area * self.load,
            max_pressure: self.max_pressure,
            force: self.force,
            center_of_pressure: reciprocal(self.load) * self.load_moment,
        }
    }
}

impl Default for ContactMeasures {
    fn default() -> Self {
        ContactSums::default().measures()
    }
}

/// Returns the reciprocal of a weight, 0 for a weight of 0.
fn reciprocal(weight: f64) -> f64 {
    if weight > 0.0 { 1.0 / weight } else { 0.0 }
}

/// Collects faces, given in ascending order, into regions.
pub(crate) fn collect(body: &SurfaceTree, faces: &[(u32, ContactSums)]) -> JointContact {
    // Faces with a common vertex are of one region.
    let surface = body.surface();
    let mut sets = UnionFind::new(surface.vertex_count());
    for (face, _) in faces {
        let [a, b, c] = surface.faces()[*face as usize];
        sets.join(a, b);
        sets.join(b, c);
    }

    // Regions by the root of their vertices, in the order of their first face.
    let mut roots: Vec<u32> = Vec::new();
    let mut regions: Vec<ContactSums> = Vec::new();
    let mut total = ContactSums::default();
    let mut of_face: Vec<usize> = Vec::with_capacity(faces.len());
    for (face, sums) in faces {
        let root = sets.find(surface.faces()[*face as usize][0]);
        let region = roots.iter().position(|known| *known == root).unwrap_or(roots.len());
        if region == roots.len() {
            roots.push(root);
            regions.push(ContactSums::default());
        }
        regions[region].merge(sums);
        total.merge(sums);
        of_face.push(region);
    }

    // Regions by falling area; of equal areas, by their first face.
    let mut order: Vec<usize> = (0..regions.len()).collect();
    order.sort_by(|&i, &j| regions[j].area.total_cmp(&regions[i].area));
    let mut rank = vec![0_u32; order.len()];
    for (place, &region) in (0..).zip(&order) {
        rank[region] = place;
    }

    let mut contact = JointContact { total: total.measures(), ..JointContact::default() };
    for &region in &order {
        contact.regions.push(regions[region].measures());
    }
    for ((face, sums), region) in faces.iter().zip(of_face) {
        let ContactMeasures { area, mean_gap, mean_pressure, .. } = sums.measures();
        let region = rank[region];
        contact.faces.push(FaceContact { face: *face, area, mean_gap, mean_pressure, region });
    }
    contact
}
