//! Cache of the cells of a map: a run that was interrupted goes on from it.
//!
//! The first line has a hash of all inputs and arguments. Each other line is a cell: its row, its
//! column, and its row of the table, whose numbers are read as they were written.

use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use crate::failure::Failure;
use crate::report::MapCell;

/// Begin of the first line; the hash follows.
const HEADER: &str = "# cells of a range of motion, of inputs ";

/// Cells of a map that an earlier run has computed, and the file that keeps more of them.
#[derive(Debug)]
pub(super) struct Cache {
    path: PathBuf,
    cells: BTreeMap<[usize; 2], MapCell>,
    file: Mutex<File>,
}

impl Cache {
    /// Opens a cache, or makes one.
    pub(super) fn open(path: &Path, inputs: u64) -> Result<Self, Failure> {
        let (mut file, content) = read(path).map_err(|error| Failure::in_output(path, &error))?;
        let header = format!("{HEADER}{inputs:016x}\n");
        if !content.is_empty() && !content.starts_with(HEADER) {
            return Err(Failure::in_file(path, "is no cache of a map: choose another file"));
        }

        // An interruption may have left the last line unfinished.
        let complete = content.rfind('\n').map_or(0, |end| end + 1);
        if complete > 0 && !content.starts_with(&header) {
            let problem = "keeps the cells of other inputs: remove it, or choose another file";
            return Err(Failure::in_file(path, problem));
        }
        let mut cells = BTreeMap::new();
        for line in content[..complete].lines().skip(1) {
            let cell = parse(line).ok_or_else(|| {
                Failure::in_file(path, format!("has a damaged line: '{}'", mesh_io::escaped(line)))
            })?;
            cells.insert(cell.0, cell.1);
        }

        let restored = restore(&mut file, complete, &header);
        restored.map_err(|error| Failure::in_output(path, &error))?;
        Ok(Self { path: path.to_owned(), cells, file: Mutex::new(file) })
    }

    /// Returns the cells of earlier runs, by row and column.
    pub(super) fn cells(&self) -> &BTreeMap<[usize; 2], MapCell> {
        &self.cells
    }

    /// Keeps a cell.
    pub(super) fn keep(&self, [row, column]: [usize; 2], cell: &MapCell) -> Result<(), Failure> {
        let line = format!("{row},{column},{}", cell.to_line()?);
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        let written = file.write_all(line.as_bytes());
        written.map_err(|error| Failure::in_output(&self.path, &error))
    }
}

/// Opens a file, which is made where there is none, and reads it.
fn read(path: &Path) -> io::Result<(File, String)> {
    let mut options = OpenOptions::new();
    let mut file = options.read(true).write(true).create(true).truncate(false).open(path)?;
    let mut content = Vec::new();
    file.read_to_end(&mut content)?;
    Ok((file, String::from_utf8_lossy(&content).into_owned()))
}

/// Cuts a file behind its complete lines, and begins an empty one.
fn restore(file: &mut File, complete: usize, header: &str) -> io::Result<()> {
    file.set_len(complete as u64)?;
    file.seek(SeekFrom::End(0))?;
    if complete == 0 { file.write_all(header.as_bytes()) } else { Ok(()) }
}

/// Parses the line of a cell.
fn parse(line: &str) -> Option<([usize; 2], MapCell)> {
    let (row, rest) = line.split_once(',')?;
    let (column, rest) = rest.split_once(',')?;
    Some(([row.parse().ok()?, column.parse().ok()?], MapCell::parse(rest)?))
}

/// Computes a hash of the content of files, of the version and of arguments.
///
/// Source: G. Fowler, L. C. Noll and K.-P. Vo, FNV-1a of 64 bits: the same for any platform and
/// release, which the standard library's hash does not promise.
pub(super) fn content_hash(files: &[PathBuf], arguments: &str) -> Result<u64, Failure> {
    let mut hash = 0xcbf2_9ce4_8422_2325;
    for part in [env!("CARGO_PKG_VERSION"), arguments] {
        hash = fnv_1a(hash, part.as_bytes());
    }
    for path in files {
        let content = std::fs::read(path);
        let content = content.map_err(|error| Failure::in_file(path, error))?;

        // The length tells where a file ends and the next begins.
        hash = fnv_1a(hash, &(content.len() as u64).to_le_bytes());
        hash = fnv_1a(hash, &content);
    }
    Ok(hash)
}

fn fnv_1a(mut hash: u64, bytes: &[u8]) -> u64 {
    for &byte in bytes {
        hash = (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
    }
    hash
}
