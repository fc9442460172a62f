//! The program, run as a user runs it.

mod anatomy;
mod bad_input;
mod check;
mod field;
mod files;
mod first_try;
mod joint;
mod medial;
mod motion;
mod motion_tables;
mod overlap;
mod page;
mod plan;
mod range;
mod resolve;
mod support;
