//! Answers about pairs of bodies, by all libraries that a Rust build reaches.
//!
//! All answer about the same pairs, those whose boxes are within reach, on one thread, pair after
//! pair. What a library keeps of a body is made beforehand, and timed apart. An answer is wrong where
//! it differs from the exact one, however precise the library means to be; it is a refusal where the
//! library declines to give one.

mod draw;
mod libraries;

use std::error::Error;
use std::path::{Path, PathBuf};

use fixtures::{data, thigh};
use serde::Serialize;

use super::curves::machine;
use super::sheet::{Settings, Sheet};
use crate::measure::{Pace, as_f64, nanoseconds};
use libraries::{Bodies, LIBRARIES, Library, Memory};

/// Rounds over all pairs, of which the quickest counts, and the least time of one \[ns\], which the
/// processor's clock resolves.
const ROUNDS: u32 = 5;
const LEAST_ROUND: f64 = 5e7;

/// Distance up to which gaps are measured \[mm\].
const REACH: f64 = 5.0;

/// Deviation of a length from the exact one up to which it is right \[mm\], and of a volume
/// \[mm³\], for volumes above 1 as a share.
const RIGHT_LENGTH: f64 = 1e-3;
const RIGHT_VOLUME: f64 = 1e-6;

/// Width of the bracket on an exact depth \[mm\].
const EXACT_DEPTH: f64 = 1e-6;

/// A question about two bodies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Question {
    Overlap,
    Gap,
    Depth,
    Volume,
}

const QUESTIONS: [Question; 4] =
    [Question::Overlap, Question::Gap, Question::Depth, Question::Volume];

/// A pair, and the least and the greatest answer that is exact.
#[derive(Clone, Copy, Debug)]
struct ExactAnswer {
    pair: [usize; 2],
    range: [f64; 2],
}

/// Answers of a library to a question: a row of the table.
#[derive(Clone, Debug, Serialize)]
struct Measurement {
    scene: String,
    question: &'static str,
    library: &'static str,
    #[serde(rename = "time per pair [us]")]
    time: f64,
    #[serde(rename = "preparation per body [us]")]
    preparation: f64,
    pairs: usize,
    wrong: usize,
    refused: usize,
    /// Of finite answers to questions with a finite one.
    #[serde(rename = "largest error [mm, mm3]")]
    largest_error: f64,
}

/// Measures answers about the generated thigh and, where it is available, a real one; draws the last.
///
/// # Errors
///
/// When a body is refused, or a file cannot be written.
pub fn run(folder: &Path) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let generated = thigh::thigh().bodies.into_iter().map(|body| body.mesh).collect();
    let mut scenes = vec![Bodies::new("generated thigh", generated)?];
    if let Some(anatomy) = data::anatomy("peers of a real thigh") {
        let files = data::bodies(&anatomy.join("vhf_left_thigh_lo"));
        let meshes = files.iter().map(|file| data::mesh(file)).collect();
        scenes.push(Bodies::new("thigh of the Visible Human Female, simplified", meshes)?);
    }

    let mut rows = Vec::new();
    for bodies in &scenes {
        for question in QUESTIONS {
            rows.extend(measure(question, bodies));
        }
    }

    let titles: Vec<&str> = scenes.iter().map(|bodies| bodies.title.as_str()).collect();
    let sheet = Sheet::new("peers", settings(&titles), &rows)?;
    let drawn = titles.last().copied().unwrap_or_default();
    let last: Vec<&Measurement> = rows.iter().filter(|row| row.scene == drawn).collect();
    let svg = draw::draw(&last, &sheet.settings)?;
    Ok(sheet.write(folder, Some(svg))?)
}

fn settings(scenes: &[&str]) -> Settings {
    let pairs = format!(
        "those with boxes within {REACH} mm; gaps of those that are apart, depths and volumes of those that overlap"
    );
    let wrong = format!(
        "more than {RIGHT_LENGTH} mm from the exact length, or {RIGHT_VOLUME} of the exact volume and as many mm³; parry3d computes in single precision, without an inside, and its depth is that of one pair of faces"
    );
    let time = format!(
        "processor time per pair, the quickest of {ROUNDS} rounds over all pairs; what a library keeps of a body is made before"
    );
    vec![
        ("scenes", scenes.join("; ")),
        ("pairs", pairs),
        ("wrong", wrong),
        ("time", time),
        ("machine", machine()),
    ]
}

/// Measures all libraries that answer the question.
fn measure(question: Question, bodies: &Bodies) -> Vec<Measurement> {
    let asked = question.exact_answers(bodies);
    let mut rows = Vec::new();
    for library in LIBRARIES {
        if library.answers(question) {
            rows.push(library.measure(question, bodies, &asked));
        }
    }
    rows
}

impl Question {
    const fn text(self) -> &'static str {
        match self {
            Self::Overlap => "do they overlap?",
            Self::Gap => "how far are they apart?",
            Self::Depth => "how deep do they overlap?",
            Self::Volume => "which volume do they share?",
        }
    }

    /// Returns the pairs that the question is about, with the exact answers.
    fn exact_answers(self, bodies: &Bodies) -> Vec<ExactAnswer> {
        let memory = &mut Memory::default();
        let mut answers = Vec::new();
        for pair in bodies.near_pairs() {
            let mut own =
                |question| Library::Own.ask(question, bodies, pair, memory).unwrap_or(f64::NAN);
            let overlaps = own(Self::Overlap) > 0.0;
            let value = match self {
                Self::Overlap => own(self),
                Self::Gap if !overlaps => own(self),
                Self::Volume if overlaps => own(self),
                Self::Depth if overlaps => {
                    let surfaces = pair.map(|body| &bodies.own[body]);
                    let range = memory.depth(surfaces, EXACT_DEPTH);
                    answers.push(ExactAnswer { pair, range });
                    continue;
                }
                _ => continue,
            };
            answers.push(ExactAnswer { pair, range: [value; 2] });
        }
        answers
    }
}

impl Library {
    fn measure(self, question: Question, bodies: &Bodies, asked: &[ExactAnswer]) -> Measurement {
        let memory = &mut Memory::default();
        let mut answers = vec![None; asked.len()];
        let mut ask_all = || {
            for (answer, exact) in answers.iter_mut().zip(asked) {
                *answer = self.ask(question, bodies, exact.pair, memory);
            }
            asked.len()
        };

        // The first round warms up and says how often a timed one asks.
        let (mut repeats, mut elapsed) = (0, 0.0);
        while elapsed < LEAST_ROUND {
            elapsed += nanoseconds(&mut ask_all);
            repeats += 1;
        }
        let mut quickest = f64::INFINITY;
        for _ in 0..ROUNDS {
            let round = Pace::long_calls(1).call_time(|| (0..repeats).map(|_| ask_all()).sum());
            quickest = quickest.min(round / f64::from(repeats));
        }

        let (mut wrong, mut refused, mut largest_error) = (0, 0, 0.0_f64);
        for (answer, exact) in answers.into_iter().zip(asked) {
            let Some(answer) = answer else {
                refused += 1;
                continue;
            };
            let error = exact.error(answer);
            let is_right = error <= exact.right(question);
            wrong += usize::from(!is_right);
            if error.is_finite() {
                largest_error = largest_error.max(error);
            }
        }
        Measurement {
            scene: bodies.title.clone(),
            question: question.text(),
            library: self.name(),
            time: 1e-3 * quickest / as_f64(asked.len().max(1)),
            preparation: self.preparation(bodies),
            pairs: asked.len(),
            wrong,
            refused,
            largest_error,
        }
    }
}

impl ExactAnswer {
    /// Returns how far an answer is from the exact one; infinite where one of them is.
    fn error(&self, answer: f64) -> f64 {
        let [least, greatest] = self.range;
        if (least..=greatest).contains(&answer) {
            0.0
        } else {
            (least - answer).abs().min((answer - greatest).abs())
        }
    }

    /// Returns the error up to which an answer is right.
    fn right(&self, question: Question) -> f64 {
        match question {
            Question::Overlap => 0.0,
            Question::Gap | Question::Depth => RIGHT_LENGTH,
            Question::Volume => RIGHT_VOLUME * self.range[1].max(1.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use fixtures::shapes::cube;
    use glam::DVec3;

    use super::*;

    fn row(rows: &[Measurement], library: Library) -> &Measurement {
        rows.iter().find(|row| row.library == library.name()).expect("it answers")
    }

    /// A small cube wholly inside a large one, one beside it that overlaps it, one apart.
    #[test]
    fn wrong_answers_are_counted() {
        let place = |size: f64, at: [f64; 3]| cube(size).translated(DVec3::from_array(at));
        let meshes = vec![
            place(10.0, [0.0; 3]),
            place(1.0, [4.0; 3]),
            place(4.0, [6.2, 0.3, 0.1]),
            place(4.0, [1.0, 3.1, 9.5]),
        ];
        let bodies = Bodies::new("cubes", meshes).unwrap();

        // Surfaces without an inside do not meet where one body is wholly in the other.
        let overlaps = measure(Question::Overlap, &bodies);
        let near = bodies.near_pairs().len();
        let [own, parry] = [Library::Own, Library::Parry].map(|library| row(&overlaps, library));
        assert_eq!((own.pairs, own.wrong), (near, 0), "{own:?}");
        assert_eq!((parry.pairs, parry.wrong), (near, 1), "{parry:?}");

        let gaps = measure(Question::Gap, &bodies);
        assert_eq!([row(&gaps, Library::Own).wrong, row(&gaps, Library::Parry).wrong], [0, 0]);
        let volumes = measure(Question::Volume, &bodies);
        let [own, boolmesh] =
            [Library::Own, Library::Boolmesh].map(|library| row(&volumes, library));
        assert_eq!((own.pairs, own.wrong, boolmesh.wrong + boolmesh.refused), (2, 0, 0));
    }

    #[test]
    fn answers_within_the_bracket_are_right() {
        let exact = ExactAnswer { pair: [0, 1], range: [1.0, 1.5] };
        for (answer, error) in [(1.2, 0.0), (0.5, 0.5), (2.0, 0.5)] {
            assert!((exact.error(answer) - error).abs() < 1e-15, "{answer}");
        }
        assert!(exact.error(f64::INFINITY).is_infinite());
    }
}
