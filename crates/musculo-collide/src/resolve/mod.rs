//! Bodies that overlap, pushed apart.
//!
//! Round by round: contact is found anew; what is inside another body, or
//! about to be, is projected out of it, all contacts together (projected
//! Gauss–Seidel on displacements, particles weighted by inverse mass); the push
//! spreads to the tissue around and through it; bringing tissue back into shape and
//! pushing it out again take turns; lost volume is given back where nothing is in
//! the way. Rigid bodies stay. Deep overlaps take several rounds,
//! since no round moves a vertex farther than its surroundings can follow.

mod carry;
mod contacts;
mod guard;
mod outcome;
mod params;
mod resolver;
mod sides;
mod sight;
mod spread;
mod tissue;
mod volume;

use std::collections::BTreeMap;

use glam::DVec3;
use kdop::Workspace;
use response::{
    ContactLaw, ContactRows, ContactSystem, Margins, SolveLevel, SolverMethod, SolverParams,
    SweepOrder,
};
use surface::Contact;

pub use self::outcome::{BodyChange, Obstacle, Remaining, Resolution, Round};
pub use self::params::ResolveParams;
pub use self::resolver::Resolver;

use self::carry::Carried;
use self::outcome::ALLOWED_VOLUME_CHANGE;
use self::sides::Memory;
use self::sight::Sight;
use self::tissue::Tissue;
use crate::scene::Body;
use crate::{BodyId, BodyKind, CheckParams, PairReport, Scene, SceneError, VertexReport, parallel};

/// Most that one round moves a vertex, in smoothing lengths. Larger steps need
/// fewer rounds, but pass by the contacts that were found.
const STEP: f64 = 0.25;

/// How far away contact is looked for, in steps. What is nearer holds tissue
/// while it is brought back into shape; more is found the farther one looks,
/// and takes longer.
const SIGHT: f64 = 0.6;

/// Rounds without improvement after which the rest is given up.
const PATIENCE: u32 = 20;

/// The same once nothing is deeper than the tolerance.
const PATIENCE_AT_THE_END: u32 = 6;

/// Depth of vertices, in smoothing lengths, beyond which edges wait.
const DEEP: f64 = 0.05;

/// Displacement that spreads over one length, as a share of that length: deep
/// pushes reach farther, so that no tissue is strained by more.
const SLOPE: f64 = 0.5;

/// Turns a round in which tissue is brought into shape and pushed out again.
const TURNS: u32 = 2;

/// Rounds in which tissue keeps to the limits on strain, by how much these widen
/// in each round after, and at most. Tissue that slides through a narrow place
/// needs more rounds the later they widen; much sooner or faster, it is dragged
/// into folds that take as many.
const FIRM_ROUNDS: usize = 3;
const WIDENING: f64 = 0.3;
const LOOSEST: f64 = 3.0;

/// Sweeps of the solver over all contacts, for the first push of a round and
/// after each turn.
const SWEEPS: [u32; 2] = [30, 6];

/// Share of the tolerated depth below which the solver stops.
const SOLVED: f64 = 2e-3;

impl Scene {
    /// Pushes apart what overlaps, and leaves the bodies where they then are.
    ///
    /// Rigid bodies do not move; soft ones yield, and share by mass what they
    /// overlap with each other. Vertices that no push comes near keep their
    /// positions to the bit.
    ///
    /// # Errors
    ///
    /// [`SceneError::Resolve`] for a parameter out of range, and those of
    /// [`check`](Self::check).
    pub fn resolve(&mut self, params: &ResolveParams) -> Result<Resolution, SceneError> {
        Resolver::new(*params)?.resolve(self)
    }
}

/// A resolution on its way.
struct Run<'a> {
    scene: &'a mut Scene,
    params: ResolveParams,
    near: CheckParams,
    tissues: Vec<Tissue>,
    inverse_masses: Vec<f64>,
    before: Vec<PairReport>,
    now: Sight,
    rounds: Vec<Round>,
    best: Option<(Round, Vec<DVec3>)>,
    /// Ways out, for both sides of each pair.
    memories: BTreeMap<(BodyId, BodyId), [Memory; 2]>,
    /// Self-crossings of each body that pushes have made.
    crossed: Vec<usize>,
    /// Bodies that pushes have made cross themselves, turned faces of, or taken
    /// volume from.
    spoilt: Vec<bool>,
    /// Rounds since things last got better.
    stalled: u32,
}

impl<'a> Run<'a> {
    fn start(
        scene: &'a mut Scene,
        params: ResolveParams,
        near: CheckParams,
    ) -> Result<Self, SceneError> {
        let before = scene.check(&near)?;
        let tissues = tissue::tissues(scene);
        let inverse_masses = tissue::inverse_masses(scene, &tissues, params.smoothing);
        let now = Sight::first(scene, near.margin)?;
        let count = tissues.len();
        let mut run = Self {
            scene,
            params,
            near,
            tissues,
            inverse_masses,
            before,
            now,
            rounds: Vec::new(),
            best: None,
            memories: BTreeMap::new(),
            crossed: vec![0; count],
            spoilt: vec![false; count],
            stalled: 0,
        };
        run.record();
        Ok(run)
    }

    /// Displaces tissue as it was displaced before, where that is better.
    fn displace(&mut self, carried: &[Option<Carried>]) -> Result<(), SceneError> {
        for (id, carried) in self.scene.ids().zip(carried) {
            if let Some(carried) = carried {
                let x = carried.displaced(&self.tissues[id.index()]);
                self.scene.move_body(id, &x)?;
            }
        }
        self.look(&self.soft())?;
        if self.stalled > 0 {
            self.go_back()?;
        }
        Ok(())
    }

    fn goes_on(&self) -> bool {
        let clean = self.rounds.last().is_none_or(Round::is_clean);
        !clean && !self.is_stuck() && self.rounds.len() <= self.params.max_rounds as usize
    }

    /// Whether nothing has become better for long.
    fn is_stuck(&self) -> bool {
        let settled = self.best.as_ref().is_some_and(|(best, _)| self.is_settled(best));
        self.stalled >= if settled { PATIENCE_AT_THE_END } else { PATIENCE }
    }

    fn is_settled(&self, round: &Round) -> bool {
        round.max_depth <= self.params.tolerance && round.new_pairs == 0
    }

    fn round(&mut self) -> Result<(), SceneError> {
        let u = self.push()?;
        let moved = self.move_by(&u)?;
        self.look(&moved)
    }

    /// Finds contact of what has moved anew.
    fn look(&mut self, moved: &[bool]) -> Result<(), SceneError> {
        self.see(moved)?;
        self.record();
        Ok(())
    }

    fn see(&mut self, moved: &[bool]) -> Result<(), SceneError> {
        let now = std::mem::take(&mut self.now);
        self.now = now.again(self.scene, self.near.margin, moved)?;
        Ok(())
    }

    /// Which bodies are not rigid.
    fn soft(&self) -> Vec<bool> {
        self.scene.bodies().iter().map(|body| body.kind() != BodyKind::Rigid).collect()
    }

    /// Displacements that take all contacts apart, or as far as one round goes,
    /// and keep tissue in shape: by turns, since each undoes some of the other.
    fn push(&mut self) -> Result<Vec<DVec3>, SceneError> {
        let step = STEP * self.params.smoothing;
        let rows = self.rows(step)?;
        let system = ContactSystem::new(&rows, &self.inverse_masses, SweepOrder::Colored)?;
        let tolerance = SOLVED * self.params.tolerance;
        let part = |u: &mut [DVec3], max_iterations: u32| -> Result<(), SceneError> {
            let solver =
                SolverParams { method: SolverMethod::GaussSeidel, max_iterations, tolerance };
            system.solve(SolveLevel::Position, u, &mut system.no_impulses(), &solver)?;
            u.iter_mut().for_each(|u| *u = u.clamp_length_max(step));
            Ok(())
        };
        let mut u = vec![DVec3::ZERO; self.inverse_masses.len()];
        part(&mut u, SWEEPS[0])?;
        self.spread(&mut u);
        let looseness = looseness(self.rounds.len());
        for turn in 0..TURNS {
            let first = turn == 0;
            self.alter(&mut u, |id, tissue, x, traversal| {
                let body = self.scene.body(id);
                guard::unfold(body.surface(), tissue, looseness, x);
                if first && self.crossed[id.index()] > 0 {
                    guard::uncross(body, tissue, x, traversal);
                }
            });
            part(&mut u, SWEEPS[1])?;
        }
        self.alter(&mut u, |id, tissue, x, _| {
            guard::stiffen(self.scene.body(id).surface(), tissue, x);
        });
        u.iter_mut().for_each(|u| *u = u.clamp_length_max(step));
        self.alter(&mut u, |id, tissue, x, _| {
            volume::restore(self.scene.body(id), tissue, x, &self.now.pairs, id);
        });
        Ok(u)
    }

    /// What contacts ask for: none more than a step.
    fn rows(&mut self, step: f64) -> Result<ContactRows, SceneError> {
        let law = ContactLaw::new(Margins::new(self.params.clearance, step)?, 0.0)?;
        let mut rows = ContactRows::new(self.inverse_masses.len());
        for contact in &self.contacts() {
            rows.push(&Contact { gap: contact.gap.max(-step), ..*contact }, law)?;
        }
        Ok(rows)
    }

    /// Changes where bodies come to lie that `u` moves, or that have lost their
    /// shape.
    fn alter(
        &self,
        u: &mut [DVec3],
        change: impl Fn(BodyId, &Tissue, &mut [DVec3], &mut Workspace) + Sync,
    ) {
        let scene = &*self.scene;
        let mut parts = split(scene, &self.tissues, u);
        let altered = |(id, tissue, u): &mut (BodyId, &Tissue, &mut [DVec3])| {
            if !self.spoilt[id.index()] && u.iter().all(|&u| u == DVec3::ZERO) {
                return;
            }
            let from = scene.body(*id).positions();
            let x: Vec<DVec3> = from.iter().zip(&**u).map(|(&x, &u)| x + u).collect();
            let mut changed = x.clone();
            change(*id, tissue, &mut changed, &mut Workspace::default());
            for (u, ((changed, x), from)) in u.iter_mut().zip(changed.iter().zip(&x).zip(from)) {
                if changed != x {
                    *u = *changed - *from;
                }
            }
        };
        parallel::map_mut(&mut parts, altered);
    }

    /// All contacts, pair by pair. Edges wait where vertices are deep: they
    /// come free with them, and until then say little.
    fn contacts(&mut self) -> Vec<Contact> {
        let Self { scene, params, tissues, now, memories, .. } = self;
        let (scene, tissues) = (&**scene, &*tissues);
        let of_body = |body: &Body| contacts::vertex_normals(body.surface(), body.positions());
        let normals = parallel::map_with(scene.bodies(), || (), |(), body| of_body(body));
        let side = |[p, q]: [BodyId; 2], report: &VertexReport, memory: &mut Memory| {
            let p_side = (scene.body(p), &tissues[p.index()]);
            let q_side = (scene.body(q), &normals[p.index()][..]);
            let traversal = &mut Workspace::default();
            let near =
                sides::straighten(p_side, q_side, report, memory, params.smoothing, traversal);
            VertexReport { inside_count: report.inside_count, near }
        };
        let mut pairs: Vec<_> = now
            .pairs
            .iter()
            .zip(&now.edges)
            .map(|(pair, edges)| {
                let memory = memories.remove(&(pair.a, pair.b)).unwrap_or_default();
                (pair, edges, memory)
            })
            .collect();
        let contacts = parallel::map_mut(&mut pairs, |(pair, edges, [of_a, of_b])| {
            let straight = PairReport {
                a_against_b: side([pair.a, pair.b], &pair.a_against_b, of_a),
                b_against_a: side([pair.b, pair.a], &pair.b_against_a, of_b),
                ..(*pair).clone()
            };
            let mut contacts = straight.contacts(scene);
            if pair.max_depth <= DEEP * params.smoothing {
                contacts.extend_from_slice(edges);
            }
            contacts
        });
        let kept = pairs.into_iter().map(|(pair, _, memory)| ((pair.a, pair.b), memory));
        memories.extend(kept);
        contacts.into_iter().flatten().collect()
    }

    fn spread(&mut self, u: &mut [DVec3]) {
        let scene = &*self.scene;
        let smoothing = self.params.smoothing;
        let mut parts = split(scene, &mut self.tissues, u);
        parallel::map_mut(&mut parts, |(id, tissue, part)| {
            let body = scene.body(*id);
            let over = smoothing.max(spread::farthest(body, tissue, part) / SLOPE);
            spread::spread(body, tissue, part, over, &mut Workspace::default());
        });
    }

    /// Moves tissue, and tells which bodies have moved.
    fn move_by(&mut self, u: &[DVec3]) -> Result<Vec<bool>, SceneError> {
        let mut moved = vec![false; self.tissues.len()];
        for id in self.scene.ids() {
            let body = self.scene.body(id);
            let particles = body.particles();
            let part = &u[particles.start as usize..particles.end as usize];
            if body.kind() != BodyKind::Rigid && part.iter().any(|&u| u != DVec3::ZERO) {
                let x: Vec<DVec3> = body.positions().iter().zip(part).map(|(x, u)| x + u).collect();
                self.scene.move_body(id, &x)?;
                moved[id.index()] = true;
            }
        }
        Ok(moved)
    }

    fn record(&mut self) {
        let mut round = Round::new(&self.now, &self.before);
        let shapes = self.shapes();
        round.volume_change = shapes.iter().map(|shape| shape.1).fold(0.0, f64::max);
        round.flipped_faces = shapes.iter().map(|shape| shape.0).sum();
        if self.is_settled(&round) && !self.rounds.is_empty() {
            self.find_self_crossings();
            round.self_crossings = self.crossed.iter().sum();
        }
        let spoilt = |((flipped, volume), crossed): ((usize, f64), usize)| {
            flipped + crossed > 0 || volume > ALLOWED_VOLUME_CHANGE
        };
        self.spoilt = shapes.into_iter().zip(self.crossed.iter().copied()).map(spoilt).collect();
        self.rounds.push(round);
        let tolerance = self.params.tolerance;
        if self.best.as_ref().is_none_or(|(best, _)| round.is_better_than(best, tolerance)) {
            self.best = Some((round, self.scene.particle_positions()));
            self.stalled = 0;
        } else {
            self.stalled += 1;
        }
    }

    /// Of each body, faces that were turned over and the change of volume.
    fn shapes(&self) -> Vec<(usize, f64)> {
        let bodies: Vec<_> = self.scene.bodies().iter().zip(&self.tissues).collect();
        parallel::map_with(
            &bodies,
            || (),
            |(), (body, tissue)| {
                let flipped = guard::flipped(body.surface(), tissue, body.positions());
                (flipped, volume::change(body, tissue))
            },
        )
    }

    /// Counts for each body how many more of its own faces cross than at first.
    fn find_self_crossings(&mut self) {
        let bodies: Vec<_> = self.scene.bodies().iter().zip(&self.tissues).collect();
        self.crossed =
            parallel::map_with(&bodies, Workspace::default, |traversal, (body, tissue)| {
                if body.positions() == tissue.rest {
                    return 0;
                }
                let count = |x: &[DVec3], traversal: &mut _| {
                    guard::self_crossings(body, x, traversal).len()
                };
                let now = count(body.positions(), traversal);
                if now == 0 { 0 } else { now.saturating_sub(count(&tissue.rest, traversal)) }
            });
    }

    /// Goes back to the best round.
    fn go_back(&mut self) -> Result<(), SceneError> {
        let Some((_, x)) = &self.best else { return Ok(()) };
        for id in self.scene.ids() {
            let particles = self.scene.body(id).particles();
            self.scene.move_body(id, &x[particles.start as usize..particles.end as usize])?;
        }
        self.see(&self.soft())
    }

    /// Takes the best round, where later ones were worse; tells also where
    /// tissue then is.
    fn finish(mut self) -> Result<(Resolution, Vec<Option<Carried>>), SceneError> {
        if self.best.as_ref().map(|(best, _)| best) != self.rounds.last() {
            self.go_back()?;
        }
        let carried = carry::take(self.scene, &self.tissues);
        let stuck = self.is_stuck();
        let Self { scene, params, near, tissues, before, now, rounds, .. } = self;
        let after = scene.check(&near)?;
        let ended = (rounds, stuck);
        let resolution = Resolution::new(scene, &params, &tissues, [before, after], &now, ended);
        Ok((resolution, carried))
    }
}

/// How far the limits on strain are widened: tissue gives way by and by where
/// the first rounds have found no gentler way.
fn looseness(rounds: usize) -> f64 {
    let over = u32::try_from(rounds.saturating_sub(FIRM_ROUNDS)).unwrap_or(u32::MAX);
    (1.0 + WIDENING * f64::from(over)).min(LOOSEST)
}

/// The soft bodies of a scene, each with one of `items` and its part of `u`.
fn split<'a, T>(
    scene: &Scene,
    items: impl IntoIterator<Item = T>,
    u: &'a mut [DVec3],
) -> Vec<(BodyId, T, &'a mut [DVec3])> {
    let mut rest = u;
    let mut parts = Vec::new();
    for (id, item) in scene.ids().zip(items) {
        let body = scene.body(id);
        let (part, others) = std::mem::take(&mut rest).split_at_mut(body.positions().len());
        rest = others;
        if body.kind() != BodyKind::Rigid {
            parts.push((id, item, part));
        }
    }
    parts
}
