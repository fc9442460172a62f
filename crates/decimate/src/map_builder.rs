//! Construction of a map from a surface onto a coarser one.

use surface::closest_on_triangle;
use surface::progress::{Interrupted, Progress};

use crate::coarse_map::CoarseMap;
use crate::edge_images::EdgeImages;
use crate::edge_path::Crossing;
use crate::mesh_point::MeshPoint;
use crate::surfaces::{Coarse, Full};
use crate::vertex_images::VertexImages;

/// Faces between two polls for interruption: about a millisecond.
const POLL_INTERVAL: usize = 1024;

/// Map under construction.
///
/// Its nodes are the vertices of the full surface, then points inside edges and faces.
pub(crate) struct MapBuilder<'a> {
    full: Full<'a>,
    coarse: Coarse<'a>,
    /// Distance that no point may be shifted by.
    limit: f64,
    /// Per node, its image in numbers of the coarse surface.
    images: Vec<MeshPoint>,
    map: CoarseMap,
    /// Per edge of the full surface, its first node; nodes are in the order of its ends.
    edge_nodes: Vec<usize>,
    /// Per coarse face, how often images cover it.
    covered: Vec<f64>,
    /// Vertices where the map fails.
    failed: Vec<u32>,
}

/// Map, or the vertices of the full surface where there is none within the limit.
pub(crate) enum Mapped {
    Whole(CoarseMap),
    Failed(Vec<u32>),
}

impl<'a> MapBuilder<'a> {
    /// Builds the map of a surface. Fails where some point would be shifted by more than the limit,
    /// or where it is not certain that all of the coarse surface is covered once.
    pub(crate) fn build(
        full: Full<'a>,
        coarse: Coarse<'a>,
        limit: f64,
        progress: Progress<'_>,
    ) -> Result<Mapped, Interrupted> {
        let mut vertices = VertexImages::find(full, coarse, limit, progress.part(0.0, 0.4))?;

        // Vertices are the first nodes, points inside edges the next.
        let part = progress.part(0.4, 0.8);
        let edges = EdgeImages::find(full, coarse, &mut vertices, limit, part)?;
        let covered = vec![0.0; coarse.surface.faces().len()];
        let (map, edge_nodes) = (CoarseMap::default(), Vec::new());
        let (images, failed) = (vertices.images, vertices.too_far);
        let mut builder = Self { full, coarse, limit, images, map, edge_nodes, covered, failed };
        builder.add_edge_nodes(&edges);

        // Faces between them can mostly be cut as they must.
        builder.map_faces(progress.part(0.8, 1.0))?;
        if builder.failed.is_empty() {
            builder.check_cover();
        }
        Ok(if builder.failed.is_empty() {
            Mapped::Whole(builder.finish())
        } else {
            Mapped::Failed(builder.failed)
        })
    }

    /// Adds the nodes inside edges.
    fn add_edge_nodes(&mut self, edges: &EdgeImages) {
        for (number, &ends) in self.full.surface.edges().iter().enumerate() {
            self.edge_nodes.push(self.images.len());
            for &Crossing { s, image } in edges.crossings(number) {
                self.add_node(MeshPoint::on_edge(ends, s), image);
            }
        }
        self.edge_nodes.push(self.images.len());
    }

    /// Adds a node at a point of the full surface.
    fn add_node(&mut self, point: MeshPoint, image: MeshPoint) {
        self.map.add_point(&point, &image);
        self.images.push(image);
    }

    /// Cuts faces into triangles whose images lie in one coarse face.
    fn map_faces(&mut self, progress: Progress<'_>) -> Result<(), Interrupted> {
        let count = self.full.surface.faces().len();
        let steps = progress.steps(count);
        let mut polygon = Vec::new();
        for face in 0..count {
            if face.is_multiple_of(POLL_INTERVAL) {
                steps.advance(POLL_INTERVAL)?;
            }
            self.write_polygon(face, &mut polygon);
            if !self.cut_ears(&mut polygon) && !self.cut_fan(face, &polygon) {
                self.failed.extend(self.full.surface.faces()[face]);
            }
        }
        Ok(())
    }

    /// Writes the nodes around a face.
    fn write_polygon(&self, face: usize, polygon: &mut Vec<usize>) {
        let surface = self.full.surface;
        polygon.clear();
        for (corner, edge) in surface.faces()[face].into_iter().zip(surface.face_edges()[face]) {
            polygon.push(corner as usize);

            // Both faces at the edge have the same nodes, in opposite directions.
            let edge = edge as usize;
            let nodes = self.edge_nodes[edge]..self.edge_nodes[edge + 1];
            if surface.edges()[edge][0] == corner {
                polygon.extend(nodes);
            } else {
                polygon.extend(nodes.rev());
            }
        }
    }

    /// Cuts a polygon into triangles, one corner after the other. Returns false, and leaves the
    /// rest, where no corner can be cut off.
    fn cut_ears(&mut self, polygon: &mut Vec<usize>) -> bool {
        while polygon.len() > 2 {
            let count = polygon.len();
            let ear = (0..count).find(|&i| {
                let [before, after] = [(i + count - 1) % count, (i + 1) % count];
                self.cover([polygon[before], polygon[i], polygon[after]])
            });

            // The new side is mapped to the straight line between its ends, for both parts.
            let Some(ear) = ear else { return false };
            polygon.remove(ear);
        }
        true
    }

    /// Cuts a polygon of a face into triangles around a new node, which is mapped to a coarse
    /// vertex. Returns false where none is near, or in the faces of all sides.
    fn cut_fan(&mut self, face: usize, polygon: &[usize]) -> bool {
        let Full { surface, x, kept, .. } = self.full;
        let corners = surface.faces()[face];
        let next = |i: usize| polygon[(i + 1) % polygon.len()];

        // The nearest vertex that has a common face with every side.
        let (mut best, mut min_distance) = (None, self.limit);
        for &vertex in polygon.iter().flat_map(|&node| self.images[node].carrier()) {
            let p = x[kept[vertex as usize] as usize];
            let foot = closest_on_triangle(p, corners.map(|v| x[v as usize]));
            let distance = foot.point.distance(p);
            let is_apex = (0..polygon.len()).all(|i| {
                let side = [polygon[i], next(i)].map(|node| self.images[node]);
                self.coarse.common_face(&[side[0], side[1], MeshPoint::vertex(vertex)]).is_some()
            });
            if distance <= min_distance && is_apex {
                min_distance = distance;
                best = Some((vertex, MeshPoint::on_face(corners, foot.barycentric)));
            }
        }

        // One triangle per side.
        let Some((vertex, point)) = best else { return false };
        let node = self.images.len();
        self.add_node(point, MeshPoint::vertex(vertex));
        (0..polygon.len()).all(|i| self.cover([polygon[i], next(i), node]))
    }

    /// Adds the image of a triangle to what is covered. Returns false where it is not in one
    /// coarse face.
    fn cover(&mut self, nodes: [usize; 3]) -> bool {
        let images = nodes.map(|node| self.images[node]);
        let Some(face) = self.coarse.common_face(&images) else { return false };
        self.covered[face as usize] += self.coarse.area_share(face, &images);
        true
    }

    /// Checks that the images cover what the coarse faces cover themselves.
    ///
    /// Both are whole numbers in every face, so that rounding does not matter.
    fn check_cover(&mut self) {
        for &corners in self.coarse.surface.faces() {
            let images = corners.map(MeshPoint::vertex);
            if let Some(face) = self.coarse.common_face(&images) {
                self.covered[face as usize] -= self.coarse.area_share(face, &images);
            }
        }

        for (corners, rest) in self.coarse.surface.faces().iter().zip(&self.covered) {
            if rest.is_nan() || rest.abs() >= 0.5 {
                self.failed.extend(corners.map(|vertex| self.full.kept[vertex as usize]));
            }
        }
    }

    /// Returns the map, with the images of the vertices that were not kept.
    fn finish(self) -> CoarseMap {
        let (full, mut map) = (self.full, self.map);
        for (vertex, image) in (0..).zip(&self.images[..full.x.len()]) {
            if full.is_moved(vertex) {
                map.add_vertex(vertex, image);
            }
        }
        map
    }
}

#[cfg(test)]
mod tests {
    use fixtures::{Mesh, shapes};
    use glam::DVec3;

    use super::*;

    /// Maps a surface with all vertices of a coarse one among its own, from any of those on the same
    /// side of a plane, and returns the largest shift.
    fn map(full: &Mesh, coarse: &Mesh) -> Option<f64> {
        let joined = Mesh { faces: full.faces.clone(), ..full.clone().joined(coarse) };
        let [start, end] = [full, &joined].map(|mesh| u32::try_from(mesh.positions.len()).unwrap());
        let kept: Vec<u32> = (start..end).collect();
        let side = |vertex: u32| joined.positions[vertex as usize].x > 30.0;
        let on_side = |vertex: u32| (start..end).find(|&kept| side(kept) == side(vertex));
        let into = |vertex: u32| if vertex < start { on_side(vertex).unwrap() } else { vertex };
        let moved_into: Vec<u32> = (0..end).map(into).collect();

        let [surface, coarse_surface] = [&joined, coarse].map(Mesh::surface);
        let x = &joined.positions;
        let full = Full { surface: &surface, x, kept: &kept, moved_into: &moved_into };
        let coarse = Coarse { surface: &coarse_surface, x: &coarse.positions };
        match MapBuilder::build(full, coarse, 5.0, Progress::none()).expect("no interruption") {
            Mapped::Whole(map) => Some(map.max_shift(x, coarse.x)),
            Mapped::Failed(_) => None,
        }
    }

    #[test]
    fn surfaces_around_the_same_body_are_mapped() {
        let full = shapes::icosphere(10.0, 3).rotated(DVec3::new(1.0, 2.0, 3.0), 0.1);
        let shift = map(&full, &shapes::icosphere(9.0, 1)).expect("a map");
        assert!((1.0..5.0).contains(&shift), "{shift}");
    }

    /// All points have images nearby, but these cover the coarse surface not once in all.
    #[test]
    fn surfaces_that_enclose_something_else_are_not_mapped() {
        let coarse = shapes::icosphere(9.0, 1);
        let beside = shapes::icosphere(2.0, 2).translated(coarse.positions[0]);
        assert!(map(&beside, &coarse).is_none());
        assert!(map(&shapes::icosphere(10.0, 3).flipped(), &coarse).is_none());
    }

    /// One of two bodies is mapped, the other encloses something else.
    #[test]
    fn each_component_is_to_be_covered() {
        let (full, coarse) = (shapes::icosphere(10.0, 3), shapes::icosphere(9.0, 1));
        let apart = |mesh: &Mesh| mesh.clone().translated(DVec3::X * 60.0);
        let both = coarse.clone().joined(&apart(&coarse));
        assert!(map(&full.clone().joined(&apart(&full)), &both).is_some());
        let beside = shapes::icosphere(2.0, 2).translated(coarse.positions[0]);
        assert!(map(&full.clone().joined(&apart(&beside)), &both).is_none());
        assert!(map(&beside.joined(&apart(&full)), &both).is_none());
    }
}
