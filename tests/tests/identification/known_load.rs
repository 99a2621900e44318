//! Tests of the drive gains from a known load (`--load`), and of simulation with an estimate as feedforward.

use std::path::Path;

use linear_model::known_load::KnownLoad;
use tests::joint_log::described;
use tests::program::{estimate, folder, rist, rist_done};
use tests::tape_robot::TapeRobot;
use tests::{model, model_text};

/// A load with the mass and inertia of the forearm is put on the forearm. It adds the same to each parameter as a URDF in which
/// mass and inertia of the forearm are doubled.
#[test]
fn a_load_adds_what_the_same_body_in_the_description_adds() {
    let arm = TapeRobot::new(model("ur5.urdf"));
    let text = model_text("ur5.urdf");
    let mut twice = text.replace(r#"<mass value="2.275"/>"#, r#"<mass value="4.55"/>"#);
    twice = twice.replace(r#"ixx="0.049443313556""#, r#"ixx="0.098886627112""#);
    twice = twice.replace(r#"iyy="0.049443313556""#, r#"iyy="0.098886627112""#);
    twice = twice.replace(r#"izz="0.004095""#, r#"izz="0.00819""#);
    let here = folder("twice_the_forearm");
    std::fs::write(here.join("twice.urdf"), twice).unwrap();
    let heavy = robot::format::read(&here.join("twice.urdf")).unwrap();
    let forearm = "link: forearm\nmass: 2.275\ncentre_of_mass: [-0.25, 0, 0.01615]\n\
                   inertia: {xx: 0.004095, yy: 0.049443313556, zz: 0.049443313556}\n";
    let load = KnownLoad::from_yaml("forearm.yaml", forearm).unwrap();
    let added = load.base_parameters(&arm.robot, &arm.map()).unwrap();
    let (light, heavy) = (&arm.truth, arm.base.values(&described(&heavy)));
    assert!(added.iter().filter(|x| x.abs() > 1e-3).count() > 5, "{added:?}");
    for (k, x) in added.iter().enumerate() {
        // The URDF has the quarter turn (pi/2) with only eleven decimals.
        assert!((x - (heavy[k] - light[k])).abs() < 1e-10, "{k}: {x} {}", heavy[k] - light[k]);
    }
}

/// A load on a frame that is fixed to a link adds the same parameters as a load on that link. A load on a frame without a moving
/// link, or on an unknown frame, is refused; the message names the frame.
#[test]
fn a_load_on_a_fixed_frame_is_one_on_its_link() {
    let text = model_text("ur5.urdf");
    let turned = text
        .replace(r#"<origin xyz="0 0 0.0823" rpy="0 0 0"/>"#, r#"<origin xyz="0 0 0.0823" rpy="-1.57079632679 0 0"/>"#);
    assert_ne!(text, turned);
    let arm = TapeRobot::new(robot::format::read_urdf(&turned, "ur5.urdf").unwrap());
    let map = arm.map();
    let added = |text: &str| KnownLoad::from_yaml("load.yaml", text).unwrap().base_parameters(&arm.robot, &map);
    // tool0 is 0.0823 m along z of wrist_3 and is rotated by a quarter turn about x: its z axis is y of wrist_3, its y axis is
    // -z.
    let on_tool = "link: tool0\nmass: 2\ncentre_of_mass: [0.01, 0.02, 0.05]\ninertia: {xx: 0.003, yy: 0.004, zz: 0.005, xy: 0.001}\n";
    let on_link = "link: wrist_3\nmass: 2\ncentre_of_mass: [0.01, 0.05, 0.0623]\ninertia: {xx: 0.003, yy: 0.005, zz: 0.004, xz: -0.001}\n";
    let (tool, link) = (added(on_tool).unwrap(), added(on_link).unwrap());
    assert!(link.iter().filter(|x| x.abs() > 1e-3).count() > 5, "{link:?}");
    for (a, b) in tool.iter().zip(&link) {
        // The URDF has the quarter turn (pi/2) with only eleven decimals.
        assert!((a - b).abs() < 1e-10, "{tool:?} {link:?}");
    }
    for name in ["base", "tool9"] {
        let refused = added(&on_tool.replace("tool0", name)).unwrap_err();
        assert!(refused.contains(&format!("`{name}`")) && refused.contains("wrist_3, tool0"), "{refused}");
    }
}

const ARM: &str = "\
convention: khalil-kleinfinger
name: arm
rotor_inertia: none
symbols: {D3: 0.25}
links:
  - {link: 1, name: column, antecedent: base, theta: q1, drive_gain: 2.393}
  - {link: 2, name: upper arm, antecedent: 1, alpha: pi/2, theta: q2, drive_gain: 0.87}
  - {link: 3, name: forearm, antecedent: 2, d: D3, theta: q3, drive_gain: 1}
standard_parameters:
  1: {XX: 0.14, XY: 0, XZ: 0, YY: 0.14, YZ: 0, ZZ: 0.134, MX: 0, MY: 0, MZ: -0.4, M: 4}
  2: {XX: 0.004, XY: -0.0007, XZ: -0.004, YY: 0.0224, YZ: 0, ZZ: 0.0231, MX: 0.1, MY: 0.012, MZ: 0.03, M: 1}
  3: {XX: 0.0048, XY: 0.0026, XZ: 0.0063, YY: 0.0615, YZ: 0.0008, ZZ: 0.0628, MX: 0.24, MY: -0.018, MZ: -0.024, M: 1.2}
";

fn run(here: &Path, arguments: &str) -> String {
    rist_done(here, arguments).out
}

/// Largest absolute difference between the joint positions of a log and of its desired motion, over all rows and the first
/// `joints` joints.
fn tracking(log: &Path, motion: &Path, joints: usize) -> f64 {
    let rows = |path: &Path| -> Vec<Vec<f64>> {
        let text = std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        text.lines().skip(1).map(|l| l.split(',').map(|x| x.parse().unwrap()).collect()).collect()
    };
    let (log, motion) = (rows(log), rows(motion));
    assert_eq!(log.len(), motion.len());
    let distance = |(a, b): (&Vec<f64>, &Vec<f64>)| (1..=joints).map(|k| (a[k] - b[k]).abs()).fold(0.0, f64::max);
    log.iter().zip(&motion).map(distance).fold(0.0, f64::max)
}

#[test]
fn a_load_on_the_forearm_gives_all_gains_and_the_estimate_feeds_forward() {
    let here = folder("known_load");
    std::fs::write(here.join("arm.yaml"), ARM).unwrap();
    std::fs::write(here.join("load.yaml"), "link: forearm\nmass: 0.5\ncentre_of_mass: [0.35, 0.02, 0.03]\n").unwrap();
    run(&here, "plan arm.yaml --out plan.yaml --starts 2 --trajectories motions");
    run(&here, "simulate arm.yaml plan.yaml --out logs --validation 0 --load load.yaml");
    let out =
        run(&here, "identify arm.yaml logs --plan plan.yaml --method rist-mh --load load.yaml --out estimate.yaml");
    assert!(out.contains("all of it stands on the known load of 8 of 16 experiments"), "{out}");
    let both = estimate(&here.join("estimate.yaml"));
    for (name, truth) in [("KT1", 2.393), ("KT2", 0.87), ("KT3", 1.0), ("MX3", 0.24)] {
        let found = both.parameters.iter().find(|p| p.id.to_string() == name).unwrap();
        let (value, sigma) = (found.value.unwrap(), found.sigma.unwrap());
        assert!((value - truth).abs() < 4.0 * sigma && sigma < 0.005 * truth, "{name}: {value} +- {sigma}");
    }
    // The rows of the method `rist` (the method of the paper) contain some friction, and the intervals do not include the error
    // that this friction causes.
    let run_of = |method: &str| {
        run(&here, &format!("identify arm.yaml logs --plan plan.yaml --method {method} --load load.yaml"))
    };
    let narrow = "too narrow where a load gives the gains: --method rist-mh";
    let paper = run_of("rist").split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(paper.contains("trust: with care") && paper.contains(narrow), "{paper}");
    assert!(!run_of("rist-mh").contains("too narrow"));
    // If all gains are given, the torque of the known load is subtracted from the measured torques.
    let given = "--gain q1=2.393,q2=0.87,q3=1 --load load.yaml --out given.yaml";
    for method in ["rist", "rist-mh"] {
        run(&here, &format!("identify arm.yaml logs --plan plan.yaml --method {method} {given}"));
        let found = estimate(&here.join("given.yaml")).value(&"MX3".parse().unwrap()).unwrap();
        // The true value is 0.24 kg m. If the load were not subtracted, the result would be larger by the first moment of the
        // load, 0.175 kg m. The rows of the paper contain some friction, so the tolerance is not smaller.
        assert!((found - 0.24).abs() < 0.002, "{method}: {found}");
    }
    // Without the load, and without the gains of q1 and q2 in the model file, only the gain of q3 determines the scale.
    std::fs::write(here.join("silent.yaml"), ARM.replace(", drive_gain: 2.393", "").replace(", drive_gain: 0.87", ""))
        .unwrap();
    let one = run(&here, "identify silent.yaml logs --plan plan.yaml --method rist-mh");
    assert!(one.contains("all of it stands on the gain of q3, 1 N m/A"), "{one}");
    rist(&here, &["identify", "arm.yaml", "logs/e01.csv", "--load", "load.yaml"])
        .failed(2, &["--load: --method ls does not use that"]);

    // The joints of this arm are coupled, and its controllers already compensate for the coupling. So feedforward from the
    // estimate is as good as no feedforward.
    let (alone, fed) = without_and_with(&here, "arm.yaml", 3);
    assert!(fed < 1.05 * alone, "{fed} {alone}");
}

/// Largest position error in the first motion of the plan, rad: without feedforward, and with feedforward from the estimate.
fn without_and_with(here: &Path, model: &str, joints: usize) -> (f64, f64) {
    let simulated = |out: &str, more: &str| {
        run(here, &format!("simulate {model} plan.yaml --out {out} --validation 0 --noise-free {more}"));
        tracking(&here.join(out).join("e01.csv"), &here.join("motions/e01.csv"), joints)
    };
    (simulated("alone", ""), simulated("fed", "--feedforward estimate.yaml"))
}

#[test]
fn a_controller_that_is_fed_an_estimate_follows_better() {
    let here = folder("fed");
    std::fs::copy(tests::model_path("planar2r_vertical.yaml"), here.join("planar.yaml")).unwrap();
    run(&here, "plan planar.yaml --out plan.yaml --starts 2 --trajectories motions");
    run(&here, "simulate planar.yaml plan.yaml --out logs --validation 0");
    run(&here, "identify planar.yaml logs --plan plan.yaml --method rist-mh --out estimate.yaml");
    let (alone, fed) = without_and_with(&here, "planar.yaml", 2);
    // With feedforward, the remaining error comes from friction and from the corners of the motion.
    assert!(fed < 0.5 * alone, "{fed} {alone}");
}
