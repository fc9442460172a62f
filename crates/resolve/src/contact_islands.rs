//! Contact islands: contacts without a common particle that can move, solved side by side.
//!
//! Each island ends when its own contacts are separated. Most contacts only hold, and cost one sweep; a
//! place where bodies are stuck delays no other.

use std::collections::BTreeMap;

use glam::DVec3;
use response::{
    Constraint, ContactLaw, ContactRows, ContactSystem, ResponseError, SolveLevel, SolverMemory,
    SolverParams, SweepOrder,
};
use surface::{Contact, Term, UnionFind, parallel};

use crate::count::as_f64;

/// Number of contacts up to which small islands are solved as one. Below, preparing islands takes longer than
/// solving them; above, small ones sweep as long as the slowest of many.
const MIN_CONTACTS: usize = 64;

/// Contacts of a scene in islands, prepared for solving.
pub(crate) struct ContactIslands(Vec<ContactIsland>);

/// Contacts that have no particle that can move in common with those of other islands.
struct ContactIsland {
    /// Particles of its contacts, ascending.
    particles: Vec<u32>,
    system: ContactSystem,
    contact_count: usize,
}

impl ContactIslands {
    /// Splits contacts into islands. Contacts of which no particle can move are left out.
    pub(crate) fn new(
        contacts: &[&Contact],
        law: ContactLaw,
        inverse_masses: &[f64],
    ) -> Result<Self, ResponseError> {
        let islands = islands(contacts, inverse_masses);
        let prepared = parallel::map(islands.len(), |number| {
            ContactIsland::new(contacts, &islands[number], law, inverse_masses)
        });
        let prepared: Result<Vec<_>, ResponseError> = prepared.into_iter().collect();
        Ok(Self(prepared?))
    }

    /// Corrects the displacements of all particles.
    pub(crate) fn solve(
        &self,
        displacements: &mut [DVec3],
        params: &SolverParams,
    ) -> Result<(), ResponseError> {
        let all = &*displacements;
        let solve =
            |memory: &mut SolverMemory, island: &ContactIsland| island.solve(memory, all, params);
        let solved =
            parallel::map_costly_first(&self.0, ContactIsland::cost, SolverMemory::default, solve);

        for (island, own) in self.0.iter().zip(solved) {
            for (&particle, displacement) in island.particles.iter().zip(own?) {
                displacements[particle as usize] = displacement;
            }
        }
        Ok(())
    }
}

impl ContactIsland {
    /// Prepares the contacts of the numbers of `own`, with their particles numbered without gaps.
    fn new(
        contacts: &[&Contact],
        own: &[usize],
        law: ContactLaw,
        inverse_masses: &[f64],
    ) -> Result<Self, ResponseError> {
        let mut particles = Vec::new();
        for &number in own {
            for term in contacts[number].stencil.terms() {
                particles.push(term.particle);
            }
        }
        particles.sort_unstable();
        particles.dedup();

        let masses: Vec<f64> = particles.iter().map(|p| inverse_masses[*p as usize]).collect();
        let numbers: BTreeMap<u32, u32> = particles.iter().copied().zip(0..).collect();
        let mut rows = ContactRows::new(particles.len());
        for &number in own {
            let contact = contacts[number];
            let mut terms = Vec::with_capacity(6);
            for &Term { particle, weight } in contact.stencil.terms() {
                terms.push(Term { particle: numbers[&particle], weight });
            }
            rows.push_terms(contact, &terms, law, Constraint::Contact)?;
        }
        let system = ContactSystem::new(&rows, &masses, SweepOrder::Colored)?;
        Ok(Self { particles, system, contact_count: rows.len() })
    }

    /// Returns the relative time of a sweep.
    fn cost(&self) -> f64 {
        as_f64(self.contact_count)
    }

    /// Computes the corrected displacements of the island's particles from those of all.
    fn solve(
        &self,
        memory: &mut SolverMemory,
        all: &[DVec3],
        params: &SolverParams,
    ) -> Result<Vec<DVec3>, ResponseError> {
        let mut own: Vec<DVec3> = self.particles.iter().map(|p| all[*p as usize]).collect();
        let mut impulses = self.system.no_impulses();
        self.system.solve_in(memory, SolveLevel::Position, &mut own, &mut impulses, params)?;
        Ok(own)
    }
}

/// Lists the numbers of the contacts of each island; small islands next to each other make one.
fn islands(contacts: &[&Contact], inverse_masses: &[f64]) -> Vec<Vec<usize>> {
    // Contacts with a particle that can move in common are of one set, named after its first one.
    let mut sets = UnionFind::new(inverse_masses.len());
    let mut first_particles = Vec::with_capacity(contacts.len());
    for contact in contacts {
        let mut first = None;
        for term in contact.stencil.terms() {
            if inverse_masses[term.particle as usize] > 0.0 {
                sets.join(term.particle, *first.get_or_insert(term.particle));
            }
        }
        first_particles.push(first);
    }
    let mut members: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for (number, first) in first_particles.into_iter().enumerate() {
        if let Some(particle) = first {
            members.entry(sets.find(particle)).or_default().push(number);
        }
    }

    let (mut islands, mut small) = (Vec::new(), Vec::new());
    for own in members.into_values() {
        if own.len() >= MIN_CONTACTS {
            islands.push(own);
            continue;
        }
        small.extend(own);
        if small.len() >= MIN_CONTACTS {
            islands.push(std::mem::take(&mut small));
        }
    }
    if !small.is_empty() {
        islands.push(small);
    }
    islands
}

#[cfg(test)]
mod tests {
    use response::Margins;
    use surface::Stencil;

    use super::*;

    /// Builds a contact of two particles that miss a gap along z.
    fn contact(lower: u32, upper: u32, gap: f64) -> Contact {
        let term = |particle, weight| Term { particle, weight };
        let stencil = Stencil::new(&[term(upper, -1.0), term(lower, 1.0)]).expect("two terms");
        Contact { stencil, anchor: None, normal: DVec3::Z, offset: 0.0, gap, time: None }
    }

    /// Builds columns of three particles on one that cannot move, with a gap missing over each: one column
    /// after the other without a particle in common but that.
    fn columns(count: u32) -> (Vec<Contact>, Vec<f64>) {
        let mut contacts = Vec::new();
        for column in 0..count {
            let first = 1 + 3 * column;
            let depth = 0.1 + 0.01 * f64::from(column % 7);
            for (lower, upper) in [(0, first), (first, first + 1), (first + 1, first + 2)] {
                contacts.push(contact(lower, upper, -depth));
            }
        }
        let mut inverse_masses = vec![1.0; 1 + 3 * count as usize];
        inverse_masses[0] = 0.0;
        (contacts, inverse_masses)
    }

    #[test]
    fn islands_hold_each_contact_once_and_share_no_particle_that_can_move() {
        let (mut contacts, inverse_masses) = columns(100);
        contacts.push(contact(1, 298, 0.0));
        contacts.push(contact(0, 0, 0.0));
        let all: Vec<&Contact> = contacts.iter().collect();
        let islands = islands(&all, &inverse_masses);
        assert!(islands.len() > 3, "{}", islands.len());
        let mut owners: BTreeMap<u32, usize> = BTreeMap::new();
        let mut seen = vec![0; contacts.len()];
        for (island, own) in islands.iter().enumerate() {
            for &number in own {
                seen[number] += 1;
                for term in contacts[number].stencil.terms() {
                    if term.particle > 0 {
                        let owner = *owners.entry(term.particle).or_insert(island);
                        assert_eq!(owner, island, "particle {}", term.particle);
                    }
                }
            }
        }
        let nothing_moves = seen.pop();
        assert_eq!((nothing_moves, seen.iter().all(|count| *count == 1)), (Some(0), true));
    }

    #[test]
    fn islands_are_solved_as_all_contacts_together() {
        let (contacts, inverse_masses) = columns(100);
        let law = ContactLaw::new(Margins::new(0.0, 1.0).expect("margins"), 0.0).expect("a law");
        let params =
            SolverParams { max_iterations: 500, tolerance: 1e-12, ..SolverParams::default() };

        let mut rows = ContactRows::new(inverse_masses.len());
        rows.extend(&contacts, law).expect("rows");
        let system = ContactSystem::new(&rows, &inverse_masses, SweepOrder::Colored);
        let system = system.expect("a system");
        let mut together = vec![DVec3::ZERO; inverse_masses.len()];
        let impulses = &mut system.no_impulses();
        let report = system.solve(SolveLevel::Position, &mut together, impulses, &params);
        assert!(report.expect("a solution").converged);

        let mut apart = vec![DVec3::ZERO; inverse_masses.len()];
        let all: Vec<&Contact> = contacts.iter().collect();
        let islands = ContactIslands::new(&all, law, &inverse_masses).expect("islands");
        islands.solve(&mut apart, &params).expect("a solution");
        assert!(together.iter().any(|u| u.z > 0.2));
        for (together, apart) in together.iter().zip(&apart) {
            assert!((*together - *apart).length() < 1e-10, "{together} {apart}");
        }
    }
}
