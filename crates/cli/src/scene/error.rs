//! Refusals of scene files and of bodies on the command line.

use std::path::PathBuf;

/// Reason why a scene cannot be used.
#[derive(Debug, thiserror::Error)]
pub(crate) enum SceneProblem {
    #[error("cannot be read: {0}")]
    Unreadable(#[from] std::io::Error),
    /// Not TOML, or an unknown key, kind or unit; the message quotes the line.
    #[error("{0}")]
    Syntax(String),
    #[error("has no [[body]]")]
    NoBodies,
    #[error("has no mesh that is at hand: put its meshes beside it, or into its folder Geometry")]
    NoModelMeshes,
    #[error("{path} is a scene with bodies of its own: use it alone", path = .0.display())]
    SceneAmongOthers(PathBuf),
    #[error("two bodies are named '{name}': {first} and {second}; give them names in a scene file")]
    SameName { name: String, first: String, second: String },
    #[error("part '{part}' is of '{first}' and of '{second}': a part is of one body", first = .names[0], second = .names[1])]
    SamePart {
        part: String,
        /// Names of both bodies.
        names: [String; 2],
    },
    #[error("the body of {file} is named '{name}', which cannot name an output file{advice}")]
    BadName {
        name: String,
        file: String,
        /// Advice on the path that gave the name, behind a colon; empty where a name was given.
        advice: String,
    },
    #[error("no body is named '{name}': the bodies are {known}")]
    NoSuchBody { name: String, known: String },
    #[error("[[ignore]] pairs '{0}' with itself")]
    IgnoredWithItself(String),
    /// A stiffness, a tie, or a selection of fixed vertices.
    #[error("line {line}: [[{table}]]: {problem}")]
    Condition { line: usize, table: &'static str, problem: String },
    #[error("margin is {0}, but must be finite and at least 0")]
    Margin(f64),
    #[error("--follow {0}: give a body and the name that it follows, as BODY=NAME")]
    Follow(String),
    #[error("--follow: {body} follows both {first:?} and {second:?}: give one of them")]
    FollowsTwo { body: String, first: String, second: String },
}
