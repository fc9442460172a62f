//! Report of a range of motion: the angle of the first contact of each pair.

use serde::Serialize;

use super::table::{Table, left, right};
use super::text::{bound, counted, fixed, measure, overlapping_text};
use crate::scene::Unit;

/// First contacts of a turn.
#[derive(Debug, Serialize)]
pub(crate) struct RangeDocument {
    pub(crate) unit: Unit,
    /// Largest angle, in degrees.
    pub(crate) to: f64,
    /// Pairs that overlap from the start, which have no first contact.
    pub(crate) overlapping: Vec<[String; 2]>,
    /// First contact of each other pair that meets, by angle.
    pub(crate) contacts: Vec<FirstContactRecord>,
}

/// First contact of two bodies.
#[derive(Debug, Serialize)]
pub(crate) struct FirstContactRecord {
    pub(crate) a: String,
    pub(crate) b: String,
    /// Angle in degrees before which the pair does not meet.
    pub(crate) angle: f64,
    /// True if the pair certainly meets there, rather than comes within rounding of it.
    pub(crate) certain: bool,
    pub(crate) at: [f64; 3],
}

impl RangeDocument {
    /// Writes a line per pair that meets, and a summary.
    pub(crate) fn to_text(&self) -> String {
        let place = format!("at [{}]", self.unit.symbol());
        let mut table = Table::new([left("pair"), right("angle [°]"), left(place)]);
        for FirstContactRecord { a, b, angle, at, .. } in &self.contacts {
            let at = at.map(measure).join(", ");
            table.row([format!("{a} × {b}"), bound(*angle, 4), at]);
        }

        let mut text =
            if self.contacts.is_empty() { String::new() } else { table.to_text() + "\n" };
        let summary = match self.contacts.first() {
            Some(first) => format!("free to {}°", bound(first.angle, 4)),
            None => format!("free to {}°", bound(self.to, 4)),
        };
        let met = counted(self.contacts.len(), "pair");
        text += &format!("{summary}; {met} first met on the way to {}°.\n", fixed(self.to, 4));
        text + &overlapping_text(&self.overlapping)
    }
}
