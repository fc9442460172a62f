//! Scenes from their descriptions: every mesh read and inspected, in parallel.

use std::fmt::Display;
use std::path::{Path, PathBuf};

use clap::Args;
use glam::DVec3;
use mesh_io::{FileError, Mesh, Space, Volume};
use musculo_collide::surface::{
    Aabb, PositionBuffer, Positions, SurfaceError, TriangleSurface, inspect, parallel,
};
use musculo_collide::{BodyId, BodyKind, PairReport, Scene, SceneError};

use crate::failure::{Failure, FailureKind};
use crate::output::FilePlan;
use crate::phase::Phase;
use crate::report::{
    BodyRecord, CheckDocument, InvertedPart, PairRecord, VolumeRecord, counted, divisions,
    self_crossings,
};
use crate::scene::{BodyDescription, IgnoredPair, SceneDescription, unit_warnings};
use crate::terminal;

/// Arguments that name the bodies of a scene.
#[derive(Debug, Args)]
pub(crate) struct SceneArguments {
    /// Scene file (.toml), or mesh files: PLY, OBJ, OFF, STL or VTP; volume meshes and surfaces: VTU,
    /// VTK, MSH or INP; models of FEBio (.feb) and Abaqus (.inp), whose parts or instances are bodies
    #[arg(required = true, value_name = "SCENE.toml | MESH")]
    pub(crate) inputs: Vec<PathBuf>,

    /// Body that does not deform (a bone); may be given several times
    #[arg(long, value_name = "NAME")]
    rigid: Vec<String>,

    /// The same as --rigid
    #[arg(long, value_name = "NAME")]
    fixed: Vec<String>,
}

impl SceneArguments {
    /// Describes the scene, without reading its meshes.
    pub(crate) fn describe(&self) -> Result<SceneDescription, Failure> {
        let mut description = SceneDescription::from_inputs(&self.inputs)?;

        // A name that no body has is answered by the option as it was given.
        for (option, names) in [("--rigid", &self.rigid), ("--fixed", &self.fixed)] {
            let named = description.set_rigid(names);
            named.map_err(|problem| Failure::new(format!("{option}: {problem}")))?;
        }
        Ok(description)
    }

    /// Begins a plan of the files that a command reads and writes.
    pub(crate) fn plan(&self, description: &SceneDescription) -> FilePlan {
        FilePlan::reading(self.inputs.iter().cloned().chain(files_of(description)))
    }
}

/// Returns the files that a scene names: its meshes, its motion, and lists of vertices.
pub(crate) fn files_of(description: &SceneDescription) -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> = description.motion.iter().cloned().collect();
    for body in &description.bodies {
        files.push(body.path.clone());
    }
    files.extend(description.vertex_files());
    files
}

/// Scene with the inspection of its meshes.
#[derive(Debug)]
pub(crate) struct LoadedScene {
    pub(crate) description: SceneDescription,
    pub(crate) scene: Scene,
    pub(crate) bodies: Vec<BodyRecord>,
    /// Volume meshes of the bodies that have one.
    pub(crate) volumes: Vec<Option<Volume>>,
    /// Per body, the numbers of its vertices in the file, where they are not counted from 0.
    pub(crate) vertex_numbers: Vec<Option<Vec<u64>>>,
    /// Index of each vertex among the nodes of its file, of bodies that are parts of one.
    pub(crate) nodes: Vec<Option<Vec<u32>>>,
    /// Space that files state, which is that of all.
    pub(crate) space: Option<Space>,
}

impl LoadedScene {
    /// Reads and inspects the meshes of a scene; a failure names every file that cannot be
    /// read.
    pub(crate) fn load(description: SceneDescription) -> Result<Self, Failure> {
        let (meshes, space) = read_meshes(&description)?;

        // Bodies in the order of the description, whichever was read first.
        let mut loaded = Self {
            description,
            scene: Scene::new(),
            bodies: Vec::new(),
            volumes: Vec::new(),
            vertex_numbers: Vec::new(),
            nodes: Vec::new(),
            space,
        };
        let mut ids = Vec::new();
        for inspected in meshes {
            let InspectedMesh { record, surface, positions, volume, vertex_numbers, nodes } =
                inspected?;
            let (name, kind) = (record.name.as_str(), record.kind);
            ids.push(loaded.scene.add(name, kind, surface, positions)?);
            loaded.bodies.push(record);
            loaded.volumes.push(volume);
            loaded.vertex_numbers.push(vertex_numbers);
            loaded.nodes.push(nodes);
        }

        for IgnoredPair { a, b } in &loaded.description.ignored {
            let (a, b) = (loaded.description.index_of(a)?, loaded.description.index_of(b)?);
            loaded.scene.ignore(ids[a], ids[b]);
        }
        Ok(loaded)
    }

    /// Returns the number of a node in the file of a body that is a part of it.
    pub(crate) fn node_number(&self, body: BodyId, node: u32) -> u64 {
        let body = body.index();
        if let Some(volume) = &self.volumes[body] {
            return volume.node_numbers[(node - volume.first_node) as usize];
        }
        let vertex = self.nodes[body].as_ref().and_then(|nodes| nodes.binary_search(&node).ok());
        let numbers = self.vertex_numbers[body].as_ref();
        vertex.zip(numbers).map_or(u64::from(node), |(vertex, numbers)| numbers[vertex])
    }

    /// Returns the margin of the description, or else the mean edge length of all bodies.
    pub(crate) fn margin(&self) -> f64 {
        self.description.margin.unwrap_or_else(|| self.mean_edge())
    }

    /// Returns the mean edge length of all bodies.
    pub(crate) fn mean_edge(&self) -> f64 {
        scene_edge(&self.bodies)
    }

    /// Returns the mean edge length of all bodies that can deform, or else of all.
    pub(crate) fn soft_edge(&self) -> f64 {
        let soft = self.bodies.iter().filter(|body| body.kind != BodyKind::Rigid);
        let edge = scene_edge(soft);

        // Without soft bodies there is no such edge, and nothing that would move.
        if edge > 0.0 { edge } else { self.mean_edge() }
    }

    /// Gathers the results of a check.
    pub(crate) fn document(&mut self, reports: &[PairReport]) -> Result<CheckDocument, SceneError> {
        let (mut sizes, mut pairs) = (Vec::new(), Vec::new());
        for body in &self.bodies {
            sizes.push((body.name.as_str(), body.inspection.bounds.unwrap_or(Aabb::EMPTY)));
        }
        for pair in reports {
            pairs.push(PairRecord::new(pair, &self.scene));
        }
        let mut bodies = self.bodies.clone();
        for (record, crossings) in bodies.iter_mut().zip(self_crossings(&mut self.scene)?) {
            record.self_crossings = crossings;
        }
        for (record, body) in bodies.iter_mut().zip(self.scene.bodies()) {
            record.inverted_parts = InvertedPart::list(body);
        }

        // A place that a body covers twice counts twice in what it shares with others.
        for body in bodies.iter().filter(|body| body.self_crossings.is_some()) {
            for pair in &mut pairs {
                pair.note_self_crossings(&body.name);
            }
        }

        Ok(CheckDocument {
            unit: self.description.unit,
            margin: self.margin(),
            joint_contact: None,
            warnings: unit_warnings(&sizes),
            divisions: divisions(&mut self.scene, reports)?,
            pairs,
            bodies,
        })
    }
}

fn scene_edge<'a>(bodies: impl IntoIterator<Item = &'a BodyRecord>) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);

    // The mean over all edges, not over the means of the bodies.
    for body in bodies {
        let edges = f64::from(u32::try_from(body.inspection.edges).unwrap_or(u32::MAX));
        sum += edges * body.inspection.mean_edge;
        count += edges;
    }
    if count > 0.0 { sum / count } else { 0.0 }
}

/// Mesh of a body, or the reason why it cannot be a body.
type Inspected = Result<InspectedMesh, SceneError>;

/// Reads and inspects the meshes of all bodies, the largest files first; returns them with the space that
/// files state.
fn read_meshes(description: &SceneDescription) -> Result<(Vec<Inspected>, Option<Space>), Failure> {
    let _phase = Phase::start("reading");
    let files = description.bodies_by_file();
    let results = parallel::map_costly_first(
        &files,
        |bodies| file_length(&description.bodies[bodies[0]]),
        || (),
        |(), bodies| {
            let bodies = bodies.iter().map(|&number| &description.bodies[number]);
            read_file_of(&bodies.collect::<Vec<_>>())
        },
    );

    // Every file that cannot be read is named, not the first alone.
    let (mut problems, mut spaces) = (Vec::new(), Vec::new());
    let mut meshes: Vec<Option<Inspected>> = description.bodies.iter().map(|_| None).collect();
    for (bodies, result) in files.iter().zip(results) {
        match result {
            Ok((space, of_file)) => {
                let first = &description.bodies[bodies[0]];
                spaces.extend(space.map(|space| (first, space)));
                for (&number, mesh) in bodies.iter().zip(of_file) {
                    if let Ok(InspectedMesh { record, .. }) = &mesh {
                        let problems = [&record.joined, &record.unread, &record.skipped];
                        for problem in problems.into_iter().flatten() {
                            warn_of(&first.path, problem);
                        }
                    }
                    meshes[number] = Some(mesh);
                }
            }
            Err(error) => problems.push(error.to_string()),
        }
    }
    let meshes: Vec<Inspected> = meshes.into_iter().flatten().collect();
    problems.extend(mixed_spaces(&spaces));
    if problems.is_empty() {
        warn_of_unstated_spaces(&description.bodies, &spaces);
        note_element_sets(&description.bodies);
        return Ok((meshes, spaces.first().map(|&(_, space)| space)));
    }
    Err(Failure { kind: FailureKind::Input, problems })
}

/// Reads and inspects the meshes of one file, of these bodies; returns them with the space that it states.
fn read_file_of(bodies: &[&BodyDescription]) -> Result<(Option<Space>, Vec<Inspected>), FileError> {
    let parts: Vec<&[String]> = bodies.iter().map(|body| &*body.parts).collect();
    let (mut space, mut inspected) = (None, Vec::new());
    for (body, mesh) in bodies.iter().zip(mesh_io::read_parts(&bodies[0].path, &parts)?) {
        space = space.or(mesh.space);
        inspected.push(InspectedMesh::new(body, mesh));
    }
    Ok((space, inspected))
}

/// Warns of files that state no space beside others that do.
fn warn_of_unstated_spaces(bodies: &[BodyDescription], spaces: &[(&BodyDescription, Space)]) {
    let states = |path: &Path| spaces.iter().any(|(stating, _)| stating.path == path);
    let mut unstated = bodies.iter().filter(|body| !states(&body.path));
    let (Some((stating, space)), Some(first)) = (spaces.first(), unstated.next()) else { return };

    let (stating, first) = (stating.path.display(), first.path.display());
    let none = match unstated.count() {
        0 => format!("{first} states none"),
        more => format!("{first} and {more} more state none"),
    };
    let problem = format!("{stating} states the space {space}, but {none}");
    terminal::print_line("warning", &format!("{problem}: they are taken to be in the same"));
}

/// Notes the element sets of a file that is the only body of the scene: they may be meant as bodies.
fn note_element_sets(bodies: &[BodyDescription]) {
    let [body] = bodies else { return };
    // A pipe has been read.
    let is_whole_file = body.parts.is_empty() && body.path.is_file();
    let content = is_whole_file.then(|| mesh_io::read_file(&body.path).ok()).flatten();
    let sets = content.map(|content| mesh_io::set_names(&content, &mesh_io::extension(&body.path)));
    let sets = sets.and_then(Result::ok).unwrap_or_default();
    if let [first, _, ..] = &*sets {
        let (path, count) = (body.path.display(), counted(sets.len(), "element set"));
        let note = format!(
            "{path} is one body of {count}, the first '{}': a scene file takes them as bodies by their names \
             (parts = [\"{}\"])",
            mesh_io::escaped(first),
            mesh_io::escaped(first)
        );
        terminal::print_line("note", &note);
    }
}

/// Describes the first two files that state different spaces: bodies would be mirrored in each other.
fn mixed_spaces(spaces: &[(&BodyDescription, Space)]) -> Option<String> {
    let (first, space) = spaces.first()?;
    let (other, other_space) = spaces.iter().find(|(_, other)| other != space)?;
    let files = [first, other].map(|body| body.path.display());
    Some(format!(
        "{} states the space {space}, but {} the space {other_space}: save both in one",
        files[0], files[1]
    ))
}

/// Returns the length of a body's file, 0 where it cannot be read.
#[expect(clippy::cast_precision_loss, reason = "an estimate of the time to read it")]
fn file_length(body: &BodyDescription) -> f64 {
    std::fs::metadata(&body.path).map_or(0.0, |file| file.len() as f64)
}

/// Warns of a mesh file, whatever the command.
fn warn_of(path: &Path, problem: &impl Display) {
    terminal::print_line("warning", &format!("{}: {problem}", path.display()));
}

/// Surface of one mesh file.
#[derive(Debug)]
pub(crate) struct LoadedSurface {
    pub(crate) surface: TriangleSurface,
    positions: PositionBuffer,
    /// Space that the file states.
    pub(crate) space: Option<Space>,
}

impl LoadedSurface {
    /// Reads a file, or some of its parts by their names.
    pub(crate) fn read(path: &Path, parts: &[String]) -> Result<Self, Failure> {
        let _phase = Phase::start("reading");
        let mut meshes = mesh_io::read_parts(path, &[parts])?;
        let Some(mesh) = meshes.pop() else {
            return Err(Failure::in_file(path, "has no mesh"));
        };
        if let Some(unread) = &mesh.unread {
            warn_of(path, unread);
        }
        if let Some(skipped) = &mesh.skipped {
            warn_of(path, skipped);
        }

        let Mesh { positions, faces, space, .. } = mesh;
        let refused = |error: SurfaceError| Failure::in_file(path, error);
        let surface = TriangleSurface::new(positions.len(), faces).map_err(refused)?;
        let positions = surface.own_positions(positions).map_err(refused)?;

        Ok(Self { surface, positions, space })
    }

    pub(crate) fn positions(&self) -> Positions<'_> {
        self.positions.as_positions()
    }
}

/// Mesh with its topology and its record.
struct InspectedMesh {
    record: BodyRecord,
    surface: TriangleSurface,
    positions: Vec<DVec3>,
    volume: Option<Volume>,
    vertex_numbers: Option<Vec<u64>>,
    nodes: Option<Vec<u32>>,
}

impl InspectedMesh {
    fn new(body: &BodyDescription, mesh: Mesh) -> Result<Self, SceneError> {
        let refused = |source| SceneError::Surface { name: body.name.clone(), source };
        let Mesh { mut positions, mut faces, mut volume, vertex_numbers, nodes, .. } = mesh;
        if let Some(placement) = &body.placement {
            // Its nodes stay where the file has them, so that it is a surface here.
            volume = None;
            for x in &mut positions {
                *x = placement.transform_point3(*x);
            }

            // A mirror image is inside out.
            if placement.matrix3.determinant() < 0.0 {
                faces.iter_mut().for_each(|face| face.swap(1, 2));
            }
        }
        let surface = TriangleSurface::new(positions.len(), faces).map_err(refused)?;
        let x = surface.positions(&positions).map_err(refused)?;
        let inspection = inspect(&surface, x);

        // The inspection first: the record has its verdicts, and all of its numbers.
        let record = BodyRecord {
            name: body.name.clone(),
            file: body.file.clone(),
            kind: body.kind.unwrap_or(if mesh.is_rigid {
                BodyKind::Rigid
            } else {
                BodyKind::Deformable
            }),
            polygons_fanned: mesh.polygons_fanned,
            joined: (mesh.object_count > 1).then(|| {
                let objects = counted(mesh.object_count, "object");
                format!("{objects} as one body: save each in a file of its own for several")
            }),
            unread: mesh.unread.as_ref().map(ToString::to_string),
            skipped: mesh.skipped.as_ref().map(ToString::to_string),
            closed: inspection.closed(),
            manifold: inspection.manifold(),
            oriented: inspection.oriented(),
            inspection,
            self_crossings: None,
            inverted_parts: Vec::new(),
            volume_mesh: volume.as_ref().map(VolumeRecord::new),
        };
        Ok(Self { record, surface, positions, volume, vertex_numbers, nodes })
    }
}
