//! Settings of a motion: units and frames of tables, names of bodies.

use std::collections::BTreeMap;
use std::path::Path;

use clap::Args;

use super::pose_table::MeshFrame;
use crate::scene::{SceneDescription, SceneProblem, Unit};

/// Arguments of motions that are tables of poses, and of names.
#[derive(Debug, Args)]
pub(crate) struct MotionArgs {
    /// Unit of lengths in a table of poses [default: m in .sto and .mot, the scene's in .csv]
    #[arg(long, value_enum, value_name = "UNIT")]
    motion_unit: Option<Unit>,

    /// Frame of the meshes, for a table of poses [default: first-pose, body for an OpenSim model]
    #[arg(long, value_enum, value_name = "FRAME")]
    meshes: Option<MeshFrame>,

    /// Body that follows another name of the motion than its own; may be given several times
    #[arg(long, value_name = "BODY=NAME")]
    follow: Vec<String>,
}

/// Settings of a motion that moves the bodies of a scene.
#[derive(Clone, Debug, Default)]
pub(crate) struct MotionParams {
    pub(super) scene_unit: Unit,
    /// Unit of lengths in a table of poses; none for that of its format.
    pub(super) table_unit: Option<Unit>,
    pub(super) meshes: MeshFrame,
    /// Option of the command line that is for tables of poses alone, if one is given.
    pub(super) table_option: Option<&'static str>,
    /// Names of the maps that bodies follow, by the name of the body.
    pub(super) follows: BTreeMap<String, String>,
}

impl MotionParams {
    /// Returns the parameters that a scene file has.
    pub(crate) fn of_scene(scene: &SceneDescription) -> Self {
        let mut follows = BTreeMap::new();
        for body in &scene.bodies {
            if let Some(name) = &body.follows {
                follows.insert(body.name.clone(), name.clone());
            }
        }
        let meshes = if scene.is_model { MeshFrame::Body } else { MeshFrame::FirstPose };
        Self { scene_unit: scene.unit, follows, meshes, ..Self::default() }
    }
}

impl MotionParams {
    /// Warns of meshes in the frames of bodies that an OpenSim table moves, where no model has the mass centers.
    pub(crate) fn mass_center_warning(
        &self,
        path: &Path,
        scene: &SceneDescription,
    ) -> Option<String> {
        let extension = path.extension().map(|extension| extension.to_ascii_lowercase());
        let is_of_opensim =
            extension.is_some_and(|extension| extension == "sto" || extension == "mot");
        let takes_origins = is_of_opensim && self.meshes == MeshFrame::Body && !scene.is_model;
        takes_origins.then(|| {
            format!(
                "{}: its positions are taken for the origins of bodies, in whose frames the meshes stand, but those of \
                 BodyKinematics are mass centers: the model (.osim) has both",
                path.display()
            )
        })
    }
}

impl MotionArgs {
    /// Returns the parameters of a scene file with those of the command line instead, where it has
    /// some.
    pub(crate) fn params(&self, scene: &SceneDescription) -> Result<MotionParams, SceneProblem> {
        let mut params = MotionParams::of_scene(scene);
        params.table_unit = self.motion_unit;
        params.meshes = self.meshes.unwrap_or(params.meshes);
        let of_unit = self.motion_unit.map(|_| "--motion-unit");
        params.table_option = of_unit.or(self.meshes.map(|_| "--meshes"));

        // A name of the command line replaces that of the scene file, but no other of its own.
        let mut given = BTreeMap::new();
        for entry in &self.follow {
            let (body, name) =
                entry.split_once('=').ok_or_else(|| SceneProblem::Follow(entry.clone()))?;
            scene.index_of(body)?;
            if let Some(first) = given.insert(body.to_owned(), name.to_owned()) {
                let (body, second) = (body.to_owned(), name.to_owned());
                return Err(SceneProblem::FollowsTwo { body, first, second });
            }
        }
        params.follows.extend(given);
        Ok(params)
    }
}
