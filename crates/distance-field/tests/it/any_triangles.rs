//! Any triangles at all: distances in the band and signs everywhere, against
//! sums over all faces.

use arbitrary::{Result, Unstructured};
use distance_field::{DistanceField, FieldMethod, FieldParams, FieldWarning, NodeValues};
use fixtures::Mesh;
use fixtures::generate::cases;
use surface::glam::DVec3;
use surface::progress::Progress;
use surface::{TriangleSurface, closest_on_triangle, winding_number};

use crate::support::{INTERPOLATING, nodes};

/// A coordinate that is often on a node's, or on another's: that is where ties are.
fn coordinate(u: &mut Unstructured<'_>) -> Result<f64> {
    let tenths = u.int_in_range(0..=60_i32)?;
    Ok(if u.ratio(1, 2)? { f64::from(tenths / 10) } else { f64::from(tenths) / 10.0 })
}

/// A few triangles, each maybe repeated, turned over or sharing an edge.
fn triangles(u: &mut Unstructured<'_>) -> Result<Mesh> {
    let mut mesh = Mesh::default();
    for _ in 0..u.int_in_range(3..=8)? {
        let p = DVec3::new(coordinate(u)?, coordinate(u)?, coordinate(u)?);
        mesh.positions.push(p);
    }
    let last = u32::try_from(mesh.positions.len() - 1).unwrap_or(0);
    for _ in 0..u.int_in_range(1..=8)? {
        let mut corner = || u.int_in_range(0..=last);
        mesh.faces.push([corner()?, corner()?, corner()?]);
    }
    Ok(mesh)
}

fn exact(mesh: &Mesh, p: DVec3) -> f64 {
    let feet = (0..mesh.faces.len()).map(|face| closest_on_triangle(p, mesh.corners(face)).point);
    feet.map(|foot| foot.distance(p)).fold(f64::INFINITY, f64::min)
}

/// Values of all nodes within the band, and signs of all nodes; and that nodes which may
/// give way do so by little, and not to the other side.
/// Rounding of distances up to 20 to single precision.
const SINGLE: f64 = 2e-6;

/// Compares a field with sums over all faces, up to the `rounding` of a distance.
fn check(
    mesh: &Mesh,
    surface: &TriangleSurface,
    params: &FieldParams,
    rounding: impl Fn(f64) -> f64,
) {
    let FieldMethod::ExactBand { band, .. } = params.method else {
        unreachable!("the band is what is checked")
    };
    let x = surface.positions(&mesh.positions).expect("finite");
    let field = DistanceField::build(surface, x, params, Progress::none()).expect("small");
    let method = FieldMethod::ExactBand { band, node_values: NodeValues::QuasiInterpolating };
    let corrected = FieldParams { method, ..*params };
    let corrected = DistanceField::build(surface, x, &corrected, Progress::none()).expect("small");
    let inverted = field.report().warnings.contains(&FieldWarning::Inverted);
    for node in nodes(field.grid().dims()) {
        let p = field.grid().position(node);
        let (value, distance) = (field.node(node), exact(mesh, p));
        let coefficient = corrected.node(node);
        assert_eq!(coefficient < 0.0, value < 0.0, "{node:?} {value} {coefficient} {mesh:?}");
        let most = params.spacing / 8.0 + 1e-6;
        assert!((coefficient - value).abs() <= most, "{node:?} {value} {coefficient} {mesh:?}");
        let rounding = rounding(distance);
        if distance < band * params.spacing - 1e-5 {
            assert!(
                (value.abs() - distance).abs() < rounding,
                "{node:?} {value} {distance} {mesh:?}"
            );
        } else {
            // Beyond, it is the distance to some face: never too short.
            assert!(value.abs() > distance - rounding, "{node:?} {value} {distance} {mesh:?}");
        }
        let winding = winding_number(surface, x, p);
        let inside = if inverted { -winding > 0.5 } else { winding > 0.5 };
        let is_tie = distance < 1e-9 || (winding.abs() - 0.5).abs() < 1e-9;
        if !is_tie {
            assert_eq!(value < 0.0, inside, "{node:?} {winding} {mesh:?}");
        }
    }
}

#[test]
fn band_is_exact_and_signs_are_winding_numbers() {
    let params =
        FieldParams { method: INTERPOLATING, padding: 2.0, samples: 0, ..FieldParams::new(1.0) };
    cases(1, 400, |u| {
        let mesh = triangles(u)?;
        let spacing = if u.ratio(1, 2)? { 1.0 } else { 0.7 };
        let truncation = if u.ratio(1, 2)? { Some(15.0) } else { None };
        check(&mesh, &mesh.surface(), &FieldParams { spacing, truncation, ..params }, |_| SINGLE);
        Ok(())
    });
}

/// Faces as thin as rounding and thinner, some of them along rows and through nodes.
#[test]
fn thin_faces_are_exact_in_the_band() {
    let params =
        FieldParams { method: INTERPOLATING, padding: 2.0, samples: 0, ..FieldParams::new(1.0) };
    cases(2, 200, |u| {
        let mut mesh = Mesh::default();
        for _ in 0..u.int_in_range(1..=3)? {
            let mut corner = || Ok(DVec3::new(coordinate(u)?, coordinate(u)?, coordinate(u)?));
            let (a, b, aside) = (corner()?, corner()?, corner()?);
            let along = f64::from(u.int_in_range(-2..=12_i8)?) / 10.0;
            let width = 0.1_f64.powi(u.int_in_range(1..=18)?);
            let first = u32::try_from(mesh.positions.len()).expect("few corners");
            mesh.positions.extend([a, b, a.lerp(b, along) + width * aside]);
            let mut face = [first, first + 1, first + 2];
            face.rotate_left(u.choose_index(3)?);
            mesh.faces.push(face);
        }
        check(&mesh, &mesh.surface(), &params, |_| SINGLE);
        Ok(())
    });
}

/// Bands of many planes around triangles at the end of a tall grid: each task on some of the planes
/// has all faces that come near.
#[test]
fn wide_bands_are_exact_in_all_planes() {
    cases(3, 30, |u| {
        let mut mesh = triangles(u)?;
        mesh.positions.iter_mut().for_each(|p| p.z *= 0.2);
        let first = u32::try_from(mesh.positions.len()).expect("few corners");
        let top = DVec3::new(3.0, 3.0, 80.0);
        mesh.positions.extend([top, top + DVec3::X, top + DVec3::Y]);
        mesh.faces.push([first, first + 1, first + 2]);
        if u.ratio(1, 2)? {
            mesh.positions.iter_mut().for_each(|p| p.z = 80.0 - p.z);
        }
        let band = f64::from(u.int_in_range(4..=40_u8)?);
        let method = FieldMethod::ExactBand { band, node_values: NodeValues::Interpolating };
        let params = FieldParams { method, padding: 0.0, samples: 0, ..FieldParams::new(1.0) };
        // Single precision: of distances beyond 20 by their size.
        let rounding = |distance| f64::max(SINGLE, 1e-7 * distance);
        check(&mesh, &mesh.surface(), &FieldParams { truncation: None, ..params }, rounding);
        Ok(())
    });
}
