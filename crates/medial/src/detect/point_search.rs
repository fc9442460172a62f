//! Contacts of one point or ball with the primitives whose bounds come near it.

use glam::DVec3;

use super::contact::{CandidatePair, PointContact, PointQuery};
use super::separation::{SeparatingDirections, rounding};
use super::{MedialContactParams, TestCounts};
use crate::{Ball, FootRule, MedialSurface};

/// Cosine of the angle below which two normals count as one: 30°.
///
/// At 10° one rounded side gives several contacts; at 60° the sides of a shallow groove become one.
const DISTINCT_COSINE: f64 = 0.866_025_403_784_438_6;

/// Search for the contacts of points, one after the other; its memory is reused.
pub(super) struct PointSearch<'a> {
    medial: &'a MedialSurface,
    params: &'a MedialContactParams,
    directions: SeparatingDirections,
    candidates: &'a mut Vec<Candidate>,
}

/// Memory of a search for the contacts of points.
#[derive(Clone, Debug, Default)]
pub struct PointCandidates(Vec<Candidate>);

/// Primitive that a point may be deepest in, with bounds on the distance.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    primitive: u32,
    lower: f64,
    upper: f64,
}

impl<'a> PointSearch<'a> {
    pub(super) fn new(
        medial: &'a MedialSurface,
        params: &'a MedialContactParams,
        PointCandidates(candidates): &'a mut PointCandidates,
    ) -> Self {
        Self { medial, params, directions: SeparatingDirections::default(), candidates }
    }

    /// Returns the numbers of tests so far.
    pub(super) fn counts(&self) -> TestCounts {
        self.directions.counts
    }

    /// Appends the contacts of a point, the smallest gap first.
    pub(super) fn find(
        &mut self,
        query: &PointQuery,
        pairs: &[CandidatePair],
        out: &mut Vec<PointContact>,
    ) {
        if self.params.max_contacts == 1 {
            out.extend(self.deepest(query, pairs));
        } else {
            self.find_distinct(query, pairs, out);
        }
    }

    /// Appends the contacts of a point that have distinct normals.
    fn find_distinct(
        &mut self,
        query: &PointQuery,
        pairs: &[CandidatePair],
        out: &mut Vec<PointContact>,
    ) {
        let first = out.len();
        for pair in pairs {
            let balls = self.medial.primitive_balls(pair.primitive);
            if self.is_beyond_margin(query, &balls) {
                continue;
            }

            let contact = self.compare(query, pair.primitive);
            if contact.gap <= self.params.margin {
                keep_distinct(out, first, contact, self.params.max_contacts);
            }
        }
    }

    /// Finds the deepest contact of a point. Rounding loses no contact.
    fn deepest(&mut self, query: &PointQuery, pairs: &[CandidatePair]) -> Option<PointContact> {
        self.find_candidates(query, pairs);
        // The primitive that is probably the deepest culls most of the others.
        self.candidates.sort_unstable_by(|a, b| {
            a.upper.total_cmp(&b.upper).then(a.primitive.cmp(&b.primitive))
        });

        let mut deepest: Option<PointContact> = None;
        for k in 0..self.candidates.len() {
            let candidate = self.candidates[k];
            let balls = self.medial.primitive_balls(candidate.primitive);
            if !self.is_culled(query, &candidate, &balls, deepest.as_ref()) {
                let contact = self.compare(query, candidate.primitive);
                if deepest.is_none_or(|deepest| contact.gap < deepest.gap) {
                    deepest = Some(contact);
                }
            }
        }
        deepest.filter(|deepest| deepest.gap <= self.params.margin)
    }

    /// Returns true if a candidate is beyond the margin, or less deep than the deepest so far.
    fn is_culled(
        &mut self,
        query: &PointQuery,
        candidate: &Candidate,
        balls: &[Ball; 3],
        deepest: Option<&PointContact>,
    ) -> bool {
        let Ball { center, radius } = query.ball;
        let known = deepest.map_or(f64::INFINITY, |deepest| deepest.gap + radius);
        let limit = self.limit(query, balls, known);
        candidate.lower > limit
            || deepest.is_some_and(|deepest| {
                self.directions.bound_along(deepest.normal, center, balls) > limit
            })
    }

    /// Collects the primitives that a point may be deepest in, without those that some direction
    /// shows to be beyond the margin or less deep than another one.
    fn find_candidates(&mut self, query: &PointQuery, pairs: &[CandidatePair]) {
        self.candidates.clear();
        let p = query.ball.center;
        let mut known = f64::INFINITY;

        // Away from the primitive that is probably the deepest, or else from a separated one.
        let mut facing: Option<DVec3> = None;
        for &CandidatePair { primitive, .. } in pairs {
            // Two cheap directions first.
            let balls = self.medial.primitive_balls(primitive);
            let limit = self.limit(query, &balls, known);
            let is_separated = self.directions.bound_from_middle(p, &balls) > limit
                || facing.is_some_and(|u| self.directions.bound_along(u, p, &balls) > limit);
            if is_separated {
                continue;
            }
            let bounds = self.directions.bounds(p, &balls, limit);
            if bounds.lower > limit {
                facing = facing.or(Some(bounds.direction));
                continue;
            }

            // By the bare face, it may be farther away than the upper bound.
            if self.params.rule == FootRule::Exact && bounds.upper < known {
                (known, facing) = (bounds.upper, Some(bounds.direction));
            }
            let (lower, upper) = (bounds.lower, bounds.upper);
            self.candidates.push(Candidate { primitive, lower, upper });
        }
    }

    /// Returns true if some direction shows a primitive to be beyond the margin.
    fn is_beyond_margin(&mut self, query: &PointQuery, balls: &[Ball; 3]) -> bool {
        let (p, limit) = (query.ball.center, self.limit(query, balls, f64::INFINITY));
        self.directions.bound_from_middle(p, balls) > limit
            || self.directions.bounds(p, balls, limit).lower > limit
    }

    /// Computes the distance of the point's center beyond which a primitive does not matter: it
    /// is beyond the margin, or less deep than one that is within `known`.
    fn limit(&self, query: &PointQuery, balls: &[Ball; 3], known: f64) -> f64 {
        let rounding = rounding(query.ball.center, balls);
        let within = self.params.margin + query.ball.radius;
        // A primitive within `known` is in contact whatever the rounding. Of several that are
        // deepest up to rounding, one is sufficient.
        if known <= within - 4.0 * rounding { known - 2.0 * rounding } else { within + rounding }
    }

    fn compare(&mut self, query: &PointQuery, primitive: u32) -> PointContact {
        self.directions.counts.leaf_tests += 1;
        PointContact::new(query, primitive, self.medial, self.params.rule)
    }
}

/// Inserts a contact among those of the same point, from `first` on, in the order of their gaps.
///
/// It replaces contacts with a similar normal that are less deep, and is left out where one is
/// deeper.
fn keep_distinct(
    out: &mut Vec<PointContact>,
    first: usize,
    contact: PointContact,
    max_contacts: usize,
) {
    let is_similar = |other: &PointContact| other.normal.dot(contact.normal) > DISTINCT_COSINE;
    if out[first..].iter().any(|other| is_similar(other) && other.gap <= contact.gap) {
        return;
    }

    // Similar contacts go; the others keep their order.
    let mut end = first;
    for k in first..out.len() {
        if !is_similar(&out[k]) {
            out[end] = out[k];
            end += 1;
        }
    }
    out.truncate(end);

    let place = first + out[first..].partition_point(|other| other.gap <= contact.gap);
    out.insert(place, contact);
    out.truncate(first + max_contacts);
}
