//! Scenes from OpenSim models: a rigid body per mesh that is at hand.
//!
//! Meshes stand in frames at the mass centers of their bodies, whose positions the tables of OpenSim's
//! body kinematics have, so that the model and such a table are a motion.

use std::path::{Path, PathBuf};

use glam::DAffine3;
use mesh_io::ModelBody;
use musculo_collide::BodyKind;

use super::{BodyDescription, SceneDescription, SceneProblem, Unit, stem};
use crate::failure::Failure;
use crate::terminal;

/// Folder beside a model in which OpenSim keeps meshes.
const GEOMETRY: &str = "Geometry";

/// Returns true if a file is an OpenSim model, by its extension.
pub(super) fn is_model_file(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("osim"))
}

/// Describes the scene of a model; meshes that are not at hand are named and left out.
pub(super) fn read(path: &Path) -> Result<SceneDescription, Failure> {
    let model = mesh_io::read_model(path)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut scene =
        SceneDescription { unit: Unit::Meter, is_model: true, ..SceneDescription::default() };
    for body in &model.bodies {
        add_meshes(body, folder, path, &mut scene);
    }
    if scene.bodies.is_empty() {
        return Err(Failure::in_file(path, SceneProblem::NoModelMeshes));
    }
    scene.check_names()?;
    Ok(scene)
}

/// Adds the meshes of a body.
fn add_meshes(body: &ModelBody, folder: &Path, model: &Path, scene: &mut SceneDescription) {
    let to_mass_center = DAffine3::from_translation(-body.mass_center);
    for mesh in &body.meshes {
        // A body of one mesh has its name.
        let of_mesh = format!("{}.{}", body.name, stem(Path::new(&mesh.file)));
        let name = if body.meshes.len() == 1 { body.name.clone() } else { of_mesh };
        let Some(file) = found(folder, &mesh.file) else {
            let problem = format!(
                "{}: {name} is left out: its mesh '{}' is neither beside the model nor in {GEOMETRY}",
                model.display(),
                mesh.file
            );
            terminal::print_line("warning", &problem);
            continue;
        };

        // The map from bodies to meshes is stated.
        terminal::print_line("note", &format!("{name} follows {}: {}", body.name, file.display()));
        scene.bodies.push(BodyDescription {
            kind: Some(BodyKind::Rigid),
            follows: Some(body.name.clone()),
            placement: Some(to_mass_center * mesh.placement),
            ..BodyDescription::of_file(name, &file, &[])
        });
    }
}

/// Finds a mesh beside its model, or in the folder of its geometry.
fn found(folder: &Path, file: &str) -> Option<PathBuf> {
    [folder.join(file), folder.join(GEOMETRY).join(file)].into_iter().find(|path| path.is_file())
}
