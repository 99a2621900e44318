//! Tests of what drives do to a log: currents that give no torque, play behind the encoders, torques without friction. Each is
//! named with its size, and is not named in logs without it.

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

/// An arm of the field, and a log of it that is compressed in the folder of inputs. `None` if the inputs are absent.
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

/// All that an identification says of drives.
fn said((found, verdict): &(Identification, Verdict)) -> String {
    let why = verdict.claims.iter().filter_map(|claim| match claim.outcome() {
        Outcome::CannotTell { why, .. } => Some(why.clone()),
        Outcome::Contradicted { fault, .. } => Some(fault.clone()),
        _ => None,
    });
    [found.estimate.remarks.clone(), why.collect()].concat().join("\n")
}

/// A log of the UR5 with the torques as currents, of which the first `dead` A of each joint give no torque.
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

/// The dead currents of a UR5 come out, and so do the parameters. The option that is printed gives the same fit when it is given.
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
        // Where the torque of a joint has one sign, a dead current is an offset, and none is named.
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

/// Currents of a UR5 without dead current, and its torques: nothing of a drive is named.
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

/// A UR5 whose torques are measured behind the gears: a sentence says that friction is not in them. It is no fault.
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

/// A log of XM430 servos with 0.06 A of dead current. The second joint carries its weight in one direction only.
#[test]
fn dead_currents_of_the_field_are_named() {
    let Some((model, path)) = of_the_field("dxl_deadcurrent.csv.gz") else { return };
    let found = identified(&model, &path, Some(1.78), Options::default());
    let taken = found.0.estimate.options.as_ref().unwrap().transmission.dead_currents.clone().unwrap();
    // Noise changes the sign of small torques, which hides a part of a dead current.
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

/// Play of one degree in a log of the field is named at the joint whose torque changes its sign, with its width. Absolute torques
/// are named by the log check; in the good logs nothing is named.
#[test]
fn play_of_the_field_is_named() {
    let Some((model, path)) = of_the_field("backlash1deg.csv.gz") else { return };
    let found = said(&identified(&model, &path, None, Options::default()));
    let (_, width) = found.split_once("j1 has play of ").unwrap_or_else(|| panic!("{found}"));
    let width: f64 = width.split(' ').next().unwrap().parse().unwrap();
    // The gap of this log has soft ends, so its width is not sharp.
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
