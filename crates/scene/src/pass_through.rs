//! Contacts that static detection misses between two states (tunnelling).

use std::collections::BTreeSet;

use crate::{
    BodyId, ContactKind, PairId, PairReport, PairSweep, Scene, SweepReport, SweptContact,
    VertexReport,
};

/// Contacts of a step between two bodies that neither the state before it nor
/// the one after it shows.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PassThrough {
    /// The two bodies.
    pub pair: PairId,
    /// True if the two overlap in neither state, though they met between them: a contact that was there
    /// at the start, or begins at the end, is one of a state.
    pub overlaps_in_neither: bool,
    /// Particles, ascending, whose path certainly met the other body's surface
    /// though they are inside it in neither state: they went in and out again.
    pub particles: Vec<u32>,
}

impl SweepReport {
    /// Compares a step with static detection [before](Scene::check) and after it, for pairs in
    /// the order of the bodies; pairs of which a state shows everything are left out.
    #[must_use]
    pub fn pass_throughs(
        &self,
        scene: &Scene,
        before: &[PairReport],
        after: &[PairReport],
    ) -> Vec<PassThrough> {
        let mut found = Vec::new();
        for sweep in &self.pairs {
            let states = [before, after].map(|reports| find(reports, sweep.pair));
            let pass = PassThrough::new(scene, sweep, &states);
            if pass.overlaps_in_neither || !pass.particles.is_empty() {
                found.push(pass);
            }
        }
        found
    }
}

fn find(reports: &[PairReport], pair: PairId) -> Option<&PairReport> {
    reports.iter().find(|report| report.pair == pair)
}

impl PassThrough {
    fn new(scene: &Scene, sweep: &PairSweep, states: &[Option<&PairReport>; 2]) -> Self {
        // Vertices that either state shows inside.
        let mut overlaps = false;
        let mut inside = BTreeSet::new();
        for report in states.iter().flatten() {
            overlaps |= report.overlaps;
            add_inside(scene, report.pair.a, &report.a_against_b, &mut inside);
            add_inside(scene, report.pair.b, &report.b_against_a, &mut inside);
        }

        // Vertices that certainly met the other surface on the way.
        let (mut has_met, mut met) = (false, BTreeSet::new());
        for found in sweep.contacts.iter().filter(|found| is_between_states(found)) {
            has_met = true;
            if found.kind == ContactKind::VertexFace && found.certain {
                met.insert(found.contact.stencil.terms()[0].particle);
            }
        }
        let particles = met.difference(&inside).copied().collect();
        Self { pair: sweep.pair, overlaps_in_neither: has_met && !overlaps, particles }
    }
}

/// Returns true for a contact that begins after the first state and before the second one.
fn is_between_states(found: &SweptContact) -> bool {
    !found.at_start && found.latest < 1.0
}

/// Adds the particles of one body that are inside the other.
fn add_inside(scene: &Scene, body: BodyId, report: &VertexReport, inside: &mut BTreeSet<u32>) {
    let first = scene.body(body).particles().start;
    for near in &report.near {
        if near.gap < 0.0 {
            inside.insert(first + near.vertex);
        }
    }
}
