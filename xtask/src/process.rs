//! Child processes: cargo, and the programs it built.

use std::io::{BufRead, BufReader, pipe};
use std::path::Path;
use std::process::{Command, ExitStatus};

use crate::TaskResult;

/// Runs cargo in `root`, with its output passed on.
pub(crate) fn cargo(root: &Path, args: &[&str]) -> TaskResult {
    let status = Command::new("cargo").args(args).current_dir(root).status();
    match status {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(format!("cargo {} ended with {status}", args.join(" "))),
        Err(error) => Err(format!("cargo cannot be run: {error}")),
    }
}

/// Runs a command, and passes each line that it prints to `line` as it comes, both streams in the
/// order of their writing.
pub(crate) fn read_lines(
    command: &mut Command,
    mut line: impl FnMut(&str),
) -> Result<ExitStatus, String> {
    let name = command.get_program().display().to_string();
    let failed = |error: std::io::Error| format!("{name} cannot be run: {error}");

    // Both streams write into one pipe.
    let (reader, writer) = pipe().map_err(failed)?;
    let both = writer.try_clone().map_err(failed)?;
    let mut child = command.stdout(writer).stderr(both).spawn().map_err(failed)?;

    // The command holds the pipe's other ends until it is given new ones.
    command.stdout(std::process::Stdio::null()).stderr(std::process::Stdio::null());

    for bytes in BufReader::new(reader).split(b'\n') {
        line(String::from_utf8_lossy(&bytes.map_err(failed)?).trim_end_matches('\r'));
    }
    child.wait().map_err(failed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_streams_come_in_order() {
        let mut lines = Vec::new();
        let script = "echo one; echo two >&2; echo three; exit 3";
        let status =
            read_lines(Command::new("sh").args(["-c", script]), |line| lines.push(line.to_owned()));
        assert_eq!(lines, ["one", "two", "three"]);
        assert_eq!(status.unwrap().code(), Some(3));
    }
}
