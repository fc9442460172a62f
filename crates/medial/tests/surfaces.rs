//! Medial surfaces as such: validation, bounds, text, and sheets given as
//! simplex surfaces.

use glam::DVec3;
use kdop::{Leaves, Tree, Workspace};
use medial::{
    Ball, MedialContactParams, MedialError, MedialSurface, ParticleOffsets, PrimitiveTree,
    QueryPoints, point_contacts, primitive_contacts,
};
use surface::SimplexSurface;

fn balls(count: u32) -> Vec<Ball> {
    (0..count).map(|k| Ball::new(DVec3::X * f64::from(k), 0.5 + 0.1 * f64::from(k))).collect()
}

#[test]
fn refuses_what_is_no_medial_surface() {
    assert_eq!(MedialSurface::new(vec![], vec![], vec![]), Err(MedialError::Empty));
    let out = MedialError::BallOutOfRange { what: "slab", index: 1, ball: 9, balls: 4 };
    assert_eq!(MedialSurface::new(balls(4), vec![], vec![[0, 1, 2], [0, 9, 1]]), Err(out));
    let twice = MedialError::RepeatedBall { what: "cone", index: 0, ball: 2 };
    assert_eq!(MedialSurface::new(balls(4), vec![[2, 2]], vec![]), Err(twice));
    for radius in [-1e-9, f64::NAN, f64::INFINITY] {
        let mut bad = balls(3);
        bad[1].radius = radius;
        let error = MedialSurface::new(bad, vec![], vec![]).unwrap_err();
        assert!(matches!(error, MedialError::NotABall { ball: 1, .. }), "{error}");
    }
    let mut medial = MedialSurface::new(balls(3), vec![], vec![[0, 1, 2]]).unwrap();
    let before = medial.clone();
    let error = medial.set_centers(&[DVec3::ZERO, DVec3::NAN, DVec3::X]).unwrap_err();
    assert!(matches!(error, MedialError::NotABall { ball: 1, .. }), "{error}");
    assert_eq!(medial.set_centers(&[]), Err(MedialError::BallCount { expected: 3, got: 0 }));
    assert_eq!(medial, before, "a refusal changes nothing");
}

#[test]
fn bounds_hold_every_ball() {
    let medial = MedialSurface::new(balls(5), vec![[3, 4]], vec![[0, 1, 2]]).unwrap();
    let [low, high] = medial.bounds();
    for ball in medial.balls() {
        assert!((ball.center - ball.radius).cmpge(low).all(), "{ball:?}");
        assert!((ball.center + ball.radius).cmple(high).all(), "{ball:?}");
    }
    assert!((high.x - 4.9).abs() < 1e-15);
}

#[test]
fn text_comes_back_to_the_bit() {
    arbtest::arbtest(|u| {
        let count = u.int_in_range(1..=12_u32)?;
        let mut list = Vec::new();
        for _ in 0..count {
            let [x, y, z, r]: [f32; 4] = u.arbitrary()?;
            let finite = |v: f32| if v.is_finite() { f64::from(v) / 3.0 } else { 0.1 };
            let center = DVec3::new(finite(x), finite(y), finite(z));
            list.push(Ball::new(center, finite(r).abs()));
        }
        let mut index = || u.int_in_range(0..=count - 1);
        let (mut cones, mut slabs) = (Vec::new(), Vec::new());
        for _ in 0..4 {
            let [a, b, c] = [index()?, index()?, index()?];
            if a != b && b != c && c != a {
                slabs.push([a, b, c]);
            }
        }
        for _ in 0..4 {
            let [a, b] = [index()?, index()?];
            let side = slabs.iter().any(|slab| slab.contains(&a) && slab.contains(&b));
            if a < b && !side && !cones.contains(&[a, b]) {
                cones.push([a, b]);
            }
        }
        cones.sort_unstable();
        let medial = MedialSurface::new(list, cones, slabs).unwrap();
        assert_eq!(MedialSurface::from_ma(&medial.to_ma()).as_ref(), Ok(&medial));
        Ok(())
    });
}

#[test]
fn text_at_fault_is_told_by_its_line() {
    let cases = [
        ("", 1, "the text is empty"),
        ("1 0\n", 1, "a number is missing"),
        ("1 0 0\nv 0 0 0\n", 2, "a number is missing"),
        ("1 0 0\nv 0 0 0 1 7\n", 2, "there are more numbers than expected"),
        ("1 0 0\n\n# a comment\nw 0 0 0 1\n", 4, "expected a line of v, e or f"),
        ("2 1 0\nv 0 0 0 1\nv 1 0 0 1\ne 0 x\n", 4, "a word is not a number of its kind"),
        ("2 0 0\nv 0 0 0 1\n", 2, "the count of vertices is not that of the first line"),
    ];
    for (text, line, reason) in cases {
        let expected = MedialError::Text { line, reason };
        assert_eq!(MedialSurface::from_ma(text), Err(expected), "{text:?}");
    }
    let nan = MedialSurface::from_ma("1 0 0\nv 0 NaN 0 1\n").unwrap_err();
    assert!(matches!(nan, MedialError::NotABall { ball: 0, .. }), "{nan}");
}

/// A hexagon and its ring of half cells, as a sheet of radius growing along x.
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

/// A medial surface carried by a simplex sheet is detected like any other: against
/// points, against another one, after the sheet has moved; and what acts on it goes to
/// the sheet's vertices.
#[test]
fn a_simplex_sheet_goes_through_everything() {
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
    let probes = QueryPoints { tree: &tree, points: &points, radii: None };
    let particles = ParticleOffsets { first_point: 0, first_ball: 2 };
    let workspace = &mut Workspace::default();
    let reach = MedialContactParams::new(0.0);
    let (found, _) = point_contacts(&probes, &shell, &on, &reach, particles, None, workspace);
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
    let of_bar = PrimitiveTree::new(&bar).unwrap();
    let (met, _) = primitive_contacts((&bar, &of_bar), (&shell, &on), 0.0, workspace);
    let least = met.iter().map(|contact| contact.gap).fold(f64::INFINITY, f64::min);
    assert!((least + 3.0).abs() < 1e-9, "the bar's axis pierces the sheet: {least}");
    assert_eq!(MedialSurface::from_ma(&shell.to_ma()).as_ref(), Ok(&shell));
}
