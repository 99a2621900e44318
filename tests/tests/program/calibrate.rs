//! Tests of `rist calibrate` as a program: files that it reads and writes, its exit codes, and its remedies as flags.

use std::path::Path;

use calibration::{Chain, Convention, MeasurementKind, Parameter, Placed, Posture, Problem, Unknowns, holding_torque};
use nalgebra::{Rotation3, UnitQuaternion, Vector3};
use random::Random;
use rist::Model;
use serde_json::Value;
use tests::program::{folder, rist, rist_done};

/// An arm of 20 kg in a vertical plane, with limits for experiments.
const ARM: &str = "\
convention: khalil-kleinfinger
name: heavy
gravity: [0, -9.81, 0]
links:
  - {link: 1, name: upper arm, antecedent: base, theta: q1, limits: {position: [-2, 2], velocity: 3, acceleration: 20}}
  - {link: 2, name: forearm, antecedent: 1, d: 0.5, theta: q2, limits: {position: [-2, 2], velocity: 3, acceleration: 20}}
  - {link: 3, name: hand, antecedent: 2, d: 0.4, theta: q3, limits: {position: [-2, 2], velocity: 3, acceleration: 20}}
standard_parameters:
  1: {XX: 0.02, XY: 0, XZ: 0, YY: 0.9, YZ: 0, ZZ: 0.9, MX: 2.5, MY: 0, MZ: 0, M: 10, IA: 0.1}
  2: {XX: 0.01, XY: 0, XZ: 0, YY: 0.35, YZ: 0, ZZ: 0.35, MX: 1.3, MY: 0, MZ: 0, M: 6.5, IA: 0.1}
  3: {XX: 0.01, XY: 0, XZ: 0, YY: 0.03, YZ: 0, ZZ: 0.03, MX: 0.2, MY: 0, MZ: 0, M: 3.5, IA: 0.05}
";
/// True compliances, rad/(N m).
const COMPLIANCES: [f64; 3] = [2e-5, 4e-5, 8e-5];
/// True zeros, rad.
const ZEROS: [f64; 3] = [0.0, 0.02, -0.015];
/// Noise of poses, m and rad.
const NOISE: f64 = 5e-5;

/// The poses that a tracker measures of the true arm under loads of 1 to 10 kg, as CSV. `bent`: whether the joints are
/// compliant; `scale`: factor of the measured lengths; `gear`: error of the gear scale of joint 3.
fn poses(bent: bool, scale: f64, gear: f64) -> String {
    let model = Model::parse(ARM, "heavy.yaml", &rist::ModelOptions::default()).unwrap();
    let torque = holding_torque(&model, None, "hand", [0.1, 0.0, 0.0]).unwrap();
    let tip = model.robot.link_ids().last().unwrap();
    let chain = Chain::new(&model.robot, tip, Convention::Dh).unwrap();
    let mut random = Random::new(77);
    let mut values = vec![0.0; chain.parameters.len()];
    for (value, parameter) in values.iter_mut().zip(&chain.parameters) {
        match parameter {
            Parameter::Zero { coordinate } => *value = ZEROS[*coordinate],
            Parameter::Compliance { coordinate } if bent => *value = COMPLIANCES[*coordinate],
            Parameter::Gear { coordinate: 2 } => *value = gear,
            _ => {}
        }
    }
    let problem = Problem::new(chain, MeasurementKind::Pose, vec![]);
    let base = Placed { rotation: Rotation3::new(Vector3::new(0.4, -0.7, 1.1)).into_inner(), ..Placed::identity() };
    let truth = Unknowns { base, points: vec![Vector3::new(0.1, 0.03, 0.0)], chain: values, ..problem.nominal() };
    let mut text = String::from("q1,q2,q3,x [mm],y [mm],z [mm],qx,qy,qz,qw,load\n");
    for _ in 0..60 {
        let q: Vec<f64> = (0..3).map(|_| random.between(-2.0, 2.0)).collect();
        let load = random.between(1.0, 10.0);
        let posture = Posture { line: 0, torque: torque(&q, load), q, points: vec![], rotation: None, distance: None };
        let pose = truth.base.then(&problem.chain.pose(&posture.q, &posture.torque, &truth.chain));
        let mut noise = || Vector3::from_fn(|_, _| NOISE * random.normal());
        let point = (pose.at(&truth.points[0]) + noise()) * (1e3 * scale);
        let turn = UnitQuaternion::from_matrix(&(Rotation3::new(noise()).into_inner() * pose.rotation));
        let row = posture.q.iter().chain(point.iter()).copied().chain([turn.i, turn.j, turn.k, turn.w, load]);
        text += &(row.map(|x| x.to_string()).collect::<Vec<_>>().join(",") + "\n");
    }
    text
}

fn json(path: &Path) -> Value {
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

/// Of a level (the result of one fit): the parameters whose names start with `word`, each with its value and the half width of
/// its interval.
fn parameters<'a>(level: &'a Value, word: &str) -> Vec<(&'a str, f64, f64)> {
    let all = level["parameters"].as_array().unwrap().iter();
    let one =
        |p: &'a Value| (p["name"].as_str().unwrap(), p["value"].as_f64().unwrap(), p["interval"].as_f64().unwrap());
    all.map(one).filter(|p| p.0.starts_with(word)).collect()
}

/// An arm is identified from simulated logs. The estimate gives the torques of the loads, with which compliances and zeros are
/// fitted to poses under loads. On postures that were not fitted, the error is at most a quarter of the error of a fit of zeros
/// alone.
#[test]
fn stiffness_is_found_with_an_estimate() {
    let here = folder("calibrate-stiffness");
    std::fs::write(here.join("arm.yaml"), ARM).unwrap();
    std::fs::write(here.join("poses.csv"), poses(true, 1.0, 0.0)).unwrap();
    std::fs::write(here.join("options.yaml"), "load_position: [0.1, 0, 0]\n").unwrap();
    rist_done(&here, "plan arm.yaml --starts 2 --experiments 5 --out plan.yaml");
    rist_done(&here, "simulate arm.yaml plan.yaml --validation 0 --out logs");
    rist_done(&here, "identify arm.yaml logs --plan plan.yaml --method rist --out estimate.yaml");
    let run = rist_done(
        &here,
        "calibrate arm.yaml poses.csv --what stiffness --estimate estimate.yaml --options options.yaml --out found.json \
         --write-zeros zeros.csv",
    );
    let found = json(&here.join("found.json"));
    let [zeros, stiff] = [1, 2].map(|k| &found["levels"][k]);
    assert_eq!((zeros["what"].as_str(), stiff["what"].as_str()), (Some("zeros"), Some("stiffness")));
    let error = |level: &Value| level["left_out"]["length"].as_f64().unwrap();
    assert!(error(stiff) <= 0.25 * error(zeros), "{}", run.out);
    let compliances = parameters(stiff, "compliance");
    assert_eq!(compliances.len(), 3, "{}", run.out);
    for ((name, value, interval), truth) in compliances.into_iter().zip(COMPLIANCES) {
        // Tolerance: twice the half width of the 95 % interval, plus 2 % for the error of the identified torques.
        assert!((value - truth).abs() < 2.0 * interval + 0.02 * truth, "{name} {value} {truth} {}", run.out);
        assert!(interval < 0.2 * truth, "{name} {interval}");
    }
    let fitted = parameters(stiff, "zero");
    for (name, value, interval) in &fitted {
        let truth = ZEROS[name.trim_start_matches("zero q").parse::<usize>().unwrap() - 1];
        assert!((value - truth).abs() < 2.0 * interval + 1e-5, "{name} {value} {truth} {}", run.out);
    }
    // The CSV of zeros has the same numbers as the JSON. A zero that is part of the base pose has empty cells.
    let table = std::fs::read_to_string(here.join("zeros.csv")).unwrap();
    let mut expected = String::from("joint,zero,interval,unit\n");
    for joint in ["q1", "q2", "q3"] {
        let of = fitted.iter().find(|p| p.0 == format!("zero {joint}"));
        expected += &of.map_or(format!("{joint},,,rad\n"), |(_, x, half)| format!("{joint},{x},{half},rad\n"));
    }
    assert!(table == expected && table.contains("q1,,,rad\n"), "{table}");
}

/// The JSON contains the fits, the claims and the verdict. A table with a fault gives exit code 1, and the printed remedy
/// corrects the fault.
#[test]
fn json_and_exit_code_follow_the_claims() {
    let here = folder("calibrate-json");
    std::fs::write(here.join("arm.yaml"), ARM).unwrap();
    std::fs::write(here.join("poses.csv"), poses(false, 1.0, 0.0)).unwrap();
    // The header says mm, but the lengths are multiplied by 1000 once more.
    std::fs::write(here.join("wrong.csv"), poses(false, 1e3, 0.0)).unwrap();
    let run = rist(&here, &["calibrate", "arm.yaml", "poses.csv", "--what", "zeros", "--json"]).ended(0);
    let found: Value = serde_json::from_str(&run.out).unwrap();
    assert_eq!(found["verdict"]["trust"], "yes", "{}", run.out);
    assert_eq!((found["postures"].as_u64(), found["tip"].as_str()), (Some(60), Some("hand")));
    assert_eq!(found["recommended"], "zeros");
    let claims = found["verdict"]["claims"].as_array().unwrap();
    let of = |topic: &str| claims.iter().filter(|c| c["topic"] == topic).collect::<Vec<_>>();
    let lengths = of("error of lengths on postures left out");
    let left_out = found["levels"][1]["left_out"]["length"].as_f64().unwrap();
    // `smallest` is the smallest error that the check would have detected. It is not the error that was found.
    assert!(lengths[0]["outcome"] == "agrees" && lengths[0]["smallest"]["value"].as_f64().unwrap() > 5e3 * left_out);
    assert_eq!(of("gear scale").len(), 3, "{}", run.out);

    // The poses are poses of the hand, and not of the upper arm.
    let other = ["calibrate", "arm.yaml", "poses.csv", "--what", "zeros", "--tip", "upper arm"];
    rist(&here, &other)
        .failed(1, &["the measured link is hand"])
        .told(1, &["name the link that was measured: --tip hand"]);

    let wrong = rist(&here, &["calibrate", "arm.yaml", "wrong.csv", "--what", "zeros"]);
    let wrong = wrong.failed(1, &["the measured lengths are in mm"]);
    assert!(wrong.out.contains("in the file of --options: corrections: {millimetres: true}"), "{}", wrong.out);
    std::fs::write(here.join("options.yaml"), "corrections: {millimetres: true}\n").unwrap();
    rist(&here, &["calibrate", "arm.yaml", "wrong.csv", "--what", "zeros", "--options", "options.yaml"])
        .told(0, &["trust: yes"]);
}

/// A wrong gear scale of a joint gives the verdict no, and the output names the flag that fits this scale. With the flag, the
/// verdict is yes, and the table contains the scale.
#[test]
fn a_wrong_scale_is_cured_by_its_flag() {
    let here = folder("calibrate-gear");
    std::fs::write(here.join("arm.yaml"), ARM).unwrap();
    std::fs::write(here.join("poses.csv"), poses(false, 1.0, 4e-3)).unwrap();
    let wrong =
        rist(&here, &["calibrate", "arm.yaml", "poses.csv"]).failed(1, &["the scale (gear ratio) is off: of q3"]);
    assert!(wrong.out.contains("fit the scales too: --gears q3"), "{}", wrong.out);
    let cured = "calibrate arm.yaml poses.csv --gears q3 --write-zeros zeros.csv";
    let cured = rist(&here, &cured.split(' ').collect::<Vec<_>>()).told(0, &["gear q3", "trust: yes"]);
    assert!(!cured.out.contains("is off"), "{}", cured.out);
    rist(&here, &["calibrate", "arm.yaml", "poses.csv", "--gears", "q2,q3"]).told(0, &["gear q2", "gear q3"]);
    let table = std::fs::read_to_string(here.join("zeros.csv")).unwrap();
    let row = table.lines().find(|line| line.starts_with("q3,")).unwrap().split(',').collect::<Vec<_>>();
    let [scale, interval] = [4, 5].map(|k: usize| row[k].parse::<f64>().unwrap());
    assert!((scale - 4e-3).abs() < 2.0 * interval && interval < 4e-4, "{table}");
}

/// Postures are chosen, measured and calibrated. The written description contains the calibrated table. A format of
/// descriptions that has no key for a parameter is refused.
#[test]
fn chosen_postures_are_measured_and_written_back() {
    let here = folder("calibrate-design");
    std::fs::write(here.join("arm.yaml"), ARM).unwrap();
    let run = rist_done(&here, "calibrate arm.yaml --what zeros --design 8 --out chosen.csv");
    assert!(run.out.contains("8 postures for") && run.out.contains("observability:  O1 "), "{}", run.out);
    let chosen = std::fs::read_to_string(here.join("chosen.csv")).unwrap();
    assert!(chosen.starts_with("q1,q2,q3\n") && chosen.lines().count() == 9, "{chosen}");
    let angles = chosen.lines().skip(1).flat_map(|line| line.split(','));
    assert!(angles.into_iter().all(|x| x.parse::<f64>().unwrap().abs() <= 2.0), "{chosen}");
    rist(&here, &["calibrate", "arm.yaml", "--design", "2"])
        .failed(2, &["2 postures do not determine", "base parameters"]);
    std::fs::write(here.join("poses.csv"), poses(false, 1.0, 0.0)).unwrap();
    rist(&here, &["calibrate", "arm.yaml", "poses.csv", "--design", "8"]).failed(2, &["leave the table out"]);
    rist_done(&here, "calibrate arm.yaml poses.csv --what zeros --write-yaml calibrated.yaml");
    let written = std::fs::read_to_string(here.join("calibrated.yaml")).unwrap();
    // The zeros of q1 and q3 are not in the description, because they are part of the poses of base and tool.
    assert!(written.contains("theta: q2 + 0.0200") && written.lines().count() == ARM.lines().count(), "{written}");
    // If the written description is calibrated again, the remaining zeros are zero up to a thousandth of their intervals.
    rist_done(&here, "calibrate calibrated.yaml poses.csv --angles as-given --what zeros --out again.json");
    for (name, value, interval) in parameters(&json(&here.join("again.json"))["levels"][1], "zero") {
        assert!(value.abs() < 1e-3 * interval, "{name} {value} {interval}");
    }
    rist(&here, &["calibrate", "arm.yaml", "poses.csv", "--write-ur", "k.yaml"]).failed(2, &["convert it first"]);
    let with_scale = ["calibrate", "arm.yaml", "poses.csv", "--gears", "q3", "--write-yaml", "c.yaml"];
    rist(&here, &with_scale).failed(2, &["no description has a scale for gear q3: the table of zeros has it"]);
}
