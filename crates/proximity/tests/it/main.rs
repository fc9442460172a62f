//! Tests of proximity queries.

mod regions;
mod surface_tree;
