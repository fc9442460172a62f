//! Structures that a plan has built, body by body.

use decimate::CoarseSurface;
use distance_field::FieldDetector;
use medial::MedialDetector;
use proximity::{ContactSurface, ParticleNumbers, SurfaceTree};
use scene::{Body, BodyId, Scene};
use surface::{RigidState, parallel};

use crate::bone_field::BoneField;
use crate::{DetectionMethod, ErrorEstimate, ExclusionReason, PairPlan, PlanError, StructureKind};

/// Structure that was built for a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Structure {
    /// The body.
    pub body: BodyId,
    /// The kind of structure.
    pub kind: StructureKind,
    /// Number of faces of a surface, nodes of a field, or balls.
    pub size: usize,
    /// Distance between the nodes of a field.
    pub spacing: Option<f64>,
    /// Distance between the structure and the body's own surface.
    pub error: ErrorEstimate,
    /// Memory, in bytes.
    pub bytes: usize,
}

/// Structure that might have been built for a body and was not.
#[derive(Clone, Debug, PartialEq)]
pub struct MissingStructure {
    /// The body.
    pub body: BodyId,
    /// The kind of structure.
    pub kind: StructureKind,
    /// Reason why it was not built.
    pub reason: ExclusionReason,
}

impl Structure {
    fn new(
        body: BodyId,
        kind: StructureKind,
        size: usize,
        error: ErrorEstimate,
        bytes: usize,
    ) -> Self {
        Self { body, kind, size, spacing: None, error, bytes }
    }
}

/// Structures of all bodies of a scene, in their order.
#[derive(Debug)]
pub(crate) struct Structures {
    /// One per body: true if the tree over its own faces is used.
    pub(crate) uses_tree: Vec<bool>,
    pub(crate) bodies: Vec<BodyStructures>,
}

/// Structures of one body.
#[derive(Debug, Default)]
pub(crate) struct BodyStructures {
    pub(crate) coarse: Option<CoarseSurface>,
    pub(crate) field: Option<BoneField>,
    pub(crate) medial: Option<MedialDetector>,
}

/// Surface of a body as it is compared with another one.
#[derive(Clone, Copy)]
pub(crate) struct ComparedSurface<'a> {
    pub(crate) tree: &'a SurfaceTree,
    pub(crate) contact: ContactSurface<'a>,
}

impl<'a> ComparedSurface<'a> {
    /// Returns the body's own surface, where its tree is up to date.
    pub(crate) fn whole(body: &'a Body) -> Option<Self> {
        body.tree().map(|tree| Self { tree, contact: body.contact_surface() })
    }
}

impl Structures {
    /// Returns no structures, for a number of bodies.
    pub(crate) fn new(count: usize) -> Self {
        let bodies = std::iter::repeat_with(BodyStructures::default).take(count).collect();
        Self { uses_tree: vec![false; count], bodies }
    }

    /// Moves trees, reduced surfaces and balls to where the bodies are.
    pub(crate) fn follow(&mut self, scene: &mut Scene) -> Result<(), PlanError> {
        // Trees first: balls that are compared with a bone use its tree.
        scene.fit(&self.uses_tree)?;
        let scene = &*scene;
        parallel::try_for_each_mut(&mut self.bodies, |number, structures| {
            let body = &scene.bodies()[number];
            if let Some(coarse) = &mut structures.coarse {
                coarse.follow(body.positions())?;
            }
            if let Some(medial) = &mut structures.medial {
                medial.follow(body.checked_positions())?;
            }
            Ok(())
        })
    }

    /// Returns a body as it is compared: by its reduced surface, if it has one. `None` where its
    /// own faces are compared and have no tree.
    pub(crate) fn compared<'a>(
        &'a self,
        scene: &'a Scene,
        id: BodyId,
    ) -> Option<ComparedSurface<'a>> {
        let contact = self.contact_surface(scene, id);
        let own_tree = || scene.body(id).tree();
        let tree = self.coarse(id).map(CoarseSurface::tree).or_else(own_tree)?;
        Some(ComparedSurface { tree, contact })
    }

    /// Returns a body as one side of contacts: by its reduced surface, if it has one.
    pub(crate) fn contact_surface<'a>(
        &'a self,
        scene: &'a Scene,
        id: BodyId,
    ) -> ContactSurface<'a> {
        // Contacts of a reduced surface are of the vertices that it has kept.
        let whole = scene.body(id).contact_surface();
        match self.coarse(id) {
            None => whole,
            Some(coarse) => ContactSurface {
                surface: coarse.tree().surface(),
                positions: coarse.tree().positions(),
                particles: ParticleNumbers {
                    kept: Some(&coarse.reduced().kept),
                    ..whole.particles
                },
                ..whole
            },
        }
    }

    /// Returns the reduced surface of a body, if it has one.
    pub(crate) fn coarse(&self, id: BodyId) -> Option<&CoarseSurface> {
        self.bodies[id.index()].coarse.as_ref()
    }

    /// Returns the detector of a rigid body's field, and the state of the body; `None` where it
    /// has no field.
    pub(crate) fn field_detector(
        &self,
        scene: &Scene,
        id: BodyId,
    ) -> Result<Option<(&FieldDetector, RigidState)>, PlanError> {
        let Some(field) = &self.bodies[id.index()].field else { return Ok(None) };

        // Vertices moved one by one have left the frame of the field.
        let body = scene.body(id);
        let Some(pose) = body.pose() else {
            return Err(PlanError::NoPose { name: body.name().to_owned() });
        };
        Ok(Some((&field.detector, RigidState::at_rest(pose))))
    }

    /// Computes the error of a pair's gaps.
    pub(crate) fn error(&self, planned: &PairPlan) -> ErrorEstimate {
        // Errors of two structures add up, but balls are compared with vertices as they are.
        let [a, b] = planned.pair.bodies().map(|id| &self.bodies[id.index()]);
        match (planned.method, planned.bone()) {
            (DetectionMethod::Field, None) => ErrorEstimate::NONE,
            (DetectionMethod::Field, Some(bone)) => {
                let other = &self.bodies[planned.other(bone).index()];
                self.bodies[bone.index()].field_error() + other.coarse_error()
            }
            (DetectionMethod::Surfaces, _) => a.coarse_error() + b.coarse_error(),
            (DetectionMethod::Medial, _) => a.medial_error().max(b.medial_error()),
        }
    }

    /// Lists the structures, in the order of the bodies.
    pub(crate) fn list(&self, scene: &Scene) -> Vec<Structure> {
        let mut list = Vec::new();
        for (id, structures) in scene.ids().zip(&self.bodies) {
            if self.uses_tree[id.index()] {
                let body = scene.body(id);
                let (faces, bytes) = (body.surface().faces().len(), tree_bytes(body));
                list.push(Structure::new(
                    id,
                    StructureKind::Tree,
                    faces,
                    ErrorEstimate::NONE,
                    bytes,
                ));
            }
            if let Some(coarse) = &structures.coarse {
                let (faces, error) =
                    (coarse.tree().surface().faces().len(), structures.coarse_error());
                list.push(Structure::new(id, StructureKind::Reduced, faces, error, coarse.bytes()));
            }
            if let Some(BoneField { detector, .. }) = &structures.field {
                let (grid, error) = (detector.field().grid(), structures.field_error());
                let (nodes, bytes) = (grid.node_count(), detector.bytes());
                let field = Structure::new(id, StructureKind::Field, nodes, error, bytes);
                list.push(Structure { spacing: Some(grid.spacing()), ..field });
            }
            if let Some(medial) = &structures.medial {
                let (balls, error) = (medial.medial().balls().len(), structures.medial_error());
                list.push(Structure::new(id, StructureKind::Medial, balls, error, medial.bytes()));
            }
        }
        list
    }
}

impl BodyStructures {
    /// Returns the certified deviation of the reduced surface.
    fn coarse_error(&self) -> ErrorEstimate {
        match &self.coarse {
            Some(coarse) => ErrorEstimate::Bound(coarse.reduced().deviation.upper()),
            None => ErrorEstimate::NONE,
        }
    }

    /// Returns the largest error of the field at samples near the surface.
    fn field_error(&self) -> ErrorEstimate {
        match &self.field {
            Some(field) => ErrorEstimate::Measured(field.measured_error),
            None => ErrorEstimate::NONE,
        }
    }

    /// Returns the certified deviation of the medial surface.
    fn medial_error(&self) -> ErrorEstimate {
        match &self.medial {
            Some(medial) => ErrorEstimate::Bound(medial.deviation().largest()),
            None => ErrorEstimate::NONE,
        }
    }
}

fn tree_bytes(body: &Body) -> usize {
    body.tree().map_or(0, |tree| tree.tree().bytes())
}
