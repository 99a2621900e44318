//! Friction terms of single joints: the program chooses them for the right joint and stores them in the estimate. Terms that make
//! no sense are refused.

use std::path::Path;

use linear_model::friction::terms::{FrictionTerm, JointTerm};
use linear_model::parameter::{FrictionParameter, ParameterId};
use logs::LogSource;
use rist::Model;
use tests::joint_log::{Machine, swinging, unlike};
use tests::program::{estimate, folder, rist};
use tests::{has, model, model_path};

/// The joint whose friction depends on the load, counted from 0. `COEFFICIENT`: its coefficient.
const LOADED: usize = 1;
const COEFFICIENT: f64 = 0.1;

/// Writes a log of the UR5 with viscous and Coulomb friction in all joints, and load-dependent friction in one joint.
fn write(path: &Path, amplitude: f64) {
    let robot = model("ur5.urdf");
    let x = unlike(&robot, 5);
    let mut log = swinging(&robot, &x, amplitude, 0.0);
    let bare = Machine::exact(&robot, &x, &[amplitude; 6]).log();
    for ((tau, load), dq) in log.tau[LOADED].iter_mut().zip(&bare.tau[LOADED]).zip(&bare.dq[LOADED]) {
        *tau += COEFFICIENT * load.abs() * dq.signum();
    }
    let names: Vec<String> = robot.coordinates.iter().map(|c| c.name.clone()).collect();
    log.write(path, &names);
}

/// The term of load-dependent friction is chosen only for the joint that has it. With this term, the estimate file predicts
/// another motion better than with the same friction terms for all joints. A generated file and a URDF cannot store the term, so
/// they contain a note.
#[test]
fn friction_of_the_load_is_found_and_carried() {
    let here = folder("joint_friction");
    write(&here.join("fitted.csv"), 1.0);
    write(&here.join("other.csv"), 0.6);
    let urdf = model_path("ur5.urdf").display().to_string();
    let robot = Model::read(&urdf).unwrap();
    let other = LogSource::Held(
        logs::Log::read(&here.join("other.csv"), robot.regressor().coordinates(), &Default::default()).unwrap().0,
    );
    let of = |name: &str, more: &[&str]| {
        let run = rist(&here, &[&["identify", &urdf, "fitted.csv", "--out", name], more].concat());
        let estimate = estimate(&here.join(name));
        let predicted =
            rist::fit::validation::predictions(&robot, &estimate, None, std::slice::from_ref(&other)).unwrap();
        (run, estimate, predicted[0].residuals.total)
    };
    let (_, _, plain) = of("plain.yaml", &["--friction", "viscous,coulomb,offset"]);
    let load = FrictionTerm::At(LOADED + 1, JointTerm::Load);
    for (name, more) in [
        ("default.yaml", &[][..]),
        ("auto.yaml", &["--friction", "auto"]),
        ("bodies.yaml", &["--friction", "auto", "--consistent", "--write-urdf", "out.urdf", "--anyway"]),
    ] {
        let (run, estimate, found) = of(name, more);
        let terms = estimate.options.as_ref().unwrap().friction.clone();
        let is_load = |term: &&FrictionTerm| matches!(term, FrictionTerm::At(_, JointTerm::Load));
        assert_eq!(terms.iter().filter(is_load).collect::<Vec<_>>(), [&load], "{name}: {}", run.out);
        let id = ParameterId::friction(FrictionParameter::Load, &robot.regressor().coordinates()[LOADED]);
        let value = estimate.value(&id).unwrap();
        assert!((value - COEFFICIENT).abs() < 0.2 * COEFFICIENT, "{name}: {value}");
        assert!(found < 0.8 * plain, "{name}: {found} {plain}");
        if more.len() > 2 {
            assert!(
                format!("{}{}", run.out, run.err).contains(&format!("{id} are not in the file")),
                "{}{}",
                run.out,
                run.err
            );
        }
        let source = rist(&here, &["generate", &urdf, "--estimate", name]);
        has(&source.out, &["Not held here: ", &id.to_string()]);
    }
    // If the user requests the term for this joint, the first fit already contains it.
    let (_, _, by_hand) = of("by_hand.yaml", &["--friction", "viscous,coulomb,offset,load@2"]);
    assert!(by_hand < 0.8 * plain, "{by_hand} {plain}");
}

#[test]
fn terms_that_cannot_be_are_refused() {
    let here = folder("joint_friction_refused");
    write(&here.join("log.csv"), 1.0);
    let urdf = model_path("ur5.urdf").display().to_string();
    for (command, terms, said) in [
        ("identify", "viscous,load@9", "the robot has joints 1 to 6"),
        ("identify", "viscous,stribeck=0.1,stribeck=0.2@3", "a parameter of one name"),
        ("identify", "viscous,offset@3", "there is no friction term `offset` of a single joint"),
        ("accumulate", "viscous,load@2", "needs the torques that a first fit predicts"),
    ] {
        let run = rist(&here, &[command, &urdf, "log.csv", "--friction", terms, "--out", "x.tri"]);
        assert_ne!(run.code, Some(0), "{command} {terms}");
        assert!(run.err.contains(said), "{command} {terms}: {}", run.err);
    }
}

/// In this log, joint 4 moves by only 0.17 rad. With an additional friction term, the fit of this log would be better, but the
/// prediction of the other log would have an error of 100 %. Without the term, this error is 12 %.
#[test]
fn a_joint_that_hardly_moves_gets_no_term() {
    let Some(shared) = tests::shared() else { return };
    let data = shared.join("data/cobot6_shanghai");
    let model = Model::read(tests::workspace().join("tests/data/robots/cobot6.yaml")).unwrap();
    let open = |log: &str| model.open_log(&data.join(log), &Default::default()).unwrap().0;
    let mut found = rist::identify(&model, &[open("traj1.csv.gz")], &Default::default()).unwrap();
    let terms = found.estimate.options.clone().unwrap().friction;
    assert!(terms.iter().any(|term| matches!(term, FrictionTerm::At(_, _))), "{terms:?}");
    assert!(!terms.iter().any(|term| matches!(term, FrictionTerm::At(4, _))), "{terms:?}");
    let judged = found.verdict_of_logs(&model, &[open("traj2.csv.gz")], false).unwrap();
    let total = judged.predictions[0].1.total;
    assert!(total < 0.2, "{total}");
}
