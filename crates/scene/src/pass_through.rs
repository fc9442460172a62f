//! What a look at single states does not show: contacts between them.

use std::collections::BTreeSet;

use crate::{BodyId, ContactKind, PairReport, PairSweep, Scene, SweepReport, VertexReport};

/// Contacts of a step between two bodies that neither the state before it nor
/// the one after it shows.
#[derive(Clone, Debug, PartialEq)]
pub struct PassThrough {
    /// The first body.
    pub a: BodyId,
    /// The second body, of the higher number.
    pub b: BodyId,
    /// Whether the two overlap in neither state, though they met on the way.
    pub pair: bool,
    /// Particles, ascending, whose path certainly met the other body's surface
    /// though they are inside it in neither state: they went in and out again.
    pub particles: Vec<u32>,
}

impl SweepReport {
    /// Compares a step with static detection [before](Scene::check) and after
    /// it, for pairs in the order of the bodies; pairs without anything unseen
    /// are left out.
    #[must_use]
    pub fn pass_throughs(
        &self,
        scene: &Scene,
        before: &[PairReport],
        after: &[PairReport],
    ) -> Vec<PassThrough> {
        let found = |sweep: &PairSweep| {
            let states = [before, after].map(|reports| find(reports, sweep));
            pass_through(scene, sweep, &states)
        };
        let shows = |unseen: &PassThrough| unseen.pair || !unseen.particles.is_empty();
        self.pairs.iter().map(found).filter(shows).collect()
    }
}

fn find<'a>(reports: &'a [PairReport], sweep: &PairSweep) -> Option<&'a PairReport> {
    reports.iter().find(|report| (report.a, report.b) == (sweep.a, sweep.b))
}

fn pass_through(
    scene: &Scene,
    sweep: &PairSweep,
    states: &[Option<&PairReport>; 2],
) -> PassThrough {
    let inside: BTreeSet<u32> =
        states.iter().flatten().flat_map(|report| particles_inside(scene, report)).collect();
    let met = sweep.contacts.iter().filter(|contact| {
        contact.kind == ContactKind::VertexFace && contact.certain && !contact.at_start
    });
    let vertices: BTreeSet<u32> =
        met.map(|contact| contact.contact.stencil.terms()[0].particle).collect();
    PassThrough {
        a: sweep.a,
        b: sweep.b,
        pair: !states.iter().flatten().any(|report| report.overlaps),
        particles: vertices.difference(&inside).copied().collect(),
    }
}

fn particles_inside<'a>(
    scene: &'a Scene,
    report: &'a PairReport,
) -> impl Iterator<Item = u32> + use<'a> {
    let of_side = |body: BodyId, side: &'a VertexReport| {
        let first = scene.body(body).particles().start;
        side.near.iter().filter(|near| near.gap < 0.0).map(move |near| first + near.vertex)
    };
    of_side(report.a, &report.a_against_b).chain(of_side(report.b, &report.b_against_a))
}
