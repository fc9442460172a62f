//! A point or ball against the primitives whose bounds come near it.

use glam::DVec3;

use super::sieve::{self, SeparatingDirections};
use super::{MedialContactParams, PointContact};
use crate::{Ball, FootRule, MedialSurface};

/// Cosine of the angle within which two normals count as one: 30°. At 10° one
/// rounded side gives several contacts; at 60° the sides of a shallow groove
/// become one.
const DISTINCT_COSINE: f64 = 0.866_025_403_784_438_6;

/// A point, and the normal it was last seen under, or zero.
pub(super) struct PointQuery {
    pub(super) ball: Ball,
    pub(super) side: DVec3,
}

/// A primitive that a point may be the deepest in.
#[derive(Clone, Copy, Debug)]
pub(super) struct Candidate {
    /// The point and the primitive.
    pair: (u32, u32),
    /// How far the point is from the primitive, at least up to rounding, and at most.
    between: [f64; 2],
}

impl PointQuery {
    /// Its contacts with all of the primitives, kept in `out`.
    pub(super) fn all(
        &self,
        pairs: &[(u32, u32)],
        medial: &MedialSurface,
        params: &MedialContactParams,
        sieve: &mut SeparatingDirections,
        out: &mut Vec<PointContact>,
    ) {
        let first = out.len();
        for &pair in pairs {
            let balls = medial.primitive_balls(pair.1);
            // On the other side than it was last seen, it may be far and in contact.
            if self.side == DVec3::ZERO && self.is_beyond(&balls, params, sieve) {
                continue;
            }
            let touch = self.touch(pair, medial, params.rule, sieve);
            if touch.gap <= params.margin {
                keep(out, first, touch, params.max_contacts);
            }
        }
    }

    /// Its deepest contact. No contact is lost by rounding.
    pub(super) fn deepest(
        &self,
        pairs: &[(u32, u32)],
        medial: &MedialSurface,
        params: &MedialContactParams,
        sieve: &mut SeparatingDirections,
    ) -> Option<PointContact> {
        let mut rivals = std::mem::take(&mut sieve.rivals);
        self.find_rivals(pairs, medial, params, sieve, &mut rivals);
        // What it is likely to be the deepest in parts it from most others.
        rivals.sort_by(|a, b| a.between[1].total_cmp(&b.between[1]));
        let Ball { center: p, radius } = self.ball;
        let mut least: Option<PointContact> = None;
        for rival in &rivals {
            let balls = medial.primitive_balls(rival.pair.1);
            let known = least.map_or(f64::INFINITY, |least| least.gap + radius);
            let limit = self.limit(&balls, params, known);
            let parted = rival.between[0] > limit
                || least.is_some_and(|least| sieve.along(least.normal, p, &balls) > limit);
            if parted {
                continue;
            }
            let touch = self.touch(rival.pair, medial, params.rule, sieve);
            if least.is_none_or(|least| touch.gap < least.gap) {
                least = Some(touch);
            }
        }
        sieve.rivals = rivals;
        least.filter(|least| least.gap <= params.margin)
    }

    /// The primitives that it may be the deepest in, and not those that some direction
    /// shows to be out of reach or less deep than another one.
    fn find_rivals(
        &self,
        pairs: &[(u32, u32)],
        medial: &MedialSurface,
        params: &MedialContactParams,
        sieve: &mut SeparatingDirections,
        rivals: &mut Vec<Candidate>,
    ) {
        rivals.clear();
        let p = self.ball.center;
        let mut known = f64::INFINITY;
        // Away from what it is likely to be the deepest in, or else from what it is parted from.
        let mut facing: Option<DVec3> = None;
        for &pair in pairs {
            let balls = medial.primitive_balls(pair.1);
            let limit = self.limit(&balls, params, known);
            let parted = sieve.away(p, &balls) > limit
                || facing.is_some_and(|facing| sieve.along(facing, p, &balls) > limit);
            if parted {
                continue;
            }
            let (between, outward) = sieve.between(p, &balls, limit);
            if between[0] > limit {
                facing = facing.or(Some(outward));
                continue;
            }
            // By the bare face, it may be farther than it is.
            if params.rule == FootRule::Exact && between[1] < known {
                (known, facing) = (between[1], Some(outward));
            }
            rivals.push(Candidate { pair, between });
        }
    }

    /// Whether some direction shows a primitive to be out of reach.
    fn is_beyond(
        &self,
        balls: &[Ball; 3],
        params: &MedialContactParams,
        sieve: &mut SeparatingDirections,
    ) -> bool {
        let (p, limit) = (self.ball.center, self.limit(balls, params, f64::INFINITY));
        sieve.away(p, balls) > limit || sieve.between(p, balls, limit).0[0] > limit
    }

    /// Distance of its center beyond which a primitive does not matter: out of reach, or
    /// less deep than one that is within `known`.
    fn limit(&self, balls: &[Ball; 3], params: &MedialContactParams, known: f64) -> f64 {
        let rounding = sieve::rounding(self.ball.center, balls);
        let within = params.margin + self.ball.radius;
        // One that is in contact whatever the rounding; of several that are the deepest
        // up to rounding, it is enough.
        if known <= within - 4.0 * rounding { known - 2.0 * rounding } else { within + rounding }
    }

    fn touch(
        &self,
        pair: (u32, u32),
        medial: &MedialSurface,
        rule: FootRule,
        sieve: &mut SeparatingDirections,
    ) -> PointContact {
        sieve.leaf_tests += 1;
        PointContact::of(pair, self.ball, medial, rule, self.side)
    }
}

/// Keeps `touch` beside those of the same point, from `first` on, that have
/// distinct normals, or in the place of one that it is deeper than; the least gap
/// first.
fn keep(out: &mut Vec<PointContact>, first: usize, touch: PointContact, most: usize) {
    let alike = |other: &PointContact| other.normal.dot(touch.normal) > DISTINCT_COSINE;
    if out[first..].iter().any(|other| alike(other) && other.gap <= touch.gap) {
        return;
    }
    let mut end = first;
    for k in first..out.len() {
        if !alike(&out[k]) {
            out[end] = out[k];
            end += 1;
        }
    }
    out.truncate(end);
    let place = first + out[first..].partition_point(|other| other.gap <= touch.gap);
    out.insert(place, touch);
    out.truncate(first + most);
}
