//! Content of files, up to a limit.

use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, is_separator};

use crate::text::split_mark;

/// Maximum size of a regular file: 4 GiB, or 85 million facets of STL.
///
/// The program needs many times the memory of a mesh file; a larger file is more likely
/// a wrong one.
pub const MAX_FILE_BYTES: u64 = 4 << 30;

/// Maximum size of the content of a pipe or a device: 256 MiB, or 5 million facets of
/// STL.
///
/// Such a file has no length, and may never end (`/dev/zero`).
pub const MAX_STREAM_BYTES: u64 = 256 << 20;

/// Reads a file that has at most [`MAX_FILE_BYTES`], or a pipe or device of at most
/// [`MAX_STREAM_BYTES`].
///
/// # Errors
///
/// Errors of the operating system, and [`io::ErrorKind::FileTooLarge`] with the limit.
pub fn read_file(path: &Path) -> io::Result<Vec<u8>> {
    let file = File::open(path).map_err(|error| with_advice(error, path))?;
    let metadata = file.metadata()?;
    let (kind, limit) = if metadata.is_file() {
        ("file", MAX_FILE_BYTES)
    } else {
        ("pipe or device", MAX_STREAM_BYTES)
    };
    let too_large = || {
        let problem = format!("it has more than {limit} bytes, the limit for a {kind}");
        io::Error::new(io::ErrorKind::FileTooLarge, problem)
    };
    if metadata.len() > limit {
        return Err(too_large());
    }

    // The length is a hint only: files may grow, and those under /proc have none.
    let mut bytes = Vec::new();
    let expected = usize::try_from(metadata.len()).unwrap_or(usize::MAX);
    bytes.try_reserve_exact(expected)?;
    // One byte more than allowed shows that there are too many.
    file.take(limit + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > limit { Err(too_large()) } else { Ok(bytes) }
}

/// Returns advice on a path whose folders this system does not separate as its author meant, to stand
/// behind the problem that it causes.
#[must_use]
pub fn separator_advice(path: &Path) -> Option<&'static str> {
    let path = path.to_string_lossy();
    if path.contains('\\') && !is_separator('\\') {
        return Some(
            "the path has backslashes, which separate folders on Windows alone: write /, which does on \
             all systems",
        );
    }
    path.contains(char::is_control).then_some(
        "the path has control characters, as where a backslash begins an escape: write / between folders",
    )
}

/// Adds advice on the path to the error of a file that does not exist.
fn with_advice(error: io::Error, path: &Path) -> io::Error {
    match separator_advice(path).filter(|_| error.kind() == io::ErrorKind::NotFound) {
        Some(advice) => io::Error::new(io::ErrorKind::NotFound, format!("{error}: {advice}")),
        None => error,
    }
}

/// Reads a text file, with the limits of [`read_file`], without the mark of UTF-8 that some editors
/// write before text, and with a line feed at the end of each line: other systems have CR LF, or CR alone.
///
/// # Errors
///
/// Those of [`read_file`], and [`io::ErrorKind::InvalidData`] with the first byte that is
/// not UTF-8.
pub fn read_text(path: &Path) -> io::Result<String> {
    let mut bytes = read_file(path)?;
    let mark = split_mark(&bytes).0.len();
    bytes.drain(..mark);
    let text = String::from_utf8(bytes).map_err(|error| {
        let byte = mark + error.utf8_error().valid_up_to();
        let problem = format!("it is not UTF-8 text from byte {byte} on");
        io::Error::new(io::ErrorKind::InvalidData, problem)
    })?;

    // Some programs write two returns before a line feed.
    let has_returns = text.contains('\r');
    let with_feeds = || text.replace("\r\r\n", "\n").replace("\r\n", "\n").replace('\r', "\n");
    Ok(if has_returns { with_feeds() } else { text })
}
