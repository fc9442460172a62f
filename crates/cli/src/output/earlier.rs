//! Files in the folder of an output that the run does not write: as a rule, those of an earlier run.

use std::collections::BTreeSet;
use std::fmt;
use std::fs;
use std::path::{Path, PathBuf};

use crate::report::counted;

/// Folder of files that are named after bodies.
#[derive(Debug)]
pub(super) struct BodyFolder {
    pub(super) folder: PathBuf,
    pub(super) bodies: Vec<String>,
}

/// Files of bodies in a folder, beside those of the run.
#[derive(Debug)]
pub(crate) struct EarlierFiles {
    folder: PathBuf,
    count: usize,
    /// First of their names.
    first: String,
}

impl BodyFolder {
    /// Finds files of the bodies that have one of the `extensions`, but are no `own` files.
    ///
    /// A folder that cannot be listed has none.
    pub(super) fn earlier_files(
        &self,
        extensions: &BTreeSet<&str>,
        is_own: impl Fn(&Path) -> bool,
    ) -> Option<EarlierFiles> {
        let mut names = BTreeSet::new();
        for entry in fs::read_dir(&self.folder).ok()?.flatten() {
            let path = entry.path();
            let name = entry.file_name().to_string_lossy().into_owned();
            let is_kind = extensions.contains(extension(&path));
            if is_kind && self.has_body_of(&name) && path.is_file() && !is_own(&path) {
                names.insert(name);
            }
        }
        let first = names.first()?.clone();
        Some(EarlierFiles { folder: self.folder.clone(), count: names.len(), first })
    }

    /// Returns true if a name is that of a body, with more behind an underscore, or with an extension.
    fn has_body_of(&self, name: &str) -> bool {
        let mut rests = self.bodies.iter().filter_map(|body| name.strip_prefix(body.as_str()));
        rests.any(|rest| rest.starts_with(['_', '.']))
    }
}

/// Returns the extension of a path, empty where there is none.
pub(super) fn extension(path: &Path) -> &str {
    path.extension().and_then(|extension| extension.to_str()).unwrap_or_default()
}

impl fmt::Display for EarlierFiles {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { folder, count, first } = self;
        let (files, folder) = (counted(*count, "file"), folder.display());
        let verb = if *count == 1 { "is" } else { "are" };
        write!(
            f,
            "{folder} has {files} of these bodies that {verb} not of this run, such as {first}: remove \
             what an earlier run has left, or choose another folder"
        )
    }
}
