//! Continuous collision queries beside other methods: times, missed contacts, late answers.
//!
//! The queries are the published ones in the folder `ccd` of the folder that the environment
//! variable `MUSCULO_DATA` names. Without it, random queries are timed.

use std::error::Error;
use std::io;
use std::path::Path;

use ::ccd::{CcdParams, MovingPoints};

use crate::ccd::answers::{Answers, NamedMethod, max_time, mean_times};
use crate::ccd::methods::{certified, plain_cubic};
use crate::ccd::queries::{QueryKind, QuerySet, mean_extent, random, read};
use crate::measure::{Report, as_f64};

/// No bound.
const ANY: f64 = f64::INFINITY;

/// Bounds for a set of queries.
#[derive(Clone, Copy)]
struct Limits {
    /// Times without and with a separation over that of a plain cubic, which has none.
    plain: [f64; 2],
    /// The same over the uncertified cubic of `del-geo-core`.
    #[cfg_attr(not(feature = "peers"), expect(dead_code, reason = "compared with peers"))]
    peer: [f64; 2],
    /// Time of the filter of a batch per candidate \[ns\].
    filter: f64,
    /// False alarms without exact arithmetic; with it there are none.
    false_alarms: f64,
    /// Earliness of reported times, median and 99th percentile \[share of the step\].
    earliness: [f64; 2],
}

/// Broad-phase candidates of simulations, nearly all without contact.
const CANDIDATES: Limits = Limits {
    plain: [1.6, 2.5],
    peer: [1.0, 1.0],
    filter: 25.0,
    false_alarms: 0.0,
    earliness: [1e-12, 1e-8],
};
/// Contacts of simulations.
const CONTACTS: Limits = Limits { plain: [2.2, 7.0], peer: [1.1, 3.7], ..CANDIDATES };
/// Degenerate cases: only safety and exactness are promised.
const DEGENERATE: Limits = Limits {
    plain: [ANY, ANY],
    peer: [ANY, ANY],
    filter: ANY,
    false_alarms: ANY,
    earliness: [ANY, ANY],
};

/// Random queries, without exact answers.
const RANDOM: Limits = Limits { plain: [1.8, 3.0], peer: [1.0, 3.0], ..DEGENERATE };

/// Rounds at full effort, of which the minimum time of each block counts.
const ROUNDS: u32 = 15;

/// Budget of the filter of a batch \[ms\].
const BUDGET: u64 = 200;

/// Compares all sets of queries.
pub(super) fn run(report: &mut Report) -> Result<(), Box<dyn Error>> {
    for (queries, limits) in sets()? {
        Comparison { set: &queries, limits, report }.run();
    }
    Ok(())
}

fn sets() -> io::Result<Vec<(QuerySet, Limits)>> {
    let Some(data) = std::env::var_os("MUSCULO_DATA") else {
        let kinds = [QueryKind::VertexFace, QueryKind::EdgeEdge];
        return Ok(kinds.map(|kind| (random(kind, 20_000), RANDOM)).into());
    };
    let files = [
        ("full/simbp", CANDIDATES),
        ("full/simhard", CONTACTS),
        ("handcrafted", DEGENERATE),
        ("adversarial", DEGENERATE),
        ("vertextouch", DEGENERATE),
    ];

    // Two files per set: vertices against faces, and edges against edges.
    let folder = Path::new(&data).join("ccd");
    let mut sets = Vec::new();
    for (name, limits) in files {
        for kind in ["vf", "ee"] {
            sets.push((read(&folder, &format!("{name}_{kind}"))?, limits));
        }
    }
    Ok(sets)
}

/// One set of queries, answered by every method.
struct Comparison<'a> {
    set: &'a QuerySet,
    limits: Limits,
    report: &'a mut Report,
}

impl Comparison<'_> {
    fn run(mut self) {
        self.times();
        self.batches();
        self.slowest();
        if self.set.is_labelled() {
            self.answers();
        }
    }

    fn name(&self, what: &str) -> String {
        format!("{}: {what}", self.set.name.trim_start_matches("full/"))
    }

    fn times(&mut self) {
        let queries = &self.set.queries;
        // A thousandth of the extent, enough to absorb the rounding of positions.
        let apart = CcdParams { min_separation: 1e-3 * mean_extent(queries), ..CcdParams::DEFAULT };
        let methods: &[NamedMethod<'_>] = &[
            ("certified", &|query| certified(query, &CcdParams::DEFAULT)),
            ("separation", &|query| certified(query, &apart)),
            ("plain cubic", &plain_cubic),
            #[cfg(feature = "peers")]
            ("del-geo-core", &crate::ccd::methods::del_geo),
        ];
        let (name, rounds) = (self.name("queries"), self.report.rounds(ROUNDS));
        let times = mean_times(&name, queries, rounds, methods, self.report);
        self.beside("plain cubic", [times[0], times[1], times[2]], self.limits.plain);
        #[cfg(feature = "peers")]
        self.beside("del-geo-core", [times[0], times[1], times[3]], self.limits.peer);
    }

    /// Reports times without and with a separation beside that of another method.
    fn beside(&mut self, other: &str, [ours, apart, time]: [f64; 3], allowed: [f64; 2]) {
        for (what, ours, allowed) in
            [("certified", ours, allowed[0]), ("separation", apart, allowed[1])]
        {
            let name = self.name(&format!("{what} / {other}"));
            self.report.ratio(name, [ours, time], "ns", allowed);
        }
    }

    /// Times the filter of a batch, which most candidates end at.
    fn batches(&mut self) {
        let ([x0, x1], candidates) = self.set.as_motion();
        let Ok(points) = MovingPoints::new(&x0, &x1) else { return };
        let filter = match self.set.kind {
            QueryKind::VertexFace => MovingPoints::filter_vertex_faces,
            QueryKind::EdgeEdge => MovingPoints::filter_edge_edges,
        };

        let name = self.name("batch, filter only");
        let mut filtered =
            || filter(&points, &candidates, &CcdParams::DEFAULT).map_or(0, |left| left.len());
        let [time] = self.report.interleave(&name, BUDGET, [("filter", &mut filtered)]);
        let time = time / as_f64(candidates.len());
        self.report.cost(name, time, "ns", self.limits.filter);
    }

    fn slowest(&mut self) {
        for (label, params) in
            [("slowest", CcdParams::DEFAULT), ("slowest, exact", CcdParams::EXACT)]
        {
            let time = max_time(&self.set.queries, &|query| certified(query, &params));
            self.report.cost(self.name(label), time * 1e-3, "us", 100.0);
        }
    }

    /// Compares answers with the exact ones: none may be missed or late.
    fn answers(&mut self) {
        let limits = self.limits;
        for (method, params, false_alarms) in [
            ("certified", CcdParams::DEFAULT, limits.false_alarms),
            ("exact", CcdParams::EXACT, 0.0),
        ] {
            let answers = Answers::new(&self.set.queries, &|query| certified(query, &params));
            for (what, value, allowed) in [
                ("missed", as_f64(answers.missed), 0.0),
                ("late", as_f64(answers.late), 0.0),
                ("false alarms", as_f64(answers.false_alarms), false_alarms),
                ("median earliness", answers.earliness(50), limits.earliness[0]),
                ("99 % earliness", answers.earliness(99), limits.earliness[1]),
            ] {
                self.report.cost(self.name(&format!("{method}, {what}")), value, "", allowed);
            }
        }
    }
}
