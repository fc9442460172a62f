//! Vertices against muscles as balls, cones and slabs, which follow the muscles.
//!
//! With the bone, its vertices are detected in the muscles' balls; with two muscles, the vertices
//! of each in the balls of the other.

use glam::DVec3;
use kdop::{Leaves, Tree, Workspace};
use medial::{
    Ball, CandidatePair, FootRule, Links, MedialContactParams, MedialParams, MedialSurface,
    PointCandidates, PointContact, PrimitiveTree, generate, point_contacts_among,
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
            point_contacts_among(pairs, ball, &balls.medial, params, None, candidates, found);
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
