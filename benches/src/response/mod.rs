//! Contact responses beside plain memory sweeps and reference implementations.

pub mod scenes;
