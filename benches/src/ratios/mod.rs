//! Figures of each crate, held to their bounds.

mod ccd;
mod distance_field;
mod kdop;
mod kdop_peers;
mod medial;
mod overlap;
mod response;

use std::error::Error;

use crate::measure::Report;

type Run = fn(&mut Report) -> Result<(), Box<dyn Error>>;

/// Crates with figures.
const GROUPS: [(&str, Run); 6] = [
    ("ccd", ccd::run),
    ("distance-field", distance_field::run),
    ("kdop", kdop::run),
    ("medial", medial::run),
    ("overlap", overlap::run),
    ("response", response::run),
];

/// Prints the figures of the named crates, or of all without a name.
///
/// # Errors
///
/// When no figures belong to a name, or a scene cannot be set up.
pub fn run(names: &[String], report: &mut Report) -> Result<(), Box<dyn Error>> {
    if let Some(name) = names.iter().find(|name| GROUPS.iter().all(|(group, _)| group != name)) {
        let known = GROUPS.map(|(group, _)| group).join(", ");
        return Err(format!("no figures belong to {name}: choose from {known}").into());
    }
    for (group, run) in GROUPS {
        if names.is_empty() || names.iter().any(|name| name == group) {
            report.begin(group);
            run(report)?;
        }
    }
    Ok(())
}
