//! Permanent contact: a list of contacts carried from frame to frame instead
//! of detected anew.
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

/// Where a contact stands between its distances kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum ContactState {
    /// Closer than the clearance.
    Collision,
    /// Within the proximity distance of it.
    Proximity,
    /// Farther: to be dropped, or to be found by detection again.
    Left,
}

impl ContactState {
    /// State of a contact with this gap, in the caller's length unit.
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

/// What a gap is measured by when weights are kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum GapMeasure {
    /// By P_c along the normal, which turns with the face or the edges.
    AlongNormal,
    /// By the length of P_c: for medial contacts.
    Length,
}

/// What carries the faces that contacts slide on.
#[derive(Clone, Copy, Debug, PartialEq)]
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
pub struct RigidMotion {
    /// A point of it, and the other fields are its state there.
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
    /// State of the object at `point`.
    #[must_use]
    pub fn at(&self, point: DVec3) -> Anchor {
        let arm = point - self.about;
        let turning = self.spin.cross(arm);
        Anchor {
            point,
            velocity: self.velocity + turning,
            acceleration: self.acceleration
                + self.spin_change.cross(arm)
                + self.spin.cross(turning),
        }
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
    /// Each normal in the frame that carries it, where there is one.
    local_normals: Vec<Option<DVec3>>,
    /// Face that each contact slid to last.
    faces: Vec<Option<u32>>,
    measure: GapMeasure,
    margins: Margins,
}

impl PermanentContacts {
    /// Keeps `contacts`, found at positions `x` of all particles.
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
        for (number, contact) in contacts.iter().enumerate() {
            check_contact(number, contact, x.len())?;
        }
        let local = |contact: &Contact| {
            carrying_frame(&contact.stencil, x).map(|frame| frame.to_local(contact.normal))
        };
        Ok(Self {
            contacts: contacts.to_vec(),
            states: contacts.iter().map(|c| ContactState::of(c.gap, margins)).collect(),
            local_normals: contacts.iter().map(local).collect(),
            faces: vec![None; contacts.len()],
            measure,
            margins,
        })
    }

    /// The contacts, in the order given.
    #[must_use]
    pub fn contacts(&self) -> &[Contact] {
        &self.contacts
    }

    /// State of each contact.
    #[must_use]
    pub fn states(&self) -> &[ContactState] {
        &self.states
    }

    /// Says where each contact's rigid object is now: `update` is given the
    /// contact's number, its anchor and its normal, to be changed together.
    /// Effective at the next [`Self::stick`].
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
    /// - [`ResponseError::ParticleNotFinite`] with the first such position;
    /// - [`ResponseError::ParticleOutOfRange`] when there are fewer than at
    ///   first;
    /// - [`ResponseError::Normal`] or [`ResponseError::ContactNotFinite`] when
    ///   an anchor or a normal was moved to what is none.
    pub fn stick(&mut self, x: &[DVec3]) -> Result<(), ResponseError> {
        check::particles("position", x.len(), x)?;
        for number in 0..self.contacts.len() {
            check_contact(number, &self.contacts[number], x.len())?;
            self.stick_one(number, x);
        }
        Ok(())
    }

    /// Recomputes each contact by walking over `surface`, whose vertices are at
    /// `on` and move with `carrier`, from where it was.
    ///
    /// A contact that has slid before starts from the face it slid to, one
    /// whose stencil holds a face of the surface from that one, and any other
    /// from face 0. A contact of two edges stays with them, at their closest
    /// points. Offsets are kept.
    ///
    /// # Errors
    ///
    /// As [`Self::stick`], and [`ResponseError::Count`] when P is a combination
    /// of several particles and slides onto particles: those are more than a
    /// contact holds.
    pub fn slide(
        &mut self,
        x: &[DVec3],
        surface: &TriangleSurface,
        on: Positions<'_>,
        carrier: SurfaceCarrier,
    ) -> Result<(), ResponseError> {
        check::particles("position", x.len(), x)?;
        for number in 0..self.contacts.len() {
            check_contact(number, &self.contacts[number], x.len())?;
            if is_of_edges(&self.contacts[number].stencil) {
                self.slide_along_edges(number, x);
                continue;
            }
            let point = -self.point_side(number).combine(|k| x[k as usize]);
            let start = self.start_face(number, surface, carrier);
            if let Some(foot) = walk_to_foot(surface, on, start, point) {
                self.stand_on(number, surface, &foot, carrier)?;
            }
        }
        Ok(())
    }

    /// Drops the contacts that were left, and returns how many they were.
    pub fn drop_left(&mut self) -> usize {
        let kept: Vec<usize> =
            (0..self.states.len()).filter(|&i| self.states[i] != ContactState::Left).collect();
        let left = self.states.len() - kept.len();
        self.contacts = kept.iter().map(|&i| self.contacts[i]).collect();
        self.local_normals = kept.iter().map(|&i| self.local_normals[i]).collect();
        self.faces = kept.iter().map(|&i| self.faces[i]).collect();
        self.states = kept.iter().map(|&i| self.states[i]).collect();
        left
    }

    fn stick_one(&mut self, number: usize, x: &[DVec3]) {
        let contact = &mut self.contacts[number];
        let frame = carrying_frame(&contact.stencil, x);
        if let (Some(frame), Some(local)) = (frame, self.local_normals[number]) {
            contact.normal = frame.to_world(local);
        }
        let separation = contact.separation(|k| x[k as usize]);
        if self.measure == GapMeasure::Length {
            contact.normal = (-separation).try_normalize().unwrap_or(contact.normal);
        }
        contact.gap = -separation.dot(contact.normal) - contact.offset;
        self.states[number] = ContactState::of(contact.gap, self.margins);
    }

    fn slide_along_edges(&mut self, number: usize, x: &[DVec3]) {
        let contact = &mut self.contacts[number];
        let [a0, a1, b0, b1] = std::array::from_fn(|k| contact.stencil.terms()[k].particle);
        let edge = |ends: [u32; 2]| ends.map(|k| x[k as usize]);
        let closest = closest_between_segments(edge([a0, a1]), edge([b0, b1]));
        contact.stencil = Stencil::edge_edge([a0, a1], closest.s, [b0, b1], closest.t);
        let away = closest.points[0] - closest.points[1];
        let side = if away.dot(contact.normal) < 0.0 { -1.0 } else { 1.0 };
        contact.normal = (side * away).try_normalize().unwrap_or(contact.normal);
        contact.gap = away.dot(contact.normal) - contact.offset;
        self.states[number] = ContactState::of(contact.gap, self.margins);
    }

    /// Terms of P, whose weights sum to −1.
    fn point_side(&self, number: usize) -> Stencil {
        let stencil = self.contacts[number].stencil;
        let terms = point_terms(&stencil);
        Stencil::new(&terms).unwrap_or(stencil)
    }

    fn start_face(&self, number: usize, surface: &TriangleSurface, carrier: SurfaceCarrier) -> u32 {
        let from_stencil = || match carrier {
            SurfaceCarrier::Particles { first } => {
                face_of(&self.contacts[number].stencil, surface, first)
            }
            SurfaceCarrier::Rigid(_) => None,
        };
        self.faces[number].or_else(from_stencil).unwrap_or(0)
    }

    fn stand_on(
        &mut self,
        number: usize,
        surface: &TriangleSurface,
        foot: &SurfaceFoot,
        carrier: SurfaceCarrier,
    ) -> Result<(), ResponseError> {
        let mut terms = point_terms(&self.contacts[number].stencil);
        let contact = &mut self.contacts[number];
        match carrier {
            SurfaceCarrier::Rigid(motion) => contact.anchor = Some(motion.at(foot.point)),
            SurfaceCarrier::Particles { first } => {
                let corners = surface.faces()[foot.face as usize];
                let of_corner = |(&corner, &weight)| Term { particle: first + corner, weight };
                terms.extend(corners.iter().zip(&foot.barycentric).map(of_corner));
                contact.anchor = None;
            }
        }
        let of_p = point_terms(&contact.stencil).len();
        let too_many =
            ResponseError::Count { what: "particles on the side of P", expected: 1, got: of_p };
        contact.stencil = Stencil::new(&terms).ok_or(too_many)?;
        contact.normal = foot.normal;
        contact.gap = foot.height - contact.offset;
        self.faces[number] = Some(foot.face);
        self.states[number] = ContactState::of(contact.gap, self.margins);
        Ok(())
    }
}

/// Axes that turn with what carries a contact's normal: three particles of a
/// face, or two and two of edges.
fn carrying_frame(stencil: &Stencil, x: &[DVec3]) -> Option<FaceFrame> {
    let at = |term: &Term| x[term.particle as usize];
    match stencil.terms() {
        [_, a, b, c] if !is_of_edges(stencil) => FaceFrame::new([at(a), at(b), at(c)]),
        [a0, a1, b0, b1] => FaceFrame::new([at(b0), at(b1), at(b0) + at(a1) - at(a0)]),
        _ => None,
    }
}

/// Whether both P and P̄ are points of edges. The sign of a weight tells its
/// side, also that of a zero.
fn is_of_edges(stencil: &Stencil) -> bool {
    matches!(stencil.terms(), [_, second, _, _] if second.weight.is_sign_negative())
}

/// Terms on the side of P.
fn point_terms(stencil: &Stencil) -> Vec<Term> {
    let terms = stencil.terms().iter();
    terms.take_while(|term| term.weight.is_sign_negative()).copied().collect()
}

/// The face of the surface that holds all corners of the side of P̄.
fn face_of(stencil: &Stencil, surface: &TriangleSurface, first: u32) -> Option<u32> {
    let of_p = point_terms(stencil).len();
    let corners: Vec<u32> = stencil.terms()[of_p..]
        .iter()
        .filter_map(|term| term.particle.checked_sub(first))
        .filter(|&vertex| (vertex as usize) < surface.vertex_count())
        .collect();
    let around = surface.vertex_faces(*corners.first()?);
    let holds = |face: &u32| corners.iter().all(|c| surface.faces()[*face as usize].contains(c));
    around.iter().copied().find(holds).or_else(|| around.first().copied())
}

fn check_contact(
    number: usize,
    contact: &Contact,
    particle_count: usize,
) -> Result<(), ResponseError> {
    let anchor = contact.anchor.unwrap_or_default();
    check::contact_vector(number, "anchor", anchor.point)?;
    check::normal(number, contact.normal)?;
    for term in contact.stencil.terms() {
        check::contact_number(number, "weight", term.weight)?;
        if term.particle as usize >= particle_count {
            let particle = term.particle;
            return Err(ResponseError::ParticleOutOfRange {
                contact: number,
                particle,
                particle_count,
            });
        }
    }
    Ok(())
}
