//! Incremental detection: pairs of which neither body moved keep their report.

use surface::Contact;
use surface::progress::{Interrupted, Progress};

use super::ResolveError;
use super::contacts::edge_contacts;
use proximity::PairProximity;
use scene::{PairId, PairReport, Scene};
use surface::parallel;

/// Pairs of bodies within the detection margin, in the order of the bodies.
#[derive(Debug, Default)]
pub(super) struct NearPairs {
    pairs: Vec<NearPair>,
}

/// Pair of bodies within the detection margin.
#[derive(Debug)]
pub(super) struct NearPair {
    /// The report, without the distance between the surfaces and without patches.
    pub(super) report: PairReport,
    /// Contacts of crossing faces without a vertex inside.
    pub(super) edges: Vec<Contact>,
}

impl NearPair {
    /// Computes the depth of the overlap, of vertices or of edges.
    pub(super) fn depth(&self) -> f64 {
        self.edges.iter().map(|contact| -contact.gap).fold(self.report.max_depth, f64::max)
    }

    /// Returns true if the pair overlaps in one of these reports.
    pub(super) fn overlaps_in(&self, reports: &[PairReport]) -> bool {
        reports.iter().any(|report| report.overlaps && report.pair == self.report.pair)
    }
}

impl NearPairs {
    /// Returns the pairs, in the order of the bodies.
    pub(super) fn iter(&self) -> impl Iterator<Item = &NearPair> {
        self.pairs.iter()
    }

    /// Returns the pairs that overlap.
    pub(super) fn overlapping(&self) -> impl Iterator<Item = &NearPair> {
        self.iter().filter(|pair| pair.report.overlaps)
    }

    /// Detects the pairs of moved bodies again. On an error, only pairs of unmoved bodies remain.
    pub(super) fn update(
        &mut self,
        scene: &mut Scene,
        margin: f64,
        moved: &[bool],
        progress: Progress<'_>,
    ) -> Result<(), ResolveError> {
        let has_moved = |pair: PairId| moved[pair.a.index()] || moved[pair.b.index()];
        self.pairs.retain(|pair| !has_moved(pair.report.pair));

        scene.fit_all()?;
        let mut stale = scene.close_pairs(margin)?;
        let scene = &*scene;
        stale.retain(|&pair| has_moved(pair));
        let detect = |found: &mut PairProximity, &pair: &PairId| {
            progress.report(0.0)?;
            let Some(trees) = scene.body(pair.a).tree().zip(scene.body(pair.b).tree()) else {
                return Ok(None);
            };
            found.compute(trees.0, trees.1, margin);
            let report = found.has_contact().then(|| PairReport::new(pair, found));
            Ok(report.map(|report| NearPair { edges: edge_contacts(scene, &report), report }))
        };
        let detected = parallel::map_slice_with(&stale, PairProximity::default, detect);

        let detected: Result<Vec<_>, Interrupted> = detected.into_iter().collect();
        self.pairs.extend(detected?.into_iter().flatten());
        self.pairs.sort_unstable_by_key(|pair| pair.report.pair);
        Ok(())
    }
}
