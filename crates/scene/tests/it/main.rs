//! Tests of detection over whole scenes.

mod check;
mod medial;
mod overlap;
mod support;
mod sweep;
