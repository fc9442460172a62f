//! A plan in words.

use std::fmt;

use super::{Plan, StructureKind, count};
use scene::BodyId;

impl fmt::Display for Plan {
    /// What was built for which body, how each pair is looked at, and what is
    /// left out for which reason.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.write_head(f)?;
        self.write_structures(f)?;
        self.write_pairs(f)?;
        self.write_left_out(f)
    }
}

impl Plan {
    fn write_head(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let milliseconds = 1e3 * self.predicted().as_secs_f64();
        write!(f, "tolerance {}", self.tolerance)?;
        if self.tolerance > self.params.tolerance {
            write!(f, ", given up for the budget: {}", self.params.tolerance)?;
        }
        write!(f, "; margin {}; {milliseconds:.1} ms a frame predicted", self.params.margin)?;
        if !self.keeps_budget() {
            write!(f, ", over the budget")?;
        }
        writeln!(f)
    }

    fn write_structures(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let width = self.name_width();
        writeln!(
            f,
            "\n{:<width$}  {:<16} {:>9} {:>9} {:>9}",
            "body", "built", "size", "error", "MB"
        )?;
        for built in &self.listed {
            let spacing = built.spacing.map_or(String::new(), |h| format!("  spacing {h:.3}"));
            let megabytes = count(built.bytes) / 1e6;
            writeln!(
                f,
                "{:<width$}  {:<16} {:>9} {:>9.4} {megabytes:>9.2}{spacing}",
                self.name(built.body),
                built.kind,
                built.size,
                built.error_bound,
            )?;
        }
        for (body, kind, reason) in &self.not_built {
            let is_bare = !self.listed.iter().any(|built| built.body == *body);
            if *kind != StructureKind::Tree || is_bare {
                writeln!(f, "{:<width$}  no {kind}: {reason}", self.name(*body))?;
            }
        }
        Ok(())
    }

    fn write_pairs(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let width = self.name_width();
        writeln!(
            f,
            "\n{:<width$}  {:<width$}  {:<12} {:>9} {:>9}",
            "a", "b", "looked at", "error", "µs"
        )?;
        for pair in &self.pairs {
            let why = pair
                .fallback_reason
                .as_ref()
                .map_or(String::new(), |why| format!("  no field: {why}"));
            writeln!(
                f,
                "{:<width$}  {:<width$}  {:<12} {:>9.4} {:>9.1}{why}",
                self.name(pair.a),
                self.name(pair.b),
                pair.method,
                pair.error_bound,
                1e6 * pair.cost,
            )?;
        }
        Ok(())
    }

    fn write_left_out(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let width = self.name_width();
        for pair in &self.excluded_pairs {
            let [a, b] = [pair.a, pair.b].map(|id| self.name(id));
            writeln!(f, "{a:<width$}  {b:<width$}  not looked at: {}", pair.reason)?;
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
