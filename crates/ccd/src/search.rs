//! The search for the first contact: filters, candidate times, verdicts.
//!
//! Nothing is passed over unless a certificate holds for every time in it:
//! - an axis, or the area vector of either end, for the whole step;
//! - the cubic, outside the intervals in which it may be zero;
//! - a direction, on such an interval or on the pieces of it.

use glam::DVec3;

use crate::closest::{Closest, closest, edge_functions};
use crate::contact::{Certainty, Contact, Params};
use crate::coplanarity::Coplanarity;
use crate::cubic::{Cubic, RootInterval, RootKind};
use crate::error::CcdError;
use crate::polygon::{Corners, MovingPolygon};
use crate::rounding::{EDGE_FUNCTION, UNDERFLOW, UNIT};

/// An interval longer than this is searched piece by piece: within a shorter
/// one a time cannot be improved by much, and its start is the answer.
const SHORT: f64 = 1e-9;

/// A moving polygon, its cubic, and what is asked of them.
pub(crate) struct Search<'a, const N: usize> {
    pub(crate) polygon: &'a MovingPolygon<N>,
    pub(crate) cubic: Cubic,
    pub(crate) params: &'a Params,
    /// The points that the polygon was made of, at both ends of the step.
    #[cfg_attr(
        not(feature = "exact"),
        expect(dead_code, reason = "only exact arithmetic returns to them")
    )]
    pub(crate) points: [&'a [DVec3; 4]; 2],
    /// Minimum separation in the polygon's scaled unit.
    pub(crate) separation: f64,
}

/// What becomes of an interval in which the cubic may be zero.
pub(crate) enum Verdict {
    /// A certificate excludes contact from all of it.
    Clear,
    /// Contact, or none that can be excluded from this time on.
    Contact(Contact),
}

/// Finds the first contact of a query: of its polygon with the origin.
#[inline]
pub(crate) fn first_contact<const N: usize>(
    x0: &[DVec3; 4],
    x1: &[DVec3; 4],
    params: &Params,
) -> Result<Option<Contact>, CcdError>
where
    MovingPolygon<N>: Corners<N>,
{
    let polygon = MovingPolygon::new(x0, x1)?;
    let separation = params.min_separation * polygon.scale;
    if polygon.axis_separates(separation) {
        return Ok(None);
    }
    Ok(first_contact_of(&polygon, params, separation, [x0, x1]))
}

/// [`first_contact`] once the polygon is known to come near the origin.
#[inline]
fn first_contact_of<const N: usize>(
    polygon: &MovingPolygon<N>,
    params: &Params,
    separation: f64,
    points: [&[DVec3; 4]; 2],
) -> Option<Contact>
where
    MovingPolygon<N>: Corners<N>,
{
    let coplanarity = Coplanarity::new(polygon);
    if coplanarity.areas_separate(polygon, params.t_max, separation) {
        return None;
    }
    let cubic = coplanarity.cubic(polygon);
    let margin = if separation > 0.0 { coplanarity.margin(polygon, separation) } else { 0.0 };
    if cubic.excludes_zero(margin) {
        return None;
    }
    let search = Search { polygon, cubic, params, points, separation };
    search.cubic.isolate_until(params.t_max, margin).iter().find_map(|interval| {
        match search.examine(interval) {
            Verdict::Clear => None,
            Verdict::Contact(contact) => Some(contact),
        }
    })
}

impl<const N: usize> Search<'_, N>
where
    MovingPolygon<N>: Corners<N>,
{
    /// Excludes an interval, or finds the first contact in it.
    #[inline]
    pub(crate) fn examine(&self, interval: &RootInterval) -> Verdict {
        let middle = 0.5 * (interval.lo + interval.hi);
        let half = 0.5 * (interval.hi - interval.lo);
        let corners = self.polygon.corners(middle);
        let area = self.polygon.area_vector(middle);
        let inside = edge_functions(&corners, area);
        if self.separation == 0.0 && self.certainly_inside(&inside, area, half) {
            if interval.kind == RootKind::Rising {
                return Verdict::Contact(self.crossing(interval, &inside, area));
            }
            if interval.kind == RootKind::Falling {
                return Verdict::Contact(self.crossing(interval, &inside, -area));
            }
        } else if self.outside_an_edge(interval, &corners, &inside, area) {
            return Verdict::Clear;
        }
        self.search(interval)
    }

    /// Whether at every time within `half` of the one at which they were taken
    /// all edge functions are positive, so that a plane through the origin
    /// holds it inside the polygon.
    #[inline]
    pub(crate) fn certainly_inside(&self, inside: &[f64; N], area: DVec3, half: f64) -> bool {
        let q = self.polygon.reach();
        let crossed = DVec3::new(q.y * q.z, q.z * q.x, q.x * q.y);
        let permanent = 2.0 * area.abs().dot(crossed);
        let bound = (EDGE_FUNCTION + 5.0 * half) * permanent + UNDERFLOW;
        inside.iter().all(|&w| w > bound)
    }

    /// Direction certificate across an edge that has the origin on its outer side.
    #[inline]
    pub(crate) fn outside_an_edge(
        &self,
        interval: &RootInterval,
        corners: &[DVec3; N],
        inside: &[f64; N],
        area: DVec3,
    ) -> bool {
        (0..N).filter(|&i| inside[i] < 0.0).any(|i| {
            let inward = area.cross(corners[(i + 1) % N] - corners[i]);
            self.polygon.direction_separates(inward, interval.lo, interval.hi, self.separation)
        })
    }

    /// The contact at a certain crossing.
    #[inline]
    fn crossing(&self, interval: &RootInterval, inside: &[f64; N], normal: DVec3) -> Contact {
        Contact {
            lo: interval.lo,
            hi: interval.hi,
            certainty: Certainty::Certain,
            at_start: false,
            weights: MovingPolygon::<N>::stencil(MovingPolygon::<N>::corner_weights(*inside)),
            normal: normal / normal.length(),
        }
    }

    /// Searches an interval piece by piece, by directions.
    #[inline(never)]
    fn search(&self, interval: &RootInterval) -> Verdict {
        match self.clear_from(interval.lo, interval.hi) {
            None => Verdict::Clear,
            Some(lo) => self.undecided(RootInterval { lo, ..*interval }),
        }
    }

    /// What becomes of an interval at whose start no direction holds.
    #[cfg(not(feature = "exact"))]
    fn undecided(&self, interval: RootInterval) -> Verdict {
        Verdict::Contact(self.possible(interval))
    }

    /// What becomes of an interval at whose start no direction holds.
    #[cfg(feature = "exact")]
    fn undecided(&self, interval: RootInterval) -> Verdict {
        use crate::contact::Undecided;
        use crate::exact::{Decision, decide};

        let possible = self.possible(interval);
        if self.params.undecided == Undecided::Report || self.separation > 0.0 {
            return Verdict::Contact(possible);
        }
        let [x0, x1] = self.points;
        match decide::<N>(x0, x1, interval.lo, interval.hi) {
            Decision::Free => Verdict::Clear,
            Decision::Contact { lo, .. } if lo > self.params.t_max => Verdict::Clear,
            Decision::Contact { lo, hi, at_start } => {
                let certainty = Certainty::Certain;
                Verdict::Contact(Contact { lo, hi, at_start, certainty, ..possible })
            }
            Decision::Open => Verdict::Contact(possible),
        }
    }

    /// The contact to report where rounding leaves it open.
    fn possible(&self, interval: RootInterval) -> Contact {
        let nearest = self.closest(interval.lo);
        let distance = nearest.point.length();
        let close = self.separation * (1.0 - 8.0 * UNIT) - self.rounding();
        Contact {
            lo: interval.lo,
            hi: interval.hi,
            certainty: if distance < close { Certainty::Certain } else { Certainty::Possible },
            at_start: interval.lo == 0.0,
            weights: MovingPolygon::<N>::stencil(nearest.weights),
            normal: self.normal(&interval, nearest.point),
        }
    }

    /// Unit direction away from the closest point, or of the plane, whichever
    /// is known; an axis where neither is.
    fn normal(&self, interval: &RootInterval, closest: DVec3) -> DVec3 {
        let area = self.polygon.area_vector(interval.lo);
        let plane = if self.cubic.value(interval.lo) > 0.0 { -area } else { area };
        let known = closest.length() > 16.0 * self.rounding();
        let candidates = if known { [-closest, plane] } else { [plane, -closest] };
        candidates.into_iter().find_map(DVec3::try_normalize).unwrap_or(DVec3::Z)
    }

    /// Bound on the rounding of a point of the polygon.
    fn rounding(&self) -> f64 {
        16.0 * UNIT * self.polygon.reach().element_sum()
    }

    pub(crate) fn closest(&self, t: f64) -> Closest<N> {
        closest(&self.polygon.corners(t), MovingPolygon::<N>::corner_weights)
    }

    /// The first time from `lo` on at which contact cannot be excluded; `None`
    /// if it can up to `hi`.
    fn clear_from(&self, lo: f64, hi: f64) -> Option<f64> {
        if hi - lo < SHORT {
            let direction = self.closest(0.5 * (lo + hi)).point;
            if self.polygon.direction_separates(direction, lo, hi, self.separation) {
                return None;
            }
            if lo > 0.0 {
                return Some(lo);
            }
        }
        self.advance(lo, hi)
    }
}
