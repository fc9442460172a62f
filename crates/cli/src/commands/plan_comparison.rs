//! Differences between the depths of a plan and those of exact detection.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Instant;

use glam::DVec3;
use musculo_collide::{
    CheckParams, Depth, DepthBracket, Detection, DetectionMethod, PairDetection, PairId,
    PairReport, PairState, Plan, Progress, Scene, SceneError,
};

use super::plan_times::FrameTimes;
use crate::report::{counted, fixed};

/// Width of the brackets on exact depths \[tolerances\]: beside it, the tolerance is what counts.
const EXACT_WIDTH: f64 = 0.01;

/// Maximum number of decimals of lengths.
const MAX_DECIMALS: usize = 12;

/// Differences between planned and exact detection over all states.
#[derive(Debug, Default)]
pub(super) struct Comparison {
    exact: FrameTimes,
    /// Number of decimals of lengths.
    decimals: usize,
    /// Number of states that were compared.
    states: usize,
    worst: Option<Difference>,
    /// Depths that differ by more than the bound of their pair.
    exceeded: usize,
    /// Overlaps deeper than the bound that the plan reports as apart.
    missing: usize,
    /// Overlaps whose depth is undefined, since a body covers a place twice, or in part inside out.
    undefined: usize,
    /// Depths of the last state.
    pub(super) depths: BTreeMap<PairId, DepthBracket>,
}

/// Difference of two depths.
#[derive(Clone, Copy, Debug)]
struct Difference {
    pair: PairId,
    state: usize,
    error: f64,
    depth: f64,
    exact: DepthBracket,
    /// Deepest point by exact detection, and the point of the other surface nearest to it.
    place: Option<[DVec3; 2]>,
}

impl Comparison {
    /// Compares the depths of the present state, those of pairs that are not planned as well.
    pub(super) fn add(
        &mut self,
        state: usize,
        plan: &Plan,
        scene: &mut Scene,
        detection: &Detection,
    ) -> Result<(), SceneError> {
        // The time of exact detection is what the plan saves.
        let tolerance = plan.params().tolerance;
        let start = Instant::now();
        let params =
            CheckParams { depth_tolerance: Some(EXACT_WIDTH * tolerance), ..CheckParams::new(0.0) };
        let exact = scene.check(&params, Progress::none())?;
        self.exact.add(start.elapsed());
        self.states += 1;
        self.decimals = decimals(tolerance);

        // Pairs of the plan, and those that either detection has found; rigid ones are neither's.
        let mut bounds = BTreeMap::new();
        for planned in plan.pairs() {
            bounds.insert(planned.pair, planned.accuracy.bound);
        }
        let mut pairs: BTreeSet<PairId> = bounds.keys().copied().collect();
        for found in detection.pairs() {
            pairs.insert(found.pair);
        }
        for report in &exact {
            pairs.insert(report.pair);
        }

        self.depths.clear();
        for pair in pairs {
            if scene.body(pair.a).is_rigid() && scene.body(pair.b).is_rigid() {
                continue;
            }
            let report = exact.iter().find(|report| report.pair == pair);
            let bound = bounds.get(&pair).copied().unwrap_or(tolerance);
            self.add_pair(state, pair, bound, report, detection);
        }
        Ok(())
    }

    fn add_pair(
        &mut self,
        state: usize,
        pair: PairId,
        bound: f64,
        report: Option<&PairReport>,
        detection: &Detection,
    ) {
        // What a budget has left out is judged by its bound.
        let left_out = detection.left_out().iter().find(|left_out| left_out.pair == pair);
        let (exact, place) = match report {
            Some(report) if report.overlaps => match report.max_depth() {
                Some(depth) if !covers_twice(report) => (depth, deepest(report)),
                _ => {
                    self.undefined += 1;
                    return;
                }
            },
            _ => (DepthBracket::default(), None),
        };
        self.depths.insert(pair, exact);
        if let Some(left_out) = left_out {
            self.exceeded += usize::from(exact.lower > left_out.upper);
            return;
        }

        // Both depths are within brackets: they differ by what separates these. An undecided pair
        // states no depth but its upper bound.
        let found = detection.pair(pair);
        let depth = found.map_or(0.0, |found| found.max_depth);
        let error = (exact.lower - depth).max(depth - exact.upper).max(0.0);
        let is_exceeded = match found {
            Some(PairDetection { state: PairState::Undecided { upper }, .. }) => {
                exact.lower > *upper
            }
            // Boxes of this state bound what balls see.
            Some(found) if found.method == DetectionMethod::Balls => error > found.depth.upper,
            _ => error > bound,
        };
        if is_exceeded {
            self.exceeded += 1;
            self.missing += usize::from(found.is_none());
        }
        if self.worst.is_none_or(|worst| error > worst.error) {
            self.worst = Some(Difference { pair, state, error, depth, exact, place });
        }
    }

    /// Returns the number of depths that differ by more than their bound.
    pub(super) fn exceeded(&self) -> usize {
        self.exceeded
    }

    /// Describes the differences in words.
    pub(super) fn text(&self, scene: &Scene) -> String {
        let states = counted(self.states, "state");
        let mut text = format!("exact: {}, {states} compared\n", self.exact);
        if let Some(Difference { pair, state, error, depth, exact, place }) = self.worst {
            let [a, b] = scene.names(pair);
            let [error, depth, lower, upper] =
                [error, depth, exact.lower, exact.upper].map(|length| fixed(length, self.decimals));
            // Within a bracket any depth may be the exact one.
            text += &if lower == upper {
                format!("depths differ by at most {error} ({a} × {b}, {depth} instead of {lower}")
            } else {
                format!(
                    "depths differ by at most {error} from brackets on exact ones ({a} × {b}, {depth} \
                     instead of {lower} to {upper}"
                )
            };
            if let Some([point, foot]) = place {
                let [point, foot] = [point, foot].map(|p| point_text(p, self.decimals - 1));
                text += &format!(", at {point} from {foot}");
            }
            if self.states > 1 {
                text += &format!(", frame {state}");
            }
            text += ")\n";
        }

        text += &match self.exceeded {
            0 => "all depths are within the bounds of their pairs\n".to_owned(),
            count => format!(
                "error: {} off by more than the bound of the pair, {} reported as apart\n",
                counted(count, "depth"),
                self.missing,
            ),
        };
        if self.undefined > 0 {
            let count = counted(self.undefined, "overlap");
            text += &format!(
                "{count} without a defined depth: a body covers a place twice, or in part inside out\n"
            );
        }
        text
    }

    /// Returns the median time of exact detection \[ms\].
    pub(super) fn exact_milliseconds(&self) -> Option<f64> {
        self.exact.milliseconds().map(|[_, median, _]| median)
    }
}

/// Returns true if a body covers a place twice, or in part inside out: exact depths in it are undefined.
fn covers_twice(report: &PairReport) -> bool {
    report.overlap.as_ref().is_some_and(|overlap| overlap.measures.covers_twice.contains(&true))
}

/// Returns the number of decimals of lengths beside a tolerance: four, and more where it is small.
fn decimals(tolerance: f64) -> usize {
    let mut decimals = 4;
    let mut digits = 1e4 * tolerance;
    while digits < 1e3 && decimals < MAX_DECIMALS {
        decimals += 1;
        digits *= 10.0;
    }
    decimals
}

/// Returns the deepest point of both surfaces, and the nearest one of the other.
fn deepest(report: &PairReport) -> Option<[DVec3; 2]> {
    let overlap = report.overlap.as_ref()?;
    let mut deepest: Option<Depth> = None;
    for depth in [overlap.depth_of_a_in_b, overlap.depth_of_b_in_a].into_iter().flatten() {
        if deepest.is_none_or(|deepest| depth.lower > deepest.lower) {
            deepest = Some(depth);
        }
    }
    deepest.map(|deepest| [deepest.point, deepest.foot])
}

fn point_text(p: DVec3, decimals: usize) -> String {
    format!("({:.decimals$}, {:.decimals$}, {:.decimals$})", p.x, p.y, p.z)
}

#[cfg(test)]
mod tests {
    use fixtures::shapes::cube;
    use musculo_collide::BodyKind;

    use super::*;

    /// Returns the line of a difference from an exact depth within a bracket.
    fn line(depth: f64, exact: DepthBracket) -> String {
        let mut scene = Scene::new();
        let [a, b] = ["bone", "muscle"].map(|name| {
            let mesh = cube(1.0);
            scene.add(name, BodyKind::Deformable, mesh.surface(), mesh.positions).expect("a body")
        });
        let error = (exact.lower - depth).max(depth - exact.upper).max(0.0);
        let pair = PairId::new(a, b);
        let worst = Some(Difference { pair, state: 0, error, depth, exact, place: None });
        let comparison = Comparison { worst, decimals: 4, states: 1, ..Comparison::default() };
        let text = comparison.text(&scene);
        text.lines().nth(1).expect("a difference").to_owned()
    }

    #[test]
    fn a_difference_is_that_from_the_bracket_which_is_written() {
        let exact = DepthBracket { lower: 1.1997, upper: 1.2046 };
        assert_eq!(
            line(1.2011, exact),
            "depths differ by at most 0.0000 from brackets on exact ones (bone × muscle, 1.2011 \
             instead of 1.1997 to 1.2046)"
        );
        assert!(line(1.2146, exact).starts_with("depths differ by at most 0.0100 from brackets"));
        let exact = DepthBracket { lower: 1.2, upper: 1.2 };
        assert_eq!(
            line(1.25, exact),
            "depths differ by at most 0.0500 (bone × muscle, 1.2500 instead of 1.2000)"
        );
    }
}
