//! The program `musculo-collide`.

use std::process::ExitCode;

fn main() -> ExitCode {
    cli::run()
}
