//! Tests that the properties that an estimate states about itself are correct, and that unusable results are refused.

use identification::estimate::artefact::Estimate;
use identification::estimate::identified::Status;
use robot::{Robot, StandardParameter};
use tests::joint_log;
use tests::program::{estimate, folder, rist};
use tests::random::Random;
use tests::{model, model_path, model_text};

fn ur5() -> (Robot, String, Vec<f64>) {
    let robot = model("ur5.urdf");
    let x = Random(60).physical_parameters(&robot);
    (robot, model_path("ur5.urdf").display().to_string(), x)
}

/// In each experiment of a plan, some joints rest. Their encoder noise does not count as motion, and all logs get the same
/// cut-off frequency.
#[test]
fn joints_that_are_held_do_not_decide_the_cutoff() {
    let here = folder("held_joints");
    let (robot, urdf, x) = ur5();
    let logs = ["a.csv", "b.csv", "c.csv"];
    let moving = [[1.0, 1.0, 0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, 1.0, 1.0]];
    for (log, amplitude) in logs.iter().zip(&moving) {
        joint_log::write_measured(&here.join(log), &robot, &x, amplitude, 0.05, 1e-5);
    }
    let of = |logs: &[&str]| {
        rist(&here, &[&["identify", &urdf, "--friction", "none", "--out", "e.yaml"], logs].concat()).ended(0);
        estimate(&here.join("e.yaml"))
    };
    // The joints move with sines of at most 0.8 Hz, in bins of 0.1 Hz. If the noise counted as motion, the cut-off would be 100
    // Hz.
    let together = of(&logs);
    assert!(together.cutoff.unwrap() < 30.0, "{together}");
    let alone = of(&logs[..1]);
    assert!(alone.cutoff.unwrap() < 30.0, "{alone}");
    let named = alone.remarks.iter().find(|r| r.contains("hardly move compared with them")).unwrap();
    assert!(named.contains("elbow") && !named.contains("shoulder_pan"), "{named}");
    assert!(alone.joints[2].f95.is_none() && alone.joints[0].f95.is_some(), "{alone}");
}

/// Two numbers in the remark on a physically consistent estimate: 1/2 chi^2, and the bound of its excess over the smallest
/// possible 1/2 chi^2.
fn account(estimate: &Estimate) -> (f64, f64) {
    let text = estimate.remarks.iter().find(|r| r.starts_with("physically consistent")).unwrap();
    let behind = |words: &str| text.split(words).nth(1).unwrap().split([',', ' ']).next().unwrap().parse().unwrap();
    (behind("chi^2 = "), behind("at most "))
}

/// The description is the reference of a physically consistent estimate. If its inertial parameters are a thousand times too
/// small, 1/2 chi^2 increases by no more than the stated bound.
#[test]
fn a_wrong_description_moves_a_consistent_estimate_within_its_bound() {
    let here = folder("wrong_reference");
    let (robot, urdf, x) = ur5();
    joint_log::write(&here.join("log.csv"), &robot, &x, &[1.0; 6], 0.05);
    let mut wrong = String::new();
    for (i, part) in model_text("ur5.urdf").split('"').enumerate() {
        let is_mass = wrong.ends_with("<mass value=");
        let is_inertia = ["ixx=", "ixy=", "ixz=", "iyy=", "iyz=", "izz="].iter().any(|name| wrong.ends_with(name));
        let text = match part.parse::<f64>() {
            Ok(number) if is_mass || is_inertia => format!("{:e}", 1e-3 * number),
            _ => part.to_string(),
        };
        if i % 2 == 1 {
            wrong += &format!("\"{text}\"");
        } else {
            wrong += &text;
        }
    }
    std::fs::write(here.join("wrong.urdf"), wrong).unwrap();
    // With such a description the verdict is no, but the estimate is written.
    let of = |urdf: &str, code: i32| {
        let run = rist(&here, &["identify", urdf, "log.csv", "--friction", "none", "--consistent", "--out", "e.yaml"]);
        assert_eq!(run.code, Some(code), "{}", run.err);
        account(&estimate(&here.join("e.yaml")))
    };
    let ((right, _), (wrong, excess)) = (of(&urdf, 0), of("wrong.urdf", 1));
    // The bound has two terms: at most 24 nats (four logarithms for each of the six bodies, one nat each), and a small term
    // that grows with the size of the bodies relative to the description, here a thousand.
    assert!(wrong - right <= excess && excess < 25.0, "{right} {wrong} {excess}");
}

#[test]
fn bodies_that_explain_nothing_are_not_written() {
    let here = folder("wrong_sign");
    let (robot, urdf, x) = ur5();
    let negative: Vec<f64> = x.iter().map(|x| -x).collect();
    joint_log::write(&here.join("log.csv"), &robot, &negative, &[1.0; 6], 0.05);
    let run = rist(&here, &["identify", &urdf, "log.csv", "--write-urdf", "w.urdf"]).ended(1);
    assert!(run.err.contains("nothing is written for a simulator") && !here.join("w.urdf").exists(), "{}", run.err);
}

#[test]
fn an_estimate_is_whole_and_knows_its_model() {
    let here = folder("whole");
    let (robot, urdf, x) = ur5();
    joint_log::write(&here.join("log.csv"), &robot, &x, &[1.0; 6], 0.01);
    joint_log::write(&here.join("other.csv"), &robot, &x, &[0.7; 6], 0.01);
    let flags = ["--rotor-inertia", "actuated", "--friction", "viscous,coulomb", "--out", "e.yaml"];
    rist(&here, &[&["identify", &urdf, "log.csv"], &flags[..]].concat()).ended(0);
    let new = rist(&here, &["validate", &urdf, "e.yaml", "other.csv"]).ended(0);
    assert!(!new.err.contains("was fitted to it"), "{}", new.err);
    std::fs::copy(here.join("log.csv"), here.join("copy.csv")).unwrap();
    rist(&here, &["validate", &urdf, "e.yaml", "copy.csv"]).failed(0, &["copy.csv: the estimate was fitted to it"]);
    rist(&here, &["validate", &urdf, "e.yaml", "log.csv"]).failed(0, &["log.csv: the estimate was fitted to it"]);

    let text = std::fs::read_to_string(here.join("e.yaml")).unwrap();
    let refused = |text: &str, said: &str| {
        std::fs::write(here.join("cut.yaml"), text).unwrap();
        rist(&here, &["validate", &urdf, "cut.yaml", "other.csv"]).failed(2, &[said]);
    };
    refused(&text.lines().take(5).collect::<Vec<_>>().join("\n"), "cut short");
    let mut fewer = estimate(&here.join("e.yaml"));
    let gone = fewer.parameters.remove(3).id.to_string();
    refused(&fewer.to_yaml().unwrap(), &format!("no parameter {gone}"));
    fewer.fingerprint = None;
    refused(&fewer.to_yaml().unwrap(), "does not say with which model");
}

/// Only one joint moves, so many parameters are identifiable only in combinations. Nevertheless, these combinations predict the
/// torque of this joint.
#[test]
fn what_is_open_does_not_spoil_the_prediction() {
    let here = folder("open");
    let (robot, urdf, _) = ur5();
    // If only one joint moves, other bodies have the same effect as a wrong unit. So the robot is simulated with the nominal
    // parameters.
    let x: Vec<f64> = StandardParameter::all(&robot).into_iter().map(|p| p.value(&robot).unwrap_or(0.0)).collect();
    joint_log::write(&here.join("a.csv"), &robot, &x, &[1.0, 0.0, 0.0, 0.0, 0.0, 0.0], 0.01);
    joint_log::write(&here.join("b.csv"), &robot, &x, &[1.5, 0.0, 0.0, 0.0, 0.0, 0.0], 0.01);
    let flags = ["--friction", "none", "--out", "e.yaml", "--validate", "b.csv"];
    // Five joints are at rest, so for no use (gravity compensation, ..) all torques are determined.
    rist(&here, &[&["identify", &urdf, "a.csv"], &flags[..]].concat())
        .failed(1, &["is not determined: the log does not identify all of its parameters"]);
    let found = estimate(&here.join("e.yaml"));
    let open: Vec<_> = found.parameters.iter().filter(|p| p.status == Status::NotIdentifiable).collect();
    assert!(open.len() > 5 && open.iter().all(|p| p.value.is_none()), "{found}");
    let run = rist(&here, &["validate", &urdf, "e.yaml", "b.csv", "--out", "v.yaml"]).ended(1);
    let total = run.out.lines().find(|l| l.starts_with("total")).unwrap();
    let total: f64 = total.split_whitespace().nth(1).unwrap().parse().unwrap();
    assert!(total < 2.0 * found.total.unwrap() + 1e-3, "fitted {}: {}", found.total.unwrap(), run.out);
}

#[test]
fn what_experiments_do_not_heed_is_refused() {
    let here = folder("unheeded");
    let race = model_path("race.yaml").display().to_string();
    let spectral = ["identify", &race, "logs", "--plan", "plan.yaml", "--method", "rist-mh"];
    for flag in [["--friction", "viscous"], ["--weights", "huber"], ["--validate", "nowhere.csv"], ["--order", "2"]] {
        rist(&here, &[&spectral[..], &flag].concat()).failed(2, &[flag[0]]);
    }
}
