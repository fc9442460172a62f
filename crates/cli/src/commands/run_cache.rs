//! Cache of the finished parts of a run: a run that was interrupted goes on from it.
//!
//! The first line has a hash of all inputs and arguments. Each other line is a part: a cell of a
//! map, or a frame of a motion, with all digits of its numbers.

use std::fs::{File, OpenOptions};
use std::io::{self, BufRead, BufReader, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use crate::failure::Failure;

/// Kind of run, in the words of its caches.
#[derive(Clone, Copy, Debug)]
pub(super) struct CacheKind {
    /// The whole run.
    pub(super) run: &'static str,
    /// Its parts.
    pub(super) parts: &'static str,
}

/// Parts that an earlier run has kept.
#[derive(Debug)]
pub(super) struct KeptParts {
    path: PathBuf,
    file: BufReader<File>,
    /// Number of the last line that was read.
    number: usize,
    /// Bytes of complete lines so far.
    complete: u64,
}

/// File that keeps more parts.
#[derive(Debug)]
pub(super) struct PartKeeper {
    path: PathBuf,
    file: Mutex<File>,
}

impl KeptParts {
    /// Opens a cache, or makes one.
    pub(super) fn open(path: &Path, kind: CacheKind, inputs: u64) -> Result<Self, Failure> {
        let CacheKind { run, parts } = kind;
        let mut options = OpenOptions::new();
        let file = options.read(true).write(true).create(true).truncate(false).open(path);
        let file = file.map_err(|error| Failure::in_output(path, &error))?;
        let mut kept =
            Self { path: path.to_owned(), file: BufReader::new(file), number: 0, complete: 0 };

        // Of an unfinished first line nothing follows: the cache begins anew.
        let begin = format!("# {parts} of a {run}, of inputs ");
        let header = format!("{begin}{inputs:016x}");
        let is_empty = kept.file.fill_buf().map_or(true, <[u8]>::is_empty);
        match kept.next_line()? {
            Some(line) if line == header => {}
            Some(line) if line.starts_with(&begin) => {
                let problem =
                    format!("keeps the {parts} of other inputs: remove it, or choose another file");
                return Err(Failure::in_file(path, problem));
            }
            None if is_empty || kept.is_begin_of(&header)? => kept.begin(&header)?,
            _ => {
                let problem = format!("is no cache of a {run}: choose another file");
                return Err(Failure::in_file(path, problem));
            }
        }
        Ok(kept)
    }

    /// Returns the next complete line. An interruption may have left the last one unfinished.
    pub(super) fn next_line(&mut self) -> Result<Option<String>, Failure> {
        let mut line = Vec::new();
        let read = self.file.read_until(b'\n', &mut line);
        read.map_err(|error| Failure::in_file(&self.path, error))?;
        if line.pop() != Some(b'\n') {
            return Ok(None);
        }
        self.number += 1;
        self.complete += line.len() as u64 + 1;
        Ok(Some(String::from_utf8_lossy(&line).into_owned()))
    }

    /// Returns a failure that names the last line.
    pub(super) fn damaged(&self) -> Failure {
        let problem = format!("has a damaged line {}: remove it, or the file", self.number);
        Failure::in_file(&self.path, problem)
    }

    /// Cuts the file behind its complete lines, to keep more parts there.
    pub(super) fn keep_more(self) -> Result<PartKeeper, Failure> {
        let Self { path, file, complete, .. } = self;
        let mut file = file.into_inner();
        let cut = file.set_len(complete).and_then(|()| file.seek(SeekFrom::End(0)));
        cut.map_err(|error| Failure::in_output(&path, &error))?;
        Ok(PartKeeper { path, file: Mutex::new(file) })
    }

    /// Returns true if the file is the begin of a header and nothing else.
    fn is_begin_of(&mut self, header: &str) -> Result<bool, Failure> {
        let content = self.file.rewind().and_then(|()| {
            let mut line = Vec::new();
            self.file.read_until(b'\n', &mut line).map(|_| line)
        });
        let content = content.map_err(|error| Failure::in_file(&self.path, error))?;
        Ok(header.as_bytes().starts_with(&content))
    }

    /// Begins an empty file.
    fn begin(&mut self, header: &str) -> Result<(), Failure> {
        let file = self.file.get_mut();
        let written = begin(file, header);
        written.map_err(|error| Failure::in_output(&self.path, &error))?;
        self.complete = header.len() as u64 + 1;
        Ok(())
    }
}

/// Writes the first line of a file, and nothing else.
fn begin(file: &mut File, header: &str) -> io::Result<()> {
    file.set_len(0)?;
    file.rewind()?;
    writeln!(file, "{header}")
}

impl PartKeeper {
    /// Keeps a part, whose text has no line breaks. Several threads may keep parts.
    pub(super) fn keep(&self, part: &str) -> Result<(), Failure> {
        let line = format!("{part}\n");
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        let written = file.write_all(line.as_bytes());
        written.map_err(|error| Failure::in_output(&self.path, &error))
    }
}

/// Computes a hash of the names and the content of files, of the version and of arguments. Folders do
/// not count: a scene may move with its cache.
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

        // The length tells where a part ends and the next begins. Bodies may be named by their files.
        let name = path.file_name().unwrap_or_default().as_encoded_bytes();
        for part in [name, &content] {
            hash = fnv_1a(hash, &(part.len() as u64).to_le_bytes());
            hash = fnv_1a(hash, part);
        }
    }
    Ok(hash)
}

fn fnv_1a(mut hash: u64, bytes: &[u8]) -> u64 {
    for &byte in bytes {
        hash = (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
    }
    hash
}
