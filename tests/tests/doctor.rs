//! `rist doctor`, and the verdict of `rist identify`: every usual mistake is named, and nothing on good logs.
//!
//! The simulated machines are not their descriptions: every standard parameter of a description is off by up to 15 %,
//! with friction, and noise on torques and velocities.

use std::path::{Path, PathBuf};

use identification::estimate::options::Options;
use identification::estimate::passport::Passport;
use identification::estimate::passport::finding::Fault;
use logs::{Log, LogSource};
use rist::{Model, ModelOptions, RotorInertias};
use robot::{Robot, StandardParameter};
use tests::benchmark::dataset::Dataset;
use tests::joint_log::{JointLog, Machine};
use tests::program::{Run, folder, rist};
use tests::random::{Random, State};
use tests::{model_path, recursion, shared, urdf_text, workspace};

fn described(robot: &Robot) -> Vec<f64> {
    StandardParameter::all(robot).iter().map(|p| p.value(robot).unwrap_or(0.0)).collect()
}

/// The machine behind a description.
fn truth(robot: &Robot, seed: u64) -> Vec<f64> {
    let mut random = Random(seed);
    described(robot).iter().map(|x| x * (1.0 + 0.15 * random.unit())).collect()
}

/// What the machine logs, each joint swinging by `amplitude` rad, torques late by `delay` s.
fn swinging(robot: &Robot, x: &[f64], amplitude: f64, delay: f64) -> JointLog {
    let n = robot.n_coordinates();
    let share = |k: usize| (1.0 - k as f64 / n as f64).powi(2) + 0.05;
    let viscous: Vec<f64> = (0..n).map(|k| 5.0 * share(k)).collect();
    let coulomb: Vec<f64> = (0..n).map(|k| 4.0 * share(k)).collect();
    let (viscous, coulomb, amplitude) = (&viscous, &coulomb, &vec![amplitude; n]);
    Machine { robot, parameters: x, amplitude, viscous, coulomb, noise: 0.1, encoder: 0.0, speed: 1e-3, delay }.log()
}

/// The same, by more than a radian and on time.
fn measured(robot: &Robot, x: &[f64]) -> JointLog {
    swinging(robot, x, 1.2, 0.0)
}

fn each(series: &mut [Vec<f64>], change: impl Fn(f64) -> f64) {
    series.iter_mut().flatten().for_each(|x| *x = change(*x));
}

fn minus(series: &mut [f64]) {
    series.iter_mut().for_each(|x| *x = -*x);
}

/// The log with positions and velocities, or torques, of a joint turned round.
fn mirrored(mut log: JointLog, k: usize, motion: bool, torque: bool) -> JointLog {
    if motion {
        minus(&mut log.q[k]);
        minus(&mut log.dq[k]);
    }
    if torque {
        minus(&mut log.tau[k]);
    }
    log
}

fn changed(log: &JointLog, change: impl Fn(&mut JointLog)) -> JointLog {
    let mut log = log.clone();
    change(&mut log);
    log
}

/// Nothing but the columns of the log: 0.6 s of it.
fn short(log: &mut JointLog) {
    log.t.truncate(300);
    log.q.iter_mut().chain(&mut log.dq).chain(&mut log.tau).for_each(|x| x.truncate(300));
}

/// N m/A behind a log of currents.
const AMPERES: [f64; 6] = [0.08, 0.075, 0.09, 0.1, 0.09, 0.1];

/// The UR5 of models/ and the log of one like it.
fn ur5() -> (Model, JointLog) {
    let model = Model::read(model_path("ur5.urdf")).unwrap();
    let log = measured(&model.robot, &truth(&model.robot, 5));
    (model, log)
}

fn look(model: &Model, here: &Path, log: &JointLog) -> Passport {
    let path = here.join("log.csv");
    log.write(&path, model.regressor().coordinates());
    let (source, _) = model.open_log(&path, &Default::default()).unwrap();
    rist::examine(model, &[source], &Options::default()).unwrap()
}

/// A model of random_tree, six joints in a row.
fn other_robot(here: &Path, seed: u64) -> Model {
    let path = here.join(format!("other_{seed}.urdf"));
    std::fs::write(&path, urdf_text::random_tree(6, 1, seed)).unwrap();
    Model::read(&path).unwrap()
}

#[test]
fn every_fault_is_named() {
    let here = folder("faults");
    let (model, good) = ur5();
    let robot = &model.robot;
    let x = truth(robot, 5);
    let weight = |log: &JointLog, r: usize| {
        let q: Vec<f64> = log.q.iter().map(|q| q[r]).collect();
        recursion::torque(robot, &State { q, dq: vec![0.0; 6], ddq: vec![0.0; 6] }, &x)
    };
    let computed = Machine {
        robot,
        parameters: &described(robot),
        amplitude: &[1.2; 6],
        viscous: &[0.0; 6],
        coulomb: &[0.0; 6],
        noise: 0.0,
        encoder: 0.0,
        speed: 0.0,
        delay: 0.0,
    };
    let near = |a: f64, b: f64, by: f64| (a - b).abs() < by;
    let right = std::f64::consts::FRAC_PI_2;
    type Named<'a> = &'a dyn Fn(&Fault) -> bool;
    let faults: [(&str, JointLog, &str, Named); 22] = [
        ("N mm", changed(&good, |l| each(&mut l.tau, |x| 1e3 * x)), "", &|f| *f == Fault::TorqueUnit(3)),
        ("kN m", changed(&good, |l| each(&mut l.tau, |x| 1e-3 * x)), "", &|f| *f == Fault::TorqueUnit(-3)),
        (
            "amperes",
            changed(&good, |l| l.tau.iter_mut().zip(AMPERES).for_each(|(tau, g)| tau.iter_mut().for_each(|x| *x *= g))),
            "",
            &|f| *f == Fault::NoTorque,
        ),
        ("all torque signs", changed(&good, |l| each(&mut l.tau, |x| -x)), "", &|f| *f == Fault::TorqueSigns),
        ("a torque sign", mirrored(good.clone(), 1, false, true), "shoulder_lift", &|f| *f == Fault::TorqueSign),
        ("the base's position", mirrored(good.clone(), 0, true, false), "shoulder_pan", &|f| *f == Fault::MotionSign),
        ("a wrist's position", mirrored(good.clone(), 3, true, false), "wrist_1", &|f| *f == Fault::MotionSign),
        ("a joint the other way round", mirrored(good.clone(), 2, true, true), "elbow", &|f| *f == Fault::Reversed),
        ("a quarter turn", changed(&good, |l| each(&mut l.q[2..3], |x| x + right)), "elbow", &|f| {
            *f == Fault::Zero(-right)
        }),
        (
            "half a turn",
            changed(&good, |l| each(&mut l.q[1..2], |x| x + 2.0 * right)),
            "shoulder_lift",
            &|f| matches!(f, Fault::Zero(a) if near(a.abs(), 2.0 * right, 1e-9)),
        ),
        // The machine is not its description: a degree or two of the zero are the description's.
        (
            "33 degrees",
            changed(&good, |l| each(&mut l.q[1..2], |x| x + 0.58)),
            "shoulder_lift",
            &|f| matches!(f, Fault::Zero(a) if near(*a, -0.58, 0.04)),
        ),
        (
            "two joints swapped",
            changed(&good, |l| {
                l.q.swap(1, 2);
                l.dq.swap(1, 2);
            }),
            "shoulder_lift elbow",
            &|f| *f == Fault::SwappedMotions,
        ),
        ("two positions swapped", changed(&good, |l| l.q.swap(3, 4)), "wrist_1 wrist_2", &|f| {
            *f == Fault::SwappedPositions
        }),
        ("two velocities swapped", changed(&good, |l| l.dq.swap(0, 1)), "shoulder_pan shoulder_lift", &|f| {
            *f == Fault::SwappedVelocities
        }),
        ("two torques swapped", changed(&good, |l| l.tau.swap(0, 1)), "shoulder_pan shoulder_lift", &|f| {
            *f == Fault::SwappedTorques
        }),
        ("another joint's velocity", changed(&good, |l| l.dq[2] = l.dq[1].clone()), "elbow", &|f| {
            *f == Fault::Velocity
        }),
        // As for the zero: to a tenth.
        ("20 ms late", swinging(robot, &x, 1.2, 0.02), "", &|f| matches!(f, Fault::Delay(s) if near(*s, 0.02, 0.002))),
        (
            "no gravity",
            changed(&good, |l| {
                for r in 0..l.t.len() {
                    let weight = weight(l, r);
                    l.tau.iter_mut().zip(weight).for_each(|(tau, w)| tau[r] -= w);
                }
            }),
            "",
            &|f| *f == Fault::GravityCompensated,
        ),
        ("computed torques", computed.log(), "", &|f| *f == Fault::Computed),
        ("a dead torque", changed(&good, |l| each(&mut l.tau[3..4], |_| 0.0)), "wrist_1", &|f| *f == Fault::DeadTorque),
        (
            "degrees",
            changed(&good, |l| {
                each(&mut l.q, f64::to_degrees);
                each(&mut l.dq, f64::to_degrees);
            }),
            "shoulder_pan shoulder_lift elbow wrist_1 wrist_2 wrist_3",
            &|f| *f == Fault::Degrees,
        ),
        ("0.6 s", changed(&good, short), "", &|f| matches!(f, Fault::Short(_))),
    ];
    for (name, log, joints, is_named) in faults {
        let passport = look(&model, &here, &log);
        let found = &passport.findings;
        println!("{name}: {}", found.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n    "));
        assert!(found.len() == 1 && is_named(&found[0].fault), "{name}: {found:?}\n{passport}");
        assert_eq!(found[0].joints.join(" "), joints, "{name}");
    }
    for seed in 1..5 {
        let found = look(&other_robot(&here, seed), &here, &good).findings;
        assert!(found.len() == 1 && found[0].fault == Fault::OtherRobot, "another robot, {seed}: {found:?}");
    }
}

#[test]
fn nothing_is_found_in_good_logs() {
    let here = folder("good_logs");
    let (ur5, _) = ur5();
    let r3g = Model::read(workspace().join("tests/data/robots/r3g.yaml")).unwrap();
    for model in [ur5, r3g, other_robot(&here, 1), other_robot(&here, 2)] {
        for seed in [5, 6] {
            let passport = look(&model, &here, &measured(&model.robot, &truth(&model.robot, seed)));
            assert!(passport.findings.is_empty(), "{}: {passport}{:?}", model.robot.name, passport.findings);
        }
    }
    // A description without inertials: what can be told is, and what not is said.
    let model = Model::read(model_path("planar2r_vertical.yaml")).unwrap();
    let x = Random(41).physical_parameters(&model.robot);
    let passport = look(&model, &here, &measured(&model.robot, &x));
    assert!(passport.findings.is_empty() && passport.untold.len() == 1, "{passport:?}");
    let backwards = changed(&measured(&model.robot, &x), |l| each(&mut l.tau, |x| -x));
    let passport = look(&model, &here, &backwards);
    assert_eq!(passport.findings.iter().map(|f| f.fault).collect::<Vec<_>>(), [Fault::TorqueSigns], "{passport}");
}

/// The description of a measured set; the Panda's and the TX40's with inertials.
fn description(dataset: &Dataset, shared: &Path, here: &Path) -> Vec<PathBuf> {
    let data = shared.join("data").join(&dataset.name);
    let places = [data, workspace().join("models"), workspace().join("tests/data/robots")];
    let mut all: Vec<PathBuf> = places.iter().map(|p| p.join(&dataset.model)).filter(|p| p.is_file()).collect();
    if dataset.name == "panda_gaz2019" {
        // The log is of the arm alone: its fingers do not move.
        let text = std::fs::read_to_string(shared.join("oracle/panda.urdf")).unwrap();
        let path = here.join("panda.urdf");
        std::fs::write(&path, text.replace("prismatic", "fixed")).unwrap();
        all.push(path);
    }
    all
}

/// Passports of the measured logs: with the options of their recipe, and with those of a newcomer.
fn passports(dataset: &Dataset, shared: &Path, model: &Path) -> Vec<(String, Passport)> {
    let rotor_inertias = dataset.rotors.then_some(RotorInertias::Actuated);
    let model = Model::read_with(model, &ModelOptions { rotor_inertias, ..ModelOptions::default() }).unwrap();
    let run = &dataset.runs[0];
    let plain = Options {
        columns: run.options.columns.clone(),
        transmission: run.options.transmission.clone(),
        ..Options::default()
    };
    let mut found = Vec::new();
    for file in run.train.iter().chain(&run.validate) {
        for (options, window) in [(&run.options, file.window), (&plain, None)] {
            let path = shared.join("data").join(&dataset.name).join(&file.file);
            let (mut log, _) = Log::read(&path, model.regressor().coordinates(), &options.columns).unwrap();
            log.window = window;
            let passport = rist::examine(&model, &[LogSource::Held(log)], options).unwrap();
            found.push((format!("{} by {}", path.display(), model.path.display()), passport));
        }
    }
    found
}

#[test]
fn nothing_is_found_in_measured_logs() {
    let Some(shared) = shared() else { return };
    let here = folder("measured_passports");
    let mut logs = 0;
    for dataset in Dataset::known().unwrap() {
        for model in description(&dataset, &shared, &here) {
            for (name, passport) in passports(&dataset, &shared, &model) {
                println!("{name}\n{passport}");
                assert!(passport.findings.is_empty(), "{name}: {:?}", passport.findings);
                logs += 1;
            }
        }
    }
    assert!(logs >= 18, "{logs} passports");
}

/// The URDF beside this log lacks the offsets of two joints; the transmission of its recipe has them not either.
#[test]
fn the_zeros_of_the_tx40_are_found() {
    let Some(shared) = shared() else { return };
    let dataset = Dataset::known().unwrap().into_iter().find(|d| d.name == "tx40_staubli").unwrap();
    let model = shared.join("data/tx40_staubli/tx40.urdf");
    for (name, passport) in passports(&dataset, &shared, &model) {
        let found: Vec<(Fault, &str)> = passport.findings.iter().map(|f| (f.fault, f.joints[0].as_str())).collect();
        let right = std::f64::consts::FRAC_PI_2;
        let expected = [(Fault::Zero(-right), "joint_2"), (Fault::Zero(right), "joint_3")];
        assert_eq!(found, expected, "{name}");
    }
}

/// The last three lines of what a command printed.
fn verdict(run: &Run) -> Vec<&str> {
    let lines: Vec<&str> = run.out.lines().collect();
    let last = lines[lines.len().saturating_sub(3)..].to_vec();
    for (line, start) in last.iter().zip(["found: ", "trust: ", "next: "]) {
        assert!(line.starts_with(start), "{}\n{}", run.out, run.err);
    }
    last
}

/// The ten mistakes about which a newcomer was told nothing: a sentence, exit code 1, an estimate and no URDF.
#[test]
fn no_mistake_is_silent() {
    let here = folder("silent");
    let (_, good) = ur5();
    let ur5 = model_path("ur5.urdf").display().to_string();
    let other = other_robot(&here, 1).path.display().to_string();
    let numbers: Vec<String> = (1..7).map(|k| k.to_string()).collect();
    let mistakes: [(&str, &str, JointLog, &str); 10] = [
        ("off90", &ur5, changed(&good, |l| each(&mut l.q[2..3], |x| x + 1.5707963)), "the zero of elbow is off by -90"),
        ("nmm", &ur5, changed(&good, |l| each(&mut l.tau, |x| 1e3 * x)), "in another unit: 10^3 times"),
        (
            "amps",
            &ur5,
            changed(&good, |l| l.tau.iter_mut().zip(AMPERES).for_each(|(tau, g)| tau.iter_mut().for_each(|x| *x *= g))),
            "the efforts are no torques of the joints: currents",
        ),
        (
            "signall",
            &ur5,
            changed(&good, |l| each(&mut l.tau, |x| -x)),
            "the torques of all joints have the wrong sign",
        ),
        ("sign1", &ur5, mirrored(good.clone(), 2, false, true), "the torque of elbow has the wrong sign"),
        ("qsign", &ur5, mirrored(good.clone(), 1, true, false), "the position of shoulder_lift has the wrong sign"),
        (
            "swapped",
            &ur5,
            changed(&good, |l| {
                l.q.swap(2, 3);
                l.dq.swap(2, 3);
            }),
            "the columns of elbow and wrist_1 are swapped",
        ),
        ("zeros", &ur5, changed(&good, |l| each(&mut l.tau, |_| 0.0)), "is not measured: it never changes"),
        ("robot", &other, good.clone(), "this log is not of this robot"),
        ("short", &ur5, changed(&good, short), "the log is too short"),
    ];
    for (name, robot, log, sentence) in mistakes {
        let (file, estimate, urdf) = (format!("{name}.csv"), format!("{name}.yaml"), format!("{name}.urdf"));
        log.write(&here.join(&file), &numbers);
        let run = rist(&here, &["identify", robot, &file, "--out", &estimate, "--write-urdf", &urdf]);
        assert_eq!(run.code, Some(1), "{name}: {}{}", run.out, run.err);
        let last = verdict(&run);
        assert!(last[1].starts_with("trust: no: ") && last[1].contains(sentence), "{name}: {last:?}");
        assert!(run.err.contains("not to be trusted") && run.err.contains("--anyway"), "{name}: {}", run.err);
        assert!(here.join(&estimate).is_file() && !here.join(&urdf).exists(), "{name}");
        let doctor = rist(&here, &["doctor", robot, &file]);
        assert_eq!(doctor.code, Some(1), "{name}: {}", doctor.out);
        assert!(doctor.out.contains(sentence), "{name}: {}", doctor.out);
    }
    let anyway = ["identify", &ur5, "sign1.csv", "--write-urdf", "sign1.urdf", "--anyway"];
    assert_eq!(rist(&here, &anyway).code, Some(1));
    assert!(here.join("sign1.urdf").is_file());
}

#[test]
fn a_good_log_is_trusted() {
    let here = folder("trusted");
    let (model, good) = ur5();
    let ur5 = model_path("ur5.urdf").display().to_string();
    good.write(&here.join("a.csv"), model.regressor().coordinates());
    let doctor = rist(&here, &["doctor", &ur5, "a.csv"]);
    assert_eq!(doctor.code, Some(0), "{}{}", doctor.out, doctor.err);
    assert!(doctor.out.contains("nothing wrong is seen") && doctor.out.contains("brakes"), "{}", doctor.out);

    let run = rist(&here, &["identify", &ur5, "a.csv", "--consistent", "--write-urdf", "w.urdf", "--out", "e.yaml"]);
    assert_eq!(run.code, Some(0), "{}{}", run.out, run.err);
    let found = verdict(&run);
    assert!(found[1].starts_with("trust: yes: "), "{found:?}");
    let percent = |line: &str, behind: &str| -> f64 {
        let rest = line.split(behind).nth(1).unwrap_or_else(|| panic!("no `{behind}` in {line}"));
        rest.split_whitespace().next().unwrap().parse().unwrap()
    };
    let description = percent(found[0], "your description predicts this log with ");
    let identified = percent(found[0], "the identified parameters with ");
    // Parameters off by up to 15 %, and not all the same way; noise of 0.1 N m beside torques of some ten.
    assert!((0.5..15.0).contains(&description) && identified < 0.5 * description, "{found:?}");
    assert!(here.join("w.urdf").is_file());

    let other = swinging(&model.robot, &truth(&model.robot, 5), 0.8, 0.0);
    other.write(&here.join("b.csv"), model.regressor().coordinates());
    let validated = rist(&here, &["validate", &ur5, "e.yaml", "b.csv"]);
    assert_eq!(validated.code, Some(0), "{}{}", validated.out, validated.err);
    assert!(verdict(&validated)[1].starts_with("trust: yes: "), "{}", validated.out);
    let backwards = changed(&good, |l| each(&mut l.tau, |x| -x));
    backwards.write(&here.join("c.csv"), model.regressor().coordinates());
    let refused = rist(&here, &["validate", &ur5, "e.yaml", "c.csv"]);
    assert_eq!(refused.code, Some(1), "{}{}", refused.out, refused.err);
    assert!(verdict(&refused)[1].contains("wrong sign"), "{}", refused.out);
}
