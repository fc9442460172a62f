//! Detection and response over time: rest, slopes, thin plates, mass ratios, permanent contacts,
//! and the gait of a thigh.

use std::error::Error;

use ::response::{
    Constraint, ContactLaw, ContactRows, ContactSystem, Margins, Restraint, SolveLevel,
    SolverMethod, SolverParams, SweepOrder,
};
use fixtures::shapes::icosphere;
use glam::{DQuat, DVec3};
use musculo_collide::scene::{PermanentParams, StepDetectors};
use musculo_collide::{
    BodyId, Material, PairId, ParticleLoads, RigidMotion, SceneStates, SceneStep, StepLength,
    StepParams,
};
use surface::Pose;

use crate::gait;
use crate::measure::{Report, as_f64, nanoseconds};
use crate::sheets::Sheets;
use crate::stability::detector::TOLERANCE;
use crate::stability::scenes::World;
use crate::stability::simulation::Simulation;
use crate::stability::{Detector, Figures, Planted, Response, Setting, simulation};

/// Steps at rest.
const REST_STEPS: u32 = 10_000;

/// Vertices along a side of the sheets: about 1,000 contacts.
const SIDE: u32 = 32;

/// Steps whose detection is timed.
const CARRIED_STEPS: u32 = 400;

/// Largest mass over the smallest.
const MASS_RATIO: f64 = 1e4;

/// Responses that have to rest and to stick.
const RESTING: [Response; 3] = [Response::Sequence, Response::Velocity, Response::SoftImplicit];

type Outcome = Result<(), Box<dyn Error>>;
type Part = fn(&mut Report) -> Outcome;

/// Parts by the beginning of the names of their figures.
const PARTS: [(&str, Part); 6] = [
    ("mass ratio", mass_ratio),
    ("thin plate", thin_plate),
    ("slope", slopes),
    ("contacts", permanent),
    ("gait", gait::run),
    ("rest", rest),
];

/// Reports what every combination that is promised to hold keeps.
pub(super) fn run(report: &mut Report) -> Outcome {
    for (beginning, part) in PARTS {
        if report.wants(beginning) {
            part(report)?;
        }
    }
    Ok(())
}

/// A ball of 642 vertices let down on a bone.
fn rest(report: &mut Report) -> Outcome {
    let steps = report.rounds(REST_STEPS);
    for detector in Detector::ALL {
        if !report.wants(&format!("rest {}", detector.name())) {
            continue;
        }
        let mut world = World::at_rest(icosphere(10.0, 3))?;
        let mut detectors = detector.prepare(&world)?;

        // Structures are built once; kept contacts are forgotten between responses.
        for response in RESTING {
            let name = format!("rest {}, {}", detector.name(), response.name());
            if !report.wants(&name) {
                continue;
            }
            detector.restart(&mut detectors, &world)?;
            let simulation = Simulation::new(&mut world, &mut detectors, response, Setting::BASE)?;
            let figures = simulation.run(steps, &mut |_| ())?;

            report.cost(format!("{name}: move per step"), 1e3 * figures.jitter, "µm", 5.0);
            report.cost(format!("{name}: exact overlap"), figures.overlap, "mm", 0.2);
            let gain = figures.energy.unwrap_or(f64::NAN);
            report.cost(format!("{name}: energy gained / fall"), gain, "", 1e-6);
        }
    }
    Ok(())
}

/// A slab on a slope of 20° that sticks, and one that slides.
fn slopes(report: &mut Report) -> Outcome {
    for detector in Detector::ALL {
        for response in [Response::Sequence, Response::Velocity, Response::Acceleration] {
            let name = format!("slope {}, {}", detector.name(), response.name());
            if !report.wants(&name) {
                continue;
            }
            let creep = format!("{name}: creep at µ 0.5");
            match figures(Planted::SlopeHeld, detector, response)? {
                Some(held) => report.cost(creep, held.creep, "mm/s", 1e-4),
                None => refused(&creep, report),
            }

            // The slide is a share of the acceleration in closed form, also over vertices of the bone.
            let scenes =
                [(Planted::SlopeSliding, "slide"), (Planted::SlopeCatching, "slide over vertices")];
            for (planted, what) in scenes {
                let slide = format!("{name}: error of the {what}");
                match figures(planted, detector, response)? {
                    Some(sliding) => report.cost(slide, (sliding.slide - 1.0).abs(), "", 0.02),
                    None => refused(&slide, report),
                }
            }
        }
    }
    Ok(())
}

/// Vertices that leave a bone of 1 mm by the far side.
fn thin_plate(report: &mut Report) -> Outcome {
    for detector in Detector::ALL {
        for approach in [0.3, 0.8, 1.0] {
            let mut world = Planted::ThinPlate.build()?;
            world.approach = DVec3::Z * -approach;
            let name = format!("thin plate {}, {approach} mm per step", detector.name());
            if !report.wants(&name) {
                continue;
            }
            let Ok(mut detectors) = detector.prepare(&world) else {
                refused(&name, report);
                continue;
            };
            let found =
                simulation::run(&mut world, &mut detectors, Response::Sequence, Setting::BASE)?;
            report.cost(format!("{name}: overlap"), found.overlap, "mm", 0.2);
            report.cost(format!("{name}: far side"), as_f64(found.far_side), "vertices", 0.0);
        }
    }
    Ok(())
}

/// Runs a scene; `None` where the detector refuses its bodies.
fn figures(
    planted: Planted,
    detector: Detector,
    response: Response,
) -> Result<Option<Figures>, Box<dyn Error>> {
    let mut world = planted.build()?;
    let Ok(mut detectors) = detector.prepare(&world) else { return Ok(None) };
    Ok(Some(simulation::run(&mut world, &mut detectors, response, Setting::BASE)?))
}

/// Adds a line for bodies that a detector refuses: no promise is made of them.
fn refused(name: &str, report: &mut Report) {
    report.cost(format!("{name}: refused"), 1.0, "", f64::INFINITY);
}

/// A thousand two-sided contacts that share particles of very different masses.
fn mass_ratio(report: &mut Report) -> Outcome {
    let sheets = Sheets::new(SIDE)?;

    // One particle of three is heavy, so that contacts couple both extremes of mass.
    let mut inverse_mass = sheets.inverse_mass.clone();
    for w in inverse_mass.iter_mut().step_by(3) {
        *w = MASS_RATIO.recip();
    }

    // Two-sided contacts make the system linear, which conjugate gradients need.
    let law = ContactLaw::new(Margins::new(0.0, 1.0)?, 0.0)?;
    let mut rows = ContactRows::new(sheets.x.len());
    for contact in &sheets.contacts {
        rows.push_constraint(contact, law, Constraint::TwoSided(0.0))?;
    }
    let system = ContactSystem::new(&rows, &inverse_mass, SweepOrder::Colored)?;

    // Cold, then warm for velocities that differ by 1 %.
    let solve = |method, v: &mut [DVec3], impulses: &mut [_]| {
        let params = SolverParams { method, max_iterations: 100_000, tolerance: 1e-9 };
        system.solve(SolveLevel::Velocity, v, impulses, &params)
    };
    let methods = [
        (SolverMethod::ConjugateGradient, "conjugate gradient", [1000.0, 100.0]),
        (SolverMethod::GaussSeidel, "Gauss–Seidel", [f64::INFINITY; 2]),
        (SolverMethod::AveragedJacobi, "Jacobi", [f64::INFINITY; 2]),
    ];
    for (method, name, allowed) in methods {
        let (mut v, mut impulses) = (sheets.v.clone(), system.no_impulses());
        let cold = solve(method, &mut v, &mut impulses)?;
        let momentum = momentum_error(&sheets.v, &v, &inverse_mass);

        // The warm start has the impulses of the cold solve.
        let mut next: Vec<DVec3> = sheets.v.iter().map(|v| 1.01 * *v).collect();
        let warm = solve(method, &mut next, &mut impulses)?;

        for (when, solved, allowed) in [("cold", cold, allowed[0]), ("warm", warm, allowed[1])] {
            let name = format!("mass ratio 1e4, {name}, {when}");
            report.cost(format!("{name}: iterations"), f64::from(solved.iterations), "", allowed);
            let bound = if allowed.is_finite() { 1e-9 } else { f64::INFINITY };
            report.cost(format!("{name}: residual"), solved.conditions.max(), "", bound);
        }
        report.cost(format!("mass ratio 1e4, {name}: momentum"), momentum, "", 1e-12);
    }
    Ok(())
}

/// Returns the change of all momentum over the sum of its changes.
fn momentum_error(before: &[DVec3], after: &[DVec3], inverse_mass: &[f64]) -> f64 {
    let (mut sum, mut size) = (DVec3::ZERO, 0.0);
    for ((before, after), w) in before.iter().zip(after).zip(inverse_mass) {
        let change = (*after - *before) / *w;
        sum += change;
        size += change.length();
    }
    sum.length() / size
}

/// Detection of a ball that rests on a bone, both of which move by 1 mm per step: contacts that are
/// kept, beside contacts found anew.
///
/// The fastest step counts: other work on the machine leaves some of so short times alone.
fn permanent(report: &mut Report) -> Outcome {
    // Sides take turns on one thread, so that no other one's time is left out.
    let mut fastest = [f64::INFINITY; 3];
    let kept = [Some(Restraint::Sticking), Some(Restraint::Sliding), None];
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    one.install(|| -> Result<(), String> {
        let mut sides = Vec::new();
        for restraint in kept {
            sides.push(Carried::new(restraint).map_err(|error| error.to_string())?);
        }
        for _ in 0..CARRIED_STEPS {
            for (side, fastest) in sides.iter_mut().zip(&mut fastest) {
                let time = side.advance().map_err(|error| error.to_string())?;
                *fastest = fastest.min(time);
            }
        }
        Ok(())
    })?;
    let [sticking, sliding, anew] = fastest;
    report.times("contacts kept, sticking / found anew, 1 mm per step", [sticking, anew], 0.2);
    report.times("contacts kept, sliding / found anew, 1 mm per step", [sliding, anew], 1.0);
    drift(report)
}

/// Distance of bodies on kept contacts from where they are with contacts found anew, and the depth that
/// kept contacts do not report.
fn drift(report: &mut Report) -> Outcome {
    for planted in [Planted::Rest, Planted::Squeeze, Planted::DrivenIn, Planted::Shortening] {
        let mut ends = Vec::new();
        let mut missed = 0.0;
        for detector in [Detector::Exact, Detector::Permanent] {
            let mut world = planted.build()?;
            let mut detectors = detector.prepare(&world)?;
            let (response, setting) = (Response::Velocity, Setting::BASE);
            missed = simulation::run(&mut world, &mut detectors, response, setting)?.missed_depth;
            ends.push(world.scene.particle_positions());
        }

        let mut largest = 0.0_f64;
        for (anew, kept) in ends[0].iter().zip(&ends[1]) {
            largest = largest.max(anew.distance(*kept));
        }
        let name = format!("contacts kept, {}", planted.name());
        report.cost(format!("{name}: drift from those found anew"), largest, "mm", f64::INFINITY);
        report.cost(format!("{name}: depth that is missed"), missed, "mm", TOLERANCE);
    }
    Ok(())
}

/// A ball and its bone in the same motion.
struct Carried {
    world: World,
    detectors: StepDetectors,
    step: SceneStep,
    x: Vec<DVec3>,
    v: Vec<DVec3>,
    w: Vec<f64>,
}

impl Carried {
    /// Returns a ball whose contacts are kept, or found anew without a restraint.
    fn new(kept: Option<Restraint>) -> Result<Self, Box<dyn Error>> {
        let world = World::at_rest(icosphere(10.0, 4))?;
        let mut detectors = Detector::Exact.prepare(&world)?;
        if let Some(restraint) = kept {
            let params = PermanentParams { restraint, skin: 0.5, attach_within: 0.0 };
            let ids: Vec<BodyId> = world.scene.ids().collect();
            detectors.set_permanent(PairId::new(ids[0], ids[1]), params)?;
        }

        // The ball is sunk in by 0.2 mm, so that contacts are there from the first step.
        let mut x = world.start.clone();
        for x in &mut x[world.tissues[0].particles.clone()] {
            x.z -= 0.5;
        }
        let (v, w) = (vec![DVec3::ZERO; x.len()], vec![1.0; x.len()]);
        let step = SceneStep::new(Material::hard(Margins::new(0.0, 0.5)?));
        Ok(Self { world, detectors, step, x, v, w })
    }

    /// Detects contacts in a step, in which nothing is corrected; returns the time of that \[ns\].
    fn advance(&mut self) -> Result<f64, Box<dyn Error>> {
        let Self { world, detectors, step, x, v, w } = self;
        let bone = world.bones[0].id;
        let from = world.scene.body(bone).pose().map_or(DVec3::ZERO, |pose| pose.translation());

        // Bone and ball move alike, so that all contacts can be kept.
        let way = DVec3::X;
        let pose = Pose::new(DQuat::IDENTITY, from + way);
        let motion = RigidMotion { velocity: 1e3 * way, ..RigidMotion::default() };
        step.move_bone(&mut world.scene, bone, &pose, motion)?;
        for x in &mut x[world.tissues[0].particles.clone()] {
            *x += way;
        }

        // Without tolerances nothing is corrected: the step detects once.
        let params = StepParams {
            depth_tolerance: None,
            approach_tolerance: None,
            ..StepParams::new(StepLength::new(1e-3)?)
        };
        let states = SceneStates { x, v, loads: ParticleLoads::None, inverse_mass: w };
        let mut time = 0.0;
        let found = step.correct(&mut world.scene, states, &params, |scene, contacts| {
            let mut detected = Ok(());
            time = nanoseconds(|| {
                detected = detectors.detect(scene, contacts);
                usize::from(detected.is_ok())
            });
            detected
        })?;
        if found.contacts == 0 {
            return Err("no contacts to keep".into());
        }
        Ok(time)
    }
}
