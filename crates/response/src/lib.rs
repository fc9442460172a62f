//! Contact response: corrections, impulses and soft forces on particles.
//!
//! A contact combines particle states: P_c = P̄ − P = Σ β_k P_k, and likewise
//! V_c and A_c ([`RelativeState`]). A response changes that combination, and a
//! change is spread over the particles so that momentum is kept
//! ([`distribute`]).
//!
//! # The table of corrections
//!
//! With n the normal, δ the depth, λ the proximity factor, d_max the proximity
//! distance, h the step, `u₊ = max(u, 0)`, `u_n = (u · n) n`, `u_t = u − u_n`:
//!
//! | row | ΔP_c | ΔV_c | ΔA_c |
//! |---|---|---|---|
//! | [`Spring::OneSided`] | −δ₊ n | ΔP_c / h (− V_c,n) | ΔP_c / h² |
//! | [`Spring::Gradual`] | −λ d_max n | ΔP_c / h (− λ V_c,n) | ΔP_c / h² |
//! | [`Spring::TwoSided`] | −λ δ n | ΔP_c / h (− λ V_c,n) | ΔP_c / h² |
//! | [second order](TimeStep::second_order_spring) | | | ΔP_c / h² − 2 V_c / h − σ ΔV_c / h − A_c |
//! | [`Reaction`], [`Friction::share`] | −λ ((D · n)₊ n + µ D_t) | −λ (V_c,n + µ V_c,t) if V_c · n > 0 | same with A_c |
//! | [`Reaction`], [`Friction::coulomb`] | −j n − min(1, µ j / \|D_t\|) D_t, j = λ (D · n)₊ | same with V_c | same with A_c |
//! | [`Reference`], [`Restraint::Sticking`] | P_ref − P_c | −V_c | −A_c |
//! | [`Reference`], [`Restraint::Sliding`] | (P_ref − P_c)_n | −V_c,n | −A_c,n |
//!
//! D is the last displacement of P_c, σ the integrator's
//! [`POSITION_SHARE`](Integrator::POSITION_SHARE). The table of the source is
//! derived again from its definitions; where those leave a choice, each is a row.
//!
//! # From one contact to many
//!
//! Corrections of contacts that share particles must not be added up: a
//! [`ContactSystem`] solves them together, at one [`SolveLevel`]. Each row of the table is
//! a [`Constraint`] on Q_c there: a target, one-sided, two-sided or of the whole vector,
//! hard or with the compliance of a [`SpringDamper`];
//! A [`ContactStep`] does so in a simulator's step, for positions, velocities and
//! accelerations in turn, with a [`Material`] per pair of bodies, bones that move
//! ([`RigidMotion`]) and warm starting ([`ImpulseCache`]). [`SoftContacts`] are forces with
//! derivatives, for the system of an implicit step. [`PermanentContacts`] carry a list of
//! contacts from frame to frame. [`stability`] computes the limits of stable steps.
//!
//! # Units and promises
//!
//! Lengths, times and masses are in the caller's units, which must fit
//! together: in millimeters, gravity is 9810. Every entry point checks its
//! arguments; input that is not finite is an error that names the contact or
//! the particle, and no result contains a value that is not finite. Momentum is
//! kept to rounding, a hard correction is met to the residual it reports, and
//! friction stays within its cone, or opposes the slip that it takes a share of, once solved.
//! Results have the same bits with and without the feature `rayon`, for any number of threads.
//!
//! # Example
//!
//! ```
//! use glam::DVec3;
//! use response::{
//!     ContactLaw, ContactRows, ContactSystem, Margins, SolveLevel, SolverParams, SweepOrder,
//! };
//! use surface::{Contact, ContactSide, Term};
//!
//! // A particle falls on a floor at rest.
//! let particle = [Term { particle: 0, weight: 1.0 }];
//! let floor = ContactSide::at_rest(DVec3::ZERO);
//! let contact = Contact::between(ContactSide::Particles(&particle), floor, DVec3::Z, 0.0);
//!
//! let mut rows = ContactRows::new(1);
//! rows.push(&contact, ContactLaw::new(Margins::new(0.0, 1.0)?, 0.3)?)?;
//! let system = ContactSystem::new(&rows, &[1.0], SweepOrder::Colored)?;
//! let mut v = [DVec3::Z * -2.0];
//! system.solve(SolveLevel::Velocity, &mut v, &mut system.no_impulses(), &SolverParams::default())?;
//! assert_eq!(v[0], DVec3::ZERO);
//! # Ok::<(), response::ResponseError>(())
//! ```
//!
//! # Features
//!
//! - `rayon`: sweeps large batches on the current thread pool.
//! - `serde`: serializes plain data.
//!
//! None is on by default.
//!
//! # Sources
//!
//! - B. Gilles, *Anatomical and kinematical modelling of the musculoskeletal
//!   system using MRI*, PhD thesis, 2007, section 4.7.2.
//! - P. Volino and N. Magnenat-Thalmann, "Implementing fast cloth simulation
//!   with collision response", Computer Graphics International, 2000.

#![expect(clippy::doc_markdown, reason = "formulas keep the source's letters, as in P_ref")]

mod check;
mod combinations;
mod constraint;
mod contact_rows;
mod contact_set;
mod contact_step;
mod distribute;
mod error;
mod followers;
mod implicit;
mod impulse_cache;
mod material;
mod permanent;
mod reaction;
mod reference;
mod relative;
mod soft;
mod solve;
mod solve_level;
mod spring;
pub mod stability;
mod step;
mod walk;

pub use glam;

pub use crate::check::{not_negative, parameter, positive};
pub use crate::combinations::Combinations;
pub use crate::constraint::{Constraint, SpringDamper};
pub use crate::contact_rows::{ContactLaw, ContactRow, ContactRows};
pub use crate::contact_set::{ContactGroup, ContactSet};
pub use crate::contact_step::{
    ContactStep, ParticleLoads, ParticleStates, StepParams, StepReport, SweptReport,
};
pub use crate::distribute::distribute;
pub use crate::error::{ParameterError, ResponseError};
pub use crate::followers::{Follower, Followers};
pub use crate::implicit::{LinearParams, LinearReport};
pub use crate::impulse_cache::ImpulseCache;
pub use crate::material::Material;
pub use crate::permanent::{
    ContactState, GapMeasure, PermanentContacts, RigidMotion, SurfaceCarrier,
};
pub use crate::reaction::{Friction, Reaction};
pub use crate::reference::{FaceFrame, Reference, Restraint};
pub use crate::relative::{Margins, RelativeMotion, RelativeState};
pub use crate::soft::{LinearForces, MatrixBlock, NormalForce, SoftContacts, SoftLaw};
pub use crate::solve::{
    ContactSystem, Impulse, Residual, SolveReport, SolverMemory, SolverMethod, SolverParams,
    SweepOrder,
};
pub use crate::solve_level::SolveLevel;
pub use crate::spring::Spring;
pub use crate::step::{
    Acceleration, Accelerations, ExplicitEuler, Implicit, ImplicitEuler, ImplicitMidpoint,
    Integrator, StepLength, SymplecticEuler, Taylor, TimeStep,
};
pub use crate::walk::{SurfaceFoot, walk_to_foot};

/// Compiles and runs the README's example.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
