//! Contacts beside brute force over all points and primitives.

use arbitrary::{Result, Unstructured};
use arbtest::arbtest;
use glam::DVec3;
use kdop::{Extents, Leaves, Tree, Workspace};
use medial::{
    Ball, FootRule, MedialContactParams, MedialSurface, ParticleOffsets, PrimitiveTree,
    QueryPoints, foot, pair_foot, point_contacts, primitive_contacts,
};

/// Coordinates of points that radii of up to three are far apart among.
const WIDE: f64 = 20.0;

fn coordinate(u: &mut Unstructured<'_>, size: f64) -> Result<f64> {
    Ok(size * f64::from(u.int_in_range(-1000_i32..=1000)?) / 1000.0)
}

fn point(u: &mut Unstructured<'_>, size: f64) -> Result<DVec3> {
    Ok(DVec3::new(coordinate(u, size)?, coordinate(u, size)?, coordinate(u, size)?))
}

/// A few slabs, cones and isolated balls.
fn medial(u: &mut Unstructured<'_>, size: f64) -> Result<MedialSurface> {
    let count = u.int_in_range(3..=14_u32)?;
    let mut balls = Vec::new();
    for _ in 0..count {
        balls.push(Ball::new(point(u, size)?, f64::from(u.int_in_range(0_u16..=300)?) / 100.0));
    }
    let mut slabs = Vec::new();
    let mut cones = Vec::new();
    for _ in 0..u.int_in_range(0..=8)? {
        let mut index = || u.int_in_range(0..=count - 1);
        let [a, b, c] = [index()?, index()?, index()?];
        if a != b && b != c && c != a {
            slabs.push([a, b, c]);
        } else if a != b {
            cones.push([a, b]);
        }
    }
    Ok(MedialSurface::new(balls, cones, slabs).expect("valid by construction"))
}

#[test]
fn points_and_balls_meet_what_brute_force_meets() {
    arbtest(|u| {
        // Far apart, or most points in several primitives at once.
        let size = if u.arbitrary()? { WIDE } else { 4.0 };
        let medial = medial(u, size)?;
        let mut points = Vec::new();
        for _ in 0..u.int_in_range(1..=20)? {
            points.push(point(u, size)?);
        }
        let radii: Vec<f64> = points.iter().map(|p| p.x.abs() / 10.0).collect();
        let radii: Option<&[f64]> = if u.arbitrary()? { Some(&radii) } else { None };
        let reach = f64::from(u.int_in_range(0_u8..=20)?) / 10.0;
        let rule = if u.arbitrary()? { FootRule::Exact } else { FootRule::BareFace };
        let tree = match radii {
            Some(radii) => {
                Tree::build_from(Leaves::Points, Extents::Balls { centers: &points, radii })
            }
            None => Tree::build(Leaves::Points, &points),
        };
        let probes = QueryPoints { tree: &tree.unwrap(), points: &points, radii };
        let on = PrimitiveTree::new(&medial).unwrap();
        let particles = ParticleOffsets { first_point: 100, first_ball: 200 };
        let reach_of = MedialContactParams {
            rule,
            max_contacts: u.int_in_range(1..=3)?,
            ..MedialContactParams::new(reach)
        };
        let workspace = &mut Workspace::default();
        let (found, _) =
            point_contacts(&probes, &medial, &on, &reach_of, particles, None, workspace);
        let at = |k: u32| match k.checked_sub(200) {
            Some(ball) => medial.balls()[ball as usize].center,
            None => points[k as usize - 100],
        };
        for contact in &found {
            assert!(contact.identity_error(at) < 1e-11, "{contact:?}");
            assert!((contact.normal.length() - 1.0).abs() < 1e-12 && contact.gap <= reach);
        }
        for (k, &p) in (100_u32..).zip(&points) {
            let radius = radii.map_or(0.0, |radii| radii[k as usize - 100]);
            let least = medial
                .primitives()
                .iter()
                .map(|balls| foot(p, &balls.map(|b| medial.balls()[b as usize]), rule).distance)
                .fold(f64::INFINITY, f64::min)
                - radius;
            let of_point: Vec<_> =
                found.iter().filter(|c| c.stencil.terms()[0].particle == k).collect();
            assert!(of_point.len() <= reach_of.max_contacts);
            assert!(of_point.is_sorted_by(|a, b| a.gap <= b.gap), "{of_point:?}");
            match of_point.first() {
                Some(contact) => {
                    assert!((contact.gap - least).abs() < 1e-11, "{least} {contact:?}");
                }
                None => assert!(least > reach, "point {k} at {least} is lost"),
            }
        }
        Ok(())
    })
    .budget_ms(1500);
}

#[test]
fn primitives_meet_what_brute_force_meets() {
    arbtest(|u| {
        let (a, b) = (medial(u, WIDE)?, medial(u, WIDE)?);
        let reach = f64::from(u.int_in_range(0_u8..=20)?) / 10.0;
        let trees = [&a, &b].map(|medial| PrimitiveTree::new(medial).unwrap());
        let workspace = &mut Workspace::default();
        let (found, counts) =
            primitive_contacts((&a, &trees[0]), (&b, &trees[1]), reach, workspace);
        let mut expected = Vec::new();
        for i in 0..u32::try_from(a.primitives().len()).unwrap() {
            for j in 0..u32::try_from(b.primitives().len()).unwrap() {
                let distance = pair_foot(&a.primitive_balls(i), &b.primitive_balls(j)).distance;
                if distance <= reach {
                    expected.push([i, j]);
                }
            }
        }
        assert_eq!(found.iter().map(|c| c.primitives).collect::<Vec<_>>(), expected);
        assert!(usize::try_from(counts.leaf_tests).unwrap() >= found.len());
        for contact in &found {
            let particles = ParticleOffsets { first_point: 0, first_ball: 100 };
            let terms = contact.terms(&a, &b, particles);
            let separation: DVec3 = terms
                .iter()
                .map(|t| match t.particle.checked_sub(100) {
                    Some(ball) => t.weight * b.balls()[ball as usize].center,
                    None => t.weight * a.balls()[t.particle as usize].center,
                })
                .sum();
            let error = contact.gap + contact.offset + separation.dot(contact.normal);
            assert!(error.abs() < 1e-11, "{error} {contact:?}");
        }
        Ok(())
    });
}

#[test]
fn a_refitted_tree_finds_moved_balls() {
    arbtest(|u| {
        let mut medial = medial(u, WIDE)?;
        let mut tree = PrimitiveTree::new(&medial).unwrap();
        let mut moved = Vec::new();
        for ball in medial.balls() {
            moved.push(Ball::new(point(u, WIDE)?, ball.radius * 1.5));
        }
        medial.set_balls(&moved).unwrap();
        tree.refit(&medial).unwrap();
        tree.tree().validate().unwrap();
        let p = point(u, WIDE)?;
        let slow = (0..u32::try_from(medial.primitives().len()).unwrap())
            .map(|i| medial.foot(p, i, FootRule::Exact).distance)
            .fold(f64::INFINITY, f64::min);
        let fast = tree.nearest(&medial, p, &mut Workspace::default()).foot.distance;
        assert!((fast - slow).abs() < 1e-15, "{fast} {slow}");
        Ok(())
    });
}
