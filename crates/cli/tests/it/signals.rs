//! Interruptions: nothing unfinished is left behind, and nothing keeps the program waiting.

use std::fs;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use crate::files::{changes, content, finish, make_pipe, motion, start, workshop};
use crate::support::Workshop;

/// Sends a signal to a process.
fn signal(child: &Child, name: &str) {
    let sent = Command::new("kill").args(["-s", name, &child.id().to_string()]).status();
    assert!(sent.expect("kill runs").success(), "SIG{name} is sent");
}

/// Returns the signals that interrupt the program. Jobs in the background of a script ignore SIGINT,
/// those of `nohup` SIGHUP, and their children inherit that.
fn interruptions() -> &'static [&'static str] {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = ignored.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    let ignores_one = mask.is_some_and(|mask| mask & 0b11 != 0);
    if ignores_one { &["TERM"] } else { &["INT", "TERM"] }
}

/// Interrupted while it writes its outputs one by one: with more frames than it can resolve
/// in the time of the test, some are written beside their places.
#[test]
fn an_interruption_leaves_nothing_behind() {
    for name in interruptions() {
        let workshop = workshop();
        workshop.write("walk.json", motion(20_000));
        let before = content(&workshop.path(""));
        let arguments = ["motion", "scene.toml", "--resolve", "new/apart", "--json", "o.json"];
        let child = start(&workshop, &arguments, Stdio::piped());
        let apart = workshop.path("new/apart");
        while !fs::read_dir(&apart).is_ok_and(|mut entries| entries.next().is_some()) {
            std::thread::sleep(Duration::from_millis(5));
        }
        signal(&child, name);
        let run = finish(child);
        assert_eq!((run.status, run.stdout, run.stderr), (130, String::new(), String::new()));
        assert_eq!(changes(&before, &content(&workshop.path(""))), "nothing changed");
    }
}

/// Signals a program that waits for a pipe to which nobody writes, and expects its end.
fn end_waiting(name: &str, start: impl Fn(&Workshop) -> Child) {
    let workshop = workshop();
    if !make_pipe(&workshop, "pipe.obj") {
        return;
    }
    let child = start(&workshop);
    std::thread::sleep(Duration::from_millis(300));
    signal(&child, name);
    assert_eq!(finish(child).status, 130, "SIG{name}");
}

#[test]
fn an_interruption_ends_waiting() {
    for name in interruptions() {
        end_waiting(name, |place| start(place, &["check", "a.obj", "pipe.obj"], Stdio::piped()));
    }
}

/// As `nohup` and jobs in the background of a script do. Where an ignored one is inherited already,
/// another shell cannot undo it.
#[test]
fn interruptions_are_handled_where_another_signal_is_ignored() {
    for (ignored, sent) in [("HUP", "TERM"), ("INT", "TERM"), ("INT", "HUP"), ("HUP", "INT")] {
        if sent == "TERM" || (interruptions().contains(&"INT") && cfg!(target_os = "linux")) {
            end_ignoring(ignored, sent);
        }
    }
}

/// Signals a program that waits and ignores another signal.
fn end_ignoring(ignored: &str, sent: &str) {
    let script = format!("trap '' {ignored}; exec \"$0\" check a.obj pipe.obj");
    end_waiting(sent, |place| shell(place, &script));
}

/// Starts a script whose `$0` is the program.
fn shell(place: &Workshop, script: &str) -> Child {
    let mut shell = Command::new("sh");
    shell.args(["-c", script, env!("CARGO_BIN_EXE_musculo-collide")]);
    shell.current_dir(place.path("")).stdout(Stdio::piped()).stderr(Stdio::piped());
    shell.spawn().expect("a shell")
}

/// Files have more than a block of 512 bytes; what is written until the limit is removed.
#[test]
fn a_limit_of_file_size_leaves_nothing_behind() {
    let workshop = workshop();
    let before = content(&workshop.path(""));
    let script = "ulimit -f 1; exec \"$0\" check a.obj b.obj --vtp new --picture o.png";
    let run = finish(shell(&workshop, script));
    assert_eq!((run.status, run.stdout), (3, String::new()), "{}", run.stderr);
    assert!(run.stderr.contains(": cannot be written: File too large"), "{}", run.stderr);
    assert_eq!(changes(&before, &content(&workshop.path(""))), "nothing changed");
}
