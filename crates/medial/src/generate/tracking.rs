//! Feet of surface samples on a union whose balls move a little at a time.
//!
//! A sample's nearest primitive changes only to one beside it while steps are
//! small. So the primitives that share a ball with the last one are compared,
//! until none is nearer; now and then all are searched.

use glam::DVec3;
use kdop::Workspace;

use crate::{
    FootRule, MedialError, MedialSurface, NearestPrimitive, PrimitiveTree, index, parallel,
};

/// Nearest primitives of a list of points.
pub(super) struct Tracking {
    points: Vec<DVec3>,
    nearest: Vec<u32>,
    /// For each primitive, those that share a ball with it.
    beside: Vec<Vec<u32>>,
}

impl Tracking {
    pub(super) fn new(medial: &MedialSurface, points: Vec<DVec3>) -> Result<Self, MedialError> {
        let mut tracking = Self { nearest: vec![0; points.len()], beside: beside(medial), points };
        tracking.search(medial)?;
        Ok(tracking)
    }

    pub(super) fn points(&self) -> &[DVec3] {
        &self.points
    }

    /// Finds the nearest primitives among all.
    pub(super) fn search(&mut self, medial: &MedialSurface) -> Result<(), MedialError> {
        let tree = PrimitiveTree::new(medial)?;
        let (points, last) = (&self.points, &self.nearest);
        let found = parallel::map(points.len(), Workspace::default, |workspace, i| {
            tree.nearest_from(medial, points[i], last[i], workspace).primitive
        });
        self.nearest = found;
        Ok(())
    }

    /// The feet on `medial`, each found by walking from the last one kept.
    pub(super) fn feet(&self, medial: &MedialSurface) -> Vec<NearestPrimitive> {
        parallel::map(self.points.len(), || (), |(), i| self.walk(medial, i))
    }

    /// Keeps feet as the start of the next walks.
    pub(super) fn keep(&mut self, feet: impl Iterator<Item = u32>) {
        self.nearest.clear();
        self.nearest.extend(feet);
    }

    fn walk(&self, medial: &MedialSurface, point: usize) -> NearestPrimitive {
        let p = self.points[point];
        let at = |primitive| NearestPrimitive {
            primitive,
            foot: medial.foot(p, primitive, FootRule::Exact),
        };
        let mut best = at(self.nearest[point]);
        loop {
            let from = best.primitive;
            for &primitive in &self.beside[from as usize] {
                let found = at(primitive);
                if found.foot.distance < best.foot.distance {
                    best = found;
                }
            }
            if best.primitive == from {
                return best;
            }
        }
    }
}

fn beside(medial: &MedialSurface) -> Vec<Vec<u32>> {
    let mut at_ball = vec![Vec::new(); medial.balls().len()];
    for (primitive, balls) in medial.primitives().iter().enumerate() {
        for &ball in balls {
            at_ball[ball as usize].push(index(primitive));
        }
    }
    let around = |(primitive, balls): (usize, &[u32; 3])| {
        let mut list: Vec<u32> =
            balls.iter().flat_map(|&ball| &at_ball[ball as usize]).copied().collect();
        list.sort_unstable();
        list.dedup();
        list.retain(|&other| other as usize != primitive);
        list
    };
    medial.primitives().iter().enumerate().map(around).collect()
}
