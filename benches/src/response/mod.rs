//! Contact responses beside plain memory sweeps and slow twins.

pub mod scenes;
