//! Vertices against muscles as balls, cones and slabs, which follow the muscles.
//!
//! With the bone, its vertices are detected in the muscles' balls; with two muscles, the vertices
//! of each in the balls of the other.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::time::Instant;

use glam::DVec3;
use kdop::{Leaves, Tree, Workspace};
use medial::{
    Ball, CandidatePair, FootRule, Links, MedialContactParams, MedialParams, MedialSurface,
    PointContact, PrimitiveTree, generate, point_contacts_among,
};
use proximity::SurfaceTree;
use surface::TriangleSurface;
use surface::progress::Progress;

use super::super::score::Answer;
use super::super::task::{Direction, Task, both_directions};
use super::{Built, Detector, Failure, whole};

/// Generated medial surfaces by body and number of balls, which both rules and both tasks share.
pub(in super::super) type GeneratedBalls = RefCell<BTreeMap<(usize, usize), Generation>>;

/// A medial surface, and the time to generate it \[ms\].
#[derive(Clone, Debug)]
pub(in super::super) struct Generation {
    medial: MedialSurface,
    milliseconds: f64,
}

/// Detection of vertices in the balls of muscles.
pub(super) struct MedialDetection<'a> {
    task: &'a Task<'a>,
    params: MedialContactParams,
    /// Trees over the vertices of each body.
    vertices: Vec<Tree>,
    /// Balls of the muscles in pairs.
    balls: Vec<Option<FollowingBalls<'a>>>,
    contacts: Vec<(Direction, Vec<PointContact>)>,
    workspace: Workspace,
    pairs: Vec<CandidatePair>,
}

/// Balls that follow a muscle.
struct FollowingBalls<'a> {
    surface: &'a TriangleSurface,
    medial: MedialSurface,
    tree: PrimitiveTree,
    links: Links,
    /// Time to generate the balls \[ms\], if that was for another detector.
    milliseconds_before: f64,
}

/// Sets up balls for the muscles of a task, generated unless another detector already did.
///
/// # Errors
///
/// When a muscle has no medial surface of this size.
pub(super) fn detector<'a>(
    task: &'a Task<'a>,
    balls: f64,
    rule: FootRule,
    generated: &GeneratedBalls,
) -> Built<'a> {
    let count = whole(balls) as usize;

    let all_directions = task.pairs.iter().flat_map(|pair| both_directions(*pair));
    let contacts: Vec<(Direction, Vec<PointContact>)> = all_directions
        .filter(|direction| direction.against > 0)
        .map(|direction| (direction, Vec::new()))
        .collect();

    // Only bodies that vertices are detected in need balls.
    let (mut vertices, mut balls) = (Vec::new(), Vec::new());
    for (number, body) in task.moving.bodies.iter().enumerate() {
        vertices.push(Tree::build(Leaves::Points, body.positions().as_slice())?);
        let is_needed = contacts.iter().any(|(direction, _)| direction.against == number);
        let build = || FollowingBalls::new(body, (number, count), generated);
        balls.push(is_needed.then(build).transpose()?);
    }
    Ok(Box::new(MedialDetection {
        task,
        params: MedialContactParams { margin: 0.0, rule, max_contacts: 1 },
        vertices,
        balls,
        contacts,
        workspace: Workspace::default(),
        pairs: Vec::new(),
    }))
}

impl<'a> FollowingBalls<'a> {
    fn new(
        body: &'a SurfaceTree,
        key: (usize, usize),
        generated: &GeneratedBalls,
    ) -> Result<Self, Failure> {
        let (surface, x) = (body.surface(), body.positions());
        // Generation is slow, so that all detectors share it; each counts its time.
        let before = generated.borrow().get(&key).cloned();
        let milliseconds_before = before.as_ref().map_or(0.0, |before| before.milliseconds);
        let medial = match before {
            Some(before) => before.medial,
            None => {
                let start = Instant::now();
                let medial =
                    generate(surface, x, &MedialParams::balls(key.1), Progress::none())?.medial;
                let milliseconds = start.elapsed().as_secs_f64() * 1e3;
                let generation = Generation { medial: medial.clone(), milliseconds };
                generated.borrow_mut().insert(key, generation);
                medial
            }
        };
        let tree = PrimitiveTree::new(&medial)?;
        let links = Links::new(&medial, surface, x)?;
        Ok(Self { surface, medial, tree, links, milliseconds_before })
    }

    fn follow(&mut self, x: &[DVec3]) -> Result<(), Failure> {
        self.links.follow(&mut self.medial, self.surface.positions(x)?)?;
        Ok(self.tree.refit(&self.medial)?)
    }
}

impl Detector for MedialDetection<'_> {
    fn milliseconds_before(&self) -> f64 {
        self.balls.iter().flatten().map(|balls| balls.milliseconds_before).sum()
    }

    fn step(&mut self, frame: usize) -> Result<(), Failure> {
        let Self { task, params, vertices, balls, contacts, workspace, pairs } = self;
        let frame = &task.moving.frames[frame];

        // The bone stays, and has no balls.
        for (balls, x) in balls.iter_mut().zip(frame) {
            if let Some(balls) = balls {
                balls.follow(x)?;
            }
        }
        for (tree, x) in vertices.iter_mut().zip(frame).skip(1) {
            tree.refit(x)?;
        }

        // Vertices in the bounds of cones and slabs, then in these.
        for (direction, found) in contacts {
            let Some(balls) = &balls[direction.against] else { continue };
            let (tree, x) = (&vertices[direction.vertices], &frame[direction.vertices]);
            pairs.clear();
            balls.tree.tree().pairs(tree, 0.0, workspace, |primitive, point| {
                pairs.push(CandidatePair { point, primitive });
            });
            let ball = |point: u32| Ball::new(x[point as usize], 0.0);
            point_contacts_among(pairs, ball, &balls.medial, params, None, found);
        }
        Ok(())
    }

    fn answer(&self) -> Answer {
        let mut directions = Vec::new();
        for (direction, found) in &self.contacts {
            let inside = found.iter().filter(|found| found.gap < 0.0);
            directions.push((*direction, inside.map(|found| (found.point, -found.gap)).collect()));
        }
        Answer::Vertices(directions)
    }
}
