//! The task `bench`: measures run times on this machine. Each computed result is also compared with an independent recursion.
//!
//! It prints one table, writes it between the two marks of docs/benchmarks.md, and stores its numbers in records/COMMIT.csv. The
//! measured programs are in a bench of the package `tests`, because xtask must build without `generated`.
//!
//! `bench instructions` counts instructions instead of time. It needs valgrind and gungraun-runner.

use std::fmt::Write as _;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Instant;

use crate::cargo::{cargo, root, said, target};

/// The generated file of a robot with seven revolute joints. Its compilation is timed.
const FILE: &str = "generated/src/robots/panda.rs";

/// Number of compilations per measured time; the shortest time is used.
const COMPILATIONS: u32 = 3;

const PAGE: &str = "docs/benchmarks.md";
const BEGIN: &str = "<!-- written by cargo xtask bench -->\n";
const END: &str = "<!-- end of what cargo xtask bench writes -->\n";

const HEAD: &str = "| work | how | ns | times the first | held to |\n|---|---|---|---|---|\n";

pub(crate) fn run(arguments: &[String]) -> Result<(), String> {
    match arguments {
        [] => {}
        [word] if word == "instructions" => return instructions(),
        [other, ..] => return Err(format!("bench takes `instructions` or nothing; found `{other}`")),
    }
    let mut rows = rows_of_bench()?;
    for (what, is_called) in [("base_regressor for f64", true), ("generic, nothing instantiated", false)] {
        let seconds = compile(is_called)?;
        let _ = writeln!(rows, "| rustc -O, {FILE} | {what} | {:.0} | | compiles |", 1e9 * seconds);
    }
    let text = format!("{BEGIN}{}\n{HEAD}{rows}{END}", conditions());
    print!("{text}");
    write_page(&text)?;
    let record = root().join("records").join(format!("{}.csv", commit()));
    write(&record, &csv(&rows))
}

/// Runs the bench and returns the rows of the table that it prints.
fn rows_of_bench() -> Result<String, String> {
    let bench = ["bench", "--quiet", "--package", "tests", "--bench", "speed"];
    let cargo = std::env::var_os("CARGO").unwrap_or("cargo".into());
    let output = Command::new(cargo).args(bench).stderr(Stdio::inherit()).output();
    let output = output.map_err(|e| format!("cargo {}: {e}", bench.join(" ")))?;
    match output.status.success() {
        true => Ok(String::from_utf8_lossy(&output.stdout).into_owned()),
        false => Err(format!("cargo {} failed: {}", bench.join(" "), output.status)),
    }
}

/// A sentence that names the commit, the processor, the number of its cores, and the compiler.
fn conditions() -> String {
    let information = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = information.lines().find_map(|line| line.strip_prefix("model name")?.split_once(": ").map(|(_, m)| m));
    let compiler = said(Command::new("rustc").arg("-V"));
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    format!(
        "Commit {}, {}, {cores} cores, {}.\n",
        commit(),
        model.unwrap_or("a processor without a name").trim(),
        compiler.trim()
    )
}

/// The measured commit. `-changed` is appended if files differ from the commit.
fn commit() -> String {
    let git = |arguments: &[&str]| said(Command::new("git").args(arguments).current_dir(root()));
    // Changes in docs and records are ignored, because this task writes there and they do not affect the measured programs.
    let status = ["status", "--porcelain", "--untracked-files=no", "--", ".", ":!docs", ":!records"];
    let is_changed = !git(&status).trim().is_empty();
    let commit = git(&["rev-parse", "--short", "HEAD"]);
    let commit = if commit.trim().is_empty() { "no-commit" } else { commit.trim() };
    format!("{commit}{}", if is_changed { "-changed" } else { "" })
}

/// Writes the table between its two marks in the page.
fn write_page(text: &str) -> Result<(), String> {
    let page = root().join(PAGE);
    let old = std::fs::read_to_string(&page).map_err(|e| format!("{PAGE}: {e}"))?;
    let marked = old.split_once(BEGIN).and_then(|(before, rest)| Some((before, rest.split_once(END)?.1)));
    let (before, behind) = marked.ok_or_else(|| format!("{PAGE} lacks the marks {BEGIN}{END}"))?;
    write(&page, &format!("{before}{text}{behind}"))
}

fn write(path: &Path, text: &str) -> Result<(), String> {
    let failed = |e| format!("{}: {e}", path.display());
    path.parent().map_or(Ok(()), std::fs::create_dir_all).map_err(failed)?;
    std::fs::write(path, text).map_err(failed)
}

/// The rows of the table, converted to CSV.
fn csv(rows: &str) -> String {
    let mut text = "work,how,ns,times_the_first,held_to\n".to_string();
    for row in rows.lines().filter(|row| row.starts_with('|')) {
        let cells: Vec<String> = row.trim_matches('|').split('|').map(|cell| format!("\"{}\"", cell.trim())).collect();
        text += &(cells.join(",") + "\n");
    }
    text
}

/// Counts the instructions of the measured programs with callgrind.
fn instructions() -> Result<(), String> {
    for tool in ["valgrind", "gungraun-runner"] {
        if said(Command::new(tool).arg("--version")).is_empty() {
            println!("SKIPPED: there is no {tool}: `apt install valgrind`, `cargo install gungraun-runner`");
            return Ok(());
        }
    }
    cargo(&["bench", "--package", "tests", "--features", "instructions", "--bench", "instructions"])
}

/// The time that rustc needs for this file alone, s: the shortest of three. The function in the file is generic. `is_called`:
/// whether it is called for f64; otherwise the compiler generates no code for it.
fn compile(is_called: bool) -> Result<f64, String> {
    let folder = target().join("bench");
    std::fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let library = folder.join("panda.rs");
    let mut text = format!("#[path = {:?}]\npub mod robot;\n", root().join(FILE));
    if is_called {
        text += "pub fn call(q: &[f64; 7], dq: &[f64; 7], ddq: &[f64; 7], y: &mut [[f64; 43]; 7]) {
    robot::base_regressor(q, dq, ddq, y)
}\n";
    }
    std::fs::write(&library, text).map_err(|e| format!("{}: {e}", library.display()))?;
    let mut best = f64::INFINITY;
    for _ in 0..COMPILATIONS {
        let start = Instant::now();
        let status = Command::new("rustc")
            .args(["--edition", "2024", "--crate-type", "lib", "-O", "--out-dir"])
            .arg(&folder)
            .arg(&library)
            .stdout(Stdio::null())
            .status()
            .map_err(|e| format!("rustc: {e}"))?;
        if !status.success() {
            return Err(format!("rustc does not compile {FILE}; run `cargo xtask gen`"));
        }
        best = best.min(start.elapsed().as_secs_f64());
    }
    Ok(best)
}
