//! Why a scene cannot be checked.

use std::path::PathBuf;

/// What is wrong with a scene file or with what the command line asks for.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub(crate) enum SceneError {
    #[error("{path}: cannot be read: {problem}", path = .path.display())]
    Unreadable { path: PathBuf, problem: String },
    /// Not TOML, or an unknown key, kind or unit; the message quotes the line.
    #[error("{path}: {problem}", path = .path.display())]
    Syntax { path: PathBuf, problem: String },
    #[error("{path}: names no [[body]]", path = .path.display())]
    NoBodies { path: PathBuf },
    #[error(
        "{path} is a scene and names all its bodies: give it alone, without other files",
        path = .path.display()
    )]
    SceneAmongOthers { path: PathBuf },
    #[error("two bodies are named '{name}': {first} and {second}; name them apart in a scene file")]
    SameName { name: String, first: String, second: String },
    #[error("the body of {file} is named '{name}', which cannot name an output file")]
    Name { name: String, file: String },
    #[error("{place} names '{name}', but the bodies are: {known}")]
    NoSuchBody { place: &'static str, name: String, known: String },
    #[error("[[ignore]] pairs '{name}' with itself")]
    IgnoredWithItself { name: String },
    #[error("reach is {reach}; it must be a finite length that is not negative")]
    Reach { reach: f64 },
}
