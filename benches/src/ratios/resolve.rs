//! Overlap removal on real anatomy: displacements beside depths, times, and the frames of a gait, each
//! resolved by itself and from the one before.

use std::error::Error;
use std::path::Path;
use std::time::Instant;

use fixtures::data;
use glam::{DQuat, DVec3};
use musculo_collide::{
    BodyId, CheckParams, Progress, Resolution, ResolveParams, Resolver, Scene, SceneError,
    WrittenPrecision,
};

use crate::gait::{BONES, Motion, resolve_params, thigh};
use crate::measure::{Report, as_f64};

/// Gap to be opened \[mm\].
const GAP: f64 = 0.05;

/// Distance from all overlaps beyond which vertices are far from them \[mm\].
const FAR: f64 = 10.0;

/// Name, value, unit and bound of a figure.
type Figure = (&'static str, f64, &'static str, f64);

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
    gait(&folder, report)
}

/// Reports one thigh at rest. Times have no bound: they are of a machine and its load.
fn at_rest(
    name: &str,
    scene: &mut Scene,
    aim: f64,
    report: &mut Report,
) -> Result<(), Box<dyn Error>> {
    let mut resolver = Resolver::new(params(scene)?)?;
    let mut start = scene.clone();
    let resolved = Resolved::new(scene, &mut resolver)?;
    let short = f64::from(u32::try_from(resolved.short_pairs)?);
    report.cost(format!("{name} thigh: pairs below the gap"), short, "pairs", 0.0);

    // The aim is 1.3. Muscle around the rim of the pelvis has a longer way out than it is deep.
    let displacements = [resolved.max_displacement(), resolved.depth()];
    report.ratio(format!("{name} thigh: displacement / depth"), displacements, "mm", 1.5);
    let times = [resolved.seconds, aim];
    for (figure, value, unit, bound) in resolved.damage(&mut start)? {
        report.cost(format!("{name} thigh: {figure}"), value, unit, bound);
    }
    report.ratio(format!("{name} thigh: time / aim"), times, "s", f64::INFINITY);
    Ok(())
}

/// Reports the frames of a gait, each without the one before it, and as a walk.
fn gait(folder: &Path, report: &mut Report) -> Result<(), Box<dyn Error>> {
    let motion = Motion::read(&folder.join("motions/gait_walk.json"))?;
    let at_rest = thigh(&folder.join("vhf_left_thigh_lo"))?;

    let mut walking = at_rest.clone();
    place(&mut walking, &at_rest, &motion, &motion.frames[0])?;
    let mut carrying = Resolver::new(params(&mut walking)?)?;
    let (mut alone, mut walk) = (Frames::default(), Frames::default());
    for maps in &motion.frames {
        place(&mut walking, &at_rest, &motion, maps)?;
        walk.add(&Resolved::new(&mut walking, &mut carrying)?);

        let mut scene = at_rest.clone();
        place(&mut scene, &at_rest, &motion, maps)?;
        let mut resolver = Resolver::new(params(&mut scene)?)?;
        alone.add(&Resolved::new(&mut scene, &mut resolver)?);
    }

    // How deep starts end depends on small things.
    alone.report("gait frames alone", 0.03, report);
    walk.report("gait as a walk", 0.03, report);
    Ok(())
}

/// Moves the thigh to one frame of a gait.
fn place(
    scene: &mut Scene,
    at_rest: &Scene,
    motion: &Motion,
    maps: &[(DQuat, DVec3); 3],
) -> Result<(), SceneError> {
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
    Ok(())
}

/// Returns parameters for the overlaps of a scene as it is.
fn params(scene: &mut Scene) -> Result<ResolveParams, Box<dyn Error>> {
    let params = resolve_params(scene)?;
    Ok(ResolveParams { gap: GAP, precision: WrittenPrecision::Single, ..params })
}

/// Frames of a gait that are resolved.
#[derive(Default)]
struct Frames {
    /// Number of those with a pair below the gap.
    held: u32,
    /// Largest displacement over the deepest overlap.
    farthest: f64,
    seconds: Vec<f64>,
}

impl Frames {
    fn add(&mut self, resolved: &Resolved) {
        self.held += u32::from(resolved.short_pairs > 0);
        self.farthest = self.farthest.max(resolved.max_displacement() / resolved.depth());
        self.seconds.push(resolved.seconds);
    }

    /// Reports all frames, of which a share may not come free.
    fn report(mut self, name: &str, held: f64, report: &mut Report) {
        let frames = [f64::from(self.held), as_f64(self.seconds.len())];
        report.ratio(format!("{name}: not free / all"), frames, "frames", held);
        report.cost(format!("{name}: displacement / depth"), self.farthest, "", f64::INFINITY);

        self.seconds.sort_by(f64::total_cmp);
        let (median, slowest) = (self.seconds[self.seconds.len() / 2], self.seconds.last());
        report.cost(format!("{name}: median"), median, "s", f64::INFINITY);
        report.cost(format!("{name}: slowest"), *slowest.unwrap_or(&median), "s", f64::INFINITY);
    }
}

/// Lists the vertices of all bodies that are inside another, or of a face that crosses one.
fn overlapping_vertices(scene: &mut Scene) -> Result<Vec<DVec3>, Box<dyn Error>> {
    let reports = scene.check(&CheckParams::without_measures(0.0), Progress::none())?;
    let mut vertices = Vec::new();
    for report in reports {
        let [a, b] = report.pair.bodies().map(|id| scene.body(id));
        for (body, side) in [(a, &report.a_against_b), (b, &report.b_against_a)] {
            let inside = side.near.iter().filter(|near| near.gap < 0.0);
            vertices.extend(inside.map(|near| body.positions()[near.vertex as usize]));
        }
        for [face_a, face_b] in report.crossing_faces {
            vertices.extend(a.corners(face_a).into_iter().chain(b.corners(face_b)));
        }
    }
    Ok(vertices)
}

impl Resolved {
    fn new(scene: &mut Scene, resolver: &mut Resolver) -> Result<Self, Box<dyn Error>> {
        let start = Instant::now();
        let resolution = resolver.resolve(scene, Progress::none())?;
        let seconds = start.elapsed().as_secs_f64();

        // Bones may be nearer to each other, and stay.
        let is_soft = |id: &BodyId| !scene.body(*id).is_rigid();
        let mut short_pairs = 0;
        for short in &resolution.gap.short {
            short_pairs += usize::from(short.pair.bodies().iter().any(is_soft));
        }
        Ok(Self { resolution, short_pairs, seconds })
    }

    fn max_displacement(&self) -> f64 {
        self.resolution.bodies.iter().map(|change| change.max_displacement).fold(0.0, f64::max)
    }

    /// Lists what else is promised of a thigh, with units and bounds; `start` is the scene before.
    fn damage(&self, start: &mut Scene) -> Result<[Figure; 4], Box<dyn Error>> {
        let (mut volume, mut flips, mut crossings) = (0.0_f64, 0, 0);
        for change in &self.resolution.bodies {
            volume = volume.max(change.volume_ratio.map_or(0.0, |ratio| (ratio - 1.0).abs()));
            flips += change.flipped_faces;
            let [before, after] = change.self_crossings;
            crossings += after.saturating_sub(before);
        }
        let mut far = self.far_displacements(start)?;
        far.sort_by(f64::total_cmp);
        let median = far.get(far.len() / 2).copied().unwrap_or_default();
        Ok([
            ("change of a volume", 100.0 * volume, "%", 0.2),
            ("faces turned over", as_f64(flips), "faces", 0.0),
            ("new self-crossings", as_f64(crossings), "pairs", 0.0),
            ("median displacement far from overlaps", median, "mm", 0.0),
        ])
    }

    /// Lists how far vertices of soft bodies move that are far from all vertices inside another body and
    /// all faces that cross one.
    fn far_displacements(&self, start: &mut Scene) -> Result<Vec<f64>, Box<dyn Error>> {
        let overlapping = overlapping_vertices(start)?;
        let mut lengths = Vec::new();
        for (body, change) in start.bodies().iter().zip(&self.resolution.bodies) {
            if body.is_rigid() {
                continue;
            }
            for (x, displacement) in body.positions().iter().zip(&change.displacements) {
                let is_far = |y: &DVec3| x.distance_squared(*y) > FAR * FAR;
                if overlapping.iter().all(is_far) {
                    lengths.push(displacement.length());
                }
            }
        }
        Ok(lengths)
    }

    /// Returns the depth of the deepest overlap at the start.
    fn depth(&self) -> f64 {
        self.resolution.rounds[0].surface_depth.map_or(0.0, |depth| depth.upper)
    }
}
