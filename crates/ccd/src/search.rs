//! Search for the first contact: filters, candidate times, decisions.
//!
//! No time is skipped unless a certificate holds for it:
//! - an axis, or the area vector of either end, for the whole step;
//! - the cubic, outside the intervals in which it may be zero;
//! - a direction, on such an interval or on the pieces of it.

use glam::DVec3;

use crate::closest::ClosestToOrigin;
use crate::contact::{CcdContact, CcdParams, Certainty, Undecided};
use crate::coplanarity::Coplanarity;
use crate::cubic::{BernsteinCubic, RootInterval, RootKind};
use crate::error::CcdError;
use crate::outline::Outline;
use crate::polygon::MovingPolygon;
use crate::rounding::{EDGE_FUNCTION, EDGE_FUNCTION_RATE, UNDERFLOW, UNIT};
use crate::shape::{Corners, PolygonShape};

/// Distance beyond the separation, relative to it, at which a contact is reported where it is not
/// certain that the separation is reached.
///
/// A contact may be reported that is this much too far away.
pub(crate) const OPEN_SLACK: f64 = 1e-10;

/// The same where a contact is certain.
///
/// The time of contact may be early by what it takes to cover this much of the separation. The last
/// digits would cost as much as all before.
pub(crate) const CERTAIN_SLACK: f64 = 1e-6;

/// Length above which an interval is searched piece by piece. Within a shorter one a time cannot be
/// improved by much, and its start is the answer.
const SHORT: f64 = 1e-9;

/// Search of one query that no filter excludes contact from.
pub(crate) struct ContactSearch<'a, const N: usize> {
    outline: &'a Outline,
    cubic: BernsteinCubic,
    /// Minimum distance of the cubic from zero where the separation is kept.
    margin: f64,
    pub(crate) params: &'a CcdParams,
    /// The points of the query, at both ends of the step.
    points: [&'a [DVec3; 4]; 2],
    /// Minimum separation in the scaled unit of the outline.
    pub(crate) separation: f64,
    /// Distance beyond the separation, relative to it, at which a certain contact is reported.
    pub(crate) certain_slack: f64,
}

/// Position of the origin relative to the edges of the polygon at one time.
pub(crate) struct OriginPosition<const N: usize> {
    /// The edges of corner 0.
    edges: [DVec3; 2],
    pub(crate) area: DVec3,
    /// Volume that each edge spans with the origin and the area vector: positive on the inner side.
    pub(crate) edge_functions: [f64; N],
    /// True if all edge functions are certainly positive during the interval, so that the polygon
    /// contains the origin whenever its plane does.
    is_inside: bool,
}

/// Finds the first contact of a query: of its polygon with the origin.
#[inline]
pub(crate) fn first_contact<const N: usize>(
    x0: &[DVec3; 4],
    x1: &[DVec3; 4],
    params: &CcdParams,
) -> Result<Option<CcdContact>, CcdError>
where
    PolygonShape<N>: Corners<N>,
{
    first_contact_within::<N>(x0, x1, params, CERTAIN_SLACK)
}

/// As [`first_contact`], with a slack of the separation where a contact is certain.
pub(crate) fn first_contact_within<const N: usize>(
    x0: &[DVec3; 4],
    x1: &[DVec3; 4],
    params: &CcdParams,
    certain_slack: f64,
) -> Result<Option<CcdContact>, CcdError>
where
    PolygonShape<N>: Corners<N>,
{
    let outline = Outline::new::<N>(x0, x1)?;
    let Some(mut search) = ContactSearch::<N>::new(&outline, [x0, x1], params) else {
        return Ok(None);
    };
    search.certain_slack = certain_slack;
    let first =
        search.cubic.find_in_root_intervals(search.margin, |interval| search.examine(interval));
    // Times do not depend on the last one of interest, which only leaves contacts out.
    Ok(first.filter(|contact| contact.lo <= params.t_max))
}

impl<'a, const N: usize> ContactSearch<'a, N>
where
    PolygonShape<N>: Corners<N>,
{
    /// Prepares the search of a query; `None` if a filter excludes contact.
    #[inline]
    pub(crate) fn new(
        outline: &'a Outline,
        points: [&'a [DVec3; 4]; 2],
        params: &'a CcdParams,
    ) -> Option<Self> {
        // From the cheapest certificate to the most expensive.
        let separation = outline.scaling.length(params.min_separation);
        if outline.axis_separates(separation) {
            return None;
        }

        let coplanarity = Coplanarity::new(outline);
        if coplanarity.areas_separate::<N>(params.t_max, separation) {
            return None;
        }

        let cubic = coplanarity.cubic();
        let margin = if separation > 0.0 { coplanarity.margin(separation) } else { 0.0 };
        if cubic.excludes_zero(margin) {
            return None;
        }
        let certain_slack = CERTAIN_SLACK;
        Some(Self { outline, cubic, margin, params, points, separation, certain_slack })
    }

    /// Finds the first contact in an interval; `None` if contact is excluded there.
    #[inline]
    fn examine(&self, interval: &RootInterval) -> Option<CcdContact> {
        // A sign change with the origin inside all edges is a certain contact.
        let position = self.origin_position(interval);
        if self.separation == 0.0 && position.is_inside {
            match interval.kind {
                RootKind::Rising => return Some(self.crossing(interval, &position, 1.0)),
                RootKind::Falling => return Some(self.crossing(interval, &position, -1.0)),
                RootKind::Grazing | RootKind::Vanishing => {}
            }
        } else if self.outside_an_edge(&self.polygon(), interval, &position) {
            return None;
        }
        self.search(interval)
    }

    /// Computes all corners of the polygon, which a certain crossing does not need.
    #[inline]
    fn polygon(&self) -> MovingPolygon<'_, N> {
        MovingPolygon::new(self.outline, self.points)
    }

    /// Computes the position of the origin relative to the edges in the middle of an interval.
    #[inline]
    pub(crate) fn origin_position(&self, interval: &RootInterval) -> OriginPosition<N> {
        let t = interval.middle();
        let [first, last] = self.outline.edges(t);
        let area = first.cross(last);

        // Two edge functions are computed; the area gives the others.
        let turned = area.cross(self.outline.corner_at(t));
        let edge_functions =
            PolygonShape::<N>::edge_functions(turned.dot(first), -turned.dot(last), area.dot(area));

        let bound = self.edge_function_bound(area, interval.hi - interval.lo);
        let is_inside = edge_functions.iter().all(|&w| w > bound);
        OriginPosition { edges: [first, last], area, edge_functions, is_inside }
    }

    /// Bounds the error of edge functions, and their change in an interval around the time at which
    /// they were computed.
    #[inline]
    pub(crate) fn edge_function_bound(&self, area: DVec3, length: f64) -> f64 {
        let q = self.outline.max_abs();
        let crossed = DVec3::new(q.y * q.z, q.z * q.x, q.x * q.y);
        (EDGE_FUNCTION + EDGE_FUNCTION_RATE * length) * area.abs().dot(crossed) + UNDERFLOW
    }

    /// Evaluates the direction certificate across each edge that has the origin on its outer side.
    #[inline]
    fn outside_an_edge(
        &self,
        polygon: &MovingPolygon<'_, N>,
        interval: &RootInterval,
        position: &OriginPosition<N>,
    ) -> bool {
        let [first, last] = position.edges;
        let edges = PolygonShape::<N>::edges(first, last);
        let (lo, hi) = (interval.lo, interval.hi);
        for (edge, edge_function) in edges.into_iter().zip(position.edge_functions) {
            let inward = position.area.cross(edge);
            if edge_function < 0.0 && polygon.direction_separates(inward, lo, hi, self.separation) {
                return true;
            }
        }
        false
    }

    /// Returns the contact at a certain crossing, in which the origin passes to the given side of
    /// the plane.
    #[inline]
    fn crossing(
        &self,
        interval: &RootInterval,
        position: &OriginPosition<N>,
        side: f64,
    ) -> CcdContact {
        let (lo, hi) = (interval.lo, interval.hi);
        let is_long = hi - lo > SHORT;
        let later = if is_long { self.advance(&self.polygon(), lo, hi, true) } else { None };
        let weights = PolygonShape::<N>::corner_weights(position.edge_functions);
        CcdContact {
            lo: later.map_or(lo, |(later, _)| later),
            hi,
            certainty: Certainty::Certain,
            at_start: false,
            weights: PolygonShape::<N>::stencil(weights),
            normal: position.area * (side / position.area.length()),
        }
    }

    /// Searches an interval piece by piece, by directions.
    #[inline(never)]
    fn search(&self, interval: &RootInterval) -> Option<CcdContact> {
        let polygon = self.polygon();
        let (lo, hi) = (interval.lo, interval.hi);
        let within = self.time_within_separation(&polygon, interval);

        // One direction decides a short interval, if it is not at the start of the step.
        if hi - lo < SHORT && self.separation == 0.0 {
            let middle = interval.middle();
            let separates = |m| polygon.direction_separates(m, lo, hi, self.separation);
            let closest = polygon.closest(middle);
            if separates(closest.point) || separates(polygon.weighted(closest, middle).hint) {
                return None;
            }
            if lo > 0.0 {
                let nearest = polygon.weighted_closest(lo).closest;
                return self.undecided(*interval, &nearest);
            }
        }

        // Else advance to the first time at which no direction separates.
        let (lo, nearest) = self.advance(&polygon, lo, hi, within.is_some())?;
        match within {
            Some(hi) => Some(self.contact([lo, hi], &nearest, Certainty::Certain)),
            None => self.undecided(RootInterval { lo, ..*interval }, &nearest),
        }
    }

    /// Applies the policy for undecided contacts to an interval at whose start no direction holds.
    fn undecided(
        &self,
        interval: RootInterval,
        nearest: &ClosestToOrigin<N>,
    ) -> Option<CcdContact> {
        #[cfg(feature = "exact")]
        if self.is_decided_exactly() {
            return self.decided(interval);
        }
        Some(self.contact([interval.lo, interval.hi], nearest, Certainty::Possible))
    }

    /// Returns the contact that exact arithmetic finds in an interval, with the weights at its time.
    #[cfg(feature = "exact")]
    fn decided(&self, interval: RootInterval) -> Option<CcdContact> {
        let ([x0, x1], polygon) = (self.points, self.polygon());
        let time = crate::exact::decide::<N>(x0, x1, [interval.lo, interval.hi])?;
        let (lo, hi) = time.rounded();
        let nearest = polygon.weighted_closest(lo).closest;
        let contact = self.contact([lo, hi], &nearest, Certainty::Certain);
        let normal = self.normal_before(&polygon, lo, interval.lo);
        Some(CcdContact { at_start: time.is_start(), normal, ..contact })
    }

    /// Returns the normal at the last of some times from `earliest` to the one of a contact at which
    /// the polygon is well apart from the origin; at `earliest` if there is none.
    ///
    /// At the contact itself the closest point is the origin, which has no direction.
    #[cfg(feature = "exact")]
    fn normal_before(&self, polygon: &MovingPolygon<'_, N>, contact: f64, earliest: f64) -> DVec3 {
        /// Distance in units of rounding from which on a direction is known to 2e-4.
        const WELL_APART: f64 = 4096.0;

        /// Number of times: each is four times as long before the contact as the one after it.
        const TIMES: i32 = 16;

        let far = WELL_APART * self.outline.rounding();
        for power in (1..TIMES).rev() {
            let t = contact - (contact - earliest) * 0.25_f64.powi(power);
            let nearest = polygon.weighted_closest(t).closest;
            if nearest.point.length() > far {
                return self.normal(t, nearest.point);
            }
        }
        self.normal(earliest, polygon.weighted_closest(earliest).closest.point)
    }

    /// Returns true if exact arithmetic decides what no direction does.
    pub(crate) fn is_decided_exactly(&self) -> bool {
        self.params.undecided != Undecided::Report && self.separation == 0.0
    }

    /// Returns the contact to report where no crossing is certain, by the closest point at `lo`.
    fn contact(
        &self,
        [lo, hi]: [f64; 2],
        nearest: &ClosestToOrigin<N>,
        certainty: Certainty,
    ) -> CcdContact {
        CcdContact {
            lo,
            hi,
            certainty,
            at_start: lo <= 0.0,
            weights: PolygonShape::<N>::stencil(nearest.weights),
            normal: self.normal(lo, nearest.point),
        }
    }

    /// Finds a time in an interval at which the polygon certainly is within the separation of the
    /// origin: its middle or its start.
    fn time_within_separation(
        &self,
        polygon: &MovingPolygon<'_, N>,
        interval: &RootInterval,
    ) -> Option<f64> {
        if self.separation <= 0.0 {
            return None;
        }
        // The weighted corners are a point of the polygon, whatever their weights are worth.
        let close = self.separation * (1.0 - 8.0 * UNIT) - self.outline.rounding();
        if close <= 0.0 {
            return None;
        }
        let is_close = |t: &f64| polygon.weighted_closest(*t).length_squared < close * close;
        [interval.middle(), interval.lo].into_iter().find(is_close)
    }

    /// Returns the unit direction away from the closest point at time `t` if rounding allows it, else
    /// the normal of the plane; an axis if neither has a direction.
    fn normal(&self, t: f64, closest: DVec3) -> DVec3 {
        // The sign of the volume is the side of the plane on which the second primitive is.
        let area = self.outline.area_vector(t);
        let plane = if self.cubic.value(t) > 0.0 { -area } else { area };
        let is_apart = closest.length() > 16.0 * self.outline.rounding();
        let candidates = if is_apart { [-closest, plane] } else { [plane, -closest] };
        candidates.into_iter().find_map(direction).unwrap_or(DVec3::Z)
    }
}

/// Returns the unit vector along `v`, if it has a direction. A vector whose square underflows is
/// scaled first.
fn direction(v: DVec3) -> Option<DVec3> {
    let size = if v.length_squared() > UNDERFLOW { 1.0 } else { v.abs().max_element() };
    (v / size).try_normalize()
}
