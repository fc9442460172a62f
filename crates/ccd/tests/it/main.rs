//! Tests of queries and batches as a caller uses them.

mod batch;
mod collinear;
mod contacts;
mod curved;
#[cfg(feature = "exact")]
mod lattice;
mod published;
mod query_files;
mod random;
mod separation;
mod thin;
