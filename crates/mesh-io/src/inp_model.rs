//! Bodies of an Abaqus input file: instances of its parts where the assembly has them, or the parts of a file without
//! instances, or the element sets of a file with one of them or none.
//!
//! A file with one part or instance at most is one body unless sets are named. The nodes of a model are those
//! of its instances, one instance after the other: a part with several instances has its nodes once per instance,
//! each with the place of the same coordinates in the file.
//!
//! Source: "Abaqus Analysis User's Guide", "Defining an assembly".

use std::collections::BTreeMap;

use glam::DVec3;

use crate::ReadError;
use crate::copy::{Copy, Precision, check_range};
use crate::inp::{InpContent, Sorting, parse_content, unsupported_type};
use crate::inp_keyword::{INP, InpLine, InpLines};
use crate::inp_outline::{Outline, Section};
use crate::inp_placement::Placement;
use crate::inp_rigid::{ElementList, RigidElements};
use crate::mesh::Mesh;
use crate::parts::{FileParts, Part, PartNodes};
use crate::text::{Lines, quoted};
use crate::volume::MeshElements;

/// Maximum number of nodes and elements of instances whose part has another one before them. Below, models with
/// many screws would be refused; above, a small file could fill the memory.
const MAX_REPEATED: usize = 1 << 22;

/// Name of what the elements of a file without parts are that are of no set.
const WITHOUT_SET: &str = "elements without a set";

/// Parts of a file with the places of their nodes.
#[derive(Debug)]
pub(crate) struct InpModel {
    parts: FileParts,
    /// Bodies in the order of their nodes.
    bodies: Vec<BodyNodes>,
}

/// Nodes of an instance.
#[derive(Debug)]
struct BodyNodes {
    /// Index behind that of the last node.
    end: usize,
    placement: Option<Placement>,
    /// Name of the part whose nodes these are, where others are instances of it.
    shared_part: Option<String>,
}

/// Reads the only body of a file.
pub(crate) fn parse(bytes: &[u8]) -> Result<Mesh, ReadError> {
    let outline = Outline::read(bytes)?;
    if outline.has_several() {
        InpModel::of_outline(&outline)?.parts.mesh(&[])
    } else {
        whole(bytes, &outline)
    }
}

/// Reads the meshes of bodies, each by the names of its parts.
pub(crate) fn parse_parts(bytes: &[u8], bodies: &[&[String]]) -> Result<Vec<Mesh>, ReadError> {
    let outline = Outline::read(bytes)?;
    let model = InpModel::of_parts_or_sets(bytes, &outline)?;
    let is_whole = |name: &String| {
        model.parts.whole.as_ref().is_some_and(|whole| name.eq_ignore_ascii_case(whole))
    };
    let mut meshes = Vec::new();
    for names in bodies {
        meshes.push(if names.is_empty() {
            parse(bytes)?
        } else if names.iter().any(is_whole) {
            InpModel::of_only_part(bytes, &outline)?.parts.mesh(&[])?
        } else {
            model.parts.mesh(&model.spelled(names))?
        });
    }
    Ok(meshes)
}

/// Returns the names of the bodies that are meshes, none of a file that is one body.
pub(crate) fn part_names(bytes: &[u8]) -> Result<Vec<String>, ReadError> {
    let outline = Outline::read(bytes)?;
    Ok(if outline.has_several() {
        InpModel::of_outline(&outline)?.parts.names()
    } else {
        Vec::new()
    })
}

/// Returns the names of the element sets that are meshes, none of a file with several parts or instances.
pub(crate) fn set_names(bytes: &[u8]) -> Result<Vec<String>, ReadError> {
    let outline = Outline::read(bytes)?;
    if outline.has_several() {
        return Ok(Vec::new());
    }
    let parts = InpModel::of_parts_or_sets(bytes, &outline)?.parts;
    Ok(parts.names().into_iter().filter(|name| Some(name) != parts.whole.as_ref()).collect())
}

/// Returns the names of ties, numbered where they have none.
pub(crate) fn tie_names(bytes: &[u8]) -> Vec<String> {
    let mut names = Vec::new();
    for line in InpLines::new(Lines::new(bytes)) {
        if let InpLine::Keyword(keyword) = line
            && keyword.name == "TIE"
        {
            let numbered = || format!("tie {}", names.len() + 1);
            names.push(keyword.value("NAME").map_or_else(numbered, str::to_owned));
        }
    }
    names
}

/// Returns the names of the instances that have the nodes of a part, by its name.
pub(crate) fn instances_by_part(bytes: &[u8]) -> Result<BTreeMap<String, Vec<String>>, ReadError> {
    let outline = Outline::read(bytes)?;
    if outline.has_several() { outline.instances_by_part() } else { Ok(BTreeMap::new()) }
}

/// Returns bounds on the distances by which placements round positions that are written, per body by the names of its
/// instances, or else of all. Each has the maximum of its coordinates.
pub(crate) fn placement_roundings(
    bytes: &[u8],
    bodies: &[&[String]],
    max_coordinates: &[f64],
) -> Result<Vec<f64>, ReadError> {
    let outline = Outline::read(bytes)?;
    let rounding = |(names, &max_coordinate): (&&[String], &f64)| {
        let is_own = |instance: &&Section<'_>| {
            let own = instance.name.as_deref().unwrap_or_default();
            names.is_empty() || names.iter().any(|name| name.eq_ignore_ascii_case(own))
        };
        let placements = outline.instances.iter().filter(is_own);
        let placements = placements.filter_map(|instance| instance.placement.as_ref());
        placements.map(|placement| placement.max_rounding(max_coordinate)).fold(0.0, f64::max)
    };
    Ok(bodies.iter().zip(max_coordinates).map(rounding).collect())
}

/// Reads all nodes and elements of a file with one part or instance at most.
fn whole(bytes: &[u8], outline: &Outline<'_>) -> Result<Mesh, ReadError> {
    let read =
        |elements| parse_content(InpLines::new(Lines::new(bytes)), elements, Sorting::Wanted);
    let mut content = read(MeshElements::Cells)?;
    if content.only_part().cells.is_empty() {
        content = read(MeshElements::Polygons)?;
    }
    let placement = outline.instances.first().and_then(|instance| instance.placement.as_ref());
    let mut nodes = std::mem::take(&mut content.nodes.numbered);
    if let Some(placement) = placement {
        nodes.positions.iter_mut().for_each(|x| *x = placement.place(*x));
    }

    let is_rigid = content.is_rigid(0, &outline.rigid_elements_of_all()?);

    // Of what there is no mesh, the first type is named.
    let part = content.only_part();
    let has_mesh = !part.cells.is_empty() || !part.polygons.is_empty();
    if let (false, Some(kind)) = (has_mesh, part.skipped.counts.keys().next()) {
        return Err(unsupported_type(kind));
    }
    let skipped = part.skipped.clone().if_any();
    let mesh = Mesh::of_elements(
        nodes,
        std::mem::take(&mut part.cells),
        &part.polygons,
        &BTreeMap::new(),
    )?;
    Ok(Mesh { skipped, is_rigid, ..mesh })
}

impl InpModel {
    /// Reads a file with all of its parts: its element sets, where it has one part at most.
    pub(crate) fn read(bytes: &[u8]) -> Result<Self, ReadError> {
        Self::of_parts_or_sets(bytes, &Outline::read(bytes)?)
    }

    fn of_parts_or_sets(bytes: &[u8], outline: &Outline<'_>) -> Result<Self, ReadError> {
        if outline.has_several() {
            return Self::of_outline(outline);
        }
        let mut content = read_parts(&Lines::new(bytes), Sorting::Sets)?;
        content.mark_rigid(&outline.rigid_elements_of_all()?);
        let others = content.parts.remove(0).without_mesh(WITHOUT_SET);
        content.parts.extend(others);
        let mut model = Self::of_one_body(content, outline)?;
        model.parts.whole = outline.only_name().map(str::to_owned);
        Ok(model)
    }

    /// Reads the only part of a file.
    fn of_only_part(bytes: &[u8], outline: &Outline<'_>) -> Result<Self, ReadError> {
        let mut content = read_parts(&Lines::new(bytes), Sorting::Part)?;
        content.mark_rigid(&outline.rigid_elements_of_all()?);
        content.parts[0].set_name(outline.only_name().unwrap_or_default());
        Self::of_one_body(content, outline)
    }

    /// Reads the nodes of a file alone.
    pub(crate) fn read_nodes(bytes: &[u8]) -> Result<Self, ReadError> {
        let outline = Outline::read(bytes)?;
        if outline.has_several() {
            return Self::of_outline(&outline);
        }
        let lines = InpLines::new(Lines::new(bytes));
        let content = parse_content(lines, MeshElements::Cells, Sorting::Part)?;
        Self::of_one_body(InpContent { parts: Vec::new(), ..content }, &outline)
    }

    /// Returns the model of a file with one part or instance at most.
    fn of_one_body(content: InpContent, outline: &Outline<'_>) -> Result<Self, ReadError> {
        let mut model = Self::new();
        let placement = outline.instances.first().and_then(|instance| instance.placement.clone());
        model.push_nodes(&content, placement, None)?;
        content.parts.into_iter().for_each(|part| model.parts.push(part));
        Ok(model)
    }

    /// Reads a file of several parts or instances.
    fn of_outline(outline: &Outline<'_>) -> Result<Self, ReadError> {
        let part_of = outline.parts_of_instances()?;
        check_outside(outline)?;
        let mut parts = Vec::new();
        for part in &outline.parts {
            parts.push(read_parts(&part.lines, Sorting::Part)?);
        }
        let mut model = Self::new();
        if outline.instances.is_empty() {
            for (part, content) in outline.parts.iter().zip(&parts) {
                let rigid = outline.rigid_elements(part)?;
                model.push_body(part, content, &rigid, None)?;
            }
            return Ok(model);
        }

        // An instance may have a mesh of its own in the place of its part's.
        let shared = outline.instances_by_part()?;
        let (mut is_used, mut repeated) = (vec![false; parts.len()], 0);
        for (instance, part) in outline.instances.iter().zip(part_of) {
            let own = read_parts(&instance.lines, Sorting::Part)?;
            let rigid = outline.rigid_elements(instance)?;
            let of_part = part.filter(|&part| !parts[part].nodes.places.is_empty());
            let Some(part) = of_part else {
                model.push_body(instance, &own, &rigid, None)?;
                continue;
            };
            if !own.nodes.places.is_empty() {
                let name = quoted(instance.name.as_deref().unwrap_or_default());
                let feature = format!("the instance {name} with nodes beside those of its part");
                return Err(INP.unsupported(feature));
            }
            if std::mem::replace(&mut is_used[part], true) {
                repeated += parts[part].nodes.places.len() + parts[part].parts[0].len();
            }
            if repeated > MAX_REPEATED {
                let feature = format!(
                    "instances that repeat parts by more than {MAX_REPEATED} nodes and elements"
                );
                return Err(INP.unsupported(feature));
            }
            let name = outline.parts[part].name.clone();
            let instances = name.as_ref().and_then(|name| shared.get(name));
            let is_shared = instances.is_some_and(|instances| instances.len() > 1);
            model.push_body(instance, &parts[part], &rigid, name.filter(|_| is_shared))?;
        }
        Ok(model)
    }

    fn new() -> Self {
        Self { parts: FileParts::new(&INP), bodies: Vec::new() }
    }

    /// Adds a part or an instance with its content.
    fn push_body(
        &mut self,
        section: &Section<'_>,
        content: &InpContent,
        rigid: &RigidElements,
        shared_part: Option<String>,
    ) -> Result<(), ReadError> {
        let first = self.node_count();
        self.push_nodes(content, section.placement.clone(), shared_part)?;
        let name = section.name.as_deref().unwrap_or_default();
        let nodes = first..self.node_count();
        let mut part = content.parts[0].with_nodes(name, nodes);
        part.set_rigid(content.is_rigid(0, rigid));
        self.parts.push(part);
        Ok(())
    }

    fn push_nodes(
        &mut self,
        content: &InpContent,
        placement: Option<Placement>,
        shared_part: Option<String>,
    ) -> Result<(), ReadError> {
        let end = self.parts.nodes.append(&content.nodes, placement.as_ref())?.end;
        self.bodies.push(BodyNodes { end, placement, shared_part });
        Ok(())
    }

    /// Returns the number of nodes of all bodies.
    pub(crate) fn node_count(&self) -> usize {
        self.parts.nodes.places.len()
    }

    /// Returns the nodes of each part by its name, whatever its elements are.
    pub(crate) fn nodes_by_part(&self) -> BTreeMap<String, PartNodes> {
        self.parts.nodes_by_part()
    }

    /// Returns names as the file spells them, those that it has not as they are.
    fn spelled(&self, names: &[String]) -> Vec<String> {
        let own = self.parts.all_names();
        let spelled = |name: &String| own.clone().find(|own| own.eq_ignore_ascii_case(name));
        names.iter().map(|name| spelled(name).unwrap_or(name).to_owned()).collect()
    }

    /// Writes the file again with some nodes elsewhere in the assembly, by their indices.
    pub(crate) fn move_nodes(
        &self,
        file: &[u8],
        moves: impl Iterator<Item = (u32, DVec3)>,
    ) -> Result<Vec<u8>, ReadError> {
        let precision = Precision::TwentyCharacters;
        let nodes = &self.parts.nodes;
        let mut moved = Vec::new();
        for (node, x) in moves {
            let node = node as usize;
            check_range(precision, &[x], node)?;
            let (Some(places), Some(&start)) =
                (nodes.places.get(node), nodes.numbered.positions.get(node))
            else {
                let (expected, found) = (self.node_count(), node + 1);
                return Err(ReadError::PositionCount { expected, found });
            };
            if x == start {
                continue;
            }
            let body = &self.bodies[self.bodies.partition_point(|body| body.end <= node)];
            if let Some(part) = &body.shared_part {
                return Err(ReadError::SharedPart { part: part.clone() });
            }
            let stored = body.placement.as_ref().map_or(x, |placement| placement.undo(x));
            check_range(precision, &[stored], node)?;
            moved.push((places, stored));
        }

        // Instances may be in another order than the parts that have their coordinates.
        moved.sort_by_key(|(places, _)| places.bytes[0].start);
        let mut copy = Copy::new(file);
        for (places, x) in moved {
            copy.put_position(places, x, precision);
        }
        Ok(copy.finish())
    }
}

impl InpContent {
    /// Returns the part of content that is not sorted by sets.
    fn only_part(&mut self) -> &mut Part {
        &mut self.parts[0]
    }
}

/// Reads the nodes of some lines, and their parts: each of its solids, or else of its surface elements.
fn read_parts(lines: &Lines<'_>, sorting: Sorting) -> Result<InpContent, ReadError> {
    let read = |elements| parse_content(InpLines::new(lines.clone()), elements, sorting);
    let mut content = read(MeshElements::Cells)?;
    let may_be_surface = |part: &Part| part.cells.is_empty() && !part.skipped.counts.is_empty();
    if !content.parts.iter().any(may_be_surface) {
        return Ok(content);
    }
    let surfaces = read(MeshElements::Polygons)?;
    let is_surface = |list: &ElementList| content.parts[list.part].cells.is_empty();
    content.lists.extend(surfaces.lists.into_iter().filter(is_surface));
    for (part, surface) in content.parts.iter_mut().zip(surfaces.parts) {
        if part.cells.is_empty() {
            *part = surface;
        }
    }
    Ok(content)
}

/// Refuses what stands outside of all parts and instances, and would be lost.
fn check_outside(outline: &Outline<'_>) -> Result<(), ReadError> {
    let lines = outline.outside.iter().cloned().flat_map(InpLines::new);
    let content = parse_content(lines, MeshElements::Cells, Sorting::Wanted)?;
    if content.nodes.places.is_empty() {
        return Ok(());
    }
    Err(INP.unsupported("nodes outside of its parts"))
}
