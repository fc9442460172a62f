//! The largest distance of some triangles from others, by branch and bound.
//!
//! The distance from one target face is convex, so on a patch it is nowhere more than
//! at one of its corners; and no more than that of the nearest face. Where no one face
//! is near all of a patch, the height of the faces that cover it bounds
//! it. Patches whose bound is not good enough are split in four.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use glam::DVec3;
use kdop::Workspace;
use surface::DirectedHausdorff;

use crate::cover::Cover;
use crate::triangles::{Target, Triangles};

/// How well the largest distance must be known.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Aim {
    /// A bound no more than this above what was seen is always good enough.
    pub(crate) slack: f64,
    /// A larger distance ends the search: the bound is then infinite.
    pub(crate) at_most: f64,
    /// Splits before the search ends anyway.
    pub(crate) splits: usize,
}

/// Excess of a bound over what was seen at which splitting ends, relative to
/// the latter.
const RELATIVE_SLACK: f64 = 0.05;

/// The largest distance of a point of `from` to the target. `hints` are faces that
/// may be near to all of a face; the fewer of them are far, the faster.
pub(crate) fn largest(
    from: &Triangles<'_>,
    target: &Target<'_>,
    hints: impl Fn(usize) -> [u32; 3],
    aim: Aim,
) -> DirectedHausdorff {
    let mut search = Search::new(*target, aim);
    for (face, vertices) in from.faces().iter().enumerate() {
        let patch = Patch { corners: vertices.map(|v| from.x[v as usize]), near: hints(face) };
        search.add(patch.bound(target), Stage::Whole, patch);
    }
    search.run()
}

/// A triangle, and for each corner a target face that may be near.
#[derive(Clone, Copy, Debug)]
struct Patch {
    corners: [DVec3; 3],
    near: [u32; 3],
}

impl Patch {
    /// The least over its faces of the largest distance at a corner.
    fn bound(&self, target: &Target<'_>) -> f64 {
        let at_most = |face: u32| {
            let distance = |&corner: &DVec3| target.triangles.distance(corner, face);
            self.corners.iter().map(distance).fold(0.0, f64::max)
        };
        let [a, b, c] = self.near;
        let mut bound = at_most(a);
        if b != a {
            bound = bound.min(at_most(b));
        }
        if c != a && c != b {
            bound = bound.min(at_most(c));
        }
        bound
    }
}

/// What has been done about a patch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    /// Bounded by single faces.
    Whole,
    /// Bounded by what covers it, too.
    Covered,
}

/// A patch by its number, with its bound: the largest first, of equals the first.
#[derive(Clone, Copy, Debug)]
struct Piece {
    bound: f64,
    number: usize,
}

impl Ord for Piece {
    fn cmp(&self, other: &Self) -> Ordering {
        self.bound.total_cmp(&other.bound).then_with(|| other.number.cmp(&self.number))
    }
}

impl PartialOrd for Piece {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Piece {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Piece {}

struct Search<'a> {
    target: Target<'a>,
    aim: Aim,
    pieces: BinaryHeap<Piece>,
    /// What was put into the heap, by number.
    patches: Vec<(Stage, Patch)>,
    seen: f64,
    /// The largest bound of the patches that were left out.
    left_out: f64,
    cover: Cover,
    workspace: Workspace,
}

impl<'a> Search<'a> {
    fn new(target: Target<'a>, aim: Aim) -> Self {
        Self {
            target,
            aim,
            pieces: BinaryHeap::new(),
            patches: Vec::new(),
            seen: 0.0,
            left_out: 0.0,
            cover: Cover::new(target.triangles.faces().len()),
            workspace: Workspace::default(),
        }
    }

    fn enough(&self) -> f64 {
        (self.seen + self.aim.slack.max(RELATIVE_SLACK * self.seen)).min(self.aim.at_most)
    }

    fn add(&mut self, bound: f64, stage: Stage, patch: Patch) {
        if bound <= self.enough() {
            self.left_out = self.left_out.max(bound);
        } else {
            self.pieces.push(Piece { bound, number: self.patches.len() });
            self.patches.push((stage, patch));
        }
    }

    /// Looks closer at what may be largest until the rest hardly matters.
    fn run(mut self) -> DirectedHausdorff {
        let mut splits = 0;
        while let Some(&piece) = self.pieces.peek() {
            if piece.bound <= self.enough() || splits == self.aim.splits {
                break;
            }
            self.pieces.pop();
            let (stage, patch) = self.patches[piece.number];
            match stage {
                Stage::Whole => self.cover(&patch, piece.bound),
                Stage::Covered => {
                    self.split(&patch, piece.bound);
                    splits += 1;
                }
            }
            if self.seen > self.aim.at_most {
                return DirectedHausdorff { lower: self.seen, upper: f64::INFINITY };
            }
        }
        let rest = self.pieces.peek().map_or(0.0, |piece| piece.bound);
        DirectedHausdorff { lower: self.seen, upper: rest.max(self.left_out).max(self.seen) }
    }

    /// Looks at what covers a patch: around its corners, or over its middle.
    fn cover(&mut self, patch: &Patch, bound: f64) {
        let target = self.target;
        let around = self.cover.bound(&target, patch.corners, patch.near, bound);
        let covered = around.or_else(|| {
            let [a, b, c] = patch.corners;
            let (over, _) = self.nearest((a + b + c) / 3.0, patch.near[0]);
            self.cover.bound(&target, patch.corners, [over; 3], bound)
        });
        self.add(covered.unwrap_or(bound), Stage::Covered, *patch);
    }

    fn split(&mut self, patch: &Patch, bound: f64) {
        let [a, b, c] = [0, 1, 2].map(|k| {
            let p = patch.corners[k];
            (p, self.nearest(p, patch.near[k]).0)
        });
        let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(from, to)| {
            let p = from.0.midpoint(to.0);
            (p, self.nearest(p, from.1).0)
        });
        for corners in [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]] {
            let patch = Patch { corners: corners.map(|c| c.0), near: corners.map(|c| c.1) };
            let bound = bound.min(patch.bound(&self.target));
            self.add(bound, Stage::Whole, patch);
        }
    }

    fn nearest(&mut self, p: DVec3, guess: u32) -> (u32, f64) {
        let nearest = self.target.nearest(p, guess, &mut self.workspace);
        self.seen = self.seen.max(nearest.1);
        nearest
    }
}
