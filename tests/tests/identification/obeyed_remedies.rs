//! Tests that the remedy of a finding, applied exactly as it is printed, gives a log check without findings.

use std::f64::consts::PI;
use std::path::Path;

use claims::Outcome;
use identification::estimate::log_check::LogCheck;
use identification::estimate::log_check::finding::{Fault, Finding};
use identification::estimate::options::Options;
use identification::estimate::verdict::Trust;
use rist::Model;
use rist::fit::verdict::Verdict;
use rist::request::IdentifyRequest;
use robot::{Inertial, Robot, StandardParameter};
use tests::faults::{changed, each, mirrored};
use tests::joint_log::{JointLog, swinging, unlike, ur5};
use tests::program::folder;

fn look(model: &Model, path: &Path, options: &Options) -> LogCheck {
    let (source, _) = model.open_log(path, &options.columns).unwrap();
    rist::examine(model, &[source], options).unwrap()
}

/// The options that the first finding of a log check prints as its remedy.
fn printed(log_check: &LogCheck) -> Options {
    let remedy = &log_check.findings[0].remedy;
    let (_, yaml) = remedy.split_once("in the file of [options]: ").unwrap_or_else(|| panic!("{remedy}"));
    Options::parse("printed.yaml", yaml).unwrap()
}

/// (name, change of a good log, phrases that the finding must contain).
type Mistake = (&'static str, fn(&mut JointLog), &'static [&'static str]);

const MISTAKES: [Mistake; 12] = [
    ("a quarter", |l| each(&mut l.tau[1..2], |x| 0.25 * x), &["the torque of shoulder_lift is off by -"]),
    ("half", |l| each(&mut l.tau[2..3], |x| 0.5 * x), &["the torque of elbow is off by -"]),
    ("four times", |l| each(&mut l.tau[0..1], |x| 4.0 * x), &["the torque of shoulder_pan is off by "]),
    (
        "two scales",
        |l| {
            each(&mut l.tau[1..2], |x| 0.4 * x);
            each(&mut l.tau[3..4], |x| 3.0 * x);
        },
        &["the torque of shoulder_lift is off by -", "the torque of wrist_1 is off by "],
    ),
    ("torques", |l| l.tau.swap(1, 2), &["the torque columns of shoulder_lift and elbow are swapped"]),
    ("a zero", |l| each(&mut l.q[2..3], |x| x + PI), &["the zero of elbow is off by 180 degrees"]),
    ("degrees", |l| [&mut l.q, &mut l.dq].into_iter().for_each(|x| each(x, f64::to_degrees)), &["in degrees"]),
    ("a unit", |l| each(&mut l.tau, |x| 1e3 * x), &["another unit: 10^3"]),
    ("all signs", |l| each(&mut l.tau, |x| -x), &["the torques of all joints have the wrong sign"]),
    (
        "sign and zero",
        |l| {
            each(&mut l.tau[1..2], |x| -x);
            each(&mut l.q[2..3], |x| x + 0.5 * PI);
        },
        &["the torque of shoulder_lift has the wrong sign", "the zero of elbow is off by -90 degrees"],
    ),
    (
        "shares of ranges",
        |l| l.q.iter_mut().chain(&mut l.dq).flatten().for_each(|x| *x *= 100.0 / (2.0 * PI)),
        &["-100 to 100 of the range"],
    ),
    (
        "shares of ranges from zero",
        |l| {
            each(&mut l.q, |q| (q + 2.0 * PI) * 25.0 / PI);
            each(&mut l.dq, |x| x * 25.0 / PI);
        },
        &["normalised: 0 to 100 of the range"],
    ),
];

/// For each mistake, the first finding names it, and its remedy is valid as options. With these options no finding remains.
#[test]
fn what_a_finding_prints_mends_the_log() {
    let here = folder("obeyed");
    let (model, good) = ur5();
    for (name, change, words) in MISTAKES {
        let path = here.join("log.csv");
        changed(&good, change).write(&path, model.regressor().coordinates());
        let found = look(&model, &path, &Options::default());
        let said: Vec<String> = found.findings.iter().map(ToString::to_string).collect();
        for wanted in words {
            let has = |said: &String| said.contains(wanted) && !said.starts_with("or else");
            assert!(said.iter().any(has), "{name}: {wanted}: {said:#?}");
        }
        let main = found.findings.iter().filter(|f| f.instead == 0);
        assert_eq!(main.clone().count(), words.len(), "{name}: {said:#?}");
        assert!(main.clone().all(|f| f.tried.is_some_and(|[before, after]| after < before)), "{name}: {said:#?}");
        let again = look(&model, &path, &printed(&found));
        assert!(again.findings.is_empty(), "{name}: {:?}", again.findings);
    }
}

/// The found torque scale is the scale of the log. It is right within 3 %, although the nominal bodies are wrong by 15 %.
#[test]
fn a_scale_is_right_to_a_few_hundredths() {
    let here = folder("scales_of_logs");
    let (model, good) = ur5();
    for (joint, factor) in [(0, 0.25), (1, 4.0), (2, 0.4), (3, 2.5)] {
        let path = here.join("log.csv");
        changed(&good, |l| each(&mut l.tau[joint..=joint], |x| factor * x))
            .write(&path, model.regressor().coordinates());
        let scales = printed(&look(&model, &path, &Options::default())).transmission.scales.unwrap();
        for (k, scale) in scales.iter().enumerate() {
            let wanted = if k == joint { factor } else { 1.0 };
            // The search for the scale stops within 1 %; noise and effects that the model lacks change the scale by about as
            // much.
            assert!((scale / wanted - 1.0).abs() < 0.03, "{joint}: {scales:?}, {factor}");
        }
    }
}

/// A remedy repeats the options that are already set, so the printed lists can replace those in the options file.
#[test]
fn a_remedy_goes_on_from_the_options() {
    let here = folder("remedy_beside_options");
    let (model, good) = ur5();
    let path = here.join("log.csv");
    let wrong = changed(&mirrored(&good, 1, false, true), |l| each(&mut l.q[4..5], |x| x - 0.25));
    wrong.write(&path, model.regressor().coordinates());
    let options = Options::parse("o.yaml", "transmission: {offsets: [0, 0, 0, 0, 0.25, 0]}").unwrap();
    let found = look(&model, &path, &options);
    let columns = printed(&found).columns;
    let again = look(&model, &path, &Options { columns, ..options });
    assert!(again.findings.is_empty(), "{:?}", again.findings);
}

fn verdict(model: &Model, path: &Path) -> Verdict {
    let (source, _) = model.open_log(path, &Default::default()).unwrap();
    let mut found = rist::identify(model, &[source], &IdentifyRequest::default()).unwrap();
    found.verdict_of_logs(model, &[], false).unwrap().verdict
}

/// A contact force of one second at the elbow is reported with its times. The log without it has no such finding.
#[test]
fn a_contact_is_named_with_its_times() {
    let here = folder("contact");
    let (model, good) = ur5();
    let push = |log: &mut JointLog| {
        for (r, t) in log.t.iter().enumerate().filter(|(_, t)| (4.0..5.0).contains(*t)) {
            log.tau[2][r] += 12.0 * (PI * (t - 4.0)).sin();
        }
    };
    let reasons = |log: &JointLog| {
        let path = here.join("log.csv");
        log.write(&path, model.regressor().coordinates());
        let verdict = verdict(&model, &path);
        let open = |outcome: &Outcome| match outcome {
            Outcome::CannotTell { why, .. } => Some(why.clone()),
            _ => None,
        };
        verdict.claims.iter().filter_map(|claim| open(claim.outcome())).collect::<Vec<_>>()
    };
    let said = reasons(&changed(&good, push));
    let named = said.iter().find(|why| why.contains("stands out from")).unwrap_or_else(|| panic!("{said:#?}"));
    assert!(named.starts_with("the residual of elbow stands out from 4."), "{named}");
    assert!(!said.iter().any(|why| why.contains("too short or too poor")), "{said:#?}");
    let said = reasons(&good);
    assert!(!said.iter().any(|why| why.contains("stands out")), "{said:#?}");
}

/// The parameters `bodies` with a point mass of `mass` kg added to the last link, 0.1 m along its z axis.
fn loaded(robot: &Robot, bodies: &[f64], mass: f64) -> Vec<f64> {
    let last = robot.links.len() - 1;
    let of_point = |parameter: &StandardParameter| match parameter.inertial {
        _ if parameter.link.0 != last => 0.0,
        Inertial::Xx | Inertial::Yy => 0.01 * mass,
        Inertial::Mz => 0.1 * mass,
        Inertial::M => mass,
        _ => 0.0,
    };
    bodies.iter().zip(StandardParameter::all(robot)).map(|(x, parameter)| x + of_point(&parameter)).collect()
}

/// A log of a UR5 that picks up 2 kg at 4 s. It puts the load down at 7.5 s if `puts_down`, otherwise it keeps it.
fn picking_up(model: &Model, puts_down: bool) -> JointLog {
    let bodies = unlike(&model.robot, 5);
    let loaded = loaded(&model.robot, &bodies, 2.0);
    let [mut log, with] = [bodies, loaded].map(|x| swinging(&model.robot, &x, 1.2, 0.0));
    for (r, _) in log.t.iter().enumerate().filter(|(_, t)| **t >= 4.0 && (**t < 7.5 || !puts_down)) {
        log.tau.iter_mut().zip(&with.tau).for_each(|(tau, with)| tau[r] = with[r]);
    }
    log
}

/// A load that is picked up is reported with its times and its mass. The motion is not called poor. A contact force and drifting
/// torques are not reported as a load.
#[test]
fn a_load_that_is_picked_up_is_named_with_its_times() {
    let here = folder("picked_up");
    let (model, good) = ur5();
    let path = here.join("log.csv");
    let look = |log: &JointLog| {
        log.write(&path, model.regressor().coordinates());
        look(&model, &path, &Options::default())
    };
    for puts_down in [false, true] {
        let found = look(&picking_up(&model, puts_down));
        let [Finding { fault: Fault::ChangedLoad { log: None, from, to, mass }, .. }] = found.findings[..] else {
            panic!("{:?}", found.findings)
        };
        // The times of the load are searched in steps of 1 % of the ten seconds; the tolerance is two steps.
        assert!((from.unwrap() - 4.0).abs() < 0.2 && to.is_some() == puts_down, "{from:?} {to:?}");
        assert!(to.is_none_or(|to| (to - 7.5).abs() < 0.2), "{to:?}");
        // The times are known to 2 % of the interval with the load, which limits the accuracy of the mass.
        assert!((mass.unwrap() - 2.0).abs() < 0.1, "{mass:?}");
        let again =
            rist::examine(&model, &[model.open_log(&path, &Default::default()).unwrap().0], &printed(&found)).unwrap();
        assert!(again.findings.is_empty(), "{:?}", again.findings);
        let verdict = verdict(&model, &path);
        assert_eq!(verdict.trust, Trust::No);
        assert!(verdict.reasons[0].contains("carries another load from"), "{:?}", verdict.reasons);
        assert!(!verdict.reasons.iter().any(|why| why.contains("too short or too poor")), "{:?}", verdict.reasons);
    }
    // If there are two logs, the finding names the log with the load.
    let paths = ["log.csv", "good.csv"].map(|name| here.join(name));
    good.write(&paths[1], model.regressor().coordinates());
    let both = [&paths[1], &paths[0]].map(|path| model.open_log(path, &Default::default()).unwrap().0);
    let found = rist::examine(&model, &both, &Options::default()).unwrap();
    let said: Vec<String> = found.findings.iter().map(ToString::to_string).collect();
    assert!(said.iter().any(|said| said.contains(" in log 2, about ")), "{said:?}");
    let push = changed(&good, |log| {
        for (r, _) in log.t.iter().enumerate().filter(|(_, t)| (4.0..5.0).contains(*t)) {
            log.tau[2][r] += 12.0;
        }
    });
    let end = good.t[good.t.len() - 1];
    let drifting =
        changed(&good, |log| log.tau[1].iter_mut().zip(&log.t).for_each(|(tau, t)| *tau *= 1.0 + 0.4 * t / end));
    for log in [good, push, drifting] {
        assert!(!look(&log).has_changed_load());
    }
}

/// The program proposes a time window without the load, but only if the parameters fitted in this window give a small residual.
/// Here, a torque that no parameters explain acts before the load is picked up. So no window is proposed.
#[test]
fn a_window_that_explains_nothing_is_not_printed() {
    let here = folder("poor_window");
    let (model, _) = ur5();
    let path = here.join("log.csv");
    let bodies = unlike(&model.robot, 5);
    // The load is heavy, from 7 s on. Before that, a sine is added to the torques. It has half of their variance and depends on
    // no state.
    let [mut log, heavy] =
        [bodies.clone(), loaded(&model.robot, &bodies, 40.0)].map(|x| swinging(&model.robot, &x, 1.2, 0.0));
    let rms = |x: &[f64]| (x.iter().map(|x| x * x).sum::<f64>() / x.len() as f64).sqrt();
    for (k, (tau, heavy)) in log.tau.iter_mut().zip(&heavy.tau).enumerate() {
        let until = log.t.iter().position(|t| *t >= 7.0).unwrap();
        let size = 0.7 * rms(&tau[..until]);
        for (r, t) in log.t.iter().enumerate() {
            match *t < 7.0 {
                true => tau[r] += size * (2.0 * PI * (2.3 + 0.37 * k as f64) * t).sin(),
                false => tau[r] = heavy[r],
            }
        }
    }
    log.write(&path, model.regressor().coordinates());
    let found = look(&model, &path, &Options::default());
    let load = found
        .findings
        .iter()
        .find(|f| matches!(f.fault, Fault::ChangedLoad { .. }))
        .unwrap_or_else(|| panic!("{:?}", found.findings));
    assert!(load.remedy.starts_with("log each load by itself"), "{load:?}");
}

/// URDF of a gantry with three prismatic axes and a wrist, masses 9, 4, 2 and 1 kg.
fn gantry() -> String {
    let body = |k: usize, mass: f64| {
        format!(
            "<link name='l{k}'><inertial><origin xyz='0.03 0.02 0.01'/><mass value='{mass}'/>\
             <inertia ixx='0.02' ixy='0' ixz='0' iyy='0.03' iyz='0' izz='0.03'/></inertial></link>"
        )
    };
    let joint = |k: usize, kind: &str, axis: &str, reach: f64| {
        format!(
            "<joint name='j{k}' type='{kind}'><parent link='l{}'/><child link='l{k}'/><origin xyz='0 0.1 0'/>\
             <axis xyz='{axis}'/><limit lower='-{reach}' upper='{reach}' velocity='2' effort='500'/></joint>",
            k - 1
        )
    };
    let bodies: String = [9.0, 4.0, 2.0, 1.0].iter().enumerate().map(|(k, mass)| body(k + 1, *mass)).collect();
    let joints = [
        ("prismatic", "1 0 0", 1.5),
        ("prismatic", "0 1 0", 1.5),
        ("prismatic", "0 0 1", 1.5),
        ("revolute", "1 0 0", 3.0),
    ];
    let joints: String =
        joints.iter().enumerate().map(|(k, (kind, axis, reach))| joint(k + 1, kind, axis, *reach)).collect();
    format!("<robot name='gantry'><link name='l0'/>{bodies}{joints}</robot>")
}

/// A gantry carries a load that its URDF lacks. The load is reported; currents or a wrong robot are not reported. Without the
/// load, nothing is reported.
#[test]
fn a_load_that_the_description_lacks_is_named() {
    let here = folder("load_of_gantry");
    let urdf = here.join("gantry.urdf");
    std::fs::write(&urdf, gantry()).unwrap();
    let model = Model::read(&urdf).unwrap();
    let path = here.join("log.csv");
    let bodies = unlike(&model.robot, 5);
    for mass in [0.0, 15.0] {
        swinging(&model.robot, &loaded(&model.robot, &bodies, mass), 1.2, 0.0)
            .write(&path, model.regressor().coordinates());
        let found = look(&model, &path, &Options::default());
        assert!(found.findings.is_empty(), "{:?}", found.findings);
        if mass == 0.0 {
            assert_eq!(found.load, None);
            continue;
        }
        let Some(Finding { fault: Fault::OtherLoad(Some(more)), .. }) = found.load else { panic!("{:?}", found.load) };
        // Tolerance, kg: the masses in the URDF are wrong by up to 15 %, and the last two bodies weigh 3 kg.
        assert!((more - mass).abs() < 0.45, "{more}");
    }
}
