//! Distance of points of a surface outside a union of balls: the maximum of φ(p) over surface points
//! p, with φ the signed distance of the union.
//!
//! The distance `φ_s` of one primitive is convex, so on a triangle it is at most the maximum of its
//! values at the corners; φ is at most `φ_s` for any s. Where the corners have the same nearest
//! primitive, the bound is exact.

use glam::DVec3;
use kdop::Workspace;
use proximity::MaximumSearch;
use surface::progress::{Interrupted, Progress};
use surface::{DirectedHausdorff, Positions, TriangleSurface};

use super::{MAX_PIECES, MIN_SLACK, search, split_all};
use crate::surface_distance::SurfaceDistance;
use crate::{ExactFeet, MedialSurface, NearestPrimitive, PreparedSlabs, PrimitiveTree};

/// Number of pieces per face at which [`BoundSearch::surface_bound`] ends: fewer leave bounds too large, more
/// cost more than following does.
const PIECES_PER_FACE: usize = 2;

/// Corner of a piece of a face.
#[derive(Clone, Copy, Debug)]
struct Corner {
    p: DVec3,
    /// Nearest primitive.
    primitive: u32,
    /// Signed distance of that primitive.
    distance: f64,
}

/// Search for the largest distance of a surface outside balls, in memory that is reused.
#[derive(Debug, Default)]
pub(crate) struct BoundSearch {
    search: MaximumSearch<Patch>,
    workspace: Workspace,
}

/// Piece of a face.
type Patch = [Corner; 3];

pub(super) fn surface_to_medial(
    medial: &MedialSurface,
    tree: &PrimitiveTree,
    surface: &SurfaceDistance<'_>,
    nearest: &[NearestPrimitive],
    progress: Progress<'_>,
) -> Result<DirectedHausdorff, Interrupted> {
    // Whole faces first.
    let (mut search, slabs) = (search(medial), &PreparedSlabs::new(medial));
    for face in surface.surface.faces() {
        let patch = face.map(|vertex| {
            let NearestPrimitive { primitive, foot } = nearest[vertex as usize];
            Corner { p: surface.x.at(vertex), primitive, distance: foot.distance }
        });
        add(&mut search, slabs, patch);
    }

    // Then quarters, by the middles of the sides.
    let mut workspace = Workspace::default();
    split_all(&mut search, MAX_PIECES, progress, |search, patch| {
        split(search, slabs, tree, patch, &mut workspace);
    })
}

impl BoundSearch {
    /// Bounds the distance of points of a surface outside a union of balls, near enough to decide
    /// whether it exceeds `limit`.
    ///
    /// `guesses` has a primitive for each vertex, near it. A bound of at most `limit` is proved; one
    /// above may be larger than need be, since the work is linear in the faces.
    pub(crate) fn surface_bound(
        &mut self,
        medial: &MedialSurface,
        tree: &PrimitiveTree,
        surface: &TriangleSurface,
        x: Positions<'_>,
        guesses: impl Fn(u32) -> u32,
        limit: f64,
    ) -> f64 {
        // By the guessed primitives, which suffice almost everywhere, else by the nearest ones.
        let Self { search, workspace } = self;
        search.restart_within(MIN_SLACK * medial.bounds().diagonal(), limit);
        for face in surface.faces() {
            let mut patch = face.map(|vertex| {
                let (p, primitive) = (x.at(vertex), guesses(vertex));
                let distance = medial.exact_foot(p, primitive).distance;
                Corner { p, primitive, distance }
            });
            if upper_bound(medial, &patch) <= limit {
                continue;
            }
            for corner in &mut patch {
                *corner = corner_at(medial, tree, corner.p, corner.primitive, workspace);
            }
            add(search, medial, patch);
        }

        // What was left out is within the limit.
        let max_pieces = PIECES_PER_FACE * surface.faces().len();
        let split_one = |search: &mut MaximumSearch<Patch>, patch| {
            split(search, medial, tree, patch, workspace);
        };
        let split_all = split_all(search, max_pieces, Progress::none(), split_one);
        split_all.map_or(f64::INFINITY, |bounds| bounds.upper.max(limit))
    }
}

/// Adds the quarters of a piece, by the middles of its sides.
fn split(
    search: &mut MaximumSearch<Patch>,
    medial: &impl ExactFeet,
    tree: &PrimitiveTree,
    [a, b, c]: Patch,
    workspace: &mut Workspace,
) {
    let mut middle = |from: &Corner, to: &Corner| {
        corner_at(medial, tree, from.p.midpoint(to.p), from.primitive, workspace)
    };
    let (ab, bc, ca) = (middle(&a, &b), middle(&b, &c), middle(&c, &a));
    for quarter in [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]] {
        add(search, medial, quarter);
    }
}

/// Computes the corner at a point, by its nearest primitive.
fn corner_at(
    medial: &impl ExactFeet,
    tree: &PrimitiveTree,
    p: DVec3,
    guess: u32,
    workspace: &mut Workspace,
) -> Corner {
    let nearest = tree.nearest_from(medial, p, guess, workspace);
    Corner { p, primitive: nearest.primitive, distance: nearest.foot.distance }
}

fn add(search: &mut MaximumSearch<Patch>, medial: &impl ExactFeet, patch: Patch) {
    for corner in &patch {
        search.evaluated(corner.distance);
    }
    search.add(upper_bound(medial, &patch), patch);
}

/// Computes the minimum over the corners' primitives of the maximum distance at a corner.
fn upper_bound(medial: &impl ExactFeet, patch: &Patch) -> f64 {
    let mut bound = f64::INFINITY;
    for &Corner { primitive, .. } in patch {
        let mut max = f64::NEG_INFINITY;
        for corner in patch {
            let distance = if corner.primitive == primitive {
                corner.distance
            } else {
                medial.exact_foot(corner.p, primitive).distance
            };
            max = max.max(distance);
        }
        bound = bound.min(max);
    }
    bound
}
