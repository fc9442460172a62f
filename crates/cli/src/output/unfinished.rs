//! Files on disk that are not in their places yet, for the removal on interruption.

use std::collections::BTreeSet;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Unfinished files and new folders of the process.
///
/// Files are made, moved and removed under the lock, so that an interruption meets a
/// complete list.
static UNFINISHED: Mutex<Unfinished> =
    Mutex::new(Unfinished { files: BTreeSet::new(), folders: BTreeSet::new() });

/// Paths of unfinished files, and of folders that did not exist before.
#[derive(Debug)]
pub(super) struct Unfinished {
    files: BTreeSet<PathBuf>,
    folders: BTreeSet<PathBuf>,
}

/// Locks the list of this process.
pub(super) fn unfinished() -> MutexGuard<'static, Unfinished> {
    // The list is complete even where a thread panicked with the lock.
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes all unfinished files of the process, and calls `exit` before another one can be
/// made.
pub(crate) fn remove_unfinished(exit: fn()) {
    let mut unfinished = unfinished();

    // What cannot be removed stays: the process ends in any case.
    for file in std::mem::take(&mut unfinished.files) {
        let _ = fs::remove_file(file);
    }

    // Inner folders stand behind outer ones.
    for folder in std::mem::take(&mut unfinished.folders).iter().rev() {
        let _ = fs::remove_dir(folder);
    }
    exit();
}

impl Unfinished {
    /// Makes an empty file.
    pub(super) fn make_file(&mut self, path: &Path) -> io::Result<fs::File> {
        let file = fs::File::create_new(path)?;
        self.files.insert(path.to_owned());
        Ok(file)
    }

    /// Makes a folder, and all above that do not exist; returns those.
    pub(super) fn make_folder(&mut self, path: &Path) -> io::Result<Vec<PathBuf>> {
        let mut made = Vec::new();
        for folder in path.ancestors().take_while(|folder| !folder.exists()) {
            made.push(folder.to_owned());
        }

        // Others may make the same folders meanwhile; those are kept if they fill them.
        fs::create_dir_all(path)?;
        self.folders.extend(made.iter().cloned());
        Ok(made)
    }

    /// Moves a finished file to its place.
    pub(super) fn move_file(&mut self, from: &Path, to: &Path) -> io::Result<()> {
        fs::rename(from, to)?;
        self.files.remove(from);
        Ok(())
    }

    /// Removes a file that will not be finished.
    pub(super) fn remove_file(&mut self, path: &Path) {
        self.files.remove(path);
        let _ = fs::remove_file(path);
    }

    /// Removes a new folder, unless another program has put files there.
    pub(super) fn remove_folder(&mut self, path: &Path) {
        self.folders.remove(path);
        let _ = fs::remove_dir(path);
    }

    /// Keeps a new folder.
    pub(super) fn keep_folder(&mut self, path: &Path) {
        self.folders.remove(path);
    }
}
