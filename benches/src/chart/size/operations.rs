//! Operations that are measured, and the bodies they work on.

use std::error::Error;

use ccd::CcdParams;
use distance_field::{DistanceField, FieldParams};
use fixtures::shapes::icosphere;
use glam::DVec3;
use musculo_collide::{
    BodyId, BodyKind, BodyMove, CheckParams, Progress, ResolveParams, Scene, resolve,
};
use overlap::{Overlap, OverlapDetector};
use proximity::SurfaceTree;

use crate::bodies::body;

/// Radius of all spheres, and the distance of a muscle's center from the bone's \[mm\].
const RADIUS: f64 = 30.0;
const APART: f64 = 58.5;

/// Way that muscles move toward the bone in a step, and margin of near pairs \[mm\].
const STEP: f64 = 1.0;
const MARGIN: f64 = 0.5;

/// An operation that is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Operation {
    Refit,
    Check,
    Overlap,
    Sweep,
    Field,
    Resolve,
}

pub(crate) const OPERATIONS: [Operation; 6] = [
    Operation::Refit,
    Operation::Check,
    Operation::Overlap,
    Operation::Sweep,
    Operation::Field,
    Operation::Resolve,
];

/// The bone, the muscles around it, and their memory.
pub(crate) struct Spheres {
    scene: Scene,
    muscles: Vec<BodyId>,
    /// Positions of the muscles at rest, and at the end of a step.
    rest: Vec<Vec<DVec3>>,
    moved: Vec<Vec<DVec3>>,
    /// The same bodies without a scene, the bone first.
    trees: Vec<SurfaceTree>,
    detector: OverlapDetector,
    overlap: Overlap,
}

impl Spheres {
    /// Places a bone of `20 · 4^level` faces.
    fn bone(level: u32) -> Result<Self, Box<dyn Error>> {
        let sphere = icosphere(RADIUS, level);
        let mut scene = Scene::new();
        scene.add("bone", BodyKind::Rigid, sphere.surface(), sphere.positions.clone())?;
        Ok(Self {
            scene,
            muscles: Vec::new(),
            rest: Vec::new(),
            moved: Vec::new(),
            trees: vec![body(sphere)],
            detector: OverlapDetector::default(),
            overlap: Overlap::default(),
        })
    }

    /// Places twelve muscles around the bone, as the vertices of an icosahedron are, each of as many
    /// faces and none aligned with another.
    pub(crate) fn with_muscles(level: u32) -> Result<Self, Box<dyn Error>> {
        let mut spheres = Self::bone(level)?;
        for (turns, place) in (1_u8..).zip(icosphere(APART, 0).positions) {
            let axis = DVec3::new(0.3, 0.5, 0.8);
            let turned = icosphere(RADIUS, level).rotated(axis, 0.07 * f64::from(turns));
            let muscle = turned.translated(place);
            let x = muscle.positions.clone();
            let name = format!("muscle {turns}");
            let kind = BodyKind::Deformable;
            spheres.muscles.push(spheres.scene.add(name, kind, muscle.surface(), x.clone())?);

            let way = STEP * place.normalize();
            spheres.moved.push(x.iter().map(|x| *x - way).collect());
            spheres.rest.push(x);
            spheres.trees.push(body(muscle));
        }
        Ok(spheres)
    }

    /// Returns the number of faces of all bodies.
    pub(crate) fn faces(&self) -> usize {
        self.trees.iter().map(|tree| tree.surface().faces().len()).sum()
    }

    /// Returns the scene.
    pub(crate) const fn scene(&mut self) -> &mut Scene {
        &mut self.scene
    }

    /// Moves the muscles to where they are at rest, which they count as a new place.
    pub(crate) fn move_to_rest(&mut self) -> Result<(), Box<dyn Error>> {
        for (muscle, rest) in self.muscles.iter().zip(&self.rest) {
            self.scene.move_body(*muscle, rest)?;
        }
        Ok(())
    }
}

impl Operation {
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Refit => "refit",
            Self::Check => "check",
            Self::Overlap => "overlap",
            Self::Sweep => "sweep",
            Self::Field => "field",
            Self::Resolve => "resolve",
        }
    }

    /// Returns the bodies that the operation works on: `20 · 4^level` faces each, or a bone of about
    /// as many as all of them.
    pub(crate) fn spheres(self, level: u32) -> Result<Spheres, Box<dyn Error>> {
        match self {
            Self::Field => Spheres::bone(level + 2),
            _ => Spheres::with_muscles(level),
        }
    }

    /// Runs once; returns the number of bodies, pairs, bytes or rounds.
    pub(crate) fn run(self, spheres: &mut Spheres) -> Result<usize, Box<dyn Error>> {
        match self {
            Self::Refit => {
                for tree in &mut spheres.trees {
                    let positions = tree.positions().as_slice().to_vec();
                    tree.set_positions(positions.into_iter())?;
                }
                Ok(spheres.trees.len())
            }
            Self::Check => {
                spheres.move_to_rest()?;
                let reports = spheres.scene.check(&CheckParams::new(MARGIN), Progress::none())?;
                Ok(reports.iter().filter(|report| report.overlaps).count())
            }
            Self::Overlap => {
                let Spheres { trees, detector, overlap, .. } = spheres;
                let mut count = 0;
                for muscle in &trees[1..] {
                    detector.measure_into([&trees[0], muscle], overlap);
                    count += overlap.regions.len();
                }
                Ok(count)
            }
            Self::Sweep => {
                spheres.move_to_rest()?;
                let Spheres { scene, muscles, moved, .. } = spheres;
                let mut moves = Vec::new();
                for (&body, positions) in muscles.iter().zip(moved) {
                    moves.push(BodyMove { body, positions });
                }
                let report = scene.sweep(&moves, &CcdParams::DEFAULT, Progress::none())?;
                Ok(report.pairs.len())
            }
            Self::Field => {
                let bone = &spheres.trees[0];
                let params = FieldParams { samples: 0, ..FieldParams::new(1.0) };
                let (surface, x) = (bone.surface(), bone.positions());
                let field = DistanceField::build(surface, x, &params, Progress::none())?;
                Ok(field.bytes())
            }
            Self::Resolve => {
                spheres.move_to_rest()?;
                let params = ResolveParams { gap: 0.05, ..ResolveParams::with_smoothing(6.0) };
                let resolution = resolve(&mut spheres.scene, &params, Progress::none())?;
                Ok(resolution.rounds.len())
            }
        }
    }
}
