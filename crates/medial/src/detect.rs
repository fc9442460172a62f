//! Contacts of points, balls and primitives with a medial surface.
//!
//! Source: B. Gilles, *Anatomical and kinematical modelling of the
//! musculoskeletal system using MRI*, PhD thesis, 2007, section 4.7.2: trees of
//! bounds over the balls' primitives, tested against the points or balls of the
//! other object, whose distance to the nearest ball is compared with the radii.
//!
//! Differs from the printed pseudo code in this:
//!
//! - a ball's bound along n is `n·c ± r‖n‖`, and the lower ones are least values;
//! - a pair of a leaf and an inner node descends the inner node;
//! - what is within the reach, not only inside, is a contact; one tree is widened
//!   by it;
//! - of several contacts of a point those with the least gap stay, not the one
//!   with the closest centre, and up to three with distinct normals: in a groove
//!   one is not enough;
//! - the foot on a slab is the exact one, unless the bare face is asked for;
//! - a point at the very centre of a ball, or that passed the middle of the sheet
//!   since it was last seen, is told by the normal it was last seen under.

use glam::DVec3;
use kdop::{Tree, Workspace};
use surface::{Contact, Stencil, Term};

use crate::{Ball, Foot, FootRule, MedialSurface, PrimitiveTree, pair_foot};

/// Contacts that a point keeps at most: what a groove with three sides needs.
pub const MOST_CONTACTS: usize = 3;

/// Cosine of the angle within which two normals count as one: 30°. At 10° one
/// rounded side gives several contacts; at 60° the sides of a shallow groove
/// become one.
const DISTINCT_COSINE: f64 = 0.866_025_403_784_438_6;

/// What counts as a contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reach {
    /// Gap up to which a contact is reported, `>= 0`.
    pub reach: f64,
    /// Which ball of a primitive is compared.
    pub rule: FootRule,
    /// Contacts kept for each point, `1..=`[`MOST_CONTACTS`].
    pub most: usize,
}

impl Reach {
    /// Exact feet and up to [`MOST_CONTACTS`] contacts a point.
    #[must_use]
    pub const fn new(reach: f64) -> Self {
        Self { reach, rule: FootRule::Exact, most: MOST_CONTACTS }
    }
}

/// Where each point of one object was last seen from another one: the unit
/// normal of its contact, or zero.
///
/// Kept from one step to the next, it tells a point that passed the middle of
/// the other object's sheet from one that came from the other side.
#[derive(Clone, Debug, PartialEq)]
pub struct Sides(Vec<DVec3>);

impl Sides {
    /// Sides of `points` points, none known yet.
    #[must_use]
    pub fn new(points: usize) -> Self {
        Self(vec![DVec3::ZERO; points])
    }

    /// The side of one point.
    ///
    /// # Panics
    ///
    /// When there is no such point.
    #[must_use]
    pub fn of(&self, point: u32) -> DVec3 {
        self.0[point as usize]
    }
}

/// Points of one object, or balls: what is compared with a medial surface.
#[derive(Clone, Copy, Debug)]
pub struct Probes<'a> {
    /// Tree over them, one leaf each, in their order.
    pub tree: &'a Tree,
    /// Their positions.
    pub points: &'a [DVec3],
    /// Their radii; none for the points of a surface, which have no extent.
    pub radii: Option<&'a [f64]>,
}

impl Probes<'_> {
    fn ball(&self, point: u32) -> Ball {
        let radius = self.radii.map_or(0.0, |radii| radii[point as usize]);
        Ball::new(self.points[point as usize], radius)
    }
}

/// How much work the last detection was.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Tests of four bounds against others, in the trees.
    pub bound_tests: u64,
    /// Tests of a point or ball against a primitive.
    pub leaf_tests: u64,
}

/// Finds the contacts of points or balls with the union of `medial`.
///
/// The particles of a contact are the point (its number in `probes`, plus
/// `first_point`) and the primitive's balls (their numbers plus `first_ball`).
/// Its offset is the sum of the radii; contacts stand in the order of the points,
/// the least gap first.
///
/// `sides`, if given, is used for points near the middle of the sheet and brought
/// up to date.
///
/// # Panics
///
/// When the trees, radii or sides are of other points or primitives.
pub fn contacts(
    probes: &Probes<'_>,
    medial: &MedialSurface,
    tree: &PrimitiveTree,
    reach: &Reach,
    particles: Particles,
    mut sides: Option<&mut Sides>,
    workspace: &mut Workspace,
) -> (Vec<Contact>, Counts) {
    let mut pairs = Vec::new();
    tree.tree().pairs(probes.tree, reach.reach, workspace, |primitive, point| {
        pairs.push((point, primitive));
    });
    let leaf_tests = pairs.len() as u64;
    let counts = Counts { bound_tests: workspace.counters().quad_tests, leaf_tests };
    pairs.sort_unstable();
    let mut out = Vec::new();
    for of_point in pairs.chunk_by(|(a, _), (b, _)| a == b) {
        let point = of_point[0].0;
        let mut found: Vec<Found> = Vec::new();
        for &(_, primitive) in of_point {
            let side = sides.as_ref().map_or(DVec3::ZERO, |sides| sides.of(point));
            let touch = Found::at(probes.ball(point), medial, primitive, reach.rule, side);
            if touch.gap <= reach.reach {
                keep(&mut found, touch, reach.most);
            }
        }
        if let (Some(sides), Some(nearest)) = (sides.as_deref_mut(), found.first()) {
            sides.0[point as usize] = nearest.normal;
        }
        out.extend(found.iter().map(|found| found.contact(point, medial, particles)));
    }
    (out, counts)
}

/// Numbers of the first point and the first ball among the caller's particles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Particles {
    /// Added to the numbers of points.
    pub first_point: u32,
    /// Added to the numbers of balls.
    pub first_ball: u32,
}

/// A point against one primitive.
#[derive(Clone, Copy, Debug)]
struct Found {
    primitive: u32,
    foot: Foot,
    radius: f64,
    normal: DVec3,
    gap: f64,
}

impl Found {
    fn at(ball: Ball, medial: &MedialSurface, primitive: u32, rule: FootRule, side: DVec3) -> Self {
        let p = ball.center;
        let foot = medial.foot(p, primitive, rule);
        let normal = normal(p, &foot, &medial.primitive_balls(primitive), side);
        // The height over the foot along the normal: the distance, or less where
        // the point is on the other side of the sheet than it was.
        let height = (p - foot.ball.center).dot(normal);
        let gap = height - foot.ball.radius - ball.radius;
        Self { primitive, foot, radius: ball.radius, normal, gap }
    }

    fn contact(&self, point: u32, medial: &MedialSurface, particles: Particles) -> Contact {
        let face =
            medial.primitives()[self.primitive as usize].map(|ball| ball + particles.first_ball);
        Contact {
            stencil: Stencil::vertex_face(point + particles.first_point, face, self.foot.weights),
            anchor: None,
            normal: self.normal,
            offset: self.foot.ball.radius + self.radius,
            gap: self.gap,
            time: None,
        }
    }
}

/// Direction from the foot to the point; mirrored at the sheet where the point
/// was last seen on its other side, and the sheet's own normal where point and
/// foot coincide.
fn normal(p: DVec3, foot: &Foot, balls: &[Ball; 3], side: DVec3) -> DVec3 {
    let [a, b, c] = balls.map(|ball| ball.center);
    let sheet = (b - a).cross(c - a).normalize_or_zero();
    match foot.normal(p) {
        Some(normal) => {
            let height = normal.dot(sheet);
            let passed = height * side.dot(sheet) < 0.0;
            if passed { normal - 2.0 * height * sheet } else { normal }
        }
        None if side != DVec3::ZERO => {
            let along = side.dot(sheet);
            if along == 0.0 { side } else { sheet * along.signum() }
        }
        None if sheet != DVec3::ZERO => sheet,
        None => (b - a).try_normalize().map_or(DVec3::Z, DVec3::any_orthonormal_vector),
    }
}

/// Keeps `touch` beside those with distinct normals, or in the place of one that
/// it is deeper than; the least gap first.
fn keep(found: &mut Vec<Found>, touch: Found, most: usize) {
    let alike = |other: &Found| other.normal.dot(touch.normal) > DISTINCT_COSINE;
    if found.iter().any(|other| alike(other) && other.gap <= touch.gap) {
        return;
    }
    found.retain(|other| !alike(other));
    let place = found.partition_point(|other| other.gap <= touch.gap);
    found.insert(place, touch);
    found.truncate(most);
}

/// Two primitives that come within reach of each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrimitiveContact {
    /// Number of the primitive of the first medial surface, then of the second.
    pub primitives: [u32; 2],
    /// Weights of the balls of each.
    pub weights: [[f64; 3]; 2],
    /// Unit vector from the second's ball to the first's; where their centres
    /// coincide, a normal of the second.
    pub normal: DVec3,
    /// Sum of the radii.
    pub offset: f64,
    /// Distance of the two balls, negative where they overlap.
    pub gap: f64,
}

impl PrimitiveContact {
    /// The particles with their weights β, as in [`Contact`]: those of the first
    /// medial surface (numbered from `particles.first_point`) sum to −1, those
    /// of the second (from `particles.first_ball`) to 1. At most six.
    #[must_use]
    pub fn terms(&self, a: &MedialSurface, b: &MedialSurface, particles: Particles) -> Vec<Term> {
        let side = |medial: &MedialSurface, k: usize, first: u32, sign: f64| {
            let balls = medial.primitives()[self.primitives[k] as usize];
            let terms = balls.into_iter().zip(self.weights[k]).filter(|&(_, w)| w > 0.0);
            terms
                .map(|(ball, w)| Term { particle: ball + first, weight: sign * w })
                .collect::<Vec<_>>()
        };
        let mut terms = side(a, 0, particles.first_point, -1.0);
        terms.extend(side(b, 1, particles.first_ball, 1.0));
        terms
    }
}

/// Finds all pairs of primitives of two medial surfaces whose unions come within
/// `reach`: what balls against primitives miss where only insides of primitives
/// meet.
///
/// The gap of each pair is the exact least distance or deepest overlap. Pairs
/// stand in ascending order.
#[must_use]
pub fn primitive_contacts(
    a: (&MedialSurface, &PrimitiveTree),
    b: (&MedialSurface, &PrimitiveTree),
    reach: f64,
    workspace: &mut Workspace,
) -> (Vec<PrimitiveContact>, Counts) {
    let mut pairs = Vec::new();
    a.1.tree().pairs(b.1.tree(), reach, workspace, |i, j| pairs.push([i, j]));
    let counts =
        Counts { bound_tests: workspace.counters().quad_tests, leaf_tests: pairs.len() as u64 };
    pairs.sort_unstable();
    let contact = |primitives: [u32; 2]| {
        let balls = b.0.primitive_balls(primitives[1]);
        let foot = pair_foot(&a.0.primitive_balls(primitives[0]), &balls);
        let on_b = Foot { weights: foot.weights_b, ball: foot.b, distance: foot.distance };
        PrimitiveContact {
            primitives,
            weights: [foot.weights_a, foot.weights_b],
            normal: normal(foot.a.center, &on_b, &balls, DVec3::ZERO),
            offset: foot.a.radius + foot.b.radius,
            gap: foot.distance,
        }
    };
    let found = pairs.into_iter().map(contact).filter(|c| c.gap <= reach).collect();
    (found, counts)
}
