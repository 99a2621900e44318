//! Tests that `rist identify` reports what a drive does to a log, with its size: dead current (the part of a current that gives
//! no torque), play behind the encoders, and torques that contain no friction. None of these is reported for a log without it.

use std::path::Path;

use claims::Outcome;
use identification::estimate::options::Options;
use linear_model::parameter::ParameterId;
use logs::NamePattern;
use rist::fit::verdict::Verdict;
use rist::{Gain, Identification, IdentifyRequest, Model, identify};
use tests::faults::changed;
use tests::joint_log::{JointLog, Machine, described, ur5};
use tests::program::folder;

/// Torque per current of each joint, N m/A.
const GAIN: f64 = 10.0;

/// A real arm, and a compressed log of this arm in the folder of inputs. `None` if the inputs are absent.
fn of_the_field(log: &str) -> Option<(Model, std::path::PathBuf)> {
    let folder = tests::shared()?.join("findings/inputs/field2");
    if !folder.is_dir() {
        println!("skipped: shared/findings is absent");
        return None;
    }
    Some((Model::read(folder.join("a0.urdf")).unwrap(), folder.join("logs").join(log)))
}

fn request(model: &Model, gain: Option<f64>, options: Options) -> IdentifyRequest {
    let mut request = IdentifyRequest::default();
    let names = model.regressor().coordinates();
    request.samples.gain = gain.iter().flat_map(|k| names.iter().map(|name| (name.clone(), Gain::Known(*k)))).collect();
    request.samples.rows.signals.options = Some(options);
    request
}

fn identified(model: &Model, path: &Path, gain: Option<f64>, options: Options) -> (Identification, Verdict) {
    let (log, _) = model.open_log(path, &options.columns).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let mut found = identify(model, &[log], &request(model, gain, options)).unwrap();
    let verdict = found.verdict_of_logs(model, &[], false).unwrap().verdict;
    (found, verdict)
}

/// All sentences of an identification about drives: the remarks of the estimate, and the reasons of its open and contradicted
/// claims.
fn said((found, verdict): &(Identification, Verdict)) -> String {
    let why = verdict.claims.iter().filter_map(|claim| match claim.outcome() {
        Outcome::CannotTell { why, .. } => Some(why.clone()),
        Outcome::Contradicted { fault, .. } => Some(fault.clone()),
        _ => None,
    });
    [found.estimate.remarks.clone(), why.collect()].concat().join("\n")
}

/// A log of the UR5 with currents in place of torques. In each joint, the first `dead` A of the current give no torque.
fn with_dead_currents(log: &JointLog, dead: &[f64]) -> JointLog {
    changed(log, |log| {
        for (tau, dead) in log.tau.iter_mut().zip(dead) {
            tau.iter_mut().for_each(|x| *x = *x / GAIN + dead * x.signum());
        }
    })
}

fn currents() -> Options {
    let mut options = Options::default();
    options.columns.current = Some(NamePattern::Pattern("tau_{joint}".into()));
    options
}

/// The dead currents of a UR5 are found, and the fit subtracts them. If the printed option is given, the next run has the same
/// fit and reports no dead current.
#[test]
fn dead_currents_are_named_and_taken_off() {
    let here = folder("dead_currents");
    let (model, good) = ur5();
    let names = model.regressor().coordinates();
    let path = here.join("log.csv");
    let dead = [0.3, 0.0, 0.3, 0.2, 0.0, 0.1];
    with_dead_currents(&good, &dead).write(&path, names);
    let options = currents();
    let found = identified(&model, &path, Some(GAIN), options.clone());
    let text = said(&found);
    assert!(text.contains("dead current, which gives no torque, is taken off"), "{text}");
    let taken = found.0.estimate.options.as_ref().unwrap().transmission.dead_currents.clone().unwrap();
    for (k, (taken, dead)) in taken.iter().zip(&dead).enumerate() {
        // If the torque of a joint never changes its sign, a dead current has the same effect as an offset of friction. So none
        // is reported.
        assert!(*taken == 0.0 || (taken - dead).abs() < 0.03, "{k}: {taken} A, {dead} A; {text}");
    }
    assert!(taken[2] > 0.0, "{taken:?}");
    let (_, yaml) = text.split_once("in the file of [options]: ").unwrap();
    let printed = Options::parse("printed.yaml", yaml.split(')').next().unwrap()).unwrap();
    let mut options = options;
    options.transmission.dead_currents = printed.transmission.dead_currents;
    let again = identified(&model, &path, Some(GAIN), options);
    assert!(!said(&again).contains("dead current"), "{}", said(&again));
    assert!((again.0.estimate.total.unwrap() / found.0.estimate.total.unwrap() - 1.0).abs() < 0.01);
}

/// Neither currents without dead current nor torques of a UR5 lead to a remark on drives.
#[test]
fn good_drives_are_not_named() {
    let here = folder("good_drives");
    let (model, good) = ur5();
    let path = here.join("log.csv");
    with_dead_currents(&good, &[0.0; 6]).write(&path, model.regressor().coordinates());
    let found = said(&identified(&model, &path, Some(GAIN), currents()));
    assert!(
        !found.contains("dead current") && !found.contains("play of") && !found.contains("not in this torque"),
        "{found}"
    );
    good.write(&path, model.regressor().coordinates());
    let found = said(&identified(&model, &path, None, Options::default()));
    assert!(!found.contains("play of") && !found.contains("not in this torque"), "{found}");
}

/// The torques of a UR5 are measured behind the gears. A remark says that they contain no friction. This is not a fault of the
/// log.
#[test]
fn torques_behind_the_gears_hold_no_friction() {
    let here = folder("behind_the_gears");
    let (model, _) = ur5();
    let parameters = described(&model.robot);
    let machine = Machine { noise: 0.02, ..Machine::exact(&model.robot, &parameters, &[0.8; 6]) };
    let path = here.join("log.csv");
    machine.log().write(&path, model.regressor().coordinates());
    let (found, verdict) = identified(&model, &path, None, Options::default());
    let text = found.estimate.remarks.join("\n");
    assert!(text.contains("friction is not in this torque: "), "{text}");
    assert!(verdict.claims.iter().all(|claim| !claim.is_contradicted()), "{verdict}");
}

/// A log of XM430 servos with 0.06 A of dead current. The torque of the second joint has one sign only, because of its weight.
#[test]
fn dead_currents_of_the_field_are_named() {
    let Some((model, path)) = of_the_field("dxl_deadcurrent.csv.gz") else { return };
    let found = identified(&model, &path, Some(1.78), Options::default());
    let taken = found.0.estimate.options.as_ref().unwrap().transmission.dead_currents.clone().unwrap();
    // Noise changes the sign of small torques. This hides a part of the dead current.
    for (k, wanted) in [(0, 0.06), (2, 0.06)] {
        assert!((taken[k] - wanted).abs() < 0.012, "{taken:?}");
    }
    let truth = found.0.described_parameters.as_ref().unwrap();
    for (value, truth) in found.0.estimate.parameters.iter().zip(truth) {
        assert!(matches!(value.id, ParameterId::Base(_)));
        let (x, sigma) = (value.value.unwrap(), value.sigma.unwrap());
        assert!((x - truth).abs() < 5.0 * sigma, "{}: {x} +- {sigma}, {truth}", value.id);
    }
}

/// In a real log with one degree of play, the joint whose torque changes its sign is reported, with the width of the play. The
/// log check reports a log that has absolute values of torques. For logs without these faults, nothing is reported.
#[test]
fn play_of_the_field_is_named() {
    let Some((model, path)) = of_the_field("backlash1deg.csv.gz") else { return };
    let found = said(&identified(&model, &path, None, Options::default()));
    let (_, width) = found.split_once("j1 has play of ").unwrap_or_else(|| panic!("{found}"));
    let width: f64 = width.split(' ').next().unwrap().parse().unwrap();
    // The play in this log has soft ends, so its width is not sharp.
    assert!((0.8..1.2).contains(&width), "{found}");
    for good in ["good.csv.gz", "good2.csv.gz", "good3.csv.gz", "stribeck_load.csv.gz", "reversed_j2.csv.gz"] {
        let (model, path) = of_the_field(good).unwrap();
        let found = said(&identified(&model, &path, None, Options::default()));
        assert!(!found.contains("play of") && !found.contains("not in this torque"), "{good}: {found}");
    }
    let (model, path) = of_the_field("abs_torque.csv.gz").unwrap();
    let (log, _) = model.open_log(&path, &Default::default()).unwrap();
    let found = rist::examine(&model, &[log], &Options::default()).unwrap();
    assert!(found.findings.iter().any(|f| f.to_string().contains("absolute values")), "{:?}", found.findings);
}
