//! Tests of proximity queries.

mod pair;
mod regions;
mod surface_tree;
mod swept;
