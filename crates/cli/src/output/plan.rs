//! Files that a command reads and writes, declared before it begins.

use std::collections::HashMap;
use std::path::PathBuf;

use super::earlier::BodyFolder;
use super::places::{Destination, Places};
use super::{OutputFormat, Outputs};
use crate::failure::Failure;

/// Files that a command reads and writes.
#[derive(Debug, Default)]
pub(crate) struct FilePlan {
    inputs: Vec<PathBuf>,
    files: Vec<PathBuf>,
    /// Those of the files whose format is known.
    formats: Vec<(PathBuf, OutputFormat)>,
    folders: Vec<BodyFolder>,
}

impl FilePlan {
    /// Begins a plan with the files that are read.
    pub(crate) fn reading(inputs: impl IntoIterator<Item = PathBuf>) -> Self {
        Self { inputs: inputs.into_iter().collect(), ..Self::default() }
    }

    /// Adds a file that is read, if there is one.
    pub(crate) fn reading_too(mut self, file: Option<PathBuf>) -> Self {
        self.inputs.extend(file);
        self
    }

    /// Adds a file that is written, if there is one.
    pub(crate) fn writing(mut self, file: Option<&PathBuf>) -> Self {
        self.files.extend(file.cloned());
        self
    }

    /// Adds a file that is written in a format, if there is one.
    pub(crate) fn writing_as(mut self, format: OutputFormat, file: Option<&PathBuf>) -> Self {
        self.formats.extend(file.map(|file| (file.clone(), format)));
        self.writing(file)
    }

    /// Adds a folder that is made where there is none, if there is one, and the names of
    /// files that are written into it, of these bodies.
    pub(crate) fn writing_into<'a>(
        mut self,
        folder: Option<&PathBuf>,
        names: impl IntoIterator<Item = String>,
        bodies: impl IntoIterator<Item = &'a str>,
    ) -> Self {
        if let Some(folder) = folder {
            self.files.extend(names.into_iter().map(|name| folder.join(name)));
            let bodies = bodies.into_iter().map(str::to_owned).collect();
            self.folders.push(BodyFolder { folder: folder.clone(), bodies });
        }
        self
    }

    /// Checks the plan, without writing anything.
    ///
    /// # Errors
    ///
    /// Outputs that are inputs or other outputs, by the identity of the file; and places
    /// where no file can be; and files whose extension is not that of their format. Devices and pipes
    /// have any name.
    pub(crate) fn open(self) -> Result<Outputs, Failure> {
        let mut places = Places::of_inputs(self.inputs);
        places.check_standard_output()?;

        // Folders first: files may stand in folders that are yet to be made.
        for BodyFolder { folder, .. } in &self.folders {
            places.add_folder(folder)?;
        }

        let mut destinations = HashMap::new();
        for file in self.files {
            let destination = places.add(&file)?;
            destinations.insert(file, destination);
        }
        for (file, format) in self.formats {
            if matches!(destinations.get(&file), Some(Destination::File(_))) {
                format.check(&file).map_err(|problem| Failure::in_file(&file, problem))?;
            }
        }
        Ok(Outputs::new(destinations, places, self.folders))
    }
}
