//! Point of a triangle surface as a weighted mean of vertices.

/// Point of a surface: a mean of up to three vertices with positive weights that sum to 1.
///
/// The vertices span its *carrier*, the smallest simplex of the surface that contains it: a
/// vertex, an edge or a face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MeshPoint {
    /// The vertices of the carrier first, then the first of them again with weight zero.
    vertices: [u32; 3],
    weights: [f64; 3],
    count: u32,
}

impl MeshPoint {
    /// Returns a point of a face by its barycentric coordinates, at least one of them positive.
    pub(crate) fn on_face(corners: [u32; 3], barycentric: [f64; 3]) -> Self {
        let mut point = Self { vertices: corners, weights: [0.0; 3], count: 0 };
        for (corner, weight) in corners.into_iter().zip(barycentric) {
            if weight > 0.0 {
                point.vertices[point.count as usize] = corner;
                point.weights[point.count as usize] = weight;
                point.count += 1;
            }
        }
        let first = point.vertices[0];
        point.vertices[point.count as usize..].fill(first);
        point
    }

    /// Returns the point of an edge at `t` in `0.0..=1.0` between its ends.
    pub(crate) fn on_edge([a, b]: [u32; 2], t: f64) -> Self {
        Self::on_face([a, b, a], [1.0 - t, t, 0.0])
    }

    pub(crate) fn vertex(vertex: u32) -> Self {
        Self { vertices: [vertex; 3], weights: [1.0, 0.0, 0.0], count: 1 }
    }

    /// Returns the vertices of the carrier.
    pub(crate) fn carrier(&self) -> &[u32] {
        &self.vertices[..self.count as usize]
    }

    /// Returns the vertex of the largest weight, the first of equals.
    pub(crate) fn main_vertex(&self) -> u32 {
        let [a, b, c] = self.weights;
        let [u, v, w] = self.vertices;
        match (a >= b && a >= c, b >= c) {
            (true, _) => u,
            (false, true) => v,
            (false, false) => w,
        }
    }

    /// Returns three vertices with their weights, which may be zero.
    pub(crate) fn terms(&self) -> [(u32, f64); 3] {
        [0, 1, 2].map(|k| (self.vertices[k], self.weights[k]))
    }

    /// Returns the weight of a vertex.
    pub(crate) fn weight(&self, vertex: u32) -> f64 {
        let number = self.carrier().iter().position(|&own| own == vertex);
        number.map_or(0.0, |number| self.weights[number])
    }
}
