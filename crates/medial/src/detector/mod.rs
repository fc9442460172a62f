//! Contact detector of a body by its medial surface: against vertices, other medial surfaces, and
//! rigid bodies by their distance.
//!
//! The depth of a point in a hundred balls, with the cones and slabs between them, is a closed
//! formula at a few slabs; no ray decides first whether it is inside. The balls follow the body as
//! it deforms, by the surface points that each of them touches.
//!
//! The balls are not particles of the caller, so their contacts are transferred to the surface:
//! the contact acts on the face where the deciding ball touches the body's surface along the
//! normal. So friction acts at the surface and not at the middle of the muscle. Where the union of
//! balls is wider than the surface there, the difference is the offset of the contact; where it is
//! narrower, the gap is that over the surface.
//!
//! Source: B. Gilles, *Anatomical and kinematical modelling of the musculoskeletal system using
//! MRI*, PhD thesis, 2007, section 4.7.2: collisions of medial surfaces. There, the medial surfaces
//! are particles of their own, tied to the surfaces by springs.

mod face_hints;
mod follow;
mod on_surface;
mod pairs;
mod rigid;
mod vertices;

use glam::DVec3;
use kdop::Workspace;
use proximity::{ContactSurface, ParticleNumbers, SurfaceTree};
use surface::progress::Progress;
use surface::{Contact, Positions, TriangleSurface};

use self::face_hints::FaceHints;
pub use self::rigid::{RigidDistance, RigidSide};
use crate::deviation::BoundSearch;
use crate::{
    CandidatePair, Deviation, FollowScratch, Generated, Links, MAX_CONTACTS, MedialError,
    MedialParams, MedialSurface, PointCandidates, PointContact, PrimitiveContact, PrimitiveTree,
    generate,
};

/// Body by its medial surface, which finds the contacts of others with it.
///
/// The balls are where the body was when it last [followed](Self::follow).
///
/// ```
/// use medial::{ContactBody, MedialDetector, MedialFeature, MedialParams, MedialScratch};
/// use proximity::{ParticleNumbers, SurfaceTree};
/// use surface::glam::DVec3;
/// use surface::progress::Progress;
///
/// let muscle = fixtures::shapes::ellipsoid(DVec3::new(60.0, 20.0, 10.0), 4);
/// let pin = fixtures::shapes::tetrahedron(3.0).translated(DVec3::new(7.0, 0.0, 11.0));
/// let mut muscle = SurfaceTree::new(muscle.surface(), muscle.positions)?;
/// let pin = SurfaceTree::new(pin.surface(), pin.positions)?;
///
/// let (surface, x) = (muscle.surface(), muscle.positions());
/// let params = MedialParams::balls(60);
/// let mut detector = MedialDetector::new(surface, x, 0.0, &params, Progress::none())?;
/// fn body(tree: &SurfaceTree, first: u32) -> ContactBody<'_> {
///     ContactBody { tree, particles: ParticleNumbers::from(first), is_rigid: false }
/// }
///
/// let mut scratch = MedialScratch::default();
/// let pin = body(&pin, 0);
/// let contacts = detector.vertex_contacts(&pin, &body(&muscle, 4), &mut scratch);
/// assert!(contacts.len() == 2 && contacts[0].contact.normal.z > 0.9);
///
/// // The muscle shortens and thickens, and the balls with it.
/// let short = muscle.positions().as_slice().to_vec();
/// muscle.set_positions(short.iter().map(|p| *p * DVec3::new(0.8, 1.118, 1.118)))?;
/// detector.follow(muscle.positions())?;
/// let deeper = detector.vertex_contacts(&pin, &body(&muscle, 4), &mut scratch);
/// assert!(deeper[0].contact.gap < contacts[0].contact.gap - 1.0);
/// assert!(matches!(deeper[0].feature, MedialFeature::Vertex(_)));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct MedialDetector {
    margin: f64,
    max_contacts: usize,
    medial: MedialSurface,
    tree: PrimitiveTree,
    links: Links,
    hints: FaceHints,
    scratch: FollowScratch,
    deviation: Deviation,
    /// Positions of the body that the balls were fitted to.
    fitted_positions: Vec<DVec3>,
    /// Bound on the surface outside the balls there, once computed.
    bound: Option<SurfaceBound>,
}

/// Bound on the distance of a surface outside balls.
#[derive(Clone, Copy, Debug)]
struct SurfaceBound {
    bound: f64,
    /// Bound up to which it did not have to be tight.
    limit: f64,
}

/// Body as one side of contacts, with the tree over its surface.
#[derive(Clone, Copy, Debug)]
pub struct ContactBody<'a> {
    /// The surface at its present positions.
    pub tree: &'a SurfaceTree,
    /// Numbers of its vertices.
    pub particles: ParticleNumbers<'a>,
    /// True if it does not yield: it is then an anchor, at rest.
    pub is_rigid: bool,
}

/// Contact with a medial surface.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct MedialContact {
    /// The contact, with the particles of both bodies.
    pub contact: Contact,
    /// The ball of the detector's medial surface that decides.
    pub ball: PrimitiveBall,
    /// Part of the other body that is in contact.
    pub feature: MedialFeature,
}

/// Part of a body that is in contact with a medial surface.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
#[non_exhaustive]
pub enum MedialFeature {
    /// A vertex, by its number in the surface.
    Vertex(u32),
    /// A ball of its medial surface.
    Ball(PrimitiveBall),
    /// A rigid body, by its distance.
    Rigid,
}

/// Ball between those of a primitive.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PrimitiveBall {
    /// Number of the primitive in its medial surface.
    pub primitive: u32,
    /// Weights of its balls, `>= 0`, with sum one.
    pub weights: [f64; 3],
}

/// Memory that is reused from pair to pair, one per thread.
#[derive(Debug, Default)]
pub struct MedialScratch {
    workspace: Workspace,
    pairs: Vec<CandidatePair>,
    primitive_pairs: Vec<[u32; 2]>,
    candidates: PointCandidates,
    points: Vec<PointContact>,
    primitives: Vec<PrimitiveContact>,
    bound: BoundSearch,
}

impl MedialDetector {
    /// Generates the medial surface of a body at rest.
    ///
    /// Gaps of at most `margin` are contacts: 0 reports the points inside the balls; the bounds of
    /// the [deviation](Self::deviation), added to the margin, report also those that may be inside
    /// the body.
    ///
    /// # Errors
    ///
    /// [`MedialError::Parameter`] when the margin is negative or not finite, and the errors of
    /// [`generate`].
    pub fn new(
        surface: &TriangleSurface,
        x: Positions<'_>,
        margin: f64,
        params: &MedialParams,
        progress: Progress<'_>,
    ) -> Result<Self, MedialError> {
        check_margin(margin)?;
        let generated = generate(surface, x, params, progress)?;
        Self::with_generated(surface, x, margin, generated)
    }

    /// Takes a medial surface of a body at rest, and measures its deviation.
    ///
    /// # Errors
    ///
    /// [`MedialError::Parameter`] when the margin is negative or not finite, and the errors of
    /// [`Deviation::measure`].
    pub fn from_medial(
        surface: &TriangleSurface,
        x: Positions<'_>,
        margin: f64,
        medial: MedialSurface,
    ) -> Result<Self, MedialError> {
        check_margin(margin)?;
        let deviation = Deviation::measure(&medial, surface, x)?;
        Self::with_generated(surface, x, margin, Generated { medial, deviation })
    }

    fn with_generated(
        surface: &TriangleSurface,
        x: Positions<'_>,
        margin: f64,
        Generated { medial, deviation }: Generated,
    ) -> Result<Self, MedialError> {
        let tree = PrimitiveTree::new(&medial)?;
        let links = Links::new(&medial, surface, x)?;
        Ok(Self {
            margin,
            max_contacts: 1,
            hints: FaceHints::new(&medial, surface, &links),
            medial,
            tree,
            links,
            scratch: FollowScratch::default(),
            deviation,
            fitted_positions: x.as_slice().to_vec(),
            bound: None,
        })
    }

    /// Keeps up to `max_contacts` contacts per vertex, `1..=`[`MAX_CONTACTS`], whose normals are
    /// 30° apart or more; otherwise the deepest is kept.
    ///
    /// More than one help a vertex in the edge of a groove. But slabs overlap in the middle of a
    /// body, where no border is, and their rims count as well.
    #[must_use]
    pub fn with_max_contacts(self, max_contacts: usize) -> Self {
        Self { max_contacts: max_contacts.clamp(1, MAX_CONTACTS), ..self }
    }

    /// Returns the gap up to which points are contacts.
    #[must_use]
    pub fn margin(&self) -> f64 {
        self.margin
    }

    /// Returns the medial surface, where the body was when it last followed.
    #[must_use]
    pub fn medial(&self) -> &MedialSurface {
        &self.medial
    }

    /// Returns the links between the balls and the body's vertices.
    #[must_use]
    pub fn links(&self) -> &Links {
        &self.links
    }

    /// Returns bounds on the deviation between medial surface and body, in both directions: at
    /// rest, or when [last measured](Self::measure).
    #[must_use]
    pub fn deviation(&self) -> &Deviation {
        &self.deviation
    }

    /// Returns the memory of its balls and of their links to the body's vertices, in bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        size_of_val(self.medial.balls())
            + size_of_val(self.medial.primitives())
            + size_of_val(self.links.links())
            + size_of_val(&self.fitted_positions[..])
    }
}

impl<'a> ContactBody<'a> {
    /// Returns the body without its tree.
    fn surface(&self) -> ContactSurface<'a> {
        ContactSurface {
            surface: self.tree.surface(),
            positions: self.tree.positions(),
            particles: self.particles,
            is_rigid: self.is_rigid,
        }
    }
}

fn check_margin(value: f64) -> Result<(), MedialError> {
    if value.is_finite() && value >= 0.0 {
        return Ok(());
    }
    Err(MedialError::Parameter { name: "margin", value, range: "finite and at least 0" })
}
