//! Report of overlap removal: rounds, bodies that moved, pairs that remain.

use musculo_collide::{
    BodyId, BodyKind, DepthBracket, GapObstacle, Obstacle, PairId, Remaining, Resolution, Scene,
};

use super::table::{Table, dash, left, right};
use super::text::{counted, grouped, length, measure};
use crate::scene::Unit;

/// Remedy for a pair that nothing moves.
const IGNORE_PAIR: &str = "[[ignore]] in a scene file leaves the pair out";

/// Names the bodies that were wholly inside another one and are not any more: they may have been meant to be there.
pub(crate) fn pushed_out(resolution: &Resolution, scene: &Scene) -> Vec<String> {
    let mut pushed = Vec::new();
    for report in resolution.before.iter().filter(|report| report.crossing_faces.is_empty()) {
        let PairId { a, b, .. } = report.pair;
        let is_left = resolution.remaining.iter().any(|left| left.pair == report.pair);
        for (id, other, side) in [(a, b, &report.a_against_b), (b, a, &report.b_against_a)] {
            let [body, outer] = [id, other].map(|id| scene.body(id));
            if !is_left && side.inside_count == Ok(body.positions().len()) {
                let (name, outer) = (body.name(), outer.name());
                pushed.push(format!(
                    "'{name}' was wholly inside '{outer}', and is pushed out of it: {IGNORE_PAIR}"
                ));
            }
        }
    }
    pushed
}

/// Writes the tables of rounds and bodies, and the remaining pairs with their reasons.
///
/// With `keep_going` the best state is the result, also where it breaks limits. `overlaps_in_files` is the number
/// of pairs that overlap in what is written.
pub(crate) fn resolution_text(
    resolution: &Resolution,
    scene: &Scene,
    unit: Unit,
    keep_going: bool,
    overlaps_in_files: usize,
) -> String {
    let (rounds, bodies) = (rounds(resolution, unit), bodies(resolution, scene, unit));
    let mut text = format!("{}\n{}\n", rounds.to_text(), bodies.to_text());

    let left_out = left_out_of_rounds(resolution, scene);
    if left_out > 0 {
        let pairs = counted(left_out, "overlapping pair");
        text += &format!("Rounds leave {pairs} out.\n");
    }

    // A state that later rounds did not improve is that of an earlier round.
    let last = resolution.rounds.len().saturating_sub(1);
    if resolution.final_round < last {
        let reason = if resolution.broken_limits.is_empty() || keep_going {
            "none of the later ones was better"
        } else {
            "better ones break the limits of a body"
        };
        text += &format!("Round {} of {last} is kept: {reason}.\n", resolution.final_round);
    }

    // Of a mesh that should be closed and is not, all but the volume is kept.
    for change in resolution.bodies.iter().filter(|change| change.moved > 0) {
        let body = scene.body(change.body);
        if let (BodyKind::Deformable, Err(reason)) = (body.kind(), body.has_inside()) {
            text += &format!("The volume of {} is not kept: {reason}.\n", body.name());
        }
    }

    for body in &resolution.self_overlaps {
        let name = scene.body(*body).name();
        text += &format!("{name} still crosses itself: its parts are too deep in each other.\n");
    }

    // The verdict stands last, where a terminal shows it.
    let count = resolution.remaining.len();
    if count == 0 && overlaps_in_files > 0 {
        let overlap = if overlaps_in_files == 1 { "overlaps" } else { "overlap" };
        return text + &format!("{} {overlap} in the files.\n", counted(overlaps_in_files, "pair"));
    }
    if count == 0 {
        return match ignored_pairs(scene).len() {
            0 if resolution.self_overlaps.is_empty() => text + "Nothing overlaps any more.\n",
            0 => text + "No two bodies overlap any more.\n",
            count => {
                let ignored = counted(count, "ignored pair");
                text + &format!("Nothing overlaps any more, {ignored} left out.\n")
            }
        };
    }
    let verdict = if resolution.resolved { "Within the tolerance" } else { "Not resolved" };
    text += &format!("{verdict}: {} still overlapping.\n", counted(count, "pair"));
    for pair in &resolution.remaining {
        let [a, b] = scene.names(pair.pair);
        text += &format!("  {a} × {b}: {}\n", remaining_text(pair, unit));
    }
    text
}

/// Counts the pairs that overlap at the start and that rounds leave as they are, without those of two rigid bodies.
fn left_out_of_rounds(resolution: &Resolution, scene: &Scene) -> usize {
    let mut overlapping: usize = 0;
    for report in resolution.before.iter().filter(|report| report.overlaps) {
        let is_soft = |id: &BodyId| !scene.body(*id).is_rigid();
        overlapping += usize::from(report.pair.bodies().iter().any(is_soft));
    }
    let counted = resolution.rounds.first().map_or(0, |start| start.overlapping_pairs);
    overlapping.saturating_sub(counted)
}

/// Lists the pairs of which nothing is asked.
pub(super) fn ignored_pairs(scene: &Scene) -> Vec<PairId> {
    let ids: Vec<_> = scene.ids().collect();
    let mut ignored = Vec::new();
    for (number, &a) in ids.iter().enumerate() {
        for &b in &ids[number + 1..] {
            let pair = PairId::new(a, b);
            if scene.is_ignored(pair) {
                ignored.push(pair);
            }
        }
    }
    ignored
}

/// Writes how many pairs a statement about all pairs leaves out.
pub(super) fn left_out_text(tied: usize, ignored: usize) -> String {
    match [tied, ignored] {
        [0, 0] => String::new(),
        [tied, 0] => format!(" but {tied} tied"),
        [0, ignored] => format!(" but {ignored} ignored"),
        [tied, ignored] => format!(" but {tied} tied and {ignored} ignored"),
    }
}

/// Writes depth, crossings and reason of a pair that remains.
pub(super) fn remaining_text(pair: &Remaining, unit: Unit) -> String {
    let is_new = if pair.at_first { "" } else { ", not at the start" };
    format!(
        "{} {} deep, {} crossing{is_new}: {}",
        bracket(pair.depth, unit),
        unit.symbol(),
        counted(pair.crossing_faces, "face pair"),
        obstacle_text(&pair.obstacle, unit),
    )
}

/// Writes the reason why a pair still overlaps.
pub(super) fn obstacle_text(obstacle: &Obstacle, unit: Unit) -> String {
    match *obstacle {
        Obstacle::Squeezed { room, thickness } => squeeze_text(room, thickness, unit),
        Obstacle::SqueezedTogether { room, thickness } => {
            let ([room, thickness], unit) = ([room, thickness].map(measure), unit.symbol());
            format!(
                "no room: rigid bodies leave {room} {unit}, both bodies together are {thickness} {unit} thick"
            )
        }
        Obstacle::BothRigid => format!("{obstacle}; {IGNORE_PAIR}"),
        _ => obstacle.to_string(),
    }
}

/// Writes the reason why a pair is nearer than the gap.
pub(super) fn gap_obstacle_text(obstacle: &GapObstacle, unit: Unit) -> String {
    match *obstacle {
        GapObstacle::Squeezed { room, thickness, gap } => {
            let text = squeeze_text(room, thickness, unit);
            format!("{text} and needs {} {} on either side", measure(gap), unit.symbol())
        }
        GapObstacle::BothRigid => format!("{obstacle}; {IGNORE_PAIR}"),
        _ => obstacle.to_string(),
    }
}

fn squeeze_text(room: f64, thickness: f64, unit: Unit) -> String {
    let ([room, thickness], unit) = ([room, thickness].map(measure), unit.symbol());
    format!("no room: rigid bodies leave {room} {unit}, the body is {thickness} {unit} thick")
}

/// Writes a depth as a range, where its ends differ in the digits that are written.
pub(super) fn bracket(DepthBracket { lower, upper }: DepthBracket, unit: Unit) -> String {
    let [lower, upper] = [lower, upper].map(|depth| length(depth, unit));
    if lower == upper { lower } else { format!("{lower} to {upper}") }
}

fn rounds(resolution: &Resolution, unit: Unit) -> Table {
    let mut table = Table::new([
        right("round"),
        right("overlapping pairs"),
        right("new"),
        right("crossing faces"),
        right(format!("deepest vertex or edge [{}]", unit.symbol())),
        right(format!("depth of surfaces [{}]", unit.symbol())),
    ]);

    // Round 0 is the state at the start.
    for (number, round) in resolution.rounds.iter().enumerate() {
        table.row([
            number.to_string(),
            grouped(round.overlapping_pairs),
            grouped(round.new_pairs),
            grouped(round.crossing_faces),
            length(round.max_depth, unit),
            round.surface_depth.map_or_else(dash, |depth| length(depth.lower, unit)),
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

    // Bodies that stayed, such as bones, have nothing to report.
    for change in &resolution.bodies {
        if change.moved == 0 {
            continue;
        }
        let volume = match change.volume_ratio {
            Some(ratio) => format!("{:+.3}", 100.0 * (ratio - 1.0)),
            None => dash(),
        };
        let [before, after] = change.self_crossings;
        table.row([
            scene.body(change.body).name().to_owned(),
            grouped(change.displacements.len()),
            grouped(change.moved),
            length(change.max_displacement, unit),
            volume,
            grouped(change.flipped_faces),
            format!("{before} -> {after}"),
        ]);
    }
    table
}
