//! Contacts of many points or balls with a medial surface.

use glam::DVec3;
use kdop::{Tree, Workspace};
use surface::Contact;

use super::contact::{CandidatePair, ParticleOffsets, PointContact, PointQuery};
use super::point_search::{PointCandidates, PointSearch};
use super::{MedialBounds, MedialContactParams, TestCounts};
use crate::{Ball, MedialSurface};

/// Points or balls of one object, which are compared with a medial surface.
#[derive(Clone, Copy, Debug)]
pub struct QueryPoints<'a> {
    /// Tree over them, one leaf per point, in their order.
    pub tree: &'a Tree,
    /// Their positions.
    pub points: &'a [DVec3],
    /// Their radii; `None` for the points of a surface, which have no extent.
    pub radii: Option<&'a [f64]>,
}

impl QueryPoints<'_> {
    fn ball(&self, point: u32) -> Ball {
        let radius = self.radii.map_or(0.0, |radii| radii[point as usize]);
        Ball::new(self.points[point as usize], radius)
    }
}

/// Finds the contacts of points or balls with the union of balls of a medial surface.
///
/// The particles of a contact are the point (its number in `points`, plus `first_point`) and the
/// balls of the primitive (their numbers plus `first_ball`). Its offset is the sum of the radii.
/// Contacts are in the order of the points, the smallest gap first.
///
/// # Panics
///
/// When the trees or radii are of other points or primitives.
pub fn point_contacts(
    points: &QueryPoints<'_>,
    on: MedialBounds<'_>,
    params: &MedialContactParams,
    particles: ParticleOffsets,
    workspace: &mut Workspace,
) -> (Vec<Contact>, TestCounts) {
    let mut pairs = Vec::new();
    on.tree.tree().pairs(points.tree, params.margin, workspace, |primitive, point| {
        pairs.push(CandidatePair { point, primitive });
    });
    let bound_tests = workspace.counters().bound_tests;

    let mut found = Vec::new();
    let ball = |point| points.ball(point);
    let candidates = &mut PointCandidates::default();
    let counts = point_contacts_among(&mut pairs, ball, on.medial, params, candidates, &mut found);
    let mut contacts = Vec::with_capacity(found.len());
    for found in &found {
        contacts.push(found.contact(on.medial, particles));
    }
    (contacts, TestCounts { bound_tests, ..counts })
}

/// Finds contacts as [`point_contacts`] does, among pairs that the caller has found, in reused
/// memory.
///
/// `pairs` is sorted, and `out` is cleared first. `ball` returns the position of a point, and its
/// radius or 0. Tests of bounds are not counted.
///
/// # Panics
///
/// When there is no such primitive.
pub fn point_contacts_among(
    pairs: &mut Vec<CandidatePair>,
    ball: impl Fn(u32) -> Ball,
    medial: &MedialSurface,
    params: &MedialContactParams,
    candidates: &mut PointCandidates,
    out: &mut Vec<PointContact>,
) -> TestCounts {
    pairs.sort_unstable();
    pairs.dedup();
    out.clear();

    let mut search = PointSearch::new(medial, params, candidates);
    for of_point in pairs.chunk_by(|a, b| a.point == b.point) {
        let point = of_point[0].point;
        search.find(&PointQuery { point, ball: ball(point) }, of_point, out);
    }
    search.counts()
}
