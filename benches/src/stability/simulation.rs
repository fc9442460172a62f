//! One run: a scene in steps, with what is measured of it.

use std::collections::BTreeSet;

use glam::DVec3;
use musculo_collide::scene::StepDetectors;
use musculo_collide::{CheckParams, Progress, Scene, SceneError, StepError};
use serde::Serialize;

use super::responder::{Responder, Response, Touch};
use super::scenes::{Expected, World};
use super::{Setting, steps_in};
use crate::measure::as_f64;

/// The last of so many parts of a run is at rest.
const REST_PART: u32 = 5;

/// Exact overlaps are measured this many times per run.
const SAMPLES: u32 = 15;

/// Gap up to which a contact counts as touching \[mm\].
const TOUCH: f64 = 0.02;

/// Width of the bracket on the depth of surfaces \[mm\].
const DEPTH_TOLERANCE: f64 = 0.01;

/// A particle this fast or far has left the scene.
const LOST_SPEED: f64 = 1e5;
const LOST_DISTANCE: f64 = 500.0;

/// Measured figures of a run. Millimeters, seconds.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Figures {
    /// Steps made: all, unless a particle was lost.
    pub steps: u32,
    /// True if a particle left the scene.
    pub lost: bool,
    /// Largest move of a vertex in a step, once at rest.
    pub jitter: f64,
    /// Root of the mean square speed, once at rest.
    pub speed: f64,
    /// Touching contacts that come or go per step, once at rest.
    pub changes: f64,
    /// Speed of the centers of soft bodies, once at rest.
    pub creep: f64,
    /// Acceleration down the slope over the last half, over the right one; 0 elsewhere.
    pub slide: f64,
    /// Energy gained, over that of the fall or the largest of the springs; `None` where the work
    /// of bones and moving goals is not known.
    pub energy: Option<f64>,
    /// Energy that corrections of positions have added, over the same.
    pub added: f64,
    /// Largest exact overlap.
    pub overlap: f64,
    /// Largest depth found beyond the exact one.
    pub false_depth: f64,
    /// Largest exact depth beyond that found.
    pub missed_depth: f64,
    /// Vertices out of the far side, at most.
    pub far_side: usize,
    /// Vertices whose side was not known, at most.
    pub unknown_sides: usize,
    /// Share of the steps in which a pair was not detected by its method.
    pub fallbacks: f64,
    /// Distance from where the body was at first, at the end.
    pub away: f64,
    /// Iterations of the solver per step.
    pub iterations: f64,
}

/// Observer of a run, which the energy over time is drawn by.
pub type Observer<'a> = &'a mut dyn FnMut(&Moment);

/// State of a run at the start of a step.
#[derive(Clone, Copy, Debug)]
pub struct Moment {
    /// Time.
    pub time: f64,
    /// Kinetic energy, and that of springs and gravity \[g mm²/s²\].
    pub kinetic: f64,
    /// Energy of springs and gravity.
    pub potential: f64,
    /// Energy of soft contacts.
    pub contact: f64,
    /// Work of bones and goals so far.
    pub work: f64,
    /// Energy that corrections of positions have added so far.
    pub added: f64,
}

/// A scene in motion.
#[derive(Debug)]
pub struct Simulation<'a> {
    world: &'a mut World,
    detectors: &'a mut StepDetectors,
    responder: Responder,
    setting: Setting,
    x: Vec<DVec3>,
    v: Vec<DVec3>,
    figures: Figures,
    account: Account,
    touches: BTreeSet<Touch>,
}

/// Energies of a run.
#[derive(Clone, Copy, Debug)]
struct Account {
    start: Option<f64>,
    work: f64,
    added: f64,
    /// Largest gain.
    gain: f64,
    /// Largest energy of the springs.
    largest: f64,
    is_known: bool,
}

impl<'a> Simulation<'a> {
    /// Puts a scene to its start.
    ///
    /// # Errors
    ///
    /// As [`World::reset`] and [`Responder::new`].
    pub fn new(
        world: &'a mut World,
        detectors: &'a mut StepDetectors,
        response: Response,
        setting: Setting,
    ) -> Result<Self, StepError> {
        let (v, x) = (world.reset(setting)?, world.start.clone());
        let responder = Responder::new(response, world, detectors, setting)?;
        let account =
            Account { start: None, work: 0.0, added: 0.0, gain: 0.0, largest: 0.0, is_known: true };
        let (figures, touches) = (Figures::default(), BTreeSet::new());
        Ok(Self { world, detectors, responder, setting, x, v, figures, account, touches })
    }

    /// Runs a number of steps, of which the last part is at rest.
    ///
    /// # Errors
    ///
    /// Those of detection and response.
    pub fn run(mut self, steps: u32, observer: Observer<'_>) -> Result<Figures, StepError> {
        let rest_from = steps - (steps / REST_PART).max(1);
        let every = (steps / SAMPLES).max(1);
        let (mut middle, mut before_rest) = (DVec3::ZERO, self.centers());
        let mut rested = Rested::default();

        // States in the middle and at the start of rest are kept, to compare the end with them.
        for step in 0..steps {
            if step == steps / 2 {
                middle = self.velocity();
            }
            if step == rest_from {
                before_rest = self.centers();
            }
            let sample = step % every == every - 1;
            self.step(sample, step >= rest_from, &mut rested, observer)?;

            // A run whose bodies are lost ends there, since its later steps mean nothing.
            if self.is_lost() {
                self.figures.lost = true;
                break;
            }
        }
        self.finish(steps, middle, &before_rest, &rested);
        Ok(self.figures)
    }

    /// Makes one step.
    fn step(
        &mut self,
        is_sample: bool,
        is_rest: bool,
        rested: &mut Rested,
        observer: Observer<'_>,
    ) -> Result<(), StepError> {
        // The present state, exactly.
        let h = self.setting.step;
        self.responder.move_bones(self.world, self.world.time)?;
        self.world.move_tissues(&self.x)?;
        let exact = if is_sample { Some(exact_depth(&mut self.world.scene)?) } else { None };
        let kinetic = self.kinetic();
        let potential = self.potential();

        // Forces, then contacts, then the move.
        self.responder.begin(&self.v);
        let mut goals = 0.0;
        for tissue in &mut self.world.tissues {
            let until = [h, self.world.time + h];
            goals += tissue.accelerate(&self.x, &mut self.v, self.world.gravity, until);
        }
        let before = self.x.clone();
        let (x, v) = (&mut self.x, &mut self.v);
        let account = self.responder.advance(self.world, self.detectors, x, v)?;
        if let Some(exact) = exact {
            let Figures { overlap, false_depth, missed_depth, .. } = &mut self.figures;
            *overlap = overlap.max(exact);
            *false_depth = false_depth.max(account.depth - exact);
            *missed_depth = missed_depth.max(exact - account.depth);
        }

        // Energy at the start of the step; then what the step has given.
        let moment = Moment {
            time: self.world.time,
            kinetic,
            potential,
            contact: account.contact_energy,
            work: self.account.work,
            added: self.account.added,
        };
        observer(&moment);
        self.account.include(&moment);
        // Goals that move give work that a step knows to its own order only.
        self.account.is_known &= goals == 0.0;
        self.account.is_known &= account.work.is_some() || self.bones_are_still();
        self.account.work += goals + account.work.unwrap_or(0.0);
        self.account.added += self.added_by_positions(&before)?;
        self.world.time += h;

        // Maxima and sums over all steps; `finish` turns the sums into means.
        self.figures.steps += 1;
        self.figures.iterations += f64::from(account.iterations);
        self.figures.fallbacks += f64::from(u8::from(account.fallbacks > 0));
        self.figures.unknown_sides = self.figures.unknown_sides.max(account.unknown_sides);
        self.figures.far_side = self.figures.far_side.max(self.world.far_count(&self.x));

        // Contacts at rest are compared with those of the step before, which are replaced last.
        if is_rest {
            self.look_at_rest(&before, rested);
        }
        self.touches = self.responder.touches(TOUCH);
        Ok(())
    }

    /// Computes the potential energy that the correction of positions has added in a step: a
    /// position that is not that of the move was corrected before it.
    fn added_by_positions(&mut self, before: &[DVec3]) -> Result<f64, StepError> {
        let h = self.setting.step;

        // Taking the move back leaves what was corrected before it.
        let mut corrected = self.x.clone();
        for (x, v) in corrected.iter_mut().zip(&self.v) {
            *x -= h * *v;
        }
        let moved = corrected.iter().zip(before).any(|(x, y)| x.distance_squared(*y) > 1e-24);
        if !moved {
            return Ok(0.0);
        }

        // Both energies are of the same time, so that moving goals add nothing here.
        let time = self.world.time + h;
        Ok(potential(self.world, &corrected, time) - potential(self.world, before, time))
    }

    fn look_at_rest(&mut self, before: &[DVec3], rested: &mut Rested) {
        for tissue in &self.world.tissues {
            for k in tissue.particles.clone() {
                self.figures.jitter = self.figures.jitter.max(self.x[k].distance(before[k]));
                rested.squares += self.v[k].length_squared();
                rested.particles += 1.0;
            }
        }

        // Contacts that came or went since the last step.
        let touches = self.responder.touches(TOUCH);
        rested.changes += as_f64(touches.symmetric_difference(&self.touches).count());
        rested.steps += 1.0;
    }

    fn finish(&mut self, steps: u32, middle: DVec3, before_rest: &[DVec3], rested: &Rested) {
        let Figures { steps: made, .. } = self.figures;
        let h = self.setting.step;
        self.figures.iterations /= f64::from(made).max(1.0);
        self.figures.fallbacks /= f64::from(made).max(1.0);
        self.figures.speed = (rested.squares / rested.particles.max(1.0)).sqrt();
        self.figures.changes = rested.changes / rested.steps.max(1.0);

        // Creep is the drift of centers, to which shaking about a place adds little.
        let rest_time = h * rested.steps.max(1.0);
        for (now, then) in self.centers().iter().zip(before_rest) {
            self.figures.creep = self.figures.creep.max(now.distance(*then) / rest_time);
        }

        // Mean acceleration over the second half, as a share of that expected.
        if let Expected::Slide { down, acceleration } = self.world.expected {
            let time = h * f64::from(steps - steps / 2);
            self.figures.slide = (self.velocity() - middle).dot(down) / (time * acceleration);
        }

        // Energies are shares of the fall, or of the largest energy where nothing falls.
        let scale = self.account.scale(self.world);
        self.figures.energy = self.account.is_known.then_some(self.account.gain / scale);
        self.figures.added = self.account.added / scale;
        for tissue in &self.world.tissues {
            self.figures.away = self.figures.away.max(tissue.farthest_from_goal(&self.x));
        }
    }

    fn bones_are_still(&self) -> bool {
        let (time, h) = (self.world.time, self.setting.step);
        self.world.bones.iter().all(|bone| bone.drive.motion(time, h).velocity == DVec3::ZERO)
    }

    fn is_lost(&self) -> bool {
        let start = self.world.start.iter();
        let is_far = self.x.iter().zip(start).any(|(x, start)| {
            let distance = x.distance(*start);
            distance.is_nan() || distance > LOST_DISTANCE
        });
        is_far || self.v.iter().any(|v| v.is_nan() || v.length() > LOST_SPEED)
    }

    /// Returns the mean velocity of all soft particles.
    fn velocity(&self) -> DVec3 {
        let first = self.world.tissues[0].particles.start;
        self.v[first..].iter().sum::<DVec3>() / as_f64(self.v.len() - first)
    }

    fn centers(&self) -> Vec<DVec3> {
        self.world.tissues.iter().map(|tissue| tissue.center(&self.x)).collect()
    }

    fn kinetic(&self) -> f64 {
        let mut energy = 0.0;
        for tissue in &self.world.tissues {
            let v = self.v[tissue.particles.clone()].iter();
            energy += v.map(|v| 0.5 * tissue.mass * v.length_squared()).sum::<f64>();
        }
        energy
    }

    fn potential(&mut self) -> f64 {
        let time = self.world.time;
        potential(self.world, &self.x, time)
    }
}

/// Sums over the part at rest.
#[derive(Clone, Copy, Debug, Default)]
struct Rested {
    squares: f64,
    particles: f64,
    changes: f64,
    steps: f64,
}

impl Account {
    /// Includes the energy at the start of a step.
    fn include(&mut self, moment: &Moment) {
        // Energy that bones, goals and corrections have put in is no gain.
        let energy = moment.kinetic + moment.potential + moment.contact - self.work - self.added;
        let start = *self.start.get_or_insert(energy);
        self.gain = self.gain.max(energy - start);
        self.largest = self.largest.max((moment.potential - start).abs()).max(moment.kinetic);
    }

    /// Returns the energy that gains are compared with: that of the fall, or the largest.
    fn scale(&self, world: &World) -> f64 {
        let mut fall = 0.0;
        for tissue in &world.tissues {
            let mass = tissue.mass * as_f64(tissue.particles.len());
            fall += mass * world.gravity.length() * world.drop;
        }
        if fall > 0.0 { fall } else { self.largest.max(1e-12) }
    }
}

/// Computes the energy of springs and gravity.
fn potential(world: &mut World, x: &[DVec3], time: f64) -> f64 {
    let mut energy = 0.0;
    for tissue in &mut world.tissues {
        energy += tissue.follow(x, time);
        let sum: DVec3 = x[tissue.particles.clone()].iter().sum();
        energy -= tissue.mass * world.gravity.dot(sum);
    }
    energy
}

/// Computes the largest depth of a vertex in another body, exactly; of the surfaces, within
/// `DEPTH_TOLERANCE`, where edges cross and no vertex is inside.
///
/// # Errors
///
/// As [`Scene::check`].
pub fn exact_depth(scene: &mut Scene) -> Result<f64, SceneError> {
    let (mut depth, mut has_edges) = (0.0_f64, false);
    for report in scene.check(&CheckParams::without_measures(0.0), Progress::none())? {
        depth = depth.max(report.max_vertex_depth);
        has_edges |= report.overlaps && report.max_vertex_depth <= 0.0;
    }

    // Depths of surfaces take a search: it runs only if a pair overlaps without a vertex inside.
    if has_edges {
        let params =
            CheckParams { depth_tolerance: Some(DEPTH_TOLERANCE), ..CheckParams::new(0.0) };
        for report in scene.check(&params, Progress::none())? {
            depth = depth.max(report.max_depth().map_or(0.0, |bracket| bracket.lower));
        }
    }
    Ok(depth)
}

/// Runs a scene for its duration.
///
/// # Errors
///
/// Those of detection and response.
pub fn run(
    world: &mut World,
    detectors: &mut StepDetectors,
    response: Response,
    setting: Setting,
) -> Result<Figures, StepError> {
    let steps = steps_in(world.duration, setting.step);
    Simulation::new(world, detectors, response, setting)?.run(steps, &mut |_| ())
}
