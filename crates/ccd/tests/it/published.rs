//! Published and adversarial queries with exact answers: none is missed, none is late, and false
//! alarms stay within their limits.

#![expect(clippy::print_stdout, reason = "figures of each file")]

use std::collections::BTreeMap;

use ccd::{CcdContact, CcdParams};

use crate::query_files::{self, LabeledQuery, read};

/// Files without their ending, and the false alarms allowed without exact arithmetic.
const FILES: [(&str, usize); 14] = [
    ("handcrafted_vf", 50),
    ("handcrafted_ee", 83),
    ("simbp_vf", 0),
    ("simbp_ee", 0),
    ("simhard_vf", 0),
    ("simhard_ee", 0),
    ("adversarial_vf", 100),
    ("adversarial_ee", 130),
    ("vertextouch_vf", 0),
    ("vertextouch_ee", 0),
    ("full/simbp_vf", 0),
    ("full/simbp_ee", 0),
    ("full/simhard_vf", 0),
    ("full/simhard_ee", 0),
];

/// Counts of wrong answers in a file, and earliness of the right ones.
#[derive(Debug, Default)]
struct Tally {
    missed: usize,
    late: usize,
    wrongly_certain: usize,
    possible: usize,
    /// Counted by family.
    false_alarms: BTreeMap<u8, usize>,
    earliness: Vec<f64>,
}

impl Tally {
    fn of(queries: &[LabeledQuery], answer: impl Fn(&LabeledQuery) -> Option<CcdContact>) -> Self {
        let mut tally = Self::default();
        for query in queries {
            tally.add(query, answer(query));
        }
        tally.earliness.sort_by(f64::total_cmp);
        tally
    }

    fn add(&mut self, query: &LabeledQuery, answer: Option<CcdContact>) {
        let meets = query.time.is_finite();
        let Some(contact) = answer else {
            self.missed += usize::from(meets);
            return;
        };
        self.possible += usize::from(!contact.is_certain());
        if meets {
            self.late += usize::from(contact.lo > query.time);
            self.wrongly_certain += usize::from(contact.is_certain() && contact.hi < query.time);
            self.earliness.push(query.time - contact.lo);
        } else {
            self.wrongly_certain += usize::from(contact.is_certain());
            *self.false_alarms.entry(query.group).or_default() += 1;
        }
    }

    /// Returns a percentile of the earliness.
    fn earliness(&self, percent: usize) -> f64 {
        self.earliness
            .get(self.earliness.len().saturating_sub(1) * percent / 100)
            .copied()
            .unwrap_or(0.0)
    }

    /// Checks what holds for every file.
    fn assert_safe(&self, name: &str) {
        let wrong = (self.missed, self.late, self.wrongly_certain);
        assert_eq!(wrong, (0, 0, 0), "{name}: missed, late, wrongly certain");
    }
}

/// Runs the queries of every file, and checks their tally.
fn for_each_file(params: &CcdParams, check: impl Fn(&str, usize, &Tally)) {
    let Some(folder) = query_files::folder() else { return };
    for (name, allowed) in FILES {
        let (kind, queries) = read(&folder.join(name).with_extension("ccdq"));
        let tally = Tally::of(&queries, |query| {
            kind.query(query.x0, query.x1, params).expect("published queries are finite")
        });
        println!(
            "{name}: false alarms {:?}, {} possible, early {:.1e} {:.1e}",
            tally.false_alarms,
            tally.possible,
            tally.earliness(50),
            tally.earliness(99)
        );
        tally.assert_safe(name);
        check(name, allowed, &tally);
    }
}

#[test]
fn no_contact_is_missed_or_late() {
    for_each_file(&CcdParams::DEFAULT, |name, allowed, tally| {
        let false_alarms: usize = tally.false_alarms.values().sum();
        assert!(false_alarms <= allowed, "{name}: {false_alarms} false alarms");
        if name.contains("sim") {
            assert!(tally.earliness(50) <= 1e-12, "{name}: {}", tally.earliness(50));
            assert!(tally.earliness(99) <= 1e-8, "{name}: {}", tally.earliness(99));
        }
    });
}

#[cfg(feature = "exact")]
#[test]
fn exact_arithmetic_leaves_no_false_alarm() {
    for_each_file(&CcdParams::EXACT, |name, _, tally| {
        assert_eq!((tally.false_alarms.len(), tally.possible), (0, 0), "{name}");
    });
}
