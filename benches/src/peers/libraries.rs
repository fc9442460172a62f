//! Bodies as each library keeps them, and its way to answer.

use std::error::Error;

use boolmesh::prelude::{Manifold, OpType, compute_boolean};
use fixtures::Mesh;
use overlap::{DepthParams, Overlap, OverlapDetector};
use parry3d::math::{Pose, Vector};
use parry3d::query::{self, ClosestPoints};
use parry3d::shape::TriMesh;
use proximity::{PairProximity, SurfaceTree};

use super::boolean::{manifold, volume};
use super::{Question, REACH, RIGHT_LENGTH};
use crate::bodies::{body, bounds};
use crate::measure::{Pace, as_f64};

/// A library.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Library {
    /// This one.
    Own,
    /// `parry3d`.
    Parry,
    /// `boolmesh`.
    Boolmesh,
}

/// All libraries.
pub const LIBRARIES: [Library; 3] = [Library::Own, Library::Parry, Library::Boolmesh];

/// The bodies of a scene, as each library keeps them.
#[derive(Debug)]
pub struct Bodies {
    /// Title of the scene.
    pub title: String,
    /// Bodies of this library.
    pub own: Vec<SurfaceTree>,
    parry: Vec<TriMesh>,
    /// `None` where the mesh is refused.
    boolmesh: Vec<Option<Manifold>>,
    /// Time that each library took to make them, per body \[us\].
    preparation: [f64; 3],
}

/// Memory that the own library reuses from pair to pair.
#[derive(Debug, Default)]
pub struct Memory {
    pair: PairProximity,
    detector: OverlapDetector,
    overlap: Overlap,
}

impl Library {
    /// Returns the name with the version.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Own => "musculo-collide",
            Self::Parry => "parry3d 0.31",
            Self::Boolmesh => "boolmesh 0.2",
        }
    }

    /// Returns true if the library has an answer to the question at all.
    #[must_use]
    pub const fn answers(self, question: Question) -> bool {
        match self {
            Self::Own => true,
            Self::Parry => !matches!(question, Question::Volume),
            Self::Boolmesh => matches!(question, Question::Overlap | Question::Volume),
        }
    }

    /// Returns the time per body to make what the library keeps of it \[us\].
    #[must_use]
    pub const fn preparation(self, bodies: &Bodies) -> f64 {
        bodies.preparation[self as usize]
    }

    /// Returns the answer about two bodies: 1 for yes, 0 for no, a length, or a volume; a gap
    /// beyond reach is infinite. `None` where the library refuses.
    pub fn ask(
        self,
        question: Question,
        bodies: &Bodies,
        [a, b]: [usize; 2],
        memory: &mut Memory,
    ) -> Option<f64> {
        match self {
            Self::Own => memory.ask(question, [&bodies.own[a], &bodies.own[b]]),
            Self::Parry => ask_parry(question, [&bodies.parry[a], &bodies.parry[b]]),
            Self::Boolmesh => {
                let pair = [bodies.boolmesh[a].as_ref()?, bodies.boolmesh[b].as_ref()?];
                ask_boolmesh(question, pair)
            }
        }
    }
}

impl Bodies {
    /// Prepares meshes for all libraries.
    ///
    /// # Errors
    ///
    /// When there is a mesh that `parry3d` refuses.
    pub fn new(title: &str, meshes: Vec<Mesh>) -> Result<Self, Box<dyn Error>> {
        let (mut own, mut parry, mut boolmesh) = (Vec::new(), Vec::new(), Vec::new());
        let pace = Pace::long_calls(1);
        let per_body = 1e-3 / as_f64(meshes.len());
        let mut preparation = [0.0; 3];
        for mesh in meshes {
            preparation[1] += per_body * pace.call_time(|| push(&mut parry, tri_mesh(&mesh)));
            preparation[2] +=
                per_body * pace.call_time(|| push(&mut boolmesh, manifold(&mesh).ok()));
            preparation[0] += per_body * pace.call_time(|| push(&mut own, body(mesh)));
        }

        let parry = parry.into_iter().collect::<Result<_, _>>()?;
        let faces: usize = own.iter().map(|body| body.surface().faces().len()).sum();
        let title = format!("{title}: {} bodies, {faces} faces", own.len());
        Ok(Self { title, own, parry, boolmesh, preparation })
    }

    /// Returns the pairs whose boxes are within reach.
    #[must_use]
    pub fn near_pairs(&self) -> Vec<[usize; 2]> {
        let mut near = Vec::new();
        for b in 0..self.own.len() {
            let reach = bounds(&self.own[b]).inflate(REACH);
            for a in 0..b {
                if reach.overlaps(bounds(&self.own[a])) {
                    near.push([a, b]);
                }
            }
        }
        near
    }
}

/// Adds an entry and returns their number.
fn push<T>(list: &mut Vec<T>, entry: T) -> usize {
    list.push(entry);
    list.len()
}

impl Memory {
    fn ask(&mut self, question: Question, [a, b]: [&SurfaceTree; 2]) -> Option<f64> {
        let Self { pair, detector, overlap } = self;
        match question {
            Question::Overlap => {
                pair.compute(a, b, 0.0).expect("few faces are near");
                Some(f64::from(u8::from(pair.overlaps())))
            }
            Question::Gap => {
                pair.compute(a, b, REACH).expect("few faces are near");
                Some(pair.distance(a, b, REACH).unwrap_or(f64::INFINITY))
            }
            Question::Depth => Some(self.depth([a, b], RIGHT_LENGTH)[0]),
            Question::Volume => {
                detector.measure_into([a, b], overlap);
                overlap.total.volume
            }
        }
    }

    /// Brackets the greater depth of both surfaces, no wider than a tolerance.
    pub fn depth(&mut self, bodies: [&SurfaceTree; 2], tolerance: f64) -> [f64; 2] {
        let params = DepthParams { relative_tolerance: 0.0, ..DepthParams::with_floor(tolerance) };
        self.detector.measure_into(bodies, &mut self.overlap);
        let mut bracket = [0.0_f64; 2];
        for depth in self.detector.depths(bodies, &params).into_iter().flatten() {
            bracket = [bracket[0].max(depth.lower), bracket[1].max(depth.upper)];
        }
        bracket
    }
}

fn tri_mesh(mesh: &Mesh) -> Result<TriMesh, impl Error + use<>> {
    let mut vertices = Vec::new();
    for position in &mesh.positions {
        vertices.push(Vector::from_array(position.as_vec3().to_array()));
    }
    TriMesh::new(vertices, mesh.faces.clone())
}

#[expect(clippy::cast_possible_truncation, reason = "a constant of few digits")]
fn ask_parry(question: Question, [a, b]: [&TriMesh; 2]) -> Option<f64> {
    let at = &Pose::IDENTITY;
    match question {
        Question::Overlap => {
            let meet = query::intersection_test(at, a, at, b).ok()?;
            Some(f64::from(u8::from(meet.intersecting)))
        }
        Question::Gap => match query::closest_points(at, a, at, b, REACH as f32).ok()? {
            ClosestPoints::Intersecting => Some(0.0),
            ClosestPoints::WithinMargin(p, q) => Some(f64::from(p.distance(q))),
            ClosestPoints::Disjoint => Some(f64::INFINITY),
        },
        Question::Depth => {
            let contact = query::contact(at, a, at, b, 0.0).ok()?;
            Some(contact.map_or(0.0, |contact| f64::from(-contact.dist)))
        }
        Question::Volume => None,
    }
}

fn ask_boolmesh(question: Question, [a, b]: [&Manifold; 2]) -> Option<f64> {
    let shared = match compute_boolean(a, b, OpType::Intersect) {
        Ok(shared) => shared,
        // Its way to say that nothing is shared.
        Err(reason) if reason.starts_with("empty") => return Some(0.0),
        Err(_) => return None,
    };

    match question {
        Question::Overlap => Some(f64::from(u8::from(shared.nf > 0))),
        Question::Volume => Some(volume(&shared)),
        Question::Gap | Question::Depth => None,
    }
}
