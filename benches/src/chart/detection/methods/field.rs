//! Vertices and edges of muscles against the distance field of the bone.

use distance_field::{DistanceField, FieldMethod, FieldParams, Pose, Voxelization};
use musculo_collide::{BodyId, FieldContact, FieldDetector, FieldFeature, RigidState, Scene};
use surface::progress::Progress;

use super::super::score::Answer;
use super::super::task::{Direction, Task};
use super::{Built, Detector, Failure};

/// Padding of the field around the bone \[mm\].
const PADDING: f64 = 5.0;

/// Detection of muscles in the field of the bone.
pub(super) struct FieldDetection<'a> {
    task: &'a Task<'a>,
    scene: Scene,
    ids: Vec<BodyId>,
    detector: FieldDetector,
    /// Muscles with their contacts.
    contacts: Vec<(usize, Vec<FieldContact>)>,
}

/// Builds the field of the bone.
///
/// # Errors
///
/// When the field cannot be built, or the scene refuses a body.
pub(super) fn detector<'a>(task: &'a Task<'a>, by_voxels: bool, spacing: f64) -> Built<'a> {
    let mut params =
        FieldParams { padding: PADDING, samples: 0, truncation: None, ..FieldParams::new(spacing) };
    if by_voxels {
        // The source's lines leave holes in coarse faces, through which its flood fill leaks.
        params.method = FieldMethod::Voxel { voxelization: Voxelization::SixSeparating };
    }
    let bone = &task.moving.bodies[0];
    let built = DistanceField::build(bone.surface(), bone.positions(), &params, Progress::none())?;

    let detector = FieldDetector::new(built, 0.0)?;
    let (scene, ids) = task.scene()?;
    let contacts = task.muscles().into_iter().map(|muscle| (muscle, Vec::new())).collect();
    let mut detection = FieldDetection { task, scene, ids, detector, contacts };
    detection.step(0)?;
    Ok(Box::new(detection))
}

impl Detector for FieldDetection<'_> {
    fn step(&mut self, frame: usize) -> Result<(), Failure> {
        let state = RigidState::at_rest(Pose::IDENTITY);
        for (muscle, _) in &self.contacts {
            self.scene.move_body(self.ids[*muscle], self.task.positions(frame, *muscle))?;
        }
        for (muscle, contacts) in &mut self.contacts {
            *contacts = self.scene.field_contacts(self.ids[*muscle], &self.detector, &state)?;
        }
        Ok(())
    }

    fn answer(&self) -> Answer {
        let mut directions = Vec::new();
        for (muscle, contacts) in &self.contacts {
            let inside = contacts.iter().filter_map(vertex_depth).collect();
            directions.push((Direction { vertices: *muscle, against: 0 }, inside));
        }
        Answer::Vertices(directions)
    }
}

/// Returns a vertex that is inside with its depth; `None` for an edge or a face.
fn vertex_depth(found: &FieldContact) -> Option<(u32, f64)> {
    match found.feature {
        FieldFeature::Vertex(vertex) if found.contact.gap < 0.0 => {
            Some((vertex, -found.contact.gap))
        }
        _ => None,
    }
}
