//! Tests of detection over whole scenes.

mod check;
mod closest_pairs;
mod kept_contacts;
mod medial;
mod overlap;
mod simplex_step;
mod step;
mod step_detectors;
mod step_memory;
mod step_sides;
mod step_sweep;
mod support;
mod sweep;
mod sweep_paths;
mod units;
