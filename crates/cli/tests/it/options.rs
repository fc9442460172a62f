//! Options that only have a meaning beside others.

use crate::motion::needle_through_plate;

/// An option without effect is refused, also where what it belongs to is excluded by a third one.
#[test]
fn options_without_effect_are_refused() {
    let workshop = needle_through_plate();
    let before = workshop.listing();
    let motion = |options: &str| format!("motion scene.toml {options}");
    let range = |options: &str| {
        let turn = "--turn needle --axis 0,0,1 --center 0,0,0 --to 9";
        format!("range plate.obj needle.obj {turn} {options}")
    };
    let mut cases = Vec::new();
    for other in [
        "--chart m.svg",
        "--joint-contact 1",
        "--vtp o",
        "--report m.html",
        "--table m.csv",
        "--cache m.frames",
        "--until-contact",
    ] {
        for option in ["--gap 1", "--smooth 1", "--tolerance 1", "--max-strain 1", "--rounds 3"] {
            cases.push((motion(&format!("{other} {option}")), option));
        }
    }
    for other in ["--until-contact", "--resolve o"] {
        for option in [
            "--joint-resolution 1",
            "--foundation 5,0.4,1",
            "--foundation-law linear",
            "--subject x",
        ] {
            cases.push((motion(&format!("{other} {option}")), option));
        }
    }
    for option in ["--map m.svg", "--table m.csv", "--cache m.cells"] {
        cases.push((range(&format!("--json r.json {option}")), option));
    }

    for (line, option) in &cases {
        let words: Vec<&str> = line.split_whitespace().collect();
        let run = workshop.run(words[0], &words[1..]);
        let name = option.split_whitespace().next().expect("a name");
        assert_eq!((run.status, run.stdout.as_str()), (2, ""), "{line}");
        assert!(run.stderr.contains(name), "{line}: {}", run.stderr);
        assert_eq!(workshop.listing(), before, "{line}");
    }

    // Each has its effect where it belongs.
    let run = workshop.run("motion", &["scene.toml", "--resolve", "o", "--gap", "0.1"]);
    assert!(run.status < 2, "{}", run.stderr);
}
