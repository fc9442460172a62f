//! Triangle meshes from polygon lists, with every index and position checked.
//!
//! Polygons are fanned about the first corner from which no triangle of the fan is
//! turned against the polygon. A convex polygon is fanned about its first corner. A
//! polygon without such a corner is refused, since any fan of it would fold over.

use std::collections::BTreeMap;
use std::fmt;

use glam::DVec3;
use surface::triangle;
use volume_mesh::{Cell, MiddleNode, VolumeError, VolumeMesh};

use crate::solid::NumberedCells;
use crate::volume::{NumberedNodes, Volume};
use crate::{FilePlace, ReadError, SkippedElements, Space};

/// Maximum distance of a node from the middle of its edge \[edge lengths\]. Below, edges that files have
/// with four digits are curved; above, surfaces of quadratic elements may be farther from those of their
/// corners.
const MAX_CURVATURE: f64 = 1e-3;

/// Rounding of a node and of the middle of its edge in a file in single precision \[coordinates\].
const SINGLE_ROUNDING: f64 = 4.0 * f32::EPSILON as f64;

/// Triangle mesh of a file: every index is below the number of vertices, every
/// coordinate is finite, and there is at least one face.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    /// |V| positions, in the unit of the file.
    pub positions: Vec<DVec3>,
    /// Corners of the faces, |F| × 3, in the order of the file.
    pub faces: Vec<[u32; 3]>,
    /// Number of faces in the file with more than three corners.
    pub polygons_fanned: usize,
    /// Number of objects of an OBJ file that have faces, which are one mesh; 1 of other files.
    pub object_count: usize,
    /// Content of the file behind the end that its header declares.
    pub unread: Option<Unread>,
    /// Elements that are no part of the mesh: of an Abaqus file all others, of an MSH, VTU or VTK file
    /// those of surfaces at nodes of none of its cells.
    pub skipped: Option<SkippedElements>,
    /// Space of the positions, where the file states one.
    pub space: Option<Space>,
    /// Number of each vertex in the file, where vertices are nodes: those of an MSH, INP, FEB, VTU or VTK file; `None`
    /// where they are counted from 0.
    pub vertex_numbers: Option<Vec<u64>>,
    /// Index of each vertex among all nodes of the file, where the mesh is a part of it.
    pub nodes: Option<Vec<u32>>,
    /// Volume mesh whose boundary this is, of a file with tetrahedra, wedges or hexahedra.
    pub volume: Option<Volume>,
    /// True if it is rigid in the file: all parts of an FEBio model by their materials, all elements of an Abaqus file by
    /// their types or sets.
    pub is_rigid: bool,
}

/// Content of a file behind the end that its header declares, which is no part of the
/// mesh.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unread {
    /// Place of the first byte: a byte of a binary file, a line of a text file.
    pub place: FilePlace,
    /// Number of bytes.
    pub bytes: usize,
}

impl fmt::Display for Unread {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { place, bytes } = self;
        let noun = if *bytes == 1 { "byte" } else { "bytes" };
        write!(f, "{bytes} {noun} from {place} on, behind the declared end, not read")
    }
}

/// Unchecked polygons of a file, with any number of corners and any index.
#[derive(Debug, Default)]
pub(crate) struct Polygons {
    corners: Vec<i64>,
    ends: Vec<usize>,
}

impl Polygons {
    /// Returns no polygons, with memory for some triangles.
    pub(crate) fn with_capacity(triangles: usize) -> Self {
        Self { corners: Vec::with_capacity(3 * triangles), ends: Vec::with_capacity(triangles) }
    }

    /// Adds a polygon of nodes that are known.
    pub(crate) fn push_nodes(&mut self, nodes: &[u32]) {
        self.push(nodes.iter().copied().map(i64::from));
    }

    /// Returns the polygons with the first node of each quadrilateral in front: they are split as faces of solids are
    /// that have the same nodes.
    fn split_as_solids(&self) -> Self {
        let mut split = Self::default();
        for corners in self.iter() {
            let first = (0..corners.len()).min_by_key(|&place| corners[place]);
            let (before, from_first) =
                corners.split_at(first.filter(|_| corners.len() > 3).unwrap_or(0));
            split.push(from_first.iter().chain(before).copied());
        }
        split
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// Returns the corners of all polygons.
    pub(crate) fn corners(&self) -> impl Iterator<Item = i64> {
        self.corners.iter().copied()
    }

    /// Returns the corners of each polygon.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &[i64]> {
        let mut start = 0;
        self.ends.iter().map(move |&end| &self.corners[std::mem::replace(&mut start, end)..end])
    }

    /// Returns the number of polygons.
    pub(crate) fn len(&self) -> usize {
        self.ends.len()
    }

    /// Adds all polygons of others behind its own, with `shift` added to their corners.
    pub(crate) fn append(&mut self, others: &Self, shift: u32) {
        for corners in others.iter() {
            self.push(corners.iter().map(|&corner| corner + i64::from(shift)));
        }
    }

    /// Numbers the corners, all below `node_count`, anew by the nodes that are corners, in their order.
    /// Returns these nodes.
    pub(crate) fn renumber(&mut self, node_count: usize) -> Vec<u32> {
        let mut places = vec![None; node_count];
        let place_of = |corner: i64| usize::try_from(corner).unwrap_or(usize::MAX);
        for &corner in &self.corners {
            places[place_of(corner)] = Some(0);
        }

        let mut nodes = Vec::new();
        for (node, place) in (0..).zip(&mut places) {
            if place.is_some() {
                *place = i64::try_from(nodes.len()).ok();
                nodes.push(node);
            }
        }
        for corner in &mut self.corners {
            *corner = places[place_of(*corner)].unwrap_or(*corner);
        }
        nodes
    }

    /// Counts those with a corner that is a node of no cell, as elements of a type, or by their corners.
    pub(crate) fn count_apart(
        &self,
        is_of_cell: &[bool],
        kind: Option<&str>,
        skipped: &mut SkippedElements,
    ) {
        let is_apart = |corner: &i64| {
            let node = usize::try_from(*corner).ok();
            !node.and_then(|node| is_of_cell.get(node)).copied().unwrap_or_default()
        };
        for corners in self.iter().filter(|corners| corners.iter().any(is_apart)) {
            skipped.add(kind.unwrap_or(match corners.len() {
                3 => "triangle",
                4 => "quadrilateral",
                _ => "polygon",
            }));
        }
    }

    pub(crate) fn push(&mut self, corners: impl IntoIterator<Item = i64>) {
        self.corners.extend(corners);
        self.ends.push(self.corners.len());
    }
}

impl Mesh {
    /// Checks the content of a file and fans its polygons into triangles.
    pub(crate) fn assemble(positions: Vec<DVec3>, polygons: &Polygons) -> Result<Self, ReadError> {
        if polygons.is_empty() {
            return Err(ReadError::NoFaces { vertices: positions.len() });
        }
        check_positions(&positions)?;

        // Triangles stay as they are, larger polygons become fans, in the order of the file.
        let faces = Vec::with_capacity(polygons.ends.len());
        let mut mesh = Self::new(positions, faces);
        let mut corners = Vec::new();

        for (face, listed) in polygons.iter().enumerate() {
            if let Some(triangle) = as_triangle(listed, mesh.positions.len()) {
                mesh.faces.push(triangle);
                continue;
            }
            check_corners(face, listed, mesh.positions.len(), &mut corners)?;
            mesh.push_fan(face, &corners)?;
        }

        Ok(mesh)
    }

    /// Checks the nodes and elements of a file: its cells, and the surface around them, or else the
    /// surface that its polygons are, with all nodes as vertices. Polygons apart from cells are counted, and
    /// so are other elements of surfaces, by type.
    pub(crate) fn of_elements(
        nodes: NumberedNodes,
        cells: NumberedCells,
        polygons: &Polygons,
        others: &BTreeMap<String, Polygons>,
    ) -> Result<Self, ReadError> {
        if cells.is_empty() && !polygons.is_empty() {
            let mesh = Self::assemble(nodes.positions, &polygons.split_as_solids())?;
            return Ok(Self { vertex_numbers: Some(nodes.numbers), ..mesh });
        }
        let skipped = apart_from(&cells, polygons, others, nodes.positions.len());
        let mesh = Self::of_volume(nodes, cells)?;
        Ok(Self { skipped: skipped.if_any(), ..mesh })
    }

    fn of_volume(nodes: NumberedNodes, mut cells: NumberedCells) -> Result<Self, ReadError> {
        let NumberedNodes { positions: nodes, numbers: node_numbers } = nodes;
        check_positions(&nodes)?;
        cells.collapse();
        let refused = |error| by_number(error, &node_numbers, &cells.numbers);
        let mesh = VolumeMesh::new(nodes.len(), cells.cells).map_err(refused)?;
        let mesh = mesh.with_middle_nodes(cells.middle_nodes).map_err(refused)?;
        check_straight(&mesh, &nodes, &node_numbers)?;
        let boundary = mesh.boundary().map_err(refused)?;

        let (positions, faces) = (boundary.positions(&nodes), boundary.faces.clone());
        let numbers = boundary.nodes.iter().map(|&node| node_numbers[node as usize]).collect();
        let cell_numbers = cells.numbers;
        let volume = Volume { mesh, nodes, boundary, node_numbers, cell_numbers, first_node: 0 };
        let mesh = Self::new(positions, faces);
        Ok(Self { vertex_numbers: Some(numbers), volume: Some(volume), ..mesh })
    }

    /// Returns a mesh of a file of which nothing else is told.
    fn new(positions: Vec<DVec3>, faces: Vec<[u32; 3]>) -> Self {
        Self {
            positions,
            faces,
            polygons_fanned: 0,
            object_count: 1,
            unread: None,
            skipped: None,
            space: None,
            vertex_numbers: None,
            nodes: None,
            volume: None,
            is_rigid: false,
        }
    }

    fn push_fan(&mut self, face: usize, corners: &[u32]) -> Result<(), ReadError> {
        let mut apexes = 0..corners.len();
        let apex = apexes.find(|&apex| fans_without_fold(corners, apex, &self.positions));
        let Some(apex) = apex else {
            return Err(ReadError::NotFannable { face, corners: corners.len() });
        };
        self.faces.extend(fan(corners, apex));
        self.polygons_fanned += 1;
        Ok(())
    }
}

/// Counts polygons with a corner that is a node of none of the cells, and `others` by their types. Those
/// that remain are faces of cells, as a rule.
fn apart_from(
    cells: &NumberedCells,
    polygons: &Polygons,
    others: &BTreeMap<String, Polygons>,
    node_count: usize,
) -> SkippedElements {
    let mut is_of_cell = vec![false; node_count];
    let corners = cells.cells.iter().flat_map(Cell::nodes);
    for &node in corners.chain(cells.middle_nodes.iter().map(|middle| &middle.node)) {
        if let Some(is_of_cell) = is_of_cell.get_mut(node as usize) {
            *is_of_cell = true;
        }
    }

    let mut skipped = SkippedElements::default();
    polygons.count_apart(&is_of_cell, None, &mut skipped);
    for (kind, polygons) in others {
        polygons.count_apart(&is_of_cell, Some(kind), &mut skipped);
    }
    skipped
}

/// Returns the refusal of cells and nodes by their numbers in the file.
fn by_number(error: VolumeError, nodes: &[u64], cells: &[u64]) -> ReadError {
    let is_known = |node: u32| (node as usize) < nodes.len();
    let node_number = |node: u32| nodes[node as usize];
    match error {
        VolumeError::RepeatedNode { cell, node } => {
            ReadError::RepeatedNode { element: cells[cell], node: node_number(node) }
        }
        VolumeError::RepeatedCell { cells: both } => {
            ReadError::RepeatedElement { elements: both.map(|cell| cells[cell]) }
        }
        VolumeError::SharedFace { cells: three } => {
            ReadError::SharedFace { elements: three.map(|cell| cells[cell]) }
        }
        VolumeError::MiddleNode { node, ends: [a, b] }
            if [node, a, b].into_iter().all(is_known) =>
        {
            ReadError::MiddleNode { node: node_number(node), ends: [a, b].map(node_number) }
        }
        other => ReadError::Volume(other),
    }
}

/// Refuses quadratic elements whose edges are curved: what is around their corners would not be their
/// surface.
fn check_straight(
    mesh: &VolumeMesh,
    nodes: &[DVec3],
    node_numbers: &[u64],
) -> Result<(), ReadError> {
    for &MiddleNode { node, ends } in mesh.middle_nodes() {
        let [a, b] = ends.map(|end| nodes[end as usize]);
        let offset = nodes[node as usize].distance(a.midpoint(b));
        let (length, size) = (a.distance(b), a.abs().max(b.abs()).max_element());
        if offset > MAX_CURVATURE * length + SINGLE_ROUNDING * size {
            let [node, a, b] = [node, ends[0], ends[1]].map(|node| node_numbers[node as usize]);
            return Err(ReadError::CurvedEdge { node, ends: [a, b], offset, length });
        }
    }
    Ok(())
}

fn check_positions(positions: &[DVec3]) -> Result<(), ReadError> {
    if u32::try_from(positions.len()).is_err() {
        return Err(ReadError::TooManyVertices(positions.len()));
    }
    match positions.iter().position(|p| !p.is_finite()) {
        Some(vertex) => Err(ReadError::NotFinite { vertex, at: positions[vertex] }),
        None => Ok(()),
    }
}

/// Returns the corners of a triangle, unless one is out of range.
fn as_triangle(listed: &[i64], vertex_count: usize) -> Option<[u32; 3]> {
    let &[a, b, c] = listed else { return None };
    let corner = |vertex: i64| u32::try_from(vertex).ok().filter(|&v| (v as usize) < vertex_count);
    Some([corner(a)?, corner(b)?, corner(c)?])
}

/// Replaces the content of `corners` by the corners that the file lists.
fn check_corners(
    face: usize,
    listed: &[i64],
    vertex_count: usize,
    corners: &mut Vec<u32>,
) -> Result<(), ReadError> {
    if listed.len() < 3 {
        return Err(ReadError::TooFewCorners { face, corners: listed.len() });
    }

    // The buffer serves all faces, so that a large file takes no allocation per face.
    corners.clear();
    for &vertex in listed {
        match u32::try_from(vertex) {
            Ok(corner) if (corner as usize) < vertex_count => corners.push(corner),
            _ => return Err(ReadError::VertexOutOfRange { face, vertex, vertex_count }),
        }
    }
    Ok(())
}

/// Returns the triangles of a polygon's fan about its corner number `apex`.
fn fan(corners: &[u32], apex: usize) -> impl Iterator<Item = [u32; 3]> {
    let corner = move |k: usize| corners[(apex + k) % corners.len()];
    (1..corners.len() - 1).map(move |k| [corner(0), corner(k), corner(k + 1)])
}

/// Returns true if no triangle of the fan is turned against the polygon's area vector.
fn fans_without_fold(corners: &[u32], apex: usize, positions: &[DVec3]) -> bool {
    let mut normals = Vec::with_capacity(corners.len());
    for triangle in fan(corners, apex) {
        normals.push(triangle::normal(triangle.map(|vertex| positions[vertex as usize])));
    }

    // Twice the area vector of the polygon, whatever the apex.
    let whole: DVec3 = normals.iter().sum();
    normals.iter().all(|normal| normal.dot(whole) >= 0.0)
}
