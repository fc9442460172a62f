//! Setup of a relaxation: particles numbered without gaps, and where each of them occurs.

use glam::DVec3;
use surface::parallel;

use super::{Relaxation, RelaxedBond, RelaxedParticle, RelaxedRow};
use crate::elastic::{ActiveParticle, Bond, ElasticProblem, GapRow, SharedArea, Terms};
use crate::occurrences::{INACTIVE, Occurrences, occurrences};
use crate::parts::{self, Part, PartGraph};
use crate::shared_number::{SharedNumber, SharedVector};
use crate::turns::Turns;
use crate::volume_row::{RelaxedArea, SharedGain, VolumeRow, volume_rows};

/// Particles by their own numbers, with the parts that they are in.
struct Numbering<'a> {
    active: &'a [ActiveParticle],
    /// Own number of each particle of the scene.
    numbers: Vec<u32>,
    parts: Vec<Part>,
}

/// Active particles with their links to each other, and the parts that these connect.
struct Linked {
    particles: Vec<RelaxedParticle>,
    links: Vec<(u32, f64)>,
    graph: PartGraph,
}

/// Rows and bonds with where particles occur in them, and the parts that these connect.
struct Coupled {
    rows: Vec<GapRow>,
    /// Rows by their own numbers, which occur in `in_rows`.
    row_order: Vec<u32>,
    in_rows: Occurrences,
    bonds: Vec<RelaxedBond>,
    in_bonds: Occurrences,
    graph: PartGraph,
}

/// Areas of particles in bodies other than their own, and what parts gain of these.
#[derive(Default)]
struct SharedVolumes {
    areas: Vec<RelaxedArea>,
    gains: Vec<SharedGain>,
}

impl Relaxation {
    /// Sets up a problem at the displacements `u` of all particles. The `penalty` is the stiffness of each row's
    /// augmented term, relative to what it moves.
    pub(super) fn new(problem: ElasticProblem, u: &[DVec3], penalty: f64) -> Self {
        let ElasticProblem { particles: active, links, rows, bonds, shared_areas, missing_volumes } =
            problem;
        let numbering = Numbering::new(&active, u.len());
        let (linked, coupled) =
            parallel::join(|| numbering.link(&links, u), || numbering.couple(rows, &bonds, u));
        let Linked { mut particles, links, mut graph } = linked;
        let Coupled { rows, row_order, in_rows, bonds, in_bonds, graph: of_terms } = coupled;

        // What holds each particle is known from both.
        for (i, particle) in particles.iter_mut().enumerate() {
            (particle.rows_end, particle.bonds_end) = (in_rows.ends[i], in_bonds.ends[i]);
            for bond in in_bonds.of(i) {
                let stiffness = bonds[bond.number as usize].stiffness;
                particle.diagonal += stiffness * bond.weight * bond.weight;
            }
        }

        let Numbering { numbers, parts, .. } = numbering;
        graph.merge(of_terms);
        let colors = graph.colors(parts.len());
        let mut volumes = volume_rows(missing_volumes, &parts);
        let shared = share_volumes(&shared_areas, &numbers, &parts, &mut particles, &mut volumes);
        set_volume_penalties(&mut volumes, &parts, &particles, &shared.areas);
        let displaced =
            |particle: &RelaxedParticle| SharedVector::new(u[particle.particle as usize]);
        Self {
            u: particles.iter().map(displaced).collect(),
            links,
            rows: relaxed_rows(&rows, &row_order, &particles, &numbers, penalty),
            particles,
            in_rows: in_rows.all,
            bonds,
            in_bonds: in_bonds.all,
            volumes,
            gained: parts.iter().map(|_| SharedNumber::default()).collect(),
            shared_areas: shared.areas,
            shared_gains: shared.gains,
            parts,
            turns: Turns::new(&colors),
            colors,
        }
    }
}

impl<'a> Numbering<'a> {
    /// Numbers the active particles, of `count` in all.
    fn new(active: &'a [ActiveParticle], count: usize) -> Self {
        let mut numbers = vec![INACTIVE; count];
        for (number, active) in (0..).zip(active) {
            numbers[active.particle as usize] = number;
        }
        let body_of: Vec<usize> = active.iter().map(|active| active.body).collect();
        Self { active, numbers, parts: parts::cut(&body_of) }
    }

    /// Lists the links between active particles; all others pull with a constant force.
    fn link(&self, all: &[(u32, f64)], u: &[DVec3]) -> Linked {
        let mut particles = Vec::with_capacity(self.active.len());
        let mut links = Vec::with_capacity(all.len());
        let mut graph = PartGraph::new(&self.parts);
        let mut first = 0;
        for Part { particles: own, .. } in &self.parts {
            for active in &self.active[own.clone()] {
                let mut particle = RelaxedParticle {
                    particle: active.particle,
                    area: active.area,
                    own: active.foundation,
                    ..RelaxedParticle::default()
                };
                for &(next, stiffness) in &all[first..active.links_end] {
                    particle.own += stiffness;
                    let number = self.numbers[next as usize];
                    if number == INACTIVE {
                        particle.pull += stiffness * u[next as usize];
                        continue;
                    }
                    links.push((number, stiffness));
                    if !own.contains(&(number as usize)) {
                        graph.connect([own.start, number as usize].into_iter());
                    }
                }
                first = active.links_end;
                particle.diagonal = particle.own;
                particle.links_end = links.len();
                particles.push(particle);
            }
        }
        Linked { particles, links, graph }
    }

    /// Lists where active particles occur in rows and bonds. Particles that are not active do not change an
    /// opening.
    fn couple(&self, mut rows: Vec<GapRow>, bonds: &[Bond], u: &[DVec3]) -> Coupled {
        let numbers = &self.numbers;
        for row in &mut rows {
            row.keep_active(|particle| numbers[particle as usize] != INACTIVE, u);
        }
        rows.retain(|row| !row.terms.is_empty());
        let count = self.active.len();
        let mut in_rows = occurrences(rows.iter().map(|row| &row.terms), numbers, count);
        let row_order = in_rows.number_by_first(rows.len());
        let in_bonds = occurrences(bonds.iter().map(|bond| &bond.terms), numbers, count);

        let mut relaxed = Vec::with_capacity(bonds.len());
        for Bond { terms, stiffness } in bonds {
            let mut stretch = DVec3::ZERO;
            for &(particle, weight) in terms {
                stretch += weight * u[particle as usize];
            }
            let stretch = SharedVector::new(stretch);
            relaxed.push(RelaxedBond { stiffness: *stiffness, stretch });
        }
        let terms = rows.iter().map(|row| &row.terms).chain(bonds.iter().map(|bond| &bond.terms));
        let graph = self.connect(terms);
        Coupled { rows, row_order, in_rows, bonds: relaxed, in_bonds, graph }
    }

    /// Connects the parts that have rows or bonds in common.
    fn connect<'t>(&self, terms: impl Iterator<Item = &'t Terms>) -> PartGraph {
        let mut graph = PartGraph::new(&self.parts);
        for terms in terms {
            let active = terms.iter().map(|(particle, _)| self.numbers[*particle as usize]);
            graph.connect(active.filter(|i| *i != INACTIVE).map(|i| i as usize));
        }
        graph
    }
}

/// Makes the rows that sweeps read, in their `order`, each with a stiffness in proportion to what it moves.
fn relaxed_rows(
    rows: &[GapRow],
    order: &[u32],
    particles: &[RelaxedParticle],
    numbers: &[u32],
    penalty: f64,
) -> Vec<RelaxedRow> {
    parallel::map_slice_with(
        order,
        || (),
        |(), &number| {
            let GapRow { terms, normal, missing } = &rows[number as usize];
            let mut compliance = 0.0;
            for &(particle, weight) in terms {
                let stiffness = particles[numbers[particle as usize] as usize].diagonal;
                if stiffness > 0.0 {
                    compliance += weight * weight / stiffness;
                }
            }
            let penalty = if compliance > 0.0 { penalty / compliance } else { 0.0 };
            let (multiplier, opening) = (SharedNumber::default(), SharedNumber::default());
            let (normal, missing) = (*normal, *missing);
            RelaxedRow { normal, missing, penalty, multiplier, opening }
        },
    )
}

/// Lists the areas of particles in bodies other than their own, and what each part gains of these. Areas are in the
/// order of the particles.
fn share_volumes(
    shared_areas: &[SharedArea],
    numbers: &[u32],
    parts: &[Part],
    particles: &mut [RelaxedParticle],
    volumes: &mut [VolumeRow],
) -> SharedVolumes {
    let mut shared = SharedVolumes::default();
    if shared_areas.is_empty() {
        return shared;
    }

    // The gains of a part follow each other, since its particles do.
    let mut first_of_part = 0;
    for &SharedArea { particle, body, area } in shared_areas {
        let number = numbers[particle as usize] as usize;
        let part = parts.partition_point(|part| part.particles.end <= number);
        if shared.gains.last().is_none_or(|gain| gain.part < part) {
            first_of_part = shared.gains.len();
        }
        let known = shared.gains[first_of_part..].iter().position(|gain| gain.body == body);
        let gain = known.map_or(shared.gains.len(), |known| first_of_part + known);
        if known.is_none() {
            volumes[body].shared.push(gain);
            shared.gains.push(SharedGain { part, body, ..SharedGain::default() });
        }
        shared.areas.push(RelaxedArea { area, body, gain });
        particles[number].shared_areas_end += 1;
    }
    let mut end = 0;
    for particle in particles {
        end += particle.shared_areas_end;
        particle.shared_areas_end = end;
    }
    shared
}

/// Sets the stiffness of each volume in proportion to what it moves.
fn set_volume_penalties(
    volumes: &mut [VolumeRow],
    parts: &[Part],
    particles: &[RelaxedParticle],
    shared: &[RelaxedArea],
) {
    let mut compliances = vec![0.0; volumes.len()];
    for part in parts {
        let mut first = match part.particles.start {
            0 => 0,
            start => particles[start - 1].shared_areas_end as usize,
        };
        for active in &particles[part.particles.clone()] {
            let own = &shared[first..active.shared_areas_end as usize];
            first = active.shared_areas_end as usize;
            if active.diagonal > 0.0 {
                compliances[part.body] += active.area.length_squared() / active.diagonal;
                for RelaxedArea { area, body, .. } in own {
                    compliances[*body] += area.length_squared() / active.diagonal;
                }
            }
        }
    }
    for (volume, compliance) in volumes.iter_mut().zip(compliances) {
        volume.penalty = if compliance > 0.0 { compliance.recip() } else { 0.0 };
    }
}
