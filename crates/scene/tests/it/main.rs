//! Tests of detection over whole scenes.

mod check;
mod medial;
mod support;
mod sweep;
