//! Medial surfaces that are given as simplex surfaces.

use glam::DVec3;
use kdop::{Leaves, Tree, Workspace};
use medial::{
    Ball, MedialBounds, MedialContactParams, MedialError, MedialSurface, ParticleOffsets,
    PrimitiveTree, QueryPoints, point_contacts, primitive_contacts,
};
use surface::SimplexSurface;

/// A spherical sheet of radii that grow along x.
#[test]
fn a_simplex_sheet_is_a_medial_surface() {
    let closed = fixtures::shapes::icosphere(20.0, 2);
    let dual = SimplexSurface::dual_of(&closed.surface()).unwrap();
    let surface = closed.surface();
    let x: Vec<DVec3> = surface
        .faces()
        .iter()
        .map(|face| face.iter().map(|&v| closed.positions[v as usize]).sum::<DVec3>() / 3.0)
        .collect();
    let radii: Vec<f64> = x.iter().map(|p| 2.0 + 0.01 * p.x).collect();
    let mut medial = MedialSurface::from_sheet(&dual, &x, &radii).unwrap();
    assert_eq!(medial.balls().len(), dual.vertex_count() + dual.polygon_count());
    assert_eq!(medial.slabs().len(), 3 * dual.vertex_count());
    // A shell: a point in the middle of the sphere is outside, one on it inside.
    let tree = PrimitiveTree::new(&medial).unwrap();
    let workspace = &mut Workspace::default();
    assert!(tree.nearest(&medial, DVec3::ZERO, workspace).foot.distance > 16.0);
    let on = tree.nearest(&medial, 19.7 * DVec3::Y, workspace).foot;
    assert!((-2.2..-1.5).contains(&on.distance), "{on:?}");
    let moved: Vec<DVec3> = x.iter().map(|p| *p + DVec3::X).collect();
    medial.set_sheet(&dual, &moved, &radii).unwrap();
    assert!((medial.balls()[0].center - x[0] - DVec3::X).length() < 1e-12);
    let error = MedialSurface::from_sheet(&dual, &x, &radii[1..]).unwrap_err();
    assert!(matches!(error, MedialError::BallCount { .. }), "{error}");
}

/// A medial surface carried by a simplex sheet is detected like any other: against points, against
/// another one, after the sheet has moved. Forces on it are distributed to the sheet's vertices.
#[test]
fn a_simplex_sheet_is_detected_after_it_has_moved() {
    let closed = fixtures::shapes::icosphere(20.0, 2);
    let sheet = SimplexSurface::dual_of(&closed.surface()).unwrap();
    let x: Vec<DVec3> = closed
        .faces
        .iter()
        .map(|face| face.iter().map(|&v| closed.positions[v as usize]).sum::<DVec3>() / 3.0)
        .collect();
    let radii = vec![2.0; x.len()];
    let mut shell = MedialSurface::from_sheet(&sheet, &x, &radii).unwrap();
    let mut on = PrimitiveTree::new(&shell).unwrap();
    let moved: Vec<DVec3> = x.iter().map(|p| *p + 100.0 * DVec3::Y).collect();
    shell.set_sheet(&sheet, &moved, &radii).unwrap();
    on.refit(&shell).unwrap();

    // A point 1 under the outside of the shell, and one in the hollow.
    let points = [DVec3::new(0.0, 100.0, 20.6), DVec3::new(0.0, 100.0, 0.0)];
    let tree = Tree::build(Leaves::Points, &points).unwrap();
    let query = QueryPoints { tree: &tree, points: &points, radii: None };
    let particles = ParticleOffsets { first_point: 0, first_ball: 2 };
    let workspace = &mut Workspace::default();
    let params = MedialContactParams::new(0.0);
    let on_shell = MedialBounds { medial: &shell, tree: &on };
    let (found, _) = point_contacts(&query, on_shell, &params, particles, workspace);
    assert!(found.iter().all(|contact| contact.stencil.terms()[0].particle == 0), "{found:?}");
    let deepest = found[0];
    assert!((-2.0..-0.5).contains(&deepest.gap) && deepest.normal.z > 0.98, "{deepest:?}");

    // The balls that carry it are the sheet's vertices and the middles of polygons.
    let mut on_vertices = vec![0.0; sheet.vertex_count()];
    for term in &deepest.stencil.terms()[1..] {
        let ball = term.particle as usize - 2;
        match ball.checked_sub(sheet.vertex_count()) {
            None => on_vertices[ball] += term.weight,
            Some(polygon) => {
                let vertices = sheet.polygon(u32::try_from(polygon).unwrap());
                let share = term.weight / f64::from(u32::try_from(vertices.len()).unwrap());
                vertices.iter().for_each(|&vertex| on_vertices[vertex as usize] += share);
            }
        }
    }
    assert!((on_vertices.iter().sum::<f64>() - 1.0).abs() < 1e-12);
    let foot: DVec3 = on_vertices.iter().zip(&moved).map(|(w, p)| *w * *p).sum();
    let center = points[0] - (deepest.gap + deepest.offset) * deepest.normal;
    assert!(foot.distance(center) < 1e-9, "{foot} is not {center}");

    // A bar through the shell, and its reading from text.
    let ends = [DVec3::new(0.0, 100.0, 15.0), DVec3::new(0.0, 100.0, 40.0)];
    let bar = MedialSurface::new(ends.map(|c| Ball::new(c, 1.0)).to_vec(), vec![[0, 1]], vec![]);
    let bar = bar.unwrap();
    let of_bar = MedialBounds { medial: &bar, tree: &PrimitiveTree::new(&bar).unwrap() };
    let (met, _) = primitive_contacts(of_bar, on_shell, 0.0, workspace);
    let least = met.iter().map(|contact| contact.gap).fold(f64::INFINITY, f64::min);
    assert!((least + 3.0).abs() < 1e-9, "the bar's axis pierces the sheet: {least}");
    assert_eq!(MedialSurface::from_ma(&shell.to_ma()).as_ref(), Ok(&shell));
}
