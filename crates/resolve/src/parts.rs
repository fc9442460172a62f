//! Parts of bodies that are relaxed side by side: bodies are cut, and parts colored so that those of one color
//! have nothing in common.
//!
//! Whole bodies would be too few and too unlike, and a problem of one body would keep one thread busy.

use std::ops::Range;

/// Largest number of particles of a part. Below, more of what a particle depends on is in other parts, and displacements
/// spread more slowly; above, threads wait for each other.
const MAX_PARTICLES: usize = 700;

/// Consecutive particles of one body, which one thread relaxes one after the other.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Part {
    /// Number of the body.
    pub(crate) body: usize,
    pub(crate) particles: Range<usize>,
}

/// Cuts bodies, whose particles follow each other, into parts of about the same size.
pub(crate) fn cut(body_of: &[usize]) -> Vec<Part> {
    let (mut parts, mut first) = (Vec::new(), 0);
    for own in body_of.chunk_by(|a, b| a == b) {
        let count = own.len().div_ceil(MAX_PARTICLES);
        for part in 0..count {
            let particles = [part, part + 1].map(|end| first + end * own.len() / count);
            parts.push(Part { body: own[0], particles: particles[0]..particles[1] });
        }
        first += own.len();
    }
    parts
}

/// Graph of parts, of which those that have something in common are neighbors.
pub(crate) struct PartGraph {
    /// Part of each particle.
    part_of: Vec<usize>,
    /// Edges, the later part first.
    edges: Vec<[usize; 2]>,
    /// Parts of the particles that are connected, in memory that is reused.
    together: Vec<usize>,
}

impl PartGraph {
    pub(crate) fn new(parts: &[Part]) -> Self {
        let mut part_of = Vec::new();
        for (number, part) in parts.iter().enumerate() {
            part_of.resize(part.particles.end, number);
        }
        Self { part_of, edges: Vec::new(), together: Vec::new() }
    }

    /// Connects the parts of particles that have something in common.
    pub(crate) fn connect(&mut self, particles: impl Iterator<Item = usize>) {
        self.together.clear();
        for particle in particles {
            // Most are of one part.
            let part = self.part_of[particle];
            if !self.together.contains(&part) {
                for &other in &self.together {
                    self.edges.push([part.max(other), part.min(other)]);
                }
                self.together.push(part);
            }
        }
    }

    /// Adds the connections of another graph of the same parts.
    pub(crate) fn merge(&mut self, other: Self) {
        self.edges.extend(other.edges);
    }

    /// Colors the graph greedily: each part in turn has the first color that no earlier neighbor has.
    pub(crate) fn colors(mut self, count: usize) -> Vec<usize> {
        self.edges.sort_unstable();
        self.edges.dedup();
        let mut colors = vec![0; count];
        for own in self.edges.chunk_by(|p, q| p[0] == q[0]) {
            let taken: Vec<usize> = own.iter().map(|[_, earlier]| colors[*earlier]).collect();
            colors[own[0][0]] = (0..).find(|color| !taken.contains(color)).unwrap_or(0);
        }
        colors
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_of_one_body_and_hold_all_particles_in_order() {
        let body_of =
            [vec![2; 10], vec![3; 3 * MAX_PARTICLES + 1], vec![7; MAX_PARTICLES]].concat();
        let parts = cut(&body_of);
        assert_eq!(parts.iter().map(|part| part.body).collect::<Vec<_>>(), [2, 3, 3, 3, 3, 7]);
        let mut end = 0;
        for part in parts {
            assert_eq!(part.particles.start, end);
            end = part.particles.end;
            assert!((1..=MAX_PARTICLES).contains(&part.particles.len()), "{part:?}");
            assert!(body_of[part.particles].iter().all(|body| *body == part.body));
        }
        assert_eq!(end, body_of.len());
    }

    #[test]
    fn parts_that_have_something_in_common_differ_in_color() {
        let parts: Vec<Part> =
            (0..40).map(|k| Part { body: k, particles: 10 * k..10 * k + 10 }).collect();
        let mut graph = PartGraph::new(&parts);
        let triples: Vec<[usize; 3]> =
            (0..60).map(|k| [(37 * k) % 400, (101 * k + 7) % 400, (53 * k + 9) % 400]).collect();
        for particles in &triples {
            graph.connect(particles.iter().copied());
        }
        let colors = graph.colors(parts.len());
        for particles in &triples {
            for [p, q] in [[0, 1], [0, 2], [1, 2]].map(|pair| pair.map(|i| particles[i] / 10)) {
                assert!(p == q || colors[p] != colors[q], "{p} and {q}");
            }
        }
        assert!(colors.iter().all(|color| *color < 10), "{colors:?}");
    }
}
