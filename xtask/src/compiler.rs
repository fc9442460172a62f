//! The compiler as verification calls it: most test programs, and examples, which only have to
//! compile, are not optimized.
//!
//! Cargo has one setting per package, for its library as for its tests. The libraries are optimized,
//! since all tests run them. Of most test programs, though, compiling takes longer than running.

use std::path::Path;
use std::process::{Command, ExitCode};

/// Sources, by the beginning of their paths, of test programs that compute so much themselves that
/// they are optimized: reference implementations, and loops that are compiled where they are called.
const OPTIMIZED: [&str; 9] = [
    "crates/baselines/tests",
    "crates/ccd/tests",
    "crates/decimate/tests",
    "crates/distance-field",
    "crates/kdop/tests",
    "crates/medial/tests",
    "crates/picture",
    "crates/resolve/tests",
    "crates/surface/tests",
];

/// Makes cargo call the compiler through this program, with one unit per crate and without partial
/// results, which takes a third less of its time where nothing is built again.
pub(crate) fn set_compiler(command: &mut Command) {
    command.env("CARGO_INCREMENTAL", "0").env("CARGO_PROFILE_DEV_CODEGEN_UNITS", "1");
    if let Ok(program) = std::env::current_exe() {
        command.env("RUSTC_WORKSPACE_WRAPPER", program);
    }
}

/// Runs the compiler where cargo calls this program in its place; `None` for a task.
pub(crate) fn run(arguments: &[String]) -> Option<ExitCode> {
    let (compiler, arguments) = arguments.split_first()?;
    let is_compiler = Path::new(compiler).file_stem()? == "rustc";
    is_compiler.then(|| {
        let status = Command::new(compiler).args(changed(arguments)).status();
        let code = status.ok().and_then(|status| u8::try_from(status.code()?).ok());
        ExitCode::from(code.unwrap_or(1))
    })
}

/// Returns the arguments of the compiler, without optimization for an example or a test program that
/// is not among [`OPTIMIZED`].
fn changed(arguments: &[String]) -> Vec<&str> {
    let source = arguments.iter().find(|argument| argument.ends_with(".rs"));
    let source = source.map_or_else(String::new, |source| source.replace('\\', "/"));
    let is_test = arguments.iter().any(|argument| argument == "--test");
    let is_program = is_test || source.contains("/examples/");
    let is_optimized = OPTIMIZED.iter().any(|beginning| source.starts_with(beginning));

    let mut changed = Vec::new();
    for argument in arguments {
        let is_level = argument.starts_with("opt-level=");
        let is_changed = is_level && is_program && !is_optimized;
        changed.push(if is_changed { "opt-level=0" } else { argument });
    }
    changed
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the level at which the compiler is called for a source.
    fn level(source: &str, further: &[&str]) -> String {
        let arguments = [&["--crate-name", "it", source, "-C", "opt-level=1"], further].concat();
        let arguments: Vec<String> = arguments.into_iter().map(str::to_owned).collect();
        changed(&arguments)[4].to_owned()
    }

    #[test]
    fn test_programs_and_examples_alone_are_not_optimized() {
        assert_eq!(level("crates/resolve/src/lib.rs", &["--test"]), "opt-level=0");
        assert_eq!(level("crates/resolve/src/lib.rs", &[]), "opt-level=1");
        assert_eq!(level("crates/resolve/examples/one.rs", &[]), "opt-level=0");
        assert_eq!(level("crates/resolve/tests/it/main.rs", &["--test"]), "opt-level=1");
        assert_eq!(level("crates\\kdop\\tests\\it\\main.rs", &["--test"]), "opt-level=1");
        assert!(OPTIMIZED.iter().all(|source| crate::root().join(source).is_dir()));
    }

    #[test]
    fn tasks_are_not_compilers() {
        let run = |argument: &str| run(&[argument.to_owned(), "--version".to_owned()]).is_some();
        assert!(!run("verify") && !run("ratios"));
        assert!(run("rustc"));
    }
}
