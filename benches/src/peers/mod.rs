//! Answers about pairs of bodies, by all libraries that a Rust build reaches, and by packages for
//! Python where they are installed.
//!
//! All answer about the same pairs, those whose boxes are within reach, pair after pair. What a library keeps of a body is made beforehand, and timed apart. An answer is wrong where
//! it differs from the exact one, however precise the library means to be; it is a refusal where the
//! library declines to give one.

pub mod boolean;
pub mod libraries;
pub mod python;

use serde::Serialize;

use crate::measure::{Pace, as_f64, nanoseconds};
use libraries::{Bodies, LIBRARIES, Library, Memory};

/// Rounds over all pairs, of which the quickest counts.
pub const ROUNDS: u32 = 5;

/// Least time of a round \[ns\], which the processor's clock resolves.
const LEAST_ROUND: f64 = 5e7;

/// Distance up to which gaps are measured \[mm\].
pub const REACH: f64 = 5.0;

/// Deviation of a length from the exact one up to which it is right \[mm\].
pub const RIGHT_LENGTH: f64 = 1e-3;

/// Deviation of a volume from the exact one up to which it is right \[mm³\], for volumes above 1 as a
/// share.
pub const RIGHT_VOLUME: f64 = 1e-6;

/// Width of the bracket on an exact depth \[mm\].
const EXACT_DEPTH: f64 = 1e-6;

/// A question about two bodies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Question {
    /// Overlap: 1 for yes, 0 for no.
    Overlap,
    /// Distance between them.
    Gap,
    /// Depth of their overlap.
    Depth,
    /// Volume that they share.
    Volume,
}

/// All questions.
pub const QUESTIONS: [Question; 4] =
    [Question::Overlap, Question::Gap, Question::Depth, Question::Volume];

/// A pair, and the least and the greatest answer that is exact.
#[derive(Clone, Copy, Debug)]
pub struct ExactAnswer {
    /// The bodies.
    pub pair: [usize; 2],
    /// The least and the greatest answer.
    pub range: [f64; 2],
}

/// A question, with the exact answers about all its pairs.
#[derive(Clone, Debug)]
pub struct Asked {
    /// The question.
    pub question: Question,
    /// The exact answers.
    pub answers: Vec<ExactAnswer>,
}

/// Answers of a library to a question, pair after pair; `None` where one is refused.
#[derive(Clone, Debug)]
pub struct Answers {
    /// Name of the library.
    pub library: String,
    /// The question.
    pub question: Question,
    /// Time per pair \[us\].
    pub time: f64,
    /// Time per body to make what the library keeps of it \[us\].
    pub preparation: f64,
    /// The answers, in the order of the exact ones.
    pub answers: Vec<Option<f64>>,
}

/// Correctness of the answers of a library to a question: a row of the table.
#[derive(Clone, Debug, Serialize)]
pub struct Measurement {
    /// Title of the scene.
    pub scene: String,
    /// Text of the question.
    pub question: &'static str,
    /// Name of the library.
    pub library: String,
    /// Time per pair.
    #[serde(rename = "time per pair [us]")]
    pub time: f64,
    /// Time per body to make what the library keeps of it.
    #[serde(rename = "preparation per body [us]")]
    pub preparation: f64,
    /// Number of pairs.
    pub pairs: usize,
    /// Number of wrong answers.
    pub wrong: usize,
    /// Number of refusals.
    pub refused: usize,
    /// Largest error of finite answers to questions with a finite one.
    #[serde(rename = "largest error [mm, mm3]")]
    pub largest_error: f64,
}

/// Returns the answers of the libraries that a Rust build reaches, where they have some.
#[must_use]
pub fn own_and_rust(bodies: &Bodies, asked: &Asked) -> Vec<Answers> {
    let mut answers = Vec::new();
    for library in LIBRARIES {
        if library.answers(asked.question) {
            answers.push(library.measure(bodies, asked));
        }
    }
    answers
}

impl Question {
    /// Returns the question in words.
    #[must_use]
    pub const fn text(self) -> &'static str {
        match self {
            Self::Overlap => "do they overlap?",
            Self::Gap => "how far are they apart?",
            Self::Depth => "how deep do they overlap?",
            Self::Volume => "which volume do they share?",
        }
    }

    /// Returns an answer, infinite for a gap beyond reach.
    fn within_reach(self, answer: f64) -> f64 {
        if self == Self::Gap && answer >= REACH { f64::INFINITY } else { answer }
    }

    /// Returns the name of the question in the script.
    const fn key(self) -> &'static str {
        match self {
            Self::Overlap => "overlap",
            Self::Gap => "gap",
            Self::Depth => "depth",
            Self::Volume => "volume",
        }
    }
}

impl Asked {
    /// Answers the question exactly, for all pairs that it is about.
    #[must_use]
    pub fn new(question: Question, bodies: &Bodies) -> Self {
        let memory = &mut Memory::default();
        let mut answers = Vec::new();
        for pair in bodies.near_pairs() {
            let mut own =
                |question| Library::Own.ask(question, bodies, pair, memory).unwrap_or(f64::NAN);
            let overlaps = own(Question::Overlap) > 0.0;
            let value = match question {
                Question::Overlap => own(question),
                Question::Gap if !overlaps => own(question),
                Question::Volume if overlaps => own(question),
                Question::Depth if overlaps => {
                    let surfaces = pair.map(|body| &bodies.own[body]);
                    let range = memory.depth(surfaces, EXACT_DEPTH);
                    answers.push(ExactAnswer { pair, range });
                    continue;
                }
                _ => continue,
            };
            answers.push(ExactAnswer { pair, range: [value; 2] });
        }
        Self { question, answers }
    }

    /// Compares the answers to this question with the exact ones, library by library.
    #[must_use]
    pub fn judge_all(&self, scene: &str, answers: &[Answers]) -> Vec<Measurement> {
        let to_this = answers.iter().filter(|answers| answers.question == self.question);
        to_this.map(|answers| self.judge(scene, answers)).collect()
    }

    fn judge(&self, scene: &str, answers: &Answers) -> Measurement {
        let (mut wrong, mut refused, mut largest_error) = (0, 0, 0.0_f64);
        for (answer, exact) in answers.answers.iter().zip(&self.answers) {
            // What is refused is not wrong.
            let Some(answer) = *answer else {
                refused += 1;
                continue;
            };
            let error = exact.error(self.question.within_reach(answer));
            wrong += usize::from(error > exact.right(self.question));
            if error.is_finite() {
                largest_error = largest_error.max(error);
            }
        }

        Measurement {
            scene: scene.to_owned(),
            question: self.question.text(),
            library: answers.library.clone(),
            time: answers.time,
            preparation: answers.preparation,
            pairs: self.answers.len(),
            wrong,
            refused,
            largest_error,
        }
    }
}

impl Library {
    fn measure(self, bodies: &Bodies, asked: &Asked) -> Answers {
        let memory = &mut Memory::default();
        let mut answers = vec![None; asked.answers.len()];
        let mut ask_all = || {
            for (answer, exact) in answers.iter_mut().zip(&asked.answers) {
                *answer = self.ask(asked.question, bodies, exact.pair, memory);
            }
            asked.answers.len()
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
        Answers {
            library: self.name().to_owned(),
            question: asked.question,
            time: 1e-3 * quickest / as_f64(asked.answers.len().max(1)),
            preparation: self.preparation(bodies),
            answers,
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

    fn measure(question: Question, bodies: &Bodies) -> Vec<Measurement> {
        let asked = Asked::new(question, bodies);
        asked.judge_all("cubes", &own_and_rust(bodies, &asked))
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
