//! Standard output and standard error.
//!
//! Text of files can stand in every report and message. Its control characters are
//! escaped here, so that none of it can send commands to the terminal.

use std::io::{self, Write};

use crate::failure::Failure;

/// Prints a report on standard output.
///
/// # Errors
///
/// Those of writing, but not a closed pipe.
pub(crate) fn print_report(text: &str) -> Result<(), Failure> {
    let written = write_standard_output(escaped_lines(text).as_bytes());
    written.map_err(|error| Failure::in_standard_output(&error))
}

/// Prints a line on standard error.
pub(crate) fn print_line(kind: &str, text: &str) {
    // Without standard error there is no place to report to.
    let _ = writeln!(io::stderr(), "{kind}: {}", escaped_lines(text));
}

/// Writes bytes to standard output as they are. A reader that closes the pipe needs no
/// more of them.
pub(crate) fn write_standard_output(bytes: &[u8]) -> io::Result<()> {
    let mut output = io::stdout().lock();
    unless_closed(output.write_all(bytes).and_then(|()| output.flush()))
}

/// Returns the result of writing, in which a closed pipe is no error.
pub(crate) fn unless_closed(result: io::Result<()>) -> io::Result<()> {
    match result {
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        result => result,
    }
}

/// Returns a text with its control characters escaped, but for the ends of lines.
fn escaped_lines(text: &str) -> String {
    let lines: Vec<String> = text.split('\n').map(mesh_io::escaped).collect();
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_stay_and_controls_are_escaped() {
        assert_eq!(escaped_lines("a × b\n1 µm\n"), "a × b\n1 µm\n");
        assert_eq!(escaped_lines("\x1b[2J\r\u{9b}\u{202e}"), r"\u{1b}[2J\r\u{9b}\u{202e}");
    }
}
