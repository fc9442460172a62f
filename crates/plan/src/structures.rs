//! What a plan has built, body by body.

use distance_field::FieldDetector;

use crate::bone::BoneField;
use crate::{PlanError, Structure, StructureKind};
use decimate::CoarseSurface;
use proximity::{ContactSurface, ParticleNumbers, SurfaceTree};
use scene::Body;
use scene::{BodyId, MedialDetector, Scene};
use surface::{RigidState, parallel};

/// By the numbers of the bodies.
#[derive(Debug)]
pub(super) struct Structures {
    /// Whether a body's own tree is kept up to date.
    pub(super) trees: Vec<bool>,
    pub(super) levels: Vec<Option<CoarseSurface>>,
    pub(super) fields: Vec<Option<BoneField>>,
    pub(super) medials: Vec<Option<MedialDetector>>,
}

impl Structures {
    /// Nothing, for so many bodies.
    pub(super) fn none(bodies: usize) -> Self {
        let trees = vec![false; bodies];
        Self { trees, levels: bare(bodies), fields: bare(bodies), medials: bare(bodies) }
    }

    /// Brings trees, levels and balls to where the bodies are.
    pub(super) fn follow(&mut self, scene: &mut Scene) -> Result<(), PlanError> {
        scene.fit(&self.trees)?;
        let scene = &*scene;
        parallel::try_for_each_mut(&mut self.levels, |number, level| match level {
            None => Ok(()),
            Some(level) => {
                let body = &scene.bodies()[number];
                level.follow(body.positions()).map_err(PlanError::from)
            }
        })?;
        parallel::try_for_each_mut(&mut self.medials, |_, medial| {
            medial.as_mut().map_or(Ok(()), |medial| medial.follow(scene)).map_err(PlanError::from)
        })
    }

    /// Returns the tree over a body's side of contacts: that of its level where it has one.
    pub(super) fn tree<'a>(&'a self, scene: &'a Scene, id: BodyId) -> Option<&'a SurfaceTree> {
        self.level(id).map_or_else(|| scene.body(id).tree(), |level| Some(level.tree()))
    }

    /// Returns a body as one side of contacts: by its level where it has one.
    pub(super) fn contact_surface<'a>(
        &'a self,
        scene: &'a Scene,
        id: BodyId,
    ) -> ContactSurface<'a> {
        let whole = scene.body(id).contact_surface();
        match self.level(id) {
            None => whole,
            Some(level) => ContactSurface {
                surface: level.tree().surface(),
                positions: level.tree().positions(),
                particles: ParticleNumbers { kept: Some(&level.reduced().kept), ..whole.particles },
                ..whole
            },
        }
    }

    /// The coarser surface that stands for a body, if one does.
    pub(super) fn level(&self, id: BodyId) -> Option<&CoarseSurface> {
        self.levels[id.index()].as_ref()
    }

    /// How far a body's side of contacts may be from its surface.
    pub(super) fn deviation(&self, id: BodyId) -> f64 {
        self.level(id).map_or(0.0, |level| level.reduced().deviation.upper())
    }

    /// How far a body's balls may be from its surface; 0 where it has none.
    pub(super) fn medial_deviation(&self, id: BodyId) -> f64 {
        let medial = self.medials[id.index()].as_ref();
        medial.map_or(0.0, |medial| medial.deviation().largest())
    }

    /// Returns the detector of a bone with the state of the bone.
    pub(super) fn detector(
        &self,
        (id, bone): (BodyId, &Body),
    ) -> Result<Option<(&FieldDetector, RigidState)>, PlanError> {
        let Some(BoneField { detector, .. }) = &self.fields[id.index()] else {
            return Ok(None);
        };
        let no_pose = || PlanError::NoPose { name: bone.name().to_owned() };
        let pose = bone.pose().ok_or_else(no_pose)?;
        Ok(Some((detector, RigidState::at_rest(pose))))
    }

    /// All of it, in the order of the bodies.
    pub(super) fn list(&self, scene: &Scene) -> Vec<Structure> {
        let of_body = |id: BodyId| {
            let number = id.index();
            let body = scene.body(id);
            let plain = |kind, size, error_bound, bytes| Structure {
                body: id,
                kind,
                size,
                spacing: None,
                error_bound,
                bytes,
            };
            let tree = self.trees[number].then(|| {
                let (faces, bytes) = (body.surface().faces().len(), body.tree_bytes());
                plain(StructureKind::Tree, faces, 0.0, bytes)
            });
            let level = self.levels[number].as_ref().map(|level| {
                let faces = level.tree().surface().faces().len();
                let deviation = level.reduced().deviation.upper();
                plain(StructureKind::Reduced, faces, deviation, level.bytes())
            });
            let field = self.fields[number].as_ref().map(|BoneField { detector, error_bound }| {
                let grid = detector.field().grid();
                let (nodes, spacing) = (grid.node_count(), Some(grid.spacing()));
                let bytes = detector.bytes();
                Structure { spacing, ..plain(StructureKind::Field, nodes, *error_bound, bytes) }
            });
            let medial = self.medials[number].as_ref().map(|medial| {
                let (balls, deviation) = (medial.medial().balls().len(), medial.deviation());
                plain(StructureKind::Medial, balls, deviation.largest(), medial.bytes())
            });
            [tree, level, field, medial].into_iter().flatten()
        };
        scene.ids().flat_map(of_body).collect()
    }
}

fn bare<T>(count: usize) -> Vec<Option<T>> {
    std::iter::repeat_with(|| None).take(count).collect()
}
