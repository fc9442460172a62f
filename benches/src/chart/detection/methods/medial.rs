//! Vertices against muscles as balls, cones and slabs, which follow the muscles.
//!
//! With the bone, its vertices are asked about the muscles' balls; of two muscles, the vertices of
//! each about the balls of the other.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::time::Instant;

use glam::DVec3;
use kdop::{Leaves, Tree, Workspace};
use medial::{
    Ball, FootRule, Links, MedialContactParams, MedialParams, MedialSurface, PointContact,
    PrimitiveTree, generate, point_contacts_among,
};
use surface::TriangleSurface;

use super::super::question::{Question, Way};
use super::super::score::Told;
use super::{Detector, Failure};
use crate::bodies::Body;

/// Medial surfaces that were generated, by body and number of balls, with the time that took \[ms\]:
/// both rules, and both questions, are about the same ones.
pub(in super::super) type Generated = RefCell<BTreeMap<(usize, usize), (MedialSurface, f64)>>;

/// Trees over the bodies' vertices, and the balls of muscles.
pub(super) struct ByBalls<'a> {
    question: &'a Question<'a>,
    reach: MedialContactParams,
    points: Vec<Tree>,
    balls: Vec<Option<Balls<'a>>>,
    ways: Vec<(Way, Vec<PointContact>)>,
    workspace: Workspace,
    pairs: Vec<(u32, u32)>,
    built_before: f64,
}

struct Balls<'a> {
    surface: &'a TriangleSurface,
    medial: MedialSurface,
    tree: PrimitiveTree,
    links: Links,
    /// Time that its surface took when it was generated \[ms\], if that was before.
    built_before: f64,
}

pub(super) fn detector<'a>(
    question: &'a Question<'a>,
    (balls, rule): (usize, FootRule),
    generated: &Generated,
) -> Result<ByBalls<'a>, Failure> {
    let bodies = &question.moving.bodies;
    let both = question.pairs.iter().flat_map(|&[a, b]| [[a, b], [b, a]]);
    let ways: Vec<Way> = both.filter(|way| way[1] > 0).collect();
    let points = bodies.iter().map(|body| Tree::build(Leaves::Points, &body.x));
    let needed = |body: usize| ways.iter().any(|way| way[1] == body);
    let of_body = |body: usize| {
        let build = || Balls::new((body, &bodies[body]), balls, generated);
        needed(body).then(build).transpose()
    };
    let all = (0..bodies.len()).map(of_body).collect::<Result<Vec<_>, _>>()?;
    let built_before = all.iter().flatten().map(|balls| balls.built_before).sum();
    Ok(ByBalls {
        question,
        reach: MedialContactParams { margin: 0.0, rule, max_contacts: 1 },
        points: points.collect::<Result<_, _>>()?,
        balls: all,
        built_before,
        ways: ways.into_iter().map(|way| (way, Vec::new())).collect(),
        workspace: Workspace::default(),
        pairs: Vec::new(),
    })
}

impl<'a> Balls<'a> {
    fn new(
        (number, body): (usize, &'a Body),
        balls: usize,
        generated: &Generated,
    ) -> Result<Self, Failure> {
        let surface = &body.surface;
        let x = surface.positions(&body.x)?;
        let known = generated.borrow().get(&(number, balls)).cloned();
        let (medial, built_before) = match known {
            Some(known) => known,
            None => {
                let start = Instant::now();
                let medial = generate(surface, x, &MedialParams::balls(balls), |_| {})?.medial;
                let took = start.elapsed().as_secs_f64() * 1e3;
                generated.borrow_mut().insert((number, balls), (medial.clone(), took));
                (medial, 0.0)
            }
        };
        let tree = PrimitiveTree::new(&medial)?;
        let links = Links::new(&medial, surface, x)?;
        Ok(Self { surface, medial, tree, links, built_before })
    }

    fn follow(&mut self, x: &[DVec3]) -> Result<(), Failure> {
        self.links.follow(&mut self.medial, self.surface.positions(x)?)?;
        Ok(self.tree.refit(&self.medial)?)
    }
}

impl Detector for ByBalls<'_> {
    fn built_before(&self) -> f64 {
        self.built_before
    }

    fn step(&mut self, frame: usize) -> Result<(), Failure> {
        let Self { question, reach, points, balls, ways, workspace, pairs, .. } = self;
        let frame = &question.moving.frames[frame];
        for (body, balls) in balls.iter_mut().enumerate() {
            if let Some(balls) = balls {
                balls.follow(&frame[body])?;
            }
        }
        // The bone stays; it has no balls. Of muscles, each is asked about some other's.
        for (tree, x) in points.iter_mut().zip(frame).skip(1) {
            tree.refit(x)?;
        }
        for ([asked, of], found) in ways {
            let Some(balls) = &balls[*of] else { continue };
            pairs.clear();
            let (tree, x) = (&points[*asked], &frame[*asked]);
            balls.tree.tree().pairs(tree, 0.0, workspace, |primitive, point| {
                pairs.push((point, primitive));
            });
            let ball = |point: u32| Ball::new(x[point as usize], 0.0);
            point_contacts_among(pairs, ball, &balls.medial, reach, None, found);
        }
        Ok(())
    }

    fn told(&self) -> Told {
        let told = |(way, found): &(Way, Vec<PointContact>)| {
            let inside = found.iter().filter(|found| found.gap < 0.0);
            (*way, inside.map(|found| (found.point, -found.gap)).collect())
        };
        Told::Vertices(self.ways.iter().map(told).collect())
    }
}
