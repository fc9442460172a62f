//! Tests of proximity queries.

mod brute_force;
mod contact;
mod inverted_parts;
mod pair;
mod regions;
mod surface_tree;
mod swept;
