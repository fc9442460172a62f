//! The corpus of the fuzzer, every file as it is and in many mutations.
#![expect(clippy::print_stdout, reason = "the test prints what it ran")]

use std::path::{Path, PathBuf};

use fixtures::random::Random;
use targets::{TARGETS, Target};

/// Mutations per target, over all files: some seconds in all.
const MUTATIONS: usize = 10_000;

/// Maximum size of a mutated file.
const MAX_BYTES: usize = 8192;

#[test]
fn no_target_panics() {
    // Targets are independent: all threads of the machine work on this one test.
    std::thread::scope(|scope| {
        for (name, target) in TARGETS {
            scope.spawn(move || run_corpus(name, target));
        }
    });
}

/// Runs a target on every file of its corpus, and on mutations of them.
fn run_corpus(name: &str, target: Target) {
    let corpus = corpus(name);
    assert!(corpus.len() >= 2, "{name} has a corpus of {}", corpus.len());
    for bytes in &corpus {
        let _ = target(bytes);
    }
    let mut random = Random(0x5851_f42d_4c95_7f2d);
    for round in 0..MUTATIONS {
        let mut bytes = corpus[round % corpus.len()].clone();
        for _ in 0..=random.below(6) {
            mutate(&mut bytes, &corpus, &mut random);
        }
        run(name, target, &bytes, round);
    }
    println!("{name}: {} files, {MUTATIONS} mutations", corpus.len());
}

/// Without a valid input in its corpus, a target would be run on refused ones only.
#[test]
fn each_corpus_holds_valid_input() {
    for (name, target) in TARGETS {
        let valid = corpus(name).iter().filter(|bytes| target(bytes)).count();
        assert!(valid > 0, "{name}: no file of the corpus is valid");
    }
}

/// Runs a target, and prints the bytes if it panics.
fn run(name: &str, target: Target, bytes: &[u8], round: usize) {
    let result = std::panic::catch_unwind(|| target(bytes));
    assert!(
        result.is_ok(),
        "{name} panics in round {round} on {:?}",
        bytes.escape_ascii().to_string()
    );
}

fn corpus(name: &str) -> Vec<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../corpus").join(name);
    let entries = std::fs::read_dir(&folder).expect("a folder for each target");
    let mut paths: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    paths.sort();
    paths.iter().map(|path| std::fs::read(path).expect("a file of the corpus")).collect()
}

fn mutate(bytes: &mut Vec<u8>, corpus: &[Vec<u8>], random: &mut Random) {
    const AWKWARD: [&[u8]; 12] = [
        b"0",
        b"-1",
        b"1e999",
        b"nan",
        b"4294967296",
        b"99999999999999999999",
        b"\n",
        b"\0\0\0\0",
        b"\xff\xff\xff\xff",
        b"\0\0\xc0\x7f",
        b" ",
        b"\"",
    ];
    let at = random.below(bytes.len() + 1);
    let end = (at + random.below(9)).min(bytes.len());
    match random.below(6) {
        0 if at < bytes.len() => bytes[at] ^= 1 << random.below(8),
        1 if at < bytes.len() => bytes[at] = random.byte(),
        2 => drop(bytes.drain(at..end)),
        3 => bytes.truncate(at),
        4 => {
            let awkward = AWKWARD[random.below(AWKWARD.len())];
            bytes.splice(at..end, awkward.iter().copied());
        }
        _ => {
            let other = &corpus[random.below(corpus.len())];
            let from = random.below(other.len() + 1);
            let to = (from + random.below(64)).min(other.len());
            bytes.splice(at..end, other[from..to].iter().copied());
        }
    }
    bytes.truncate(MAX_BYTES);
}
