//! Tests of overlap removal.

mod anatomy;
mod planted;
mod thigh;
