//! Tests that rist takes joint, unit and status of a parameter from the model, and does not derive them from the form of its
//! name.

use identification::estimate::artefact::Estimate;
use identification::estimate::identified::{Identified, Status};
use identification::estimate::validation::Validation;
use tests::joint_log;
use tests::program::{estimate, folder, rist};
use tests::random::Random;
use tests::{model, model_path, model_text, test_robot_path};

fn parameter<'a>(estimate: &'a Estimate, name: &str) -> &'a Identified {
    let id = name.parse().unwrap();
    estimate.parameters.iter().find(|p| p.id == id).unwrap_or_else(|| panic!("no {name} in {estimate}"))
}

/// The joint shoulder_pan moves little, so the weakly identified parameter belongs to it. The digit in the name `wrist_1` must
/// not be read as joint 1.
#[test]
fn the_joint_of_a_parameter_is_not_read_from_its_name() {
    let here = folder("weak_joint");
    let robot = model("ur5.urdf");
    let x = Random(50).physical_parameters(&robot);
    joint_log::write(&here.join("log.csv"), &robot, &x, &[0.005, 1.0, 1.0, 1.0, 1.0, 1.0], 0.01);
    let urdf = model_path("ur5.urdf").display().to_string();
    let run = rist(&here, &["identify", &urdf, "log.csv", "--friction", "none", "--out", "e.yaml"]).ended(0);
    let found = estimate(&here.join("e.yaml"));
    let weak = found.parameters.iter().filter(|p| p.status == Status::Weak);
    assert_eq!(weak.map(|p| p.id.to_string()).collect::<Vec<_>>(), ["ZZR_shoulder_pan"], "{}", run.out);
}

#[test]
fn units_are_those_of_the_joint() {
    let here = folder("prismatic_units");
    let robot = model("cartesian3p.yaml");
    let x = Random(51).physical_parameters(&robot);
    joint_log::write(&here.join("log.csv"), &robot, &x, &[0.5, 0.5, 0.5], 0.0);
    // The description is used without its inertial parameters, because the log is from other bodies.
    let text = model_text("cartesian3p.yaml");
    std::fs::write(here.join("arm.yaml"), text.split("standard_parameters").next().unwrap()).unwrap();
    let run = rist(&here, &["identify", "arm.yaml", "log.csv", "--out", "e.yaml"]).ended(0);
    let found = estimate(&here.join("e.yaml"));
    for (name, unit) in [("IA1", "kg"), ("FV2", "N s/m"), ("FS3", "N"), ("OFF3", "N")] {
        assert_eq!(parameter(&found, name).unit.to_string(), unit, "{name}");
    }
    assert!(run.out.contains("rms N ") && !run.out.contains("N m"), "{}", run.out);
}

/// The file of a validation on logs has the same form as the file of a validation on experiments. So `report` can read both.
#[test]
fn a_report_reads_every_validation() {
    let here = folder("report_of_logs");
    let robot = model("planar2r_vertical.yaml");
    let x = Random(52).physical_parameters(&robot);
    let arm = test_robot_path("planar2r_vertical.yaml").display().to_string();
    joint_log::write(&here.join("a.csv"), &robot, &x, &[1.0, 1.0], 0.01);
    joint_log::write(&here.join("b.csv"), &robot, &x, &[0.6, 1.4], 0.01);
    for arguments in [
        &["identify", &arm, "a.csv", "--out", "e.yaml"][..],
        &["validate", &arm, "e.yaml", "b.csv", "--out", "v.yaml"],
        &["report", "--estimate", "e.yaml", "--validation", "v.yaml", "--out", "r.html"],
    ] {
        rist(&here, arguments).ended(0);
    }
    let page = std::fs::read_to_string(here.join("r.html")).unwrap();
    assert!(page.contains("1 motion") && page.contains("<td>q2</td>"), "{page}");
}

/// A simulation writes its true parameters as truth.yaml. This file is a valid estimate, so `validate` also finds the drive gains
/// in it.
#[test]
fn the_truth_of_a_simulation_predicts_its_logs() {
    let here = folder("truth");
    let race = model_path("race.yaml").display().to_string();
    for arguments in [
        &["plan", &race, "-n", "3", "--out", "plan.yaml"][..],
        &["simulate", &race, "plan.yaml", "--gain", "q1=2.393,q2=0.870", "--out", "logs", "--validation", "2"],
        &["validate", &race, "logs/truth.yaml", "logs", "--out", "v.yaml"],
    ] {
        rist(&here, arguments).ended(0);
    }
    // The limit is the error of the estimate in docs/tutorial.md, 1.44 %. The true values must have a smaller error.
    let validation = std::fs::read_to_string(here.join("v.yaml")).unwrap();
    let total = Validation::from_yaml("v.yaml", &validation).unwrap().total;
    assert!(total < 0.0144, "{total}");
    let truth = estimate(&here.join("logs/truth.yaml"));
    assert_eq!(parameter(&truth, "KT1").value, Some(2.393));
}

/// The true parameters of a simulation with a load are the parameters of the robot plus the parameters of the load. Both files of
/// true parameters contain the friction.
#[test]
fn the_truth_has_the_load_and_the_friction() {
    let here = folder("truth_loaded");
    let ur5 = tests::workspace().join("models/ur5.urdf").display().to_string();
    let docs = tests::workspace().join("docs/ur5");
    let (motion, tool) = (docs.join("motion.yaml").display().to_string(), docs.join("tool.yaml").display().to_string());
    rist(&here, &["simulate", &ur5, &motion, "--load", &tool, "--validation", "0", "--out", "logs"]).ended(0);
    let (bare, loaded) = (estimate(&here.join("logs/truth.yaml")), estimate(&here.join("logs/truth_loaded.yaml")));
    // A load of 2 kg at (0.02, 0, 0.12) m; the joint axis is z, so the first moment across the axis grows by 0.04 kg m.
    let value = |e: &Estimate, name: &str| parameter(e, name).value.unwrap_or_else(|| panic!("{name} has no value"));
    let grown = |name: &str| value(&loaded, name) - value(&bare, name);
    assert!((grown("MX_wrist_3").hypot(grown("MY_wrist_3")) - 0.04).abs() < 1e-9, "{}", grown("MX_wrist_3"));
    for name in bare.parameters.iter().map(|p| p.id.to_string()).filter(|n| n.starts_with('F')) {
        assert_eq!(grown(&name), 0.0, "{name}");
    }
    let friction = bare.parameters.iter().filter(|p| p.id.to_string().starts_with('F')).count();
    assert_eq!(friction, 4 * 6, "four of each joint");
    let coulomb = ["FSP_elbow", "FSN_elbow"].map(|name| value(&bare, name));
    assert!(coulomb[0] > 0.0 && coulomb[1] < 0.0, "{coulomb:?}");
}

/// With `--consistent`, parameters that are not identifiable are computed from a reference body. They must have no value in the
/// estimate.
#[test]
fn a_consistent_estimate_gives_no_value_to_what_is_not_identifiable() {
    let here = folder("consistent_open");
    let text = std::fs::read_to_string(test_robot_path("planar2r_vertical.yaml")).unwrap();
    std::fs::write(here.join("arm.yaml"), &text).unwrap();
    let robot = model("planar2r_vertical.yaml");
    let x = Random(53).physical_parameters(&robot);
    joint_log::write(&here.join("log.csv"), &robot, &x, &[1.0, 0.0], 0.01);
    let run = rist(&here, &["identify", "arm.yaml", "log.csv", "--consistent", "--out", "e.yaml"]);
    // One joint is at rest. So for no use all torques are determined, and the exit code is 1. The estimate is written
    // nevertheless.
    assert_eq!(run.code, Some(1), "{}", run.err);
    let found = estimate(&here.join("e.yaml"));
    let open = found.parameters.iter().filter(|p| p.status == Status::NotIdentifiable);
    let open: Vec<&Identified> = open.collect();
    assert!(!open.is_empty() && open.iter().all(|p| p.value.is_none()), "{open:?}");
}
