//! Tests of plans.

mod detect;
mod steady;
