//! Logs as users record them, each with the options that it needs. The identification must give the true parameters of the robot.
//!
//! The files are modelled on logs that users published with questions. All are from one arm with three joints, and are in
//! `../shared`.

use std::path::PathBuf;

use identification::estimate::options::Options;
use linear_model::parameter::ParameterId;
use rist::{FrictionTerm, IdentifyRequest, Model, identify};

/// Log file, options, and largest relative residual of the torques.
const LOGS: [(&str, &str, f64); 19] = [
    ("good.csv.gz", "", 0.01),
    ("lbr.csv.gz", "", 0.01),
    ("kuka_trace.csv.gz", "columns: {time: Zeit, position: \"A{} Ist\", torque: \"A{} Moment\"}", 0.01),
    (
        "bag_lowstate",
        "columns: {position: \"motor_state[{}].q\", velocity: \"motor_state[{}].dq\", torque: \"motor_state[{}].tau_est\"}",
        0.01,
    ),
    (
        "bag_dynamic",
        "columns: {position: \"interface_values[{joint}].values[position]\", torque: \
         \"interface_values[{joint}].values[effort]\"}",
        0.01,
    ),
    ("lerobot_effort.parquet", LEROBOT, 0.01),
    ("lerobot_episodes.parquet", LEROBOT, 0.01),
    ("prefix.csv.gz", "", 0.01),
    ("bag_prefix", "", 0.01),
    ("bag_two", "", 0.01),
    ("unit_sym.csv.gz", "", 0.01),
    ("unit_row.csv.gz", "", 0.01),
    ("unit_deg.csv.gz", "", 0.01),
    ("unit_grad.csv.gz", "", 0.01),
    ("joint_n.csv.gz", "", 0.01),
    ("jitter.csv.gz", "", 0.01),
    ("held.csv.gz", "", 0.03),
    ("franka.csv.gz", "", 0.01),
    ("no_tau1.csv.gz", "columns: {prescribed: [j1]}", 0.01),
];

const LEROBOT: &str = "columns: {position: \"observation.state_{}\", velocity: \"observation.velocity_{}\", torque: \
                       \"observation.effort_{}\"}";

/// The error of a parameter exceeds this number of standard deviations only in one of a million cases.
const FAR_DEVIATIONS: f64 = 5.0;

/// The folder and the arm. If they do not exist, prints a message and returns `None`.
fn arm() -> Option<(PathBuf, Model)> {
    let field = tests::field()?;
    let model = Model::read(field.join("a0_arm.urdf")).unwrap();
    Some((field, model))
}

fn request(options: &str, friction: bool) -> IdentifyRequest {
    let mut request = IdentifyRequest::default();
    let mut options =
        Options::parse("options.yaml", &format!("{options}\nmodel: arm\n")).unwrap_or_else(|e| panic!("{e}"));
    if !friction {
        options.friction = Vec::<FrictionTerm>::new();
    }
    request.samples.rows.signals.options = Some(options);
    request
}

/// Identifies the parameters, and compares them with the description, which has the true values.
fn held_against_truth(model: &Model, file: &str, request: &IdentifyRequest, most: f64) {
    let path = tests::field().unwrap().join("logs").join(file);
    let names = &request.samples.rows.signals.options.as_ref().unwrap().columns;
    let (log, _) = model.open_log(&path, names).unwrap_or_else(|e| panic!("{file}: {e}"));
    let found = identify(model, &[log], request).unwrap_or_else(|e| panic!("{file}: {e}"));
    let described = found.described.unwrap();
    assert!(described < most, "{file}: {described}");
    let truth = found.described_parameters.as_ref().unwrap();
    let mut told = 0;
    for (value, truth) in found.estimate.parameters.iter().zip(truth) {
        assert!(matches!(value.id, ParameterId::Base(_)), "{file}");
        if let (Some(x), Some(sigma)) = (value.value, value.sigma) {
            told += 1;
            assert!((x - truth).abs() < FAR_DEVIATIONS * sigma, "{file}: {}: {x} +- {sigma}, {truth}", value.id);
        }
    }
    assert!(told + 1 >= truth.len(), "{file}: {told} of {}", truth.len());
}

#[test]
fn logs_of_the_field_give_the_robot_behind_them() {
    let Some((_, model)) = arm() else { return };
    for (file, options, most) in LOGS {
        held_against_truth(&model, file, &request(options, true), most);
    }
}

/// Nothing drives a free-floating base, so a log needs no torque columns for it. Columns of zeros for it are accepted.
#[test]
fn a_base_that_nothing_drives_is_told() {
    let Some((field, _)) = arm() else { return };
    let model = Model::read(field.join("ff.yaml")).unwrap();
    let free = "columns: {free: [base_x, base_y, base_z, base_yaw, base_pitch, base_roll]}";
    for file in ["freeflyer.csv.gz", "freeflyer_nobase.csv.gz"] {
        let request = request(free, false);
        held_against_truth(&model, file, &request, 0.02);
        let path = field.join("logs").join(file);
        let options = request.samples.rows.signals.options.as_ref().unwrap();
        let (log, _) = model.open_log(&path, &options.columns).unwrap();
        let log_check = rist::examine(&model, &[log], options).unwrap();
        assert!(log_check.findings.is_empty(), "{file}: {log_check}");
    }
}

/// The model has a column for a spring parallel to a joint. The stiffness of the spring and the parameters of the bodies are
/// identified.
#[test]
fn a_spring_of_the_field_is_told() {
    let Some((field, model)) = arm() else { return };
    let spring = "transmission: {elements: [{name: balancer, along: [[2, 1.0]], torques: [spring]}]}";
    let (log, _) = model.open_log(&field.join("logs/spring.csv.gz"), &Default::default()).unwrap();
    let found = identify(&model, std::slice::from_ref(&log), &request(spring, true)).unwrap();
    let stiffness = found.estimate.parameters.iter().find(|p| p.id.to_string() == "KE_balancer").unwrap();
    let (k, sigma) = (stiffness.value.unwrap(), stiffness.sigma.unwrap());
    // The spring has 12 N m/rad and is relaxed at 0.3 rad. Its torque at zero is a separate parameter.
    assert!((k - 12.0).abs() < FAR_DEVIATIONS * sigma && k > 20.0 * sigma, "{k} +- {sigma}");
    let truth = model.nominal_parameters().unwrap();
    for (p, truth) in found.estimate.parameters.iter().zip(&truth) {
        let (x, sigma) = (p.value.unwrap_or(*truth), p.sigma.unwrap_or(f64::INFINITY));
        assert!((x - truth).abs() < FAR_DEVIATIONS * sigma, "{}: {x} +- {sigma}, {truth}", p.id);
    }
    // Without the column of the spring, the estimate is not trusted.
    let without = identify(&model, &[log], &request("", true)).unwrap();
    assert!(without.estimate.total.unwrap() > 2.0 * found.estimate.total.unwrap());
}

/// The MJCF description of a geared arm has friction and armature (rotor inertia). With these columns, the residual is only
/// noise.
#[test]
fn friction_and_armature_of_an_mjcf_explain_the_log() {
    let Some((field, wrong)) = arm() else { return };
    let here = tests::program::folder("mjcf_of_the_field");
    let body = |name: &str, place: &str, axis: &str, armature: f64, inertial: &str, within: &str| {
        format!(
            "<body name=\"{name}\" pos=\"{place}\"><joint name=\"j{}\" axis=\"{axis}\" armature=\"{armature}\" damping=\"0.8\" \
             frictionloss=\"1.2\"/><inertial {inertial} fullinertia=\"0.02 0.03 0.025 0.001 0.002 0.0005\"/>{within}</body>",
            &name[1..]
        )
    };
    let l3 = body("l3", "0.4 0.02 0", "0 1 0", 0.3, "pos=\"0.15 0.01 0\" mass=\"0.8\"", "");
    let l2 = body("l2", "0.05 0 0.2", "0 1 0", 0.8, "pos=\"0.2 0 0.01\" mass=\"1.5\"", &l3);
    let l1 = body("l1", "0 0 0.1", "0 0 1", 0.8, "pos=\"0.1 0.02 0.05\" mass=\"2\"", &l2);
    let text = format!("<mujoco><compiler angle=\"radian\"/><worldbody>{l1}</worldbody></mujoco>");
    std::fs::write(here.join("arm.xml"), text).unwrap();
    let model = Model::read(here.join("arm.xml")).unwrap();
    held_against_truth(&model, "armature.csv.gz", &request("", true), 0.01);
    let (log, _) = wrong.open_log(&field.join("logs/armature.csv.gz"), &Default::default()).unwrap();
    let log_check = rist::examine(&wrong, &[log], request("", true).samples.rows.signals.options.as_ref().unwrap());
    assert!(log_check.is_ok());
}

#[test]
fn goals_of_a_data_set_are_proposed() {
    let Some((field, model)) = arm() else { return };
    let found = rist::propose_columns(&model.robot, &field.join("logs/lerobot_pos_only.parquet"), None, None).unwrap();
    let mapping = found.proposal.mapping.as_ref().unwrap_or_else(|| panic!("{found}")).to_string();
    assert!(mapping.contains("position: j1 <- observation.state_1 [deg]"), "{mapping}");
    assert!(mapping.contains("goal: j1 <- action_1 [rad]"), "{mapping}");
    // In this file, the column that may contain goals of servos (`action`) equals the measured positions except for rounding. So
    // it contains no goals, and the log is refused.
    let names = "columns: {position: \"observation.state_{}\", goal: \"action_{}\"}\nunits: {position: deg, goal: rad}";
    let names = request(names, true).samples.rows.signals.options.unwrap().columns;
    let refused = model.open_log(&field.join("logs/lerobot_pos_only.parquet"), &names).map(drop).unwrap_err();
    assert!(
        refused.to_string().contains("`action_1` is the position of its joint in every row, to 7.6e-5"),
        "{refused}"
    );
}

/// The program proposes options for a log. With these options, the log can be read.
#[test]
fn proposals_read_what_they_are_made_for() {
    let Some((field, model)) = arm() else { return };
    for (file, wanted) in [
        ("lbr.csv.gz", "time_stamp_sec [s] and time_stamp_nano_sec [ns]"),
        ("bag_lowstate", "j1 <- motor_state[0].q"),
        ("bag_dynamic", "j1 <- interface_values[j1].values[position]"),
        ("lerobot_episodes.parquet", "time: timestamp"),
        ("kuka_trace.csv.gz", "j1 <- A1 Ist"),
    ] {
        let found = rist::propose_columns(&model.robot, &field.join("logs").join(file), None, None).unwrap();
        let mapping = found.proposal.mapping.as_ref().unwrap_or_else(|| panic!("{file}: {found}"));
        assert!(mapping.to_string().contains(wanted), "{file}: {mapping}");
    }
}
