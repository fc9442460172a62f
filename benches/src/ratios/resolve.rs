//! Overlap removal on real anatomy: displacements beside depths, times, and the frames of a gait of
//! which each is resolved by itself.

use std::error::Error;
use std::path::Path;

use fixtures::data;
use musculo_collide::{Progress, Resolution, ResolveParams, Scene, WrittenPrecision, resolve};

use crate::gait::{BONES, Motion, smoothing, thigh};
use crate::measure::{Report, nanoseconds};

/// Gap to be opened \[mm\].
const GAP: f64 = 0.05;

/// Scene with the gap opened, as far as it goes.
struct Resolved {
    resolution: Resolution,
    /// Pairs with a soft body that are not proved to keep the gap.
    short_pairs: usize,
    seconds: f64,
}

/// Reports the thigh at rest, at both resolutions, and all frames of a gait; skips without data.
pub(super) fn run(report: &mut Report) -> Result<(), Box<dyn Error>> {
    let Some(folder) = data::anatomy("overlap removal of the thigh") else { return Ok(()) };
    for (name, set, seconds) in
        [("full", "vhf_left_thigh", 6.0), ("coarse", "vhf_left_thigh_lo", 0.6)]
    {
        at_rest(name, &mut thigh(&folder.join(set))?, seconds, report)?;
    }
    frames_alone(&folder, report)
}

/// Reports one thigh at rest. Times have no bound: they are of a machine and its load.
fn at_rest(
    name: &str,
    scene: &mut Scene,
    aim: f64,
    report: &mut Report,
) -> Result<(), Box<dyn Error>> {
    let resolved = Resolved::new(scene)?;
    let short = f64::from(u32::try_from(resolved.short_pairs)?);
    report.cost(format!("{name} thigh: pairs below the gap"), short, "pairs", 0.0);

    // The aim is 1.3. Muscle around the rim of the pelvis has a longer way out than it is deep.
    let displacements = [resolved.max_displacement(), resolved.depth()];
    report.ratio(format!("{name} thigh: displacement / depth"), displacements, "mm", 1.5);
    let times = [resolved.seconds, aim];
    report.ratio(format!("{name} thigh: time / aim"), times, "s", f64::INFINITY);
    Ok(())
}

/// Reports the frames of a gait, each without the one before it.
fn frames_alone(folder: &Path, report: &mut Report) -> Result<(), Box<dyn Error>> {
    let motion = Motion::read(&folder.join("motions/gait_walk.json"))?;
    let at_rest = thigh(&folder.join("vhf_left_thigh_lo"))?;
    let (mut held, mut slowest, mut farthest) = (0, 0.0_f64, 0.0_f64);
    for maps in &motion.frames {
        let mut scene = at_rest.clone();
        for id in at_rest.ids() {
            let body = at_rest.body(id);
            let bone = BONES.iter().find(|(name, _)| *name == body.name());
            let mut moved = Vec::with_capacity(body.positions().len());
            for &x in body.positions() {
                moved.push(match bone {
                    Some((_, None)) => x,
                    Some((_, Some(map))) => maps[*map].0 * x + maps[*map].1,
                    None => motion.skinned(x, maps),
                });
            }
            scene.move_body(id, &moved)?;
        }
        let resolved = Resolved::new(&mut scene)?;
        held += u32::from(resolved.short_pairs > 0);
        slowest = slowest.max(resolved.seconds);
        farthest = farthest.max(resolved.max_displacement() / resolved.depth());
    }

    // The aim is none: in one, a muscle stays at the ischium.
    let count = u32::try_from(motion.frames.len())?;
    let frames = [f64::from(held), f64::from(count)];
    report.ratio("gait frames alone: not free / all", frames, "frames", 0.03);
    report.cost("gait frames alone: displacement / depth", farthest, "", f64::INFINITY);
    report.cost("gait frames alone: slowest", slowest, "s", f64::INFINITY);
    Ok(())
}

impl Resolved {
    fn new(scene: &mut Scene) -> Result<Self, Box<dyn Error>> {
        let params = ResolveParams::with_smoothing(smoothing(scene)?);
        let params = ResolveParams { gap: GAP, precision: WrittenPrecision::Single, ..params };
        let mut result = None;
        let time = nanoseconds(|| {
            result = Some(resolve(scene, &params, Progress::none()));
            scene.bodies().len()
        });
        let resolution = result.ok_or("no result")??;

        // Bones may be nearer to each other, and stay.
        let is_soft = |id: &musculo_collide::BodyId| !scene.body(*id).is_rigid();
        let mut short_pairs = 0;
        for short in &resolution.gap.short {
            short_pairs += usize::from(short.pair.bodies().iter().any(is_soft));
        }
        Ok(Self { resolution, short_pairs, seconds: time * 1e-9 })
    }

    fn max_displacement(&self) -> f64 {
        self.resolution.bodies.iter().map(|change| change.max_displacement).fold(0.0, f64::max)
    }

    /// Returns the depth of the deepest overlap at the start.
    fn depth(&self) -> f64 {
        self.resolution.rounds[0].surface_depth.map_or(0.0, |depth| depth.upper)
    }
}
