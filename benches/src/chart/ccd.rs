//! Time of continuous collision queries over the errors of their answers.
//!
//! Vertices against faces and edges against edges, half of each: a peer's cubic, a plain one,
//! interval subdivision, and the crate `ccd` with default parameters, with exact decisions, and
//! with separations. An answer errs by a missed contact, by a false alarm, and by the earliness of
//! its time.

use std::error::Error;
use std::path::{Path, PathBuf};

use ccd::CcdParams;
use serde::Serialize;

use super::curves::machine;
use super::palette;
use super::poster::{ErrorAxis, Figure, MethodKey, Poster};
use super::sheet::Sheet;
use crate::ccd::answers::{Answers, NamedMethod, mean_times};
use crate::ccd::methods::{certified, contact, del_geo, interval_subdivision, plain_cubic};
use crate::ccd::queries::{CcdQuery, QueryKind, QuerySet, mean_extent, on_lattice, random, read};
use crate::measure::{Report, as_f64};

/// Generated queries of each kind, and queries used of a file, about.
const GENERATED: usize = 4000;
const USED: usize = 4000;

/// Separations over the mean extent of a query.
const SEPARATIONS: [f64; 5] = [1e-2, 1e-3, 1e-4, 1e-5, 1e-6];

/// Rounds, of which the minimum time of each block counts.
const ROUNDS: u32 = 9;

/// Queries of each kind that interval subdivision answers, which takes a thousand times as long.
const SUBDIVIDED: usize = 80;

const ATTRIBUTION: &str = "queries of B. Wang et al., ACM TOG 40(5), 2021 (MIT) and of D. Belgrod et al., 2023 (Apache-2.0); exact answers by integer and algebraic arithmetic";
const SHARES: &str = "false alarms of the queries without contact, missed of those with one; a contact kept apart is reported where bodies come within the separation, which counts as a false alarm here";
const EARLINESS: &str = "exact time of contact less the one reported, in shares of the step: 99 of 100 are less; late contacts count as 0";
const TIME: &str = "per query, minimum of several for each block, methods in turns; interval subdivision answers 160";

const LESSON: &str = "certified queries miss nothing, in about the time of a cubic that misses contacts where points and edges lie in one plane. A certificate of the separation costs little, and finds what comes near as well";

/// Methods in the order of the legend.
const METHODS: [MethodKey; 6] = [
    MethodKey::new("del-geo-core", "its cubic, f64", palette::VERMILION),
    MethodKey::new("plain cubic", "Provot 1997 in f64", palette::ORANGE),
    MethodKey::new("interval subdivision", "Snyder 1993, to 1e-6", palette::GRAY),
    MethodKey::new("ccd", "default", palette::BLUE),
    MethodKey::new("ccd (decided exactly)", "where rounding leaves it open", palette::BLACK),
    MethodKey::new("ccd (kept apart)", "by 1e-2, … 1e-6 of the extent", palette::GREEN).hollow(),
];

/// Draws the pictures of generated queries and, where they are available, of published ones.
///
/// # Errors
///
/// When a file cannot be written or read.
pub fn run(folder: &Path) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    // Generated queries, with answers in exact arithmetic.
    let mut generated = Vec::new();
    let generators: [Generator; 2] = [random, on_lattice];
    for (title, generate) in ["at random", "degenerate, on a lattice"].into_iter().zip(generators) {
        let sets = [QueryKind::VertexFace, QueryKind::EdgeEdge]
            .map(|kind| with_exact_answers(generate(kind, GENERATED)));
        generated.push(LabeledSet::new(title, sets));
    }
    let mut written = draw_sets("ccd", &generated, None, folder)?;

    // Published ones, where they are at hand.
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
        query.time = match contact {
            Some(contact) => contact.hi,
            None => f64::INFINITY,
        };
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

/// Function that generates queries of a kind, a number of them.
type Generator = fn(QueryKind, usize) -> QuerySet;

/// Answer to a query: the time of the first contact, if any.
type Answer<'a> = Box<dyn Fn(&CcdQuery) -> Option<f64> + 'a>;

/// A method with its separation over the mean extent, for those with one.
struct Candidate<'a> {
    method: &'static str,
    separation: Option<f64>,
    answer: Answer<'a>,
}

/// Mean time and errors of one method over a set of queries: a row of the table.
#[derive(Clone, Debug, Serialize)]
struct Measurement {
    /// Title of the set.
    queries: &'static str,
    method: &'static str,
    #[serde(rename = "separation [extent]")]
    separation: Option<f64>,
    #[serde(rename = "time [ns]")]
    time: f64,
    /// Of the queries without contact.
    #[serde(rename = "false alarms [share]")]
    false_alarms: f64,
    /// Of the queries with a contact.
    #[serde(rename = "missed [share]")]
    missed: f64,
    #[serde(rename = "late [share]")]
    late: f64,
    #[serde(rename = "median earliness [step]")]
    median_earliness: f64,
    #[serde(rename = "99 % earliness [step]")]
    earliness: f64,
}

impl LabeledSet {
    /// Takes a share of the queries of each kind, evenly over the file.
    fn new(title: &'static str, by_kind: [QuerySet; 2]) -> Self {
        let (mut queries, mut few) = (Vec::new(), Vec::new());
        for set in by_kind {
            let step = (set.queries.len() / USED).max(1);
            let used: Vec<CcdQuery> = set.queries.into_iter().step_by(step).collect();

            // The slow method answers fewer of them, again evenly over the file.
            few.extend(used.iter().step_by(used.len().div_ceil(SUBDIVIDED)));
            queries.extend(used);
        }
        Self { title, queries, few }
    }

    /// Measures all methods; the fast ones take turns.
    fn measure(&self) -> Vec<Measurement> {
        let extent = mean_extent(&self.queries);
        let [peer, plain, subdivision, default, exact, apart] = METHODS.map(|key| key.name);
        let by_ccd = |method, separation: Option<f64>, params: CcdParams| Candidate {
            method,
            separation,
            answer: Box::new(move |query: &CcdQuery| certified(query, &params)),
        };

        // All of these answer all queries, in turns.
        let mut candidates = vec![
            Candidate { method: peer, separation: None, answer: Box::new(del_geo) },
            Candidate { method: plain, separation: None, answer: Box::new(plain_cubic) },
            by_ccd(default, None, CcdParams::DEFAULT),
            by_ccd(exact, None, CcdParams::EXACT),
        ];
        for separation in SEPARATIONS {
            let min_separation = separation * extent;
            let params = CcdParams { min_separation, ..CcdParams::DEFAULT };
            candidates.push(by_ccd(apart, Some(separation), params));
        }
        let mut measured = self.measure_candidates(&candidates, &self.queries, ROUNDS);

        // Once, since it takes seconds for the few.
        let answer = Box::new(interval_subdivision);
        let slow = [Candidate { method: subdivision, separation: None, answer }];
        measured.extend(self.measure_candidates(&slow, &self.few, 1));
        measured
    }

    fn measure_candidates(
        &self,
        candidates: &[Candidate<'_>],
        queries: &[CcdQuery],
        rounds: u32,
    ) -> Vec<Measurement> {
        let mut methods: Vec<NamedMethod<'_>> = Vec::new();
        for Candidate { method, answer, .. } in candidates {
            methods.push((method, &**answer));
        }
        let times = mean_times(self.title, queries, rounds, &methods, &mut Report::new(1.0));

        // Each share is of the queries in which that error can occur.
        let contacts = count_contacts(queries);
        let mut measured = Vec::new();
        for (Candidate { method, separation, answer }, time) in candidates.iter().zip(times) {
            let answers = Answers::new(queries, &**answer);
            measured.push(Measurement {
                queries: self.title,
                method,
                separation: *separation,
                time,
                false_alarms: share(answers.false_alarms, queries.len() - contacts),
                missed: share(answers.missed, contacts),
                late: share(answers.late, contacts),
                median_earliness: answers.earliness(50),
                earliness: answers.earliness(99),
            });
        }
        measured
    }
}

fn count_contacts(queries: &[CcdQuery]) -> usize {
    queries.iter().filter(|query| query.time.is_finite()).count()
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
    let (mut counts, mut titles) = (Vec::new(), Vec::new());
    for LabeledSet { title, queries, .. } in sets {
        titles.push(*title);
        let contacts = count_contacts(queries);
        counts.push(format!("{title}: {}, {contacts} with a contact", queries.len()));
    }
    let mut settings = vec![
        ("queries, half vertex–face and half edge–edge", counts.join("; ")),
        ("shares", SHARES.to_owned()),
        ("earliness", EARLINESS.to_owned()),
        ("time", TIME.to_owned()),
        ("to take from it", LESSON.to_owned()),
        ("machine", machine()),
    ];
    settings.extend(attribution.map(|text| ("data", text.to_owned())));

    // The legend has the figures of the last set, the hardest.
    let measured: Vec<Measurement> = sets.iter().flat_map(LabeledSet::measure).collect();
    let sheet = Sheet::new(name, settings, &measured)?;
    let poster = Poster {
        heading: "First contacts of moving primitives: time per query over error",
        time: Figure::new("time per query [ns]", &["time [ns]"]),
        row_height: 360,
        methods: &METHODS,
        errors: [
            ErrorAxis { error: FALSE_ALARMS, range: [-5.0, 0.0] },
            ErrorAxis { error: MISSED, range: [-5.0, 0.0] },
            ErrorAxis { error: EARLY, range: [-15.0, 0.0] },
        ],
        figures: [
            Figure::new("time [ns]", &["time [ns]"]),
            FALSE_ALARMS,
            MISSED,
            Figure::new("late [share]", &["late [share]"]),
            EARLY,
        ],
        group_column: "queries",
        groups: &titles,
        legend_group: titles.last().copied().unwrap_or_default(),
        sheet: &sheet,
    };
    Ok(sheet.write(folder, Some(poster.draw()?))?)
}

const FALSE_ALARMS: Figure = Figure::new("false alarms [share]", &["false alarms [share]"]);
const MISSED: Figure = Figure::new("missed [share]", &["missed [share]"]);
const EARLY: Figure = Figure::new("earliness [step]", &["99 % earliness [step]"]);
