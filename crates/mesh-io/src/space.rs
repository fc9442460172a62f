//! Spaces of anatomical axes, as files of 3D Slicer state them.
//!
//! Positions are as the file has them, in either space: whoever puts two meshes together compares
//! what they state. A file that states none may be in any space.
//!
//! Source: 3D Slicer, `vtkMRMLModelStorageNode`: `SPACE=LPS` or `SPACE=RAS` in the header of STL files
//! and the comments of PLY and OBJ files, an array `SPACE` in the field data of VTK files of both kinds.

use std::fmt;

use crate::text::Lines;

/// Directions of the axes of a file, in a body that stands upright.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Space {
    /// Towards left, posterior and superior (LPS).
    LeftPosteriorSuperior,
    /// Towards right, anterior and superior (RAS): x and y have the other sign.
    RightAnteriorSuperior,
}

impl fmt::Display for Space {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::LeftPosteriorSuperior => "LPS",
            Self::RightAnteriorSuperior => "RAS",
        })
    }
}

impl Space {
    /// Returns the words that state the space in a header or a comment.
    pub(crate) fn statement(self) -> String {
        format!("SPACE={self}")
    }

    /// Returns the space that a header or a comment states.
    pub(crate) fn in_text(text: &[u8]) -> Option<Self> {
        let states = |space: &[u8]| text.windows(space.len()).any(|words| words == space);
        if states(b"SPACE=RAS") {
            return Some(Self::RightAnteriorSuperior);
        }
        states(b"SPACE=LPS").then_some(Self::LeftPosteriorSuperior)
    }

    /// Returns the space that an array of text names.
    pub(crate) fn named(name: &[u8]) -> Option<Self> {
        match name {
            b"RAS" => Some(Self::RightAnteriorSuperior),
            b"LPS" => Some(Self::LeftPosteriorSuperior),
            _ => None,
        }
    }

    /// Returns the space that comments before all else state.
    pub(crate) fn in_first_comments(file: &[u8]) -> Option<Self> {
        let lines = Lines::new(file).map(|line| line.text.trim_ascii_start());
        let mut comments = lines.take_while(|text| text.is_empty() || text.starts_with(b"#"));
        comments.find_map(Self::in_text)
    }
}
