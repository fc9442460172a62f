//! Published and adversarial queries with exact answers.

#![expect(clippy::print_stdout, reason = "figures of each file")]

mod support;

use std::collections::BTreeMap;

use ccd::Params;
use support::{Labelled, read};

/// Counts of wrong answers in a file.
#[derive(Debug, Default)]
struct Tally {
    queries: usize,
    hits: usize,
    missed: usize,
    late: usize,
    certain_but_false: usize,
    false_alarms: BTreeMap<u8, usize>,
    possible: usize,
    earliness: Vec<f64>,
}

impl Tally {
    fn add(&mut self, query: &Labelled, contact: Option<ccd::Contact>) {
        self.queries += 1;
        let is_hit = query.time.is_finite();
        self.hits += usize::from(is_hit);
        match contact {
            None => self.missed += usize::from(is_hit),
            Some(c) => {
                self.possible += usize::from(!c.is_certain());
                if is_hit {
                    self.late += usize::from(c.lo > query.time);
                    self.certain_but_false += usize::from(c.is_certain() && c.hi < query.time);
                    self.earliness.push(query.time - c.lo);
                } else {
                    *self.false_alarms.entry(query.group).or_default() += 1;
                    self.certain_but_false += usize::from(c.is_certain());
                }
            }
        }
    }

    fn quantile(&mut self, share: f64) -> f64 {
        self.earliness.sort_by(f64::total_cmp);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            clippy::cast_precision_loss,
            reason = "a place in a list"
        )]
        let at = ((self.earliness.len() as f64 - 1.0) * share) as usize;
        self.earliness.get(at).copied().unwrap_or(0.0)
    }
}

#[test]
fn no_published_contact_is_missed_or_late() {
    let Some(folder) = support::folder() else { return };
    for name in [
        "handcrafted",
        "simbp",
        "simhard",
        "adversarial",
        "vertextouch",
        "full/simbp",
        "full/simhard",
    ] {
        for suffix in ["vf", "ee"] {
            let (kind, queries) = read(&folder.join(format!("{name}_{suffix}.ccdq")));
            let mut tally = Tally::default();
            for query in &queries {
                let contact = kind.query(query.x0, query.x1, &params()).unwrap();
                tally.add(query, contact);
            }
            let (m, p, w) = (tally.quantile(0.5), tally.quantile(0.99), tally.quantile(1.0));
            tally.earliness.clear();
            println!("{name}_{suffix} {tally:?} early {m:.2e} {p:.2e} {w:.2e}");
            assert_eq!((tally.missed, tally.late, tally.certain_but_false), (0, 0, 0), "{name}");
        }
    }
}

fn params() -> Params {
    #[cfg(feature = "exact")]
    return Params::EXACT;
    #[cfg(not(feature = "exact"))]
    return Params::DEFAULT;
}
