//! Methods that go by chance: trees with counts of filled cells, and pairs drawn at random.

use baselines::{PairFindings, average_case, selected_pairs};

use super::super::question::Question;
use super::super::score::Told;
use super::images::body_at;
use super::{Detector, Failure};

/// Trees of boxes: the bone's is kept, a muscle's is good for one frame.
pub(super) struct Chances<'a> {
    question: &'a Question<'a>,
    params: average_case::AverageCaseParams,
    bone: average_case::AverageCaseTree,
    muscles: Vec<usize>,
    found: Vec<PairFindings>,
}

pub(super) fn average_case<'a>(
    question: &'a Question<'a>,
    acceptance: f64,
) -> Result<Chances<'a>, Failure> {
    let params =
        average_case::AverageCaseParams { acceptance, ..average_case::AverageCaseParams::DEFAULT };
    let bone = average_case::AverageCaseTree::new(body_at(question, 0, 0)?, &params)?;
    Ok(Chances { question, params, bone, muscles: question.muscles(), found: Vec::new() })
}

impl Detector for Chances<'_> {
    fn step(&mut self, frame: usize) -> Result<(), Failure> {
        let Self { question, params, bone, muscles, found } = self;
        let mut trees: Vec<Option<average_case::AverageCaseTree>> = Vec::new();
        trees.resize_with(question.moving.bodies.len(), || None);
        for &muscle in &*muscles {
            let body = body_at(question, frame, muscle)?;
            trees[muscle] = Some(average_case::AverageCaseTree::new(body, params)?);
        }
        found.clear();
        for &[a, b] in &question.pairs {
            let of_b = trees[b].as_ref().unwrap_or(bone);
            let of_a = trees[a].as_ref().unwrap_or(bone);
            let [a, b] = [body_at(question, frame, a)?, body_at(question, frame, b)?];
            found.push(of_a.detect(a, of_b, b, params)?);
        }
        Ok(())
    }

    fn told(&self) -> Told {
        let overlapping = self.question.pairs.iter().zip(&self.found);
        let overlapping = overlapping.filter(|(_, found)| found.overlap);
        Told::Overlaps(overlapping.map(|(pair, _)| *pair).collect())
    }
}

/// Pairs of faces that are kept from frame to frame.
pub(super) struct Drawn<'a> {
    question: &'a Question<'a>,
    params: selected_pairs::SelectedPairsParams,
    pairs: Vec<selected_pairs::SelectedPairs>,
    found: Vec<PairFindings>,
}

pub(super) fn selected_pairs<'a>(
    question: &'a Question<'a>,
    max_tests: u64,
) -> Result<Drawn<'a>, Failure> {
    let params = selected_pairs::SelectedPairsParams {
        max_tests,
        ..selected_pairs::SelectedPairsParams::DEFAULT
    };
    let pairs = (1..).take(question.pairs.len()).map(selected_pairs::SelectedPairs::new).collect();
    Ok(Drawn { question, params, pairs, found: Vec::new() })
}

impl Detector for Drawn<'_> {
    fn step(&mut self, frame: usize) -> Result<(), Failure> {
        self.found.clear();
        for (&[a, b], pairs) in self.question.pairs.iter().zip(&mut self.pairs) {
            let [a, b] = [body_at(self.question, frame, a)?, body_at(self.question, frame, b)?];
            self.found.push(pairs.step(a, b, &self.params)?);
        }
        Ok(())
    }

    fn told(&self) -> Told {
        let told = |(pair, found): (&[usize; 2], &PairFindings)| {
            (*pair, found.crossing_faces.clone().unwrap_or_default())
        };
        Told::Crossings(self.question.pairs.iter().zip(&self.found).map(told).collect())
    }
}
