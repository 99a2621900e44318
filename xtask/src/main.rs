//! Tasks of this repository: `cargo xtask gen [--check] [MODEL..]`, `cargo xtask bench`, `cargo xtask pictures [--check]`,
//! `cargo xtask book [--check | --screenshots]`, `cargo xtask datasets DIR`, `cargo xtask stubs [--check]`,
//! `cargo xtask notices [--check]`, `cargo xtask python`, `cargo xtask fuzz SECONDS`, `cargo xtask sanitize`.

mod bench_task;
mod book_pages;
mod book_task;
mod cargo;
mod fuzz_task;
mod gen_task;
mod pictures;
mod pictures_task;
mod python_task;
mod sanitize_task;
mod stubs_task;

use std::process::ExitCode;

use cargo::cargo;

const USAGE: &str = "\
Tasks of this repository.

cargo xtask gen [MODEL..]           write generated/src/robots/ from models/ (all, without an argument)
cargo xtask gen --check [MODEL..]   compare instead of writing, and say what to run
cargo xtask bench                   time derivations, calls and the compilation of a generated file, each held
                                    against an independent recursion; writes docs/benchmarks.md and records/
cargo xtask bench instructions      count the instructions of calls (needs valgrind and gungraun-runner)
cargo xtask pictures [--check]      write (compare) docs/pictures/*.svg, each drawn from its own data
cargo xtask book                    the pages of docs/ as a book, with live pages of rist, in target/book; where mdbook is
                                    absent they are checked all the same. RIST names a program that is built already
cargo xtask book --check            check pages, links and order alone
cargo xtask book --screenshots      also take the pictures of the live pages by Chromium, into docs/pictures
cargo xtask datasets DIR            the scoreboard on the measured robots whose logs are in folders of DIR
cargo xtask stubs [--check]         write (compare) what Python and docs/files.md say of the fields of requests
cargo xtask notices [--check]       write (compare) THIRD_PARTY_NOTICES, the licences of the crates in a binary
cargo xtask python [PYTEST..]       build the package for Python in target/python and run its tests; skipped, and
                                    said, where python3, pip or the network is absent
cargo xtask fuzz SECONDS            build the targets of fuzz/ with coverage and run them for so long in all: every reader,
                                    what is derived of a robot, what is identified from a log
cargo xtask sanitize                valgrind, Miri and the address sanitizer on what is unsafe; skipped, and said, where
                                    valgrind or a nightly toolchain is absent

A MODEL is a path such as models/race.yaml.";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let outcome = match arguments.split_first() {
        Some((task, rest)) if task == "gen" => gen_task::run(rest),
        Some((task, rest)) if task == "bench" => bench_task::run(rest),
        Some((task, rest)) if task == "python" => python_task::run(rest),
        Some((task, rest)) if task == "stubs" || task == "notices" => stubs_task::run(task, rest),
        Some((task, rest)) if task == "pictures" => pictures_task::run(rest),
        Some((task, rest)) if task == "book" => book_task::run(rest),
        Some((task, rest)) if task == "fuzz" => fuzz_task::run(rest),
        Some((task, rest)) if task == "sanitize" => sanitize_task::run(rest),
        // The task runs in a separate program, because it needs the crate `generated`, and xtask must be built without it.
        Some((task, rest)) if task == "datasets" => {
            let words = ["run", "--quiet", "--release", "--package", "tests", "--bin", "datasets", "--"];
            cargo(&words.into_iter().chain(rest.iter().map(String::as_str)).collect::<Vec<_>>())
        }
        Some((task, _)) if task == "--help" || task == "-h" || task == "help" => {
            println!("{USAGE}");
            return ExitCode::SUCCESS;
        }
        Some((task, _)) => Err(format!("there is no task `{task}`\n\n{USAGE}")),
        None => Err(USAGE.to_string()),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("{message}");
            ExitCode::FAILURE
        }
    }
}
