//! Average-case collision detection: how likely do two trees of boxes meet?
//!
//! Each node of a tree of boxes keeps in how many cells of its box the surface
//! fills a good part. Where two boxes overlap, these counts say how many cells
//! of the overlap each surface is expected to fill, and, had chance dealt
//! them, how likely some cell is filled by both. The likeliest pair is opened
//! first; the search ends when a pair is likely enough, when none is left, or
//! when the budget is spent.
//!
//! Source: J. Klein and G. Zachmann, "ADB-Trees: controlling the error of
//! time-critical collision detection", VMV 2003, and "Time-critical collision
//! detection using an average-case approach", VRST 2003. Differs in that
//! leaves are tested exactly, so that an acceptance of 1 and no limit give the
//! exact answer.
//!
//! It says whether there is a collision, not where: no vertices, no depth.
//!
//! # Example
//!
//! ```
//! use glam::DVec3;
//! use surface::TriangleSurface;
//! use baselines::{PlacedSurface, average_case::{AverageCaseParams, AverageCaseTree}};
//!
//! let faces = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
//! let surface = TriangleSurface::new(4, faces)?;
//! let first = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
//! let second = first.map(|x| x + DVec3::splat(0.2));
//! let (x, y) = (surface.positions(&first)?, surface.positions(&second)?);
//! let (a, b) = (PlacedSurface { surface: &surface, x }, PlacedSurface { surface: &surface, x: y });
//! let params = AverageCaseParams { acceptance: 1.0, ..AverageCaseParams::DEFAULT };
//! let (tree_a, tree_b) = (AverageCaseTree::new(a, &params)?, AverageCaseTree::new(b, &params)?);
//! assert!(tree_a.detect(a, &tree_b, b, &params)?.overlap);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use glam::DVec3;
use surface::{Meeting, triangles_meet};

use crate::boxes::Bounds;
use crate::error::{BaselineError, check_count, check_share};
use crate::findings::{PairFindings, PlacedSurface, index};

/// How trees are made, and when the search is content.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AverageCaseParams {
    /// Cells along each side of a node's box, in `1..=16`.
    pub cells: u32,
    /// Share of a cell's largest cross-section that surface must cover for the
    /// cell to count as filled, in `0.0..=1.0` and not 0.
    pub filled: f64,
    /// Probability from which on a collision is reported, in `0.0..=1.0` and
    /// not 0. With 1, only faces that cross are one.
    pub acceptance: f64,
    /// Pairs of nodes and of faces tested, at most. When they are spent, no
    /// collision is reported, and [`PairFindings::probability`] is that of the
    /// likeliest pair left.
    pub max_tests: u64,
}

impl AverageCaseParams {
    /// 8 cells a side, half filled, nine in ten.
    pub const DEFAULT: Self = Self { cells: 8, filled: 0.5, acceptance: 0.9, max_tests: u64::MAX };

    fn check(&self) -> Result<(), BaselineError> {
        check_count("cells", self.cells.into(), 16)?;
        check_share("filled", self.filled)?;
        check_share("acceptance", self.acceptance)
    }
}

impl Default for AverageCaseParams {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// Faces in a leaf, at most.
const LEAF: usize = 4;

/// A binary tree of boxes over a body's faces, with counts of filled cells.
#[derive(Clone, Debug)]
pub struct AverageCaseTree {
    nodes: Vec<Node>,
    /// Faces in the order of the leaves.
    faces: Vec<u32>,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    bounds: Bounds,
    /// Share of the cells of the box that are filled.
    filled: f64,
    below: Below,
}

#[derive(Clone, Copy, Debug)]
enum Below {
    /// Numbers of two nodes.
    Nodes([u32; 2]),
    /// From where to where in the list of faces.
    Faces([u32; 2]),
}

impl AverageCaseTree {
    /// Builds the tree of a body; it is good for this state of it alone.
    ///
    /// # Errors
    ///
    /// When a parameter is out of range.
    pub fn new(body: PlacedSurface<'_>, params: &AverageCaseParams) -> Result<Self, BaselineError> {
        params.check()?;
        let mut tree = Self { nodes: Vec::new(), faces: (0..body.face_count()).collect() };
        if !tree.faces.is_empty() {
            tree.build(body, params, 0..body.surface.faces().len());
        }
        Ok(tree)
    }

    /// Bytes that the tree takes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.nodes.capacity() * size_of::<Node>() + self.faces.capacity() * size_of::<u32>()
    }

    /// Builds the node over part of the faces, and all below; gives its number.
    fn build(
        &mut self,
        body: PlacedSurface<'_>,
        params: &AverageCaseParams,
        part: std::ops::Range<usize>,
    ) -> u32 {
        let faces = &mut self.faces[part.clone()];
        let bounds =
            faces.iter().fold(Bounds::EMPTY, |b, &f| b.union(Bounds::of(&body.corners(f))));
        let node = self.nodes.len();
        let filled = filled_share(body, faces, bounds, params);
        let below = Below::Faces([index(part.start), index(part.end)]);
        self.nodes.push(Node { bounds, filled, below });
        if part.len() > LEAF {
            halve(body, faces, bounds);
            let middle = part.start + part.len() / 2;
            let children =
                [part.start..middle, middle..part.end].map(|half| self.build(body, params, half));
            self.nodes[node].below = Below::Nodes(children);
        }
        index(node)
    }

    /// Tells whether two bodies collide, by their trees.
    ///
    /// # Errors
    ///
    /// When a parameter is out of range.
    pub fn detect(
        &self,
        body: PlacedSurface<'_>,
        other: &Self,
        other_body: PlacedSurface<'_>,
        params: &AverageCaseParams,
    ) -> Result<PairFindings, BaselineError> {
        params.check()?;
        let mut search = Search { trees: [self, other], params, open: BinaryHeap::new(), tests: 0 };
        if !(self.nodes.is_empty() || other.nodes.is_empty()) {
            search.open([0, 0]);
        }
        let mut found = PairFindings::default();
        let mut likeliest = 0.0;
        while let Some(pair) = search.open.pop() {
            likeliest = pair.probability;
            if params.acceptance < 1.0 && pair.probability >= params.acceptance {
                found.overlap = true;
                break;
            }
            if search.tests >= params.max_tests {
                break;
            }
            if search.expand(&pair, [body, other_body]) {
                (found.overlap, likeliest) = (true, 1.0);
                break;
            }
            likeliest = 0.0;
        }
        Ok(PairFindings { probability: Some(likeliest), tests: search.tests, ..found })
    }
}

/// Sorts faces so that each half is on one side, along the longest side of the box.
fn halve(body: PlacedSurface<'_>, faces: &mut [u32], bounds: Bounds) {
    let sides = bounds.sides().to_array();
    let axis = (0..3).max_by(|&i, &j| sides[i].total_cmp(&sides[j])).unwrap_or(0);
    let middle = |face: u32| body.corners(face).iter().map(|p| p[axis]).sum::<f64>();
    faces.select_nth_unstable_by(faces.len() / 2, |&f, &g| {
        middle(f).total_cmp(&middle(g)).then(f.cmp(&g))
    });
}

/// Pieces along a face's edges, at most, of which each counts where its middle is.
const MOST_PIECES: u32 = 16;

/// Share of a box's cells in which faces fill a good part of a cross-section.
fn filled_share(
    body: PlacedSurface<'_>,
    faces: &[u32],
    bounds: Bounds,
    params: &AverageCaseParams,
) -> f64 {
    let n = params.cells;
    let cell = bounds.sides() / f64::from(n);
    let mut area = vec![0.0; (n * n * n) as usize];
    for &face in faces {
        let [a, b, c] = body.corners(face);
        let extent = (b - a).abs().max((c - a).abs()).max((c - b).abs());
        let wanted =
            (extent / cell).to_array().into_iter().filter(|x| x.is_finite()).fold(1.0, f64::max);
        let pieces = place(wanted.ceil(), MOST_PIECES);
        let share = 0.5 * (b - a).cross(c - a).length() / f64::from(pieces * pieces);
        for_each_piece(pieces, |s, t| {
            let from = (a + (b - a) * s + (c - a) * t - bounds.low) / cell;
            let [i, j, k] = from.to_array().map(|x| place(x.floor() + 1.0, n) - 1);
            area[((i * n + j) * n + k) as usize] += share;
        });
    }
    let enough = params.filled * largest_section(cell);
    let filled = area.iter().filter(|area| **area > 0.0 && **area >= enough).count();
    f64::from(index(filled)) / f64::from(n * n * n)
}

/// Area of the plane through two opposite long edges of a box.
fn largest_section(sides: DVec3) -> f64 {
    let longest = sides.max_element();
    let squared = sides.length_squared() - longest * longest;
    longest * squared.max(0.0).sqrt()
}

/// Visits the middles of the pieces of a triangle cut `n` times along its
/// edges, by their weights of the second and the third corner.
fn for_each_piece(n: u32, mut visit: impl FnMut(f64, f64)) {
    let at = |i: u32, third: f64| (f64::from(i) + third) / f64::from(n);
    for i in 0..n {
        for j in 0..n - i {
            visit(at(i, 1.0 / 3.0), at(j, 1.0 / 3.0));
            if i + j + 1 < n {
                visit(at(i, 2.0 / 3.0), at(j, 2.0 / 3.0));
            }
        }
    }
}

/// A whole number brought into `1..=most`; 1 for what is not a number.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within the range")]
fn place(x: f64, most: u32) -> u32 {
    x.max(1.0).min(f64::from(most)) as u32
}

/// A pair of nodes that overlap, and how likely surfaces collide in them.
struct Pair {
    probability: f64,
    nodes: [u32; 2],
}

impl Ord for Pair {
    fn cmp(&self, other: &Self) -> Ordering {
        self.probability.total_cmp(&other.probability).then(other.nodes.cmp(&self.nodes))
    }
}

impl PartialOrd for Pair {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Pair {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Pair {}

/// The pairs still open, the likeliest first.
struct Search<'a> {
    trees: [&'a AverageCaseTree; 2],
    params: &'a AverageCaseParams,
    open: BinaryHeap<Pair>,
    tests: u64,
}

impl Search<'_> {
    /// Tests the boxes of two nodes and keeps the pair if they overlap.
    fn open(&mut self, nodes: [u32; 2]) {
        self.tests += 1;
        let [a, b] = [0, 1].map(|i| &self.trees[i].nodes[nodes[i] as usize]);
        if a.bounds.overlaps(b.bounds) {
            let probability = probability(a, b, self.params.cells);
            self.open.push(Pair { probability, nodes });
        }
    }

    /// Opens what is below a pair; says whether faces in it cross.
    fn expand(&mut self, pair: &Pair, bodies: [PlacedSurface<'_>; 2]) -> bool {
        let below = [0, 1].map(|i| self.trees[i].nodes[pair.nodes[i] as usize].below);
        match below {
            [Below::Nodes(a), Below::Nodes(b)] => {
                for (a, b) in a.into_iter().flat_map(|a| b.map(|b| (a, b))) {
                    self.open([a, b]);
                }
                false
            }
            [Below::Nodes(a), Below::Faces(_)] => {
                a.into_iter().for_each(|a| self.open([a, pair.nodes[1]]));
                false
            }
            [Below::Faces(_), Below::Nodes(b)] => {
                b.into_iter().for_each(|b| self.open([pair.nodes[0], b]));
                false
            }
            [Below::Faces(a), Below::Faces(b)] => self.faces_cross([a, b], bodies),
        }
    }

    fn faces_cross(&mut self, parts: [[u32; 2]; 2], bodies: [PlacedSurface<'_>; 2]) -> bool {
        let [a, b] = [0, 1].map(|i| {
            let [from, to] = parts[i];
            &self.trees[i].faces[from as usize..to as usize]
        });
        let mut pairs = a.iter().flat_map(|f| b.iter().map(move |g| (*f, *g)));
        pairs.any(|(f, g)| {
            self.tests += 1;
            triangles_meet(bodies[0].corners(f), bodies[1].corners(g)) == Meeting::Crossing
        })
    }
}

/// How likely a cell in the overlap of two boxes is filled by both, if filled
/// cells are dealt by chance: one less the chance that `s_B` cells out of `s`
/// miss all `s_A` others, which is hypergeometric.
fn probability(a: &Node, b: &Node, cells: u32) -> f64 {
    let overlap = a.bounds.intersection(b.bounds).sides();
    // Cells of the overlap, of the size of those of the smaller box.
    let cell = a.bounds.sides().min(b.bounds.sides()) / f64::from(cells);
    let along = (overlap / cell).to_array().map(|x| f64::from(place(x.round(), cells)));
    let s: f64 = along.iter().product();
    let (s_a, s_b) = ((a.filled * s).round(), (b.filled * s).round());
    if s_a + s_b > s {
        return 1.0;
    }
    let (few, many) = (s_a.min(s_b), s_a.max(s_b));
    let mut miss = 1.0;
    let mut dealt = 0.0;
    while dealt < few {
        miss *= (s - many - dealt) / (s - dealt);
        dealt += 1.0;
    }
    1.0 - miss
}

#[cfg(test)]
mod tests {
    use super::{AverageCaseParams, AverageCaseTree, Below, PlacedSurface};

    #[test]
    fn each_face_is_in_one_leaf_and_its_boxes() {
        let mesh = fixtures::shapes::octasphere(1.0, 3);
        let surface = mesh.surface();
        let x = surface.positions(&mesh.positions).expect("finite");
        let body = PlacedSurface { surface: &surface, x };
        let tree =
            AverageCaseTree::new(body, &AverageCaseParams::DEFAULT).expect("valid parameters");
        let mut found = Vec::new();
        for node in &tree.nodes {
            if let Below::Faces([from, to]) = node.below {
                found.extend_from_slice(&tree.faces[from as usize..to as usize]);
            }
            let inner = match node.below {
                Below::Nodes(nodes) => nodes.map(|n| tree.nodes[n as usize].bounds).to_vec(),
                Below::Faces([from, to]) => tree.faces[from as usize..to as usize]
                    .iter()
                    .map(|f| crate::boxes::Bounds::of(&body.corners(*f)))
                    .collect(),
            };
            assert!(
                inner.iter().all(|b| b.union(node.bounds) == node.bounds),
                "a box is too small"
            );
            assert!((0.0..=1.0).contains(&node.filled), "a share");
        }
        found.sort_unstable();
        assert!(found.iter().copied().eq(0..body.face_count()), "all faces once");
    }
}
