//! Files of all bodies after overlap removal, and the state that they hold.

use glam::DVec3;
use mesh_io::{MeshFormat, Precision};
use musculo_collide::{BodyChange, BodyId, Progress};

use super::body_file::{BodyFile, extension, is_rewritten};
use super::resolve_parts::complete_parts;
use crate::failure::Failure;
use crate::load::LoadedScene;
use crate::scene::BodyDescription;

/// Returns the extension of the file that a body is written to, with its dot: its own, unless a new
/// file has another format.
pub(super) fn suffix(body: &BodyDescription) -> String {
    match body.path.extension() {
        Some(own) if is_rewritten(body) || MeshFormat::of(&body.path).is_some() => {
            format!(".{}", own.to_string_lossy())
        }
        None if is_rewritten(body) => String::new(),
        _ => format!(".{}", MeshFormat::Ply.extension()),
    }
}

/// Returns the number type in which each body is written. Rigid bodies are copied, and new files have double
/// precision.
pub(super) fn precisions(loaded: &LoadedScene) -> Result<Vec<Precision>, Failure> {
    let mut precisions = Vec::new();
    for (description, body) in loaded.description.bodies.iter().zip(loaded.scene.bodies()) {
        let (path, mut precision) = (&description.path, Precision::Double);
        if !body.is_rigid() && is_rewritten(description) {
            let content = mesh_io::read_file(path)?;
            precision = mesh_io::coordinate_precision(&content, &extension(path))
                .map_err(|error| Failure::in_file(path, error))?;
        }
        precisions.push(precision);
    }
    Ok(precisions)
}

/// Refuses soft volume meshes with inverted elements, which cannot follow their surfaces.
pub(super) fn check_elements(loaded: &LoadedScene) -> Result<(), Failure> {
    for (volume, body) in loaded.volumes.iter().zip(loaded.scene.bodies()) {
        let Some(volume) = volume.as_ref().filter(|_| !body.is_rigid()) else { continue };
        let quality = volume.mesh.quality(&volume.nodes);
        if quality.inverted > 0 {
            return Err(Failure::new(format!(
                "'{}' has {} elements that are inverted or flat at the start, the worst is {} with \
                 a scaled Jacobian of {:.3}",
                body.name(),
                quality.inverted,
                volume.cell_numbers[quality.worst_cell],
                quality.min_scaled_jacobian,
            )));
        }
    }
    Ok(())
}

/// Completes the files of all bodies, and moves the bodies to what these hold; their `changes` are then those in
/// the files. `start` has the positions before overlap removal.
pub(super) fn complete_files(
    loaded: &mut LoadedScene,
    start: &[Vec<DVec3>],
    changes: &mut [BodyChange],
    progress: Progress<'_>,
) -> Result<Vec<BodyFile>, Failure> {
    let mut files = Vec::new();
    let ids: Vec<BodyId> = loaded.scene.ids().collect();
    for numbers in loaded.description.bodies_by_file() {
        let first = numbers[0];
        let bodies: Vec<BodyId> = numbers.into_iter().map(|number| ids[number]).collect();
        let of_file = if is_part(loaded, first) {
            complete_parts(loaded, &bodies, start, progress)?
        } else {
            let description = &loaded.description.bodies[first];
            let (volume, space) = (loaded.volumes[first].as_ref(), loaded.space);
            let (scene, start) = (&mut loaded.scene, &start[first]);
            let body = bodies[0];
            vec![BodyFile::complete(description, volume, space, scene, body, start, progress)?]
        };
        files.extend(bodies.into_iter().zip(of_file));
    }

    // What was written may be elsewhere than what was pushed apart.
    files.sort_by_key(|(body, _)| body.index());
    for (body, file) in &files {
        let (start, change) = (&start[body.index()], &mut changes[body.index()]);
        if file.displacements != change.displacements {
            *change = BodyChange::since(&mut loaded.scene, *body, start, progress)?;
        }
    }
    Ok(files.into_iter().map(|(_, file)| file).collect())
}

/// Returns true if a body is written as a part of a copy of its file.
fn is_part(loaded: &LoadedScene, body: usize) -> bool {
    loaded.nodes[body].is_some() && is_rewritten(&loaded.description.bodies[body])
}
