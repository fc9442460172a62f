//! Report of the first contact of each pair in a motion.

use serde::Serialize;

use super::table::{Table, dash, left, right};
use super::text::{bound, counted, fixed, measure, overlapping_text};
use crate::scene::Unit;

/// First contacts of a motion.
#[derive(Debug, Serialize)]
pub(crate) struct UntilContactDocument {
    pub(crate) unit: Unit,
    /// Number of frames of the motion.
    pub(crate) frames: usize,
    /// Pairs that overlap in the first frame, which have no first contact.
    pub(crate) overlapping: Vec<[String; 2]>,
    /// First contact of each other pair that meets, the earliest first.
    pub(crate) contacts: Vec<MeetingTimeRecord>,
}

/// Time of the first contact of two bodies.
#[derive(Debug, Serialize)]
pub(crate) struct MeetingTimeRecord {
    pub(crate) a: String,
    pub(crate) b: String,
    /// Frame before the contact.
    pub(crate) frame: usize,
    /// Fraction of the step to the next frame before which the pair does not meet.
    pub(crate) fraction: f64,
    /// The same as a time in seconds, where frames have one.
    pub(crate) time: Option<f64>,
    /// True if the pair certainly meets there, rather than comes within rounding of it.
    pub(crate) certain: bool,
    pub(crate) at: [f64; 3],
}

impl MeetingTimeRecord {
    /// Writes the time of the contact in frames.
    fn in_frames(&self) -> String {
        format!("{} + {}", self.frame, bound(self.fraction, 4))
    }
}

impl UntilContactDocument {
    /// Writes a line per pair that meets, and a summary.
    pub(crate) fn to_text(&self) -> String {
        let place = format!("at [{}]", self.unit.symbol());
        let mut table = Table::new([left("pair"), right("frame"), right("time [s]"), left(place)]);
        for record in &self.contacts {
            let MeetingTimeRecord { a, b, time, at, .. } = record;
            let (at, time) = (at.map(measure).join(", "), time.map_or_else(dash, no_later));
            table.row([format!("{a} × {b}"), record.in_frames(), time, at]);
        }

        let mut text =
            if self.contacts.is_empty() { String::new() } else { table.to_text() + "\n" };
        let free = match self.contacts.first() {
            Some(first) => format!("free to frame {}", first.in_frames()),
            None => "free to the end".to_owned(),
        };
        let (met, frames) = (counted(self.contacts.len(), "pair"), counted(self.frames, "frame"));
        text += &format!("{free}; {met} first met on the way through {frames}.\n");
        text + &overlapping_text(&self.overlapping)
    }
}

/// Writes a time, rounded down, with more decimals where it needs them.
fn no_later(time: f64) -> String {
    if time < 0.0 { fixed((1e5 * time).floor() * 1e-5, 5) } else { bound(time, 5) }
}
