//! Identity of files, whatever path leads to them.

use std::fs::{self, File, Metadata};
use std::io;
use std::path::{Path, PathBuf};

/// Identity of a file: equal for all links to it, and for all spellings of its path.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum FileId {
    /// Number of an existing file on its device.
    Node { device: u64, inode: u64 },
    /// Absolute path without links.
    Path(PathBuf),
}

impl FileId {
    /// Returns the identity of a file at a path, and that of the file which a new file at
    /// the path would be.
    ///
    /// # Errors
    ///
    /// Errors of the operating system, where the path leads nowhere.
    pub(crate) fn of(path: &Path) -> io::Result<Self> {
        // Devices and pipes may have a number but no path of their own (/dev/stdout).
        if let Ok(metadata) = fs::metadata(path)
            && let Some(node) = Self::of_node(&metadata)
        {
            return Ok(node);
        }
        Ok(Self::Path(resolved(path)?))
    }

    /// Returns the identity of standard output, where the system has one.
    #[cfg(unix)]
    pub(crate) fn of_standard_output() -> Option<Self> {
        use std::os::fd::AsFd;
        let descriptor = io::stdout().as_fd().try_clone_to_owned().ok()?;
        Self::of_node(&File::from(descriptor).metadata().ok()?)
    }

    #[cfg(not(unix))]
    pub(crate) fn of_standard_output() -> Option<Self> {
        None
    }

    #[cfg(unix)]
    #[expect(clippy::unnecessary_wraps, reason = "other systems number no files")]
    fn of_node(metadata: &Metadata) -> Option<Self> {
        use std::os::unix::fs::MetadataExt;
        Some(Self::Node { device: metadata.dev(), inode: metadata.ino() })
    }

    #[cfg(not(unix))]
    fn of_node(_: &Metadata) -> Option<Self> {
        None
    }
}

/// Returns true if both paths lead to one file.
pub(crate) fn is_same_file(a: &Path, b: &Path) -> bool {
    a == b || matches!((FileId::of(a), FileId::of(b)), (Ok(a), Ok(b)) if a == b)
}

/// Returns the absolute path without links behind a path, whose end may not exist yet.
///
/// # Errors
///
/// Errors of the operating system, such as a circle of links, and a path that ends in
/// `..` behind a folder that does not exist.
pub(crate) fn resolved(path: &Path) -> io::Result<PathBuf> {
    match fs::canonicalize(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => {}
        result => return result,
    }

    // A link to a file that does not exist: a circle of links is another error above.
    let parent = match path.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    };
    if let Ok(target) = fs::read_link(path) {
        return resolved(&parent.join(target));
    }
    let name = path.file_name().ok_or(io::ErrorKind::InvalidFilename)?;
    Ok(resolved(parent)?.join(name))
}

/// Returns true for character devices: terminals and `/dev/null` keep nothing that could
/// be replaced.
#[cfg(unix)]
pub(crate) fn is_character_device(path: &Path) -> bool {
    use std::os::unix::fs::FileTypeExt;
    fs::metadata(path).is_ok_and(|metadata| metadata.file_type().is_char_device())
}

#[cfg(not(unix))]
pub(crate) fn is_character_device(_: &Path) -> bool {
    false
}
