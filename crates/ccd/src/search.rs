//! The search for the first contact: filters, candidate times, verdicts.
//!
//! Nothing is passed over unless a certificate holds for every time in it:
//! - an axis, or the area vector of either end, for the whole step;
//! - the cubic, outside the intervals in which it may be zero;
//! - a direction, on such an interval or on the pieces of it.

use glam::DVec3;

use crate::contact::{CcdContact, CcdParams, Certainty};
use crate::coplanarity::Coplanarity;
use crate::cubic::{Cubic, RootInterval, RootKind, Roots};
use crate::error::CcdError;
use crate::polygon::{Corners, MovingPolygon, Outline, Shape, mix_points};
use crate::rounding::{EDGE_FUNCTION, EDGE_FUNCTION_RATE, UNDERFLOW, UNIT};

/// An interval longer than this is searched piece by piece: within a shorter
/// one a time cannot be improved by much, and its start is the answer.
const SHORT: f64 = 1e-9;

/// The outline of a moving polygon, its cubic, and what is asked of them.
pub(crate) struct Search<'a, const N: usize> {
    pub(crate) outline: &'a Outline,
    pub(crate) cubic: Cubic,
    /// How far from zero the cubic has to be.
    margin: f64,
    pub(crate) params: &'a CcdParams,
    /// The points that the outline was made of, at both ends of the step.
    pub(crate) points: [&'a [DVec3; 4]; 2],
    /// Minimum separation in the polygon's scaled unit.
    pub(crate) separation: f64,
}

/// The origin beside the edges of the polygon at one time.
pub(crate) struct Place<const N: usize> {
    /// The edges of corner 0.
    edges: [DVec3; 2],
    pub(crate) area: DVec3,
    /// For each edge, the volume that it spans with the origin and the area
    /// vector: positive on the inner side.
    pub(crate) edge_functions: [f64; N],
    /// Whether all of these are certainly positive during the interval, so
    /// that whenever the plane holds the origin, so does the polygon.
    pub(crate) is_inside: bool,
}

/// Finds the first contact of a query: of its polygon with the origin.
#[inline]
pub(crate) fn first_contact<const N: usize>(
    x0: &[DVec3; 4],
    x1: &[DVec3; 4],
    params: &CcdParams,
) -> Result<Option<CcdContact>, CcdError>
where
    Shape<N>: Corners<N>,
{
    let find = |search: &Search<'_, N>| {
        search.cubic.find_interval(search.margin, |interval| search.examine(interval))
    };
    let first = Search::unless_filtered(x0, x1, params, find)?.flatten();
    // Times do not depend on the last one of interest; it only leaves out.
    Ok(first.filter(|contact| contact.lo <= params.t_max))
}

impl<const N: usize> Search<'_, N>
where
    Shape<N>: Corners<N>,
{
    /// Runs a search of a query that no filter excludes contact from.
    #[inline]
    pub(crate) fn unless_filtered<R>(
        x0: &[DVec3; 4],
        x1: &[DVec3; 4],
        params: &CcdParams,
        run: impl FnOnce(&Search<'_, N>) -> R,
    ) -> Result<Option<R>, CcdError> {
        let outline = Outline::new::<N>(x0, x1)?;
        let separation = outline.scaling.length(params.min_separation);
        if outline.axis_separates(separation) {
            return Ok(None);
        }
        let coplanarity = Coplanarity::new(&outline);
        if coplanarity.areas_separate::<N>(params.t_max, separation) {
            return Ok(None);
        }
        let cubic = coplanarity.cubic();
        let margin = if separation > 0.0 { coplanarity.margin(separation) } else { 0.0 };
        if cubic.excludes_zero(margin) {
            return Ok(None);
        }
        let points = [x0, x1];
        Ok(Some(run(&Search { outline: &outline, cubic, margin, params, points, separation })))
    }

    /// Intervals outside which the cubic excludes contact.
    #[inline]
    pub(crate) fn intervals(&self) -> Roots {
        self.cubic.isolate(self.margin)
    }
}

impl<const N: usize> Search<'_, N>
where
    Shape<N>: Corners<N>,
{
    /// The first contact in an interval, or none if it can be excluded there.
    #[inline]
    pub(crate) fn examine(&self, interval: &RootInterval) -> Option<CcdContact> {
        let place = self.place(interval);
        if self.separation == 0.0 && place.is_inside {
            match interval.kind {
                RootKind::Rising => return Some(self.crossing(interval, &place, 1.0)),
                RootKind::Falling => return Some(self.crossing(interval, &place, -1.0)),
                RootKind::Grazing | RootKind::Vanishing => {}
            }
        } else if self.outside_an_edge(&self.polygon(), interval, &place) {
            return None;
        }
        self.search(interval)
    }

    /// The polygon with all its corners, which a certain crossing does not need.
    #[inline]
    pub(crate) fn polygon(&self) -> MovingPolygon<'_, N> {
        MovingPolygon::new(self.outline, self.points)
    }

    /// Where the origin is, relative to the edges, in the middle of an interval.
    #[inline]
    pub(crate) fn place(&self, interval: &RootInterval) -> Place<N> {
        let t = 0.5 * (interval.lo + interval.hi);
        let outline = self.outline;
        let [first, last] = outline.edges(t);
        let corner = mix_points(outline.corner[0], outline.corner[1], t);
        let area = first.cross(last);
        let turned = area.cross(corner);
        let edge_functions =
            Shape::<N>::edge_functions(turned.dot(first), -turned.dot(last), area.dot(area));
        let bound = self.edge_function_bound(area, interval.hi - interval.lo);
        let is_inside = edge_functions.iter().all(|&w| w > bound);
        Place { edges: [first, last], area, edge_functions, is_inside }
    }

    /// Bound on the error of edge functions, and on their change in an interval
    /// around the time at which they were taken.
    #[inline]
    pub(crate) fn edge_function_bound(&self, area: DVec3, length: f64) -> f64 {
        let q = self.outline.reach();
        let crossed = DVec3::new(q.y * q.z, q.z * q.x, q.x * q.y);
        (EDGE_FUNCTION + EDGE_FUNCTION_RATE * length) * area.abs().dot(crossed) + UNDERFLOW
    }

    /// Direction certificate across an edge that has the origin on its outer side.
    #[inline]
    pub(crate) fn outside_an_edge(
        &self,
        polygon: &MovingPolygon<'_, N>,
        interval: &RootInterval,
        place: &Place<N>,
    ) -> bool {
        let [first, last] = place.edges;
        let edges = Shape::<N>::edges(first, last);
        let (lo, hi) = (interval.lo, interval.hi);
        for (edge, edge_function) in edges.into_iter().zip(place.edge_functions) {
            let inward = place.area.cross(edge);
            if edge_function < 0.0 && polygon.direction_separates(inward, lo, hi, self.separation) {
                return true;
            }
        }
        false
    }

    /// The contact at a certain crossing, in which the origin passes to the
    /// given side of the plane.
    #[inline]
    fn crossing(&self, interval: &RootInterval, place: &Place<N>, side: f64) -> CcdContact {
        let long = interval.hi - interval.lo > SHORT;
        let ends = [interval.lo, interval.hi];
        let later = if long { self.advance(&self.polygon(), ends, true) } else { None };
        let weights = Shape::<N>::corner_weights(place.edge_functions);
        CcdContact {
            lo: later.unwrap_or(interval.lo),
            hi: interval.hi,
            certainty: Certainty::Certain,
            at_start: false,
            weights: Shape::<N>::stencil(weights),
            normal: place.area * (side / place.area.length()),
        }
    }

    /// Searches an interval piece by piece, by directions.
    #[inline(never)]
    fn search(&self, interval: &RootInterval) -> Option<CcdContact> {
        let polygon = self.polygon();
        let (lo, hi) = (interval.lo, interval.hi);
        let within = self.time_within_separation(&polygon, interval);
        if hi - lo < SHORT && self.separation == 0.0 {
            let direction = polygon.closest(0.5 * (lo + hi)).point;
            if polygon.direction_separates(direction, lo, hi, self.separation) {
                return None;
            }
            if lo > 0.0 {
                return self.undecided(*interval);
            }
        }
        let lo = self.advance(&polygon, [lo, hi], within.is_some())?;
        match within {
            Some(hi) => {
                Some(self.reported(&RootInterval { lo, hi, ..*interval }, Certainty::Certain))
            }
            None => self.undecided(RootInterval { lo, ..*interval }),
        }
    }

    /// What becomes of an interval at whose start no direction holds.
    #[cfg(not(feature = "exact"))]
    fn undecided(&self, interval: RootInterval) -> Option<CcdContact> {
        Some(self.reported(&interval, Certainty::Possible))
    }

    /// What becomes of an interval at whose start no direction holds.
    #[cfg(feature = "exact")]
    fn undecided(&self, interval: RootInterval) -> Option<CcdContact> {
        use crate::exact::{Decision, decide};

        let possible = self.reported(&interval, Certainty::Possible);
        if !self.is_decided_exactly() {
            return Some(possible);
        }
        let [x0, x1] = self.points;
        match decide::<N>(x0, x1, interval.lo, interval.hi) {
            Decision::Free => None,
            Decision::Contact { lo, hi, at_start } => {
                let certainty = Certainty::Certain;
                Some(CcdContact { lo, hi, at_start, certainty, ..possible })
            }
            Decision::Open => Some(possible),
        }
    }

    /// Whether exact arithmetic decides what no direction does.
    #[cfg(feature = "exact")]
    pub(crate) fn is_decided_exactly(&self) -> bool {
        self.params.undecided == crate::contact::Undecided::DecideExactly && self.separation == 0.0
    }

    /// The contact to report where no crossing is certain.
    fn reported(&self, interval: &RootInterval, certainty: Certainty) -> CcdContact {
        let (lo, hi) = (interval.lo, interval.hi);
        let nearest = self.polygon().closest(lo);
        CcdContact {
            lo,
            hi,
            certainty,
            at_start: lo <= 0.0,
            weights: Shape::<N>::stencil(nearest.weights),
            normal: self.normal(interval, nearest.point),
        }
    }

    /// A time in an interval at which the polygon certainly is within the
    /// separation of the origin: the middle of it, if any is found.
    fn time_within_separation(
        &self,
        polygon: &MovingPolygon<'_, N>,
        interval: &RootInterval,
    ) -> Option<f64> {
        if self.separation <= 0.0 {
            return None;
        }
        let close = self.separation * (1.0 - 8.0 * UNIT) - self.rounding();
        let middle = 0.5 * (interval.lo + interval.hi);
        let mut times = [middle, interval.lo].into_iter();
        times.find(|&t| polygon.closest(t).point.length() < close)
    }

    /// Unit direction away from the closest point, or of the plane, whichever
    /// is known; an axis where neither is.
    fn normal(&self, interval: &RootInterval, closest: DVec3) -> DVec3 {
        let area = self.outline.area_vector(interval.lo);
        let plane = if self.cubic.value(interval.lo) > 0.0 { -area } else { area };
        let known = closest.length() > 16.0 * self.rounding();
        let candidates = if known { [-closest, plane] } else { [plane, -closest] };
        candidates.into_iter().find_map(DVec3::try_normalize).unwrap_or(DVec3::Z)
    }

    /// Bound on the rounding of a point of the polygon.
    fn rounding(&self) -> f64 {
        16.0 * UNIT * self.outline.reach().element_sum()
    }
}
