//! Bodies that overlap with their sides level, as two boxes in a row: no face crosses another, and no vertex is inside.

use std::collections::BTreeSet;

use glam::DVec3;
use scene::{BodyId, PairReport};

use crate::ResolveError;
use crate::detection::clearance;
use crate::resolution::covers_twice;
use crate::run::Run;

/// Distance by which one of two bodies is moved out of level \[clearances\]. Below, it is of rounding; above, it is seen.
const OUT_OF_LEVEL: f64 = 1e-3;

/// Direction in which it is moved, along no side of a box, and in no plane of two of its diagonals.
const DIRECTION: DVec3 = DVec3::new(0.239, 0.797, 0.555);

impl Run<'_> {
    /// Moves one body of each pair that overlaps level a little, to where faces cross and vertices are inside. Bodies of
    /// which most vertices are on the other have no side to leave by, and stay.
    pub(crate) fn move_out_of_level(&mut self) -> Result<(), ResolveError> {
        let mut bodies: BTreeSet<BodyId> = BTreeSet::new();
        for report in &self.before {
            let is_level = report.overlaps && report.crossing_faces.is_empty();
            if is_level && self.is_to_come_apart(report) {
                let is_free = |id: &BodyId| {
                    let tissue = &self.tissues[id.index()];
                    !tissue.is_rigid && !tissue.is_held
                };
                bodies.extend(report.pair.bodies().into_iter().rfind(is_free));
            }
        }
        if bodies.is_empty() {
            return Ok(());
        }
        let step = OUT_OF_LEVEL * clearance(&self.params) * DIRECTION;
        self.move_soft(|tissue, x| {
            bodies.contains(&tissue.id).then(|| {
                let moved = |(vertex, &x)| if tissue.is_free(vertex) { x + step } else { x };
                (0..).zip(x).map(moved).collect()
            })
        })
    }

    /// Returns true if a pair of which no face crosses is pushed apart, but has nothing yet that shows where to.
    fn is_to_come_apart(&self, report: &PairReport) -> bool {
        let pair = report.pair;
        let is_known = self.near.overlapping().any(|near| near.report.pair == pair);
        let is_left = self.exempt_pairs.contains(&pair) || self.is_tied(pair);
        !(is_known || is_left || covers_twice(report) || self.nearly_coincided(pair))
    }
}
