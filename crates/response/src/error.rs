//! What a response refuses, and where.

/// Why a contact, a particle or a parameter was refused.
///
/// Each variant names the first offender. `contact` is its position in the
/// list that was given, 0 where a single one was.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ResponseError {
    /// A parameter is outside its range.
    #[error("{name} is {value}, but must be {range}")]
    Parameter {
        /// What it is called.
        name: &'static str,
        /// As given.
        value: f64,
        /// What is allowed.
        range: &'static str,
    },
    /// A list is of another length than the one it goes with.
    #[error("{expected} {what} are needed, but {got} were given")]
    Count {
        /// What the list holds.
        what: &'static str,
        /// Length needed.
        expected: usize,
        /// Length given.
        got: usize,
    },
    /// More than 32-bit indices can number.
    #[error("{count} {what} are more than the {limit} that can be numbered")]
    TooMany {
        /// What there are too many of.
        what: &'static str,
        /// How many were given.
        count: usize,
        /// How many are possible.
        limit: usize,
    },
    /// A particle's state is infinite or not a number.
    #[error("{what} of particle {particle} is {value}, which is not finite")]
    ParticleNotFinite {
        /// `"position"`, `"velocity"`, `"acceleration"` or `"force"`.
        what: &'static str,
        /// The first such particle.
        particle: usize,
        /// Its first coordinate that is not finite.
        value: f64,
    },
    /// An inverse mass is negative, infinite or not a number.
    #[error("the inverse mass of particle {particle} is {value}, but must be finite and >= 0")]
    InverseMass {
        /// The first such particle.
        particle: usize,
        /// As given.
        value: f64,
    },
    /// A field of a contact is infinite or not a number.
    #[error("{what} of contact {contact} is {value}, which is not finite")]
    ContactNotFinite {
        /// Which contact.
        contact: usize,
        /// Which field.
        what: &'static str,
        /// Its first value that is not finite.
        value: f64,
    },
    /// A contact's normal is not of unit length.
    #[error("the normal of contact {contact} has length {length}, but must have length 1")]
    Normal {
        /// Which contact.
        contact: usize,
        /// Length of its normal.
        length: f64,
    },
    /// A contact refers to a particle that does not exist.
    #[error("contact {contact} refers to particle {particle}, but there are {particle_count}")]
    ParticleOutOfRange {
        /// Which contact.
        contact: usize,
        /// The index it holds.
        particle: u32,
        /// Particles there are.
        particle_count: usize,
    },
    /// A contact's weights do not add up, so momentum would not be kept.
    #[error("the weights of contact {contact} sum to {sum}, but must sum to {expected}")]
    Weights {
        /// Which contact.
        contact: usize,
        /// Their sum.
        sum: f64,
        /// 0; −1 where P̄ is carried by a rigid object.
        expected: f64,
    },
    /// No particle of a contact can move, so nothing can correct it.
    #[error("contact {contact} has no particle that can move")]
    NoFreeParticle {
        /// Which contact.
        contact: usize,
    },
    /// Three particles in a line cannot carry the torque of friction.
    #[error("the particles that carry the surface point of contact {contact} are in a line")]
    Collinear {
        /// Which contact.
        contact: usize,
    },
    /// A barrier can keep objects apart, but not part them.
    #[error("contact {contact} has gap {gap} at the start, but a barrier needs a gap above 0")]
    Overlapped {
        /// Which contact.
        contact: usize,
        /// Its gap over the clearance.
        gap: f64,
    },
    /// A correction was made for another step length than it was applied to.
    #[error("a correction for steps of {made_for} was applied to a step of {applied_to}")]
    StepLength {
        /// Step length the correction was computed with.
        made_for: f64,
        /// Step length it met.
        applied_to: f64,
    },
}
