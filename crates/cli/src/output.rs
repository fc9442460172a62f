//! Files out, whole or not at all: everything is written beside its place
//! first and moved there only when all of it is on disk.

use std::path::{Path, PathBuf};
use std::{fs, io};

/// A file or folder that could not be written.
#[derive(Debug, thiserror::Error)]
#[error("{path}: cannot be written: {problem}", path = .path.display())]
pub(crate) struct OutputError {
    path: PathBuf,
    problem: io::Error,
}

/// Files that are written and not yet in their places. Dropping this removes
/// them again.
#[derive(Debug, Default)]
pub(crate) struct Outputs {
    staged: Vec<Staged>,
    folders: Vec<PathBuf>,
}

#[derive(Debug)]
struct Staged {
    beside: PathBuf,
    path: PathBuf,
}

impl Outputs {
    /// Makes a folder, where there is none yet.
    pub(crate) fn folder(&mut self, path: &Path) -> Result<(), OutputError> {
        let is_new = !path.exists();
        fs::create_dir_all(path).map_err(|problem| failed(path, problem))?;
        if is_new {
            self.folders.push(path.to_owned());
        }
        Ok(())
    }

    /// Writes a file beside its place.
    pub(crate) fn stage(&mut self, path: &Path, bytes: &[u8]) -> Result<(), OutputError> {
        if path.is_dir() {
            return Err(failed(path, io::ErrorKind::IsADirectory.into()));
        }
        let name =
            path.file_name().ok_or_else(|| failed(path, io::ErrorKind::InvalidFilename.into()))?;
        let mut hidden = std::ffi::OsString::from(".");
        hidden.push(name);
        hidden.push(format!(".{}.tmp", std::process::id()));
        let beside = path.with_file_name(hidden);
        // Known before it is written, so that a half-written file goes too.
        self.staged.push(Staged { beside: beside.clone(), path: path.to_owned() });
        fs::write(&beside, bytes).map_err(|problem| failed(path, problem))
    }

    /// Moves every file to its place, in the order they were staged; returns
    /// the paths.
    pub(crate) fn commit(mut self) -> Result<Vec<PathBuf>, OutputError> {
        let mut written = Vec::new();
        self.folders.clear();
        while !self.staged.is_empty() {
            let Staged { beside, path } = &self.staged[0];
            fs::rename(beside, path).map_err(|problem| failed(path, problem))?;
            written.push(self.staged.remove(0).path);
        }
        Ok(written)
    }
}

impl Drop for Outputs {
    fn drop(&mut self) {
        for Staged { beside, .. } in &self.staged {
            let _ = fs::remove_file(beside);
        }
        for folder in self.folders.iter().rev() {
            let _ = fs::remove_dir(folder); // keeps what others have put there
        }
    }
}

fn failed(path: &Path, problem: io::Error) -> OutputError {
    OutputError { path: path.to_owned(), problem }
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
    fn nothing_is_in_its_place_before_all_is_written() {
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
        assert!(error.to_string().contains("missing/b: cannot be written"), "{error}");
        drop(outputs);
        assert_eq!(names(folder.path()), Vec::<String>::new());
    }
}
