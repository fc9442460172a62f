//! Tests of detection over whole scenes.

mod check;
mod field;
mod medial;
mod segment;
mod support;
mod sweep;
