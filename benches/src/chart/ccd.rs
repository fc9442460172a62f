//! Time of continuous collision queries over the errors of their answers.
//!
//! Vertices against faces and edges against edges, half of each: a peer's cubic, a plain one,
//! interval subdivision, and the crate `ccd` with default parameters, with exact decisions, and
//! with separations. An answer errs by a missed contact, by a false alarm, and by the earliness of
//! its time.

use std::error::Error;
use std::path::{Path, PathBuf};

use ccd::CcdParams;
use serde_json::{Value, json};

use super::curves::machine;
use super::poster::{ErrorAxis, Mark, MethodKey, Poster};
use super::sheet::{Settings, Sheet};
use crate::ccd::answers::{Answers, Method, mean_times};
use crate::ccd::methods::{certified, contact, del_geo, interval_subdivision, plain_cubic};
use crate::ccd::queries::{CcdQuery, QueryKind, QuerySet, mean_extent, on_lattice, random, read};
use crate::measure::as_f64;

/// Generated queries of each kind, and queries used of a file, about.
const GENERATED: usize = 4000;
const USED: usize = 4000;

/// Separations over the mean extent of a query.
const SEPARATIONS: [f64; 5] = [1e-2, 1e-3, 1e-4, 1e-5, 1e-6];

/// Rounds, of which the minimum time of each block counts.
const ROUNDS: usize = 9;

/// Queries of each kind that interval subdivision answers, which takes a thousand times as long.
const SUBDIVIDED: usize = 80;

const ATTRIBUTION: &str = "queries of B. Wang et al., ACM TOG 40(5), 2021 (MIT) and of D. Belgrod et al., 2023 (Apache-2.0); exact answers by integer and algebraic arithmetic";

const DEL_GEO: MethodKey = MethodKey::new("del-geo-core", "its cubic, f64", 0xb5_26_2e);
const PLAIN: MethodKey = MethodKey::new("plain cubic", "Provot 1997 in f64", 0xe0_7b_00);
const INTERVALS: MethodKey =
    MethodKey::new("interval subdivision", "Snyder 1993, to 1e-6", 0x80_80_80);
const CERTIFIED: MethodKey = MethodKey::new("ccd", "default", 0x1f_6f_b4);
const EXACT: MethodKey =
    MethodKey::new("ccd (decided exactly)", "where rounding leaves it open", 0);
const SEPARATED: MethodKey =
    MethodKey::new("ccd (kept apart)", "by 1e-2, … 1e-6 of the extent", 0x2c_8c_3c).hollow();

/// Methods in the order of the legend.
const METHODS: [MethodKey; 6] = [DEL_GEO, PLAIN, INTERVALS, CERTIFIED, EXACT, SEPARATED];

/// Draws the pictures of generated queries and, where they are available, of published ones.
///
/// # Errors
///
/// When a file cannot be written or read.
pub fn run(folder: &Path) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let kinds = [QueryKind::VertexFace, QueryKind::EdgeEdge];
    let labeled = |generate: fn(QueryKind, usize) -> QuerySet| {
        kinds.map(|kind| with_exact_answers(generate(kind, GENERATED)))
    };
    let generated = [
        LabeledSet::new("at random", labeled(random)),
        LabeledSet::new("degenerate, on a lattice", labeled(on_lattice)),
    ];
    let mut written = draw_sets("ccd", &generated, None, folder)?;

    if let Some(data) = std::env::var_os("MUSCULO_DATA") {
        let queries = Path::new(&data).join("ccd");
        let mut published = Vec::new();
        for (title, name) in [
            ("candidates of simulations", "full/simbp"),
            ("contacts of simulations", "full/simhard"),
            ("degenerate by design", "handcrafted"),
        ] {
            let read = |kind: &str| read(&queries, &format!("{name}_{kind}"));
            published.push(LabeledSet::new(title, [read("vf")?, read("ee")?]));
        }
        written.extend(draw_sets("ccd-published", &published, Some(ATTRIBUTION), folder)?);
    }
    Ok(written)
}

/// Sets the times by exact arithmetic: the end of the interval that the contact is in.
fn with_exact_answers(mut set: QuerySet) -> QuerySet {
    for query in &mut set.queries {
        let contact = contact(query, &CcdParams::EXACT);
        query.time = contact.map_or(f64::INFINITY, |contact| contact.hi);
    }
    set
}

/// Queries of both kinds with exact answers.
struct LabeledSet {
    title: &'static str,
    queries: Vec<CcdQuery>,
    /// The few of them that interval subdivision answers.
    few: Vec<CcdQuery>,
}

impl LabeledSet {
    /// Takes a share of the queries of each kind, evenly over the file.
    fn new(title: &'static str, by_kind: [QuerySet; 2]) -> Self {
        let (mut queries, mut few) = (Vec::new(), Vec::new());
        for set in by_kind {
            let step = (set.queries.len() / USED).max(1);
            let used: Vec<CcdQuery> = set.queries.into_iter().step_by(step).collect();
            few.extend(used.iter().step_by(used.len().div_ceil(SUBDIVIDED)));
            queries.extend(used);
        }
        Self { title, queries, few }
    }

    /// Measures all methods; the fast ones take turns.
    fn measure(&self) -> Vec<Measurement> {
        let extent = mean_extent(&self.queries);
        let separated = SEPARATIONS.map(|separation| {
            let params = CcdParams { min_separation: separation * extent, ..CcdParams::DEFAULT };
            move |query: &CcdQuery| certified(query, &params)
        });

        let mut keys: Vec<(MethodKey, Option<f64>)> =
            vec![(DEL_GEO, None), (PLAIN, None), (CERTIFIED, None), (EXACT, None)];
        let mut methods: Vec<Method<'_>> = vec![
            &del_geo,
            &plain_cubic,
            &|query| certified(query, &CcdParams::DEFAULT),
            &|query| certified(query, &CcdParams::EXACT),
        ];
        for (separation, method) in SEPARATIONS.iter().zip(&separated) {
            keys.push((SEPARATED, Some(*separation)));
            methods.push(method);
        }

        let mut measured = self.measure_methods(&keys, &self.queries, &methods, ROUNDS);
        let keys = [(INTERVALS, None)];
        measured.extend(self.measure_methods(&keys, &self.few, &[&interval_subdivision], 1));
        measured
    }

    /// Measures methods, given with their separations, over some of the queries.
    fn measure_methods(
        &self,
        keys: &[(MethodKey, Option<f64>)],
        queries: &[CcdQuery],
        methods: &[Method<'_>],
        rounds: usize,
    ) -> Vec<Measurement> {
        let contacts = queries.iter().filter(|query| query.time.is_finite()).count();
        let times = mean_times(queries, rounds, methods);
        let mut measured = Vec::new();
        for ((&(key, separation), method), time) in keys.iter().zip(methods).zip(times) {
            measured.push(Measurement {
                title: self.title,
                method: key.name,
                separation,
                time,
                queries: queries.len(),
                contacts,
                answers: Answers::new(queries, method),
            });
        }
        measured
    }
}

/// Times and answers of one method over a set of queries.
#[derive(Clone, Debug)]
struct Measurement {
    title: &'static str,
    method: &'static str,
    /// Separation over the mean extent.
    separation: Option<f64>,
    /// Mean time per query \[ns\].
    time: f64,
    queries: usize,
    contacts: usize,
    answers: Answers,
}

impl Measurement {
    /// Returns the shares of false alarms among queries without contact, and of missed and late
    /// answers among those with one.
    fn shares(&self) -> [f64; 3] {
        let Answers { false_alarms, missed, late, .. } = self.answers;
        [
            share(false_alarms, self.queries - self.contacts),
            share(missed, self.contacts),
            share(late, self.contacts),
        ]
    }

    fn mark(&self) -> Mark {
        let [false_alarms, missed, late] = self.shares();

        // Late contacts have no earliness.
        let earliness = self.answers.earliness(99).max(0.0);
        Mark {
            group: self.title,
            method: self.method,
            time: self.time,
            errors: [false_alarms, missed, earliness].map(Some),
            figures: [self.time, false_alarms, missed, late, earliness].map(Some),
        }
    }

    fn row(&self) -> Value {
        let Self { title, method, separation, time, answers, .. } = self;
        let [false_alarms, missed, late] = self.shares();
        let [median, most] = [50, 99].map(|percent| answers.earliness(percent));
        json!([title, method, separation, time, false_alarms, missed, late, median, most])
    }
}

fn share(count: usize, total: usize) -> f64 {
    as_f64(count) / as_f64(total.max(1))
}

fn draw_sets(
    name: &'static str,
    sets: &[LabeledSet],
    attribution: Option<&str>,
    folder: &Path,
) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    // The caption has the counts of queries, so that it follows the measurements.
    let measured: Vec<Measurement> = sets.iter().flat_map(LabeledSet::measure).collect();
    let titles: Vec<&'static str> = sets.iter().map(|set| set.title).collect();
    let mut settings = settings(&measured, &titles);
    settings.extend(attribution.map(|text| ("data", text.to_owned())));

    // The legend has the figures of the last set, the hardest.
    let poster = Poster {
        heading: "First contacts of moving primitives: time per query over error",
        time_label: "time per query [ns]",
        row_height: 360,
        methods: &METHODS,
        errors: [
            ErrorAxis { label: "false alarms [share]", range: [-5.0, 0.0] },
            ErrorAxis { label: "missed [share]", range: [-5.0, 0.0] },
            ErrorAxis { label: "earliness, 99 of 100 [step]", range: [-16.0, 0.0] },
        ],
        figures: [
            "time [ns]",
            "false alarms [share]",
            "missed [share]",
            "late [share]",
            "earliness, 99 of 100 [step]",
        ],
        groups: &titles,
        legend_group: titles.last().copied().unwrap_or_default(),
        marks: measured.iter().map(Measurement::mark).collect(),
        settings: &settings,
    };
    let svg = Some(poster.draw()?);
    let rows = measured.iter().map(Measurement::row).collect();
    Ok(Sheet { name, svg, settings, columns: COLUMNS, rows }.write(folder)?)
}

const SHARES: &str = "false alarms of the queries without contact, missed of those with one; a contact kept apart is reported where bodies come within the separation, which counts as a false alarm here";
const EARLINESS: &str = "exact time of contact less the one reported, in shares of the step: 99 of 100 are less; late contacts count as 0";
const TIME: &str = "per query, minimum of several for each block, methods in turns; interval subdivision answers 160";

fn settings(measured: &[Measurement], titles: &[&str]) -> Settings {
    let mut counts = Vec::new();
    for title in titles {
        if let Some(Measurement { queries, contacts, .. }) =
            measured.iter().find(|m| m.title == *title)
        {
            counts.push(format!("{title}: {queries}, {contacts} with a contact"));
        }
    }
    vec![
        ("queries, half vertex–face and half edge–edge", counts.join("; ")),
        ("shares", SHARES.to_owned()),
        ("earliness", EARLINESS.to_owned()),
        ("time", TIME.to_owned()),
        ("machine", machine()),
    ]
}

const COLUMNS: &[&str] = &[
    "queries",
    "method",
    "separation [extent]",
    "time [ns]",
    "false alarms [share]",
    "missed [share]",
    "late [share]",
    "median earliness [step]",
    "99 % earliness [step]",
];
