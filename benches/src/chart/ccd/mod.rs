//! Time of continuous collision queries over the errors of their answers.
//!
//! Vertices against faces and edges against edges, half of each: a peer's cubic, a plain one,
//! interval subdivision, and the crate `ccd` with default parameters, with exact decisions, and
//! with separations. An answer errs by a missed contact, by a false alarm, and by the earliness of
//! its time.

mod draw;

use std::error::Error;
use std::path::{Path, PathBuf};

use ccd::CcdParams;

use super::curves::machine;
use super::poster::MethodKey;
use super::sheet::{Cell, Sheet, number};
use crate::ccd::answers::{Answers, mean_times};
use crate::ccd::methods::{certified, del_geo, interval_subdivision, plain_cubic};
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

/// Draws the pictures of generated queries and, where they are available, of published ones.
///
/// # Errors
///
/// When a file cannot be written or read.
pub fn run(folder: &Path) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let kinds = [QueryKind::VertexFace, QueryKind::EdgeEdge];
    let generated = [
        LabeledSet {
            title: "at random",
            by_kind: kinds.map(|kind| with_exact_answers(random(kind, GENERATED))),
        },
        LabeledSet {
            title: "degenerate, on a lattice",
            by_kind: kinds.map(|kind| with_exact_answers(on_lattice(kind, GENERATED))),
        },
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
            published.push(LabeledSet { title, by_kind: [read("vf")?, read("ee")?] });
        }
        written.extend(draw_sets("ccd-published", &published, Some(ATTRIBUTION), folder)?);
    }
    Ok(written)
}

/// Queries of both kinds with exact answers.
struct LabeledSet {
    title: &'static str,
    by_kind: [QuerySet; 2],
}

/// Sets the times by exact arithmetic: the end of the interval that the contact is in.
fn with_exact_answers(mut set: QuerySet) -> QuerySet {
    for query in &mut set.queries {
        let contact = match set.kind {
            QueryKind::VertexFace => ccd::vertex_face(query.x0, query.x1, &CcdParams::EXACT),
            QueryKind::EdgeEdge => ccd::edge_edge(query.x0, query.x1, &CcdParams::EXACT),
        };
        query.time = contact.ok().flatten().map_or(f64::INFINITY, |contact| contact.hi);
    }
    set
}

/// Methods in the order of the legend.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum CcdMethod {
    DelGeo,
    Plain,
    Intervals,
    Certified,
    Exact,
    Separated,
}

impl CcdMethod {
    const ALL: [Self; 6] =
        [Self::DelGeo, Self::Plain, Self::Intervals, Self::Certified, Self::Exact, Self::Separated];

    /// Returns the legend entry.
    const fn key(self) -> MethodKey {
        match self {
            Self::DelGeo => MethodKey::new("del-geo-core", "its cubic, f64", 0xb5_26_2e),
            Self::Plain => MethodKey::new("plain cubic", "Provot 1997 in f64", 0xe0_7b_00),
            Self::Intervals => {
                MethodKey::new("interval subdivision", "Snyder 1993, to 1e-6", 0x80_80_80)
            }
            Self::Certified => MethodKey::new("ccd", "default", 0x1f_6f_b4),
            Self::Exact => {
                MethodKey::new("ccd (decided exactly)", "where rounding leaves it open", 0)
            }
            Self::Separated => {
                MethodKey::new("ccd (kept apart)", "by 1e-2, … 1e-6 of the extent", 0x2c_8c_3c)
                    .hollow()
            }
        }
    }
}

/// Method with its parameters.
struct Candidate {
    method: CcdMethod,
    /// Separation over the mean extent.
    separation: Option<f64>,
    params: CcdParams,
}

impl Candidate {
    fn new(method: CcdMethod, params: CcdParams) -> Self {
        Self { method, separation: None, params }
    }

    /// Returns all methods, with separations relative to an extent.
    fn all(extent: f64) -> Vec<Self> {
        let mut all = vec![
            Self::new(CcdMethod::DelGeo, CcdParams::DEFAULT),
            Self::new(CcdMethod::Plain, CcdParams::DEFAULT),
            Self::new(CcdMethod::Certified, CcdParams::DEFAULT),
            Self::new(CcdMethod::Exact, CcdParams::EXACT),
        ];
        for separation in SEPARATIONS {
            let params = CcdParams { min_separation: separation * extent, ..CcdParams::DEFAULT };
            let candidate = Self::new(CcdMethod::Separated, params);
            all.push(Self { separation: Some(separation), ..candidate });
        }
        all.push(Self::new(CcdMethod::Intervals, CcdParams::DEFAULT));
        all
    }

    fn answer(&self, kind: QueryKind, query: &CcdQuery) -> Option<f64> {
        match self.method {
            CcdMethod::DelGeo => del_geo(kind, query),
            CcdMethod::Plain => plain_cubic(kind, query),
            CcdMethod::Intervals => interval_subdivision(kind, query),
            CcdMethod::Certified | CcdMethod::Exact | CcdMethod::Separated => {
                certified(kind, query, &self.params)
            }
        }
    }
}

/// Times and answers of one method over a set of queries.
#[derive(Clone, Debug)]
struct Measurement {
    title: &'static str,
    method: CcdMethod,
    separation: Option<f64>,
    /// Mean time per query \[ns\].
    time: f64,
    queries: usize,
    contacts: usize,
    answers: Answers,
}

impl Measurement {
    /// Returns the share of false alarms among queries without contact.
    fn false_alarms(&self) -> f64 {
        share(self.answers.false_alarms, self.queries - self.contacts)
    }

    /// Returns the share of contacts that are not reported.
    fn missed(&self) -> f64 {
        share(self.answers.missed, self.contacts)
    }

    /// Returns the share of contacts that are reported only after they happen.
    fn late(&self) -> f64 {
        share(self.answers.late, self.contacts)
    }

    /// Returns the earliness of 99 of 100 contacts; 0 for late ones.
    fn earliness(&self) -> f64 {
        self.answers.earliness(99).max(0.0)
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
    let measured: Vec<Measurement> = sets.iter().flat_map(measure).collect();
    let titles: Vec<&str> = sets.iter().map(|set| set.title).collect();
    let mut settings = settings(&measured, &titles);
    settings.extend(attribution.map(|text| ("data", text.to_owned())));

    let svg = Some(draw::draw(&measured, &titles, &settings)?);
    let rows = measured.iter().map(row).collect();
    Ok(Sheet { name, svg, settings, columns: COLUMNS.into(), rows }.write(folder)?)
}

/// Measures all methods over a set; the fast ones take turns.
fn measure(set: &LabeledSet) -> Vec<Measurement> {
    // A share of the queries, evenly over the file; of these few for subdivision.
    let used = set.by_kind.each_ref().map(|set| set.thinned((set.queries.len() / USED).max(1)));
    let mut candidates = Candidate::all(mean_extent(used.iter().flatten()));
    let few = used.each_ref().map(|queries| {
        queries.iter().step_by(queries.len().div_ceil(SUBDIVIDED)).copied().collect()
    });
    let subdivision = candidates.split_off(candidates.len() - 1);

    let mut measured = measure_candidates(set, &used, &candidates, ROUNDS);
    measured.extend(measure_candidates(set, &few, &subdivision, 1));
    measured
}

fn measure_candidates(
    set: &LabeledSet,
    used: &[Vec<CcdQuery>; 2],
    candidates: &[Candidate],
    rounds: usize,
) -> Vec<Measurement> {
    let queries = used.iter().map(Vec::len).sum();
    let contacts = used.iter().flatten().filter(|query| query.time.is_finite()).count();
    let mut measured = Vec::new();
    for &Candidate { method, separation, .. } in candidates {
        let (title, answers) = (set.title, Answers::default());
        measured.push(Measurement {
            title,
            method,
            separation,
            time: 0.0,
            queries,
            contacts,
            answers,
        });
    }

    // Both kinds of queries count by their numbers.
    for (of_kind, used) in set.by_kind.iter().zip(used) {
        let answer =
            |candidate| move |query: &CcdQuery| Candidate::answer(candidate, of_kind.kind, query);
        let answers: Vec<_> = candidates.iter().map(answer).collect();
        let methods: Vec<_> =
            answers.iter().map(|answer| answer as crate::ccd::answers::Method<'_>).collect();
        let times = mean_times(used, rounds, &methods);
        for ((measured, method), time) in measured.iter_mut().zip(methods).zip(times) {
            measured.time += time * share(used.len(), queries);
            measured.answers.add(used, method);
        }
    }
    measured
}

const SHARES: &str = "false alarms of the queries without contact, missed of those with one; a contact kept apart is reported where bodies come within the separation, which counts as a false alarm here";
const EARLINESS: &str = "exact time of contact less the one reported, in shares of the step: 99 of 100 are less; late contacts count as 0";
const TIME: &str = "per query, minimum of several for each block, methods in turns; interval subdivision answers 160";

fn settings(measured: &[Measurement], titles: &[&str]) -> Vec<(&'static str, String)> {
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

const COLUMNS: [&str; 9] = [
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

fn row(m: &Measurement) -> Vec<Cell> {
    let mut row = vec![Cell::text(m.title), Cell::text(m.method.key().name), number(m.separation)];
    let earliness = [m.answers.earliness(50), m.answers.earliness(99)];
    let values = [m.time, m.false_alarms(), m.missed(), m.late()].into_iter().chain(earliness);
    row.extend(values.map(Cell::Number));
    row
}
