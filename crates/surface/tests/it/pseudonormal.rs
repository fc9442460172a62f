//! Signs by pseudonormals against winding numbers, over spiky closed surfaces
//! and close to their edges and corners.

use arbitrary::{Result, Unstructured};
use fixtures::{generate, shapes};
use surface::glam::DVec3;
use surface::{
    ClosestOnTriangle, Positions, Pseudonormals, TriangleFeature, TriangleSurface,
    closest_on_triangle, winding_number,
};

use crate::support;

/// The closest point of a whole surface, and its face.
fn closest(surface: &TriangleSurface, x: Positions<'_>, p: DVec3) -> (u32, ClosestOnTriangle) {
    let feet = (0..).zip(surface.faces()).map(|(f, c)| (f, closest_on_triangle(p, x.corners(*c))));
    let distance = |foot: &ClosestOnTriangle| foot.point.distance_squared(p);
    feet.min_by(|(_, a), (_, b)| distance(a).total_cmp(&distance(b))).expect("a face")
}

/// A sphere with its vertices moved in and out: spikes, pits and saddles, but
/// no crossing.
fn spiky(u: &mut Unstructured<'_>) -> Result<(TriangleSurface, Vec<DVec3>)> {
    let mut sphere = shapes::octasphere(1.0, 1);
    for p in &mut sphere.positions {
        *p *= 0.3 + 1.4 * support::coordinate(u)?.abs();
    }
    Ok((sphere.surface(), sphere.positions))
}

/// A point anywhere, or near a vertex or an edge.
fn query(u: &mut Unstructured<'_>, surface: &TriangleSurface, x: &[DVec3]) -> Result<DVec3> {
    let [a, b] = u.choose(surface.edges())?.map(|k| x[k as usize]);
    let away = support::point(u)? * support::thinness(u, 6)?;
    Ok(match u.int_in_range(0..=2)? {
        0 => support::point(u)?,
        1 => a + away,
        _ => a.lerp(b, support::coordinate(u)?.abs()) + away,
    })
}

#[test]
fn sides_equal_those_of_the_winding_number() {
    let mut feet = [0; 3];
    let mut misled = 0;
    generate::cases(1, 5000, |u| {
        let (surface, x) = spiky(u)?;
        let p = query(u, &surface, &x)?;
        let x = surface.positions(&x).expect("finite");
        let normals = Pseudonormals::new(&surface, x);
        let (face, foot) = closest(&surface, x, p);
        let distance = normals.signed_distance(&surface, p, face, &foot);
        if distance.abs() < 1e-12 {
            return Ok(());
        }
        let winding = winding_number(&surface, x, p);
        assert_eq!(distance < 0.0, winding > 0.5, "{distance} {winding} at {p}: {foot:?}");
        feet[match foot.feature {
            TriangleFeature::Face => 0,
            TriangleFeature::Edge(_) => 1,
            TriangleFeature::Corner(_) => 2,
        }] += 1;
        let by_face = (p - foot.point).dot(normals.at(&surface, face, TriangleFeature::Face));
        misled += i32::from((by_face < 0.0) != (distance < 0.0));
        Ok(())
    });
    assert!(feet.iter().all(|count| *count > 100), "{feet:?}: too few of one kind");
    assert!(misled > 0, "no case in which the face's own normal is wrong");
}

#[test]
fn a_cube_has_diagonal_normals_however_it_is_cut() {
    // Each side in two triangles: vertices have from three to six faces.
    let at = |k: u32| DVec3::new(f64::from(k & 1), f64::from(k >> 1 & 1), f64::from(k >> 2 & 1));
    let x: Vec<DVec3> = (0..8).map(at).collect();
    let sides =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let faces = sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    let surface = TriangleSurface::new(8, faces).expect("valid");
    let normals = Pseudonormals::new(&surface, surface.positions(&x).expect("finite"));
    for (x, normal) in x.iter().zip(normals.vertices()) {
        let diagonal = (*x - DVec3::splat(0.5)).normalize();
        assert!(normal.distance(diagonal) < 1e-15, "{normal} for {diagonal}");
    }
    for (ends, normal) in surface.edges().iter().zip(normals.edges()) {
        let middle = x[ends[0] as usize].midpoint(x[ends[1] as usize]) - DVec3::splat(0.5);
        assert!(normal.distance(middle.normalize()) < 1e-15, "{normal} for {ends:?}");
    }
}

#[test]
fn faces_without_area_do_not_count() {
    let x = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::X * 0.5];
    let faces = vec![[0, 1, 2], [0, 3, 1], [1, 1, 2]];
    let surface = TriangleSurface::new(4, faces).expect("valid");
    let normals = Pseudonormals::new(&surface, surface.positions(&x).expect("finite"));
    assert_eq!(normals.faces(), [DVec3::Z, DVec3::ZERO, DVec3::ZERO]);
    assert_eq!(normals.vertices(), [DVec3::Z, DVec3::Z, DVec3::Z, DVec3::ZERO]);
    assert_eq!(normals.at(&surface, 2, TriangleFeature::Edge(0)), DVec3::ZERO);
    assert_eq!(normals.at(&surface, 1, TriangleFeature::Edge(2)), DVec3::Z);
}
