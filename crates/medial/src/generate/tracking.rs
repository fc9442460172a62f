//! Feet of surface samples on a union whose balls move a little at a time.
//!
//! Each sample keeps the few primitives that are not much farther than its nearest one. Since the
//! distance of a primitive changes by no more than its balls move and grow, one of these remains the
//! nearest until the balls around have moved as far as the list extends; then the sample searches
//! all primitives again. Balls far from a sample are not part of that test: now and then every list
//! is rebuilt.

use glam::DVec3;
use kdop::Workspace;
use surface::progress::Progress;

use crate::batches::map_in_batches;
use crate::{
    ExactFeet, MedialError, MedialSurface, NearestPrimitive, PreparedSlabs, PrimitiveTree, index,
};

/// Distance by which a list extends beyond the nearest primitive, in mean radii.
///
/// Twice as far and lists are long; half as far and they are used up twice as soon.
const LIST_MARGIN: f64 = 0.15;

/// Number of samples per batch: about a millisecond.
const SAMPLES_PER_BATCH: usize = 128;

/// Samples with the primitives that may be nearest to them.
pub(super) struct Tracking {
    points: Vec<DVec3>,
    lists: Vec<NearPrimitives>,
    list_margin: f64,
    tree: PrimitiveTree,
    /// For each primitive, the balls of those that share a ball with it.
    balls_around: Vec<Vec<u32>>,
    /// Sum of the moves and growths of each ball.
    traveled: Vec<f64>,
}

/// Primitives that may be nearest to a point, the nearest first.
struct NearPrimitives {
    primitives: Vec<u32>,
    /// Lower bound on the distance of each, plus all travel of its own balls until then.
    bounds: Vec<f64>,
    /// Lower bound on the distance of all others.
    others: f64,
    /// Largest travel of the balls around, when the list was built.
    traveled: f64,
}

impl Tracking {
    pub(super) fn new(
        medial: &MedialSurface,
        points: Vec<DVec3>,
        progress: Progress<'_>,
    ) -> Result<Self, MedialError> {
        let radii = medial.balls().iter().map(|ball| ball.radius).sum::<f64>();
        let balls = medial.balls().len();
        let mut tracking = Self {
            lists: Vec::new(),
            list_margin: LIST_MARGIN * radii / crate::real(balls),
            tree: PrimitiveTree::new(medial)?,
            balls_around: balls_around(medial),
            traveled: vec![0.0; balls],
            points,
        };
        tracking.rebuild_lists(medial, progress)?;
        Ok(tracking)
    }

    pub(super) fn points(&self) -> &[DVec3] {
        &self.points
    }

    /// Returns the primitives that may be nearest to a point, and some that are not much farther.
    pub(super) fn near(&self, point: u32) -> &[u32] {
        &self.lists[point as usize].primitives
    }

    /// Searches all primitives for those near each point.
    pub(super) fn rebuild_lists(
        &mut self,
        medial: &MedialSurface,
        progress: Progress<'_>,
    ) -> Result<(), MedialError> {
        self.tree.refit(medial)?;
        let slabs = PreparedSlabs::new(medial);
        let traveled = self.traveled_around(None);

        // Without a list, the search starts from the nearest primitive of the point before, which
        // mostly is next to it on the surface.
        let own = self.traveled_by(medial, None);
        let this = &*self;
        let scratch = <(u32, Vec<NearestPrimitive>, Workspace)>::default;
        let list = |(last, found, workspace): &mut (u32, Vec<_>, Workspace), i: usize| {
            let guess = this.lists.get(i).map_or(*last, |list| list.primitives[0]);
            let others = this.within_margin(&slabs, this.points[i], guess, found, workspace);
            *last = found[0].primitive;
            let bound = |near: &NearestPrimitive| near.foot.distance + own[near.primitive as usize];
            NearPrimitives {
                primitives: found.iter().map(|near| near.primitive).collect(),
                bounds: found.iter().map(bound).collect(),
                others,
                traveled: traveled[*last as usize],
            }
        };
        let count = self.points.len();
        self.lists = map_in_batches(count, SAMPLES_PER_BATCH, progress, scratch, list)?;
        Ok(())
    }

    /// Lists the primitives that are at most the margin farther from a point than the nearest one:
    /// that one first, the others ascending. Returns a lower bound on the distance of all others.
    fn within_margin(
        &self,
        slabs: &PreparedSlabs,
        p: DVec3,
        guess: u32,
        found: &mut Vec<NearestPrimitive>,
        workspace: &mut Workspace,
    ) -> f64 {
        let nearest = self.tree.nearest_from(slabs, p, guess, workspace);
        let others = nearest.foot.distance + self.list_margin;
        found.clear();
        self.tree.within(slabs, p, others, workspace, |near| {
            if near.primitive != nearest.primitive {
                found.push(near);
            }
        });
        found.sort_unstable_by_key(|near| near.primitive);
        found.insert(0, nearest);
        others
    }

    /// Computes the feet of all points on `medial`, which is `step` away from where the balls were
    /// at the last call of [`Self::add_travel`].
    pub(super) fn feet(
        &mut self,
        medial: &MedialSurface,
        step: &[f64],
        progress: Progress<'_>,
    ) -> Result<Vec<NearestPrimitive>, MedialError> {
        self.tree.refit(medial)?;
        let slabs = PreparedSlabs::new(medial);
        let traveled = self.traveled_around(Some(step));
        let own = self.traveled_by(medial, Some(step));
        let (tree, points, lists) = (&self.tree, &self.points, &self.lists);
        let foot = |workspace: &mut Workspace, i: usize| {
            // One of the list is the nearest, unless the balls around have traveled too far.
            let (p, list) = (points[i], &lists[i]);
            let best = list.nearest(&slabs, p, &own);
            let since = traveled[list.primitives[0] as usize] - list.traveled;
            if best.foot.distance + since <= list.others {
                best
            } else {
                tree.nearest_from(&slabs, p, best.primitive, workspace)
            }
        };
        let count = points.len();
        Ok(map_in_batches(count, SAMPLES_PER_BATCH, progress, Workspace::default, foot)?)
    }

    /// Adds the moves and growths of the balls in an accepted step.
    pub(super) fn add_travel(&mut self, step: &[f64]) {
        for (traveled, step) in self.traveled.iter_mut().zip(step) {
            *traveled += step;
        }
    }

    /// Computes the largest travel of the balls around each primitive, with a step that is not yet
    /// accepted.
    fn traveled_around(&self, step: Option<&[f64]>) -> Vec<f64> {
        let traveled = self.traveled_with(step);
        self.balls_around.iter().map(|balls| largest_of(&traveled, balls)).collect()
    }

    /// Computes the largest travel of each primitive's own balls.
    fn traveled_by(&self, medial: &MedialSurface, step: Option<&[f64]>) -> Vec<f64> {
        let traveled = self.traveled_with(step);
        medial.primitives().iter().map(|balls| largest_of(&traveled, balls)).collect()
    }

    /// Adds a step to the travel of each ball.
    fn traveled_with(&self, step: Option<&[f64]>) -> Vec<f64> {
        let mut traveled = self.traveled.clone();
        for (traveled, step) in traveled.iter_mut().zip(step.unwrap_or(&[])) {
            *traveled += step;
        }
        traveled
    }
}

fn largest_of(traveled: &[f64], balls: &[u32]) -> f64 {
    let mut largest = 0.0_f64;
    for &ball in balls {
        largest = largest.max(traveled[ball as usize]);
    }
    largest
}

impl NearPrimitives {
    /// Finds the nearest of the primitives, the first of equals; `own` has the travel of the balls of
    /// each until now.
    fn nearest(&self, slabs: &PreparedSlabs, p: DVec3, own: &[f64]) -> NearestPrimitive {
        let mut best = slabs.nearest_on(p, self.primitives[0]);
        for (&primitive, &bound) in self.primitives.iter().zip(&self.bounds).skip(1) {
            // Most of the others cannot have come near enough.
            if bound - own[primitive as usize] > best.foot.distance {
                continue;
            }
            let found = slabs.nearest_on(p, primitive);
            if found.foot.distance < best.foot.distance {
                best = found;
            }
        }
        best
    }
}

/// Lists, for each primitive, the balls of those that share a ball with it.
fn balls_around(medial: &MedialSurface) -> Vec<Vec<u32>> {
    let mut at_ball = vec![Vec::new(); medial.balls().len()];
    for (primitive, balls) in medial.primitives().iter().enumerate() {
        for &ball in balls {
            at_ball[ball as usize].push(index(primitive));
        }
    }

    let mut around = Vec::with_capacity(medial.primitives().len());
    for balls in medial.primitives() {
        let mut list = Vec::new();
        for &primitive in balls.iter().flat_map(|&ball| &at_ball[ball as usize]) {
            list.extend(medial.primitives()[primitive as usize]);
        }
        list.sort_unstable();
        list.dedup();
        around.push(list);
    }
    around
}

#[cfg(test)]
mod tests {
    use fixtures::random::Random;

    use super::*;
    use crate::Ball;

    /// Cones that share a ball: each is around all others.
    #[test]
    fn feet_are_the_nearest_while_balls_move() {
        let mut random = Random(4);
        let mut point =
            |size: f64| size * DVec3::from_array([(); 3].map(|()| 2.0 * random.unit() - 1.0));
        let mut balls: Vec<Ball> = (0..20).map(|_| Ball::new(point(10.0), 1.0)).collect();
        let surface = |balls: &[Ball]| {
            let cones = (1..20).map(|ball| [0, ball]).collect();
            MedialSurface::new(balls.to_vec(), cones, vec![]).expect("a star")
        };
        let samples: Vec<DVec3> = (0..100).map(|_| point(12.0)).collect();
        let mut tracking = Tracking::new(&surface(&balls), samples, Progress::none()).unwrap();

        let mut changed = 0;
        let mut last = vec![0; tracking.points().len()];
        for _ in 0..30 {
            let moves: Vec<DVec3> = balls.iter().map(|_| point(0.2)).collect();
            for (ball, by) in balls.iter_mut().zip(&moves) {
                ball.center += *by;
            }
            let step: Vec<f64> = moves.iter().map(|by| by.length()).collect();
            let medial = surface(&balls);
            let feet = tracking.feet(&medial, &step, Progress::none()).unwrap();
            tracking.add_travel(&step);
            let tree = PrimitiveTree::new(&medial).unwrap();
            for ((&p, foot), last) in tracking.points().iter().zip(&feet).zip(&mut last) {
                let nearest = tree.nearest(&medial, p, &mut Workspace::default());
                let excess = foot.foot.distance - nearest.foot.distance;
                assert!(excess.abs() < 1e-12, "{foot:?} for {nearest:?}");
                changed += usize::from(std::mem::replace(last, foot.primitive) != foot.primitive);
            }
        }
        assert!(changed > 150, "{changed}");
    }
}
