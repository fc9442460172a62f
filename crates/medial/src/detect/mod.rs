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
//!   with the closest center, and up to three with distinct normals: in a groove
//!   one is not enough;
//! - the foot on a slab is the exact one, unless the bare face is asked for;
//! - a point at the very center of a ball, or that passed the middle of the sheet
//!   since it was last seen, is told by the normal it was last seen under.

mod primitives;
mod probe;
mod sieve;

use glam::DVec3;
use kdop::{Tree, Workspace};
use surface::{Contact, Stencil};

pub use self::primitives::{PrimitiveContact, primitive_contacts, primitive_contacts_among};
use self::probe::PointQuery;
use self::sieve::SeparatingDirections;
use crate::{Ball, Foot, FootRule, MedialSurface, PrimitiveTree};

/// Contacts that a point keeps at most: what a groove with three sides needs.
pub const MAX_CONTACTS: usize = 3;

/// What counts as a contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MedialContactParams {
    /// Gap up to which a contact is reported, `>= 0`.
    pub margin: f64,
    /// Which ball of a primitive is compared.
    pub rule: FootRule,
    /// Contacts kept for each point, `1..=`[`MAX_CONTACTS`].
    pub max_contacts: usize,
}

impl MedialContactParams {
    /// Exact feet and up to [`MAX_CONTACTS`] contacts a point.
    #[must_use]
    pub const fn new(margin: f64) -> Self {
        Self { margin, rule: FootRule::Exact, max_contacts: MAX_CONTACTS }
    }
}

/// Where each point of one object was last seen from another one: the unit
/// normal of its contact, or zero.
///
/// Kept from one step to the next, it tells a point that passed the middle of
/// the other object's sheet from one that came from the other side.
#[derive(Clone, Debug, PartialEq)]
pub struct PreviousNormals(Vec<DVec3>);

impl PreviousNormals {
    /// [`PreviousNormals`] of `points` points, none known yet.
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
pub struct QueryPoints<'a> {
    /// Tree over them, one leaf each, in their order.
    pub tree: &'a Tree,
    /// Their positions.
    pub points: &'a [DVec3],
    /// Their radii; none for the points of a surface, which have no extent.
    pub radii: Option<&'a [f64]>,
}

impl QueryPoints<'_> {
    fn ball(&self, point: u32) -> Ball {
        let radius = self.radii.map_or(0.0, |radii| radii[point as usize]);
        Ball::new(self.points[point as usize], radius)
    }
}

/// How much work the last detection was.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TestCounts {
    /// Tests of four bounds against others, in the trees.
    pub bound_tests: u64,
    /// Tests of a direction that may part a point or a primitive from a primitive.
    pub direction_tests: u64,
    /// Tests of a point, a ball or a primitive against a primitive: their distance.
    pub leaf_tests: u64,
}

/// A point or ball in or near a medial surface, and the ball of a primitive that
/// decides how deep or how near.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointContact {
    /// The point.
    pub point: u32,
    /// The primitive.
    pub primitive: u32,
    /// The primitive's ball and its weights.
    pub foot: Foot,
    /// Unit vector from that ball's center to the point; see [`PreviousNormals`].
    pub normal: DVec3,
    /// Sum of the radii of that ball and the point's own.
    pub offset: f64,
    /// Height of the point over the ball's center less the offset.
    pub gap: f64,
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
pub fn point_contacts(
    probes: &QueryPoints<'_>,
    medial: &MedialSurface,
    tree: &PrimitiveTree,
    params: &MedialContactParams,
    particles: ParticleOffsets,
    sides: Option<&mut PreviousNormals>,
    workspace: &mut Workspace,
) -> (Vec<Contact>, TestCounts) {
    let mut pairs = Vec::new();
    tree.tree().pairs(probes.tree, params.margin, workspace, |primitive, point| {
        pairs.push((point, primitive));
    });
    let bound_tests = workspace.counters().bound_tests;
    let mut found = Vec::new();
    let counts = point_contacts_among(
        &mut pairs,
        |point| probes.ball(point),
        medial,
        params,
        sides,
        &mut found,
    );
    let contacts = found.iter().map(|found| found.contact(medial, particles)).collect();
    (contacts, TestCounts { bound_tests, ..counts })
}

/// As [`point_contacts`], among pairs of a point and a primitive that the caller found,
/// and with memory that is the caller's: `pairs` is sorted, and what `out` held is
/// lost. `ball` tells a point's position, and its radius or 0. The bounds that were
/// tested are not counted.
///
/// # Panics
///
/// When there is no such primitive, or the sides are of fewer points.
pub fn point_contacts_among(
    pairs: &mut Vec<(u32, u32)>,
    ball: impl Fn(u32) -> Ball,
    medial: &MedialSurface,
    params: &MedialContactParams,
    mut sides: Option<&mut PreviousNormals>,
    out: &mut Vec<PointContact>,
) -> TestCounts {
    pairs.sort_unstable();
    pairs.dedup();
    out.clear();
    let mut sieve = SeparatingDirections::default();
    for of_point in pairs.chunk_by(|(a, _), (b, _)| a == b) {
        let (point, first) = (of_point[0].0, out.len());
        let probe = PointQuery {
            ball: ball(point),
            side: sides.as_ref().map_or(DVec3::ZERO, |sides| sides.of(point)),
        };
        if params.max_contacts == 1 && probe.side == DVec3::ZERO {
            out.extend(probe.deepest(of_point, medial, params, &mut sieve));
        } else {
            probe.all(of_point, medial, params, &mut sieve, out);
        }
        if let (Some(sides), Some(nearest)) = (sides.as_deref_mut(), out.get(first)) {
            sides.0[point as usize] = nearest.normal;
        }
    }
    TestCounts { bound_tests: 0, direction_tests: sieve.tests, leaf_tests: sieve.leaf_tests }
}

/// Numbers of the first point and the first ball among the caller's particles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ParticleOffsets {
    /// Added to the numbers of points.
    pub first_point: u32,
    /// Added to the numbers of balls.
    pub first_ball: u32,
}

impl PointContact {
    fn of(
        (point, primitive): (u32, u32),
        ball: Ball,
        medial: &MedialSurface,
        rule: FootRule,
        side: DVec3,
    ) -> Self {
        let p = ball.center;
        let foot = medial.foot(p, primitive, rule);
        let normal = normal(p, &foot, &medial.primitive_balls(primitive), side);
        // The height over the foot along the normal: the distance, or less where
        // the point is on the other side of the sheet than it was.
        let height = (p - foot.ball.center).dot(normal);
        let offset = foot.ball.radius + ball.radius;
        Self { point, primitive, foot, normal, offset, gap: height - offset }
    }

    /// The contact between the point and the primitive's balls as particles.
    ///
    /// # Panics
    ///
    /// When `medial` has no such primitive.
    #[must_use]
    pub fn contact(&self, medial: &MedialSurface, particles: ParticleOffsets) -> Contact {
        let face =
            medial.primitives()[self.primitive as usize].map(|ball| ball + particles.first_ball);
        let point = self.point + particles.first_point;
        Contact {
            stencil: Stencil::vertex_face(point, face, self.foot.weights),
            anchor: None,
            normal: self.normal,
            offset: self.offset,
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
