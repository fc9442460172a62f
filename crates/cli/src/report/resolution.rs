//! What a resolution did, as text.

use musculo_collide::{BodyChange, Resolution, Round, Scene};

use super::text::counted;
use crate::scene::Unit;

/// Rounds, bodies that moved, what remains and why.
pub(crate) fn resolution_table(resolution: &Resolution, scene: &Scene, unit: Unit) -> String {
    let symbol = unit.symbol();
    let mut text = rounds(&resolution.rounds, symbol);
    text += &bodies(resolution, scene, symbol);
    text += &remaining(resolution, scene, symbol);
    text
}

fn rounds(rounds: &[Round], symbol: &str) -> String {
    let mut text = format!("round  overlapping pairs  new  crossing faces  deepest [{symbol}]\n");
    for (number, round) in rounds.iter().enumerate() {
        text += &format!(
            "{number:>5}  {:>17}  {:>3}  {:>14}  {:>12.4}\n",
            round.overlapping_pairs, round.new_pairs, round.crossing_faces, round.max_depth
        );
    }
    text
}

fn bodies(resolution: &Resolution, scene: &Scene, symbol: &str) -> String {
    let name = |change: &BodyChange| scene.body(change.body).name().to_owned();
    let moved: Vec<&BodyChange> =
        resolution.bodies.iter().filter(|change| change.moved > 0).collect();
    let width = moved.iter().map(|change| name(change).len()).max().unwrap_or(0).max(4);
    let mut text = format!(
        "\n{:<width$}  vertices moved   farthest [{symbol}]  volume change  flipped  self-crossings\n",
        "body"
    );
    for change in moved {
        let count = change.displacements.len();
        let volume = change
            .volume_ratio
            .map_or("-".to_owned(), |ratio| format!("{:+.3} %", 100.0 * (ratio - 1.0)));
        let [before, after] = change.self_crossings;
        text += &format!(
            "{:<width$}  {:>6} / {count:<6}  {:>14.4}  {volume:>13}  {:>7}  {before} -> {after}\n",
            name(change),
            change.moved,
            change.max_displacement,
            change.flipped_faces,
        );
    }
    text
}

fn remaining(resolution: &Resolution, scene: &Scene, symbol: &str) -> String {
    if resolution.remaining.is_empty() {
        return "\nNothing overlaps any more.\n".to_owned();
    }
    let what = if resolution.resolved { "All within the tolerance" } else { "Not resolved" };
    let pairs = counted(resolution.remaining.len(), "pair");
    let mut text = format!("\n{what}: {pairs} still overlapping.\n");
    for pair in &resolution.remaining {
        let new = if pair.at_first { "" } else { " (not at first)" };
        text += &format!(
            "  {} and {}: {:.4} {symbol} deep, {} crossing{new}: {}\n",
            scene.body(pair.pair.a).name(),
            scene.body(pair.pair.b).name(),
            pair.depth,
            counted(pair.crossing_faces, "face pair"),
            pair.obstacle,
        );
    }
    text
}
