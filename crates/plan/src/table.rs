//! Plan as a table in plain text.

use std::fmt;

use scene::BodyId;

use crate::cost::count;
use crate::{Plan, StructureKind};

impl fmt::Display for Plan {
    /// Writes the structures of each body, the method of each pair, and the excluded pairs with
    /// their reasons.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.write_head(f)?;
        self.write_structures(f)?;
        self.write_pairs(f)?;
        self.write_excluded_pairs(f)
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
        let width = self.name_width();
        write!(f, "\n{:<width$}  {:<16} ", "body", "built")?;
        writeln!(f, "{:>9} {:>9} {:>9}", "size", "error", "MB")?;
        for built in &self.built {
            let megabytes = count(built.bytes) / 1e6;
            write!(f, "{:<width$}  {:<16} ", self.name(built.body), built.kind)?;
            write!(f, "{:>9} {:>9.4} {megabytes:>9.2}", built.size, built.measured_error)?;
            match built.spacing {
                Some(spacing) => writeln!(f, "  spacing {spacing:.3}")?,
                None => writeln!(f)?,
            }
        }
        for missing in &self.missing {
            // A missing tree is worth a line only where nothing else was built.
            let is_bare = !self.built.iter().any(|built| built.body == missing.body);
            if missing.kind != StructureKind::Tree || is_bare {
                let name = self.name(missing.body);
                writeln!(f, "{name:<width$}  no {}: {}", missing.kind, missing.reason)?;
            }
        }
        Ok(())
    }

    fn write_pairs(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let width = self.name_width();
        write!(f, "\n{:<width$}  {:<width$}  ", "a", "b")?;
        writeln!(f, "{:<8} {:>9} {:>9}", "method", "error", "µs")?;
        for planned in &self.pairs {
            let microseconds = 1e6 * planned.cost;
            let [a, b] = planned.pair.bodies().map(|id| self.name(id));
            write!(f, "{a:<width$}  {b:<width$}  {:<8} ", planned.method)?;
            write!(f, "{:>9.4} {microseconds:>9.1}", planned.measured_error)?;
            match &planned.fallback_reason {
                Some(reason) => writeln!(f, "  no field: {reason}")?,
                None => writeln!(f)?,
            }
        }
        Ok(())
    }

    fn write_excluded_pairs(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let width = self.name_width();
        for excluded in &self.excluded_pairs {
            let [a, b] = excluded.pair.bodies().map(|id| self.name(id));
            writeln!(f, "{a:<width$}  {b:<width$}  excluded: {}", excluded.reason)?;
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
