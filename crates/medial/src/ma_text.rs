//! Medial surfaces as text, in the format that tools for medial axis transforms share.
//!
//! The first line holds the counts of vertices, edges and faces. A line `v x y z r` follows for
//! each ball, `e i j` for each edge, `f i j k` for each face, numbered from 0. Blank lines and
//! everything after `#` are skipped.
//!
//! Source: the `.ma` files of P. Li et al., "Q-MAT", ACM TOG 35(1), 2015, and of the programs after
//! it.
//!
//! There, edges list the sides of faces as well. Such an edge adds nothing to the union of balls: it
//! is written, since other readers rely on it, and skipped when read.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::str::{FromStr, SplitWhitespace};

use glam::DVec3;

use crate::{Ball, MedialError, MedialSurface};

/// Records of the lines after the first.
#[derive(Default)]
struct Records {
    balls: Vec<Ball>,
    edges: Vec<[u32; 2]>,
    faces: Vec<[u32; 3]>,
}

impl MedialSurface {
    /// Writes the medial surface as text that [`Self::from_ma`] reads back to the same bits. Cones
    /// are written in ascending order, each once; those that are sides of slabs add nothing and are
    /// not read back.
    #[must_use]
    pub fn to_ma(&self) -> String {
        let mut edges = sides(self.slabs());
        edges.extend(self.cones().map(ascending));

        // Writing into a string cannot fail.
        let mut text = format!("{} {} {}\n", self.balls().len(), edges.len(), self.slabs().len());
        for Ball { center: DVec3 { x, y, z }, radius } in self.balls() {
            let _ = writeln!(text, "v {x} {y} {z} {radius}");
        }
        for [a, b] in edges {
            let _ = writeln!(text, "e {a} {b}");
        }
        for [a, b, c] in self.slabs() {
            let _ = writeln!(text, "f {a} {b} {c}");
        }
        text
    }

    /// Reads a medial surface from text.
    ///
    /// ```
    /// use medial::MedialSurface;
    ///
    /// let capsule = MedialSurface::from_ma("2 1 0\nv 0 0 0 1\nv 4 0 0 1.5\ne 0 1\n")?;
    /// assert_eq!(capsule.cones().next(), Some([0, 1]));
    /// assert_eq!(MedialSurface::from_ma(&capsule.to_ma())?, capsule);
    /// # Ok::<(), medial::MedialError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// - [`MedialError::Text`] with the first line that does not follow the format, or the last one
    ///   when the counts of the first are not met.
    /// - The errors of [`Self::new`].
    pub fn from_ma(text: &str) -> Result<Self, MedialError> {
        let mut counts = None;
        let mut records = Records::default();
        let mut last = 1;
        for (number, line) in (1..).zip(text.lines()) {
            let line = line.split('#').next().unwrap_or("").trim();
            if line.is_empty() {
                continue;
            }
            // The first line holds the counts.
            if counts.is_none() {
                counts = Some(numbers(number, &mut line.split_whitespace())?);
            } else {
                records.read(number, line)?;
            }
            last = number;
        }

        let counts = counts.ok_or(fault(1, "the text is empty"))?;
        records.check_counts(last, counts)?;
        records.into_medial_surface()
    }
}

impl Records {
    fn read(&mut self, number: usize, line: &str) -> Result<(), MedialError> {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let [x, y, z, radius] = numbers(number, &mut words)?;
                self.balls.push(Ball::new(DVec3::new(x, y, z), radius));
            }
            Some("e") => self.edges.push(numbers(number, &mut words)?),
            Some("f") => self.faces.push(numbers(number, &mut words)?),
            _ => return Err(fault(number, "expected a line of v, e or f")),
        }
        Ok(())
    }

    /// Checks the numbers of records against the first line.
    fn check_counts(&self, last: usize, counts: [usize; 3]) -> Result<(), MedialError> {
        let found = [self.balls.len(), self.edges.len(), self.faces.len()];
        let reasons = [
            "the count of vertices is not that of the first line",
            "the count of edges is not that of the first line",
            "the count of faces is not that of the first line",
        ];
        match (0..3).find(|&k| found[k] != counts[k]) {
            Some(k) => Err(fault(last, reasons[k])),
            None => Ok(()),
        }
    }

    /// Builds the medial surface; edges that are sides of faces are skipped.
    fn into_medial_surface(self) -> Result<MedialSurface, MedialError> {
        let sides = sides(&self.faces);
        let mut cones = self.edges;
        cones.retain(|&edge| !sides.contains(&ascending(edge)));
        MedialSurface::new(self.balls, cones, self.faces)
    }
}

/// Returns the sides of slabs, each once.
fn sides(slabs: &[[u32; 3]]) -> BTreeSet<[u32; 2]> {
    slabs.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]].map(ascending)).collect()
}

fn ascending([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

fn fault(line: usize, reason: &'static str) -> MedialError {
    MedialError::Text { line, reason }
}

/// Reads exactly `N` numbers, and checks that no further word follows.
fn numbers<T: FromStr + Copy + Default, const N: usize>(
    line: usize,
    words: &mut SplitWhitespace<'_>,
) -> Result<[T; N], MedialError> {
    let mut values = [T::default(); N];
    for value in &mut values {
        let word = words.next().ok_or(fault(line, "a number is missing"))?;
        *value = word.parse().map_err(|_| fault(line, "a word is not a number of its kind"))?;
    }
    match words.next() {
        Some(_) => Err(fault(line, "there are more numbers than expected")),
        None => Ok(values),
    }
}
