//! Plan as a table in plain text.

use std::collections::BTreeMap;
use std::fmt;

use scene::BodyId;

use crate::accuracy::length;
use crate::cost::count;
use crate::{Plan, PlanParams};

impl fmt::Display for Plan {
    /// Writes the structures of each body, the method of each planned pair, and the numbers of
    /// other pairs with the reasons.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.write_head(f)?;
        self.write_structures(f)?;
        self.write_pairs(f)?;
        self.write_other_pairs(f)
    }
}

impl Plan {
    fn write_head(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let PlanParams { tolerance, margin, frames, .. } = self.params;
        write!(f, "tolerance {tolerance}; margin {margin}; ")?;
        match frames {
            1 => write!(f, "1 frame")?,
            _ => write!(f, "{frames} frames")?,
        }

        // Without alternatives, nothing is counted before the first frame.
        let milliseconds = 1e3 * self.predicted_time().as_secs_f64();
        if milliseconds > 0.0 {
            write!(f, ", {milliseconds:.1} ms each by operation counts")?;
        }
        writeln!(f)
    }

    fn write_structures(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // One line per structure, with its bound, the measured error and its predicted time.
        let width = self.name_width();
        write!(f, "\n{:<width$}  {:<15} {:>9} ", "body", "built", "size")?;
        writeln!(f, "{:>9}         {:>9} {:>9} {:>9}", "bound", "measured", "MB", "ms")?;
        for built in &self.built {
            let megabytes = count(built.bytes) / 1e6;
            let milliseconds = 1e3 * self.params.machine_factor * built.operations.seconds();
            write!(f, "{:<width$}  {:<15} ", self.name(built.body), built.kind)?;
            write!(f, "{:>9} {} ", built.size, built.accuracy)?;
            write!(f, "{megabytes:>9.2} {milliseconds:>9.1}")?;
            match built.spacing {
                Some(spacing) => writeln!(f, "  spacing {}", length(spacing))?,
                None => writeln!(f)?,
            }
        }

        // What could not be built, with the reason.
        for missing in &self.missing {
            let name = self.name(missing.body);
            writeln!(f, "{name:<width$}  no {}: {}", missing.kind, missing.reason)?;
        }
        Ok(())
    }

    /// Writes one line per planned pair, but for those that cost and hold nothing.
    fn write_pairs(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let width = self.name_width();
        write!(f, "\n{:<width$}  {:<width$}  {:<6} ", "a", "b", "method")?;
        writeln!(f, "{:>9}         {:>9} {:>9}", "bound", "measured", "µs")?;
        let mut folded = 0;
        for (planned, detector) in self.pairs.iter().zip(&self.detectors) {
            if detector.is_counted && detector.holds_nothing() {
                folded += 1;
                continue;
            }
            let microseconds = 1e6 * planned.cost;
            let [a, b] = planned.pair.bodies().map(|id| self.name(id));
            write!(f, "{a:<width$}  {b:<width$}  {:<6} ", planned.method)?;
            writeln!(f, "{} {microseconds:>9.1}", planned.accuracy)?;
        }
        match folded {
            0 => Ok(()),
            1 => writeln!(f, "1 more pair, which does not meet"),
            _ => writeln!(f, "{folded} more pairs, which do not meet"),
        }
    }

    /// Writes the numbers of pairs that are not in the plan, one line per reason.
    fn write_other_pairs(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Bones that lie against bones, mostly.
        let mut counts = BTreeMap::new();
        for excluded in &self.excluded_pairs {
            *counts.entry(excluded.reason.to_string()).or_insert(0_usize) += 1;
        }
        for (reason, count) in counts {
            writeln!(f, "{count} pairs near each other excluded: {reason}")?;
        }

        // All the rest, which are not even listed.
        if self.far_pair_count > 0 {
            let count = self.far_pair_count;
            writeln!(f, "{count} pairs farther apart: detected by surfaces once they come near")?;
        }
        Ok(())
    }

    fn name(&self, id: BodyId) -> &str {
        &self.bodies[id.index()].name
    }

    fn name_width(&self) -> usize {
        self.bodies.iter().map(|body| body.name.chars().count()).max().unwrap_or(0).max(4)
    }
}
