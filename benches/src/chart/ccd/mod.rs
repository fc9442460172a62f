//! Time of a continuous collision query against how right its answer is.
//!
//! Vertices against faces and edges against edges, half of each: a peer's cubic, a plain one,
//! subdivision by interval arithmetic, and the crate `ccd` as it is, with exact decisions, and with
//! separations to be kept. An answer is wrong by a contact that is missed, by one told where none
//! is, and by how much earlier than the contact its time is.

mod draw;

use std::error::Error;
use std::path::{Path, PathBuf};

use ccd::CcdParams;

use super::curves::{machine, number};
use super::sheet::{Cell, Sheet};
use crate::ccd::measure::{Answers, Method, as_f64, mean_times};
use crate::ccd::methods::{certified, del_geo, interval_subdivision, plain_cubic};
use crate::ccd::queries::{Kind, Query, QuerySet, made, made_on_lattice, read};

/// Queries made of each kind.
const MADE: usize = 4000;

/// Queries taken of a file, about.
const TAKEN: usize = 4000;

/// Separations to be kept, over the mean extent of a query.
const SEPARATIONS: [f64; 5] = [1e-2, 1e-3, 1e-4, 1e-5, 1e-6];

/// Rounds of which the least time of each block counts.
const ROUNDS: usize = 9;

/// Draws the pictures and writes the numbers behind them: of queries that are made, and of published
/// ones where they are at hand.
///
/// # Errors
///
/// When a file cannot be written or read.
pub fn run(folder: &Path) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let kinds = [Kind::VertexFace, Kind::EdgeEdge];
    let made = [
        ("at random", kinds.map(|kind| labelled(made(kind, MADE)))),
        ("on a lattice, to be degenerate", kinds.map(|kind| labelled(made_on_lattice(kind, MADE)))),
    ];
    let mut written = draw_sets("ccd", &made, None, folder)?;
    if let Some(data) = std::env::var_os("MUSCULO_DATA") {
        let folder_of = PathBuf::from(data).join("ccd");
        let sets = [
            ("candidates of simulations", "full/simbp"),
            ("contacts of simulations", "full/simhard"),
            ("built to be degenerate", "handcrafted"),
        ];
        let mut published = Vec::new();
        for (title, name) in sets {
            let of = |kind: &str| read(&folder_of, &format!("{name}_{kind}"));
            published.push((title, [of("vf")?, of("ee")?]));
        }
        written.extend(draw_sets("ccd-published", &published, Some(ATTRIBUTION), folder)?);
    }
    Ok(written)
}

const ATTRIBUTION: &str = "queries of B. Wang et al., ACM TOG 40(5), 2021 (MIT) and of D. Belgrod et al., 2023 (Apache-2.0); exact answers by integer and algebraic arithmetic";

/// Queries with answers by exact arithmetic: of a contact, the end of the interval that it is in.
fn labelled(mut set: QuerySet) -> QuerySet {
    for query in &mut set.queries {
        let contact = match set.kind {
            Kind::VertexFace => ccd::vertex_face(query.x0, query.x1, &CcdParams::EXACT),
            Kind::EdgeEdge => ccd::edge_edge(query.x0, query.x1, &CcdParams::EXACT),
        };
        query.time = contact.ok().flatten().map_or(f64::INFINITY, |contact| contact.hi);
    }
    set
}

/// What one method does with some queries.
#[derive(Clone, Debug)]
struct Measured {
    set: usize,
    method: Way,
    setting: String,
    /// Of a query \[ns\].
    time: f64,
    queries: usize,
    contacts: usize,
    answers: Answers,
}

/// Ways to answer, in the order of the legend.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Way {
    DelGeo,
    Plain,
    Intervals,
    Certified,
    Exact,
    Separated,
}

impl Way {
    const ALL: [Self; 6] =
        [Self::DelGeo, Self::Plain, Self::Intervals, Self::Certified, Self::Exact, Self::Separated];

    const fn name(self) -> &'static str {
        match self {
            Self::DelGeo => "del-geo-core",
            Self::Plain => "plain cubic",
            Self::Intervals => "interval subdivision",
            Self::Certified => "ccd",
            Self::Exact => "ccd (decided exactly)",
            Self::Separated => "ccd (kept apart)",
        }
    }

    const fn settings(self) -> &'static str {
        match self {
            Self::DelGeo => "its cubic, f64",
            Self::Plain => "Provot 1997 in f64",
            Self::Intervals => "Snyder 1993, to 1e-6",
            Self::Certified => "as it is",
            Self::Exact => "what rounding leaves open",
            Self::Separated => "by 1e-2, … 1e-6 of the extent",
        }
    }
}

impl Measured {
    /// Contacts told where none is, over the queries without one.
    fn false_alarms(&self) -> f64 {
        share(self.answers.false_alarms, self.queries - self.contacts)
    }

    /// Contacts not found, or told only after they happen, over all.
    fn missed(&self) -> f64 {
        share(self.answers.missed, self.contacts)
    }

    fn late(&self) -> f64 {
        share(self.answers.late, self.contacts)
    }
}

fn share(count: usize, of: usize) -> f64 {
    as_f64(count) / as_f64(of.max(1))
}

type Sets = [(&'static str, [QuerySet; 2])];

fn draw_sets(
    name: &'static str,
    sets: &Sets,
    attribution: Option<&str>,
    folder: &Path,
) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let measured: Vec<Measured> =
        sets.iter().enumerate().flat_map(|(number, (_, set))| measure(number, set)).collect();
    let titles: Vec<&str> = sets.iter().map(|(title, _)| *title).collect();
    let settings = settings(&measured, &titles, attribution);
    let svg = draw::draw(&measured, &titles, &settings)?;
    let (columns, rows) = table(&measured, &titles);
    Ok(Sheet { name, svg: Some(svg), settings, columns, rows }.write(folder)?)
}

fn measure(set: usize, both: &[QuerySet; 2]) -> Vec<Measured> {
    let taken: Vec<Vec<Query>> = both
        .iter()
        .map(|of_kind| of_kind.thinned((of_kind.queries.len() / TAKEN).max(1)))
        .collect();
    let count: usize = taken.iter().map(Vec::len).sum();
    let contacts = taken.iter().flatten().filter(|query| query.time.is_finite()).count();
    let extent = mean_extent(&taken);
    let mut ways: Vec<(Way, String, Option<CcdParams>)> = vec![
        (Way::DelGeo, String::new(), None),
        (Way::Plain, String::new(), None),
        (Way::Certified, String::new(), Some(CcdParams::DEFAULT)),
        (Way::Exact, String::new(), Some(CcdParams::EXACT)),
    ];
    for separation in SEPARATIONS {
        let params = CcdParams { min_separation: separation * extent, ..CcdParams::DEFAULT };
        ways.push((Way::Separated, format!("{separation:e}"), Some(params)));
    }
    let mut times = vec![0.0; ways.len()];
    let mut answers = vec![Answers::default(); ways.len()];
    for (of_kind, queries) in both.iter().zip(&taken) {
        let answer = |(way, _, params): &(Way, String, Option<CcdParams>)| {
            let (way, params, kind) = (*way, *params, of_kind.kind);
            move |query: &Query| ask(way, kind, query, params.as_ref())
        };
        let asked: Vec<_> = ways.iter().map(answer).collect();
        let methods: Vec<Method<'_>> = asked.iter().map(|method| method as Method<'_>).collect();
        let least = mean_times(queries, ROUNDS, &methods);
        for (k, method) in methods.iter().enumerate() {
            times[k] += least[k] * as_f64(queries.len()) / as_f64(count);
            answers[k].add(queries, method);
        }
    }
    let of = |((method, setting, _), (time, answers))| Measured {
        set,
        method,
        setting,
        time,
        queries: count,
        contacts,
        answers,
    };
    let mut measured: Vec<Measured> =
        ways.into_iter().zip(times.into_iter().zip(answers)).map(of).collect();
    measured.push(subdivided(set, both, &taken));
    measured
}

/// Subdivision takes a thousand times as long: it is asked few.
fn subdivided(set: usize, both: &[QuerySet; 2], taken: &[Vec<Query>]) -> Measured {
    let (mut answers, mut time, mut count, mut contacts) = (Answers::default(), 0.0, 0, 0);
    for (of_kind, queries) in both.iter().zip(taken) {
        let few: Vec<Query> = queries.iter().step_by(queries.len().div_ceil(80)).copied().collect();
        let method = |query: &Query| interval_subdivision(of_kind.kind, query);
        time += mean_times(&few, 1, &[&method])[0] * as_f64(few.len());
        answers.add(&few, &method);
        count += few.len();
        contacts += few.iter().filter(|query| query.time.is_finite()).count();
    }
    let time = time / as_f64(count);
    let (method, setting) = (Way::Intervals, String::new());
    Measured { set, method, setting, time, queries: count, contacts, answers }
}

fn ask(way: Way, kind: Kind, query: &Query, params: Option<&CcdParams>) -> Option<f64> {
    match (way, params) {
        (Way::DelGeo, _) => del_geo(kind, query),
        (Way::Plain, _) => plain_cubic(kind, query),
        (_, Some(params)) => certified(kind, query, params),
        (_, None) => interval_subdivision(kind, query),
    }
}

fn mean_extent(taken: &[Vec<Query>]) -> f64 {
    let extent = |query: &Query| {
        let from_first = query.x0.iter().map(|x| x.distance(query.x0[0]));
        from_first.fold(0.0, f64::max)
    };
    let all = taken.iter().flatten();
    all.clone().map(extent).sum::<f64>() / as_f64(all.count().max(1))
}

fn settings(
    measured: &[Measured],
    titles: &[&str],
    attribution: Option<&str>,
) -> Vec<(&'static str, String)> {
    let of_set = |(number, title): (usize, &&str)| {
        let of = measured.iter().find(|m| m.set == number);
        let (queries, contacts) = of.map_or((0, 0), |m| (m.queries, m.contacts));
        format!("{title}: {queries}, {contacts} with a contact")
    };
    let counts: Vec<String> = titles.iter().enumerate().map(of_set).collect();
    let mut settings = vec![
        ("queries, half vertex–face and half edge–edge", counts.join("; ")),
        (
            "shares",
            "false alarms of the queries without contact, missed of those with one; a contact kept apart is told where bodies come within the separation, which counts as a false alarm here".to_owned(),
        ),
        (
            "earliness",
            "exact time of contact less the one told, in shares of the step: 99 of 100 are less; those told late count as 0".to_owned(),
        ),
        ("time", "of a query, least of several for each block, methods in turns; interval subdivision is asked 160".to_owned()),
        ("machine", machine()),
    ];
    settings.extend(attribution.map(|text| ("data", text.to_owned())));
    settings
}

fn table(measured: &[Measured], titles: &[&str]) -> (Vec<&'static str>, Vec<Vec<Cell>>) {
    let columns = vec![
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
    let row = |m: &Measured| {
        let mut row = vec![Cell::text(titles[m.set]), Cell::text(m.method.name())];
        row.push(number(m.setting.parse().ok()));
        let answers = [m.answers.earliness(50), m.answers.earliness(99)];
        let all = [m.time, m.false_alarms(), m.missed(), m.late()].into_iter().chain(answers);
        row.extend(all.map(Cell::Number));
        row
    };
    (columns, measured.iter().map(row).collect())
}
