//! `rist identify` with typical logs: friction, currents, a load, several files, predictions.

use serde_json::Value as Json;
use tests::planar_log::{HEADER, log_of, write_log};
use tests::program::{folder, rist};
use tests::random::Random;
use tests::{has, model, test_robot_path};

/// Viscous friction, N m s/rad. `COULOMB`: Coulomb friction, N m.
const VISCOUS: [f64; 2] = [0.4, 0.2];
const COULOMB: [f64; 2] = [0.7, 0.3];

fn rubbed(j: usize, dq: f64, tau: f64) -> f64 {
    tau + VISCOUS[j] * dq + COULOMB[j] * dq.signum()
}

fn arm() -> String {
    test_robot_path("planar2r_vertical.yaml").display().to_string()
}

fn yaml(path: &std::path::Path) -> Json {
    serde_yaml::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

fn value(estimate: &Json, name: &str) -> f64 {
    let parameters = estimate["parameters"].as_array().unwrap();
    parameters.iter().find(|p| p["name"] == name).unwrap()["value"].as_f64().unwrap()
}

fn line<'a>(text: &'a str, start: &str) -> &'a str {
    text.lines().find(|l| l.starts_with(start)).unwrap_or_else(|| panic!("no line `{start}` in {text}"))
}

/// The number at a position of a line, counted in words from 0.
fn number(line: &str, word: usize) -> f64 {
    line.split_whitespace().nth(word).unwrap().parse().unwrap()
}

#[test]
fn several_logs_friction_and_prediction() {
    let here = folder("several_logs");
    let robot = model("planar2r_vertical.yaml");
    let rows = log_of(&robot, &Random(41).physical_parameters(&robot), &rubbed);
    let part = |name: &str, rows: &[String]| {
        std::fs::write(here.join(name), format!("{HEADER}\n{}\n", rows.join("\n"))).unwrap();
    };
    part("a.csv", &rows[..2500]);
    part("b.csv", &rows[2500..4500]);
    part("c.csv", &rows[4500..]);
    let run = rist(&here, &["identify", &arm(), "a.csv", "b.csv", "--validate", "c.csv", "--out", "e.yaml"]).ended(0);
    let estimate = yaml(&here.join("e.yaml"));
    for j in 0..2 {
        // The filter smooths the jumps of the friction torque, and in the same way the friction columns. So the error is below 1
        // %.
        assert!((value(&estimate, &format!("FV{}", j + 1)) / VISCOUS[j] - 1.0).abs() < 0.01);
        assert!((value(&estimate, &format!("FS{}", j + 1)) / COULOMB[j] - 1.0).abs() < 0.01);
    }
    let predicted = run.out.split("c.csv, not fitted").nth(1).unwrap();
    assert!(number(line(predicted, "total"), 1) < 0.01, "{predicted}");
    // A later prediction with the estimate file gives the same result.
    let later = rist(&here, &["validate", &arm(), "e.yaml", "c.csv", "--out", "v.yaml"]).ended(0);
    assert_eq!(line(&later.out, "total"), line(predicted, "total"));
    let total = yaml(&here.join("v.yaml"))["total"].as_f64().unwrap();
    assert!((total - number(line(predicted, "total"), 1)).abs() < 1e-4);
}

#[test]
fn currents_become_torques_by_gains_given_or_found() {
    let here = folder("currents");
    let robot = model("planar2r_vertical.yaml");
    let gain = [2.0, 0.5];
    let rows = log_of(&robot, &Random(42).physical_parameters(&robot), &|j, dq, tau| rubbed(j, dq, tau) / gain[j]);
    std::fs::write(here.join("log.csv"), format!("{}\n{}\n", HEADER.replace("tau", "i"), rows.join("\n"))).unwrap();
    std::fs::write(here.join("options.yaml"), "covariance: true\n").unwrap();
    let command = ["identify", &arm(), "log.csv", "--options", "options.yaml"];
    let identify = |more: &[&str]| rist(&here, &[&command, more].concat());
    identify(&[]).failed(2, &["--gain q1=11.5"]);
    for gains in ["q1=2,q2=0.5", "q1=2", "q1=2,q2=0.6+-0.3"] {
        let run = identify(&["--gain", gains, "--out", "e.yaml"]).ended(0);
        let estimate = yaml(&here.join("e.yaml"));
        for (c, parameter) in estimate["parameters"].as_array().unwrap().iter().enumerate() {
            let Some(sigma) = parameter["sigma"].as_f64() else { continue };
            let variance = estimate["covariance"][c][c].as_f64().unwrap();
            assert!((variance / (sigma * sigma) - 1.0).abs() < 1e-9, "{gains}: {parameter:?} {variance}");
        }
        let friction = value(&estimate, "FS2");
        // The accuracy is limited by the filtered jumps of the friction.
        assert!((friction / COULOMB[1] - 1.0).abs() < 0.01, "{gains}: {friction}");
        assert_eq!(
            run.out.contains("q2 0.5") && run.out.contains("q1 2.0000 (given)"),
            gains != "q1=2,q2=0.5",
            "{}",
            run.out
        );
    }
}

/// The load on the forearm of a planar arm changes only the parameters ZZ, MX, MY and M.
#[test]
fn a_load_between_two_logs() {
    let here = folder("load");
    let robot = model("planar2r_vertical.yaml");
    let x = Random(43).physical_parameters(&robot);
    write_log(&here, &log_of(&robot, &x, &rubbed));
    let names = tests::standard_names(&robot);
    let load = [("ZZ2", 0.05), ("MX2", 0.3), ("MY2", -0.1), ("M2", 1.5)];
    let mut loaded = x.clone();
    for (name, more) in load {
        loaded[names.iter().position(|n| n == name).unwrap()] += more;
    }
    let rows = log_of(&robot, &loaded, &rubbed);
    std::fs::write(here.join("loaded.csv"), format!("{HEADER}\n{}\n", rows.join("\n"))).unwrap();
    let run = rist(&here, &["identify", &arm(), "log.csv", "--loaded", "loaded.csv"]).ended(0);
    let found = run.out.split("load on forearm").nth(1).unwrap();
    for (name, more) in load {
        let letters = name.trim_end_matches('2');
        let found = number(line(found, &format!("{letters} ")), 1);
        assert!((found - more).abs() < 0.01 * 1.5, "{name}: {found}, not {more}");
    }
    assert!(line(found, "XX ").contains("not identifiable"), "{found}");
    rist(&here, &["identify", &arm(), "log.csv", "--loaded", "loaded.csv", "--loaded-link", "hand"])
        .failed(2, &["upper arm, forearm"]);
}

fn described_arm() -> std::path::PathBuf {
    tests::model_path("planar2r_vertical.yaml")
}

/// Writes two logs of the same motion, without and with a load. The logged signals are the torques divided by `gain`.
fn write_pair(here: &std::path::Path, head: &str, gain: [f64; 2], noise: f64, seed: u64) {
    let robot = model("planar2r_vertical.yaml");
    let x = tests::joint_log::described(&robot);
    let names = tests::standard_names(&robot);
    let mut loaded = x.clone();
    for (name, more) in [("ZZ2", 0.05), ("MX2", 0.3), ("MY2", -0.1), ("M2", 1.5)] {
        loaded[names.iter().position(|n| n == name).unwrap()] += more;
    }
    let random = std::cell::RefCell::new(Random(seed));
    let noisy = |tau: f64| tau + noise * (0..12).map(|_| 0.5 * random.borrow_mut().unit()).sum::<f64>();
    for (file, x) in [("log.csv", &x), ("loaded.csv", &loaded)] {
        let rows = log_of(&robot, x, &|j, dq, tau| noisy(rubbed(j, dq, tau)) / gain[j]);
        std::fs::write(here.join(file), format!("{}\n{}\n", HEADER.replace("tau", head), rows.join("\n"))).unwrap();
    }
}

/// The given gains are wrong by their standard deviations. The error of the identified load must agree with its standard
/// deviation: over eight draws of four numbers, the rms of the normalised error is one, up to 25 %. If the standard deviation did
/// not contain the uncertainty of the gains, it would be above ten.
#[test]
fn a_load_is_as_unsure_as_the_gains() {
    let here = folder("load_gains");
    let (expected, share, draws) = ([2.0, 0.5], 0.2, 8);
    let mut random = Random(46);
    let mut normal = || (0..12).map(|_| 0.5 * random.unit()).sum::<f64>();
    let mut squares = Vec::new();
    for seed in 0..draws {
        let gain = expected.map(|k: f64| k * (1.0 + share * normal()));
        write_pair(&here, "i", gain, 0.02, seed);
        let gains: Vec<String> =
            expected.iter().enumerate().map(|(j, k)| format!("q{}={k}+-{}", j + 1, share * k)).collect();
        let arm = described_arm().display().to_string();
        let command = ["identify", &arm, "log.csv", "--loaded", "loaded.csv", "--gain", &gains.join(",")];
        let run = rist(&here, &[&command[..], &["--json"]].concat());
        assert!(run.code.is_some_and(|code| code < 2), "{}", run.err);
        let load = &serde_json::from_str::<Json>(&run.out).unwrap()["load"];
        for (name, truth) in [("ZZ", 0.05), ("MX", 0.3), ("MY", -0.1), ("M", 1.5)] {
            let told = |key: &str| load["parameters"][name][key].as_f64().unwrap();
            squares.push(((told("value") - truth) / told("sigma")).powi(2));
        }
        let said = rist(&here, &command).out;
        assert!(said.contains("these include sigma of the drive gains"), "{said}");
        assert!(!said.contains("a common factor"), "{said}");
    }
    let rms = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
    assert!((0.4..1.6).contains(&rms) && squares.iter().all(|s| *s < 16.0), "{rms} {squares:?}");
}

/// All torques are 15 % too small, so the load is 15 % too small. The output states that a common factor cannot be detected, and
/// its effect on the mass.
#[test]
fn a_common_factor_that_would_not_have_shown_is_said_of_a_load() {
    let here = folder("load_scale");
    write_pair(&here, "tau", [1.0 / 0.85, 1.0 / 0.85], 0.02, 5);
    let run = rist(&here, &["identify", &described_arm().display().to_string(), "log.csv", "--loaded", "loaded.csv"]);
    let said = line(&run.out, "in the units of the torques as logged: a common factor below ");
    let between = said.split_once("by which the mass is between ").unwrap().1;
    let (from, to) = (number(between, 0), number(between, 2));
    assert!(from < 1.275 && 1.5 < to && to < 3.0, "{said}");
}

/// Encoder counts instead of angles are refused, because sines of them have no meaning.
#[test]
fn counts_of_an_encoder_are_refused() {
    let here = folder("counts");
    let robot = model("planar2r_vertical.yaml");
    let rows = log_of(&robot, &Random(44).physical_parameters(&robot), &rubbed);
    for per_radian in [2e4, 1e9] {
        let counts = rows.iter().map(|row| {
            let mut cells: Vec<f64> = row.split(',').map(|cell| cell.parse().unwrap()).collect();
            cells[2] *= per_radian;
            cells[4] *= per_radian;
            cells.iter().map(|x| format!("{x:?}")).collect::<Vec<_>>().join(",")
        });
        write_log(&here, &counts.collect::<Vec<_>>());
        let run = rist(&here, &["identify", &arm(), "log.csv"]).ended(2);
        has(&run.err, &["log.csv", "q2 is at", "thousand turns", "counts of an encoder", "divide the column"]);
    }
}

/// Parameters are written into a MuJoCo model. If it already has them, it is unchanged, byte by byte. A model of another robot is
/// refused.
#[test]
fn a_mujoco_model_takes_the_figures() {
    let here = folder("mujoco");
    let [urdf, log] = ["models/ur5.urdf", "docs/ur5/log.csv"].map(|f| tests::workspace().join(f).display().to_string());
    let write = |out: &str, into: &[&str]| {
        let common = ["identify", &urdf, &log, "--consistent", "--anyway", "--write-mjcf", out];
        rist(&here, &[&common, into].concat())
    };
    write("arm.xml", &[]).ended(0);
    let text = std::fs::read_to_string(here.join("arm.xml")).unwrap();
    assert_eq!(text.matches("<inertial ").count(), 6, "{text}");
    std::fs::write(here.join("own.xml"), &text).unwrap();
    assert_eq!(write("again.xml", &["--into", "own.xml"]).code, Some(0));
    assert!(std::fs::read_to_string(here.join("again.xml")).unwrap() == text, "the same figures change the text");
    std::fs::write(here.join("other.xml"), text.replace("pos=\"-0.425 0 0\"", "pos=\"-0.6 0 0\"")).unwrap();

    write("no.xml", &["--into", "other.xml"]).failed(2, &["other.xml:11: the body of forearm stands at"]);
    assert!(!here.join("no.xml").exists());
}

/// A spring, a cable and a bearing between joints, as the user describes them. The parameters of each element are identified, and
/// a second log is predicted with them. An element of another robot is refused.
#[test]
fn elements_between_joints_come_out() {
    let here = folder("elements");
    let robot = model("planar2r_vertical.yaml");
    let rows = log_of(&robot, &Random(45).physical_parameters(&robot), &rubbed);
    // The elements act along w = q1 - 0.5 q2. Stiffness, N m/rad; amplitude of the sine, N m; viscous friction, N m s/rad.
    let (along, stiffness, sine, viscous) = ([1.0, -0.5], 3.0, 1.4, 0.6);
    let moved = |row: &String| {
        let x: Vec<f64> = row.split(',').map(|cell| cell.parse().unwrap()).collect();
        let of = |first: usize| along[0] * x[first] + along[1] * x[first + 1];
        let force = stiffness * of(1) + sine * of(1).sin() + viscous * of(3);
        let cells = [&x[..5], &[x[5] + along[0] * force, x[6] + along[1] * force]].concat();
        cells.iter().map(|x| format!("{x:?}")).collect::<Vec<_>>().join(",")
    };
    let rows: Vec<String> = rows.iter().map(moved).collect();
    let part = |name: &str, rows: &[String]| {
        std::fs::write(here.join(name), format!("{HEADER}\n{}\n", rows.join("\n"))).unwrap();
    };
    part("a.csv", &rows[..4000]);
    part("b.csv", &rows[4000..]);
    let options = |element: &str| {
        std::fs::write(here.join("o.yaml"), format!("transmission:\n  elements: [{element}]\n")).unwrap();
        rist(&here, &["identify", &arm(), "a.csv", "--options", "o.yaml", "--validate", "b.csv", "--out", "e.yaml"])
    };
    let run = options("{name: cable, along: [[1, 1.0], [2, -0.5]], torques: [spring, sine, viscous]}").ended(0);
    let estimate = yaml(&here.join("e.yaml"));
    // The filter smooths the jumps of the friction, so the error is below 1 %.
    for (name, exact) in [("KE_cable", stiffness), ("SE_cable", sine), ("FVE_cable", viscous)] {
        assert!((value(&estimate, name) / exact - 1.0).abs() < 0.01, "{name} {}", value(&estimate, name));
    }
    let predicted = run.out.split("b.csv, not fitted").nth(1).unwrap();
    assert!(number(line(predicted, "total"), 1) < 0.01, "{predicted}");
    for (element, said) in [
        ("{name: cable, along: [[1, 1.0], [3, -0.5]], torques: [spring]}", "element `cable`: `along` needs pairs"),
        ("{name: cable, along: [[1, 1.0], [1, -0.5]], torques: [spring]}", "different joints of 1 to 2"),
        ("{name: cable, along: [[1, .nan]], torques: [spring]}", "element `cable`: `along` needs pairs"),
        ("{name: cable, along: [[1, 1.0]], torques: []}", "`torques` needs one or more different words"),
        ("{name: 'a cable', along: [[1, 1.0]], torques: [spring]}", "its name needs letters"),
        ("{name: cable, along: [[1, 1.0]], torques: [rubber]}", "expected one of `inertia`, `viscous`, `coulomb`"),
    ] {
        options(element).failed(2, &[said]);
    }
}
