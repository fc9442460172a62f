//! Medial surfaces as text, in the format that tools for medial axis
//! transforms share.
//!
//! A first line holds the counts of vertices, edges and faces; a line
//! `v x y z r` follows for each ball, `e i j` for each edge, `f i j k` for each
//! face, numbered from 0. Blank lines and what follows `#` are skipped.
//!
//! Source: the `.ma` files of P. Li et al., "Q-MAT", ACM TOG 35(1), 2015, and of
//! the programs after it.
//!
//! There, edges list the sides of faces as well. Such an edge adds nothing to
//! the union of balls: it is written, since other readers rely on it, and
//! skipped when read.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::str::SplitWhitespace;

use glam::DVec3;

use crate::{Ball, MedialError, MedialSurface};

impl MedialSurface {
    /// Writes the medial surface as text that [`Self::from_ma`] reads back to
    /// the same bits.
    #[must_use]
    pub fn to_ma(&self) -> String {
        let mut edges = sides(self.slabs());
        edges.extend(self.cones().map(sorted));
        let mut text = format!("{} {} {}\n", self.balls().len(), edges.len(), self.slabs().len());
        for Ball { center: DVec3 { x, y, z }, radius } in self.balls() {
            line(&mut text, format_args!("v {x} {y} {z} {radius}"));
        }
        for [a, b] in edges {
            line(&mut text, format_args!("e {a} {b}"));
        }
        for [a, b, c] in self.slabs() {
            line(&mut text, format_args!("f {a} {b} {c}"));
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
    /// - [`MedialError::Text`] with the first line that is not understood, or
    ///   the last one when the counts of the first are not met.
    /// - What [`Self::new`] refuses.
    pub fn from_ma(text: &str) -> Result<Self, MedialError> {
        let mut lines = text
            .lines()
            .enumerate()
            .map(|(i, line)| (i + 1, line.split('#').next().unwrap_or("").trim()))
            .filter(|(_, line)| !line.is_empty());
        let (number, first) = lines.next().ok_or(fault(1, "the text is empty"))?;
        let counts = numbers(number, &mut first.split_whitespace())?;
        let mut records = Records::default();
        let mut last = number;
        for (number, line) in lines {
            records.read(number, line)?;
            last = number;
        }
        records.check(last, counts)?;
        records.finish()
    }
}

fn line(text: &mut String, content: std::fmt::Arguments<'_>) {
    // Writing into a string cannot fail.
    let _ = writeln!(text, "{content}");
}

fn sorted([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

fn sides(slabs: &[[u32; 3]]) -> BTreeSet<[u32; 2]> {
    slabs.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]].map(sorted)).collect()
}

fn fault(line: usize, reason: &'static str) -> MedialError {
    MedialError::Text { line, reason }
}

/// What the lines after the first hold.
#[derive(Default)]
struct Records {
    balls: Vec<Ball>,
    edges: Vec<[u32; 2]>,
    faces: Vec<[u32; 3]>,
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

    fn check(&self, last: usize, counts: [usize; 3]) -> Result<(), MedialError> {
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

    fn finish(self) -> Result<MedialSurface, MedialError> {
        let sides = sides(&self.faces);
        let cones = self.edges.into_iter().filter(|&edge| !sides.contains(&sorted(edge)));
        MedialSurface::new(self.balls, cones.collect(), self.faces)
    }
}

/// Exactly `N` numbers, and no further word.
fn numbers<T: std::str::FromStr + Copy + Default, const N: usize>(
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
