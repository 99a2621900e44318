//! The program `rist`: reads the command line, calls the library, prints results.
//!
//! It is a library, so that the Python package can contain the program too: `bin/rist.rs` and the command `rist` of that
//! package call [`run_program`].

#![warn(missing_docs)]

mod artefact;
#[cfg(feature = "calibration")]
mod calibration;
mod check;
mod columns;
mod convert;
mod doctor;
mod evaluate;
mod example;
mod excite;
mod failure;
mod flags;
#[cfg(feature = "fleet")]
mod fleet;
#[cfg(feature = "formulas")]
mod formulas;
mod generate;
mod groups;
mod help;
mod identify;
mod inspect;
#[cfg(feature = "inspection")]
mod inspection;
mod interrupt;
mod lint;
mod model;
#[cfg(feature = "packages")]
mod packages;
mod plan;
mod play;
mod replay;
mod report;
mod schema;
mod shell;
mod simulate;
#[cfg(feature = "statics")]
mod statics;
mod terminal;
mod validate;
mod verdict;
pub mod wings;

use std::ffi::OsString;
use std::io::{self, Write};

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use failure::{Failure, UNUSABLE};
use terminal::TerminalArguments;

/// From a robot description to an exact symbolic model, generated code, and inertial parameters
/// identified from logs of the robot.
#[derive(Parser)]
#[command(name = "rist", version, max_term_width = help::COLUMNS)]
struct Arguments {
    #[command(subcommand)]
    command: Command,

    #[command(flatten)]
    terminal: TerminalArguments,
}

#[derive(Subcommand)]
enum Command {
    Example(example::Arguments),
    Inspect(inspect::Arguments),
    Lint(lint::Arguments),
    Convert(convert::Arguments),
    Excite(excite::Arguments),
    Check(check::Arguments),
    Play(play::Arguments),
    #[cfg(feature = "inspection")]
    Visibility(inspection::visibility::Arguments),
    Plan(plan::Arguments),
    Simulate(simulate::Arguments),
    Columns(columns::Arguments),
    #[cfg(feature = "statics")]
    Postures(statics::postures::Arguments),
    #[cfg(feature = "statics")]
    Wrench(statics::wrench::Arguments),
    #[cfg(feature = "calibration")]
    Calibrate(calibration::calibrate::Arguments),
    Doctor(doctor::Arguments),
    Identify(Box<identify::Arguments>),
    Validate(validate::Arguments),
    Replay(replay::Arguments),
    Report(report::Arguments),
    #[cfg(feature = "fleet")]
    Accumulate(Box<fleet::accumulate::Arguments>),
    #[cfg(feature = "fleet")]
    Merge(fleet::merge::Arguments),
    #[cfg(feature = "fleet")]
    Solve(fleet::solve::Arguments),
    #[cfg(feature = "fleet")]
    Compare(fleet::compare::Arguments),
    Generate(generate::Arguments),
    #[cfg(feature = "formulas")]
    Derive(formulas::derive::Arguments),
    Evaluate(evaluate::Arguments),
    Schema(schema::Arguments),
    Completions(shell::CompletionArguments),
    Man(shell::ManualArguments),
    /// Print the licences of the crates that this program contains
    Notices,
}

impl Command {
    /// Text that says what a command writes instead of JSON; `None` for a command with a JSON result.
    fn other_than_json(&self) -> Option<&'static str> {
        match self {
            Command::Convert(_) => Some("convert writes a description, or CSV"),
            Command::Evaluate(_) => Some("evaluate writes CSV"),
            Command::Generate(_) => Some("generate writes source"),
            #[cfg(feature = "formulas")]
            Command::Derive(_) => Some("derive writes formulas"),
            Command::Report(_) => Some("report writes a page"),
            Command::Completions(_) => Some("completions are for a shell"),
            Command::Man(_) => Some("man writes pages of the manual"),
            Command::Example(_) => Some("example writes files"),
            Command::Notices => Some("notices prints licences"),
            _ => None,
        }
    }
}

/// Size of a memory block, bytes: the largest block that raises the mmap threshold of glibc when it is freed. This size is 32
/// MiB minus a reserve for the header of the block.
const LARGEST_KEPT_BYTES: usize = (32 << 20) - (64 << 10);

/// Makes the allocator keep freed memory for reuse. The mmap threshold of glibc rises to the largest block that was freed
/// (mallopt(3), `M_MMAP_THRESHOLD`). Otherwise the system would clear sixty thousand pages again for a long log.
fn keep_freed_memory() {
    drop(std::hint::black_box(Vec::<u8>::with_capacity(LARGEST_KEPT_BYTES)));
}

/// The command-line program with its arranged help.
fn program() -> clap::Command {
    help::arranged(Arguments::command())
}

/// Runs the program with the words of a command line, of which the first is the program's name. Returns the exit code: 0 for
/// success, 1 if the answer is no, 2 for unusable input. Call this function only once per process, because the terminal
/// settings stay.
pub fn run_program(words: Vec<OsString>) -> u8 {
    keep_freed_memory();
    wings::register();
    let matches = program().try_get_matches_from(&words);
    let code = match matches.and_then(|matches| Arguments::from_arg_matches(&matches)) {
        Ok(arguments) => run_command(arguments, &words),
        Err(e) if let Some(missing) = wings::of_absent(&words).filter(|_| e.use_stderr()) => {
            eprintln!("rist: {missing}");
            UNUSABLE
        }
        Err(e) => {
            // Help and version texts of clap are printed here too. If printing fails, the failure cannot be reported.
            let _ = e.print();
            if e.use_stderr() { UNUSABLE } else { 0 }
        }
    };
    // Flush standard output here, because the Python package does not flush it.
    let _ = io::stdout().flush();
    code
}

/// Runs a command with the settings of the terminal, and returns its exit code.
fn run_command(Arguments { command, terminal }: Arguments, words: &[OsString]) -> u8 {
    report::set_command(words);
    terminal::set(terminal);
    let outcome = match command.other_than_json() {
        Some(text) if terminal.json => Err(Failure::new(format_args!("--json: rist {text}; leave the flag out"))),
        _ => run(command),
    };
    terminal::rest();
    match outcome {
        Ok(()) => 0,
        Err(failure) => {
            terminal::complain(&failure.text());
            failure.exit_code()
        }
    }
}

/// Runs a command. Commands of a wing exist only if this build contains the wing.
fn run(command: Command) -> Result<(), Failure> {
    // Each command except the last three calls the function `run` of the module with the name of the command. The commands of a
    // wing are in the module of the wing.
    match command {
        Command::Inspect(arguments) => inspect::run(&arguments),
        Command::Convert(arguments) => convert::run(&arguments),
        Command::Lint(arguments) => lint::run(&arguments),
        Command::Evaluate(arguments) => evaluate::run(&arguments),
        Command::Generate(arguments) => generate::run(&arguments),
        #[cfg(feature = "formulas")]
        Command::Derive(arguments) => formulas::derive::run(&arguments),
        Command::Plan(arguments) => plan::run(&arguments),
        Command::Excite(arguments) => excite::run(&arguments),
        Command::Check(arguments) => check::run(&arguments),
        Command::Play(arguments) => play::run(&arguments),
        #[cfg(feature = "inspection")]
        Command::Visibility(arguments) => inspection::visibility::run(&arguments),
        Command::Simulate(arguments) => simulate::run(&arguments),
        Command::Columns(arguments) => columns::run(&arguments),
        #[cfg(feature = "statics")]
        Command::Postures(arguments) => statics::postures::run(&arguments),
        #[cfg(feature = "statics")]
        Command::Wrench(arguments) => statics::wrench::run(&arguments),
        #[cfg(feature = "calibration")]
        Command::Calibrate(arguments) => calibration::calibrate::run(&arguments),
        Command::Doctor(arguments) => doctor::run(&arguments),
        Command::Identify(arguments) => identify::run(&arguments),
        Command::Validate(arguments) => validate::run(&arguments),
        Command::Replay(arguments) => replay::run(&arguments),
        Command::Report(arguments) => report::run(&arguments),
        #[cfg(feature = "fleet")]
        Command::Accumulate(arguments) => fleet::accumulate::run(&arguments),
        #[cfg(feature = "fleet")]
        Command::Merge(arguments) => fleet::merge::run(&arguments),
        #[cfg(feature = "fleet")]
        Command::Solve(arguments) => fleet::solve::run(&arguments),
        #[cfg(feature = "fleet")]
        Command::Compare(arguments) => fleet::compare::run(&arguments),
        Command::Example(arguments) => example::run(&arguments),
        Command::Schema(arguments) => schema::run(&arguments),
        Command::Completions(arguments) => shell::completions(&arguments, program()),
        Command::Man(arguments) => shell::manual(&arguments, program()),
        Command::Notices => terminal::print(include_str!("../../../THIRD_PARTY_NOTICES")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_flag_says_what_it_does() {
        let mut program = Arguments::command();
        program.build();
        let commands: Vec<_> = program.get_subcommands().filter(|c| c.get_name() != "help").collect();
        assert!(commands.len() > 15, "{} commands", commands.len());
        for command in commands {
            for argument in command.get_arguments() {
                let help = argument.get_long_help().or(argument.get_help());
                assert!(help.is_some(), "rist {} {}: no help", command.get_name(), argument.get_id());
            }
        }
    }
}
