//! Muscles as balls, cones and slabs: vertices against them as they follow the muscles, and balls
//! against each other where balls are what is simulated.
//!
//! With the bone, its vertices are detected in the muscles' balls; with two muscles, the vertices
//! of each in the balls of the other.

use std::collections::BTreeMap;

use glam::DVec3;
use kdop::{Leaves, Tree, Workspace};
use medial::{
    Ball, CandidatePair, FootRule, Links, MedialContactParams, MedialParams, MedialSurface,
    PointCandidates, PointContact, PrimitiveContact, PrimitiveTree, generate, point_contacts_among,
    primitive_contacts_among,
};
use proximity::SurfaceTree;
use surface::TriangleSurface;
use surface::progress::Progress;

use super::super::score::Answer;
use super::super::task::{Direction, Task, both_directions};
use super::{Built, Detector, Failure, whole};

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
    candidates: PointCandidates,
}

/// Balls that follow a muscle.
struct FollowingBalls<'a> {
    surface: &'a TriangleSurface,
    medial: MedialSurface,
    tree: PrimitiveTree,
    links: Links,
}

/// Generates balls for the muscles of a task.
///
/// # Errors
///
/// When a muscle has no medial surface of this size.
pub(super) fn detector<'a>(task: &'a Task<'a>, balls: f64, rule: FootRule) -> Built<'a> {
    let count = whole(balls) as usize;

    let mut contacts = Vec::new();
    let mut is_needed = vec![false; task.moving.bodies.len()];
    for direction in task.pairs.iter().copied().flat_map(both_directions) {
        if direction.against > 0 {
            contacts.push((direction, Vec::new()));
            is_needed[direction.against] = true;
        }
    }

    // Only bodies that vertices are detected in need balls.
    let (mut vertices, mut balls) = (Vec::new(), Vec::new());
    for (number, body) in task.moving.bodies.iter().enumerate() {
        vertices.push(Tree::build(Leaves::Points, body.positions().as_slice())?);
        let following = match is_needed[number] {
            true => Some(FollowingBalls::new(body, count)?),
            false => None,
        };
        balls.push(following);
    }
    Ok(Box::new(MedialDetection {
        task,
        params: MedialContactParams { margin: 0.0, rule, max_contacts: 1 },
        vertices,
        balls,
        contacts,
        workspace: Workspace::default(),
        pairs: Vec::new(),
        candidates: PointCandidates::default(),
    }))
}

impl<'a> FollowingBalls<'a> {
    fn new(body: &'a SurfaceTree, count: usize) -> Result<Self, Failure> {
        let (surface, x) = (body.surface(), body.positions());
        let medial = generate(surface, x, &MedialParams::balls(count), Progress::none())?.medial;
        let tree = PrimitiveTree::new(&medial)?;
        let links = Links::new(&medial, surface, x)?;
        Ok(Self { surface, medial, tree, links })
    }

    fn follow(&mut self, x: &[DVec3]) -> Result<(), Failure> {
        self.links.follow(&mut self.medial, self.surface.positions(x)?)?;
        Ok(self.tree.refit(&self.medial)?)
    }
}

impl Detector for MedialDetection<'_> {
    fn step(&mut self, frame: usize) -> Result<(), Failure> {
        let Self { task, params, vertices, balls, contacts, workspace, pairs, candidates } = self;
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
            point_contacts_among(pairs, ball, &balls.medial, params, candidates, found);
        }
        Ok(())
    }

    fn answer(&self) -> Answer {
        let mut directions = Vec::new();
        for (direction, found) in &self.contacts {
            let mut inside = Vec::new();
            for PointContact { point, gap, .. } in found {
                if *gap < 0.0 {
                    inside.push((*point, -gap));
                }
            }
            directions.push((*direction, inside));
        }
        Answer::Vertices(directions)
    }
}

/// Detection between balls, cones and slabs, whose places in all frames are given.
struct SimulatedBalls<'a> {
    task: &'a Task<'a>,
    /// Balls per body and frame; none of bodies without pairs.
    frames: Vec<Vec<MedialSurface>>,
    trees: Vec<Option<PrimitiveTree>>,
    /// Depth of each pair.
    depths: Vec<f64>,
    workspace: Workspace,
    pairs: Vec<[u32; 2]>,
    contacts: Vec<PrimitiveContact>,
}

/// Generates balls for all bodies in pairs, and places them in all frames.
///
/// # Errors
///
/// When a body has no medial surface of this size.
pub(super) fn simulated<'a>(task: &'a Task<'a>, balls: f64) -> Built<'a> {
    let count = whole(balls) as usize;
    let (mut frames, mut trees) = (Vec::new(), Vec::new());
    for (number, body) in task.moving.bodies.iter().enumerate() {
        let (mut placed, mut tree) = (Vec::new(), None);
        // Bodies without pairs need no balls.
        if task.pairs.iter().flatten().any(|&member| member == number) {
            let mut balls = FollowingBalls::new(body, count)?;
            for frame in &task.moving.frames {
                balls.follow(&frame[number])?;
                placed.push(balls.medial.clone());
            }
            tree = Some(balls.tree);
        }
        frames.push(placed);
        trees.push(tree);
    }
    Ok(Box::new(SimulatedBalls {
        task,
        frames,
        trees,
        depths: vec![0.0; task.pairs.len()],
        workspace: Workspace::default(),
        pairs: Vec::new(),
        contacts: Vec::new(),
    }))
}

impl Detector for SimulatedBalls<'_> {
    fn step(&mut self, frame: usize) -> Result<(), Failure> {
        let Self { task, frames, trees, depths, workspace, pairs, contacts } = self;
        for (tree, placed) in trees.iter_mut().zip(&*frames) {
            if let Some(tree) = tree {
                tree.refit(&placed[frame])?;
            }
        }

        for (&[a, b], depth) in task.pairs.iter().zip(depths) {
            let [Some(tree_a), Some(tree_b)] = [&trees[a], &trees[b]] else { continue };
            pairs.clear();
            tree_a.tree().pairs(tree_b.tree(), 0.0, workspace, |i, j| pairs.push([i, j]));
            let (a, b) = (&frames[a][frame], &frames[b][frame]);
            primitive_contacts_among(pairs, a, b, 0.0, contacts);
            *depth = contacts.iter().map(|contact| -contact.gap).fold(0.0, f64::max);
        }
        Ok(())
    }

    fn answer(&self) -> Answer {
        let mut depths = BTreeMap::new();
        for (&pair, &depth) in self.task.pairs.iter().zip(&self.depths) {
            if depth > 0.0 {
                depths.insert(pair, depth);
            }
        }
        Answer::Depths(depths)
    }
}
