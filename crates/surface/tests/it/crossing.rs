//! Triangle intersections against rational arithmetic, on triangles that touch or are an
//! ulp apart.

use arbitrary::{Result, Unstructured};
use fixtures::data;
use fixtures::generate::cases;
use num_rational::BigRational;
use num_traits::{Signed, Zero};
use surface::glam::DVec3;
use surface::{Meeting, segment_meets_triangle, triangles_meet};

use crate::support::{self, Exact, anatomy, between_segments, to_triangle};

type Corners<'a> = [&'a Exact; 3];

fn normal([a, b, c]: Corners<'_>) -> Exact {
    b.sub(a).cross(&c.sub(a))
}

fn heights(a: Corners<'_>, b: Corners<'_>) -> [BigRational; 3] {
    let n = normal(b);
    a.map(|corner| n.dot(&corner.sub(b[0])))
}

fn edges([a, b, c]: Corners<'_>) -> [[&Exact; 2]; 3] {
    [[a, b], [b, c], [c, a]]
}

/// Points in which edges of `a` pass the plane of `b` strictly.
fn piercings(a: Corners<'_>, b: Corners<'_>) -> Vec<Exact> {
    let h = heights(a, b);
    (0..3)
        .filter_map(|k| {
            let (hp, hq) = (&h[k], &h[(k + 1) % 3]);
            let opposite = (hp * hq).is_negative();
            opposite.then(|| a[k].lerp(a[(k + 1) % 3], &(hp / (hp - hq))))
        })
        .collect()
}

fn reference_shares_a_point(a: Corners<'_>, b: Corners<'_>) -> bool {
    let corner = a.iter().any(|p| is_on(p, b)) || b.iter().any(|p| is_on(p, a));
    let edge = edges(a).iter().any(|&e| edges(b).iter().any(|&f| segments_share_a_point(e, f)));
    let inside =
        piercings(a, b).iter().any(|p| is_on(p, b)) || piercings(b, a).iter().any(|p| is_on(p, a));
    corner || edge || inside
}

/// Returns true if a point is on a triangle, which may be collapsed.
fn is_on(p: &Exact, b: Corners<'_>) -> bool {
    // Off the plane, its distance need not be divided out.
    normal(b).dot(&p.sub(b[0])).is_zero() && to_triangle(p, b).is_zero()
}

/// Returns true if two segments share a point.
fn segments_share_a_point(a: [&Exact; 2], b: [&Exact; 2]) -> bool {
    // Those of skew lines do not, whatever their distance.
    let across = a[1].sub(a[0]).cross(&b[1].sub(b[0]));
    across.dot(&b[0].sub(a[0])).is_zero() && between_segments(a, b).is_zero()
}

/// Ends, along `direction`, of what `a` and the plane of `b` share; `None`
/// unless `a` has corners on both sides.
fn stretch(a: Corners<'_>, b: Corners<'_>, direction: &Exact) -> Option<[BigRational; 2]> {
    let h = heights(a, b);
    if !(h.iter().any(Signed::is_positive) && h.iter().any(Signed::is_negative)) {
        return None;
    }
    let in_plane = a.iter().zip(&h).filter(|(_, h)| h.is_zero()).map(|(p, _)| (*p).clone());
    let along: Vec<BigRational> =
        piercings(a, b).into_iter().chain(in_plane).map(|p| p.dot(direction)).collect();
    Some([along.iter().min()?.clone(), along.iter().max()?.clone()])
}

fn reference_meeting(a: [DVec3; 3], b: [DVec3; 3]) -> Meeting {
    let [ea, eb] = [a, b].map(|corners| corners.map(Exact::new));
    let [a, b] = [&ea, &eb].map(|e| [&e[0], &e[1], &e[2]]);
    let direction = normal(a).cross(&normal(b));
    if let (Some([a0, a1]), Some([b0, b1])) = (stretch(a, b, &direction), stretch(b, a, &direction))
        && a0.max(b0) < a1.min(b1)
    {
        return Meeting::Crossing;
    }
    if reference_shares_a_point(a, b) { Meeting::Touching } else { Meeting::Disjoint }
}

/// A point of a small grid: three of them are often on a line, four in a plane.
fn grid_point(u: &mut Unstructured<'_>) -> Result<DVec3> {
    let mut x = || Ok(f64::from(u.int_in_range(-2_i8..=2)?));
    Ok(DVec3::new(x()?, x()?, x()?))
}

fn grid_triangle(u: &mut Unstructured<'_>) -> Result<[DVec3; 3]> {
    Ok([grid_point(u)?, grid_point(u)?, grid_point(u)?])
}

/// A corner on, in or through another triangle: on its corners, edges, plane,
/// or anywhere; exactly, or up to ulps.
fn corner_at(u: &mut Unstructured<'_>, corners: [DVec3; 3]) -> Result<DVec3> {
    let near = support::point_near(u, corners)?;
    match u.int_in_range(0..=4)? {
        0 => Ok(*u.choose(&corners)?),
        1 => support::nudged(u, near),
        2 => Ok(corners[0].midpoint(corners[1])),
        3 => support::point(u),
        _ => Ok(near),
    }
}

fn pair(u: &mut Unstructured<'_>) -> Result<[[DVec3; 3]; 2]> {
    if u.ratio(1, 3)? {
        return Ok([grid_triangle(u)?, grid_triangle(u)?]);
    }
    let a = support::triangle(u)?;
    let b = [corner_at(u, a)?, corner_at(u, a)?, corner_at(u, a)?];
    let moved = if u.ratio(1, 4)? { DVec3::new(300.0, -700.0, 1100.0) } else { DVec3::ZERO };
    Ok([a.map(|x| x + moved), b.map(|x| x + moved)])
}

#[test]
fn meetings_equal_those_of_rational_arithmetic() {
    let mut counts = [0; 3];
    cases(1, 2000, |u| {
        let [a, b] = pair(u)?;
        let expected = reference_meeting(a, b);
        let turned = |c: [DVec3; 3]| [c[1], c[2], c[0]];
        let flipped = |c: [DVec3; 3]| [c[0], c[2], c[1]];
        for (a, b) in
            [(a, b), (b, a), (turned(a), b), (a, flipped(b)), (flipped(a), turned(turned(b)))]
        {
            assert_eq!(triangles_meet(a, b), expected, "{a:?} {b:?}");
        }
        counts[expected as usize] += 1;
        Ok(())
    });
    assert!(counts.iter().all(|count| *count > 50), "{counts:?}: too few of one kind");
}

#[test]
fn segments_meet_triangles_as_in_rational_arithmetic() {
    cases(21, 150, |u| {
        let [a, b] = pair(u)?;
        let ends = [b[0], b[1]];
        let [ea, eb] = [a, b].map(|corners| corners.map(Exact::new));
        let (corners, [p, q]) = ([&ea[0], &ea[1], &ea[2]], [&eb[0], &eb[1]]);
        let shares = reference_shares_a_point(corners, [p, q, q]);
        let pierced = piercings([p, q, q], corners);
        let inside = pierced.first().is_some_and(|x| {
            let n = normal(corners);
            edges(corners)
                .iter()
                .all(|[from, to]| n.dot(&to.sub(from).cross(&x.sub(from))).is_positive())
        });
        let expected = match (inside, shares) {
            (true, _) => Meeting::Crossing,
            (false, true) => Meeting::Touching,
            (false, false) => Meeting::Disjoint,
        };
        assert_eq!(segment_meets_triangle(ends, a), expected, "{a:?} {ends:?}");
        assert_eq!(segment_meets_triangle([ends[1], ends[0]], a), expected, "{a:?} {ends:?}");
        Ok(())
    });
}

#[test]
fn decided_cases() {
    use Meeting::{Crossing, Disjoint, Touching};
    let floor = [DVec3::ZERO, DVec3::X * 4.0, DVec3::Y * 4.0];
    let v = DVec3::new;
    let cases = [
        ("shares an edge", [v(0.0, 0.0, 0.0), v(4.0, 0.0, 0.0), v(0.0, 0.0, 4.0)], Touching),
        ("shares a corner", [v(0.0, 0.0, 0.0), v(-4.0, 0.0, 0.0), v(0.0, -1.0, 4.0)], Touching),
        ("corner on the face", [v(1.0, 1.0, 0.0), v(1.0, 1.0, 4.0), v(2.0, 1.0, 4.0)], Touching),
        ("edge on the face", [v(1.0, 1.0, 0.0), v(2.0, 1.0, 0.0), v(2.0, 1.0, 4.0)], Touching),
        ("overlap in the plane", [v(1.0, 1.0, 0.0), v(9.0, 1.0, 0.0), v(1.0, 9.0, 0.0)], Touching),
        ("star in the plane", [v(3.0, 3.0, 0.0), v(-1.0, 3.0, 0.0), v(3.0, -1.0, 0.0)], Touching),
        (
            "edges meet in a point",
            [v(-1.0, 1.0, -1.0), v(1.0, 1.0, 1.0), v(-1.0, 1.0, 1.0)],
            Touching,
        ),
        ("through the face", [v(1.0, 1.0, -1.0), v(2.0, 1.0, 1.0), v(1.0, 2.0, 1.0)], Crossing),
        (
            "corner in the plane, through",
            [v(1.0, 1.0, 0.0), v(1.0, 2.0, 1.0), v(1.0, 2.0, -1.0)],
            Crossing,
        ),
        (
            "edge through a corner",
            [v(0.0, 0.0, -1.0), v(0.0, 0.0, 1.0), v(1.0, 1.0, 0.0)],
            Crossing,
        ),
        (
            "edge across its plane",
            [v(1.0, 0.0, -1.0), v(3.0, 0.0, -1.0), v(2.0, 0.0, 1.0)],
            Touching,
        ),
        ("above", [v(1.0, 1.0, 1.0), v(2.0, 1.0, 1.0), v(2.0, 1.0, 4.0)], Disjoint),
        ("beside in the plane", [v(3.0, 3.0, 0.0), v(9.0, 3.0, 0.0), v(3.0, 9.0, 0.0)], Disjoint),
        ("a line through", [v(1.0, 1.0, -1.0), v(1.0, 1.0, 1.0), v(1.0, 1.0, 3.0)], Touching),
        ("a point on", [v(1.0, 1.0, 0.0), v(1.0, 1.0, 0.0), v(1.0, 1.0, 0.0)], Touching),
        ("a point beside", [v(-1.0, 1.0, 0.0), v(-1.0, 1.0, 0.0), v(-1.0, 1.0, 0.0)], Disjoint),
    ];
    for (name, corners, expected) in cases {
        assert_eq!(triangles_meet(floor, corners), expected, "{name}");
        assert_eq!(triangles_meet(corners, floor), expected, "{name}, the other way");
        assert_eq!(reference_meeting(floor, corners), expected, "{name}, by rational arithmetic");
    }
}

/// Pairs of faces of two meshes whose boxes overlap, sorted along x and swept.
fn count_crossings(a: &[[DVec3; 3]], b: &[[DVec3; 3]]) -> usize {
    let lower = |c: &[DVec3; 3]| c[0].min(c[1]).min(c[2]);
    let upper = |c: &[DVec3; 3]| c[0].max(c[1]).max(c[2]);
    let mut b = b.to_vec();
    b.sort_by(|p, q| lower(p).x.total_cmp(&lower(q).x));
    let widest = b.iter().map(|c| upper(c).x - lower(c).x).fold(0.0, f64::max);
    let met = a.iter().map(|a| {
        let (from, to) = (lower(a), upper(a));
        let start = b.partition_point(|c| lower(c).x < from.x - widest);
        let ahead = b[start..].iter().take_while(|c| lower(c).x <= to.x);
        let near = ahead.filter(|c| from.cmple(upper(c)).all() && lower(c).cmple(to).all());
        near.filter(|c| triangles_meet(*a, **c) == Meeting::Crossing).count()
    });
    met.sum()
}

/// The table counts crossing pairs of faces by another exact program.
#[test]
fn real_meshes_cross_in_as_many_faces_as_their_table_says() {
    let test = "real_meshes_cross_in_as_many_faces_as_their_table_says";
    let Some(folder) = data::anatomy(test) else { return };
    let corners = |set: &str, name: &str| -> Vec<[DVec3; 3]> {
        let own = folder.join(set).join(format!("{name}.ply"));
        let shared = folder.join("vhf_left_thigh").join(format!("{name}.ply"));
        let mesh = data::mesh(if own.exists() { &own } else { &shared });
        (0..mesh.faces.len()).map(|face| mesh.corners(face)).collect()
    };
    let mut total = 0;
    for row in
        anatomy::rows(folder.join("pairs.csv")).iter().filter(|row| row[0] != "vhf_left_thigh")
    {
        let count = count_crossings(&corners(&row[0], &row[1]), &corners(&row[0], &row[2]));
        assert_eq!(count.to_string(), row[9], "{} and {} of {}", row[1], row[2], row[0]);
        total += count;
    }
    assert!(total > 1000, "only {total} crossings");
}
