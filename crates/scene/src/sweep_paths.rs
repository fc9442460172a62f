//! Swept detection on curved paths: bones that turn, and tissue that follows them.
//!
//! The step is divided into pieces short enough for paths to be nearly straight. Each piece is a
//! step of straight motion with the deviation of paths from their chords for a minimum separation.
//! So no contact is missed. Contacts that a piece leaves open are then searched on the true paths,
//! in shorter pieces of their own ([`ccd::first_contact_on_paths`]).

use std::collections::BTreeMap;
use std::fmt;

use ccd::{CcdParams, PathBounds, Primitives, chord_deviation};
use glam::DVec3;
use proximity::{ContactKind, SweptContact};
use surface::progress::Progress;
use surface::{Path, mean_edge, parallel};

use crate::{Body, BodyId, BodyMove, PairId, PairSweep, Scene, SceneError, SweepReport};

/// Path of a body during a step.
#[derive(Clone, Copy)]
pub struct PathMove<'a> {
    /// The body.
    pub body: BodyId,
    /// Paths of its vertices, from where they are.
    pub path: &'a dyn Path,
}

impl fmt::Debug for PathMove<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("PathMove").field("body", &self.body).finish_non_exhaustive()
    }
}

/// Deviation from chords, relative to the mean edge of a body, that a piece may have.
///
/// Smaller takes more pieces, each with its bounds; larger finds more candidates that do not meet.
const DEVIATION: f64 = 0.25;

/// Maximum number of pieces. A step that would need more is still detected completely, with more
/// candidates.
const MAX_PIECES: u32 = 1024;

/// Roundings of a coordinate in the position of a path.
const ROUNDINGS: f64 = 64.0;

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
        let steps = Steps::new(self, moves)?;
        if steps.is_straight {
            return self.sweep_piece(&steps, [0.0, 1.0], params, |_| true, progress);
        }
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
        let steps = Steps::new(self, moves)?;
        self.sweep_pieces(&steps, params, Wanted::FirstOfPair, progress)
    }

    fn sweep_pieces(
        &mut self,
        steps: &Steps<'_>,
        params: &CcdParams,
        wanted: Wanted,
        progress: Progress<'_>,
    ) -> Result<SweepReport, SceneError> {
        // Bodies stand at the start of each piece while it is swept, and go back at the end.
        let states: Vec<_> = steps.moves.iter().map(|m| self.body(m.body).state()).collect();
        let swept = self.sweep_moving(steps, params, wanted, progress);
        for (PathMove { body, .. }, state) in steps.moves.iter().zip(states) {
            self.get_mut(*body)?.restore(state)?;
        }
        swept
    }

    /// Sweeps piece by piece; leaves bodies at the start of the last piece.
    fn sweep_moving(
        &mut self,
        steps: &Steps<'_>,
        params: &CcdParams,
        wanted: Wanted,
        progress: Progress<'_>,
    ) -> Result<SweepReport, SceneError> {
        let separation = params.min_separation + steps.deviation;
        let of_piece = CcdParams { min_separation: separation, t_max: 1.0, ..*params };
        let mut first: BTreeMap<PairId, Known> = BTreeMap::new();
        let mut candidates = 0;

        for piece in 0..steps.pieces {
            let [from, to] = steps.interval(piece);
            if from > params.t_max {
                break;
            }
            let part = progress.part(from, to);
            let is_open = |pair| wanted == Wanted::All || !first.contains_key(&pair);
            let report = self.sweep_piece(steps, [from, to], &of_piece, is_open, part)?;
            candidates += report.candidates;

            // What the piece leaves open is searched on the true paths.
            for PairSweep { pair, contacts } in report.pairs {
                let known = first.entry(pair).or_default();
                let open = OpenPair { scene: self, steps, pair, interval: [from, to], params };
                match wanted {
                    Wanted::All => open.add_all(contacts, known)?,
                    Wanted::FirstOfPair => open.add_first(contacts, known)?,
                }
            }
            first.retain(|_, contacts| !contacts.is_empty());
        }
        Ok(report_of(first, params, candidates))
    }

    /// Sweeps all bodies along their chords of a piece.
    fn sweep_piece(
        &mut self,
        steps: &Steps<'_>,
        [from, to]: [f64; 2],
        params: &CcdParams,
        is_wanted: impl Fn(PairId) -> bool,
        progress: Progress<'_>,
    ) -> Result<SweepReport, SceneError> {
        let mut ends = Vec::with_capacity(steps.moves.len());
        for PathMove { body, path } in steps.moves {
            let count = self.body(*body).surface().vertex_count();
            if from > 0.0 {
                self.move_body(*body, &positions(*path, count, from))?;
            }
            ends.push(positions(*path, count, to));
        }
        let mut moves = Vec::with_capacity(ends.len());
        for (PathMove { body, .. }, positions) in steps.moves.iter().zip(&ends) {
            moves.push(BodyMove { body: *body, positions });
        }
        self.sweep_among(&moves, params, is_wanted, progress)
    }
}

/// First contacts that are wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Wanted {
    /// Those of all vertices, edges and faces.
    All,
    /// The earliest of each pair of bodies.
    FirstOfPair,
}

/// Returns the positions of all vertices at a time.
fn positions(path: &dyn Path, count: usize, time: f64) -> Vec<DVec3> {
    let vertices = (0_u32..).take(count);
    vertices.map(|vertex| path.position(vertex, time)).collect()
}

/// Step of a scene along paths, divided into pieces.
struct Steps<'a> {
    moves: &'a [PathMove<'a>],
    /// Path of each body, by its number; `None` where it rests.
    paths: Vec<Option<&'a dyn Path>>,
    pieces: u32,
    /// True if no path bends.
    is_straight: bool,
    /// Bound of the deviation of two bodies from their chords over a piece, with rounding.
    deviation: f64,
    /// Bound of the rounding of the positions of two primitives.
    rounding: f64,
}

impl<'a> Steps<'a> {
    fn new(scene: &Scene, moves: &'a [PathMove<'a>]) -> Result<Self, SceneError> {
        let mut paths = vec![None; scene.bodies().len()];
        let (mut bends, mut pieces, mut extent) = ([0.0_f64; 2], 1_u32, 0.0_f64);
        for x in scene.bodies().iter().flat_map(Body::positions) {
            extent = extent.max(x.abs().max_element());
        }

        for PathMove { body: id, path } in moves {
            let body = scene.get(*id)?;
            paths[id.index()] = Some(*path);
            let (mut bend, mut reach) = (0.0_f64, 0.0_f64);
            for vertex in (0_u32..).take(body.positions().len()) {
                bend = bend.max(path.bend(vertex));
                reach = reach.max(path.position(vertex, 1.0).abs().max_element());
            }

            // Both ends of an arc bound its coordinates but for its bend.
            extent = extent.max(reach) + bend;
            let edge = mean_edge(body.surface(), body.checked_positions());
            pieces = pieces.max(pieces_for(bend, DEVIATION * edge));
            let [first, second] = bends;
            bends = if bend > first { [bend, first] } else { [first, second.max(bend)] };
        }

        // Two bodies at most take part in a contact: those that bend most bound all.
        let rounding = 2.0 * ROUNDINGS * f64::EPSILON * extent;
        let piece = 1.0 / f64::from(pieces);
        let deviation = chord_deviation(bends[0] + bends[1], piece) + rounding;
        Ok(Self { moves, paths, pieces, is_straight: bends[0] <= 0.0, deviation, rounding })
    }

    /// Returns where a vertex is at a time.
    fn position(&self, scene: &Scene, vertex: BodyVertex, time: f64) -> DVec3 {
        let BodyVertex { body, vertex } = vertex;
        match self.paths[body.index()] {
            Some(path) => path.position(vertex, time),
            None => scene.body(body).positions()[vertex as usize],
        }
    }

    /// Returns the largest bend of some vertices.
    fn max_bend(&self, vertices: &[BodyVertex]) -> f64 {
        let mut largest = 0.0_f64;
        for BodyVertex { body, vertex } in vertices {
            if let Some(path) = self.paths[body.index()] {
                largest = largest.max(path.bend(*vertex));
            }
        }
        largest
    }

    /// Returns the start and the end of a piece: neighbors share theirs to the bit.
    fn interval(&self, piece: u32) -> [f64; 2] {
        [piece, piece + 1].map(|k| f64::from(k) / f64::from(self.pieces))
    }
}

/// Returns the number of pieces over which a path deviates by no more than a length.
fn pieces_for(bend: f64, deviation: f64) -> u32 {
    let mut pieces = 1;
    while pieces < MAX_PIECES && chord_deviation(bend, 1.0 / f64::from(pieces)) > deviation {
        pieces += 1;
    }
    pieces
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
        let vertices = particles.map(|particle| vertex_of(scene, self.pair, particle));
        let at = |time: f64| vertices.map(|vertex| steps.position(scene, vertex, time));

        // Each primitive deviates by as much as the worst of its points.
        let (primitives, first) =
            if is_vertex { (Primitives::VertexFace, 1) } else { (Primitives::EdgeEdge, 2) };
        let (of_first, of_second) = vertices.split_at(first);
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

/// Vertex of a body.
#[derive(Clone, Copy)]
struct BodyVertex {
    body: BodyId,
    vertex: u32,
}

/// Returns the vertex of one of two bodies that a particle is.
fn vertex_of(scene: &Scene, pair: PairId, particle: u32) -> BodyVertex {
    let in_second = scene.body(pair.b).particles().contains(&particle);
    let body = if in_second { pair.b } else { pair.a };
    BodyVertex { body, vertex: particle - scene.body(body).particles().start }
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
