//! The task `python`: builds the Python package in a virtual environment below target/, and tests it there.
//!
//! If there is no python3 with venv, or if pip cannot install the needed packages, the task prints a message and succeeds,
//! because the project must also build and pass its tests without Python.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use crate::cargo::{cargo, done, root, target};
use crate::stubs_task;

/// The packages that are installed in the environment in addition to rist.
const PACKAGES: [&str; 3] = ["maturin>=1.9,<2", "numpy", "pytest"];

pub(crate) fn run(arguments: &[String]) -> Result<(), String> {
    stubs_task::run("stubs", &["--check".into()])?;
    let (root, target) = (root(), target());
    let environment = target.join("python");
    if let Err(why) = environment_in(&environment) {
        println!("SKIPPED: the package for Python was neither built nor tested: {why}");
        return Ok(());
    }

    // The Python tests compare the output of the package with the output of the program `rist`, byte by byte.
    cargo(&["build", "--quiet", "--package", "cli", "--features", "all-readers"])?;
    let at_root = |program: &str| {
        let mut command = Command::new(environment.join("bin").join(program));
        command.current_dir(root).env("VIRTUAL_ENV", &environment).env("CARGO_TARGET_DIR", &target);
        command
    };
    let mut build = at_root("maturin");
    build.args(["develop", "--quiet", "--locked", "--profile", "dev", "--features", "all-readers"]);
    done(&mut build, "maturin develop")?;
    let mut format = Command::new("cargo");
    format.args(["fmt", "--check", "--manifest-path", "crates/python/Cargo.toml"]).current_dir(root);
    done(&mut format, "cargo fmt --manifest-path crates/python/Cargo.toml")?;
    let mut tests = at_root("python");
    tests.args(["-m", "pytest", "-q", "-p", "no:cacheprovider"]).args(arguments);
    done(tests.env("RIST_PROGRAM", target.join("debug/rist")), "pytest")
}

/// Makes the virtual environment if there is none. Fails with the reason if it cannot be made.
fn environment_in(environment: &Path) -> Result<(), String> {
    let complete = environment.join("complete");
    if fs::read_to_string(&complete).is_ok_and(|text| text == PACKAGES.join(" ")) {
        return Ok(());
    }
    quiet(Command::new("python3").args(["-m", "venv"]).arg(environment), "python3 -m venv")?;
    let pip = environment.join("bin/python");
    quiet(Command::new(pip).args(["-m", "pip", "install", "--quiet"]).args(PACKAGES), "pip install")?;
    fs::write(&complete, PACKAGES.join(" ")).map_err(|e| format!("{}: {e}", complete.display()))
}

/// Runs a command without showing its output. If it fails, the last line of its output is the reason.
fn quiet(command: &mut Command, what: &str) -> Result<(), String> {
    let out = command.stdin(Stdio::null()).output().map_err(|e| format!("{what}: {e}"))?;
    let said = String::from_utf8_lossy(&out.stderr).trim().lines().last().unwrap_or("no reason is given").to_string();
    if out.status.success() { Ok(()) } else { Err(format!("{what}: {said}")) }
}
