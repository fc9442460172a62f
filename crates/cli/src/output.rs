//! Output files, written completely or not at all: each is written beside its place, and
//! moved there once all of them are on disk.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::{fs, io};

use serde::Serialize;

use crate::failure::Failure;

/// Files that are written but not yet in their places. Dropping this removes them.
#[derive(Debug, Default)]
pub(crate) struct Outputs {
    staged: Vec<StagedFile>,
    /// Folders that did not exist before.
    folders: Vec<PathBuf>,
}

#[derive(Debug)]
struct StagedFile {
    beside: PathBuf,
    path: PathBuf,
}

impl Outputs {
    /// Creates a folder where there is none.
    pub(crate) fn folder(&mut self, path: &Path) -> Result<(), Failure> {
        let is_new = !path.exists();
        fs::create_dir_all(path).map_err(|problem| failed(path, problem))?;
        if is_new {
            self.folders.push(path.to_owned());
        }
        Ok(())
    }

    /// Writes a file beside its place.
    pub(crate) fn stage(&mut self, path: &Path, content: impl AsRef<[u8]>) -> Result<(), Failure> {
        if path.is_dir() {
            return Err(failed(path, io::ErrorKind::IsADirectory.into()));
        }
        let Some(name) = path.file_name() else {
            return Err(failed(path, io::ErrorKind::InvalidFilename.into()));
        };
        let mut hidden = OsString::from(".");
        hidden.push(name);
        hidden.push(format!(".{}.tmp", std::process::id()));
        let beside = path.with_file_name(hidden);

        // Listed before it is written, so that a half-written file is removed too.
        self.staged.push(StagedFile { beside: beside.clone(), path: path.to_owned() });
        fs::write(&beside, content).map_err(|problem| failed(path, problem))
    }

    /// Writes a report as JSON beside its place, if there is a path for it.
    pub(crate) fn stage_json(
        &mut self,
        path: Option<&Path>,
        report: &impl Serialize,
    ) -> Result<(), Failure> {
        let Some(path) = path else { return Ok(()) };
        self.stage(path, serde_json::to_string_pretty(report)? + "\n")
    }

    /// Moves every file to its place, in the order of staging, and returns the paths.
    pub(crate) fn commit(mut self) -> Result<Vec<PathBuf>, Failure> {
        self.folders.clear();
        let mut written = Vec::new();
        while let Some(StagedFile { beside, path }) = self.staged.first() {
            fs::rename(beside, path).map_err(|problem| failed(path, problem))?;
            written.push(self.staged.remove(0).path);
        }
        Ok(written)
    }
}

impl Drop for Outputs {
    fn drop(&mut self) {
        for StagedFile { beside, .. } in &self.staged {
            let _ = fs::remove_file(beside);
        }
        // A folder stays if another program has put files there.
        for folder in self.folders.iter().rev() {
            let _ = fs::remove_dir(folder);
        }
    }
}

fn failed(path: &Path, problem: io::Error) -> Failure {
    Failure::in_file(path, format!("cannot be written: {problem}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        let mut names: Vec<String> =
            entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn files_move_to_their_places_once_all_are_written() {
        let folder = tempfile::tempdir().unwrap();
        let inner = folder.path().join("inner");
        let mut outputs = Outputs::default();
        outputs.stage(&folder.path().join("a"), b"1").unwrap();
        outputs.folder(&inner).unwrap();
        outputs.stage(&inner.join("b"), b"2").unwrap();
        assert!(!folder.path().join("a").exists() && !inner.join("b").exists());
        assert_eq!(outputs.commit().unwrap(), [folder.path().join("a"), inner.join("b")]);
        assert_eq!(names(folder.path()), ["a", "inner"]);
        assert_eq!(fs::read(inner.join("b")).unwrap(), b"2");
    }

    #[test]
    fn a_failure_leaves_nothing_behind() {
        let folder = tempfile::tempdir().unwrap();
        let mut outputs = Outputs::default();
        outputs.folder(&folder.path().join("new")).unwrap();
        outputs.stage(&folder.path().join("new/a"), b"1").unwrap();
        let error = outputs.stage(&folder.path().join("missing/b"), b"2").unwrap_err();
        assert!(error.problems[0].contains("missing/b: cannot be written"), "{error:?}");
        drop(outputs);
        assert_eq!(names(folder.path()), Vec::<String>::new());
    }
}
