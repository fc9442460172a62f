//! Files of all bodies after overlap removal, and the state that they hold.

use glam::DVec3;
use mesh_io::{MeshFormat, Precision};
use musculo_collide::{BodyChange, BodyId, Progress};

use super::body_file::{BodyFile, is_rewritten};
use super::resolve_parts::{complete_parts, following_steps};
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

/// Rounding of the positions of a body in its file.
#[derive(Clone, Copy)]
pub(super) struct FileRounding {
    pub(super) precision: Precision,
    /// Bound on the distance by which positions are rounded because the file has them in the axes of a part.
    pub(super) of_placement: f64,
}

/// Returns the rounding of each body. Rigid bodies are copied, and new files have double precision.
pub(super) fn file_roundings(loaded: &LoadedScene) -> Result<Vec<FileRounding>, Failure> {
    let (bodies, described) = (loaded.scene.bodies(), &loaded.description.bodies);
    let none = FileRounding { precision: Precision::Double, of_placement: 0.0 };
    let mut roundings = vec![none; bodies.len()];
    for numbers in soft_bodies_by_file(loaded) {
        let path = &described[numbers[0]].path;
        let refused = |error| Failure::in_file(path, error);
        let (content, extension) = (mesh_io::read_file(path)?, mesh_io::extension(path));
        let precision = mesh_io::coordinate_precision(&content, &extension).map_err(refused)?;
        let (mut parts, mut sizes) = (Vec::new(), Vec::new());
        for &number in &numbers {
            parts.push(&*described[number].parts);
            sizes.push(bodies[number].largest_coordinate());
        }
        let of_placements =
            mesh_io::placement_roundings(&content, &extension, &parts, &sizes).map_err(refused)?;
        for (number, of_placement) in numbers.into_iter().zip(of_placements) {
            roundings[number] = FileRounding { precision, of_placement };
        }
    }
    Ok(roundings)
}

/// Refuses soft bodies whose nodes are those of other instances, too: their part has one set of coordinates.
pub(super) fn check_shared_parts(loaded: &LoadedScene) -> Result<(), Failure> {
    let described = &loaded.description.bodies;
    for numbers in soft_bodies_by_file(loaded) {
        let path = &described[numbers[0]].path;
        if described[numbers[0]].parts.is_empty() {
            continue;
        }
        let content = mesh_io::read_file(path)?;
        let parts = mesh_io::instances_by_part(&content, &mesh_io::extension(path))
            .map_err(|error| Failure::in_file(path, error))?;
        for (part, instances) in parts.iter().filter(|(_, instances)| instances.len() > 1) {
            let can_move =
                |name: &String| numbers.iter().any(|&number| described[number].has_part(name));
            let Some(own) = instances.iter().position(can_move) else { continue };
            let names = [part, &instances[own], &instances[usize::from(own == 0)]];
            let [part, own, other] = names.map(|name| mesh_io::escaped(name));
            let problem = format!(
                "'{own}' can move, but its part '{part}' has one set of coordinates, which are those of \
                 '{other}', too: give '{own}' a part of its own, or make all instances of '{part}' rigid"
            );
            return Err(Failure::in_file(path, problem));
        }
    }
    Ok(())
}

/// Returns the numbers of the bodies of each file that can move and are written into a copy of it.
fn soft_bodies_by_file(loaded: &LoadedScene) -> Vec<Vec<usize>> {
    let bodies = loaded.scene.bodies();
    let mut files = loaded.description.bodies_by_file();
    for numbers in &mut files {
        numbers.retain(|&number| {
            !bodies[number].is_rigid() && is_rewritten(&loaded.description.bodies[number])
        });
    }
    files.retain(|numbers| !numbers.is_empty());
    files
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
    let steps: Vec<usize> = ids.iter().map(|id| following_steps(loaded, *id, start)).collect();
    let (all, mut done) = (steps.iter().sum(), 0);
    for numbers in loaded.description.bodies_by_file() {
        let first = numbers[0];
        let before = done;
        done += numbers.iter().map(|&number| steps[number]).sum::<usize>();
        let progress = progress.part(share(before, all), share(done, all));
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

#[expect(clippy::cast_precision_loss, reason = "a share of progress needs few digits")]
fn share(done: usize, all: usize) -> f64 {
    done as f64 / all as f64
}

/// Returns true if a body is written as a part of a copy of its file.
fn is_part(loaded: &LoadedScene, body: usize) -> bool {
    loaded.nodes[body].is_some() && is_rewritten(&loaded.description.bodies[body])
}
