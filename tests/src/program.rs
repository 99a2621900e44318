//! Builds the program `rist`, and runs it as a user does.
//!
//! A run is the output and the exit code of one call of the program.

use std::collections::BTreeSet;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::{Mutex, OnceLock, PoisonError};

use rist::{Estimate, ExcitingMotion};
use serde_json::Value;

/// A description of a robot with two links in a vertical plane. It has all limits that a motion can have.
pub const LIMITED_ARM: &str = "\
convention: khalil-kleinfinger
name: arm
gravity: [0, -9.81, 0]
symbols: {L1: 0.5}
links:
  - {link: 1, name: upper arm, antecedent: base, theta: q1, limits: {position: [-2, 2], velocity: 5, effort: 100}}
  - {link: 2, name: forearm, antecedent: 1, d: L1, theta: q2, limits: {position: [-2, 2], velocity: 5, effort: 50}}
standard_parameters:
  1: {XX: 0.02, XY: 0, XZ: 0, YY: 0.35, YZ: 0, ZZ: 0.35, MX: 1, MY: 0, MZ: 0, M: 4, IA: 0.1}
  2: {XX: 0.01, XY: 0, XZ: 0, YY: 0.09, YZ: 0, ZZ: 0.09, MX: 0.4, MY: 0, MZ: 0, M: 2, IA: 0.05}
";

#[derive(Default)]
pub struct Run {
    pub called: String,
    pub code: Option<i32>,
    pub out: String,
    pub err: String,
}

impl Run {
    /// Fails unless the program ended with the exit code `code`; otherwise returns the run.
    #[track_caller]
    pub fn ended(self, code: i32) -> Run {
        assert_eq!(self.code, Some(code), "{}: {}{}", self.called, self.out, self.err);
        self
    }

    /// Fails unless the program ended with the exit code `code`, and unless its output contains each of these texts.
    #[track_caller]
    pub fn told(self, code: i32, said: &[&str]) -> Run {
        said.iter().for_each(|text| assert!(self.out.contains(text), "{}: no `{text}` in {}", self.called, self.out));
        self.ended(code)
    }

    /// Fails unless the program ended with the exit code `code`, and unless its error output contains each of these texts.
    #[track_caller]
    pub fn failed(self, code: i32, said: &[&str]) -> Run {
        said.iter().for_each(|text| assert!(self.err.contains(text), "{}: no `{text}` in {}", self.called, self.err));
        self.ended(code)
    }
}

/// Runs `rist` with these arguments in `folder`. Lines of the output are not wrapped, so that tests can search for phrases.
pub fn rist(folder: &Path, arguments: &[&str]) -> Run {
    run(Command::new(program()).args(arguments).current_dir(folder).env("COLUMNS", "100000"))
}

/// Runs `rist` with arguments that are separated by blanks. Fails if the program fails.
#[track_caller]
pub fn rist_done(folder: &Path, arguments: &str) -> Run {
    rist(folder, &arguments.split_whitespace().collect::<Vec<_>>()).ended(0)
}

/// Runs `rist` with the line width that it uses in a pipe.
pub fn rist_in_pipe(folder: &Path, arguments: &[&str]) -> Run {
    run(Command::new(program()).args(arguments).current_dir(folder).env_remove("COLUMNS"))
}

pub fn run(command: &mut Command) -> Run {
    let Output { status, stdout, stderr } = command.output().unwrap_or_else(|e| panic!("{command:?}: {e}"));
    let text = |bytes| String::from_utf8(bytes).expect("rist prints UTF-8");
    Run { called: format!("{command:?}"), code: status.code(), out: text(stdout), err: text(stderr) }
}

/// Runs a compiler or another program in `folder`. Panics if the program fails.
#[track_caller]
pub fn done(folder: &Path, program: &str, options: &str) -> Run {
    let named = if program == "rustc" { std::env::var("RUSTC").ok() } else { None };
    let mut command = Command::new(named.as_deref().unwrap_or(program));
    run(command.args(options.split(' ')).current_dir(folder)).ended(0)
}

/// Whether there is a `python3` with these modules. If not, prints a message.
pub fn has_python(modules: &str) -> bool {
    let import = format!("import {modules}");
    let found = Command::new("python3").args(["-c", &import]).output().is_ok_and(|o| o.status.success());
    if !found {
        println!("skipped: no python3 with {modules}");
    }
    found
}

/// Runs a script in Node.js with this input, and returns the JSON that it prints. If Node.js is missing, prints a message and
/// returns `None`.
pub fn node(script: &str, input: &Value) -> Option<Value> {
    if !is_there("node") {
        println!("skipped: no node");
        return None;
    }
    let mut node = Command::new("node");
    let mut node = node.args(["-e", script]).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().ok()?;
    node.stdin.take()?.write_all(input.to_string().as_bytes()).unwrap_or_else(|e| panic!("{e}"));
    let out = node.wait_with_output().unwrap_or_else(|e| panic!("{e}"));
    assert!(out.status.success(), "{script}");
    Some(serde_json::from_slice(&out.stdout).unwrap_or_else(|e| panic!("{e}")))
}

pub fn is_there(program: &str) -> bool {
    Command::new(program).arg("--version").output().is_ok_and(|o| o.status.success())
}

pub fn motion(path: &Path) -> ExcitingMotion {
    let text = std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    ExcitingMotion::from_yaml("motion", &text).unwrap_or_else(|e| panic!("{e}"))
}

pub fn estimate(path: &Path) -> Estimate {
    let text = std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    Estimate::from_yaml("estimate", &text).unwrap_or_else(|e| panic!("{e}"))
}

/// A folder for temporary files with this name. It is emptied at its first use in a process; tests that run in parallel may share
/// it.
pub fn folder(name: &str) -> PathBuf {
    static MADE: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());
    let folder = target().join("tmp").join(format!("{name}-{}", std::process::id()));
    let mut made = MADE.lock().unwrap_or_else(PoisonError::into_inner);
    if !made.insert(folder.clone()) {
        return folder;
    }
    remove_abandoned(name);
    std::fs::remove_dir_all(&folder).ok();
    std::fs::create_dir_all(&folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    folder
}

/// Removes the folders with this name whose process has ended: up to 50 MB each. Does nothing on systems without /proc.
fn remove_abandoned(name: &str) {
    let processes = Path::new("/proc");
    let is_abandoned = |folder: &Path| {
        let last = folder.file_name().and_then(|last| last.to_str()).unwrap_or_default();
        let process = last.strip_prefix(name).and_then(|rest| rest.strip_prefix('-'));
        let process = process.filter(|process| process.bytes().all(|b| b.is_ascii_digit()));
        process.is_some_and(|process| processes.join("self").exists() && !processes.join(process).exists())
    };
    let folders = std::fs::read_dir(target().join("tmp")).into_iter().flatten().flatten().map(|entry| entry.path());
    folders.filter(|folder| is_abandoned(folder)).for_each(|folder| drop(std::fs::remove_dir_all(folder)));
}

/// The folder target/debug, or its equivalent. The test program is in its subfolder `deps`.
fn target() -> PathBuf {
    let here = std::env::current_exe().expect("a test has a path");
    here.ancestors().nth(2).expect("target/debug/deps/test").to_path_buf()
}

/// The program. It is built once per test file, because a package cannot refer to the binary of another package.
pub fn program() -> &'static Path {
    static PROGRAM: OnceLock<PathBuf> = OnceLock::new();
    PROGRAM.get_or_init(|| {
        let mut build = Command::new(std::env::var_os("CARGO").unwrap_or("cargo".into()));
        // The program is built with all optional readers, as the tests are. So common code is compiled only once.
        build
            .args(["build", "--quiet", "--package", "cli", "--bin", "rist", "--features", "all-readers"])
            .current_dir(crate::workspace());
        if !cfg!(debug_assertions) {
            build.arg("--release");
        }
        build.arg("--target-dir").arg(target().parent().expect("target/debug has a parent"));
        let made = build.output().expect("cargo can be started");
        assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
        target().join(format!("rist{}", std::env::consts::EXE_SUFFIX))
    })
}
