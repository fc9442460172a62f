//! Defect reports: planted defects, random face lists against counts by brute force, and
//! real meshes against their table.

use std::collections::BTreeMap;

use fixtures::data;
use fixtures::generate::cases;
use surface::glam::DVec3;
use surface::{Aabb, Defect, Element, Finding, Inspection, SurfaceError, TriangleSurface, inspect};

use crate::support::anatomy;

const TETRAHEDRON: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];

fn corners() -> Vec<DVec3> {
    vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z]
}

fn report(x: &[DVec3], faces: &[[u32; 3]]) -> Inspection {
    let surface = TriangleSurface::new(x.len(), faces.to_vec()).expect("valid");
    inspect(&surface, surface.positions(x).expect("finite"))
}

#[test]
fn a_tetrahedron_has_no_defect() {
    let report = report(&corners(), &TETRAHEDRON);
    assert_eq!(report.findings, []);
    assert!(report.closed() && report.manifold() && report.oriented());
    assert_eq!((report.components, report.euler), (1, 2));
    assert_eq!((report.vertices, report.edges, report.faces), (4, 6, 4));
    assert!((report.volume - 1.0 / 6.0).abs() < 1e-15);
    assert!((report.area - (1.5 + 0.75_f64.sqrt())).abs() < 1e-15);
    assert!((report.mean_edge - (3.0 + 3.0 * 2.0_f64.sqrt()) / 6.0).abs() < 1e-15);
    assert_eq!(report.bounds, Some(Aabb { min: DVec3::ZERO, max: DVec3::ONE }));
}

#[test]
fn vertices_without_a_face_are_out_of_the_box() {
    let x = [&corners()[..], &[DVec3::splat(1e4)]].concat();
    let report = report(&x, &TETRAHEDRON);
    assert_eq!(report.bounds, Some(Aabb { min: DVec3::ZERO, max: DVec3::ONE }));
    let isolated = &report.findings[..];
    assert!(matches!(isolated, [it] if it.defect == Defect::IsolatedVertex), "{isolated:?}");
}

#[test]
fn nothing_has_no_defect_and_no_box() {
    let report = report(&[], &[]);
    assert!(report.closed() && report.findings.is_empty() && report.bounds.is_none());
    assert_eq!((report.components, report.euler, report.mean_edge), (0, 0, 0.0));
}

/// A defect, how often and where first, vertices to add, faces, and its words.
type Planted = (Defect, usize, Element, u8, Vec<[u32; 3]>, &'static str);

/// Each kind of defect planted alone, with its count, first place and words.
#[test]
fn planted_defects_are_found_in_place() {
    use Element::{Edge, Face, Vertex};
    let t = TETRAHEDRON;
    let with = |more: &[[u32; 3]]| [&t[..], more].concat();
    let far = |n: u8| (0..n).map(|k| DVec3::new(5.0, f64::from(k), f64::from(k * k)));
    let cases: [Planted; 8] = [
        (
            Defect::BoundaryEdge,
            3,
            Edge([0, 2]),
            0,
            t[..3].to_vec(),
            "3 boundary edges, the first from vertex 0 to 2 at (0, 0.5, 0)",
        ),
        (
            Defect::NonManifoldEdge,
            1,
            Edge([0, 1]),
            2,
            with(&[[0, 1, 4], [1, 0, 5], [0, 4, 5], [4, 1, 5]]),
            "1 non-manifold edge, from vertex 0 to 1 at (0.5, 0, 0)",
        ),
        (
            Defect::MisorientedEdge,
            3,
            Edge([0, 1]),
            0,
            vec![[0, 1, 2], t[1], t[2], t[3]],
            "3 misoriented edges, the first from vertex 0 to 1 at (0.5, 0, 0)",
        ),
        (
            Defect::NonManifoldVertex,
            1,
            Vertex(3),
            3,
            with(&[[3, 5, 4], [3, 4, 6], [4, 5, 6], [5, 3, 6]]),
            "1 non-manifold vertex, vertex 3 at (0, 0, 1)",
        ),
        (
            Defect::IsolatedVertex,
            2,
            Vertex(4),
            2,
            t.to_vec(),
            "2 isolated vertices, the first vertex 4 at (5, 0, 0)",
        ),
        (
            Defect::RepeatedCorner,
            1,
            Face(4),
            0,
            with(&[[1, 1, 2]]),
            "1 face that repeats a vertex, face 4 at (0.6666666666666666, 0.3333333333333333, 0)",
        ),
        (Defect::ZeroArea, 1, Face(4), 3, with(&[[4, 5, 6]]), ""),
        (Defect::DuplicateFace, 2, Face(4), 0, with(&[[2, 1, 0], [3, 0, 1]]), ""),
    ];
    for (defect, count, first, extra, faces, words) in cases {
        let mut x = corners();
        x.extend(far(extra));
        if defect == Defect::ZeroArea {
            x[5].z = 0.5;
            x[6] = x[4].lerp(x[5], 2.0);
        }
        let report = report(&x, &faces);
        let finding = report.findings.iter().find(|f| f.defect == defect).expect("found");
        assert_eq!((finding.count, finding.first), (count, first), "{defect:?}");
        assert!(words.is_empty() || finding.to_string() == words, "{finding}");
    }
}

#[test]
fn duplicate_vertices_are_those_in_an_earlier_place() {
    let mut x = corners();
    x.extend([DVec3::new(-0.0, 0.0, -0.0), DVec3::Y, DVec3::ZERO, DVec3::Y * (1.0 + f64::EPSILON)]);
    let report = report(&x, &TETRAHEDRON);
    assert_eq!(report.count(Defect::DuplicateVertex), 3);
    let finding = report.findings.iter().find(|f| f.defect == Defect::DuplicateVertex).unwrap();
    assert_eq!((finding.first, finding.at), (Element::Vertex(4), DVec3::ZERO));
}

/// Gives each face corners of its own, as files do that have separate triangles.
fn separate(x: &[DVec3], faces: &[[u32; 3]]) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let corners = faces.iter().flatten().map(|vertex| x[*vertex as usize]).collect();
    let faces = (0_u32..).zip(faces).map(|(face, _)| [3 * face, 3 * face + 1, 3 * face + 2]);
    (corners, faces.collect())
}

#[test]
fn vertices_that_are_not_welded_are_named() {
    let words = |x: &[DVec3], faces: &[[u32; 3]]| -> Vec<String> {
        let findings = report(x, faces).findings;
        findings.iter().map(Finding::to_string).filter(|text| text.contains("weld")).collect()
    };
    let (x, faces) = separate(&corners(), &TETRAHEDRON);
    let seams = "12 boundary edges in the place of others (vertices are not welded: merge those at one place), the first \
        from vertex 0 to 1 at (0, 0.5, 0)";
    assert_eq!(words(&x, &faces), [seams]);

    // A face less: three of its neighbors' edges are a border, and no seam.
    assert!(words(&x, &faces[..3])[0].starts_with("6 boundary edges in the place of others"));

    // One vertex is there twice, as where a texture is cut, with a coordinate of -0.
    let cut = [&corners()[..], &[DVec3::new(-0.0, -0.0, 1.0)]].concat();
    let torn = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 4]];
    let text = "4 boundary edges in the place of others (vertices are not welded: merge those at one place), the first \
        from vertex 0 to 3 at (0, 0, 0.5)";
    assert_eq!(words(&cut, &torn), [text]);
    let surface = TriangleSurface::new(5, torn.to_vec()).expect("valid");
    let refused = surface.require_welded(surface.positions(&cut).expect("finite"));
    assert_eq!(refused, Err(SurfaceError::Unwelded { count: 4, from: 0, to: 3 }));

    // Neither holes nor tetrahedra that touch are seams.
    assert_eq!(words(&corners(), &TETRAHEDRON[..3]), [""; 0]);
    let twice =
        [corners(), corners().iter().map(|x| DVec3::new(x.x, x.y, -x.z)).collect()].concat();
    let touching = [TETRAHEDRON, TETRAHEDRON.map(|face| face.map(|v| v + 4))].concat();
    assert_eq!(words(&twice, &touching), [""; 0]);
}

/// Random triangles of few places, each pair of border edges compared.
#[test]
fn unwelded_edges_equal_those_of_all_pairs() {
    for number in 0_u32..300 {
        let mut state = number.wrapping_mul(2_654_435_761) | 1;
        let mut next = |below: u32| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 16) % below
        };
        let x: Vec<DVec3> =
            (0..12).map(|_| DVec3::from([next(2), next(2), next(2)].map(f64::from))).collect();
        let faces: Vec<[u32; 3]> = (0..8).map(|_| [next(12), next(12), next(12)]).collect();
        let surface = TriangleSurface::new(x.len(), faces).expect("valid");
        let count = |edge: usize| surface.edge_faces(u32::try_from(edge).expect("few")).len();
        let border: Vec<[u32; 2]> = (0..surface.edges().len())
            .filter(|edge| count(*edge) == 1)
            .map(|edge| surface.edges()[edge])
            .collect();
        let place = |[a, b]: [u32; 2]| [x[a as usize], x[b as usize]];
        let is_seam = |edge: &&[u32; 2]| {
            let [a, b] = place(**edge);
            let others = border.iter().filter(|other| other != edge);
            others.map(|other| place(*other)).any(|other| other == [a, b] || other == [b, a])
        };
        let expected = border.iter().filter(is_seam).count();
        let found = inspect(&surface, surface.positions(&x).expect("finite"));
        assert_eq!(found.count(Defect::UnweldedEdge), expected, "{number}");
    }
}

#[test]
fn what_is_lacking_is_refused_with_its_place() {
    let surface = |faces: &[[u32; 3]]| TriangleSurface::new(7, faces.to_vec()).expect("valid");
    let t = TETRAHEDRON;
    assert_eq!(surface(&t).require_closed(), Ok(()));
    assert_eq!(surface(&t).require_manifold(), Ok(()));
    assert_eq!(surface(&t).require_oriented(), Ok(()));
    let open = SurfaceError::Open { count: 3, from: 0, to: 2, face: 0 };
    assert_eq!(surface(&t[..3]).require_closed(), Err(open));
    let book = surface(&[[0, 1, 2], [0, 1, 3], [0, 1, 4]]);
    let edge = SurfaceError::NonManifold { count: 1, from: 0, to: 1 };
    assert_eq!(book.require_manifold(), Err(edge));
    let misoriented = SurfaceError::Misoriented { count: 1, from: 0, to: 1 };
    assert_eq!(book.require_oriented(), Err(misoriented));
    let bow_tie = surface(&[[0, 1, 2], [0, 3, 4]]);
    let vertex = SurfaceError::NonManifoldVertex { count: 1, vertex: 0 };
    assert_eq!(bow_tie.require_manifold(), Err(vertex));
    assert!(!bow_tie.is_closed() && bow_tie.require_manifold().is_err());
    assert_eq!(bow_tie.require_oriented(), Ok(()));
}

/// Counts half-edges one by one.
fn reference_counts(vertex_count: u32, faces: &[[u32; 3]]) -> BTreeMap<&'static str, usize> {
    let mut runs: BTreeMap<[u32; 2], usize> = BTreeMap::new();
    let mut uses: BTreeMap<[u32; 2], usize> = BTreeMap::new();
    for &[a, b, c] in faces {
        for [from, to] in [[a, b], [b, c], [c, a]].into_iter().filter(|[from, to]| from != to) {
            *runs.entry([from, to]).or_default() += 1;
            *uses.entry([from.min(to), from.max(to)]).or_default() += 1;
        }
    }
    let sorted = |face: &[u32; 3]| {
        let mut face = *face;
        face.sort_unstable();
        face
    };
    let whole = |f: &[u32; 3]| f[0] != f[1] && f[1] != f[2] && f[2] != f[0];
    let is_duplicate = |i: usize| faces[..i].iter().any(|f| sorted(f) == sorted(&faces[i]));
    let split = |v: u32| {
        let mut parts: Vec<Vec<&[u32; 3]>> =
            faces.iter().filter(|f| f.contains(&v)).map(|f| vec![f]).collect();
        let joined = |p: &[&[u32; 3]], q: &[&[u32; 3]]| {
            p.iter().any(|f| f.iter().any(|k| *k != v && q.iter().any(|g| g.contains(k))))
        };
        while let Some((i, j)) = (0..parts.len())
            .flat_map(|i| (0..i).map(move |j| (i, j)))
            .find(|(i, j)| joined(&parts[*i], &parts[*j]))
        {
            let part = parts.swap_remove(i);
            parts[j].extend(part);
        }
        parts.len() > 1
    };
    BTreeMap::from([
        ("boundary", uses.values().filter(|n| **n == 1).count()),
        ("non-manifold", uses.values().filter(|n| **n > 2).count()),
        ("misoriented", runs.values().filter(|n| **n > 1).count()),
        ("split", (0..vertex_count).filter(|v| split(*v)).count()),
        ("isolated", (0..vertex_count).filter(|v| !faces.iter().any(|f| f.contains(v))).count()),
        ("repeats", faces.iter().filter(|f| !whole(f)).count()),
        ("duplicates", (0..faces.len()).filter(|i| whole(&faces[*i]) && is_duplicate(*i)).count()),
    ])
}

#[test]
fn counts_of_any_list_equal_those_by_brute_force() {
    cases(21, 20_000, |u| {
        let vertex_count = u.int_in_range(1..=8_u32)?;
        let mut faces = Vec::new();
        for _ in 0..u.int_in_range(0..=12)? {
            let mut corner = || u.int_in_range(0..=vertex_count - 1);
            faces.push([corner()?, corner()?, corner()?]);
        }
        let x: Vec<DVec3> =
            (0..vertex_count).map(|k| DVec3::splat(f64::from(k)).with_y(0.1)).collect();
        let report = report(&x, &faces);
        let counts = BTreeMap::from([
            ("boundary", report.count(Defect::BoundaryEdge)),
            ("non-manifold", report.count(Defect::NonManifoldEdge)),
            ("misoriented", report.count(Defect::MisorientedEdge)),
            ("split", report.count(Defect::NonManifoldVertex)),
            ("isolated", report.count(Defect::IsolatedVertex)),
            ("repeats", report.count(Defect::RepeatedCorner)),
            ("duplicates", report.count(Defect::DuplicateFace)),
        ]);
        assert_eq!(counts, reference_counts(vertex_count, &faces), "{faces:?}");
        assert_eq!(
            report.count(Defect::ZeroArea),
            faces.len() - report.count(Defect::RepeatedCorner),
            "all corners are on one line"
        );
        Ok(())
    });
}

#[test]
fn real_meshes_have_the_defects_of_their_table() {
    let test = "real_meshes_have_the_defects_of_their_table";
    let Some(folder) = data::anatomy(test) else { return };
    for row in anatomy::rows(folder.join("meshes.csv")) {
        let mesh = data::mesh(&folder.join(&row[0]).join(&row[1]));
        let surface = mesh.surface();
        let report = inspect(&surface, surface.positions(&mesh.positions).unwrap());
        let number = |column: usize| row[column].parse::<usize>().unwrap();
        let name = &row[1];
        assert_eq!([report.vertices, report.faces], [number(2), number(3)], "{name}");
        assert_eq!(report.count(Defect::BoundaryEdge), number(5), "{name}");
        assert_eq!(report.count(Defect::NonManifoldEdge), number(6), "{name}");
        assert_eq!(report.count(Defect::NonManifoldVertex), number(7), "{name}");
        assert_eq!(report.count(Defect::MisorientedEdge), number(8), "{name}");
        let sound = report.closed() && report.manifold() && report.oriented();
        assert_eq!(sound, row[9] == "True", "{name}");
        assert_eq!(report.components, number(10), "{name}");
        assert_eq!(report.euler, row[11].parse::<i64>().unwrap(), "{name}");
        if sound {
            let volume: f64 = row[13].parse().unwrap();
            assert!(
                (report.volume / 1000.0 - volume).abs() <= 0.005001,
                "{name} {}",
                report.volume
            );
        }
    }
}
