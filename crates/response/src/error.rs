//! Errors of responses.

/// Parameter outside its range.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("{name} is {value}, but must be {range}")]
pub struct ParameterError {
    /// Name of the parameter.
    pub name: &'static str,
    /// Value as given.
    pub value: f64,
    /// Accepted values, in words.
    pub range: &'static str,
}

/// Error of a contact, a particle or a parameter.
///
/// Each variant names the first offender. `contact` is its position in the given list, 0
/// for a single one.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ResponseError {
    /// A parameter is outside its range.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// A list has the wrong length.
    #[error("{expected} {what} are needed, but {got} were given")]
    Count {
        /// Content of the list.
        what: &'static str,
        /// Required length.
        expected: usize,
        /// Length given.
        got: usize,
    },
    /// More than 32-bit indices can number.
    #[error("{count} {what} are more than the {limit} that can be numbered")]
    TooMany {
        /// Name of the elements.
        what: &'static str,
        /// Number given.
        count: usize,
        /// Maximum.
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
        /// Number of the contact.
        contact: usize,
        /// Name of the field.
        what: &'static str,
        /// Its first value that is not finite.
        value: f64,
    },
    /// A contact's normal is not of unit length.
    #[error("the normal of contact {contact} has length {length}, but must have length 1")]
    Normal {
        /// Number of the contact.
        contact: usize,
        /// Length of its normal.
        length: f64,
    },
    /// A contact refers to a particle that does not exist.
    #[error("contact {contact} refers to particle {particle}, but there are {particle_count}")]
    ParticleOutOfRange {
        /// Number of the contact.
        contact: usize,
        /// The index it holds.
        particle: u32,
        /// Number of particles.
        particle_count: usize,
    },
    /// A contact's weights have the wrong sum, so momentum would not be kept.
    #[error("the weights of contact {contact} sum to {sum}, but must sum to {expected}")]
    Weights {
        /// Number of the contact.
        contact: usize,
        /// Their sum.
        sum: f64,
        /// 0; −1 where P̄ is carried by a rigid object.
        expected: f64,
    },
    /// A follower has a leader with a negative weight, which would take mass from it.
    #[error(
        "particle {leader} leads particle {follower} with weight {weight}, but it must be at least 0"
    )]
    LeaderWeight {
        /// The particle that follows.
        follower: u32,
        /// The particle that it follows.
        leader: u32,
        /// As given.
        weight: f64,
    },
    /// No particle of a contact can move, so it cannot be corrected.
    #[error("contact {contact} has no particle that can move: give one an inverse mass > 0")]
    NoFreeParticle {
        /// Number of the contact.
        contact: usize,
    },
    /// A barrier keeps objects apart, but does not separate objects that overlap.
    #[error("contact {contact} has gap {gap} at the start, but a barrier needs a gap above 0")]
    Overlapped {
        /// Number of the contact.
        contact: usize,
        /// Its gap over the clearance.
        gap: f64,
    },
    /// A correction was applied to a step of another length.
    #[error("a correction for steps of {made_for} was applied to a step of {applied_to}")]
    StepLength {
        /// Step length the correction was computed with.
        made_for: f64,
        /// Step length it was applied to.
        applied_to: f64,
    },
}
