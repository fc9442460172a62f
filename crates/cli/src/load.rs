//! From a description to bodies in a scene: every file read, every mesh
//! inspected, in parallel.

use glam::DVec3;
use mesh_io::Mesh;
use musculo_collide::surface::{TriangleSurface, inspect};
use musculo_collide::{BodyKind, SceneError};
use rayon::prelude::*;

use crate::commands::Failure;
use crate::progress::Progress;
use crate::report::{BodyRecord, BodySource};
use crate::scene::{Bounds, Scene, Unit};

/// Reads every file, and names each that cannot be.
pub(crate) fn read_meshes(description: &Scene) -> Result<Vec<Mesh>, Failure> {
    let _progress = Progress::start("reading", 1);
    let bodies = description.bodies.par_iter();
    let results: Vec<_> = bodies.map(|body| mesh_io::read_mesh(&body.path)).collect();
    let (mut meshes, mut problems) = (Vec::new(), Vec::new());
    for result in results {
        match result {
            Ok(mesh) => meshes.push(mesh),
            Err(error) => problems.push(error.to_string()),
        }
    }
    if problems.is_empty() { Ok(meshes) } else { Err(Failure::new(problems)) }
}

/// A mesh that was looked over, on its way into the scene.
struct Built {
    kind: BodyKind,
    surface: TriangleSurface,
    positions: Vec<DVec3>,
    record: BodyRecord,
}

/// Builds a scene of meshes, with what inspection found of each.
pub(crate) fn build_scene(
    description: &Scene,
    meshes: Vec<Mesh>,
) -> Result<(musculo_collide::Scene, Vec<BodyRecord>), Failure> {
    let _progress = Progress::start("inspecting meshes", 1);
    let built: Vec<Result<Built, SceneError>> = description
        .bodies
        .par_iter()
        .zip(meshes)
        .map(|(body, mesh)| build_one(body, description.unit, mesh))
        .collect();
    let mut scene = musculo_collide::Scene::new();
    let (mut records, mut ids) = (Vec::new(), Vec::new());
    for built in built {
        let Built { kind, surface, positions, record } = built?;
        ids.push(scene.add(record.name.as_str(), kind, surface, positions)?);
        records.push(record);
    }
    for &[a, b] in &description.ignored {
        scene.ignore(ids[a], ids[b]);
    }
    Ok((scene, records))
}

fn build_one(body: &crate::scene::Body, unit: Unit, mesh: Mesh) -> Result<Built, SceneError> {
    let refused = |source| SceneError::Surface { name: body.name.clone(), source };
    let Mesh { positions, faces, polygons_fanned } = mesh;
    let surface = TriangleSurface::new(positions.len(), faces).map_err(refused)?;
    let inspection = inspect(&surface, surface.positions(&positions).map_err(refused)?);
    let source = BodySource { body, bounds: Bounds::of(&positions), polygons_fanned, unit };
    let record = BodyRecord::new(source, &inspection);
    Ok(Built { kind: body.kind, surface, positions, record })
}
