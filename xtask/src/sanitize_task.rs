//! The task `sanitize`: runs valgrind, Miri and the address sanitizer on all `unsafe` code: the SIMD lanes of `generated`, the QR
//! decomposition in registers of `numerics`, the tape (list of operations) of `expr`, and the functions with wide registers of
//! `logs` and `identification`.
//!
//! Miri and the address sanitizer need a nightly compiler; Miri also needs its component and `rust-src`. If a tool is missing,
//! a message says so, and the task does not fail.
//!
//! | tool | tests that it runs | not covered |
//! |---|---|---|
//! | valgrind | the kernels with the registers that valgrind supports: AVX2 with FMA, not AVX-512 | |
//! | address sanitizer | library tests of these packages and tests of the SIMD lanes, with all registers of the processor | |
//! | Miri | the kernels: without SIMD, with AVX2 and FMA, and with AVX-512 | robots with more than three coordinates (an hour) |
//!
//! Not tested here: the Python package, because its `unsafe` code needs an interpreter.

use std::process::Command;

use crate::cargo::{done, host, root, said, target};

/// The tests of functions with `unsafe` code (kernels): package, cargo option that selects the target, and a part of the test
/// names.
const KERNELS: [[&str; 3]; 6] = [
    ["expr", "--lib", "tape::tests"],
    ["numerics", "--lib", "reflection::tests"],
    ["processor", "--lib", "tests"],
    ["logs", "--lib", "packed::tests"],
    ["identification", "--lib", "butterworth::tests"],
    ["tests", "--test=model", "lanes::"],
];

/// The processor features with which Miri runs the kernels.
const PROCESSORS: [&str; 3] = ["", "-Ctarget-feature=+avx2,+fma", "-Ctarget-feature=+avx2,+fma,+avx512f"];

pub(crate) fn run(arguments: &[String]) -> Result<(), String> {
    if let Some(argument) = arguments.first() {
        return Err(format!("sanitize takes no argument; found `{argument}`"));
    }
    valgrind()?;
    let Some(nightly) = nightly() else {
        println!("SKIPPED: neither Miri nor the address sanitizer: rustup has no nightly toolchain");
        return Ok(());
    };
    miri(&nightly)?;
    address(&nightly)
}

fn valgrind() -> Result<(), String> {
    if said(Command::new("valgrind").arg("--version")).is_empty() {
        println!("SKIPPED: valgrind: it is not installed");
        return Ok(());
    }
    let runner = format!("CARGO_TARGET_{}_RUNNER", host()?.to_uppercase().replace('-', "_"));
    for [package, tests, name] in KERNELS {
        println!("== valgrind: {package} {tests} {name}");
        let mut test = Command::new("cargo");
        test.args(["test", "--quiet", "--locked", "--package", package, tests, "--", name]).current_dir(root());
        done(test.env(&runner, "valgrind --quiet --error-exitcode=9"), &format!("valgrind on {package}"))?;
    }
    Ok(())
}

fn miri(nightly: &str) -> Result<(), String> {
    let installed = said(Command::new("rustup").args(["component", "list", "--installed", "--toolchain", nightly]));
    let is_there = |component: &&str| installed.lines().any(|line| line.starts_with(*component));
    let missing: Vec<&str> = ["miri", "rust-src"].into_iter().filter(|c| !is_there(c)).collect();
    if !missing.is_empty() {
        let missing = missing.join(" ");
        println!("SKIPPED: Miri: the toolchain lacks {missing} (rustup component add --toolchain {nightly} {missing})");
        return Ok(());
    }
    for processor in PROCESSORS {
        for [package, tests, name] in KERNELS {
            println!("== Miri: {package} {tests} {name} {processor}");
            let mut test = Command::new("cargo");
            test.args([&format!("+{nightly}"), "miri", "test", "--locked", "--package", package, tests, "--", name]);
            test.current_dir(root()).env("RUSTFLAGS", processor).env("CARGO_TARGET_DIR", target().join("miri"));
            done(&mut test, &format!("Miri on {package}"))?;
        }
    }
    Ok(())
}

fn address(nightly: &str) -> Result<(), String> {
    let host = host()?;
    if host != "x86_64-unknown-linux-gnu" {
        println!("SKIPPED: the address sanitizer: the registers are of x86-64, and this is {host}");
        return Ok(());
    }
    for selected in [&["expr", "--lib"][..], &["numerics", "--lib"], &["tests", "--test=model", "--", "lanes::"]] {
        println!("== address sanitizer: {}", selected.join(" "));
        let mut test = Command::new("cargo");
        test.args([&format!("+{nightly}"), "test", "--quiet", "--locked", "--target", &host, "--package"]);
        test.args(selected).current_dir(root()).env("RUSTFLAGS", "-Zsanitizer=address");
        done(test.env("CARGO_TARGET_DIR", target().join("address")), &format!("address sanitizer: {}", selected[0]))?;
    }
    Ok(())
}

/// Name of a nightly toolchain of rustup; `None` if there is none.
fn nightly() -> Option<String> {
    let text = said(Command::new("rustup").args(["toolchain", "list"]));
    let names = text.lines().filter_map(|line| line.split_whitespace().next());
    names.filter(|name| name.starts_with("nightly")).max().map(str::to_string)
}
