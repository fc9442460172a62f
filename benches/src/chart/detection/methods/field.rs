//! The vertices and edges of muscles against the distance field of the bone.

use std::cell::OnceCell;

use distance_field::{DistanceField, FieldMethod, FieldParams, Pose, Voxelization};
use musculo_collide::{BodyId, FieldContact, FieldDetector, FieldFeature, RigidState, Scene};

use super::super::question::Question;
use super::super::score::Told;
use super::{Detector, Failure, Method};

/// Room around the bone in which the field is known \[mm\].
const PADDING: f64 = 5.0;

/// A field and the bodies that are asked about it.
pub(super) struct ByField<'a> {
    question: &'a Question<'a>,
    scene: Scene,
    ids: Vec<BodyId>,
    detector: FieldDetector<'a>,
    contacts: Vec<(usize, Vec<FieldContact>)>,
}

pub(super) fn detector<'a>(
    question: &'a Question<'a>,
    method: Method,
    spacing: f64,
    kept: &'a OnceCell<DistanceField>,
) -> Result<ByField<'a>, Failure> {
    let params = FieldParams { padding: PADDING, samples: 0, ..FieldParams::new(spacing) };
    let method = match method {
        // The source's lines leave holes in coarse faces, through which its flood leaks.
        Method::SeedField => FieldMethod::Voxel { voxelization: Voxelization::SixSeparating },
        _ => params.method,
    };
    let params = FieldParams { method, truncation: None, ..params };
    let bone = &question.moving.bodies[0];
    let field = DistanceField::build(&bone.surface, bone.surface.positions(&bone.x)?, &params)?;
    let detector = FieldDetector::new(kept.get_or_init(|| field), 0.0)?;
    let (scene, ids) = question.scene()?;
    let contacts = question.muscles().into_iter().map(|muscle| (muscle, Vec::new())).collect();
    let mut built = ByField { question, scene, ids, detector, contacts };
    built.step(0)?;
    Ok(built)
}

impl Detector for ByField<'_> {
    fn step(&mut self, frame: usize) -> Result<(), Failure> {
        let state = RigidState::at_rest(Pose::IDENTITY);
        for (muscle, _) in &self.contacts {
            self.scene
                .move_body(self.ids[*muscle], &self.question.moving.frames[frame][*muscle])?;
        }
        for (muscle, contacts) in &mut self.contacts {
            *contacts = self.scene.field_contacts(self.ids[*muscle], &self.detector, &state)?;
        }
        Ok(())
    }

    fn told(&self) -> Told {
        let inside = |found: &FieldContact| match found.feature {
            FieldFeature::Vertex(vertex) if found.contact.gap < 0.0 => {
                Some((vertex, -found.contact.gap))
            }
            _ => None,
        };
        let told = |(muscle, contacts): &(usize, Vec<FieldContact>)| {
            ([*muscle, 0], contacts.iter().filter_map(inside).collect())
        };
        Told::Vertices(self.contacts.iter().map(told).collect())
    }
}
