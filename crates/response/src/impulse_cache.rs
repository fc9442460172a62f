//! Warm starting: impulses kept from one step to the next.

use glam::DVec3;
use surface::Contact;

use crate::{ContactSet, Impulse, ResponseError, check};

/// Cosine of the largest rotation of a normal at which a contact persists: 30°.
/// Contacts of one particle with the two sides of a groove lie further apart; a normal that
/// slides over a ridge turns less in a step.
const SAME_NORMAL_COSINE: f64 = 0.866;

/// Impulses that the contacts of the last step ended with.
///
/// ```
/// use glam::DVec3;
/// use response::{ContactSet, Impulse, ImpulseCache, Margins, Material, RigidMotion};
/// use surface::{Contact, Stencil};
///
/// let contact = |vertex, face| Contact {
///     stencil: Stencil::vertex_face(vertex, face, [0.2, 0.3, 0.5]),
///     anchor: None, normal: DVec3::Z, offset: 0.0, gap: 0.0, time: None,
/// };
/// let material = Material::hard(Margins::new(0.0, 1.0)?);
/// let set = |contacts: &[Contact]| {
///     let mut set = ContactSet::default();
///     set.add(0, &material, &RigidMotion::default(), contacts);
///     set
/// };
/// let push = Impulse { normal: 2.0, tangent: DVec3::ZERO };
/// let mut cache = ImpulseCache::default();
/// cache.store(&set(&[contact(7, [1, 2, 3])]), &[push])?;
///
/// // The vertex has slid to the next face; another one is new. The step is half as long.
/// let contacts = set(&[contact(8, [1, 2, 3]), contact(7, [2, 3, 4])]);
/// let mut start = Vec::new();
/// cache.warm_start(&contacts, 0.5, &mut start);
/// assert_eq!(start, [Impulse::default(), Impulse { normal: 1.0, ..push }]);
/// # Ok::<(), response::ResponseError>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ImpulseCache {
    /// Sorted by identity.
    entries: Vec<Entry>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Entry {
    key: Key,
    /// Place in the list of the last step.
    number: usize,
    normal: DVec3,
    impulse: Impulse,
    is_used: bool,
}

impl ImpulseCache {
    /// Replaces `start` by impulses for `contacts` to start from: the stored ones times
    /// `scale` where a contact persists, else zero.
    ///
    /// A contact persists where the pair of bodies and the particles on the side of P are the
    /// same and the normal has turned by less than 30°; the nearest normal counts. Each stored
    /// impulse is used once. [`SolveLevel::impulse_scale`] computes the scale where steps
    /// change their length.
    ///
    /// [`SolveLevel::impulse_scale`]: crate::SolveLevel::impulse_scale
    pub fn warm_start(&mut self, contacts: &ContactSet, scale: f64, start: &mut Vec<Impulse>) {
        for entry in &mut self.entries {
            entry.is_used = false;
        }

        // In the order of the contacts, so that each stored impulse has one taker.
        start.clear();
        for group in contacts.groups() {
            for contact in &contacts.contacts()[group.contacts.clone()] {
                start.push(self.take(key(group.pair, contact), contact.normal, scale));
            }
        }
    }

    /// Takes the stored impulse of the nearest normal; the later one of equally near normals.
    fn take(&mut self, key: Key, normal: DVec3, scale: f64) -> Impulse {
        let first = self.entries.partition_point(|entry| entry.key < key);
        let (mut cosine, mut best) = (SAME_NORMAL_COSINE, None);
        for entry in self.entries[first..].iter_mut().take_while(|entry| entry.key == key) {
            let turn = entry.normal.dot(normal);
            if !entry.is_used && turn > SAME_NORMAL_COSINE && turn >= cosine {
                (cosine, best) = (turn, Some(entry));
            }
        }

        // Impulses are forces over a step, which may have another length now.
        let Some(entry) = best else { return Impulse::default() };
        entry.is_used = true;
        Impulse { normal: scale * entry.impulse.normal, tangent: scale * entry.impulse.tangent }
    }

    /// Replaces the stored impulses.
    ///
    /// # Errors
    ///
    /// [`ResponseError::Count`] unless there is one impulse per contact.
    pub fn store(
        &mut self,
        contacts: &ContactSet,
        impulses: &[Impulse],
    ) -> Result<(), ResponseError> {
        check::count("impulses", contacts.contacts().len(), impulses.len())?;

        // Sorted by identity below: contacts may come in any order.
        self.entries.clear();
        for group in contacts.groups() {
            for number in group.contacts.clone() {
                let contact = &contacts.contacts()[number];
                self.entries.push(Entry {
                    key: key(group.pair, contact),
                    number,
                    normal: contact.normal,
                    impulse: impulses[number],
                    is_used: false,
                });
            }
        }

        // Numbers are unique, so an unstable sort, which needs no memory, has one result.
        self.entries.sort_unstable_by_key(|entry| (entry.key, entry.number));
        Ok(())
    }

    /// Removes all impulses: the next step starts cold.
    pub fn clear(&mut self) {
        self.entries.clear();
    }
}

/// Pair of bodies, and particles on the side of P: one, two of an edge, three of a face.
type Key = (u64, [u32; 4]);

fn key(pair: u64, contact: &Contact) -> Key {
    let mut particles = [u32::MAX; 4];
    let of_p = contact.stencil.terms().iter().filter(|term| term.weight.is_sign_negative());
    for (slot, term) in particles.iter_mut().zip(of_p) {
        *slot = term.particle;
    }
    particles.sort_unstable();
    (pair, particles)
}
