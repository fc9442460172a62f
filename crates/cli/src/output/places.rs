//! Places of outputs, each of which only one output may have.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::{fs, io};

use crate::failure::Failure;
use crate::file_id::{FileId, is_character_device, resolved};

/// Path that stands for standard output.
const STANDARD_OUTPUT: &str = "-";

/// Place to which the content of an output goes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Destination {
    StandardOutput,
    /// Device or pipe, which is written as it is.
    Stream(PathBuf),
    /// Regular file, or one that does not exist yet, by its path without links.
    File(PathBuf),
}

/// Part of a file in a plan.
#[derive(Debug)]
enum Role {
    Input(PathBuf),
    Output(PathBuf),
}

/// Places that have a part in a plan.
#[derive(Debug)]
pub(super) struct Places {
    roles: BTreeMap<FileId, Role>,
    standard_output: Option<FileId>,
    /// Planned folders.
    folders: Vec<PathBuf>,
}

impl Places {
    pub(super) fn of_inputs(inputs: Vec<PathBuf>) -> Self {
        let mut roles = BTreeMap::new();

        // An input that does not exist is named by its reader.
        for input in inputs {
            if let Ok(id) = FileId::of(&input)
                && !is_character_device(&input)
            {
                roles.insert(id, Role::Input(input));
            }
        }
        Self { roles, standard_output: FileId::of_standard_output(), folders: Vec::new() }
    }

    /// Refuses a table that would be appended to an input.
    pub(super) fn check_standard_output(&self) -> Result<(), Failure> {
        match self.standard_output.as_ref().and_then(|id| self.roles.get(id)) {
            Some(Role::Input(input)) => {
                Err(Failure::in_file(input, "is an input, and standard output as well"))
            }
            _ => Ok(()),
        }
    }

    /// Gives a folder its place.
    pub(super) fn add_folder(&mut self, folder: &Path) -> Result<(), Failure> {
        let place = folder_place(folder).map_err(|error| Failure::in_output(folder, &error))?;
        self.claim(FileId::Path(place.clone()), folder)?;
        self.folders.push(place);
        Ok(())
    }

    /// Returns true if a file is read.
    pub(super) fn is_input(&self, file: &Path) -> bool {
        let role = FileId::of(file).ok().and_then(|id| self.roles.get(&id));
        matches!(role, Some(Role::Input(_)))
    }

    /// Returns the planned folders.
    pub(super) fn folders(&self) -> &[PathBuf] {
        &self.folders
    }

    /// Gives an output its place.
    pub(super) fn add(&mut self, file: &Path) -> Result<Destination, Failure> {
        let found = destination(file, self.standard_output.as_ref(), &self.folders);
        let (id, destination) = found.map_err(|error| Failure::in_output(file, &error))?;
        if let Some(id) = id {
            self.claim(id, file)?;
        }
        Ok(destination)
    }

    /// Gives a file to an output, unless it has a part already.
    fn claim(&mut self, id: FileId, output: &Path) -> Result<(), Failure> {
        let other = match self.roles.insert(id, Role::Output(output.to_owned())) {
            None => return Ok(()),
            Some(Role::Input(input)) if input == output => "this input".to_owned(),
            Some(Role::Input(input)) => format!("the input {}", input.display()),
            Some(Role::Output(other)) if other == output => "another one".to_owned(),
            Some(Role::Output(other)) => format!("the output {}", other.display()),
        };
        let problem = format!("the output would replace {other}: give it a place of its own");
        Err(Failure::in_file(output, problem))
    }
}

/// Returns the place of a folder, which may not exist yet.
fn folder_place(folder: &Path) -> io::Result<PathBuf> {
    if folder == Path::new(STANDARD_OUTPUT) {
        let problem = "'-' is standard output, and no folder (the folder '-' is './-')";
        return Err(io::Error::new(io::ErrorKind::NotADirectory, problem));
    }
    let place = resolved(folder)?;
    match fs::metadata(&place) {
        Ok(metadata) if !metadata.is_dir() => Err(io::ErrorKind::NotADirectory.into()),
        _ => Ok(place),
    }
}

/// Returns where the content of an output goes, and the identity of a file that only one
/// output may have.
fn destination(
    path: &Path,
    standard_output: Option<&FileId>,
    folders: &[PathBuf],
) -> io::Result<(Option<FileId>, Destination)> {
    // However it is spelled (/dev/stdout, or the file to which it is redirected).
    let id = FileId::of(path)?;
    if path == Path::new(STANDARD_OUTPUT) || standard_output == Some(&id) {
        let id = FileId::Path(STANDARD_OUTPUT.into());
        return Ok((Some(id), Destination::StandardOutput));
    }

    match fs::metadata(path) {
        Ok(metadata) if metadata.is_dir() => Err(io::ErrorKind::IsADirectory.into()),
        Ok(metadata) if metadata.is_file() => Ok((Some(id), Destination::File(resolved(path)?))),
        // A device or a pipe: a file moved to its place would replace it.
        Ok(_) if is_character_device(path) => Ok((None, Destination::Stream(path.into()))),
        Ok(_) => Ok((Some(id), Destination::Stream(path.into()))),
        Err(_) => Ok((Some(id), Destination::File(place_of_new(path, folders)?))),
    }
}

/// Returns the place of a file that does not exist yet, in a folder that does, or will.
fn place_of_new(path: &Path, folders: &[PathBuf]) -> io::Result<PathBuf> {
    let place = resolved(path)?;
    let folder = place.parent().unwrap_or(&place);
    if folder.is_dir() || folders.iter().any(|planned| planned == folder) {
        return Ok(place);
    }
    let problem = "its folder does not exist";
    Err(io::Error::new(io::ErrorKind::NotFound, problem))
}
