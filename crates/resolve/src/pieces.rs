//! Pieces of bodies: parts of a surface that have no vertex in common, as the cartilages of both bones of a joint that are one
//! body. Each piece of a pair's body comes apart from each of the other one's as bodies do.

use std::collections::BTreeMap;

use glam::DVec3;
use surface::{TriangleSurface, UnionFind};

/// Largest number of pieces of a body that are told apart. Below, assemblies count as one piece; above, crumbs take
/// time and memory.
const MAX_PIECES: usize = 64;

/// Returns the number of the piece of each vertex at `x`, |V|; empty for bodies of one, or of too many. One within the bounds of
/// another, as the wall of a cavity, is of that one.
pub(crate) fn pieces(surface: &TriangleSurface, x: &[DVec3]) -> Vec<u32> {
    let mut sets = UnionFind::new(x.len());
    for &[p, q] in surface.edges() {
        sets.join(p, q);
    }
    let mut bounds: BTreeMap<u32, [DVec3; 2]> = BTreeMap::new();
    for face in surface.faces() {
        for &corner in face {
            let x = x[corner as usize];
            let [low, high] = bounds.entry(sets.find(corner)).or_insert([x, x]);
            (*low, *high) = (low.min(x), high.max(x));
        }
    }
    if bounds.len() < 2 || bounds.len() > MAX_PIECES {
        return Vec::new();
    }

    for (piece, [low, high]) in &bounds {
        for (outer, [outer_low, outer_high]) in &bounds {
            if low.cmpge(*outer_low).all() && high.cmple(*outer_high).all() {
                sets.join(*piece, *outer);
            }
        }
    }
    let pieces: Vec<u32> = (0..).take(x.len()).map(|vertex| sets.find(vertex)).collect();
    let is_one = surface.faces().iter().all(|[corner, ..]| {
        let first = surface.faces()[0][0];
        pieces[*corner as usize] == pieces[first as usize]
    });
    if is_one { Vec::new() } else { pieces }
}

#[cfg(test)]
mod tests {
    use fixtures::{Mesh, shapes};
    use scene::{BodyKind, Scene};
    use surface::progress::Progress;

    use super::*;
    use crate::ResolveParams;

    /// Joins meshes to one.
    fn together(meshes: &[Mesh]) -> Mesh {
        let mut all = Mesh { positions: Vec::new(), faces: Vec::new() };
        for mesh in meshes {
            let first = u32::try_from(all.positions.len()).expect("few vertices");
            all.positions.extend(&mesh.positions);
            all.faces.extend(mesh.faces.iter().map(|face| face.map(|corner| first + corner)));
        }
        all
    }

    #[test]
    fn pieces_are_told_apart_and_walls_of_cavities_are_of_what_is_around_them() {
        let [outer, cavity, beside] = [(2.0, 0.0), (1.0, 0.2), (1.0, 2.0)]
            .map(|(size, x)| shapes::cube(size).translated(x * DVec3::X));
        for (meshes, count) in [
            (vec![outer.clone()], 0),
            (vec![outer.clone(), cavity.clone()], 0),
            (vec![outer.clone(), beside.clone()], 2),
            (vec![outer, cavity, beside], 2),
        ] {
            let mesh = together(&meshes);
            let mut found = pieces(&mesh.surface(), &mesh.positions);
            assert!(found.is_empty() || found.len() == mesh.positions.len());
            found.sort_unstable();
            found.dedup();
            assert_eq!(found.len(), count, "of {} meshes", meshes.len());
        }
    }

    /// A soft lens between two soft plates of one body, deep in both.
    #[test]
    fn what_is_in_two_pieces_of_a_body_comes_out_of_either_as_out_of_two_bodies() {
        // Curved as a femur and a tibia with a meniscus between them.
        let layer = |size: f64, cells: u32, heights: [(f64, f64); 2]| {
            let layer = shapes::plate(DVec3::new(size, size, 2.0), [cells, cells]);
            layer.mapped(|x| {
                let (height, bend) = heights[usize::from(x.z > 0.0)];
                DVec3::new(x.x, x.y, height + bend * x.truncate().length_squared())
            })
        };
        let above = layer(24.0, 14, [(0.1, 1.0 / 48.0), (2.1, 1.0 / 48.0)]);
        let below = layer(24.0, 14, [(-2.1, 1.0 / 120.0), (-0.1, 1.0 / 120.0)]);
        let lens = layer(14.0, 7, [(-0.5, 1.0 / 120.0), (0.5, 1.0 / 48.0)]);
        let one = together(&[above.clone(), below.clone()]);
        for plates in [vec![("above", above), ("below", below)], vec![("plates", one)]] {
            let mut scene = Scene::new();
            for (name, mesh) in plates.into_iter().chain([("lens", lens.clone())]) {
                let added = scene.add(name, BodyKind::Deformable, mesh.surface(), mesh.positions);
                added.expect("a body");
            }
            let params = ResolveParams { gap: 0.05, ..ResolveParams::for_overlaps(0.4, 1.7) };
            let end = crate::resolve(&mut scene, &params, Progress::none()).expect("an end");
            assert!(end.resolved, "{:?}", end.rounds);
            let most = end.bodies.iter().map(|body| body.max_displacement).fold(0.0, f64::max);
            assert!(most < 0.7, "{most}");
        }
    }
}
