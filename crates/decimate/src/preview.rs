//! Surface of fewer faces to look at.

use glam::DVec3;
use surface::TriangleSurface;

use crate::DecimateError;
use crate::collapsed::Collapsed;
use crate::decimation::check;
use crate::mesh::Mesh;
use crate::order::Collapse;
use crate::quadric::{Quadric, quadrics};

/// Surface of fewer faces on some of the vertices of a full one, to look at: in a seventh of the time
/// of a [`ReducedSurface`](crate::ReducedSurface), and nothing is proved about it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Preview {
    /// Per vertex, its number in the full surface, ascending.
    pub kept: Vec<u32>,
    /// Corners of the faces, in its own vertex numbers.
    pub faces: Vec<[u32; 3]>,
}

/// Parts of the tolerance that mean distances from planes may take, pass by pass, so that what costs little
/// goes first. Vertices are farther from the faces that are left than half the tolerance then, and seldom
/// farther than the whole.
const SHARES: [f64; 4] = [0.0625, 0.125, 0.25, 0.5];

/// A pass is the last of its share where this many times the vertices that it removes are fewer than are left.
const MIN_REMOVED: usize = 50;

impl Preview {
    /// Collapses edges of a surface whose vertices then are about a tolerance (length, `> 0`) from
    /// the faces that are left, at most.
    ///
    /// # Errors
    ///
    /// - [`DecimateError::Surface`] for a surface that is not closed, manifold and oriented, or that
    ///   the positions do not fit.
    /// - [`DecimateError::RepeatedVertex`] or [`DecimateError::TooSmall`] for one that
    ///   encloses nothing.
    /// - [`DecimateError::MaxDeviation`] for a tolerance that is not positive.
    pub fn new(
        surface: &TriangleSurface,
        positions: &[DVec3],
        tolerance: f64,
    ) -> Result<Self, DecimateError> {
        check(surface)?;
        surface.positions(positions)?;
        if tolerance.is_nan() || tolerance <= 0.0 {
            return Err(DecimateError::MaxDeviation { value: tolerance });
        }

        let mut thinning = Thinning::new(surface.faces(), positions);
        for share in SHARES {
            let max_cost = (share * tolerance) * (share * tolerance);
            while thinning.pass(max_cost) * MIN_REMOVED > thinning.left() {}
        }
        let Collapsed { kept, faces, .. } =
            Collapsed::new(positions.len(), surface.faces(), &thinning.collapses);
        Ok(Self { kept, faces })
    }
}

/// Surface that loses vertices, pass by pass.
struct Thinning<'a> {
    x: &'a [DVec3],
    mesh: Mesh<'a>,
    quadrics: Vec<Quadric>,
    /// Point that quadrics are relative to.
    origin: DVec3,
    /// Per vertex, its cheapest collapse.
    cheapest: Vec<Cheapest>,
    collapses: Vec<Collapse>,
}

/// Cheapest collapse of a vertex.
#[derive(Clone, Copy)]
enum Cheapest {
    /// To be found anew, since the faces at the vertex have changed.
    Unknown,
    /// The vertex is gone, or no collapse is allowed.
    None,
    Into {
        neighbor: u32,
        cost: f64,
    },
}

impl<'a> Thinning<'a> {
    fn new(faces: &[[u32; 3]], x: &'a [DVec3]) -> Self {
        let origin = x.first().copied().unwrap_or_default();
        Self {
            x,
            mesh: Mesh::new(faces, x),
            quadrics: quadrics(faces, x, origin),
            origin,
            cheapest: vec![Cheapest::Unknown; x.len()],
            collapses: Vec::new(),
        }
    }

    /// Returns the number of vertices that are left.
    fn left(&self) -> usize {
        self.x.len() - self.collapses.len()
    }

    /// Performs collapses that cost no more, each vertex and its neighbors once, and returns their
    /// number.
    fn pass(&mut self, max_cost: f64) -> usize {
        let before = self.collapses.len();
        let mut has_changed = vec![false; self.x.len()];
        for vertex in (0_u32..).take(self.x.len()) {
            if has_changed[vertex as usize] {
                continue;
            }
            let Cheapest::Into { neighbor: into, cost } = self.cheapest(vertex) else { continue };
            if cost <= max_cost && self.mesh.may_collapse(vertex, into) {
                self.perform(Collapse { vertex, into }, &mut has_changed);
            }
        }
        self.collapses.len() - before
    }

    /// Returns the cheapest collapse of a vertex, found where it is not known.
    fn cheapest(&mut self, vertex: u32) -> Cheapest {
        if let Cheapest::Unknown = self.cheapest[vertex as usize] {
            self.cheapest[vertex as usize] = self.find_cheapest(vertex);
        }
        self.cheapest[vertex as usize]
    }

    fn find_cheapest(&mut self, vertex: u32) -> Cheapest {
        let mut cheapest = Cheapest::None;
        let mut least = f64::INFINITY;
        let neighbors: Vec<u32> = self.mesh.neighbors(vertex).collect();
        for neighbor in neighbors {
            let at = self.x[neighbor as usize] - self.origin;
            let cost = self.quadrics[vertex as usize].mean(at);
            if cost < least && self.mesh.may_collapse(vertex, neighbor) {
                least = cost;
                cheapest = Cheapest::Into { neighbor, cost };
            }
        }
        cheapest
    }

    /// Moves a vertex into its neighbor. Those around are left alone for the rest of the pass.
    fn perform(&mut self, collapse: Collapse, has_changed: &mut [bool]) {
        let Collapse { vertex, into } = collapse;
        self.mesh.contract(vertex, into);
        let moved = self.quadrics[vertex as usize];
        self.quadrics[into as usize] += moved;

        self.cheapest[vertex as usize] = Cheapest::None;
        self.cheapest[into as usize] = Cheapest::Unknown;
        has_changed[into as usize] = true;
        for neighbor in self.mesh.neighbors(into) {
            self.cheapest[neighbor as usize] = Cheapest::Unknown;
            has_changed[neighbor as usize] = true;
        }
        self.collapses.push(collapse);
    }
}
