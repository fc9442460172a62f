//! Simplex surfaces: the dual and back, what is refused, fans, and weights that
//! keep a combination.

use fixtures::generate::cases;
use fixtures::{data, shapes};
use surface::glam::DVec3;
use surface::{
    NO_NEIGHBOR, SimplexError, SimplexSurface, Stencil, SurfaceError, Term, TriangleSurface,
    closest_on_triangle, inspect,
};

use crate::support::{self, anatomy};

/// The face from its smallest corner on.
fn from_smallest([a, b, c]: [u32; 3]) -> [u32; 3] {
    if a < b && a < c {
        [a, b, c]
    } else if b < c {
        [b, c, a]
    } else {
        [c, a, b]
    }
}

fn assert_round_trip(surface: &TriangleSurface) -> SimplexSurface {
    let dual = SimplexSurface::dual_of(surface).expect("a closed manifold");
    let back = dual.dual().expect("no border");
    let faces: Vec<_> = surface.faces().iter().map(|face| from_smallest(*face)).collect();
    assert_eq!(back.faces(), faces, "the triangulation");
    assert_eq!(SimplexSurface::dual_of(&back).as_ref(), Ok(&dual), "the dual again");
    assert_neighbors(&dual);
    dual
}

/// Neighbors name each other, and each polygon runs between two of them.
fn assert_neighbors(dual: &SimplexSurface) {
    for (vertex, (around, within)) in (0..).zip(dual.neighbors().iter().zip(dual.vertex_polygons()))
    {
        for k in 0..3 {
            if around[k] == NO_NEIGHBOR {
                continue;
            }
            assert!(dual.neighbors()[around[k] as usize].contains(&vertex), "at {vertex}");
            if within[k] != NO_NEIGHBOR {
                let polygon = dual.polygon(within[k]);
                let at = polygon.iter().position(|v| *v == vertex).expect("a corner");
                let len = polygon.len();
                assert_eq!(polygon[(at + 1) % len], around[k], "at {vertex}");
                assert_eq!(polygon[(at + len - 1) % len], around[(k + 1) % 3], "at {vertex}");
            }
        }
    }
}

fn octasphere(splits: u32) -> (TriangleSurface, Vec<DVec3>) {
    let sphere = shapes::octasphere(1.0, splits);
    (sphere.surface(), sphere.positions)
}

/// The dual's vertices: barycenters of the faces, here on the unit sphere.
fn barycenters(surface: &TriangleSurface, x: &[DVec3]) -> Vec<DVec3> {
    let sum = |face: &[u32; 3]| face.iter().map(|k| x[*k as usize]).sum::<DVec3>();
    surface.faces().iter().map(|face| sum(face).normalize()).collect()
}

#[test]
fn spheres_survive_the_dual_and_back() {
    for splits in 0..=3 {
        let dual = assert_round_trip(&octasphere(splits).0);
        assert_eq!(dual.polygon_count(), dual.vertex_count() / 2 + 2);
    }
}

#[test]
fn real_meshes_survive_the_dual_and_back() {
    let Some(folder) = data::anatomy("real_meshes_survive_the_dual_and_back") else { return };
    for row in anatomy::rows(folder.join("meshes.csv")) {
        let surface = data::mesh(&folder.join(&row[0]).join(&row[1])).surface();
        if row[9] == "True" {
            assert_round_trip(&surface);
        } else {
            let refused = SimplexSurface::dual_of(&surface);
            assert!(matches!(refused, Err(SimplexError::Surface(_))), "{}", row[1]);
        }
    }
}

#[test]
fn patches_have_a_border() {
    // Three hexagons about vertex 0.
    let polygons = [vec![0, 1, 2, 3, 4, 5], vec![0, 5, 6, 7, 8, 9], vec![0, 9, 10, 11, 12, 1]];
    let patch = SimplexSurface::new(13, &polygons).unwrap();
    assert_neighbors(&patch);
    assert_eq!(patch.neighbors()[0], [1, 5, 9]);
    assert_eq!(patch.vertex_polygons()[0], [0, 1, 2]);
    assert_eq!(patch.neighbors()[1], [2, 0, 12]);
    assert_eq!(patch.vertex_polygons()[1], [0, 2, NO_NEIGHBOR]);
    assert_eq!(patch.neighbors()[3], [4, 2, NO_NEIGHBOR]);
    assert_eq!(patch.vertex_polygons()[3], [0, NO_NEIGHBOR, NO_NEIGHBOR]);
    assert_eq!(patch.dual(), Err(SimplexError::Border { vertex: 1, polygons: 2 }));
}

#[test]
fn what_is_no_simplex_surface_is_refused() {
    use SimplexError::{NotSimplex, ShortPolygon, VertexOutOfRange};
    let cases: [(usize, &[&[u32]], SimplexError); 9] = [
        (3, &[&[0, 1, 2], &[2, 1]], ShortPolygon { polygon: 1, len: 2 }),
        (3, &[&[0, 1, 3]], VertexOutOfRange { polygon: 0, vertex: 3, vertex_count: 3 }),
        (4, &[&[0, 1, 2]], NotSimplex { vertex: 3, polygons: 0 }),
        (5, &[&[0, 1, 2], &[0, 3, 4]], NotSimplex { vertex: 0, polygons: 2 }),
        (3, &[&[0, 1, 2], &[0, 2, 1]], NotSimplex { vertex: 0, polygons: 2 }),
        (5, &[&[0, 1, 2], &[0, 2, 3], &[0, 3, 4]], NotSimplex { vertex: 0, polygons: 3 }),
        (5, &[&[0, 2, 3], &[0, 1, 2], &[0, 3, 4]], NotSimplex { vertex: 0, polygons: 3 }),
        (3, &[&[0, 1, 2, 1]], NotSimplex { vertex: 0, polygons: 1 }),
        (
            5,
            &[&[0, 1, 2], &[0, 2, 3], &[0, 3, 4], &[0, 4, 1]],
            NotSimplex { vertex: 0, polygons: 4 },
        ),
    ];
    for (vertex_count, polygons, expected) in cases {
        let polygons: Vec<Vec<u32>> = polygons.iter().map(|polygon| polygon.to_vec()).collect();
        assert_eq!(SimplexSurface::new(vertex_count, &polygons), Err(expected), "{polygons:?}");
    }
    let dual = |count, faces: &[[u32; 3]]| {
        SimplexSurface::dual_of(&TriangleSurface::new(count, faces.to_vec()).expect("valid"))
    };
    assert!(matches!(dual(3, &[[0, 1, 2]]), Err(SimplexError::Surface(SurfaceError::Open { .. }))));
    assert_eq!(dual(3, &[[0, 1, 2], [0, 2, 1]]), Err(ShortPolygon { polygon: 0, len: 2 }));
    let isolated = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
    assert_eq!(dual(5, &isolated), Err(ShortPolygon { polygon: 4, len: 0 }));
    let repeats = [&isolated[..], &[[0, 0, 1]]].concat();
    assert!(dual(4, &repeats).is_err());
}

/// The fan is a closed surface of three triangles for each vertex, and its faces
/// are found by their polygon.
#[test]
fn fans_are_closed() {
    let (surface, x) = octasphere(2);
    let dual = SimplexSurface::dual_of(&surface).unwrap();
    let x = barycenters(&surface, &x);
    let fan = dual.fan().unwrap();
    let mut particles = Vec::new();
    dual.fan_positions(dual.positions(&x).unwrap(), &mut particles);
    let report = inspect(&fan, fan.positions(&particles).unwrap());
    assert_eq!(report.findings, []);
    assert_eq!((report.faces, report.euler), (3 * dual.vertex_count(), 2));
    assert!(report.volume > 3.8, "{}", report.volume);
    let mut faces = fan.faces().iter();
    for polygon in 0..u32::try_from(dual.polygon_count()).unwrap() {
        let vertices = dual.polygon(polygon);
        for (j, [center, from, to]) in faces.by_ref().take(vertices.len()).enumerate() {
            assert_eq!(*center as usize, dual.vertex_count() + polygon as usize);
            assert_eq!([*from, *to], [vertices[j], vertices[(j + 1) % vertices.len()]]);
        }
    }
}

/// A foot anywhere on the fan, spread to the vertices, combines to itself.
#[test]
fn spreading_keeps_the_combination() {
    let (surface, x) = octasphere(1);
    let dual = SimplexSurface::dual_of(&surface).unwrap();
    let x = barycenters(&surface, &x);
    let fan = dual.fan().unwrap();
    let mut particles = Vec::new();
    dual.fan_positions(dual.positions(&x).unwrap(), &mut particles);
    let mut terms = Vec::new();
    cases(21, 10_000, |u| {
        let face = *u.choose(fan.faces())?;
        let foot = closest_on_triangle(
            support::point(u)?,
            face.map(|particle| particles[particle as usize]),
        );
        let vertex = u.int_in_range(0..=x.len() - 1)?;
        let on_fan = Stencil::vertex_face(vertex.try_into().unwrap(), face, foot.barycentric);
        dual.spread(on_fan.terms(), &mut terms);
        let spread: DVec3 = terms.iter().map(|t| t.weight * x[t.particle as usize]).sum();
        let whole = on_fan.combine(|k| particles[k as usize]);
        assert!(spread.distance(whole) < 1e-14, "{terms:?}");
        assert!(terms.iter().map(|t| t.weight).sum::<f64>().abs() < 1e-14);
        let named = |term: &Term| terms.iter().filter(|t| t.particle == term.particle).count();
        assert!(terms.iter().all(|term| named(term) == 1), "{terms:?}");
        Ok(())
    });
}
