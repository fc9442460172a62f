//! Contacts and sums that the tests share.

use arbitrary::Unstructured;
use glam::DVec3;
use response::{
    ContactLaw, ContactRows, ContactSystem, Friction, Margins, Material, RelativeMotion,
    RelativeState, SolveLevel, SolveReport, SolverMethod, SolverParams, SweepOrder,
};
use surface::{Anchor, Contact, Stencil, Term};

/// A term.
pub(crate) fn term(particle: u32, weight: f64) -> Term {
    Term { particle, weight }
}

/// A contact without offset.
pub(crate) fn contact(stencil: Stencil, normal: DVec3, gap: f64) -> Contact {
    Contact { stencil, anchor: None, normal, offset: 0.0, gap, time: None }
}

/// Particle `k` at `x` over a fixed plane through the origin.
pub(crate) fn on_plane(k: u32, x: DVec3, normal: DVec3) -> Contact {
    let gap = x.dot(normal);
    let anchor = Some(Anchor { point: x - gap * normal, ..Anchor::default() });
    Contact { anchor, ..contact(Stencil::single(term(k, -1.0)), normal, gap) }
}

/// Particle `above` over particle `below`, one length apart when touching.
pub(crate) fn stacked(below: u32, above: u32, x: &[DVec3]) -> Contact {
    let stencil = Stencil::new(&[term(above, -1.0), term(below, 1.0)]).expect("two terms");
    let gap = (x[above as usize] - x[below as usize]).z - 1.0;
    Contact { offset: 1.0, ..contact(stencil, DVec3::Z, gap) }
}

/// Contacts of a tower of particles on a floor at height 0, bottom first.
pub(crate) fn tower(x: &[DVec3]) -> Vec<Contact> {
    let floor = Contact { offset: 0.0, ..on_plane(0, x[0], DVec3::Z) };
    let count = u32::try_from(x.len()).expect("a few particles");
    std::iter::once(floor).chain((1..count).map(|k| stacked(k - 1, k, x))).collect()
}

/// Margins that tests do not vary: no clearance, everything in proximity.
pub(crate) fn law(friction: f64) -> ContactLaw {
    ContactLaw::new(Margins::new(0.0, 1.0).expect("in range"), friction).expect("in range")
}

/// The same law as a material.
pub(crate) fn material(friction: f64) -> Material {
    let friction = Friction::coulomb(friction).expect("in range");
    Material { friction, ..Material::hard(law(0.0).margins()) }
}

/// Rows of `contacts` over `count` particles.
pub(crate) fn rows(count: usize, contacts: &[Contact], law: ContactLaw) -> ContactRows {
    let mut rows = ContactRows::new(count);
    rows.extend(contacts, law).expect("contacts of a test are valid");
    rows
}

/// Solves `contacts` for `q` from a cold start, in the order given.
pub(crate) fn solve(
    level: SolveLevel,
    q: &mut [DVec3],
    inverse_mass: &[f64],
    contacts: &[Contact],
    law: ContactLaw,
    params: &SolverParams,
) -> SolveReport {
    let rows = rows(q.len(), contacts, law);
    let system = ContactSystem::new(&rows, inverse_mass, SweepOrder::Given).expect("valid masses");
    let mut impulses = system.no_impulses();
    system.solve(level, q, &mut impulses, params).expect("valid states")
}

/// Many sweeps, to rounding.
pub(crate) fn thorough() -> SolverParams {
    SolverParams { max_iterations: 20_000, tolerance: 1e-13, ..SolverParams::default() }
}

/// All solvers.
pub(crate) const METHODS: [SolverMethod; 3] =
    [SolverMethod::GaussSeidel, SolverMethod::AveragedJacobi, SolverMethod::ConjugateGradient];

/// All levels.
pub(crate) const LEVELS: [SolveLevel; 3] =
    [SolveLevel::Position, SolveLevel::Velocity, SolveLevel::Acceleration];

/// Solves rows by a method, to rounding and from a cold start.
pub(crate) fn solve_by(
    rows: &ContactRows,
    inverse_mass: &[f64],
    level: SolveLevel,
    q: &mut [DVec3],
    method: SolverMethod,
) -> SolveReport {
    let system = ContactSystem::new(rows, inverse_mass, SweepOrder::Colored).expect("valid");
    let params = SolverParams { method, max_iterations: 200_000, tolerance: 1e-11 };
    system.solve(level, q, &mut system.no_impulses(), &params).expect("valid")
}

/// State of a particle at `x`, `v` over the fixed plane through the origin.
pub(crate) fn over_plane(x: DVec3, v: DVec3, normal: DVec3, margins: Margins) -> RelativeState {
    let foot = x - x.dot(normal) * normal;
    let motion = RelativeMotion { position: foot - x, velocity: -v, acceleration: DVec3::ZERO };
    RelativeState::new(motion, normal, 0.0, margins).expect("finite")
}

/// |Σ m dv| as a share of Σ m |v|: what a response adds to the momentum.
pub(crate) fn momentum_residual(inverse_mass: &[f64], before: &[DVec3], after: &[DVec3]) -> f64 {
    let mut change = DVec3::ZERO;
    let mut scale = 0.0;
    for ((w, before), after) in inverse_mass.iter().zip(before).zip(after) {
        change += (*after - *before) / *w;
        scale += (before.length() + after.length()) / *w;
    }
    if scale > 0.0 { change.length() / scale } else { 0.0 }
}

/// Σ m v² / 2 over the particles that can move.
pub(crate) fn kinetic_energy(inverse_mass: &[f64], v: &[DVec3]) -> f64 {
    inverse_mass
        .iter()
        .zip(v)
        .filter(|(w, _)| **w > 0.0)
        .map(|(w, v)| 0.5 * v.length_squared() / w)
        .sum()
}

/// A number in `low..=high`, in 2^16 steps.
pub(crate) fn number(u: &mut Unstructured<'_>, low: f64, high: f64) -> arbitrary::Result<f64> {
    let share = f64::from(u.int_in_range(0..=u16::MAX)?) / f64::from(u16::MAX);
    Ok(low + share * (high - low))
}

/// A vector in the cube of half side `extent`.
pub(crate) fn vector(u: &mut Unstructured<'_>, extent: f64) -> arbitrary::Result<DVec3> {
    let mut one = || number(u, -extent, extent);
    Ok(DVec3::new(one()?, one()?, one()?))
}

/// A unit vector.
pub(crate) fn unit(u: &mut Unstructured<'_>) -> arbitrary::Result<DVec3> {
    Ok(vector(u, 1.0)?.try_normalize().unwrap_or(DVec3::Y))
}

/// A repeatable stream of numbers in 0..1, for scenes of a fixed make.
pub(crate) struct Stream(pub(crate) u64);

impl Stream {
    /// The next number.
    pub(crate) fn next(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let top = u32::try_from(self.0 >> 32).expect("32 bits");
        f64::from(top) / 4_294_967_296.0
    }

    /// The next whole number below `below`.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 <= x < below")]
    pub(crate) fn index(&mut self, below: u32) -> u32 {
        (self.next() * f64::from(below)) as u32
    }
}

/// A patch of `count` vertex-face contacts between 12 particles above and 12
/// below, moving toward each other, each approaching.
pub(crate) fn patch(count: usize, seed: u64) -> (Vec<DVec3>, Vec<f64>, Vec<Contact>) {
    let mut stream = Stream(seed);
    let mut v = Vec::new();
    let mut inverse_mass = Vec::new();
    for k in 0..24 {
        let toward = if k < 12 { -1.0 } else { 1.0 };
        let jitter = DVec3::new(stream.next() - 0.5, stream.next() - 0.5, stream.next() - 0.5);
        v.push(DVec3::Z * toward + 0.4 * jitter);
        inverse_mass.push(0.5 + stream.next());
    }
    let mut contacts = Vec::new();
    while contacts.len() < count {
        let face = [stream.index(12), stream.index(12), stream.index(12)].map(|k| 12 + k);
        if face[0] == face[1] || face[1] == face[2] || face[2] == face[0] {
            continue;
        }
        let (a, b) = (0.05 + stream.next(), 0.05 + stream.next());
        let sum = a + b + 0.5;
        let weights = [a / sum, b / sum, 0.5 / sum];
        let tilt = DVec3::new(stream.next() - 0.5, stream.next() - 0.5, 2.0).normalize();
        contacts.push(contact(Stencil::vertex_face(stream.index(12), face, weights), tilt, 0.0));
    }
    (v, inverse_mass, contacts)
}
