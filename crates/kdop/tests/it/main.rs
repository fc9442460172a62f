//! Tests of trees as a caller uses them.

mod golden;
mod no_pair_lost;
mod reference;
mod rejected_input;
mod steps;
