//! Swept detection on curved paths: bones that turn, and tissue that follows them.
//!
//! Two rigid bodies are swept in their relative motion ([`crate::rigid_paths`]). For other pairs, the
//! step is divided into pieces short enough for paths to be nearly straight. Each piece is a
//! step of straight motion with the deviation of paths from their chords for a minimum separation.
//! So no contact is missed. Contacts that a piece leaves open are then searched on the true paths,
//! in shorter pieces of their own ([`ccd::first_contact_on_paths`]).

use std::collections::BTreeMap;

use ccd::{CcdParams, PathBounds, Primitives};
use glam::DVec3;
use kdop::Workspace;
use proximity::{ContactKind, SweptContact};
use surface::parallel;
use surface::progress::Progress;

use crate::path_steps::{PathMove, Steps, positions};
use crate::rigid_paths::PieceContacts;
use crate::sweep::NearLines;
use crate::{Body, BodyId, BodyMove, PairId, PairSweep, Scene, SceneError, SweepReport};

impl Scene {
    /// Finds the first contacts while each body named in `moves` follows its path; other bodies
    /// rest.
    ///
    /// The bodies are not moved: [`move_body`](Self::move_body) does that. No contact is missed,
    /// and no time is after the true one on the true paths. [`ccd::first_contact_on_paths`] tells
    /// how early they may be, and which contacts are certain.
    ///
    /// Where no path bends, this is [`sweep`](Self::sweep), which is quicker, and certain.
    ///
    /// # Errors
    ///
    /// As [`sweep`](Self::sweep); [`SceneError::Surface`] also where a path leads to positions
    /// that are not finite.
    pub fn sweep_paths(
        &mut self,
        moves: &[PathMove<'_>],
        params: &CcdParams,
        progress: Progress<'_>,
    ) -> Result<SweepReport, SceneError> {
        params.validate()?;
        if let Some(straight) = straight_moves(moves) {
            return self.sweep(&straight, params, progress);
        }
        if is_straight(self, moves)? {
            let mut ends = Vec::with_capacity(moves.len());
            for PathMove { body, path } in moves {
                ends.push(positions(*path, self.body(*body).surface().vertex_count(), 1.0));
            }
            let chords = Chords { moves, ends: &ends, near: &NearLines::default() };
            return self.sweep_chords(&chords, params, |_| true, progress);
        }
        let steps = Steps::new(self, moves, params)?;
        self.sweep_pieces(&steps, params, Wanted::All, progress)
    }

    /// Finds the first contact of each pair, as [`sweep_paths`](Self::sweep_paths) does, and nothing
    /// after it: how far a joint turns before bodies meet.
    ///
    /// Pairs that overlap already have no first contact; theirs is the first of primitives that
    /// were apart.
    ///
    /// # Errors
    ///
    /// As [`sweep_paths`](Self::sweep_paths).
    pub fn first_contacts(
        &mut self,
        moves: &[PathMove<'_>],
        params: &CcdParams,
        progress: Progress<'_>,
    ) -> Result<SweepReport, SceneError> {
        params.validate()?;
        let steps = Steps::new(self, moves, params)?;
        self.sweep_pieces(&steps, params, Wanted::FirstOfPair, progress)
    }

    /// Sweeps the pairs of rigid bodies in whole, and all others piece by piece.
    fn sweep_pieces(
        &mut self,
        steps: &Steps<'_>,
        params: &CcdParams,
        wanted: Wanted,
        progress: Progress<'_>,
    ) -> Result<SweepReport, SceneError> {
        let (first, candidates) = self.sweep_rigid(steps, params, wanted, progress)?;
        if steps.pieces == 0 {
            return Ok(report_of(first, params, candidates));
        }

        // Bodies stand at the start of each piece while it is swept, and go back at the end.
        let mut states = Vec::new();
        if steps.pieces > 1 {
            states.extend(steps.moves.iter().map(|moving| self.body(moving.body).state()));
        }
        let swept = self.sweep_moving(steps, params, wanted, progress, first);
        for (PathMove { body, .. }, state) in steps.moves.iter().zip(states) {
            self.get_mut(*body)?.restore(state)?;
        }
        let mut report = swept?;
        report.candidates += candidates;
        Ok(report)
    }

    /// Sweeps the pairs of rigid bodies in their relative motions; returns their first contacts and
    /// the number of queries.
    fn sweep_rigid(
        &mut self,
        steps: &Steps<'_>,
        params: &CcdParams,
        wanted: Wanted,
        progress: Progress<'_>,
    ) -> Result<(BTreeMap<PairId, Known>, usize), SceneError> {
        self.fit_with(&self.members(&steps.rigid_pairs), progress)?;
        let scene = &*self;
        let sweep = |workspace: &mut Workspace, &pair: &PairId| {
            let (mut known, mut candidates) = (Known::new(), 0);
            let rigid = steps.rigid_pair(scene, pair);
            rigid.for_each_piece(params, workspace, progress, |piece| {
                let PieceContacts { interval, contacts, candidates: queried } = piece;
                candidates += queried;
                let open = OpenPair { scene, steps, pair, interval, params };
                open.add(wanted, contacts, &mut known)?;
                Ok(wanted == Wanted::All || known.is_empty())
            })?;
            Ok::<_, SceneError>((known, candidates))
        };
        let cost = |pair: &PairId| scene.faces_in_common_box(*pair);
        let pairs = &steps.rigid_pairs;
        let swept = parallel::map_costly_first(pairs, cost, Workspace::default, sweep);

        let (mut first, mut candidates) = (BTreeMap::new(), 0);
        for (&pair, swept) in steps.rigid_pairs.iter().zip(swept) {
            let (known, queried) = swept?;
            candidates += queried;
            if !known.is_empty() {
                first.insert(pair, known);
            }
        }
        Ok((first, candidates))
    }

    /// Sweeps other pairs than those of `first` piece by piece, and adds their first contacts; leaves
    /// bodies at the start of the last piece.
    fn sweep_moving(
        &mut self,
        steps: &Steps<'_>,
        params: &CcdParams,
        wanted: Wanted,
        progress: Progress<'_>,
        mut first: BTreeMap<PairId, Known>,
    ) -> Result<SweepReport, SceneError> {
        let min_separation = params.min_separation + steps.rounding;
        let of_piece = CcdParams { min_separation, t_max: 1.0, ..*params };
        let mut candidates = 0;

        for piece in 0..steps.pieces {
            let [from, to] = steps.interval(piece);
            if from > params.t_max {
                break;
            }
            let part = progress.part(from, to);
            let is_open = |pair| {
                let is_new = wanted == Wanted::All || !first.contains_key(&pair);
                is_new && steps.rigid_pairs.binary_search(&pair).is_err()
            };
            let ends = self.place_on_piece(steps, piece)?;
            let ends = ends.as_ref().unwrap_or(&steps.ends);
            let chords = Chords { moves: steps.moves, ends, near: &steps.near };
            let report = self.sweep_chords(&chords, &of_piece, is_open, part)?;
            candidates += report.candidates;

            // What the piece leaves open is searched on the true paths.
            for PairSweep { pair, contacts } in report.pairs {
                let known = first.entry(pair).or_default();
                let open = OpenPair { scene: self, steps, pair, interval: [from, to], params };
                open.add(wanted, contacts, known)?;
            }
            first.retain(|_, contacts| !contacts.is_empty());
        }
        Ok(report_of(first, params, candidates))
    }

    /// Moves all bodies to the start of a piece, and returns their positions at its end; `None` for
    /// those of the step.
    fn place_on_piece(
        &mut self,
        steps: &Steps<'_>,
        piece: u32,
    ) -> Result<Option<Vec<Vec<DVec3>>>, SceneError> {
        let [from, to] = steps.interval(piece);
        let is_last = piece + 1 == steps.pieces;
        let mut ends = Vec::with_capacity(steps.moves.len());
        for PathMove { body, path } in steps.moves {
            let count = self.body(*body).surface().vertex_count();
            if piece > 0 {
                self.move_body(*body, &positions(*path, count, from))?;
            }
            if !is_last {
                ends.push(positions(*path, count, to));
            }
        }
        Ok((!is_last).then_some(ends))
    }

    /// Sweeps all bodies from where they are along straight lines.
    fn sweep_chords(
        &mut self,
        chords: &Chords<'_>,
        params: &CcdParams,
        is_wanted: impl Fn(PairId) -> bool,
        progress: Progress<'_>,
    ) -> Result<SweepReport, SceneError> {
        let mut moves = Vec::with_capacity(chords.ends.len());
        for (PathMove { body, .. }, positions) in chords.moves.iter().zip(chords.ends) {
            moves.push(BodyMove { body: *body, positions });
        }
        self.sweep_near_lines(&moves, params, chords.near, is_wanted, progress)
    }
}

/// Chords of paths from where bodies are.
struct Chords<'a> {
    moves: &'a [PathMove<'a>],
    /// Positions at the ends of the chords, per move.
    ends: &'a [Vec<DVec3>],
    /// Distances of particles from their chords.
    near: &'a NearLines,
}

/// First contacts that are wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Wanted {
    /// Those of all vertices, edges and faces.
    All,
    /// The earliest of each pair of bodies.
    FirstOfPair,
}

/// Returns the moves of paths that are known to be straight, if all are.
fn straight_moves<'a>(moves: &[PathMove<'a>]) -> Option<Vec<BodyMove<'a>>> {
    let mut straight = Vec::with_capacity(moves.len());
    for &PathMove { body, path } in moves {
        straight.push(BodyMove { body, positions: path.straight_to()? });
    }
    Some(straight)
}

/// Returns true if no path bends.
fn is_straight(scene: &Scene, moves: &[PathMove<'_>]) -> Result<bool, SceneError> {
    for PathMove { body, path } in moves {
        let mut vertices = (0_u32..).take(scene.get(*body)?.positions().len());
        if vertices.any(|vertex| path.bend(vertex) > 0.0) {
            return Ok(false);
        }
    }
    Ok(true)
}

/// Two primitives by their kind and particles, in the order of a query.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Features {
    /// True for a vertex and a face.
    is_vertex: bool,
    particles: [u32; 4],
}

impl Features {
    fn of(contact: &SweptContact) -> Self {
        let terms = contact.contact.stencil.terms();
        let mut particles = [0; 4];
        for (particle, term) in particles.iter_mut().zip(terms) {
            *particle = term.particle;
        }
        Self { is_vertex: contact.kind == ContactKind::VertexFace, particles }
    }
}

/// First contacts of a pair, by their primitives.
type Known = BTreeMap<Features, SweptContact>;

/// Pair of bodies that a piece leaves open.
struct OpenPair<'a> {
    scene: &'a Scene,
    steps: &'a Steps<'a>,
    pair: PairId,
    /// Start and end of the piece.
    interval: [f64; 2],
    params: &'a CcdParams,
}

impl OpenPair<'_> {
    /// Adds the first contacts of this kind that no earlier piece has.
    fn add(
        &self,
        wanted: Wanted,
        contacts: Vec<SweptContact>,
        known: &mut Known,
    ) -> Result<(), SceneError> {
        match wanted {
            Wanted::All => self.add_all(contacts, known),
            Wanted::FirstOfPair => self.add_first(contacts, known),
        }
    }

    /// Adds the first contacts of primitives that have not met in an earlier piece.
    fn add_all(&self, mut open: Vec<SweptContact>, known: &mut Known) -> Result<(), SceneError> {
        open.retain(|contact| !known.contains_key(&Features::of(contact)));
        let found = parallel::map(open.len(), |number| self.search(&open[number]));
        for (open, found) in open.iter().zip(found) {
            if let Some(contact) = found? {
                known.insert(Features::of(open), contact);
            }
        }
        Ok(())
    }

    /// Adds the earliest contact, if there is one. The contacts of a piece are in the order of
    /// times that the true ones are not before.
    fn add_first(&self, open: Vec<SweptContact>, known: &mut Known) -> Result<(), SceneError> {
        let [from, to] = self.interval;
        let mut earliest: Option<(Features, SweptContact)> = None;
        for contact in open {
            let bound = from + time_of(&contact) * (to - from);
            if earliest.as_ref().is_some_and(|(_, earliest)| time_of(earliest) < bound) {
                break;
            }
            let Some(found) = self.search(&contact)? else { continue };
            if earliest.as_ref().is_none_or(|(_, earliest)| time_of(&found) < time_of(earliest)) {
                earliest = Some((Features::of(&contact), found));
            }
        }
        known.extend(earliest);
        Ok(())
    }

    /// Searches the contact on the true paths, from the earliest time that the piece leaves open.
    fn search(&self, open: &SweptContact) -> Result<Option<SweptContact>, SceneError> {
        let Self { scene, steps, interval: [from, to], params, .. } = *self;
        let Features { is_vertex, particles } = Features::of(open);
        let (primitives, first) =
            if is_vertex { (Primitives::VertexFace, 1) } else { (Primitives::EdgeEdge, 2) };
        let points = ContactPoints::new(scene, self.pair, particles, first);
        let at = |time: f64| points.at(steps, time);

        // Each primitive deviates by as much as the worst of its points.
        let (of_first, of_second) = particles.split_at(first);
        let bend = (steps.max_bend(of_first) + steps.max_bend(of_second)) * (1.0 + f64::EPSILON);
        let bounds = PathBounds { bend, rounding: steps.rounding };

        // The piece has excluded all times before its contact.
        let earliest = time_of(open);
        let start = (from + earliest * (to - from) - 4.0 * f64::EPSILON).max(from);
        let found = ccd::first_contact_on_paths(primitives, at, bounds, [start, to], params)?;
        let Some(found) = found else { return Ok(None) };

        let found = ccd::CcdContact { at_start: found.at_start && found.lo <= 0.0, ..found };
        let (kind, separation) = (open.kind, params.min_separation);
        Ok(Some(SweptContact::new(kind, particles, at(found.lo), separation, &found)))
    }
}

/// Points of two primitives, each of one body.
struct ContactPoints<'a> {
    bodies: [&'a Body; 2],
    ids: [BodyId; 2],
    vertices: [u32; 4],
    /// Number of points of the first primitive.
    first: usize,
}

impl<'a> ContactPoints<'a> {
    fn new(scene: &'a Scene, pair: PairId, particles: [u32; 4], first: usize) -> Self {
        let is_of_b = |particle| scene.body(pair.b).particles().contains(&particle);
        let ids = if is_of_b(particles[0]) { [pair.b, pair.a] } else { [pair.a, pair.b] };
        let bodies = ids.map(|id| scene.body(id));
        let mut vertices = particles;
        for (k, vertex) in vertices.iter_mut().enumerate() {
            *vertex -= bodies[usize::from(k >= first)].particles().start;
        }
        Self { bodies, ids, vertices, first }
    }

    /// Returns where the points are at a time of the step.
    fn at(&self, steps: &Steps<'_>, time: f64) -> [DVec3; 4] {
        let mut points = [DVec3::ZERO; 4];
        let (of_first, of_second) = points.split_at_mut(self.first);
        let (first, second) = self.vertices.split_at(self.first);
        steps.place(self.bodies[0], self.ids[0], first, time, of_first);
        steps.place(self.bodies[1], self.ids[1], second, time, of_second);
        points
    }
}

/// Reports the first contacts of all pairs, by time.
fn report_of(first: BTreeMap<PairId, Known>, params: &CcdParams, candidates: usize) -> SweepReport {
    let mut report = SweepReport { pairs: Vec::new(), largest_free_step: 1.0, candidates };
    for (pair, contacts) in first {
        let mut contacts: Vec<SweptContact> = contacts.into_values().collect();
        contacts.retain(|contact| time_of(contact) <= params.t_max);

        // Stable: contacts at one time stay in the order of their primitives.
        contacts.sort_by(|p, q| time_of(p).total_cmp(&time_of(q)));
        report.add(PairSweep { pair, contacts }, 0);
    }
    report
}

fn time_of(contact: &SweptContact) -> f64 {
    contact.contact.time.unwrap_or(1.0)
}
