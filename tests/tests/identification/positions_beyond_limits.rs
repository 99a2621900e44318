//! Tests of `rist doctor` for positions far beyond the limits of the description: a gripper that is logged as a share of its range
//! or in mm, beside joints in rad.

use std::path::Path;

use identification::estimate::log_check::finding::{Fault, Finding};
use identification::estimate::options::Options;
use rist::Model;
use tests::joint_log::{JointLog, Machine, unlike};
use tests::program::folder;

/// Limits of the finger, m.
const LOW: f64 = -0.02;
const HIGH: f64 = 0.025;

/// An arm with a finger of this mass, kg; its limits in the description, m.
fn arm(here: &Path, finger: f64, [low, high]: [f64; 2]) -> Model {
    let link = |name: &str, mass: f64, inertia: f64| {
        format!(
            "<link name=\"{name}\"><inertial><origin xyz=\"0.12 0.02 0.03\"/><mass value=\"{mass}\"/><inertia ixx=\"{inertia}\" \
             ixy=\"0\" ixz=\"0\" iyy=\"{inertia}\" iyz=\"0\" izz=\"{inertia}\"/></inertial></link>"
        )
    };
    let joint = |name: &str, kind: &str, links: [&str; 2], origin: &str, axis: &str, limits: [f64; 2]| {
        format!(
            "<joint name=\"{name}\" type=\"{kind}\"><parent link=\"{}\"/><child link=\"{}\"/><origin xyz=\"{origin}\"/><axis \
             xyz=\"{axis}\"/><limit lower=\"{}\" upper=\"{}\" effort=\"90\" velocity=\"3\"/></joint>",
            links[0], links[1], limits[0], limits[1]
        )
    };
    let text = [
        "<robot name=\"hand\"><link name=\"base\"/>".to_string(),
        link("l1", 2.0, 0.02),
        link("l2", 1.5, 0.02),
        link("l3", 0.5, 0.01),
        link("f", finger, 1e-3 * finger),
        joint("j1", "revolute", ["base", "l1"], "0 0 0.1", "0 0 1", [-2.0, 2.0]),
        joint("j2", "revolute", ["l1", "l2"], "0.05 0 0.2", "0 1 0", [-2.0, 2.0]),
        joint("j3", "revolute", ["l2", "l3"], "0.4 0.02 0", "0 1 0", [-2.0, 2.0]),
        joint("finger", "prismatic", ["l3", "f"], "0.3 0 0", "0 0 1", [low, high]),
        "</robot>".to_string(),
    ];
    std::fs::write(here.join("hand.urdf"), text.concat()).unwrap();
    Model::read(here.join("hand.urdf")).unwrap()
}

/// A log of the arm with other bodies than described, with the position of the finger in another form.
fn findings(here: &Path, model: &Model, form: impl Fn(f64) -> f64, options: &Options) -> Vec<Finding> {
    let bodies = unlike(&model.robot, 3);
    let friction = [0.4, 0.4, 0.2, 0.3];
    let amplitude = [1.2, 1.2, 1.2, 0.018];
    let exact = Machine::exact(&model.robot, &bodies, &amplitude);
    let mut log: JointLog = Machine { viscous: &friction, coulomb: &friction, noise: 0.02, ..exact }.log();
    log.q[3].iter_mut().for_each(|q| *q = form(*q));
    let slope = (form(HIGH) - form(LOW)) / (HIGH - LOW);
    log.dq[3].iter_mut().for_each(|dq| *dq *= slope);
    let path = here.join("log.csv");
    log.write(&path, model.regressor().coordinates());
    let (source, _) = model.open_log(&path, &options.columns).unwrap();
    rist::examine(model, &[source], options).unwrap().findings
}

#[test]
fn a_finger_in_another_form_is_named_and_its_remedy_holds() {
    let here = folder("finger_forms");
    let model = arm(&here, 1.5, [LOW, HIGH]);
    let share = |q: f64| (q - LOW) / (HIGH - LOW);
    type Form = (Fault, fn(f64) -> f64);
    let forms: [Form; 4] = [
        (Fault::Normalised(0, 1), |s| s),
        (Fault::Normalised(0, 100), |s| 100.0 * s),
        (Fault::Normalised(-100, 100), |s| 200.0 * s - 100.0),
        (Fault::Millimetres, |s| 1e3 * (LOW + s * (HIGH - LOW))),
    ];
    assert!(findings(&here, &model, |q| q, &Options::default()).is_empty());
    for (fault, form) in forms {
        let found = findings(&here, &model, |q| form(share(q)), &Options::default());
        let [only] = found.as_slice() else { panic!("{fault:?}: {found:#?}") };
        assert_eq!((only.fault, only.joints.join(" ")), (fault, "finger".into()), "{only}");
        let (_, yaml) = only.remedy.split_once("in the file of [options]: ").unwrap_or_else(|| panic!("{only}"));
        let obeyed = findings(&here, &model, |q| form(share(q)), &Options::parse("printed.yaml", yaml).unwrap());
        assert!(obeyed.is_empty(), "{fault:?}: {obeyed:#?}");
    }
}

/// A finger of a milligram leaves no trace in the torques, so the log does not show whether the limits or the positions are wrong.
#[test]
fn positions_beyond_the_limits_are_said_where_no_torque_shows_why() {
    let here = folder("beyond_limits");
    let light = arm(&here, 1e-6, [LOW, HIGH]);
    let share = |q: f64| (q - LOW) / (HIGH - LOW);
    let found = findings(&here, &light, share, &Options::default());
    let [only] = found.as_slice() else { panic!("{found:#?}") };
    assert!(matches!(only.fault, Fault::BeyondLimits(low, high) if low >= 0.0 && (0.5..1.0).contains(&high)), "{only}");
    assert!(!only.fault.is_gross() && only.to_string().contains("limits of -0.02 and 0.025 m"), "{only}");
    assert!(findings(&here, &light, |q| q, &Options::default()).is_empty());

    // The positions are right, and the description has narrow limits: the torques contradict all other forms.
    let narrow = arm(&here, 1.5, [0.0, 0.01]);
    let found = findings(&here, &narrow, |q| q, &Options::default());
    let [only] = found.as_slice() else { panic!("{found:#?}") };
    assert!(matches!(only.fault, Fault::BeyondLimits(..)), "{only}");
}

/// If the finger is light and has no friction, positions between 0 and 100 may be mm or a share of the range: both are said.
#[test]
fn two_forms_that_explain_a_log_alike_are_both_said() {
    let here = folder("finger_mm_or_share");
    let model = arm(&here, 0.05, [0.0, 0.1]);
    let shifted = |q: f64| 1e3 * (q + 0.05);
    let found = findings(&here, &model, shifted, &Options::default());
    let faults: Vec<(Fault, usize)> = found.iter().map(|f| (f.fault, f.instead)).collect();
    assert_eq!(faults, [(Fault::Normalised(0, 100), 0), (Fault::Millimetres, 1)], "{found:#?}");
    assert!(found[1].to_string().starts_with("or else the position of finger is in mm"), "{}", found[1]);
}
