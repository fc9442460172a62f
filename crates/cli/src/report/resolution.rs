//! Report of overlap removal: rounds, bodies that moved, pairs that remain.

use musculo_collide::{Remaining, Resolution, Scene};

use super::check_tables::dash;
use super::table::{Table, left, right};
use super::text::{counted, grouped, length};
use crate::scene::Unit;

/// Writes the tables of rounds and bodies, and the remaining pairs with their reasons.
pub(crate) fn resolution_text(resolution: &Resolution, scene: &Scene, unit: Unit) -> String {
    let (rounds, bodies) = (rounds(resolution, unit), bodies(resolution, scene, unit));
    let mut text = format!("{}\n{}\n", rounds.to_text(), bodies.to_text());

    let count = resolution.remaining.len();
    if count == 0 {
        return text + "Nothing overlaps any more.\n";
    }
    let verdict = if resolution.resolved { "Within the tolerance" } else { "Not resolved" };
    text += &format!("{verdict}: {} still overlapping.\n", counted(count, "pair"));
    for pair in &resolution.remaining {
        let [a, b] = pair.pair.bodies().map(|id| scene.body(id).name());
        text += &format!("  {a} × {b}: {}\n", remaining_text(pair, unit));
    }
    text
}

/// Writes depth, crossings and reason of a pair that remains.
pub(super) fn remaining_text(pair: &Remaining, unit: Unit) -> String {
    let is_new = if pair.at_first { "" } else { ", not at the start" };
    format!(
        "{} {} deep, {} crossing{is_new}: {}",
        length(pair.depth, unit),
        unit.symbol(),
        counted(pair.crossing_faces, "face pair"),
        pair.obstacle,
    )
}

fn rounds(resolution: &Resolution, unit: Unit) -> Table {
    let mut table = Table::new([
        right("round"),
        right("overlapping pairs"),
        right("new"),
        right("crossing faces"),
        right(format!("deepest [{}]", unit.symbol())),
    ]);
    for (number, round) in resolution.rounds.iter().enumerate() {
        table.row([
            number.to_string(),
            grouped(round.overlapping_pairs),
            grouped(round.new_pairs),
            grouped(round.crossing_faces),
            length(round.max_depth, unit),
        ]);
    }
    table
}

fn bodies(resolution: &Resolution, scene: &Scene, unit: Unit) -> Table {
    let mut table = Table::new([
        left("body"),
        right("vertices"),
        right("moved"),
        right(format!("max displacement [{}]", unit.symbol())),
        right("volume [%]"),
        right("flipped faces"),
        right("self-crossings"),
    ]);
    for change in resolution.bodies.iter().filter(|change| change.moved > 0) {
        let percent = change.volume_ratio.map(|ratio| 100.0 * (ratio - 1.0));
        let [before, after] = change.self_crossings;
        table.row([
            scene.body(change.body).name().to_owned(),
            grouped(change.displacements.len()),
            grouped(change.moved),
            length(change.max_displacement, unit),
            percent.map_or_else(dash, |percent| format!("{percent:+.3}")),
            grouped(change.flipped_faces),
            format!("{before} -> {after}"),
        ]);
    }
    table
}
