//! Contacts outside that can touch next, and ridges that cross: planted by detector.

use fixtures::Mesh;
use fixtures::shapes::plate;
use glam::{DQuat, DVec3};
use medial::{MedialDetector, MedialParams};
use response::{Margins, Material, ParticleLoads, Restraint, RigidMotion, StepLength, StepParams};
use scene::{
    BodyId, BodyKind, CheckParams, DetectorParams, FallbackReason, FieldDetector, PairId,
    PermanentParams, Progress, Scene, SceneStates, SceneStep, StepDetectors, StepError, StepMethod,
};
use surface::{Contact, Pose};

const MARGIN: f64 = 0.5;

/// A bone and a soft body, with what detects them.
struct Pair {
    scene: Scene,
    bone: BodyId,
    soft: BodyId,
    step: SceneStep,
    detectors: StepDetectors,
}

impl Pair {
    fn new(bone: Mesh, soft: Mesh) -> Self {
        let mut scene = Scene::new();
        let bone = scene.add("bone", BodyKind::Rigid, bone.surface(), bone.positions);
        let soft = scene.add("soft", BodyKind::Deformable, soft.surface(), soft.positions);
        let margins = Margins::new(0.0, MARGIN).expect("in range");
        let params = DetectorParams { margin: MARGIN, tolerance: 0.2 };
        Self {
            scene,
            bone: bone.expect("a bone"),
            soft: soft.expect("a soft body"),
            step: SceneStep::new(Material::hard(margins)),
            detectors: StepDetectors::new(params).expect("in range"),
        }
    }

    fn id(&self) -> PairId {
        PairId::new(self.bone, self.soft)
    }

    fn keep(&mut self, restraint: Restraint) {
        let params = PermanentParams { restraint, skin: 1.0, attach_within: 0.01 };
        self.detectors.set_permanent(self.id(), params).expect("in range");
    }

    fn set_field(&mut self) {
        let body = self.scene.body(self.bone);
        let (surface, x) = (body.surface(), body.checked_positions());
        let params = distance_field::FieldParams::new(0.25);
        let field = distance_field::DistanceField::build(surface, x, &params, Progress::none());
        let field = FieldDetector::new(field.expect("closed"), MARGIN).expect("in range");
        self.detectors.set_field(self.bone, field);
        self.detectors.set_default_method(StepMethod::Field);
    }

    fn set_balls(&mut self) {
        let body = self.scene.body(self.bone);
        let (surface, x) = (body.surface(), body.checked_positions());
        let params = MedialParams::balls(10);
        let balls = MedialDetector::new(surface, x, MARGIN + 1.0, &params, Progress::none());
        self.detectors.set_balls(self.bone, balls.expect("closed"));
        self.detectors.set_default_method(StepMethod::Balls);
    }

    /// Detects without correction.
    fn detect(&mut self) -> Result<Vec<Contact>, StepError> {
        let mut x = self.scene.particle_positions();
        let (mut v, w) = (vec![DVec3::ZERO; x.len()], vec![1.0; x.len()]);
        let loads = ParticleLoads::None;
        let states = SceneStates { x: &mut x, v: &mut v, loads, inverse_mass: &w };
        let h = StepLength::new(1e-3).expect("in range");
        let params =
            StepParams { depth_tolerance: None, approach_tolerance: None, ..StepParams::new(h) };
        let detectors = &mut self.detectors;
        self.step.correct(&mut self.scene, states, &params, |scene, contacts| {
            detectors.detect(scene, contacts)
        })?;
        Ok(self.step.contact_step().contacts().contacts().to_vec())
    }

    /// Counts vertices within the margin, by all closest points.
    fn near_count(&mut self, tilt: f64) -> usize {
        let reports = self.scene.check(&CheckParams::without_measures(MARGIN), Progress::none());
        let reports = reports.expect("valid");
        let near = reports
            .iter()
            .flat_map(|report| report.a_against_b.near.iter().chain(&report.b_against_a.near));
        near.filter(|near| near.normal.z.abs() < tilt).count()
    }
}

/// A slab of 7 × 8 × 3 over a flat bone with vertices every 2, its front edge just behind a row.
fn slab_on_bone(height: f64) -> [Mesh; 2] {
    let bone = plate(DVec3::new(40.0, 20.0, 4.0), [20, 10]).translated(DVec3::Z * -2.0);
    let slab = plate(DVec3::new(7.0, 8.0, 3.0), [4, 4]);
    [bone, slab.translated(DVec3::new(0.45, 0.3, 1.5 + height))]
}

/// Vertices just ahead of a slab are within its margin, with normals along the way: they are no
/// contacts, by whichever detector, and whether the bone is flat or the soft body.
#[test]
fn vertices_ahead_of_a_sliding_body_do_not_stop_it() {
    let detectors: [fn(&mut Pair); 4] = [
        |_| (),
        Pair::set_field,
        |pair| pair.keep(Restraint::Sliding),
        |pair| pair.keep(Restraint::Sticking),
    ];
    for is_bone_flat in [true, false] {
        for (number, set) in detectors.iter().enumerate() {
            let [flat, slab] = slab_on_bone(0.02);
            let mut pair = if is_bone_flat { Pair::new(flat, slab) } else { Pair::new(slab, flat) };
            set(&mut pair);
            assert!(pair.near_count(0.5) > 3, "ghosts are near");
            let found = pair.detect().expect("valid");
            assert!(found.len() >= 25, "{number}: {}", found.len());
            for contact in found {
                assert!(contact.normal.z.abs() > 0.999, "{is_bone_flat} {number}: {contact:?}");
            }
        }
    }
}

/// A kept list holds the vertices ahead: they act once the slab is over them.
#[test]
fn vertices_ahead_are_kept_for_later() {
    let [bone, slab] = slab_on_bone(0.02);
    let mut pair = Pair::new(bone, slab);
    pair.keep(Restraint::Sliding);
    let before = pair.detect().expect("valid").len();
    let moved: Vec<DVec3> =
        pair.scene.body(pair.soft).positions().iter().map(|x| *x + DVec3::X * 0.1).collect();
    pair.scene.move_body(pair.soft, &moved).expect("finite");
    let after = pair.detect().expect("valid").len();
    assert_eq!(pair.detectors.kept().next().map(|kept| kept.since), Some(0));
    assert!(after >= before + 3, "{before} {after}");
}

/// A vertex that a round of corrections has pushed out may be just ahead of the body then. It stays in
/// contact for the other rounds of the step, and no longer.
#[test]
fn vertices_that_touched_stay_in_contact_until_the_step_ends() {
    let [bone, slab] = slab_on_bone(0.02);
    let mut pair = Pair::new(bone, slab);
    let fresh = pair.detect().expect("valid").len();

    // Two detections of one step: pressed in a little further ahead, then back.
    let back = pair.scene.body(pair.soft).positions().to_vec();
    let pressed: Vec<DVec3> = back.iter().map(|x| *x + DVec3::new(0.1, 0.0, -0.05)).collect();
    let (mut x, soft, detectors) =
        (pair.scene.particle_positions(), pair.soft, &mut pair.detectors);
    let (mut v, w) = (vec![DVec3::ZERO; x.len()], vec![1.0; x.len()]);
    let states = SceneStates { x: &mut x, v: &mut v, loads: ParticleLoads::None, inverse_mass: &w };
    let h = StepLength::new(1e-3).expect("in range");
    let params =
        StepParams { depth_tolerance: None, approach_tolerance: None, ..StepParams::new(h) };
    let mut counts = Vec::new();
    let detect = |scene: &mut Scene, contacts: &mut scene::PairContacts<'_>| {
        for state in [&pressed, &back] {
            scene.move_body(soft, state)?;
            detectors.detect(scene, contacts)?;
            counts.push(contacts.len());
        }
        Ok::<(), StepError>(())
    };
    pair.step.correct(&mut pair.scene, states, &params, detect).expect("valid");
    let again = counts[1] - counts[0];
    assert!(again >= fresh + 3, "{fresh}, {counts:?}");
    assert_eq!(pair.detect().expect("valid").len(), fresh, "another step");
}

/// A needle of a half angle of 3°, its tip at the origin.
fn needle(lean: f64) -> Mesh {
    let mut positions = vec![DVec3::ZERO];
    for k in 0..6 {
        let turn = DQuat::from_rotation_z(std::f64::consts::TAU * f64::from(k) / 6.0);
        positions.push(turn * DVec3::new(1.0, 0.0, -19.0));
    }
    let mut faces = Vec::new();
    for k in 0..6 {
        let next = 1 + (k + 1) % 6;
        faces.push([0, 1 + k, next]);
        if k > 0 && next > 1 {
            faces.push([1, next, 1 + k]);
        }
    }
    Mesh { positions, faces }.rotated(DVec3::Y, lean)
}

/// The faces of a needle look aside, but its tip is what touches first, wherever it is.
#[test]
fn a_needle_between_vertices_is_found() {
    for lean in [0.0, 0.1, 0.2] {
        for number in 0..3 {
            let soft = plate(DVec3::new(30.0, 30.0, 6.0), [3, 3]);
            let soft = soft.translated(DVec3::new(1.0, 2.0, 3.1));
            let mut pair = Pair::new(needle(lean), soft);
            match number {
                0 => (),
                1 => pair.set_field(),
                _ => pair.keep(Restraint::Sliding),
            }
            let found = pair.detect().expect("valid");
            let tip = found
                .iter()
                .any(|found| (found.gap - 0.1).abs() < 1e-9 && found.normal.z.abs() > 1.0 - 1e-9);
            assert!(tip, "{lean} {number}: {found:?}");
        }
    }
}

/// The faces of a sheet that stands on its edge look aside, straight or not: the edge touches first.
#[test]
fn a_sheet_on_its_edge_is_found() {
    for lean in [0.0, 1e-12, 0.1] {
        let bone = plate(DVec3::new(20.0, 20.0, 4.0), [2, 2]).translated(DVec3::Z * -2.0);
        let corners = [[-3.0, 0.0], [3.0, 0.0], [3.0, 5.0], [-3.0, 5.0]];
        let positions = corners.map(|[x, z]| DVec3::new(x, 0.0, z)).to_vec();
        let sheet = Mesh { positions, faces: vec![[0, 1, 2], [0, 2, 3]] };
        let sheet = sheet.rotated(DVec3::X, lean).translated(DVec3::new(0.4, 1.3, 0.1));
        let found = Pair::new(bone, sheet).detect().expect("valid");
        assert_eq!(found.len(), 2, "{lean}: {found:?}");
        assert!(found.iter().all(|contact| (contact.gap - 0.1).abs() < 1e-9), "{found:?}");
    }
}

/// Vertices of the far side of a thin plate are within the margin, and their faces look away.
#[test]
fn vertices_that_look_away_are_left_out() {
    let bone = plate(DVec3::new(20.0, 20.0, 0.2), [10, 10]).translated(DVec3::Z * -0.1);
    let slab = plate(DVec3::new(9.0, 9.0, 3.0), [3, 3]).translated(DVec3::Z * 1.6);
    let mut pair = Pair::new(bone, slab);
    let found = pair.detect().expect("valid");
    assert!(!found.is_empty() && found.iter().all(|contact| (contact.gap - 0.1).abs() < 1e-9));
}

/// A bar of square section along x, a ridge of it at height 0.
fn bar() -> Mesh {
    let ring = [[0.0, 0.0], [4.0, -4.0], [0.0, -8.0], [-4.0, -4.0]];
    let mut positions = Vec::new();
    for x in [-12.0, 12.0] {
        positions.extend(ring.map(|[y, z]| DVec3::new(x, y, z)));
    }
    let mut faces = vec![[0, 1, 2], [0, 2, 3], [4, 6, 5], [4, 7, 6]];
    for k in 0..4 {
        let next = (k + 1) % 4;
        faces.extend([[k, next + 4, next], [k, k + 4, next + 4]]);
    }
    Mesh { positions, faces }
}

/// A soft bar upside down across the ridge of a bone, by a height between the ridges.
fn crossed_bars(height: f64) -> Pair {
    let soft = bar().rotated(DVec3::X, 0.5).rotated(DVec3::Z, 0.21);
    Pair::new(bar(), soft.translated(DVec3::Z * height + 0.7 * DVec3::X))
}

/// Ridges that cross are held by a contact of both, with their own normal, also before they touch.
#[test]
fn ridges_that_cross_are_held() {
    for height in [-0.7, -1e-9, 1e-9, 0.3] {
        let mut pair = crossed_bars(height);
        let found = pair.detect().expect("valid");
        let [contact] = &found[..] else { panic!("{height}: {found:?}") };
        assert!((contact.gap - height).abs() < 1e-9, "{contact:?}");
        assert!((contact.normal - DVec3::Z).length() < 1e-9, "{contact:?}");
        assert_eq!(contact.stencil.terms().len(), 2, "a point of the soft ridge");
        assert!(pair.detectors.unheld_overlaps().is_empty());
    }

    // Kept, they are found anew each time.
    let mut pair = crossed_bars(-0.2);
    pair.keep(Restraint::Sliding);
    for _ in 0..2 {
        assert_eq!(pair.detect().expect("valid").len(), 1);
        assert_eq!(pair.detectors.kept().count(), 0);
    }
}

/// The ridges of the two sides of a thin body are no contact, though one is below the other.
#[test]
fn ridges_of_two_sides_do_not_meet() {
    let bone = plate(DVec3::new(10.0, 10.0, 0.3), [1, 1]).translated(DVec3::Z * -0.15);
    let slab = plate(DVec3::new(10.0, 10.0, 2.0), [1, 1]).rotated(DVec3::Z, 0.07);
    let mut pair = Pair::new(bone, slab.translated(DVec3::Z * 1.1));
    let found = pair.detect().expect("valid");
    assert!(found.len() >= 8 && found.iter().all(|contact| (contact.gap - 0.1).abs() < 1e-9));
}

/// Of two slabs that overlap a little, ridges across the whole width are no contact.
#[test]
fn ridges_far_from_each_other_do_not_meet() {
    let slab = || plate(DVec3::new(16.0, 16.0, 6.0), [1, 1]);
    for height in [-0.05, 0.05] {
        let upper = slab().rotated(DVec3::Z, 0.03).translated(DVec3::Z * (6.0 + height));
        let found = Pair::new(slab(), upper).detect().expect("valid");
        assert!(found.len() >= 8, "the rims cross eight times: {found:?}");
        assert!(found.iter().all(|contact| (contact.gap - height).abs() < 1e-9), "{found:?}");
    }
}

/// A ridge may cut a round body between its vertices. No contact holds that: balls give way to exact
/// detection, and that names the pair.
#[test]
fn overlaps_that_no_contact_holds_are_named() {
    let ball = fixtures::shapes::icosphere(10.0, 2).rotated(DVec3::ONE, 0.1);
    let blade = bar().rotated(DVec3::X, 0.5).rotated(DVec3::Z, 0.08);
    for has_balls in [false, true] {
        let blade = blade.clone().translated(DVec3::new(0.0, 1.8, 9.7));
        let mut pair = Pair::new(ball.clone(), blade);
        if has_balls {
            pair.set_balls();
        }
        let found = pair.detect().expect("valid");
        assert!(found.iter().all(|contact| contact.gap > 0.0), "{found:?}");
        assert_eq!(pair.detectors.unheld_overlaps(), [pair.id()]);

        let fallbacks: Vec<_> =
            pair.detectors.fallbacks().iter().map(|fallback| fallback.reason).collect();
        let expected = if has_balls { vec![FallbackReason::CrossingEdges] } else { vec![] };
        assert_eq!(fallbacks, expected);

        // Apart, there is nothing to name.
        pair.step.move_bone(&mut pair.scene, pair.bone, &raised(-0.3), at_rest()).expect("bone");
        pair.detect().expect("valid");
        assert!(pair.detectors.unheld_overlaps().is_empty());
        assert!(pair.detectors.fallbacks().is_empty());
    }
}

/// Ridges may cross at one place while a vertex touches at another: balls, which find the vertex
/// alone, give way there, too.
#[test]
fn balls_give_way_where_ridges_cross_beside_a_vertex_that_touches() {
    // A spindle along x of square section, with ridges above, below and at its sides.
    let square = |x: DVec3| {
        let [y, z] = [x.y, x.z].map(|c| c * x.y.hypot(x.z) / (x.y.abs() + x.z.abs()).max(1.0));
        DVec3::new(x.x, y, z - 10.0)
    };
    let bone = fixtures::shapes::octasphere(10.0, 3).mapped(square);
    let tip = needle(0.0).rotated(DVec3::X, 0.5).translated(DVec3::new(7.0, 2.0, -5.2));

    for (height, touches) in [(-0.7, 2), (0.9, 1)] {
        let soft = bar().rotated(DVec3::X, 0.5).rotated(DVec3::Z, 0.21);
        let soft = soft.translated(DVec3::new(0.8, 0.0, height)).joined(&tip);
        let [exact, by_balls] = [false, true].map(|has_balls| {
            let mut pair = Pair::new(bone.clone(), soft.clone());
            if has_balls {
                pair.set_balls();
            }
            let found = pair.detect().expect("valid").into_iter().map(|contact| contact.gap);
            let gaps: Vec<_> = found.filter(|gap| *gap < 0.0).collect();
            (gaps, pair.detectors.fallbacks().len())
        });
        let is_close = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-9;
        assert_eq!(exact.0.len(), touches, "{:?}", exact.0);
        assert_eq!(by_balls.0.len(), touches, "{:?}", by_balls.0);
        assert!(by_balls.0.iter().zip(&exact.0).all(is_close), "{exact:?}, {by_balls:?}");
        assert_eq!(by_balls.1, touches - 1, "balls are enough for a vertex");
    }
}

fn at_rest() -> RigidMotion {
    RigidMotion::default()
}

/// Pairs that pull have to be told on what: contacts within the margin are not pulled shut.
#[test]
fn permanent_materials_pull_on_chosen_contacts_alone() {
    let [bone, slab] = slab_on_bone(0.02);
    let mut pair = Pair::new(bone, slab);
    let margins = Margins::new(0.0, MARGIN).expect("in range");
    let glue = Material { permanent: Some(Restraint::Sliding), ..Material::hard(margins) };
    pair.step.set_material(pair.id(), glue);
    assert!(matches!(pair.detect(), Err(StepError::NotKept { .. })));

    // Farther than those that are chosen, until they touch.
    pair.keep(Restraint::Sliding);
    assert_eq!(pair.detect().expect("valid").len(), 0);
    pair.step.move_bone(&mut pair.scene, pair.bone, &raised(0.021), at_rest()).expect("bone");
    let attached = pair.detect().expect("valid").len();
    assert!(attached >= 25, "{attached}");
    pair.step.move_bone(&mut pair.scene, pair.bone, &raised(-0.1), at_rest()).expect("bone");
    assert_eq!(pair.detect().expect("valid").len(), attached, "attached, they stay");
}

fn raised(height: f64) -> Pose {
    Pose::new(DQuat::IDENTITY, DVec3::Z * height)
}
