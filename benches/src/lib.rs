//! Benchmarks: figures beside peers, tables, charts of accuracy over time, and endurance.
//!
//! The program `benches` runs them all; `cargo xtask ratios`, `chart` and `soak` call it. The bench
//! target `figures` runs the same figures under Criterion:
//! `cargo bench -p benches --features criterion -- kdop`.
//!
//! # Features
//!
//! - `charts` (default): what needs the facade or draws: charts and endurance. Figures build in
//!   half the time without it.
//! - `figures`: figures, as far as they need no other library.
//! - `peers`: other libraries, and all that is compared with them: further figures and two charts.
//! - `criterion`: the target `figures`.

pub mod bodies;
pub mod ccd;
#[cfg(feature = "charts")]
pub mod chart;
#[cfg(feature = "charts")]
pub mod floors;
#[cfg(feature = "charts")]
pub mod gait;
pub mod measure;
pub mod medial_contact;
pub mod medial_report;
#[cfg(feature = "peers")]
pub mod peers;
#[cfg(feature = "figures")]
pub mod ratios;
#[cfg(feature = "charts")]
pub mod regret;
pub mod sheets;
#[cfg(feature = "charts")]
pub mod soak;
#[cfg(all(feature = "charts", feature = "peers"))]
pub mod source_figures;
#[cfg(feature = "charts")]
pub mod stability;
pub mod trees;
pub mod volumes;

/// Returns the entries of the given names, or all without a name.
#[cfg(any(feature = "charts", feature = "figures"))]
fn selected<T: Copy>(
    all: &[(&'static str, T)],
    names: &[String],
) -> Result<Vec<(&'static str, T)>, String> {
    let known: Vec<&str> = all.iter().map(|(name, _)| *name).collect();
    if let Some(name) = names.iter().find(|name| !known.contains(&name.as_str())) {
        return Err(format!("there is no {name}: choose from {}", known.join(", ")));
    }
    let mut chosen = all.to_vec();
    chosen.retain(|(name, _)| names.is_empty() || names.iter().any(|wanted| wanted == name));
    Ok(chosen)
}
