//! Test programs, each run as soon as it is built.
//!
//! `cargo test` runs nothing until all is built, and then one program at a time: a core waits while
//! the last crates of a chain compile, and again at the end of each program.

use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;

use crate::figures::field;
use crate::process::read_lines;
use crate::test_output::TestOutput;

/// Programs that run at a time: while the last test of one keeps a core, another has the rest.
const RUNNERS: usize = 2;

/// Program with the tests of a target.
struct Program {
    package: String,
    /// Name of the target; `lib` for unit tests.
    target: String,
    executable: PathBuf,
    /// Folder of its package, in which cargo runs it.
    folder: PathBuf,
    /// True if its tests may run a program of its package, which cargo may finish after them.
    needs_program: bool,
}

impl Program {
    /// Reads a message of cargo; `None` unless it says that a test program is built.
    fn read(message: &str) -> Option<Self> {
        let (_, profile) = message.split_once("\"profile\":{")?;
        profile.split('}').next()?.contains("\"test\":true").then_some(())?;
        let path = |name: &str| Some(PathBuf::from(field(message, name)?.replace("\\\\", "\\")));

        // Packages have the names of their folders.
        let folder = path("manifest_path")?.parent()?.to_owned();
        let package = folder.file_name()?.to_str()?.to_owned();
        let executable = path("executable").filter(|path| path.is_absolute())?;
        let source = path("src_path")?;
        let is_unit = source.parent()?.ends_with("src");
        let target = if is_unit { "lib" } else { field(message, "name")? }.to_owned();
        let needs_program = !is_unit && folder.join("src/main.rs").is_file();
        Some(Self { package, target, executable, folder, needs_program })
    }

    /// Runs all tests, or those that `arguments` choose; returns what they printed, and whether
    /// the program ended well.
    fn run(&self, root: &Path, arguments: &[&str]) -> (String, bool) {
        // What cargo sets for a program that it runs. Golden files are only compared.
        let mut command = Command::new(&self.executable);
        command
            .arg("--show-output")
            .args(arguments)
            .current_dir(&self.folder)
            .env("CARGO_MANIFEST_DIR", &self.folder)
            .env("INSTA_WORKSPACE_ROOT", root)
            .env("INSTA_UPDATE", "no")
            .env_remove("INSTA_FORCE_PASS");

        let mut text = format!("\n     Running {} of {}\n", self.target, self.package);
        let ended = read_lines(&mut command, |line| {
            text.push_str(line);
            text.push('\n');
        });
        if let Err(error) = &ended {
            text.push_str(error);
        }
        (text, ended.is_ok_and(|status| status.success()))
    }
}

/// Programs that wait for a runner.
#[derive(Default)]
struct Waiting {
    programs: VecDeque<Program>,
    is_complete: bool,
}

/// Queue between the build and the runners.
#[derive(Default)]
struct Queue {
    waiting: Mutex<Waiting>,
    changed: Condvar,
}

impl Queue {
    fn lock(&self) -> MutexGuard<'_, Waiting> {
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn add(&self, program: Program) {
        self.lock().programs.push_back(program);
        self.changed.notify_all();
    }

    /// Adds a program that takes long: shorter ones then fill up what it leaves.
    fn add_first(&self, program: Program) {
        self.lock().programs.push_front(program);
        self.changed.notify_all();
    }

    /// Ends the queue: runners that find it empty return.
    fn complete(&self) {
        self.lock().is_complete = true;
        self.changed.notify_all();
    }

    /// Returns the next program, for which it waits; `None` once there are no more.
    fn next(&self) -> Option<Program> {
        let is_to_come =
            |waiting: &mut Waiting| waiting.programs.is_empty() && !waiting.is_complete;
        let waiting = self.changed.wait_while(self.lock(), is_to_come);
        waiting.unwrap_or_else(PoisonError::into_inner).programs.pop_front()
    }
}

/// Builds with `build`, and runs each test program that comes out of it; calls `meanwhile` once
/// all are built, while they run. Prints and returns the output, and whether all ended well.
///
/// # Errors
///
/// When cargo cannot be run.
pub(crate) fn build_and_run(
    root: &Path,
    build: &mut Command,
    arguments: &[&str],
    meanwhile: impl FnOnce(&Mutex<TestOutput>) -> Result<bool, String>,
) -> Result<(TestOutput, bool), String> {
    let queue = Queue::default();
    let output = Mutex::new(TestOutput::default());
    let run_all = || {
        let mut ended_well = true;
        while let Some(program) = queue.next() {
            let (text, passed) = program.run(root, arguments);
            ended_well &= passed;
            let mut output = output.lock().unwrap_or_else(PoisonError::into_inner);
            output.begin(&program.package);
            for line in text.lines() {
                println!("{line}");
                output.read(line);
            }
        }
        ended_well
    };

    let ended_well = thread::scope(|scope| {
        let runners: Vec<_> = (0..RUNNERS).map(|_| scope.spawn(run_all)).collect();

        // Messages of the compiler are for reading, those of cargo for the queue.
        let mut held = Vec::new();
        build.arg("--no-run").arg("--message-format=json-render-diagnostics");
        build.current_dir(root).stdin(Stdio::null());
        let built = read_lines(build, |line| match Program::read(line) {
            Some(program) if program.needs_program => held.push(program),
            Some(program) => queue.add(program),
            None if line.starts_with('{') => (),
            None => println!("{line}"),
        });
        for program in held {
            queue.add_first(program);
        }
        let is_built = built.map(|status| status.success());
        let rest = is_built.and_then(|is_built| Ok(meanwhile(&output)? && is_built));

        queue.complete();
        let mut ended_well = rest?;
        for runner in runners {
            ended_well &= runner.join().unwrap_or(false);
        }
        Ok::<bool, String>(ended_well)
    })?;
    Ok((output.into_inner().unwrap_or_else(PoisonError::into_inner), ended_well))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a message of cargo about a target of the package `kdop`.
    fn message(source: &str, is_test: bool, executable: &str) -> String {
        format!(
            r#"{{"reason":"compiler-artifact","manifest_path":"/a/crates/kdop/Cargo.toml","target":{{"kind":["lib"],"name":"it","src_path":"/a/crates/kdop/{source}","doctest":true,"test":true}},"profile":{{"opt_level":"1","test":{is_test}}},"filenames":[],"executable":{executable},"fresh":false}}"#
        )
    }

    #[test]
    fn test_programs_are_found_among_messages() {
        let unit = Program::read(&message("src/lib.rs", true, "\"/t/kdop-1\"")).unwrap();
        assert_eq!((unit.package.as_str(), unit.target.as_str()), ("kdop", "lib"));
        assert_eq!(unit.executable, Path::new("/t/kdop-1"));
        assert_eq!(unit.folder, Path::new("/a/crates/kdop"));
        let it = Program::read(&message("tests/it/main.rs", true, "\"/t/it-1\"")).unwrap();
        assert_eq!(it.target, "it");

        // A library, a program without tests, and other messages.
        assert!(Program::read(&message("src/lib.rs", false, "null")).is_none());
        assert!(Program::read(&message("src/lib.rs", true, "null")).is_none());
        assert!(Program::read(&message("src/main.rs", false, "\"/t/kdop\"")).is_none());
        assert!(Program::read(r#"{"reason":"build-finished","success":true}"#).is_none());
        assert!(Program::read("   Compiling kdop v0.1.0").is_none());
    }

    #[cfg(unix)]
    #[test]
    fn tests_wait_for_the_program_of_their_package() {
        use std::fs;
        use std::os::unix::fs::PermissionsExt;

        // A build that has the test before the program, and a test that looks for the program.
        let folder = std::env::temp_dir().join(format!("xtask-{}", std::process::id()));
        let test = folder.join("crates/kdop/it");
        fs::create_dir_all(folder.join("crates/kdop/src")).unwrap();
        fs::write(folder.join("crates/kdop/src/main.rs"), "").unwrap();
        fs::write(&test, "#!/bin/sh\ntest -e program\n").unwrap();
        fs::set_permissions(&test, fs::Permissions::from_mode(0o755)).unwrap();
        let executable = format!("\"{}\"", test.display());
        let message = message("tests/it/main.rs", true, &executable);
        let message = message.replace("\"/a/", &format!("\"{}/", folder.display()));
        let script = format!("echo '{message}'; sleep 0.3; touch crates/kdop/program");

        let mut build = Command::new("sh");
        let ended = build_and_run(&folder, build.args(["-c", &script]), &[], |_| Ok(true));
        fs::remove_dir_all(&folder).unwrap();
        assert!(ended.unwrap().1);
    }

    #[test]
    fn a_complete_queue_gives_out_what_it_holds() {
        let queue = Queue::default();
        let found = thread::scope(|scope| {
            let runner = scope.spawn(|| std::iter::from_fn(|| queue.next()).count());
            for _ in 0..3 {
                let program = Program::read(&message("src/lib.rs", true, "\"/t/kdop-1\""));
                queue.add(program.unwrap());
            }
            queue.complete();
            runner.join().unwrap()
        });
        assert_eq!(found, 3);
    }

    #[test]
    fn a_program_that_fails_says_so() {
        let program = Program {
            package: "kdop".to_owned(),
            target: "lib".to_owned(),
            executable: PathBuf::from("false"),
            folder: std::env::temp_dir(),
            needs_program: false,
        };
        assert!(!program.run(Path::new("."), &[]).1);
        let missing = Program { executable: PathBuf::from("/no/such/program"), ..program };
        let (text, passed) = missing.run(Path::new("."), &[]);
        assert!(!passed && text.contains("cannot be run"), "{text}");
    }
}
