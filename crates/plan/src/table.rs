//! Plan as a table in plain text.

use std::collections::BTreeMap;
use std::fmt;

use scene::BodyId;

use crate::Plan;
use crate::cost::count;

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
        let milliseconds = 1e3 * self.predicted_time().as_secs_f64();
        write!(f, "tolerance {}", self.tolerance)?;
        if self.tolerance > self.params.tolerance {
            write!(f, " ({} exceeds the budget)", self.params.tolerance)?;
        }
        write!(f, "; margin {}; ", self.params.margin)?;
        write!(f, "{milliseconds:.1} ms per frame predicted")?;
        if !self.is_within_budget() {
            write!(f, ", over the budget")?;
        }
        writeln!(f)
    }

    fn write_structures(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // One line per structure, with its error and whether that is proved.
        let width = self.name_width();
        write!(f, "\n{:<width$}  {:<16} ", "body", "built")?;
        writeln!(f, "{:>9} {:>9} {:>18}", "size", "error", "MB")?;
        for built in &self.built {
            let megabytes = count(built.bytes) / 1e6;
            write!(f, "{:<width$}  {:<16} ", self.name(built.body), built.kind)?;
            write!(f, "{:>9} {} {megabytes:>9.2}", built.size, built.error)?;
            match built.spacing {
                Some(spacing) => writeln!(f, "  spacing {spacing:.3}")?,
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

    fn write_pairs(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // One line per planned pair.
        let width = self.name_width();
        write!(f, "\n{:<width$}  {:<width$}  ", "a", "b")?;
        writeln!(f, "{:<8} {:>9} {:>18}", "method", "error", "µs")?;
        for planned in &self.pairs {
            let microseconds = 1e6 * planned.cost;
            let [a, b] = planned.pair.bodies().map(|id| self.name(id));
            write!(f, "{a:<width$}  {b:<width$}  {:<8} ", planned.method)?;
            write!(f, "{} {microseconds:>9.1}", planned.error)?;
            match &planned.fallback_reason {
                Some(reason) => writeln!(f, "  no field: {reason}")?,
                None => writeln!(f)?,
            }
        }
        Ok(())
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
