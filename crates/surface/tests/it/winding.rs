//! Inside and outside: rays through corners and edges against solid angles,
//! points on the surface, points within ulps of it.

use arbitrary::{Result, Unstructured};
use fixtures::generate::cases;
use surface::glam::DVec3;
use surface::{
    TriangleSurface, closest_on_segment, closest_on_triangle, ray_crosses_triangle,
    ray_crosses_triangle_from_below, winding_number,
};

use crate::support;

const OCTAHEDRON: [[u32; 3]; 8] =
    [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];

fn octahedron() -> TriangleSurface {
    TriangleSurface::new(6, OCTAHEDRON.to_vec()).expect("valid")
}

fn regular() -> [DVec3; 6] {
    [DVec3::X, -DVec3::X, DVec3::Y, -DVec3::Y, DVec3::Z, -DVec3::Z]
}

/// Direction in which a ray from a point crosses a triangle.
type Crosses = fn(DVec3, [DVec3; 3]) -> Option<i32>;

/// Sum of the signs of all passages, and whether their number is odd.
fn passages(surface: &TriangleSurface, x: &[DVec3], p: DVec3, crosses: Crosses) -> (i32, bool) {
    let x = surface.positions(x).expect("finite");
    let signs = || surface.faces().iter().filter_map(|f| crosses(p, x.corners(*f)));
    (signs().sum(), signs().count() % 2 == 1)
}

fn winding(surface: &TriangleSurface, x: &[DVec3], p: DVec3) -> f64 {
    winding_number(surface, surface.positions(x).expect("finite"), p)
}

fn grid_point(u: &mut Unstructured<'_>) -> Result<DVec3> {
    let mut x = || Ok(f64::from(u.int_in_range(-2_i8..=2)?));
    Ok(DVec3::new(x()?, x()?, x()?))
}

/// Corners on a small grid, so that rays meet corners and edges, faces lie along
/// the ray, and surfaces fold through themselves.
///
/// The point itself may be on the surface: on this grid, the move by which that
/// is decided is one by these amounts.
#[test]
fn passages_of_any_closed_surface_sum_to_its_winding_number() {
    let surface = octahedron();
    let mut on_surface = 0;
    cases(1, 5000, |u| {
        let x: Vec<DVec3> = (0..6).map(|_| grid_point(u)).collect::<Result<_>>()?;
        let p = grid_point(u)?;
        let moved = p + DVec3::new(2.0_f64.powi(-12), 2.0_f64.powi(-24), 2.0_f64.powi(-36));
        // Up, and down by as much.
        for (moved, crosses) in [
            (moved, ray_crosses_triangle as Crosses),
            (p - (moved - p), ray_crosses_triangle_from_below),
        ] {
            let expected = winding(&surface, &x, moved);
            let (sum, odd) = passages(&surface, &x, p, crosses);
            assert!((f64::from(sum) - expected).abs() < 1e-6, "{sum} {expected}: {x:?} from {p}");
            assert_eq!(odd, sum % 2 != 0);
        }
        let x = surface.positions(&x).expect("finite");
        let on = |f: &[u32; 3]| closest_on_triangle(p, x.corners(*f)).point == p;
        on_surface += i32::from(surface.faces().iter().any(on));
        Ok(())
    });
    assert!(on_surface > 300, "only {on_surface} points were on a surface");
}

/// Points one ulp to either side of a face, of any place and size.
#[test]
fn an_ulp_beside_a_face_decides_the_side() {
    let surface = octahedron();
    cases(21, 1000, |u| {
        let offset = DVec3::new(1.0, -0.7, 0.4) * *u.choose(&[0.0, 1.0, 1e3, 1e6])?;
        let x = regular().map(|x| offset + x);
        let face = u.choose(&OCTAHEDRON)?.map(|k| x[k as usize]);
        let share = |u: &mut Unstructured<'_>| Ok(f64::from(u.int_in_range(10..=90)?) / 100.0);
        let on = face[0].lerp(face[1].lerp(face[2], share(u)?), share(u)?);
        let outward = (on - offset).signum();
        let ulp = 4.0 * f64::EPSILON * on.abs().max(DVec3::ONE);
        for (p, inside) in [(on - outward * ulp, true), (on + outward * ulp, false)] {
            let (sum, odd) = passages(&surface, &x, p, ray_crosses_triangle);
            assert_eq!((sum, odd), (i32::from(inside), inside), "{p}");
            let winding = winding(&surface, &x, p);
            assert!((winding - f64::from(sum)).abs() < 1e-11, "{winding} at {p}");
        }
        Ok(())
    });
}

#[test]
fn winding_numbers_near_edges_keep_the_digits_that_they_promise() {
    let surface = octahedron();
    cases(22, 1000, |u| {
        let t = f64::from(u.int_in_range(0_u8..=100)?) / 100.0;
        let delta = support::thinness(u, 12)?;
        let p = DVec3::X.lerp(DVec3::Y, t) * (1.0 - delta)
            + DVec3::Z * delta * support::coordinate(u)? / 4.0;
        let nearest = surface.edges().iter().map(|ends| {
            let edge = ends.map(|k| regular()[k as usize]);
            closest_on_segment(p, edge).point.distance(p)
        });
        let nearest = nearest.fold(f64::INFINITY, f64::min);
        let winding = winding(&surface, &regular(), p);
        assert!((winding - 1.0).abs() <= 1e-14 / nearest, "{winding} at {p}, {nearest:e}");
        Ok(())
    });
}

#[test]
fn an_open_surface_covers_its_share() {
    let half = TriangleSurface::new(6, OCTAHEDRON[..4].to_vec()).expect("valid");
    assert!((winding(&half, &regular(), DVec3::ZERO) - 0.5).abs() < 1e-15);
    let on_face = regular()[0].midpoint(regular()[2]).midpoint(regular()[4]);
    assert!((winding(&octahedron(), &regular(), on_face) - 0.5).abs() < 1e-14);
}
