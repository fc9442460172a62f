//! Separate contact regions: connected parts of the border of what two bodies share.
//!
//! Passings are joined along stretches of the curve, and along the parts of edges that lie inside, to
//! each other and to the clusters of inside vertices. Each region has an origin of its own near it,
//! so that its measures have the rounding of its own size and not of its place.

use std::cmp::Ordering;

use glam::DVec3;
use proximity::SurfaceTree;
use surface::UnionFind;

use crate::curve::{Curve, edge_ends, index};
use crate::cut_edges::CutEdge;
use crate::inside::Inside;

/// Stands for a region that is not reported: a touch in points.
pub(crate) const NO_REGION: u32 = u32::MAX;

/// Regions of one pair of bodies.
#[derive(Debug, Default)]
pub(crate) struct Regions {
    /// Inside parts of the cut edges of A and of B, run from the lower-numbered end.
    edge_parts: [Vec<EdgePart>; 2],
    /// One per cut edge of A and of B, and one more: where its inside parts begin.
    part_starts: [Vec<u32>; 2],
    /// One per region: a point near it.
    pub(crate) origins: Vec<DVec3>,
    /// One per passing: its position from its region's origin.
    pub(crate) points: Vec<DVec3>,
    /// One per region, and one more: its place in [`Overlap::regions`](crate::Overlap::regions),
    /// or [`NO_REGION`].
    pub(crate) reported: Vec<u32>,
    /// One per node: passings, then clusters of inside vertices of A, then of B.
    region_of: Vec<u32>,
    /// Number of the first cluster of A, and of B, among the nodes.
    first_cluster: [usize; 2],
    sets: UnionFind,
    entering: Vec<(f64, Node)>,
    leaving: Vec<(f64, Node)>,
    /// Points along an edge, with the change of the winding number at passings.
    along: Vec<(f64, Node, i32)>,
}

/// A part of an edge inside the other body.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EdgePart {
    pub(crate) from: Node,
    pub(crate) to: Node,
}

/// A corner of what two bodies share, as one of them has it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Node {
    /// A passing.
    Passing(u32),
    /// A vertex inside the other body.
    Vertex(u32),
}

impl Regions {
    /// Joins everything into regions, in place of those found before.
    pub(crate) fn find(&mut self, bodies: [&SurfaceTree; 2], curve: &Curve, inside: &[Inside; 2]) {
        let passings = curve.passings.len();
        self.first_cluster = [passings, passings + inside[0].cluster_starts.len()];
        let nodes = self.first_cluster[1] + inside[1].cluster_starts.len();
        self.sets.reset(nodes);

        // The curve joins its passings, edges join these to the vertices they lead to.
        for stretch in &curve.stretches {
            self.sets.join(stretch.ends[0], stretch.ends[1]);
        }
        for side in 0..2 {
            self.edge_parts[side].clear();
            self.part_starts[side].clear();
            self.part_starts[side].push(0);
            for cut in curve.cut_edges[side].as_slice() {
                let ends = bodies[side].surface().edges()[cut.edge as usize];
                self.join_along_edge(side, cut, ends, curve, &inside[side]);
                self.part_starts[side].push(index(self.edge_parts[side].len()));
            }
        }

        self.number_regions(nodes, bodies, curve, inside);
        self.place_passings(bodies, curve);
    }

    /// Returns the region of a passing.
    pub(crate) fn of_passing(&self, passing: u32) -> usize {
        self.region_of[passing as usize] as usize
    }

    /// Returns the region of a cluster of inside vertices.
    pub(crate) fn of_cluster(&self, side: usize, cluster: u32) -> usize {
        self.region_of[self.first_cluster[side] + cluster as usize] as usize
    }

    /// Returns the place among the reported regions of a node of body `side`.
    pub(crate) fn reported(&self, side: usize, node: Node, inside: &Inside) -> u32 {
        let node = self.number(side, node, inside) as usize;
        self.reported[self.region_of[node] as usize]
    }

    /// Returns the position of a passing.
    pub(crate) fn position(&self, passing: u32) -> DVec3 {
        self.origins[self.of_passing(passing)] + self.points[passing as usize]
    }

    /// Returns the inside parts of a cut edge, by its place among those of its body.
    pub(crate) fn parts_of(&self, side: usize, cut: usize) -> &[EdgePart] {
        let starts = &self.part_starts[side];
        &self.edge_parts[side][starts[cut] as usize..starts[cut + 1] as usize]
    }

    /// Pairs the passings of an edge to its inside parts and joins the ends of each.
    ///
    /// Entering and leaving points are sorted apart and paired by rank, so that rounding in their
    /// places cannot leave one unpaired.
    fn join_along_edge(
        &mut self,
        side: usize,
        cut: &CutEdge,
        [low, high]: [u32; 2],
        curve: &Curve,
        inside: &Inside,
    ) {
        // A lower end that is inside comes first, an upper one last.
        self.entering.clear();
        self.leaving.clear();
        if inside.winding(low) != 0 {
            self.entering.push((f64::NEG_INFINITY, Node::Vertex(low)));
        }
        if inside.winding(high) != 0 {
            self.leaving.push((f64::INFINITY, Node::Vertex(high)));
        }
        for number in cut.passings.clone() {
            let passing = &curve.passings[number as usize];
            let end = (passing.share, Node::Passing(number));
            if passing.enters { self.entering.push(end) } else { self.leaving.push(end) }
        }
        self.entering.sort_by(by_share);
        self.leaving.sort_by(by_share);

        // The i-th entering point begins the i-th inside part.
        for (&(_, from), &(_, to)) in self.entering.iter().zip(&self.leaving) {
            self.edge_parts[side].push(EdgePart { from, to });
            let from = self.number(side, from, inside);
            let to = self.number(side, to, inside);
            self.sets.join(from, to);
        }
        if inside.covers_twice {
            self.join_covered(side, inside, low);
        }
    }

    /// Joins consecutive points of an edge with a winding number other than 0 between them.
    ///
    /// Ranks pair points where the other body covers a place once. Where it is inside out or covers
    /// a place twice, both ends of an inside part may enter, and one may begin several parts.
    fn join_covered(&mut self, side: usize, inside: &Inside, low: u32) {
        let entering = self.entering.iter().map(|&(share, node)| (share, node, 1));
        let leaving = self.leaving.iter().map(|&(share, node)| (share, node, -1));
        let mut along = std::mem::take(&mut self.along);
        along.clear();
        along.extend(entering.chain(leaving));
        along.sort_by(|p, q| p.0.total_cmp(&q.0));

        let mut winding = inside.winding(low);
        for pair in along.windows(2) {
            let [(_, from, change), (_, to, _)] = [pair[0], pair[1]];
            if matches!(from, Node::Passing(_)) {
                winding += change;
            }
            if winding != 0 {
                let from = self.number(side, from, inside);
                let to = self.number(side, to, inside);
                self.sets.join(from, to);
            }
        }
        self.along = along;
    }

    fn number(&self, side: usize, node: Node, inside: &Inside) -> u32 {
        match node {
            Node::Passing(passing) => passing,
            Node::Vertex(vertex) => {
                index(self.first_cluster[side]) + inside.cluster(vertex).unwrap_or(0)
            }
        }
    }

    /// Numbers the regions by their first node, and takes a corner there as origin.
    fn number_regions(
        &mut self,
        nodes: usize,
        bodies: [&SurfaceTree; 2],
        curve: &Curve,
        inside: &[Inside; 2],
    ) {
        self.origins.clear();
        self.region_of.clear();

        for node in 0..index(nodes) {
            let root = self.sets.find(node) as usize;
            let region = if root == node as usize {
                self.origins.push(self.corner_at(root, bodies, curve, inside));
                index(self.origins.len() - 1)
            } else {
                self.region_of[root]
            };
            self.region_of.push(region);
        }
    }

    /// Returns a vertex at a node: itself, or the lower-numbered end of a passing's edge.
    fn corner_at(
        &self,
        node: usize,
        bodies: [&SurfaceTree; 2],
        curve: &Curve,
        inside: &[Inside; 2],
    ) -> DVec3 {
        if node < self.first_cluster[0] {
            let name = curve.passings[node].name;
            let body = bodies[usize::from(name.side)];
            let [low, _] = body.surface().edges()[name.edge as usize];
            return body.position(low);
        }
        let side = usize::from(node >= self.first_cluster[1]);
        let vertex = inside[side].cluster_starts[node - self.first_cluster[side]];
        bodies[side].position(vertex)
    }

    /// Computes the position of each passing, once for all of its faces.
    fn place_passings(&mut self, bodies: [&SurfaceTree; 2], curve: &Curve) {
        self.points.clear();
        for (number, passing) in (0..).zip(&curve.passings) {
            let body = bodies[usize::from(passing.name.side)];
            let [low, high] = edge_ends(body, passing.name.edge);
            let origin = self.origins[self.of_passing(number)];
            // An end itself is met exactly, so that a corner that rests on a face is one point.
            let point = if passing.share < 1.0 {
                (low - origin) + passing.share * (high - low)
            } else {
                high - origin
            };
            self.points.push(point);
        }
    }
}

/// Orders the passings of an edge.
fn by_share(p: &(f64, Node), q: &(f64, Node)) -> Ordering {
    p.0.total_cmp(&q.0)
}
