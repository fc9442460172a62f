//! Feet of surface samples on a union whose balls move a little at a time.
//!
//! Each sample keeps the few primitives that are not much farther than its nearest
//! one. Since a primitive's distance changes by no more than its balls move and
//! grow, one of these stays the nearest until the balls around have moved as far as
//! the list reaches; then the sample searches all primitives again. Balls far from
//! a sample are not asked how far they moved: now and then every list is made anew.

use glam::DVec3;
use kdop::Workspace;

use crate::{
    FootRule, MedialError, MedialSurface, NearestPrimitive, PrimitiveTree, index, parallel,
};

/// How far a list reaches, in mean radii. Twice as far and lists are long; half as
/// far and they are used up twice as soon.
const LIST_REACH: f64 = 0.15;

/// Primitives that may be nearest to points.
pub(super) struct Tracking {
    points: Vec<DVec3>,
    lists: Vec<List>,
    list_reach: f64,
    tree: PrimitiveTree,
    /// For each primitive, the balls of those that share a ball with it.
    around: Vec<Vec<u32>>,
    /// How far each ball has moved and grown.
    travelled: Vec<f64>,
}

/// The primitives that may be nearest to a point.
struct List {
    primitives: Vec<u32>,
    /// No other primitive was nearer than this.
    others: f64,
    /// How far the balls around had travelled then.
    travelled: f64,
}

impl Tracking {
    pub(super) fn new(medial: &MedialSurface, points: Vec<DVec3>) -> Result<Self, MedialError> {
        let radii = medial.balls().iter().map(|ball| ball.radius).sum::<f64>();
        let balls = medial.balls().len();
        let mut tracking = Self {
            lists: Vec::new(),
            list_reach: LIST_REACH * radii / crate::real(balls),
            tree: PrimitiveTree::new(medial)?,
            around: around(medial),
            travelled: vec![0.0; balls],
            points,
        };
        tracking.search(medial)?;
        Ok(tracking)
    }

    pub(super) fn points(&self) -> &[DVec3] {
        &self.points
    }

    /// The primitives that may be nearest to a point, and some that are not much
    /// farther.
    pub(super) fn near(&self, point: u32) -> &[u32] {
        &self.lists[point as usize].primitives
    }

    /// Makes every list anew.
    pub(super) fn search(&mut self, medial: &MedialSurface) -> Result<(), MedialError> {
        self.tree.refit(medial)?;
        let travelled = self.travelled_around(None);
        let (tree, points, lists) = (&self.tree, &self.points, &self.lists);
        // Samples next to each other in the list mostly are so on the surface.
        let start = || (0, Workspace::default());
        let found = parallel::map(points.len(), start, |(last, workspace), i| {
            let p = points[i];
            let guess = lists.get(i).map_or(*last, |list: &List| list.primitives[0]);
            let nearest = tree.nearest_from(medial, p, guess, workspace);
            *last = nearest.primitive;
            let others = nearest.foot.distance + self.list_reach;
            let mut primitives = vec![nearest.primitive];
            tree.within(medial, p, others, workspace, |primitive| {
                if primitive != nearest.primitive {
                    primitives.push(primitive);
                }
            });
            primitives[1..].sort_unstable();
            let travelled = travelled[nearest.primitive as usize];
            List { primitives, others, travelled }
        });
        self.lists = found;
        Ok(())
    }

    /// The feet of all points on `medial`, which is a step away from where the balls
    /// were when [`Self::moved`] was last told.
    pub(super) fn feet(
        &mut self,
        medial: &MedialSurface,
        step: &[f64],
    ) -> Result<Vec<NearestPrimitive>, MedialError> {
        self.tree.refit(medial)?;
        let travelled = self.travelled_around(Some(step));
        let (tree, points, lists) = (&self.tree, &self.points, &self.lists);
        Ok(parallel::map(points.len(), Workspace::default, |workspace, i| {
            let (p, list) = (points[i], &lists[i]);
            let best = nearest_of(medial, p, &list.primitives);
            let travelled = travelled[list.primitives[0] as usize] - list.travelled;
            if best.foot.distance + travelled <= list.others {
                best
            } else {
                tree.nearest_from(medial, p, best.primitive, workspace)
            }
        }))
    }

    /// Tells how far each ball has moved and grown.
    pub(super) fn moved(&mut self, step: &[f64]) {
        for (travelled, step) in self.travelled.iter_mut().zip(step) {
            *travelled += step;
        }
    }

    /// How far the balls around each primitive have travelled at most.
    fn travelled_around(&self, step: Option<&[f64]>) -> Vec<f64> {
        let travelled = |&ball: &u32| {
            let step = step.map_or(0.0, |step| step[ball as usize]);
            self.travelled[ball as usize] + step
        };
        self.around.iter().map(|balls| balls.iter().map(travelled).fold(0.0, f64::max)).collect()
    }
}

fn nearest_of(medial: &MedialSurface, p: DVec3, primitives: &[u32]) -> NearestPrimitive {
    let at = |primitive| NearestPrimitive {
        primitive,
        foot: medial.foot(p, primitive, FootRule::Exact),
    };
    let first = at(primitives[0]);
    primitives[1..].iter().fold(first, |best, &primitive| {
        let found = at(primitive);
        if found.foot.distance < best.foot.distance { found } else { best }
    })
}

fn around(medial: &MedialSurface) -> Vec<Vec<u32>> {
    let mut at_ball = vec![Vec::new(); medial.balls().len()];
    for (primitive, balls) in medial.primitives().iter().enumerate() {
        for &ball in balls {
            at_ball[ball as usize].push(index(primitive));
        }
    }
    let around = |balls: &[u32; 3]| {
        let beside = balls.iter().flat_map(|&ball| &at_ball[ball as usize]);
        let mut list: Vec<u32> =
            beside.flat_map(|&primitive| medial.primitives()[primitive as usize]).collect();
        list.sort_unstable();
        list.dedup();
        list
    };
    medial.primitives().iter().map(around).collect()
}
