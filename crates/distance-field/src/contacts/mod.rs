//! Contacts of a surface with a rigid body that is given by its distance field.
//!
//! The tree over the surface leaves the faces near the rigid body; the field is evaluated
//! at their vertices. An edge between two vertices outside may still dip into the body: its
//! deepest point is found in closed form, so that no offset has to be guessed that keeps
//! edges out.
//!
//! Source: B. Gilles, *Anatomical and kinematical modelling of the musculoskeletal system
//! using MRI*, PhD thesis, 2007, section 4.7.2: rigid bodies as distance maps, contacts as
//! linear combinations of particles. There, vertices alone are tested, kept away by an
//! offset for the sake of edges.

mod bounds;
mod detector;
mod gradient;
mod search;

use surface::Contact;

pub use self::detector::{FieldDetector, FieldDistance};
pub use self::search::FieldContacts;

/// Contact of a vertex or an edge of a surface with a rigid body.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FieldContact {
    /// The contact, with the rigid body as its anchor. Its gap is the value of the field.
    pub contact: Contact,
    /// Part of the surface that is in contact.
    pub feature: FieldFeature,
    /// Length of the field's gradient: near 1 where the normal is reliable, less where
    /// several parts of the rigid body are equally near. Where it is 0, the normal points
    /// away from the center of the body's box.
    pub gradient_length: f64,
}

/// Part of a surface that is in contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum FieldFeature {
    /// A vertex, by its number in the surface.
    Vertex(u32),
    /// The interior of an edge, by its number in the surface, both of whose ends are
    /// outside the margin.
    Edge(u32),
}
