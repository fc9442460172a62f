//! Formats of outputs, each by its extension.

use std::path::Path;

use super::earlier::extension;

/// Format of an output of which there is one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct OutputFormat {
    /// Content, as in "a picture".
    content: &'static str,
    /// Extension, in lower case and without a dot.
    extension: &'static str,
}

impl OutputFormat {
    pub(crate) const PICTURE: Self = Self { content: "a picture", extension: "png" };
    pub(crate) const TABLE: Self = Self { content: "a table", extension: "csv" };
    pub(crate) const REPORT: Self = Self { content: "a report", extension: "html" };
    pub(crate) const CHART: Self = Self { content: "a chart", extension: "svg" };
    pub(crate) const BALLS: Self = Self { content: "a medial surface", extension: "ma" };
    pub(crate) const VTP: Self = Self { content: "a surface with distances", extension: "vtp" };

    /// Checks that a file has the extension of the format, or none; returns the problem otherwise.
    pub(super) fn check(self, path: &Path) -> Result<(), String> {
        let own = extension(path);
        if path.extension().is_none() || own.eq_ignore_ascii_case(self.extension) {
            return Ok(());
        }
        Err(format!("unknown format of {}: expected .{}", self.content, self.extension))
    }
}
