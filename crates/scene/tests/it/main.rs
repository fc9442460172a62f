//! Tests of detection over whole scenes.

mod check;
mod medial;
mod segment;
mod support;
mod sweep;
