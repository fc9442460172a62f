//! Tests of the public interface: every cell of the table of corrections, scenes with
//! answers in closed form, and solvers against reference implementations.

#![expect(clippy::float_cmp, reason = "what is not touched, or is exact in binary, must stay so")]

mod bad_input;
mod cells;
mod common;
mod contact_step;
mod coupled_rows;
#[cfg(feature = "serde")]
mod deserialized;
mod distribution;
mod implicit;
mod mass_ratios;
mod permanent;
mod rows;
mod scenes_friction;
mod scenes_hard;
mod scenes_momentum;
mod scenes_springs;

mod shares;
mod soft;
mod solving;
mod step_scenes;
mod units;
