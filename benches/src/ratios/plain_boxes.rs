//! Plain binary tree of boxes: the reference of k-DOP trees that needs no other library.
//!
//! One triangle per leaf, split at the median of centers along the longest axis, in single precision
//! as the k-DOP trees. Parents stand before their children, so that a refit is one sweep from the
//! end. Nothing is vectorized by hand: what k-DOPs are to gain is measured against such a tree.

use std::ops::Range;

use glam::{DVec3, Vec3};

use super::other_tree::OtherTree;

/// Box of a triangle or of all below a node.
#[derive(Clone, Copy)]
struct PlainBox {
    min: Vec3,
    max: Vec3,
}

impl PlainBox {
    fn of(points: &[Vec3], triangle: [u32; 3]) -> Self {
        let [a, b, c] = triangle.map(|i| points[i as usize]);
        Self { min: a.min(b).min(c), max: a.max(b).max(c) }
    }

    fn merged(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    fn intersects(&self, other: &Self) -> bool {
        self.min.cmple(other.max).all() && other.min.cmple(self.max).all()
    }

    /// Returns twice the center.
    fn center(&self) -> Vec3 {
        self.min + self.max
    }
}

/// Contents of a node.
#[derive(Clone, Copy)]
enum Below {
    Triangle(u32),
    Children([u32; 2]),
}

#[derive(Clone, Copy)]
struct Node {
    bounds: PlainBox,
    below: Below,
}

/// Binary tree of boxes over triangles.
pub(super) struct PlainTree {
    nodes: Vec<Node>,
    triangles: Vec<[u32; 3]>,
    /// Pairs of nodes that a traversal has yet to visit.
    stack: Vec<[u32; 2]>,
}

impl PlainTree {
    /// Adds the node of a range of `order`, and all below it; returns its number.
    fn add(&mut self, boxes: &[PlainBox], order: &mut [u32], range: Range<usize>) -> u32 {
        let number = u32::try_from(self.nodes.len()).expect("fewer than 2^31 triangles");
        let items = &mut order[range.clone()];
        let first = items[0];
        self.nodes.push(Node { bounds: boxes[first as usize], below: Below::Triangle(first) });
        if items.len() == 1 {
            return number;
        }

        // The longest axis of the box of centers.
        let (mut min, mut max) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for &item in items.iter() {
            let center = boxes[item as usize].center();
            (min, max) = (min.min(center), max.max(center));
        }
        let axis = (max - min).max_position();
        let along = |item: &u32| boxes[*item as usize].center()[axis];
        let half = items.len() / 2;
        items.select_nth_unstable_by(half, |i, j| along(i).total_cmp(&along(j)));

        let middle = range.start + half;
        let children =
            [range.start..middle, middle..range.end].map(|part| self.add(boxes, order, part));
        let [a, b] = children.map(|child| self.nodes[child as usize].bounds);
        self.nodes[number as usize] =
            Node { bounds: a.merged(b), below: Below::Children(children) };
        number
    }

    fn refit_to(&mut self, bounds: impl Fn([u32; 3]) -> PlainBox) -> usize {
        for number in (0..self.nodes.len()).rev() {
            self.nodes[number].bounds = match self.nodes[number].below {
                Below::Triangle(triangle) => bounds(self.triangles[triangle as usize]),
                Below::Children(children) => {
                    let [a, b] = children.map(|child| self.nodes[child as usize].bounds);
                    a.merged(b)
                }
            };
        }
        self.triangles.len()
    }
}

impl OtherTree for PlainTree {
    const NAME: &'static str = "plain boxes";

    type Point = Vec3;

    fn points(points: &[DVec3]) -> Vec<Vec3> {
        points.iter().map(|p| p.as_vec3()).collect()
    }

    fn build(triangles: &[[u32; 3]], points: &[Vec3]) -> Self {
        let boxes: Vec<PlainBox> = triangles.iter().map(|&t| PlainBox::of(points, t)).collect();
        let mut order: Vec<u32> = (0..).take(boxes.len()).collect();
        let nodes = Vec::with_capacity(2 * boxes.len());
        let mut tree = Self { nodes, triangles: triangles.to_vec(), stack: Vec::new() };
        tree.add(&boxes, &mut order, 0..boxes.len());
        tree
    }

    fn leaf_count(&self) -> usize {
        self.triangles.len()
    }

    fn refit(&mut self, points: &[Vec3]) -> usize {
        self.refit_to(|t| PlainBox::of(points, t))
    }

    fn refit_swept(&mut self, [x0, x1]: [&[Vec3]; 2]) -> usize {
        self.refit_to(|t| PlainBox::of(x0, t).merged(PlainBox::of(x1, t)))
    }

    fn pairs(&mut self, other: &Self, out: &mut Vec<(u32, u32)>) -> usize {
        out.clear();
        self.stack.clear();
        self.stack.push([0, 0]);
        while let Some([i, j]) = self.stack.pop() {
            let (a, b) = (&self.nodes[i as usize], &other.nodes[j as usize]);
            if !a.bounds.intersects(&b.bounds) {
                continue;
            }
            match (a.below, b.below) {
                (Below::Triangle(a), Below::Triangle(b)) => out.push((a, b)),
                (of_a, of_b) => descend(&mut self.stack, [i, j], [of_a, of_b]),
            }
        }
        out.len()
    }

    fn self_pairs(&mut self, out: &mut Vec<(u32, u32)>) -> usize {
        out.clear();
        self.stack.clear();
        self.stack.push([0, 0]);
        while let Some([i, j]) = self.stack.pop() {
            let (a, b) = (&self.nodes[i as usize], &self.nodes[j as usize]);
            match (a.below, b.below) {
                (Below::Children([p, q]), _) if i == j => {
                    self.stack.extend([[p, p], [q, q], [p, q]]);
                }
                _ if i == j || !a.bounds.intersects(&b.bounds) => {}
                (Below::Triangle(a), Below::Triangle(b)) => {
                    let [of_a, of_b] = [a, b].map(|t| self.triangles[t as usize]);
                    if !of_a.iter().any(|p| of_b.contains(p)) {
                        out.push((a, b));
                    }
                }
                (of_a, of_b) => descend(&mut self.stack, [i, j], [of_a, of_b]),
            }
        }
        out.len()
    }
}

/// Puts the pairs of nodes below a pair on the stack; a triangle stands for itself.
fn descend(stack: &mut Vec<[u32; 2]>, [i, j]: [u32; 2], below: [Below; 2]) {
    match below {
        [Below::Children(of_a), Below::Children(of_b)] => {
            for child in of_a {
                stack.extend(of_b.map(|other| [child, other]));
            }
        }
        [Below::Children(of_a), Below::Triangle(_)] => stack.extend(of_a.map(|child| [child, j])),
        [Below::Triangle(_), Below::Children(of_b)] => stack.extend(of_b.map(|child| [i, child])),
        [Below::Triangle(_), Below::Triangle(_)] => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fixtures::muscle::{Placement, scene};

    /// Returns all pairs of triangles whose boxes meet, by trying each.
    fn meeting(a: &[PlainBox], b: &[PlainBox]) -> Vec<(u32, u32)> {
        let mut pairs = Vec::new();
        for (i, a) in (0..).zip(a) {
            for (j, b) in (0..).zip(b) {
                if a.intersects(b) {
                    pairs.push((i, j));
                }
            }
        }
        pairs
    }

    #[test]
    fn traversals_find_the_pairs_that_meet() {
        let muscles = scene(600, Placement::Oblique);
        let mut trees = [&muscles.a, &muscles.b].map(|muscle| {
            let [x0, x1] = [0, 1].map(|state| PlainTree::points(&muscle.states[state]));
            let mut tree = PlainTree::build(&muscle.triangles, &x0);
            tree.refit(&x1);
            let boxes: Vec<PlainBox> =
                muscle.triangles.iter().map(|&t| PlainBox::of(&x1, t)).collect();
            (tree, boxes)
        });
        let mut found = Vec::new();
        let [(a, of_a), (b, of_b)] = &mut trees;
        a.pairs(b, &mut found);
        found.sort_unstable();
        assert_eq!(found, meeting(of_a, of_b));
        assert!(!found.is_empty());

        // Within one muscle: each pair once, without those that share a vertex.
        a.self_pairs(&mut found);
        for pair in &mut found {
            *pair = (pair.0.min(pair.1), pair.0.max(pair.1));
        }
        found.sort_unstable();
        let mut expected = meeting(of_a, of_a);
        expected.retain(|&(i, j)| {
            let [p, q] = [i, j].map(|t| a.triangles[t as usize]);
            i < j && !p.iter().any(|vertex| q.contains(vertex))
        });
        assert_eq!(found, expected);
    }
}
