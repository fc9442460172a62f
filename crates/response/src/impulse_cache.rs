//! Impulses kept from one step to the next.

use glam::DVec3;
use surface::Contact;

use crate::{Impulse, ResponseError, check};

/// Cosine of the largest turn of a normal at which a contact is still the same
/// one: 30°. Contacts of one particle with two objects, or with the two sides
/// of a groove, lie further apart; a normal that slides over a ridge turns
/// less in a step.
const SAME_NORMAL: f64 = 0.866;

/// Impulses for `new` contacts to start from: those that the `old` ones ended
/// with, where they persist, else zero.
///
/// A contact persists where the particles on the side of P are the same and
/// the normal has turned by less than 30°; the nearest normal counts. Each old
/// impulse is handed on once.
///
/// ```
/// use glam::DVec3;
/// use response::{Impulse, warm_start};
/// use surface::{Contact, Stencil};
///
/// let contact = |vertex, face| Contact {
///     stencil: Stencil::vertex_face(vertex, face, [0.2, 0.3, 0.5]),
///     anchor: None, normal: DVec3::Z, offset: 0.0, gap: 0.0, time: None,
/// };
/// let old = [contact(7, [1, 2, 3])];
/// let push = Impulse { normal: 2.0, tangent: DVec3::ZERO };
/// // The vertex has slid to the next face; another one is new.
/// let new = [contact(8, [1, 2, 3]), contact(7, [2, 3, 4])];
/// assert_eq!(warm_start(&old, &[push], &new)?, [Impulse::default(), push]);
/// # Ok::<(), response::ResponseError>(())
/// ```
///
/// # Errors
///
/// [`ResponseError::Count`] when there is not one impulse an old contact.
pub fn warm_start(
    old: &[Contact],
    impulses: &[Impulse],
    new: &[Contact],
) -> Result<Vec<Impulse>, ResponseError> {
    check::count("impulses", old.len(), impulses.len())?;
    let mut by_key: Vec<(Key, usize)> =
        old.iter().enumerate().map(|(number, contact)| (key(contact), number)).collect();
    by_key.sort_unstable();
    let mut handed_on = vec![false; old.len()];
    let mut carried = vec![Impulse::default(); new.len()];
    for (contact, carried) in new.iter().zip(&mut carried) {
        let key = key(contact);
        let first = by_key.partition_point(|entry| entry.0 < key);
        let same = by_key[first..].iter().take_while(|entry| entry.0 == key).map(|entry| entry.1);
        let turn = |number: usize| old[number].normal.dot(contact.normal);
        let best = same
            .filter(|&number| !handed_on[number] && turn(number) > SAME_NORMAL)
            .max_by(|&a, &b| turn(a).total_cmp(&turn(b)));
        if let Some(number) = best {
            handed_on[number] = true;
            *carried = impulses[number];
        }
    }
    Ok(carried)
}

/// Contacts of the last step with the impulses they ended with.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ImpulseCache {
    contacts: Vec<Contact>,
    impulses: Vec<Impulse>,
}

impl ImpulseCache {
    /// Impulses for `contacts` to start from, as [`warm_start`] finds them.
    ///
    /// # Errors
    ///
    /// None that a memory filled by [`Self::remember`] can cause.
    pub fn recall(&self, contacts: &[Contact]) -> Result<Vec<Impulse>, ResponseError> {
        warm_start(&self.contacts, &self.impulses, contacts)
    }

    /// Replaces what is kept.
    ///
    /// # Errors
    ///
    /// [`ResponseError::Count`] when there is not one impulse a contact.
    pub fn remember(
        &mut self,
        contacts: &[Contact],
        impulses: Vec<Impulse>,
    ) -> Result<(), ResponseError> {
        check::count("impulses", contacts.len(), impulses.len())?;
        self.contacts.clear();
        self.contacts.extend_from_slice(contacts);
        self.impulses = impulses;
        Ok(())
    }

    /// Sum of the impulses that rigid objects were given: each contact's own
    /// is this one's opposite on P.
    #[must_use]
    pub fn given_to_rigid(&self) -> DVec3 {
        let each = self.contacts.iter().zip(&self.impulses);
        each.filter(|(contact, _)| contact.anchor.is_some())
            .map(|(contact, impulse)| -(impulse.normal * contact.normal + impulse.tangent))
            .sum()
    }
}

/// Particles on the side of P: one, two of an edge, three of a face.
type Key = [u32; 4];

fn key(contact: &Contact) -> Key {
    let mut key = [u32::MAX; 4];
    let of_p = contact.stencil.terms().iter().filter(|term| term.weight.is_sign_negative());
    for (slot, term) in key.iter_mut().zip(of_p) {
        *slot = term.particle;
    }
    key.sort_unstable();
    key
}
