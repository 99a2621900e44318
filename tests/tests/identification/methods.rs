//! Tests of `rist identify --method`: what each method finds, and that each method uses or refuses every flag.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use identification::estimate::identified::Status;
use linear_model::parameter::ParameterId;
use tests::program::{LIMITED_ARM, estimate, folder, rist, rist_done};

/// A model of two links in a vertical plane. Link 2 is a thin rod along x, so MY2 is zero.
fn arm() -> String {
    LIMITED_ARM.replace("effort: 100}", "acceleration: 30}").replace("effort: 50}", "acceleration: 30}")
}

fn run(here: &Path, arguments: &str) -> String {
    rist_done(here, arguments).out
}

/// Creates a folder with arm.yaml, plan.yaml and the simulated logs in logs/.
fn experiments(name: &str) -> PathBuf {
    let here = folder(name);
    std::fs::write(here.join("arm.yaml"), arm()).unwrap();
    run(&here, "plan arm.yaml --starts 2 --experiments 5 --out plan.yaml");
    run(&here, "simulate arm.yaml plan.yaml --validation 2 --out logs");
    here
}

/// True values of base parameters of the arm.
const TRUTH: [(&str, f64); 7] =
    [("ZZR1", 0.95), ("MXR1", 2.0), ("MY1", 0.0), ("ZZ2", 0.09), ("MX2", 0.4), ("MY2", 0.0), ("IA2", 0.05)];

#[test]
fn iv_and_didim_find_the_arm_and_are_validated() {
    let here = experiments("closed_loop_methods");
    for method in ["iv", "didim"] {
        let out = run(&here, &format!("identify arm.yaml logs --plan plan.yaml --method {method} --out {method}.yaml"));
        assert!(out.contains("of the simulated loop"), "{method}: {out}");
        let found = estimate(&here.join(format!("{method}.yaml")));
        assert_eq!(found.settled, Some(true), "{method}: {out}");
        for (name, truth) in TRUTH {
            let value = found.value(&name.parse().unwrap()).unwrap_or_else(|| panic!("{method}: no {name}"));
            // Tolerance: 2 % of the largest value, 2.0. The simulated friction differs between the directions of motion; the
            // friction columns do not.
            assert!((value - truth).abs() < 0.02 * 2.0, "{method} {name}: {value} for {truth}\n{out}");
        }
        let out = run(&here, &format!("validate arm.yaml {method}.yaml logs"));
        assert!(out.contains("trust: with care") && out.contains("too narrow"), "{out}");
    }
    rist(&here, &["identify", "arm.yaml", "logs", "--method", "didim"]).failed(2, &["--method didim needs the plan"]);
}

/// The logs have currents, and one gain is known. Both total least squares (`tls`) and maximum likelihood find the true gain. If
/// all gains are known, `tls` has nothing to estimate and is refused.
#[test]
fn total_least_squares_finds_the_gains_of_drives() {
    let here = experiments("total_least_squares");
    run(&here, "simulate arm.yaml plan.yaml --validation 1 --gain q1=2,q2=1.5 --out currents");
    for method in ["rist", "tls"] {
        run(
            &here,
            &format!("identify arm.yaml currents --plan plan.yaml --gain q2=1.5 --method {method} --out {method}.yaml"),
        );
    }
    let (likely, total) = (estimate(&here.join("rist.yaml")), estimate(&here.join("tls.yaml")));
    assert!(total.method.starts_with("tls:"), "{}", total.method);
    assert_ne!(likely.parameters, total.parameters);
    for (ours, theirs) in total.parameters.iter().zip(&likely.parameters).filter(|(p, _)| p.value.is_some()) {
        let (sigma, difference) = (theirs.sigma_or_infinity(), ours.value.unwrap() - theirs.value.unwrap());
        // Both estimators are efficient, so their difference is much smaller than the error of either.
        assert!(difference.abs() <= 0.5 * sigma + 1e-12, "{}: {difference} of {sigma}", ours.id);
    }
    let gain = total.parameters.iter().find(|p| p.id == ParameterId::drive_gain("q1")).unwrap();
    assert!((gain.value.unwrap() - 2.0).abs() < 4.0 * gain.sigma_or_infinity().max(0.005), "{gain:?}");
    let all = "identify arm.yaml currents --plan plan.yaml --gain q1=2,q2=1.5 --method tls";
    rist(&here, &all.split(' ').collect::<Vec<_>>()).failed(2, &["all of them are known: --method rist takes them"]);
}

#[test]
fn essential_leaves_out_what_the_logs_do_not_need() {
    let here = experiments("essential_method");
    let logs = "logs/v01.csv logs/v02.csv";
    run(&here, &format!("identify arm.yaml {logs} --out whole.yaml"));
    let out = run(&here, &format!("identify arm.yaml {logs} --method essential --out few.yaml"));
    assert!(out.contains("essential parameters, least squares") && out.contains("are essential"), "{out}");
    let (whole, few) = (estimate(&here.join("whole.yaml")), estimate(&here.join("few.yaml")));
    let gone: Vec<String> = few.parameters.iter().filter(|p| p.value == Some(0.0)).map(|p| p.id.to_string()).collect();
    assert!(gone.iter().any(|name| name == "MY1" || name == "MY2"), "{gone:?}");
    for parameter in few.parameters.iter().filter(|p| p.value == Some(0.0)) {
        assert_eq!(parameter.status, Status::NotSignificant, "{parameter:?}");
    }
    assert!(few.value(&"ZZR1".parse().unwrap()).is_some_and(|zz| (zz - 0.95).abs() < 0.1));
    // The method `essential` removes parameters if the residual grows by a small amount, far below 1 %.
    let (few_left, whole_left) = (few.total.unwrap(), whole.total.unwrap());
    assert!(few_left < 1.01 * whole_left, "{few_left} {whole_left}");
    run(&here, "validate arm.yaml few.yaml logs/v02.csv");
}

/// Flags of `rist identify --help` that determine how the robot description is read. All commands have them;
/// `tests/tests/program/command_line.rs` tests them.
const OF_THE_MODEL: [&str; 11] = [
    "--root",
    "--angles",
    "--mimic",
    "--value",
    "--arg",
    "--package",
    "--rotor-inertia",
    "--lock",
    "--base",
    "--floating-base",
    "--any-size",
];

/// Flags of all commands that control the terminal output; `tests/tests/program/terminal.rs` tests them.
const OF_THE_TERMINAL: [&str; 3] = ["--color", "--json", "--quiet"];

/// The arguments with which a flag changes the outcome, if the method uses the flag; `None` for an unknown flag.
fn with_value(flag: &str) -> Option<Vec<&str>> {
    let value = match flag {
        "--plan" => "plan.yaml",
        "--gain" => "q1=2",
        "--validate" | "--loaded" => "logs/v01.csv",
        "--load" => "load.yaml",
        "--arm" => "xm430-w350",
        "--cutoff" => "12",
        "--rate" => "300",
        "--order" => "2",
        "--decimate" => "7",
        "--delay" => "0.003",
        "--ripple" => "q2=12",
        "--elastic" | "--backlash" | "--spring" | "--eccentric" => "all",
        "--unknowns" => "zeros",
        "--friction" => "viscous",
        "--weights" => "none",
        "--options" => "options.yaml",
        "--write-urdf" | "--write-mjcf" | "--report" | "--series" => "extra.txt",
        "--consistent" | "--anyway" | "--covariance" | "--leave-out-contact" => return Some(vec![flag]),
        // These flags need another flag, or exclude one.
        "--free-bodies" => return Some(vec![flag, "--consistent"]),
        "--loaded-link" => return Some(vec!["--loaded", "logs/v01.csv", flag, "forearm"]),
        "--into" => return Some(vec!["--write-mjcf", "extra.txt", flag, "plan.yaml"]),
        "--date" => return Some(vec!["--report", "extra.txt", flag, "today"]),
        _ => return None,
    };
    Some(vec![flag, value])
}

/// The log arguments of a method, and the other arguments that this method needs.
fn logs_of(method: &str) -> &'static [&'static str] {
    match method {
        // This method estimates drive gains, so its logs contain currents.
        "tls" => &["currents", "--plan", "plan.yaml", "--gain", "q2=1.5"],
        "ls" | "essential" => &["logs/v02.csv"],
        _ => &["logs", "--plan", "plan.yaml"],
    }
}

/// No method ignores a flag: either the outcome changes, or the flag is refused. The refusal names the flag and lists the methods
/// that use it.
#[test]
fn every_method_heeds_or_refuses_every_flag() {
    let here = experiments("flags_of_methods");
    std::fs::write(here.join("load.yaml"), "link: forearm\nmass: 0.5\ncentre_of_mass: [0.3, 0, 0]\n").unwrap();
    std::fs::write(here.join("options.yaml"), "columns: {time: clock}\n").unwrap();
    let help = run(&here, "identify --help-all");
    let words = help.split(|c: char| !(c.is_ascii_alphanumeric() || c == '-')).filter(|w| w.starts_with("--"));
    let mut flags: Vec<&str> = words.filter(|w| w.len() > 2).collect();
    flags.sort();
    flags.dedup();
    assert!(flags.len() > 20, "{flags:?}");
    run(&here, "simulate arm.yaml plan.yaml --validation 1 --gain q1=2,q2=1.5 --out currents");
    let methods = ["ls", "essential", "rist", "tls", "rist-mh", "iv", "didim"];
    // Flag -> (methods that refuse it, methods that the refusal lists as users).
    let mut refusals: BTreeMap<String, (Vec<&str>, Vec<String>)> = BTreeMap::new();
    for method in methods {
        let base = [&["identify", "arm.yaml", "--method", method, "--out", "e.yaml"], logs_of(method)].concat();
        let plain = rist(&here, &base).ended(0);
        let estimate = || std::fs::read(here.join("e.yaml")).unwrap_or_default();
        let written = estimate();
        let elsewhere = [&OF_THE_MODEL[..], &OF_THE_TERMINAL, &["--help", "--help-all", "--method", "--out"]].concat();
        for &flag in flags.iter().filter(|f| !elsewhere.contains(f)) {
            let Some(more) = with_value(flag) else {
                panic!("{flag} is new: say here with which value it changes something")
            };
            if base.contains(&flag) {
                continue;
            }
            let _ = std::fs::remove_file(here.join("extra.txt"));
            let run = rist(&here, &base.iter().chain(&more).copied().collect::<Vec<_>>());
            let named = more.iter().find(|word| word.starts_with("--")).unwrap();
            let is_refused = run.code == Some(2) && (run.err.contains(named) || run.err.contains("clock"));
            let refused = run.err.lines().find_map(|l| l.split_once(": --method ").filter(|(f, _)| f.ends_with(named)));
            if let Some((_, users)) = refused.and_then(|(_, rest)| rest.split_once("; --method ")) {
                let refusal = refusals.entry(named.to_string()).or_default();
                refusal.0.push(method);
                refusal.1 = users.trim_end_matches(" does").split(" or ").map(String::from).collect();
            }
            let is_heeded = run.out != plain.out || estimate() != written || here.join("extra.txt").exists();
            // `--anyway` only changes the output if the verdict is no, and for these logs the verdict is not no.
            let is_idle = flag == "--anyway" && method == "ls";
            assert!(
                is_refused || is_heeded || is_idle,
                "--method {method} {more:?} is passed over: {}{}",
                run.err,
                run.out
            );
        }
    }
    assert!(refusals.len() > 10, "{refusals:?}");
    for (flag, (by, users)) in &refusals {
        let others: Vec<&str> = methods.into_iter().filter(|method| !by.contains(method)).collect();
        assert_eq!(*users, others, "{flag}, refused by {by:?}");
    }
}
