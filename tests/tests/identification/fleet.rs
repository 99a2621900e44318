//! `rist accumulate`, `merge`, `solve` and `compare`: the result from sums of logs equals the result of a single pass over all
//! logs; sums that do not fit are refused; changes between robots are reported.

use std::path::Path;

use rist::{Estimate, Model};
use tests::benchmark::fleet::{Fleet, simulate};
use tests::faults::{changed, each};
use tests::joint_log::{JointLog, swinging, unlike};
use tests::program::{Run, estimate, folder, rist};
use tests::{has, model_path, urdf_text};

fn arm() -> String {
    model_path("ur5.urdf").display().to_string()
}

/// Logs a.csv, b.csv, .. of one machine. The amplitude of the motion decreases from log to log.
fn logs(here: &Path, count: usize) -> Vec<String> {
    let model = Model::read(arm()).unwrap();
    let x = unlike(&model.robot, 5);
    let write = |k: usize| {
        let name = format!("{}.csv", char::from(b'a' + k as u8));
        log(&model, &x, 1.2 - 0.1 * k as f64).write_for(&model, &here.join(&name));
        name
    };
    (0..count).map(write).collect()
}

/// A log of ten seconds at 500 Hz, with every fifth row.
fn log(model: &Model, x: &[f64], amplitude: f64) -> JointLog {
    swinging(&model.robot, x, amplitude, 0.0).every(5)
}

#[track_caller]
fn done(here: &Path, arguments: &[&str]) -> Run {
    rist(here, arguments).ended(0)
}

fn refused(here: &Path, arguments: &[&str], expected: &[&str]) {
    let run = rist(here, arguments).ended(2);
    has(&run.err, expected);
}

#[test]
fn sums_are_one_pass() {
    let here = folder("fleet_sums");
    let model = arm();
    let names = logs(&here, 4);
    let all: Vec<&str> = names.iter().map(String::as_str).collect();
    for logs in [&all[..1], &all] {
        done(&here, &[&["accumulate", &model], logs, &["--out", "default.tri"]].concat());
        done(&here, &["solve", "default.tri", "--out", "sums.yaml"]);
        done(&here, &[&["identify", &model], logs, &["--weights", "joint", "--out", "pass.yaml"]].concat());
        let (sums, pass) = (estimate(&here.join("sums.yaml")), estimate(&here.join("pass.yaml")));
        assert_eq!((sums.rows, sums.rank, &sums.logs), (pass.rows, pass.rank, &pass.logs));
        // The sums and the single pass divide the rows into different blocks. So the results differ by some hundred rounding
        // errors, times a condition number of a hundred.
        let close = |a: f64, b: f64, size: f64| (a - b).abs() < 1e-10 * size;
        let of = |e: &Estimate| (e.cutoff.unwrap(), e.total.unwrap());
        let (sums_of, pass_of) = (of(&sums), of(&pass));
        assert!(close(sums_of.0, pass_of.0, pass_of.0) && close(sums_of.1, pass_of.1, pass_of.1));
        for (a, b) in sums.parameters.iter().zip(&pass.parameters) {
            assert_eq!((&a.id, a.unit, a.value.is_some()), (&b.id, b.unit, b.value.is_some()));
            let Some((x, y)) = a.value.zip(b.value) else { continue };
            assert!(close(x, y, y.abs() + b.sigma.unwrap()), "{}: {x} {y}", a.id);
            // The robust standard deviations differ, because they use different replicates: sums use blocks of time, a single
            // pass uses also bands of speed. So only the standard deviations for white noise are compared.
            assert!((a.white_sigma.unwrap() / b.white_sigma.unwrap() - 1.0).abs() < 1e-8, "{}", a.id);
        }
    }
    let sum = |logs: &[&str], out: &str, more: &[&str]| {
        done(&here, &[&["accumulate", &model], logs, &["--cutoff", "5", "--out", out], more].concat());
        std::fs::read(here.join(out)).unwrap()
    };
    let one = sum(&all, "all.tri", &["--threads", "1"]);
    assert!(
        one == sum(&[all[2], all[0], all[3], all[1]], "two.tri", &["--threads", "2"]),
        "two readers, another order"
    );
    sum(&all[2..], "late.tri", &[]);
    sum(&all[1..2], "b.tri", &[]);
    done(&here, &["accumulate", &model, "a.csv", "--like", "late.tri", "--out", "a.tri"]);
    for parts in [["late.tri", "a.tri", "b.tri"], ["b.tri", "late.tri", "a.tri"]] {
        done(&here, &[&["merge"][..], &parts, &["--out", "merged.tri"]].concat());
        assert!(std::fs::read(here.join("merged.tri")).unwrap() == one, "{parts:?}");
    }
    // If a log has a gap, the samples of all its segments are used.
    let whole = std::fs::read_to_string(here.join("a.csv")).unwrap();
    let gap = |(k, _): &(usize, &str)| !(400..600).contains(k);
    let parts: Vec<&str> = whole.lines().enumerate().filter(gap).map(|(_, line)| line).collect();
    std::fs::write(here.join("gap.csv"), parts.join("\n") + "\n").unwrap();
    let samples = |out: &str| -> usize {
        let tri = std::fs::read(here.join(out)).unwrap();
        let text = String::from_utf8_lossy(&tri);
        text.split("samples: ").nth(1).unwrap().lines().next().unwrap().trim().parse().unwrap()
    };
    sum(&["gap.csv"], "gap.tri", &[]);
    sum(&["a.csv"], "a_alone.tri", &[]);
    // In the log with a gap, a fifth of the rows is missing, and the filter drops more rows at the ends of the gap.
    let share = samples("gap.tri") as f64 / samples("a_alone.tri") as f64;
    assert!((0.6..0.85).contains(&share), "{share}");
    let text = String::from_utf8_lossy(&one);
    has(&text, &["rist-tri 4 ", "fingerprint: ", "cutoff: 5", "name: d.csv", "rows: 1000", "unit: kg m"]);
    // An estimate from sums can be used like any other estimate.
    done(&here, &["solve", "merged.tri", "--out", "e.yaml"]);
    let valid = done(&here, &["validate", &model, "e.yaml", "a.csv"]);
    assert!(valid.out.contains("from sums"), "{}", valid.out);
    done(&here, &["report", "--estimate", "e.yaml", "--out", "r.html"]);
}

#[test]
fn broken_logs_are_named() {
    let here = folder("fleet_broken");
    let other = here.join("other.urdf");
    std::fs::write(&other, urdf_text::random_tree(6, 1, 1)).unwrap();
    let (model, ur5) = (Model::read(&other).unwrap(), Model::read(arm()).unwrap());
    let coordinates = model.regressor().coordinates();
    let x = unlike(&model.robot, 5);
    log(&model, &x, 1.2).write(&here.join("a.csv"), coordinates);
    let backwards = changed(&log(&model, &x, 1.0), |log| each(&mut log.tau, |x| -x));
    backwards.write(&here.join("backwards.csv"), coordinates);
    log(&ur5, &unlike(&ur5.robot, 5), 1.2).write(&here.join("other.csv"), coordinates);
    let packed = {
        use std::io::Write;
        let mut gz = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        gz.write_all(&std::fs::read(here.join("a.csv")).unwrap()).unwrap();
        gz.finish().unwrap()
    };
    std::fs::write(here.join("cut.csv.gz"), &packed[..packed.len() / 2]).unwrap();
    let model = other.display().to_string();
    let out = ["--cutoff", "5", "--out", "x.tri"];
    for (log, why) in [
        ("cut.csv.gz", "damaged or cut short"),
        ("other.csv", "not of the described robot"),
        ("backwards.csv", "wrong sign"),
        ("missing.csv", "there is no such file"),
    ] {
        refused(&here, &[&["accumulate", &model, "a.csv", log][..], &out].concat(), &[log, why, "--skip-broken"]);
        assert!(!here.join("x.tri").exists());
    }
    let broken = ["cut.csv.gz", "other.csv", "a.csv", "missing.csv"];
    let run = done(&here, &[&["accumulate", &model][..], &broken, &out, &["--skip-broken"]].concat());
    has(&run.out, &["left out: cut.csv.gz: ", "left out: missing.csv: ", "left out: other.csv: ", ": 1 log, "]);
    let solved = done(&here, &["solve", "x.tri", "--out", "e.yaml"]);
    assert!(solved.out.contains("not in it: cut.csv.gz: "), "{}", solved.out);
    assert_eq!(estimate(&here.join("e.yaml")).logs, ["a.csv"]);
    refused(
        &here,
        &[&["accumulate", &model, "missing.csv", "--skip-broken"][..], &out].concat(),
        &["no log can be used"],
    );
    done(&here, &[&["accumulate", &model, "other.csv", "--anyway"][..], &out].concat());
}

/// Sums with different settings cannot be added and are refused. The message names the difference.
#[test]
fn unlike_parts_are_refused() {
    let here = folder("fleet_unlike");
    let model = arm();
    logs(&here, 2);
    let sum = |log: &str, out: &str, more: &[&str]| {
        done(&here, &[&["accumulate", &model, log, "--out", out], more].concat());
    };
    sum("a.csv", "a.tri", &["--cutoff", "5"]);
    sum("b.csv", "b.tri", &["--cutoff", "6", "--friction", "viscous,coulomb"]);
    sum("b.csv", "same.tri", &["--cutoff", "5"]);
    std::fs::copy(here.join("a.csv"), here.join("copy.csv")).unwrap();
    sum("copy.csv", "copy.tri", &["--cutoff", "5"]);
    let merge = |parts: &[&str], expected: &[&str]| {
        refused(&here, &[&["merge"][..], parts, &["--out", "x.tri"]].concat(), expected);
        assert!(!here.join("x.tri").exists());
    };
    merge(&["a.tri", "b.tri"], &["b.tri cannot be added to a.tri", "cut-off: 5 Hz and 6 Hz", "friction: ", "--like"]);
    merge(&["a.tri", "a.tri"], &["a.csv: in both"]);
    merge(&["a.tri", "copy.tri"], &["copy.csv: in both (as a.csv)"]);
    refused(&here, &["compare", "a.tri", "b.tri"], &["b.tri and a.tri cannot be compared", "cut-off"]);
    refused(&here, &["compare", "a.tri", "copy.tri"], &["copy.csv: in copy.tri and in a.tri"]);
    refused(&here, &["compare", "a.tri", "same.tri", "--fdr", "2"], &["between 0 and 1"]);
    let bytes = std::fs::read(here.join("a.tri")).unwrap();
    std::fs::write(here.join("cut.tri"), &bytes[..bytes.len() / 2]).unwrap();
    let newer: Vec<u8> = [b"rist-tri 7", &bytes["rist-tri 3".len()..]].concat();
    std::fs::write(here.join("newer.tri"), newer).unwrap();
    refused(&here, &["solve", "cut.tri"], &["cut.tri: cut short", "make it again"]);
    refused(&here, &["solve", "newer.tri"], &["newer.tri: version 7", "reads up to 4"]);
    refused(&here, &["solve", "a.csv"], &["a.csv: no sums of rist accumulate"]);
    let accumulate = |more: &[&str], expected: &[&str]| {
        refused(&here, &[&["accumulate", &model, "a.csv", "--out", "x.tri"], more].concat(), expected);
    };
    accumulate(&["--weights", "huber"], &["residual of each row", "joint or none, or identify"]);
    accumulate(&["--delay", "auto"], &["over the rows many times", "find it on some of the logs"]);
    accumulate(&["--friction", "auto"], &["once for each candidate", "choose it on some of the logs"]);
    accumulate(&["a.csv"], &["given twice"]);
    accumulate(&["copy.csv"], &["copy.csv: in both (as a.csv)"]);
    let currents = std::fs::read_to_string(here.join("a.csv")).unwrap().replace("tau_", "i_");
    std::fs::write(here.join("currents.csv"), currents).unwrap();
    refused(
        &here,
        &["accumulate", &model, "currents.csv", "--out", "x.tri"],
        &["currents.csv", "motor currents", "all logs at once", "--gain"],
    );
    let other = here.join("other.urdf");
    std::fs::write(&other, urdf_text::random_tree(6, 1, 1)).unwrap();
    let other = other.display().to_string();
    refused(
        &here,
        &["accumulate", &other, "a.csv", "--like", "a.tri", "--out", "x.tri"],
        &["a.tri: the sums: made with"],
    );
}

#[test]
fn changed_robots_are_found() {
    let model = Model::read(tests::workspace().join("tests/data/robots/r3g.yaml")).unwrap();
    let fleet = Fleet { robots: 60, changed: 12, logs: 16, seconds: 4.0, reference_logs: 32, seed: 3 };
    let found = simulate(&model, fleet, &[0.0, 8.0], 0.05);
    let [(_, none), (_, eight)] = found.as_slice() else { panic!("{found:?}") };
    println!("{none:?}\n{eight:?}");
    // 60 unchanged robots: the probability that any of them is reported is 5 %.
    assert!(none.robots <= 1, "{none:?}");
    // The size of the change is eight standard deviations of the difference between a robot (sum of 16 logs) and the reference.
    // This is two standard deviations of a single log. Of twelve changed robots, one may be missed, and one unchanged robot may
    // be reported.
    assert!(eight.power() > 0.9 && eight.robots - eight.right_robots <= 1, "{eight:?}");
    assert!(eight.false_parameters() < 0.1, "{eight:?}");
}
