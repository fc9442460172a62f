//! Order of the edge collapses, cheapest first.
//!
//! A heap holds, per vertex, the cheapest neighbor that it may move into. A collapse changes
//! the costs of the vertices around it: they are offered again, and the version of an offer
//! tells it from older ones.
//!
//! Cost is the larger of two squared lengths: the quadric error, by which a vertex chooses the neighbor,
//! and the deviation: the largest distance of a removed vertex from the faces around it. By the latter
//! the surface comes out evenly coarse, with half as many faces within a deviation on muscles and
//! bones as by the quadric error alone.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use glam::DVec3;
use surface::TotalF64;
use surface::progress::{Interrupted, Progress};

use crate::mesh::Mesh;
use crate::quadric::{Quadric, quadrics};

/// Half-edge collapse: a vertex that moves into a neighbor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Collapse {
    pub(crate) vertex: u32,
    pub(crate) into: u32,
}

/// Offers and collapses between two reports of progress: about a millisecond of work.
const REPORT_EVERY: usize = 256;

/// Collapses in their order, and how far each prefix goes.
#[derive(Clone, Debug)]
pub(crate) struct Collapses {
    pub(crate) list: Vec<Collapse>,
    /// Per collapse, the largest cost so far: never less than the squared distance of a removed
    /// vertex from faces near it.
    max_costs: Vec<f64>,
}

impl Collapses {
    /// Finds all collapses that cost no more and that topology and shape allow, cheapest first.
    pub(crate) fn find(
        faces: &[[u32; 3]],
        x: &[DVec3],
        max_cost: f64,
        progress: Progress<'_>,
    ) -> Result<Self, Interrupted> {
        // Every vertex offers one collapse, and most of them make it.
        let steps = progress.steps(2 * x.len() / REPORT_EVERY);
        let mut order = Order::new(faces, x);
        for vertex in (0_u32..).take(x.len()) {
            order.offer(vertex);
            if (vertex as usize).is_multiple_of(REPORT_EVERY) {
                steps.advance(1)?;
            }
        }

        let mut collapses = Self { list: Vec::with_capacity(faces.len() / 2), max_costs: vec![] };
        let mut highest: f64 = 0.0;
        while let Some((collapse, cost)) = order.next(max_cost) {
            highest = highest.max(cost);
            collapses.list.push(collapse);
            collapses.max_costs.push(highest);
            if collapses.list.len().is_multiple_of(REPORT_EVERY) {
                steps.advance(1)?;
            }
        }
        Ok(collapses)
    }

    /// Returns the longest prefix of collapses that cost no more.
    pub(crate) fn within(&self, max_cost: f64) -> &[Collapse] {
        &self.list[..self.max_costs.partition_point(|&cost| cost <= max_cost)]
    }
}

/// Collapse that a vertex may make at present. Equal costs are ordered by vertex numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Offer {
    cost: TotalF64,
    collapse: Collapse,
    version: u32,
    /// True if the deviation is in the cost.
    is_measured: bool,
}

/// Search state.
#[derive(Clone)]
pub(crate) struct Order<'a> {
    mesh: Mesh<'a>,
    x: &'a [DVec3],
    quadrics: Vec<Quadric>,
    /// Point that quadrics are relative to.
    origin: DVec3,
    offers: BinaryHeap<Reverse<Offer>>,
    /// Per vertex, the number of its last offer.
    versions: Vec<u32>,
    /// Per vertex, true if it stays.
    stays: Vec<bool>,
    choices: Vec<Offer>,
}

impl<'a> Order<'a> {
    pub(crate) fn new(faces: &[[u32; 3]], x: &'a [DVec3]) -> Self {
        let origin = x.first().copied().unwrap_or_default();
        Self {
            mesh: Mesh::new(faces, x),
            x,
            quadrics: quadrics(faces, x, origin),
            origin,
            offers: BinaryHeap::with_capacity(x.len()),
            versions: vec![0; x.len()],
            stays: vec![false; x.len()],
            choices: Vec::new(),
        }
    }

    /// Performs collapses that were found before.
    pub(crate) fn repeat(&mut self, collapses: &[Collapse]) {
        for &Collapse { vertex, into } in collapses {
            self.mesh.collapse(vertex, into);
            let moved = self.quadrics[vertex as usize];
            self.quadrics[into as usize] += moved;
        }
    }

    /// Keeps the faces around a vertex as they are.
    pub(crate) fn keep_around(&mut self, vertex: u32) {
        self.stays[vertex as usize] = true;
        for neighbor in self.mesh.neighbors(vertex) {
            self.stays[neighbor as usize] = true;
        }
    }

    /// Appends all collapses that cost no more and that are allowed now, cheapest first.
    pub(crate) fn append(&mut self, vertices: &[u32], max_cost: f64, out: &mut Vec<Collapse>) {
        for &vertex in vertices {
            self.offer(vertex);
        }
        while let Some((collapse, _)) = self.next(max_cost) {
            out.push(collapse);
        }
    }

    /// Performs the cheapest collapse that is allowed and costs no more, and returns it with its
    /// cost.
    fn next(&mut self, max_cost: f64) -> Option<(Collapse, f64)> {
        while let Some(Reverse(offer)) = self.offers.pop() {
            let Offer { cost: TotalF64(cost), collapse, version, is_measured } = offer;
            let Collapse { vertex, into } = collapse;
            if cost > max_cost {
                return None;
            }
            if version != self.versions[vertex as usize] {
                continue;
            }
            // A collapse two edges away may have made this one inadmissible.
            if !self.mesh.may_collapse(vertex, into) {
                self.offer(vertex);
                continue;
            }

            // The deviation takes longer than a quadric: it is measured once a collapse is next.
            let squared =
                if is_measured { cost } else { self.mesh.squared_deviation(vertex, into) };
            if squared > cost {
                let offer = Offer { cost: TotalF64(squared), is_measured: true, ..offer };
                self.offers.push(Reverse(offer));
                continue;
            }
            self.perform(collapse);
            return Some((collapse, cost));
        }
        None
    }

    /// Performs a collapse, and replaces the offers of the vertices around it.
    fn perform(&mut self, Collapse { vertex, into }: Collapse) {
        self.mesh.collapse(vertex, into);
        let moved = self.quadrics[vertex as usize];
        self.quadrics[into as usize] += moved;
        self.versions[vertex as usize] += 1;

        let around: Vec<u32> = self.mesh.neighbors(into).collect();
        self.offer(into);
        for vertex in around {
            self.offer(vertex);
        }
    }

    /// Replaces the offer of a vertex by the cheapest collapse that it may make now.
    fn offer(&mut self, vertex: u32) {
        self.versions[vertex as usize] += 1;
        let version = self.versions[vertex as usize];
        if self.stays[vertex as usize] {
            return;
        }
        let mut choices = std::mem::take(&mut self.choices);
        choices.clear();
        for into in self.mesh.neighbors(vertex) {
            let collapse = Collapse { vertex, into };
            choices.push(Offer {
                cost: self.cost(collapse),
                collapse,
                version,
                is_measured: false,
            });
        }
        choices.sort_unstable();

        // Checking the shape of faces costs more than sorting.
        let is_allowed = |offer: &&Offer| self.mesh.may_collapse(vertex, offer.collapse.into);
        self.offers.extend(choices.iter().find(is_allowed).copied().map(Reverse));
        self.choices = choices;
    }

    /// Computes the mean squared distance of the new position from the planes of all faces
    /// that the vertex has replaced, weighted by their areas.
    ///
    /// The mean, since the deviation is a distance, not a volume; and without the planes of
    /// the neighbor, which keep their vertex. On muscles and a femur that took a fifth fewer
    /// faces for the same deviation of 0.5 to 1 mm than the sum over both, and about as many
    /// below.
    fn cost(&self, Collapse { vertex, into }: Collapse) -> TotalF64 {
        TotalF64(self.quadrics[vertex as usize].mean(self.x[into as usize] - self.origin))
    }
}
