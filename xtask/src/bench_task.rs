//! `bench`: how long things take on this machine, as the tables of docs/benchmarks.md.
//!
//! The programs measured are benches of the package `tests`: xtask must build without `generated`.

use std::process::{Command, Stdio};
use std::time::Instant;

use crate::cargo::{cargo, root, target};

/// A generated 7R file.
const FILE: &str = "generated/src/robots/panda.rs";

pub fn run(arguments: &[String]) -> Result<(), String> {
    if let Some(argument) = arguments.first() {
        return Err(format!("bench takes no argument; found `{argument}`"));
    }
    cargo(&["bench", "--quiet", "--package", "tests", "--bench", "speed"])?;
    println!("\n| rustc -O, {FILE} | s |\n|---|---|");
    for (what, instantiated) in [("base_regressor for f64", true), ("generic, nothing instantiated", false)] {
        println!("| {what} | {:.2} |", compile(instantiated)?);
    }
    Ok(())
}

/// Seconds that rustc takes for the file alone, the best of three; with a caller for f64 or without.
fn compile(instantiated: bool) -> Result<f64, String> {
    let folder = target().join("bench");
    std::fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let library = folder.join("panda.rs");
    let mut text = format!("#[path = {:?}]\npub mod robot;\n", root().join(FILE));
    if instantiated {
        text += "pub fn call(q: &[f64; 7], dq: &[f64; 7], ddq: &[f64; 7], y: &mut [[f64; 43]; 7]) {
    robot::base_regressor(q, dq, ddq, y)
}\n";
    }
    std::fs::write(&library, text).map_err(|e| format!("{}: {e}", library.display()))?;
    let mut best = f64::INFINITY;
    for _ in 0..3 {
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
