//! Decisions that `rist identify` makes itself and reports: rotor inertias of a URDF, delayed torques, velocity columns that are
//! unusable, a tilted base. For a correct log, it makes no such decision.

use identification::signals::signal_options::Velocity;
use linear_model::description_options::RotorInertias;
use linear_model::parameter::ParameterId;
use rist::fit::samples::Identification;
use rist::request::{IdentifyRequest, SamplesRequest};
use rist::{Model, ModelOptions};
use robot::{Inertial, StandardParameter};
use tests::faults::changed;
use tests::joint_log::{JointLog, described, swinging, unlike};
use tests::model_path;
use tests::program::folder;
use tests::random_situations::sensors::low_pass;

fn identified(name: &str, model: &Model, log: &JointLog, more: &str) -> Identification {
    let file = folder("default_path").join(format!("{name}.csv"));
    log.write_for(model, &file);
    if !more.is_empty() {
        let text = std::fs::read_to_string(&file).unwrap();
        // Adds the columns `more` to each row, with numbers that have no pattern.
        let row = |(i, line): (usize, &str)| match i {
            0 => format!("{line},{more}"),
            _ => more.split(',').enumerate().fold(line.to_string(), |line, (k, _)| {
                line + &format!(",{:.3}", 9.0 * ((i * (k + 3)) as f64 * 0.618).fract() - 4.5)
            }),
        };
        let lines: Vec<String> = text.lines().enumerate().map(row).collect();
        std::fs::write(&file, lines.join("\n") + "\n").unwrap();
    }
    let (source, _) = model.open_log(&file, &Default::default()).unwrap();
    rist::identify(model, &[source], &IdentifyRequest::default()).unwrap()
}

fn says(found: &Identification, words: &str) -> bool {
    found.estimate.remarks.iter().any(|remark| remark.contains(words))
}

/// The first words of the sentences that report a decision.
const DECISIONS: [&str; 5] = [
    "rotor inertias are among",
    "the torques come",
    "the velocity columns lag",
    "the acceleration columns of",
    "the base is taken as tilted",
];

#[test]
fn a_clean_log_changes_nothing() {
    let model = Model::read(model_path("ur5.urdf")).unwrap();
    let log = swinging(&model.robot, &unlike(&model.robot, 2), 1.2, 0.0);
    let found = identified("clean", &model, &log, "");
    assert!(found.model.is_none() && found.decided.delay.is_none());
    assert!(DECISIONS.iter().all(|words| !says(&found, words)), "{:?}", found.estimate.remarks);
}

#[test]
fn rotors_of_a_urdf_are_found_where_they_are_and_pinned_where_the_user_says_so() {
    let with = |rotor_inertia| {
        let options = ModelOptions { rotor_inertia, ..ModelOptions::default() };
        Model::read_with(model_path("ur5.urdf"), &options).unwrap()
    };
    let (geared, plain, pinned) =
        (with(Some(RotorInertias::Actuated)).robot, with(None), with(Some(RotorInertias::None)));
    let mut truth = described(&geared);
    for (x, p) in truth.iter_mut().zip(StandardParameter::all(&geared)) {
        if p.inertial == Inertial::Ia {
            *x = 0.4;
        }
    }
    let log = swinging(&geared, &truth, 1.2, 0.0);
    let found = identified("rotors", &plain, &log, "");
    assert!(says(&found, DECISIONS[0]) && found.model.is_some(), "{:?}", found.estimate.remarks);
    // The same description is given as a xacro file, and from standard input.
    let text = tests::model_text("ur5.urdf");
    for (name, path) in [("xacro", "ur5.xacro"), ("input", "-")] {
        let model = Model::parse(&text, path, &ModelOptions::default()).unwrap();
        assert!(identified(name, &model, &log, "").model.is_some(), "{path}");
    }
    let id: ParameterId = "IA_wrist_2".parse().unwrap();
    let rotor = found.estimate.parameters.iter().find(|p| p.id == id).unwrap();
    let (value, sigma) = (rotor.value.unwrap(), rotor.sigma.unwrap());
    assert!((value - 0.4).abs() < 4.0 * sigma && sigma < 0.05, "{value} +- {sigma}");
    assert!(identified("pinned", &pinned, &log, "").model.is_none());
}

#[test]
fn late_torques_are_taken_back() {
    let model = Model::read(model_path("ur5.urdf")).unwrap();
    let truth = unlike(&model.robot, 2);
    let late = swinging(&model.robot, &truth, 1.2, 0.02);
    let found = identified("late", &model, &late, "");
    assert!(says(&found, DECISIONS[1]), "{:?}", found.estimate.remarks);
    assert!(found.decided.delay.is_some_and(|d| (d.seconds - 0.02).abs() < 1e-3));
    // The user fixes the delay, so the program does not decide on it.
    let source = late.opened(&model, &folder("default_path_pinned").join("late.csv"));
    let mut samples = SamplesRequest::default();
    samples.rows.signals.delay = Some(rist::request::Delay::Seconds(0.0));
    let request = IdentifyRequest { samples, ..IdentifyRequest::default() };
    assert!(rist::identify(&model, &[source], &request).unwrap().decided.delay.is_none());
}

#[test]
fn rates_that_are_none_give_way_to_slopes() {
    let model = Model::read(model_path("ur5.urdf")).unwrap();
    let good = swinging(&model.robot, &unlike(&model.robot, 2), 1.2, 0.0);
    // The velocities are filtered by a first-order low-pass of 10 Hz, which delays them by 16 ms.
    let slow = changed(&good, |l| l.dq.iter_mut().for_each(|dq| *dq = low_pass(dq, 10.0, 500.0)));
    let found = identified("slow", &model, &slow, "");
    assert!(says(&found, DECISIONS[2]) && says(&found, "by 1"), "{:?}", found.estimate.remarks);
    let signal = &found.estimate.options.as_ref().unwrap().signal;
    assert_eq!((signal.velocity, signal.acceleration), (Velocity::Differentiated, Velocity::Differentiated));
    assert!(found.decided.delay.is_none() && found.estimate.total.unwrap() < 0.01, "{}", found.estimate.total.unwrap());

    let columns: Vec<String> = model.regressor().coordinates().iter().map(|name| format!("ddq_{name}")).collect();
    let found = identified("accelerations", &model, &good, &columns.join(","));
    assert!(says(&found, DECISIONS[3]), "{:?}", found.estimate.remarks);
    assert_eq!(found.estimate.options.as_ref().unwrap().signal.acceleration, Velocity::Differentiated);
    assert!(found.estimate.total.unwrap() < 0.01, "{}", found.estimate.total.unwrap());
}

/// An arm on a base that is tilted by two degrees about x and one degree about y. The program finds the tilt, unless the user
/// fixes the orientation of the base.
#[test]
fn a_tilted_base_is_taken_and_pinned_where_the_user_says_so() {
    let with = |base| {
        let options = ModelOptions { base, ..ModelOptions::default() };
        Model::read_with(model_path("ur5.urdf"), &options).unwrap()
    };
    let leans = [2.0_f64.to_radians(), 1.0_f64.to_radians(), 0.0];
    let tilted = with(Some(leans));
    let log = swinging(&tilted.robot, &unlike(&tilted.robot, 2), 1.2, 0.0);
    let found = identified("tilted", &with(None), &log, "");
    assert!(says(&found, DECISIONS[4]), "{:?}", found.estimate.remarks);
    assert!(
        found.decided.mended.iter().any(|claim| claim.to_string().contains("tilted")),
        "{:?}",
        found.decided.mended
    );
    let base = found.model.as_ref().and_then(|model| model.description.as_ref()?.base).unwrap();
    // A rotation about gravity has no effect on the torques. The log has no noise; the error is caused by the filtered friction
    // at reversals.
    assert!((0..2).all(|k| (base[k] - leans[k]).abs() < 2e-3), "{base:?}");
    assert!(found.estimate.total.unwrap() < 0.01, "{}", found.estimate.total.unwrap());
    assert!(identified("upright", &with(Some([0.0; 3])), &log, "").model.is_none());
}
