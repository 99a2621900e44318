//! Claims about logs: a fault above the stated detection limit is named with its joint, and a correct log has no findings.

use claims::{Claim, EvidenceLevel, Outcome, Topic};
use identification::estimate::claims::hypotheses::Hypothesis;
use identification::estimate::topics::{MOUNT, SCALE, SPRING, ZERO};
use identification::estimators::weighted::Weights;
use rist::fit::verdict::{Trust, Verdict};
use rist::{Model, ModelOptions};
use robot::Robot;
use robot::value::Value;
use tests::faults::{changed, each};
use tests::joint_log::{JointLog, swinging, swinging_by, unlike};
use tests::model_path;
use tests::program::folder;

/// Amplitude of the joint motions, rad.
const AMPLITUDE: f64 = 1.2;

fn verdict(name: &str, model: &Model, log: &JointLog) -> Verdict {
    let source = log.opened(model, &folder("claims").join(format!("{name}.csv")));
    let mut found = rist::identify(model, &[source], &Default::default()).unwrap();
    found.verdict_of_logs(model, &[], false).unwrap().verdict
}

fn contradicted(verdict: &Verdict) -> Vec<&Claim> {
    verdict.claims.iter().filter(|claim| matches!(claim.outcome(), Outcome::Contradicted { .. })).collect()
}

/// The detection limit for a topic at a joint, from the claims; `None` if there is none.
fn power(verdict: &Verdict, topic: Topic, joint: &str) -> Option<f64> {
    let about =
        verdict.claims.iter().filter(|c| c.subject().topic == topic && c.subject().of.iter().any(|j| j == joint));
    let smallest = |claim: &Claim| match claim.outcome() {
        Outcome::Agrees { smallest } => Some(smallest.value),
        _ => None,
    };
    about.filter_map(smallest).reduce(f64::min)
}

fn tilted(robot: &Robot, by: f64) -> Robot {
    let mut turned = robot.clone();
    let [x, y, z] = robot.gravity_number();
    turned.gravity = [x, y * by.cos() - z * by.sin(), z * by.cos() + y * by.sin()].map(Value::Number);
    turned
}

#[test]
fn clean_logs_of_wrong_descriptions_are_accused_of_nothing() {
    for file in ["ur5.urdf", "puma560.yaml"] {
        let model = Model::read(model_path(file)).unwrap();
        for seed in 1..5 {
            let log = swinging(&model.robot, &unlike(&model.robot, seed), AMPLITUDE, 0.0);
            let found = verdict(&format!("clean{seed}{file}"), &model, &log);
            assert!(contradicted(&found).is_empty(), "{file} {seed}: {found}");
            assert!(found.trust != Trust::No, "{file} {seed}: {found}");
            // Joints 2 and 3 carry the arm. Their scale errors are detected from 10 % on. Their zero errors are detected from
            // some degrees on. The forearm of the Puma is excepted, because there another body would explain the log as well.
            for (k, joint) in model.regressor().coordinates().iter().enumerate().take(3).skip(1) {
                assert!(power(&found, SCALE, joint).is_some_and(|p| p <= 10.0), "{file} {seed} {joint}: {found}");
                let most = if file == "ur5.urdf" { 5.0 } else { 10.0 };
                if k == 1 || file == "ur5.urdf" {
                    assert!(power(&found, ZERO, joint).is_some_and(|p| p <= most), "{file} {seed} {joint}: {found}");
                }
            }
            for axis in ["x", "y"] {
                assert!(power(&found, MOUNT, axis).is_some_and(|p| p <= 5.0), "{file} {seed} {axis}: {found}");
            }
        }
    }
}

#[test]
fn a_fault_above_the_power_is_named_with_its_joint() {
    for file in ["ur5.urdf", "puma560.yaml"] {
        // Without this option, the program would accept a tilted base as an explanation.
        let upright = ModelOptions { base: Some([0.0; 3]), ..ModelOptions::default() };
        let model = Model::read_with(model_path(file), &upright).unwrap();
        let robot = &model.robot;
        let (names, truth) = (model.regressor().coordinates(), unlike(robot, 3));
        let good = swinging(robot, &truth, AMPLITUDE, 0.0);
        let heavy = |share: f64| share * good.tau[2].iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        let tilt = 8f64.to_radians();
        let spring = heavy(0.5);
        let off = if file == "ur5.urdf" { (2, 6.0) } else { (1, 12.0) };
        let zero = |l: &mut JointLog| each(&mut l.q[off.0..=off.0], |x| x - f64::to_radians(off.1));
        let faults: [(Topic, &str, f64, JointLog); 4] = [
            (ZERO, &names[off.0], off.1, changed(&good, zero)),
            // The torque of the third joint is 20 % too large, which is 17 % of the logged torque. A smaller scale error would
            // explain less than 1 % of the torque.
            (SCALE, &names[2], 18.0, changed(&good, |l| each(&mut l.tau[2..3], |x| 1.2 * x))),
            (
                SPRING,
                &names[2],
                spring,
                changed(&good, |l| l.tau[2].iter_mut().zip(&l.q[2]).for_each(|(tau, q)| *tau += spring * q)),
            ),
            (MOUNT, "x", 8.0, swinging(&tilted(robot, tilt), &truth, AMPLITUDE, 0.0)),
        ];
        for (topic, joint, size, log) in faults {
            let found = verdict(&format!("{}{file}", topic.0.replace(' ', "_")), &model, &log);
            let claims = contradicted(&found);
            let first = claims.first().unwrap_or_else(|| panic!("{file}: {topic:?} of {joint} is not named: {found}"));
            assert_eq!(first.subject().topic, topic, "{file}: {found}");
            assert!(first.subject().of.iter().any(|j| j == joint), "{file}: {topic:?} of {joint}: {found}");
            let Outcome::Contradicted { fault, .. } = first.outcome() else { unreachable!("it is contradicted") };
            let told: f64 = fault.split([' ', '~']).find_map(|w| w.parse().ok()).unwrap_or_else(|| panic!("{fault}"));
            // The size of the fault is estimated under the assumption that torques are linear in it. This is only approximately
            // true, so the tolerance is 15 %.
            assert!((told / size - 1.0).abs() < 0.15, "{file}: {fault}, true {size}");
            assert_eq!(found.trust, Trust::No, "{file}: {found}");
        }
    }
}

/// A scale error that explains less than 1 % of the torque is also named with its joint and size, but as an open claim.
#[test]
fn a_small_scale_is_named_with_its_joint() {
    for (file, factor) in [("ur5.urdf", 1.12), ("puma560.yaml", 1.15)] {
        let model = Model::read(model_path(file)).unwrap();
        let good = swinging(&model.robot, &unlike(&model.robot, 3), AMPLITUDE, 0.0);
        let log = changed(&good, |l| each(&mut l.tau[2..3], |x| factor * x));
        let found = verdict(&format!("small_scale{file}"), &model, &log);
        let joint = &model.regressor().coordinates()[2];
        let named = format!("the torque of {joint} is off by ");
        let is_open = |claim: &&Claim| claim.standing() == EvidenceLevel::Open && claim.to_string().contains(&named);
        let claim = found.claims.iter().find(is_open).unwrap_or_else(|| panic!("{file}: {found}")).to_string();
        let told: f64 = claim.split_once(&named).unwrap().1.split(' ').next().unwrap().parse().unwrap();
        let size = 100.0 * (1.0 - 1.0 / factor);
        // The size of the fault is estimated under the assumption that torques are linear in it. This is only approximately true,
        // so the tolerance is 15 %.
        assert!((told / size - 1.0).abs() < 0.15, "{file}: {claim}, true {size}");
        assert_eq!(found.trust, Trust::WithCare, "{file}: {found}");
    }
}

/// An arm is mounted on a wall or a ceiling, and its description is upright. The base orientation is the first finding. After it
/// is corrected in the description, nothing is contradicted. A large zero error is still named as a zero error.
#[test]
fn a_base_on_a_wall_or_a_ceiling_is_named_with_what_mends_it() {
    for file in ["ur5.urdf", "puma560.yaml"] {
        let model = Model::read(model_path(file)).unwrap();
        let (robot, truth) = (&model.robot, unlike(&model.robot, 4));
        for degrees in [90.0, 180.0] {
            let log = swinging(&tilted(robot, f64::to_radians(degrees)), &truth, AMPLITUDE, 0.0);
            let found = verdict(&format!("mount{degrees}{file}"), &model, &log);
            let claims = contradicted(&found);
            let Some(Outcome::Contradicted { fault, remedy, .. }) = claims.first().map(|claim| claim.outcome()) else {
                panic!("{file}: {degrees} degrees are not named: {found}");
            };
            assert_eq!(*fault, format!("the base is mounted otherwise: turned by {degrees:.0} degrees"), "{file}");
            let text = &remedy.sentence;
            let rpy = text.split_once("[base=").unwrap_or_else(|| panic!("{text}")).1.split_once(']').unwrap().0;
            let rpy: Vec<f64> = rpy.split(',').map(|angle| angle.parse().unwrap()).collect();
            let options = ModelOptions { base: rpy.try_into().ok(), ..Default::default() };
            let mended = Model::read_with(model_path(file), &options).unwrap();
            let found = verdict(&format!("mended{degrees}{file}"), &mended, &log);
            assert!(contradicted(&found).is_empty(), "{file}: {found}");
        }
        // A joint at rest gives no rows. The base orientation is determined by the other joints.
        let amplitude: Vec<f64> = (0..6).map(|k| if k < 5 { AMPLITUDE } else { 0.0 }).collect();
        let resting = swinging_by(&tilted(robot, f64::to_radians(180.0)), &truth, &amplitude, 0.0);
        let found = verdict(&format!("rest{file}"), &model, &resting);
        assert!(contradicted(&found).iter().any(|claim| claim.subject().topic == MOUNT), "{file}: {found}");
        let zero = |l: &mut JointLog| each(&mut l.q[1..2], |x| x - f64::to_radians(40.0));
        let log = changed(&swinging(robot, &truth, AMPLITUDE, 0.0), zero);
        let found = verdict(&format!("zero40{file}"), &model, &log);
        assert_eq!(contradicted(&found)[0].subject().topic, ZERO, "{file}: {found}");
    }
}

/// The robot has contact during some per cent of the log. Robust weights remove these rows. Then the standard deviations, the
/// detection limits of springs and the autocorrelation time of the residual are about the same as for the log without contact.
#[test]
fn contact_that_counts_nothing_leaves_deviations_as_they_are() {
    let model = Model::read(model_path("ur5.urdf")).unwrap();
    let clean = swinging(&model.robot, &unlike(&model.robot, 3), AMPLITUDE, 0.0);
    let rows = clean.t.len();
    let touching = changed(&clean, |l| {
        // The contact affects 3 % of the rows, in one interval.
        l.tau[1][rows / 2..rows / 2 + 3 * rows / 100].iter_mut().for_each(|tau| *tau += 60.0);
        l.tau[2][rows / 2..rows / 2 + 3 * rows / 100].iter_mut().for_each(|tau| *tau -= 40.0);
    });
    let identified = |name: &str, log: &JointLog, weights: Weights| {
        let source = log.opened(&model, &folder("contact").join(format!("{name}.csv")));
        let mut request = rist::IdentifyRequest::default();
        request.samples.rows.weights = Some(weights);
        rist::identify(&model, &[source], &request).unwrap()
    };
    let reference = identified("clean", &clean, Weights::Bisquare);
    let found = identified("touching", &touching, Weights::Bisquare);
    for (a, b) in found.estimate.parameters.iter().zip(&reference.estimate.parameters) {
        // The filter spreads the contact over neighbouring rows, and the rows of the contact are missing, so the standard
        // deviations differ by some per cent. Without robust weights they are up to a thousand times larger.
        let ratio = a.sigma.unwrap() / b.sigma.unwrap();
        assert!((0.5..2.0).contains(&ratio), "{}: {:?} {:?}", a.id, a.sigma, b.sigma);
    }
    for (a, b) in found.faults.iter().zip(&reference.faults) {
        let is_spring = matches!(a.of, Hypothesis::Spring(_));
        assert!(!is_spring || (a.power / b.power < 2.0), "{a:?} {b:?}");
    }
    for (a, b) in found.estimate.joints.iter().zip(&reference.estimate.joints) {
        let (a, b) = (a.memory.unwrap(), b.memory.unwrap());
        assert!(a < 2.0 * b, "{a} {b}");
    }
}
