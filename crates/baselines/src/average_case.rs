//! Average-case collision detection: probability of an overlap, from trees of boxes.
//!
//! Each node of a tree of boxes keeps the share of the cells of its box that the surface fills.
//! Where two boxes overlap, these shares give the expected number of filled cells in the overlap
//! for each surface, and, if filled cells are distributed at random, the probability that both
//! fill some cell. The most probable pair is expanded first (best-first search). The search ends
//! when a pair is probable enough, when no pair is left, or when the budget is spent.
//!
//! Source: J. Klein and G. Zachmann, "ADB-Trees: controlling the error of time-critical collision
//! detection", VMV 2003, and "Time-critical collision detection using an average-case approach",
//! VRST 2003. Here leaves are tested exactly, so that an acceptance of 1 without a budget gives the
//! exact answer.
//!
//! The method reports an overlap, but neither vertices nor depths.
//!
//! # Example
//!
//! ```
//! use baselines::average_case::{AverageCaseParams, AverageCaseTree};
//! use baselines::{PlacedSurface, glam::DVec3};
//! use surface::TriangleSurface;
//!
//! let faces = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
//! let surface = TriangleSurface::new(4, faces)?;
//! let first = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
//! let second = first.map(|x| x + DVec3::splat(0.2));
//! let a = PlacedSurface { surface: &surface, x: surface.positions(&first)? };
//! let b = PlacedSurface { surface: &surface, x: surface.positions(&second)? };
//!
//! let params = AverageCaseParams { acceptance: 1.0, ..AverageCaseParams::DEFAULT };
//! let (tree_a, tree_b) = (AverageCaseTree::new(a, &params)?, AverageCaseTree::new(b, &params)?);
//! assert!(tree_a.detect(a, &tree_b, b, &params)?.overlap);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::ops::Range;

use glam::DVec3;
use surface::{Aabb, Meeting, TotalF64, triangle, triangles_meet};

use crate::error::{BaselineError, check, check_share};
use crate::findings::{PairFindings, PlacedSurface, clamp_cell, clamp_count, index};

/// Parameters of the trees and of the search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AverageCaseParams {
    /// Cells along each side of a node's box, in `1..=16`.
    pub cells: u32,
    /// Share of a cell's largest cross-section that the surface must cover for the cell to count
    /// as filled, above 0 and at most 1.
    pub filled: f64,
    /// Probability from which on an overlap is reported, above 0 and at most 1. With 1, only
    /// crossing faces count.
    pub acceptance: f64,
    /// Maximum number of tests of nodes and of faces. When they are spent, no overlap is reported,
    /// and [`PairFindings::probability`] is that of the most probable pair left.
    pub max_tests: u64,
}

impl AverageCaseParams {
    /// 8 cells per side, half filled, probability 0.9.
    pub const DEFAULT: Self = Self { cells: 8, filled: 0.5, acceptance: 0.9, max_tests: u64::MAX };

    /// Checks that all parameters are in range.
    ///
    /// # Errors
    ///
    /// Names the first parameter out of range.
    pub fn validate(&self) -> Result<(), BaselineError> {
        check("cells", self.cells.into(), (1..=16).contains(&self.cells), "in 1..=16")?;
        check_share("filled", self.filled)?;
        check_share("acceptance", self.acceptance)
    }
}

/// Maximum number of faces in a leaf.
const LEAF: usize = 4;

/// Binary tree of boxes over the faces of a surface, with shares of filled cells.
#[derive(Clone, Debug)]
pub struct AverageCaseTree {
    nodes: Vec<Node>,
    /// Faces in the order of the leaves.
    faces: Vec<u32>,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    bounds: Aabb,
    /// Share of the cells of the box that are filled.
    filled: f64,
    children: Children,
}

#[derive(Clone, Copy, Debug)]
enum Children {
    /// Numbers of two nodes.
    Nodes([u32; 2]),
    /// Start and end of a range in the list of faces.
    Faces([u32; 2]),
}

impl AverageCaseTree {
    /// Builds the tree of a surface; it is valid for these positions only.
    ///
    /// # Errors
    ///
    /// When a parameter is out of range.
    pub fn new(body: PlacedSurface<'_>, params: &AverageCaseParams) -> Result<Self, BaselineError> {
        params.validate()?;
        let mut tree = Self { nodes: Vec::new(), faces: (0..body.face_count()).collect() };
        if !tree.faces.is_empty() {
            tree.build(body, params, 0..body.surface.faces().len());
        }
        Ok(tree)
    }

    /// Builds the node over a range of the faces, with all nodes below; returns its number.
    fn build(
        &mut self,
        body: PlacedSurface<'_>,
        params: &AverageCaseParams,
        range: Range<usize>,
    ) -> u32 {
        let faces = &mut self.faces[range.clone()];
        let mut bounds = Aabb::EMPTY;
        for &face in &*faces {
            bounds = bounds.union(body.face_bounds(face));
        }
        let filled = filled_share(body, faces, bounds, params);
        let node = self.nodes.len();
        let children = Children::Faces([index(range.start), index(range.end)]);
        self.nodes.push(Node { bounds, filled, children });

        // Half of the faces below each child.
        if range.len() > LEAF {
            partition_at_median(body, faces, bounds);
            let middle = range.start + range.len() / 2;
            let first = self.build(body, params, range.start..middle);
            let second = self.build(body, params, middle..range.end);
            self.nodes[node].children = Children::Nodes([first, second]);
        }
        index(node)
    }

    /// Detects an overlap of two surfaces by their trees.
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
        params.validate()?;
        let mut search = Search {
            trees: [self, other],
            bodies: [body, other_body],
            params,
            open: BinaryHeap::new(),
            tests: 0,
        };
        if !(self.nodes.is_empty() || other.nodes.is_empty()) {
            search.open([0, 0]);
        }
        let (overlap, probability) = search.run();
        let tests = search.tests;
        Ok(PairFindings { overlap, probability: Some(probability), tests, ..Default::default() })
    }
}

/// Partitions faces at the median along the longest side of their box.
fn partition_at_median(body: PlacedSurface<'_>, faces: &mut [u32], bounds: Aabb) {
    let sides = bounds.sides().to_array();
    let axis = (0..3).max_by(|&i, &j| sides[i].total_cmp(&sides[j])).unwrap_or(0);
    let center = |face: u32| body.corners(face).iter().map(|p| p[axis]).sum::<f64>();
    faces.select_nth_unstable_by(faces.len() / 2, |&f, &g| {
        center(f).total_cmp(&center(g)).then(f.cmp(&g))
    });
}

/// Maximum number of pieces along a face's edges, which are assigned to cells by their centers.
const MAX_PIECES: u32 = 16;

/// Computes the share of a box's cells that faces fill.
fn filled_share(
    body: PlacedSurface<'_>,
    faces: &[u32],
    bounds: Aabb,
    params: &AverageCaseParams,
) -> f64 {
    let n = params.cells;
    let cell = bounds.sides() / f64::from(n);

    // Area per cell, by faces cut into pieces about as large as a cell.
    let mut areas = vec![0.0; (n * n * n) as usize];
    for &face in faces {
        let corners = body.corners(face);
        let [a, b, c] = corners;
        let extent = (b - a).abs().max((c - a).abs()).max((c - b).abs());
        // A flat box has cells without height, and counts none of them.
        let mut in_cells = 1.0_f64;
        for x in (extent / cell).to_array() {
            in_cells = if x.is_finite() { in_cells.max(x) } else { in_cells };
        }
        let pieces = clamp_count(in_cells.ceil(), MAX_PIECES);
        let area = triangle::area(corners) / f64::from(pieces * pieces);
        for_each_piece(pieces, |s, t| {
            let from_corner = (a + (b - a) * s + (c - a) * t - bounds.min) / cell;
            let [i, j, k] = from_corner.to_array().map(|x| clamp_cell(x, n));
            areas[((i * n + j) * n + k) as usize] += area;
        });
    }

    // A cell is filled if its area is a good part of its largest cross-section.
    let enough = params.filled * largest_section(cell);
    let filled = areas.iter().filter(|area| **area > 0.0 && **area >= enough).count();
    f64::from(index(filled)) / f64::from(n * n * n)
}

/// Computes the area of the plane through two opposite long edges of a box.
fn largest_section(sides: DVec3) -> f64 {
    let longest = sides.max_element();
    let squared = sides.length_squared() - longest * longest;
    longest * squared.max(0.0).sqrt()
}

/// Visits the centers of the pieces of a triangle cut `n` times along its edges, by their weights
/// of the second and the third corner.
fn for_each_piece(n: u32, mut visit: impl FnMut(f64, f64)) {
    let weight = |i: u32, third: f64| (f64::from(i) + third) / f64::from(n);
    for i in 0..n {
        for j in 0..n - i {
            visit(weight(i, 1.0 / 3.0), weight(j, 1.0 / 3.0));
            if i + j + 1 < n {
                visit(weight(i, 2.0 / 3.0), weight(j, 2.0 / 3.0));
            }
        }
    }
}

/// Two nodes that overlap, ordered by the probability of an overlap of their surfaces.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct NodePair {
    probability: TotalF64,
    nodes: Reverse<[u32; 2]>,
}

/// Best-first search over pairs of nodes.
struct Search<'a> {
    trees: [&'a AverageCaseTree; 2],
    bodies: [PlacedSurface<'a>; 2],
    params: &'a AverageCaseParams,
    open: BinaryHeap<NodePair>,
    tests: u64,
}

impl Search<'_> {
    /// Searches for an overlap; returns it with its probability.
    fn run(&mut self) -> (bool, f64) {
        let AverageCaseParams { acceptance, max_tests, .. } = *self.params;
        while let Some(NodePair { probability, nodes }) = self.open.pop() {
            let is_accepted = acceptance < 1.0 && probability.0 >= acceptance;
            if is_accepted || self.tests >= max_tests {
                return (is_accepted, probability.0);
            }
            if self.expand(nodes.0) {
                return (true, 1.0);
            }
        }
        (false, 0.0)
    }

    fn nodes(&self, [a, b]: [u32; 2]) -> [&Node; 2] {
        [&self.trees[0].nodes[a as usize], &self.trees[1].nodes[b as usize]]
    }

    /// Tests the boxes of two nodes, and keeps the pair if they overlap.
    fn open(&mut self, nodes: [u32; 2]) {
        self.tests += 1;
        let [a, b] = self.nodes(nodes);
        if a.bounds.overlaps(b.bounds) {
            let probability = TotalF64(probability(a, b, self.params.cells));
            self.open.push(NodePair { probability, nodes: Reverse(nodes) });
        }
    }

    /// Opens the children of a pair; returns true if faces in it cross.
    fn expand(&mut self, nodes: [u32; 2]) -> bool {
        let [first, second] = nodes;
        let (firsts, seconds) = match self.nodes(nodes).map(|node| node.children) {
            [Children::Faces(a), Children::Faces(b)] => return self.faces_cross([a, b]),
            [Children::Nodes(a), Children::Nodes(b)] => (a.to_vec(), b.to_vec()),
            [Children::Nodes(a), Children::Faces(_)] => (a.to_vec(), vec![second]),
            [Children::Faces(_), Children::Nodes(b)] => (vec![first], b.to_vec()),
        };
        for a in firsts {
            for &b in &seconds {
                self.open([a, b]);
            }
        }
        false
    }

    fn faces_cross(&mut self, ranges: [[u32; 2]; 2]) -> bool {
        let [first, second] = [0, 1].map(|i| {
            let [start, end] = ranges[i];
            &self.trees[i].faces[start as usize..end as usize]
        });
        for &f in first {
            for &g in second {
                self.tests += 1;
                let corners = [self.bodies[0].corners(f), self.bodies[1].corners(g)];
                if triangles_meet(corners[0], corners[1]) == Meeting::Crossing {
                    return true;
                }
            }
        }
        false
    }
}

/// Computes the probability that both surfaces fill a cell in the overlap of two boxes, if filled
/// cells are distributed at random.
///
/// It is 1 less the probability that `s_B` of `s` cells are none of `s_A` others, which is
/// hypergeometric.
fn probability(a: &Node, b: &Node, cells: u32) -> f64 {
    // Cells of the overlap, of the size of those of the smaller box.
    let overlap = a.bounds.intersection(b.bounds).sides();
    let cell = a.bounds.sides().min(b.bounds.sides()) / f64::from(cells);
    let counts = (overlap / cell).to_array().map(|x| f64::from(clamp_count(x.round(), cells)));
    let s: f64 = counts.iter().product();

    let (s_a, s_b) = ((a.filled * s).round(), (b.filled * s).round());
    if s_a + s_b > s {
        return 1.0;
    }
    // The product of the probabilities that each drawn cell is none of the others.
    let (few, many) = (s_a.min(s_b), s_a.max(s_b));
    let (mut none_common, mut drawn) = (1.0, 0.0);
    while drawn < few {
        none_common *= (s - many - drawn) / (s - drawn);
        drawn += 1.0;
    }
    1.0 - none_common
}

#[cfg(test)]
mod tests {
    use super::{Aabb, AverageCaseParams, AverageCaseTree, Children, PlacedSurface};

    #[test]
    fn each_face_is_in_one_leaf_and_its_boxes() {
        let mesh = fixtures::shapes::octasphere(1.0, 3);
        let surface = mesh.surface();
        let x = surface.positions(&mesh.positions).expect("finite");
        let body = PlacedSurface { surface: &surface, x };
        let tree = AverageCaseTree::new(body, &AverageCaseParams::DEFAULT).expect("valid");

        let mut found = Vec::new();
        for node in &tree.nodes {
            let inner: Vec<Aabb> = match node.children {
                Children::Nodes(nodes) => {
                    nodes.iter().map(|n| tree.nodes[*n as usize].bounds).collect()
                }
                Children::Faces([start, end]) => {
                    let faces = &tree.faces[start as usize..end as usize];
                    found.extend_from_slice(faces);
                    faces.iter().map(|face| body.face_bounds(*face)).collect()
                }
            };
            let is_outer = inner.iter().all(|bounds| bounds.union(node.bounds) == node.bounds);
            assert!(is_outer, "a box is too small");
            assert!((0.0..=1.0).contains(&node.filled), "a share");
        }
        found.sort_unstable();
        assert!(found.iter().copied().eq(0..body.face_count()), "all faces once");
    }
}
