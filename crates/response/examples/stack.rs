//! Separates a stack of particles, each sunk into the one below.
//!
//! ```text
//! cargo run --release -p response --example stack
//! ```
//!
//! Contacts that share particles undo each other's corrections when they are corrected one
//! by one: one sweep opens the topmost gap alone. Solved together all gaps open, within the
//! reported residual. A stack is the worst case: the number of sweeps grows with the square
//! of its height.
#![expect(clippy::print_stdout, reason = "a program that prints a table")]

use glam::DVec3;
use response::{
    ContactLaw, ContactRows, ContactSystem, Margins, ResponseError, SolveLevel, SolverParams,
    SweepOrder,
};
use surface::{Contact, ContactSide, Term};

/// Particles of radius 1, each of which should be 2 above the one below.
const COUNT: u32 = 8;

/// Returns the contact of a particle with the floor or with the particle below it.
fn contact(particle: u32, x: &[DVec3]) -> Contact {
    let above = [Term { particle, weight: 1.0 }];
    let height = x[particle as usize].z;
    let p = ContactSide::Particles(&above);

    let Some(below) = particle.checked_sub(1) else {
        let floor = ContactSide::at_rest(DVec3::ZERO);
        return Contact { offset: 1.0, ..Contact::between(p, floor, DVec3::Z, height - 1.0) };
    };
    let gap = height - x[below as usize].z - 2.0;
    let below = [Term { particle: below, weight: 1.0 }];
    let on = ContactSide::Particles(&below);
    Contact { offset: 2.0, ..Contact::between(p, on, DVec3::Z, gap) }
}

fn main() -> Result<(), ResponseError> {
    // Each 0.3 too low over the one below.
    let sunk: Vec<DVec3> = (0..COUNT).map(|i| DVec3::Z * (0.7 + 1.7 * f64::from(i))).collect();
    let law = ContactLaw::new(Margins::new(0.0, 1.0)?, 0.0)?;
    let contacts = |x: &[DVec3]| (0..COUNT).map(|i| contact(i, x)).collect::<Vec<Contact>>();
    let mut rows = ContactRows::new(sunk.len());
    rows.extend(&contacts(&sunk), law)?;
    let inverse_mass = vec![1.0; sunk.len()];
    let system = ContactSystem::new(&rows, &inverse_mass, SweepOrder::Given)?;
    for max_iterations in [0, 1, 10, 100, 1000] {
        let (mut moved, mut impulses) = (vec![DVec3::ZERO; sunk.len()], system.no_impulses());
        let solver = SolverParams { max_iterations, ..SolverParams::default() };
        let report = system.solve(SolveLevel::Position, &mut moved, &mut impulses, &solver)?;
        let x: Vec<DVec3> = sunk.iter().zip(&moved).map(|(x, by)| *x + *by).collect();
        let gaps: Vec<String> = contacts(&x).iter().map(|c| format!("{:.3}", c.gap)).collect();
        println!("{:>4} sweeps, gaps from the floor up: {}", report.iterations, gaps.join(" "));
    }
    Ok(())
}
