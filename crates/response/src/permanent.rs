//! Permanent contact: a list of contacts carried from frame to frame instead
//! of being detected again.
//!
//! Source: B. Gilles, PhD thesis, 2007, section 4.7.2: P_c is recomputed with
//! the same weights (sticking), or the contact's parameters are recomputed
//! (sliding), here by walking over the surface; its state then follows from the
//! length of P_c for medial contacts, or from its sign along the normal.

use glam::DVec3;
use surface::{
    Anchor, Contact, Positions, Stencil, Term, TriangleSurface, closest_between_segments,
};

use crate::{FaceFrame, Margins, ResponseError, SurfaceFoot, check, walk_to_foot};

/// State of a contact relative to the distances kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum ContactState {
    /// Closer than the clearance.
    Collision,
    /// Within the proximity distance of it.
    Proximity,
    /// Farther: to be dropped, or to be detected again.
    Left,
}

impl ContactState {
    /// Returns the state of a contact with this gap, in the caller's length unit.
    #[must_use]
    pub fn of(gap: f64, margins: Margins) -> Self {
        if gap < margins.clearance() {
            Self::Collision
        } else if gap < margins.clearance() + margins.proximity() {
            Self::Proximity
        } else {
            Self::Left
        }
    }
}

/// Measure of a gap when weights are kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum GapMeasure {
    /// P_c along the normal, which turns with the face or the edges.
    AlongNormal,
    /// Length of P_c: for medial contacts.
    Length,
}

/// Carrier of the faces that contacts slide on.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum SurfaceCarrier {
    /// Particles: the surface's vertices are numbered from `first`.
    Particles {
        /// Particle of vertex 0.
        first: u32,
    },
    /// A rigid object in motion.
    Rigid(RigidMotion),
}

/// Motion of a rigid object.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RigidMotion {
    /// Point of the object at which the other fields hold.
    pub about: DVec3,
    /// Velocity.
    pub velocity: DVec3,
    /// Acceleration.
    pub acceleration: DVec3,
    /// Angular velocity \[1 / time\].
    pub spin: DVec3,
    /// Angular acceleration \[1 / time²\].
    pub spin_change: DVec3,
}

impl RigidMotion {
    /// Computes the state of the object at `point`.
    #[must_use]
    pub fn at(&self, point: DVec3) -> Anchor {
        let arm = point - self.about;
        let turning = self.spin.cross(arm);
        let velocity = self.velocity + turning;
        let acceleration =
            self.acceleration + self.spin_change.cross(arm) + self.spin.cross(turning);
        Anchor { point, velocity, acceleration }
    }
}

/// Contacts that persist, with the state of each.
///
/// ```
/// use glam::DVec3;
/// use response::{ContactState, Margins, GapMeasure, PermanentContacts};
/// use surface::{Contact, Stencil};
///
/// // Particle 0 at 0.1 over the face of particles 1, 2, 3.
/// let mut x = [DVec3::new(0.2, 0.2, 0.1), DVec3::ZERO, DVec3::X, DVec3::Y];
/// let contact = Contact {
///     stencil: Stencil::vertex_face(0, [1, 2, 3], [0.6, 0.2, 0.2]),
///     anchor: None, normal: DVec3::Z, offset: 0.0, gap: 0.1, time: None,
/// };
/// let margins = Margins::new(0.0, 1.0)?;
/// let mut permanent = PermanentContacts::new(&[contact], &x, GapMeasure::AlongNormal, margins)?;
/// x[0].z = -0.3;
/// permanent.stick(&x)?;
/// assert_eq!(permanent.states(), [ContactState::Collision]);
/// assert!((permanent.contacts()[0].gap + 0.3).abs() < 1e-15);
/// # Ok::<(), response::ResponseError>(())
/// ```
#[derive(Clone, Debug)]
pub struct PermanentContacts {
    contacts: Vec<Contact>,
    states: Vec<ContactState>,
    tracks: Vec<Track>,
    /// Contacts of a slide before they replace the others, `None` where there is no face.
    slid: Vec<Option<Slid>>,
    measure: GapMeasure,
    margins: Margins,
}

/// Data that carries one contact to the next frame.
#[derive(Clone, Copy, Debug)]
struct Track {
    /// Its normal in the frame that carries it, where there is one.
    local_normal: Option<DVec3>,
    /// Face that it slid to last.
    face: Option<u32>,
}

/// Contact after a slide.
#[derive(Clone, Copy, Debug)]
struct Slid {
    contact: Contact,
    /// Face that it is on now; `None` for a contact of two edges.
    face: Option<u32>,
}

impl PermanentContacts {
    /// Keeps `contacts`, detected at positions `x` of all particles.
    ///
    /// # Errors
    ///
    /// As [`Self::stick`], for contacts and positions that are refused.
    pub fn new(
        contacts: &[Contact],
        x: &[DVec3],
        measure: GapMeasure,
        margins: Margins,
    ) -> Result<Self, ResponseError> {
        check::particles("position", x.len(), x)?;
        let (mut kept, capacity) = (Self::empty(measure, margins), contacts.len());
        kept.contacts.reserve_exact(capacity);
        kept.states.reserve_exact(capacity);
        kept.tracks.reserve_exact(capacity);
        for contact in contacts {
            kept.push(contact, None, x)?;
        }
        Ok(kept)
    }

    /// Returns a list without contacts.
    #[must_use]
    pub fn empty(measure: GapMeasure, margins: Margins) -> Self {
        let (contacts, states, tracks) = (Vec::new(), Vec::new(), Vec::new());
        Self { contacts, states, tracks, slid: Vec::new(), measure, margins }
    }

    /// Removes all contacts, and sets the margins of those to come; the memory is kept.
    pub fn clear(&mut self, margins: Margins) {
        self.contacts.clear();
        self.states.clear();
        self.tracks.clear();
        self.margins = margins;
    }

    /// Adds a contact, detected at positions `x` of all particles. Its first walk starts from
    /// `face`, where the detector that found it knows one: of contacts on a rigid object, the
    /// stencil has no face.
    ///
    /// # Errors
    ///
    /// As [`Self::stick`], for a contact that is refused.
    pub fn push(
        &mut self,
        contact: &Contact,
        face: Option<u32>,
        x: &[DVec3],
    ) -> Result<(), ResponseError> {
        check_contact(self.contacts.len(), contact, x.len())?;
        self.tracks.push(Track { local_normal: None, face });
        self.states.push(ContactState::of(contact.gap, self.margins));
        self.contacts.push(*contact);
        self.keep_normal(self.contacts.len() - 1, x);
        Ok(())
    }

    /// Returns the contacts, in the order given.
    #[must_use]
    pub fn contacts(&self) -> &[Contact] {
        &self.contacts
    }

    /// Returns the state of each contact.
    #[must_use]
    pub fn states(&self) -> &[ContactState] {
        &self.states
    }

    /// Returns the face that a contact slid to last, or that it was added with.
    ///
    /// # Panics
    ///
    /// When there is no such contact.
    #[must_use]
    pub fn face(&self, number: usize) -> Option<u32> {
        self.tracks[number].face
    }

    /// Moves each contact's rigid object: `update` receives the contact's number, its
    /// anchor and its normal, to be changed together. Effective at the next
    /// [`Self::stick`].
    pub fn move_anchors(&mut self, mut update: impl FnMut(usize, &mut Anchor, &mut DVec3)) {
        for (number, contact) in self.contacts.iter_mut().enumerate() {
            if let Some(anchor) = &mut contact.anchor {
                update(number, anchor, &mut contact.normal);
            }
        }
    }

    /// Recomputes each contact with the same weights at positions `x`.
    ///
    /// # Errors
    ///
    /// No contact is changed then.
    ///
    /// - [`ResponseError::ParticleNotFinite`] with the first such position;
    /// - [`ResponseError::ParticleOutOfRange`] when there are fewer than at
    ///   first;
    /// - [`ResponseError::Normal`] or [`ResponseError::ContactNotFinite`] when
    ///   an anchor or a normal was moved to an invalid value.
    pub fn stick(&mut self, x: &[DVec3]) -> Result<(), ResponseError> {
        check::particles("position", x.len(), x)?;
        for (number, contact) in self.contacts.iter().enumerate() {
            check_contact(number, contact, x.len())?;
        }
        for number in 0..self.contacts.len() {
            self.stick_one(number, x);
        }
        Ok(())
    }

    /// Recomputes each contact by walking over `surface`, whose vertices are at
    /// `on` and move with `carrier`, from its last face.
    ///
    /// A contact that has slid before starts from the face it slid to, one
    /// whose stencil holds a face of the surface from that one, and any other
    /// from face 0. A contact of two edges stays with them, at their closest
    /// points. Offsets are kept.
    ///
    /// # Errors
    ///
    /// As [`Self::stick`], [`ResponseError::ParticleOutOfRange`] where the surface has vertices that are
    /// no particles, and [`ResponseError::Count`] when P is a combination of several particles and
    /// slides onto particles: more than a contact holds. No contact is changed then.
    pub fn slide(
        &mut self,
        x: &[DVec3],
        surface: &TriangleSurface,
        on: Positions<'_>,
        carrier: SurfaceCarrier,
    ) -> Result<(), ResponseError> {
        check::particles("position", x.len(), x)?;

        // All of them first, so that an error changes none.
        let mut slid = std::mem::take(&mut self.slid);
        let result = self.slide_all(x, surface, on, carrier, &mut slid);
        if result.is_ok() {
            for (number, slid) in slid.iter().enumerate() {
                if let Some(slid) = slid {
                    self.replace(number, slid, x);
                }
            }
        }
        self.slid = slid;
        result
    }

    /// Drops the contacts that were left, and returns their number.
    pub fn drop_left(&mut self) -> usize {
        // Move the contacts that stay to the front, in order.
        let mut kept = 0;
        for number in 0..self.states.len() {
            if self.states[number] != ContactState::Left {
                self.contacts[kept] = self.contacts[number];
                self.states[kept] = self.states[number];
                self.tracks[kept] = self.tracks[number];
                kept += 1;
            }
        }
        let left = self.states.len() - kept;
        self.contacts.truncate(kept);
        self.states.truncate(kept);
        self.tracks.truncate(kept);
        left
    }

    /// Recomputes one contact with the same weights.
    fn stick_one(&mut self, number: usize, x: &[DVec3]) {
        // The normal turns with its carrier; the weights stay.
        let contact = &mut self.contacts[number];
        let frame = carrying_frame(&contact.stencil, x);
        if let (Some(frame), Some(local)) = (frame, self.tracks[number].local_normal) {
            contact.normal = frame.to_world(local);
        }

        // The gap along the normal, which for medial contacts follows P_c.
        let separation = contact.separation(|k| x[k as usize]);
        if self.measure == GapMeasure::Length {
            contact.normal = (-separation).try_normalize().unwrap_or(contact.normal);
        }
        contact.gap = -separation.dot(contact.normal) - contact.offset;
        self.states[number] = ContactState::of(contact.gap, self.margins);
    }

    /// Stores the normal of a contact in the frame that carries it.
    fn keep_normal(&mut self, number: usize, x: &[DVec3]) {
        let contact = &self.contacts[number];
        let frame = carrying_frame(&contact.stencil, x);
        self.tracks[number].local_normal = frame.map(|frame| frame.to_local(contact.normal));
    }

    /// Computes each contact after a slide.
    fn slide_all(
        &self,
        x: &[DVec3],
        surface: &TriangleSurface,
        on: Positions<'_>,
        carrier: SurfaceCarrier,
        slid: &mut Vec<Option<Slid>>,
    ) -> Result<(), ResponseError> {
        slid.clear();
        for (number, contact) in self.contacts.iter().enumerate() {
            check_contact(number, contact, x.len())?;
            if is_of_edges(&contact.stencil) {
                slid.push(Some(Slid { contact: slid_along_edges(contact, x), face: None }));
                continue;
            }

            // A step moves little, so the last face is a good start of the walk.
            let start = self.start_face(number, surface, carrier);
            slid.push(match walk_to_foot(surface, on, start, point(contact, x)) {
                Some(foot) => {
                    let contact = on_foot(number, contact, surface, &foot, carrier, x.len())?;
                    Some(Slid { contact, face: Some(foot.face) })
                }
                None => None,
            });
        }
        Ok(())
    }

    /// Replaces a contact by what it has slid to.
    fn replace(&mut self, number: usize, slid: &Slid, x: &[DVec3]) {
        self.contacts[number] = slid.contact;
        self.states[number] = ContactState::of(slid.contact.gap, self.margins);
        self.tracks[number].face = slid.face.or(self.tracks[number].face);
        self.keep_normal(number, x);
    }

    /// Returns the face to walk from.
    fn start_face(&self, number: usize, surface: &TriangleSurface, carrier: SurfaceCarrier) -> u32 {
        let of_stencil = match carrier {
            SurfaceCarrier::Particles { first } => {
                face_of(&self.contacts[number].stencil, surface, first)
            }
            SurfaceCarrier::Rigid(_) => None,
        };
        self.tracks[number].face.or(of_stencil).unwrap_or(0)
    }
}

/// Computes P of a contact, whose weights sum to −1.
fn point(contact: &Contact, x: &[DVec3]) -> DVec3 {
    let terms = point_terms(&contact.stencil);
    -terms.iter().map(|term| term.weight * x[term.particle as usize]).sum::<DVec3>()
}

/// Returns a contact of two edges at their closest points.
fn slid_along_edges(contact: &Contact, x: &[DVec3]) -> Contact {
    // Both points are free along their edges.
    let [a0, a1, b0, b1] = std::array::from_fn(|k| contact.stencil.terms()[k].particle);
    let edge = |ends: [u32; 2]| ends.map(|k| x[k as usize]);
    let closest = closest_between_segments(edge([a0, a1]), edge([b0, b1]));
    let stencil = Stencil::edge_edge([a0, a1], closest.s, [b0, b1], closest.t);

    // The normal keeps its side of the edges.
    let away = closest.points[0] - closest.points[1];
    let side = if away.dot(contact.normal) < 0.0 { -1.0 } else { 1.0 };
    let normal = (side * away).try_normalize().unwrap_or(contact.normal);
    Contact { stencil, normal, gap: away.dot(normal) - contact.offset, ..*contact }
}

/// Returns a contact with P̄ at a foot on the surface.
fn on_foot(
    number: usize,
    contact: &Contact,
    surface: &TriangleSurface,
    foot: &SurfaceFoot,
    carrier: SurfaceCarrier,
    particle_count: usize,
) -> Result<Contact, ResponseError> {
    // The side of P stays; the foot replaces the side of P̄.
    let of_p = point_terms(&contact.stencil);
    let (stencil, anchor) = match carrier {
        SurfaceCarrier::Rigid(motion) => (Stencil::new(of_p), Some(motion.at(foot.point))),
        SurfaceCarrier::Particles { first } => {
            let corners =
                surface.faces()[foot.face as usize].map(|corner| first.saturating_add(corner));
            check::particle_range(number, corners, particle_count)?;

            // A zero has the sign of its side: with −0, the sum is the positive zero.
            let [a, b, c] =
                [0, 1, 2].map(|k| Term { particle: corners[k], weight: foot.barycentric[k] + 0.0 });
            let stencil = match *of_p {
                [p] => Stencil::new(&[p, a, b, c]),
                [p, q] => Stencil::new(&[p, q, a, b, c]),
                _ => None,
            };
            (stencil, None)
        }
    };

    let (what, got) = ("particles on the side of P", of_p.len());
    let stencil = stencil.ok_or(ResponseError::Count { what, expected: 1, got })?;
    let gap = foot.height - contact.offset;
    Ok(Contact { stencil, anchor, normal: foot.normal, gap, ..*contact })
}

/// Computes the frame that carries a contact's normal: of the three particles of a face,
/// or of two and two of edges.
fn carrying_frame(stencil: &Stencil, x: &[DVec3]) -> Option<FaceFrame> {
    let at = |term: &Term| x[term.particle as usize];
    match stencil.terms().split_at(point_terms(stencil).len()) {
        (_, [a, b, c]) => FaceFrame::new([at(a), at(b), at(c)]),
        ([a0, a1], [b0, b1]) => FaceFrame::new([at(b0), at(b1), at(b0) + at(a1) - at(a0)]),
        _ => None,
    }
}

/// Returns true if both P and P̄ are points of edges.
fn is_of_edges(stencil: &Stencil) -> bool {
    (stencil.terms().len(), point_terms(stencil).len()) == (4, 2)
}

/// Returns the terms on the side of P. The sign of a weight decides its side, also that of a zero.
fn point_terms(stencil: &Stencil) -> &[Term] {
    let terms = stencil.terms();
    let count = terms.iter().take_while(|term| term.weight.is_sign_negative()).count();
    &terms[..count]
}

/// Finds the face of the surface with all corners of the side of P̄.
fn face_of(stencil: &Stencil, surface: &TriangleSurface, first: u32) -> Option<u32> {
    let mut corners = Vec::new();
    for term in &stencil.terms()[point_terms(stencil).len()..] {
        let vertex = term.particle.checked_sub(first);
        corners.extend(vertex.filter(|v| (*v as usize) < surface.vertex_count()));
    }
    let around = surface.vertex_faces(*corners.first()?);
    let holds_all =
        |face: &&u32| corners.iter().all(|c| surface.faces()[**face as usize].contains(c));
    around.iter().find(holds_all).or_else(|| around.first()).copied()
}

fn check_contact(
    number: usize,
    contact: &Contact,
    particle_count: usize,
) -> Result<(), ResponseError> {
    check::contact_vector(number, "anchor", contact.anchor.unwrap_or_default().point)?;
    check::normal(number, contact.normal)?;
    for term in contact.stencil.terms() {
        check::contact_number(number, "weight", term.weight)?;
        check::particle_range(number, [term.particle], particle_count)?;
    }
    Ok(())
}
