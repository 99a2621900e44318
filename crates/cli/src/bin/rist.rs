//! Entry point of the program `rist`.

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(cli::run_program(std::env::args_os().collect()))
}
