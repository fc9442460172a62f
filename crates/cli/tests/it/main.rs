//! The program, run as a user runs it.

mod absurd;
mod anatomy;
mod bad_input;
mod check;
mod earlier;
mod febio;
mod field;
mod files;
mod finite_elements;
mod first_try;
mod joint;
mod medial;
mod motion;
mod motion_cache;
mod motion_report;
mod motion_tables;
mod motion_until;
mod options;
mod overlap;
mod page;
mod plan;
mod range;
mod resolve;
mod signals;
mod spaces;
mod support;
