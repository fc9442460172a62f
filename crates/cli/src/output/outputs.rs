//! Outputs, written completely or not at all.

use std::collections::{BTreeSet, HashMap, VecDeque};
use std::fs::{self, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process;

use serde::Serialize;

use super::earlier::{BodyFolder, EarlierFiles, extension};
use super::places::{Destination, Places};
use super::unfinished::unfinished;
use crate::failure::Failure;
use crate::report::counted;
use crate::terminal;

/// Planned outputs, and those of them that are written but not yet in their places.
/// Dropping this removes them.
#[derive(Debug)]
pub(crate) struct Outputs {
    /// Destination of each planned output, by its path as the command has it.
    destinations: HashMap<PathBuf, Destination>,
    places: Places,
    /// Planned folders, until they are made.
    folders: Vec<PathBuf>,
    /// Folders that were made, the outer ones behind the inner ones.
    made_folders: Vec<PathBuf>,
    staged: VecDeque<StagedOutput>,
    body_folders: Vec<BodyFolder>,
}

/// Output whose content is complete.
#[derive(Debug)]
struct StagedOutput {
    /// Path as the command has it.
    path: PathBuf,
    content: StagedContent,
}

/// Complete content of an output, until it goes to its place.
#[derive(Debug)]
enum StagedContent {
    StandardOutput(Vec<u8>),
    Stream { place: PathBuf, content: Vec<u8> },
    File { beside: PathBuf, place: PathBuf },
}

impl Outputs {
    pub(super) fn new(
        destinations: HashMap<PathBuf, Destination>,
        places: Places,
        body_folders: Vec<BodyFolder>,
    ) -> Self {
        let folders = places.folders().to_vec();
        let (made_folders, staged) = (Vec::new(), VecDeque::new());
        Self { destinations, places, folders, made_folders, staged, body_folders }
    }

    /// Completes an output whose name depends on the results, in a planned folder.
    ///
    /// # Errors
    ///
    /// As [`stage`](Self::stage), and where it would replace an input or another output.
    pub(crate) fn stage_found(
        &mut self,
        path: &Path,
        content: impl AsRef<[u8]>,
    ) -> Result<(), Failure> {
        let destination = self.places.add(path)?;
        self.destinations.insert(path.to_owned(), destination);
        self.stage(path, content)
    }

    /// Completes a planned output: a file beside its place, other content in memory.
    pub(crate) fn stage(&mut self, path: &Path, content: impl AsRef<[u8]>) -> Result<(), Failure> {
        let Some(destination) = self.destinations.get(path).cloned() else {
            debug_assert!(false, "{} is not planned", path.display());
            return Err(Failure::in_output(path, &io::Error::other("it is not planned")));
        };
        if let Destination::File(place) = &destination {
            self.make_folders(place)?;
        }

        // A file beside its place is on the same file system, where a rename replaces it at once.
        let content = content.as_ref();
        let staged = match destination {
            Destination::StandardOutput => StagedContent::StandardOutput(content.to_vec()),
            Destination::Stream(place) => {
                StagedContent::Stream { place, content: content.to_vec() }
            }
            Destination::File(place) => {
                let beside = beside(&place, self.staged.len());
                let written = write_beside(&beside, &place, content);
                written.map_err(|error| Failure::in_output(path, &error))?;
                StagedContent::File { beside, place }
            }
        };
        self.staged.push_back(StagedOutput { path: path.to_owned(), content: staged });
        Ok(())
    }

    /// Completes a report as JSON, if there is a path for it.
    pub(crate) fn stage_json(
        &mut self,
        path: Option<&Path>,
        report: &impl Serialize,
    ) -> Result<(), Failure> {
        let Some(path) = path else { return Ok(()) };
        self.stage(path, serde_json::to_string_pretty(report)? + "\n")
    }

    /// Makes the planned folders in which a file stands, before the first of their files.
    fn make_folders(&mut self, place: &Path) -> Result<(), Failure> {
        let holds = |folder: &mut PathBuf| place.starts_with(folder);
        for folder in self.folders.extract_if(.., holds).collect::<Vec<PathBuf>>() {
            let made = unfinished().make_folder(&folder);
            self.made_folders.extend(made.map_err(|error| Failure::in_output(&folder, &error))?);
        }
        Ok(())
    }

    /// Writes the outputs that are no files, and names all outputs.
    ///
    /// These come before the files: what a pipe has taken cannot be taken back.
    pub(crate) fn write_streams(&self) -> Result<Written, Failure> {
        let mut written = Written { paths: Vec::new(), to_standard_output: false };
        for StagedOutput { path, content } in &self.staged {
            let result = match content {
                StagedContent::StandardOutput(content) => {
                    written.to_standard_output = true;
                    terminal::write_standard_output(content)
                }
                StagedContent::Stream { place, content } => write_stream(place, content),
                StagedContent::File { .. } => Ok(()),
            };
            result.map_err(|error| Failure::in_output(path, &error))?;
            written.paths.push(path.clone());
        }
        Ok(written)
    }

    /// Returns the files of bodies in the planned folders that are neither staged nor read, once all
    /// outputs are complete.
    pub(crate) fn earlier_files(&self) -> Vec<EarlierFiles> {
        let staged: BTreeSet<&Path> = self.staged.iter().map(|output| &*output.path).collect();
        let is_own = |path: &Path| staged.contains(path) || self.places.is_input(path);
        let mut earlier = Vec::new();
        for body_folder in &self.body_folders {
            // Other kinds of files are not of this program.
            let outputs = self.destinations.keys();
            let inside = outputs.filter(|path| path.parent() == Some(&body_folder.folder));
            let extensions = inside.map(|path| extension(path)).collect();
            earlier.extend(body_folder.earlier_files(&extensions, is_own));
        }
        earlier
    }

    /// Moves every file to its place, in the order of staging.
    pub(crate) fn move_files(mut self) -> Result<(), Failure> {
        // An interruption comes before the first file is moved, or after the last.
        let mut unfinished = unfinished();
        while let Some(StagedOutput { path, content }) = self.staged.front() {
            if let StagedContent::File { beside, place } = content {
                let moved = unfinished.move_file(beside, place);
                moved.map_err(|error| Failure::in_output(path, &error))?;
            }
            self.staged.pop_front();
        }

        for folder in std::mem::take(&mut self.made_folders) {
            unfinished.keep_folder(&folder);
        }
        Ok(())
    }
}

impl Drop for Outputs {
    fn drop(&mut self) {
        let mut unfinished = unfinished();

        // Files first: only an empty folder can be removed.
        for StagedOutput { content, .. } in &self.staged {
            if let StagedContent::File { beside, .. } = content {
                unfinished.remove_file(beside);
            }
        }
        for folder in &self.made_folders {
            unfinished.remove_folder(folder);
        }
    }
}

/// Returns the path of a file until it is moved to its place: a name of its own, since that
/// of the place may leave no room for more.
fn beside(place: &Path, number: usize) -> PathBuf {
    place.with_file_name(format!(".musculo-collide-{}-{number}.tmp", process::id()))
}

/// Writes a file with the permissions of the one that it will replace.
fn write_beside(beside: &Path, place: &Path, content: &[u8]) -> io::Result<()> {
    // Listed before it has content, so that a half-written file is removed too.
    let mut file = unfinished().make_file(beside)?;
    let mut written = file.write_all(content);
    if let (Ok(()), Ok(replaced)) = (&written, fs::metadata(place)) {
        written = file.set_permissions(replaced.permissions());
    }
    if written.is_err() {
        unfinished().remove_file(beside);
    }
    written
}

/// Writes to a device or a pipe. A reader that closes a pipe needs no more of it.
fn write_stream(place: &Path, content: &[u8]) -> io::Result<()> {
    let mut stream = OpenOptions::new().write(true).open(place)?;
    terminal::unless_closed(stream.write_all(content))
}

/// Names of complete outputs.
#[derive(Debug)]
pub(crate) struct Written {
    paths: Vec<PathBuf>,
    /// True if an output has taken standard output, so that no table may follow.
    pub(crate) to_standard_output: bool,
}

/// Maximum number of written files of one folder that are listed one by one.
const MAX_LISTED: usize = 6;

impl Written {
    /// Returns lines that name the outputs, or the folders of many.
    pub(crate) fn lines(&self) -> String {
        let mut folders: Vec<(&Path, Vec<&Path>)> = Vec::new();
        for path in &self.paths {
            let folder = path.parent().unwrap_or(path);
            match folders.iter_mut().find(|(known, _)| *known == folder) {
                Some((_, paths)) => paths.push(path),
                None => folders.push((folder, vec![path])),
            }
        }

        let mut lines = String::new();
        for (folder, paths) in folders {
            if paths.len() > MAX_LISTED {
                let folder = if folder == Path::new("") { Path::new(".") } else { folder };
                let files = counted(paths.len(), "file");
                lines += &format!("wrote {files} to {}\n", folder.display());
                continue;
            }
            for path in paths {
                lines += &format!("wrote {}\n", path.display());
            }
        }
        lines
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_files_are_named_by_their_folders() {
        let mut paths: Vec<PathBuf> = (0..7).map(|k| format!("apart/{k}.vtp").into()).collect();
        paths.push("apart.json".into());
        let written = Written { paths, to_standard_output: false };
        assert_eq!(written.lines(), "wrote 7 files to apart\nwrote apart.json\n");
        let paths = (0..7).map(|k| format!("{k}.vtp").into()).collect();
        let written = Written { paths, to_standard_output: false };
        assert_eq!(written.lines(), "wrote 7 files to .\n");
    }
}
