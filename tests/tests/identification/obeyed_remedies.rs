//! What a finding prints is done to the letter: the log is read again, and nothing is contradicted any more.

use std::f64::consts::PI;
use std::path::Path;

use claims::Outcome;
use identification::estimate::options::Options;
use identification::estimate::passport::Passport;
use rist::Model;
use rist::fit::verdict::Verdict;
use rist::request::IdentifyRequest;
use tests::faults::{changed, each, mirrored};
use tests::joint_log::{JointLog, swinging, unlike};
use tests::model_path;
use tests::program::folder;

fn ur5() -> (Model, JointLog) {
    let model = Model::read(model_path("ur5.urdf")).unwrap();
    let log = swinging(&model.robot, &unlike(&model.robot, 5), 1.2, 0.0);
    (model, log)
}

fn look(model: &Model, path: &Path, options: &Options) -> Passport {
    let (source, _) = model.open_log(path, &options.columns).unwrap();
    rist::examine(model, &[source], options).unwrap()
}

/// The options that a passport prints for what it names first.
fn printed(passport: &Passport) -> Options {
    let remedy = &passport.findings[0].remedy;
    let (_, yaml) = remedy.split_once("in the file of [options]: ").unwrap_or_else(|| panic!("{remedy}"));
    Options::parse("printed.yaml", yaml).unwrap()
}

/// A mistake, and the words of the finding that names it.
type Mistake = (&'static str, fn(&mut JointLog), &'static [&'static str]);

const MISTAKES: [Mistake; 11] = [
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
];

/// Each mistake is named first, with what it takes: one request, which the program reads. Read so, nothing is contradicted.
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

/// The figure of a wrong scale is that of the log, and not of the description, whose bodies are off by 15 %.
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
            // The search ends within a hundredth; noise and the parts left out move it by as much.
            assert!((scale / wanted - 1.0).abs() < 0.03, "{joint}: {scales:?}, {factor}");
        }
    }
}

/// What options say already is said with what a remedy adds, so that the printed lists can take their place.
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
    found.judged(model, &[], false).unwrap().verdict
}

/// A push of a second at the elbow is said with its times; the log without it says nothing of the kind.
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
