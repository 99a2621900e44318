//! `rist doctor` names each usual mistake in simulated and in measured logs, and has no findings for correct logs.
//!
//! The simulated machines differ from their descriptions: each standard parameter by up to 15 %. They have friction, and noise on
//! torques and velocities.

use std::path::{Path, PathBuf};

use identification::estimate::hypothesis::Hypothesis::*;
use identification::estimate::log_check::LogCheck;
use identification::estimate::log_check::finding::{ColumnKind, Fault, Finding};
use identification::estimate::options::Options;
use logs::{Log, LogSource};
use rist::describe::description::RotorInertias;
use rist::{Model, ModelOptions};
use tests::benchmark::dataset::Dataset;
use tests::faults::{Injected, changed, cut, each, injected, mirrored};
use tests::joint_log::{JointLog, Machine, described, swinging, swinging_by, unlike, ur5};
use tests::program::folder;
use tests::random::{Random, State};
use tests::{model_path, recursion, shared, test_robot_path, urdf_text, workspace};

fn look(model: &Model, here: &Path, log: &JointLog) -> LogCheck {
    rist::examine(model, &[log.opened(model, &here.join("log.csv"))], &Options::default()).unwrap()
}

/// A random serial robot with six joints.
fn other_robot(here: &Path, seed: u64) -> Model {
    let path = here.join(format!("other_{seed}.urdf"));
    std::fs::write(&path, urdf_text::random_tree(6, 1, seed)).unwrap();
    Model::read(&path).unwrap()
}

/// Whether a log check has exactly one finding, and this finding names the mistake of the log.
fn names(model: &Model, findings: &[Finding], mistake: &Injected) -> bool {
    let [finding] = findings else { return false };
    let joints = mistake.joints.iter().map(|&k| &model.regressor().coordinates()[k]);
    (mistake.is_named)(&finding.fault) && joints.eq(&finding.joints)
}

#[test]
fn every_fault_is_named() {
    let here = folder("faults");
    let (model, good) = ur5();
    let (robot, x) = (&model.robot, unlike(&model.robot, 5));
    let weight = |log: &JointLog, r: usize| {
        let q: Vec<f64> = log.q.iter().map(|q| q[r]).collect();
        recursion::torque(robot, &State { q, dq: vec![0.0; 6], ddq: vec![0.0; 6] }, &x)
    };
    let right = std::f64::consts::FRAC_PI_2;
    let mut mistakes = injected(&good, [1, 2], weight, 10);
    let mut add = |name, log, joints: &[usize], is_named: fn(&Fault) -> bool| {
        mistakes.push(Injected { name, log, joints: joints.to_vec(), is_named: Box::new(is_named) });
    };
    let computed = Machine::exact(robot, &described(robot), &[1.2; 6]).log();
    add("computed torques", computed, &[], |f| *f == Fault::Computed);
    let absolute = changed(&good, |l| each(&mut l.tau, f64::abs));
    add("absolute torques", absolute, &[], |f| *f == Fault::AbsoluteTorque);
    add("kN m", changed(&good, |l| each(&mut l.tau, |x| 1e-3 * x)), &[], |f| *f == Fault::TorqueUnit(-3));
    add("the base's position", mirrored(&good, 0, true, false), &[0], |f| *f == Fault::Of(MotionSign(0), 0.0));
    add("a joint the other way round", mirrored(&good, 2, true, true), &[2], |f| *f == Fault::Of(Reversed(2), 0.0));
    let half = changed(&good, |l| each(&mut l.q[1..2], |x| x + 2.0 * right));
    add(
        "half a turn",
        half,
        &[1],
        |f| matches!(f, Fault::Of(Zero(1), a) if (a.abs() - std::f64::consts::PI).abs() < 1e-9),
    );
    // The parameters of the machine differ from the description. This has the same effect as a zero error of one or two degrees.
    let odd = changed(&good, |l| each(&mut l.q[1..2], |x| x + 0.58));
    add("33 degrees", odd, &[1], |f| matches!(f, Fault::Of(Zero(1), a) if (a + 0.58).abs() < 0.04));
    let swapped = |k, l| changed(&good, |log| log.q.swap(k, l));
    add("two positions swapped", swapped(3, 4), &[3, 4], |f| *f == Fault::Of(SwappedPositions(3, 4), 0.0));
    let swapped = |k, l| changed(&good, |log| log.dq.swap(k, l));
    add("two velocities swapped", swapped(0, 1), &[0, 1], |f| *f == Fault::Of(SwappedVelocities(0, 1), 0.0));
    let swapped = |k, l| changed(&good, |log| log.tau.swap(k, l));
    add("two torques swapped", swapped(0, 1), &[0, 1], |f| *f == Fault::Of(SwappedTorques(0, 1), 0.0));
    let swapped =
        |k, l| changed(&good, |log| [&mut log.q, &mut log.dq, &mut log.tau].into_iter().for_each(|x| x.swap(k, l)));
    add("two joints' columns swapped", swapped(1, 3), &[1, 3], |f| *f == Fault::Of(SwappedJoints(1, 3), 0.0));
    let backwards = changed(&good, |log| [&mut log.q, &mut log.dq, &mut log.tau].into_iter().for_each(|x| x.reverse()));
    add("columns from the tip", backwards, &[0, 1, 2, 3, 4, 5], |f| *f == Fault::Permuted(ColumnKind::All));
    let torques = changed(&good, |log| log.tau[..4].rotate_right(1));
    add("torques permuted", torques, &[0, 1, 2, 3], |f| *f == Fault::Permuted(ColumnKind::Torques));
    add("0.6 s", cut(&good, 0.6), &[], |f| matches!(f, Fault::Short(_)));
    for mistake in &mistakes {
        let log_check = look(&model, &here, &mistake.log);
        let found = &log_check.findings;
        println!("{}: {}", mistake.name, found.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n    "));
        assert!(names(&model, found, mistake), "{}: {found:?}\n{log_check}", mistake.name);
    }
    for seed in 1..5 {
        let found = look(&other_robot(&here, seed), &here, &good).findings;
        assert!(found.len() == 1 && found[0].fault == Fault::OtherRobot, "another robot, {seed}: {found:?}");
    }
}

/// If the signs of all torques are reversed, the log check reports this, and all its other findings are the same, with the same
/// numbers.
#[test]
fn signs_of_all_torques_change_nothing_else() {
    let here = folder("all_signs");
    let (model, good) = ur5();
    for factor in [0.35, 1.0, 2.5] {
        // In the first log, one torque has the wrong sign. In the second log, all torques of the first log are reversed.
        let single = changed(&mirrored(&good, 2, false, true), |l| each(&mut l.tau, |x| factor * x));
        let opposite = changed(&single, |l| each(&mut l.tau, |x| -x));
        // The slopes (measured over nominal torque) are not compared, because their signs differ.
        let found = |log: &JointLog| -> Vec<(Fault, String)> {
            let findings = look(&model, &here, log).findings.into_iter();
            findings.map(|f| (f.fault, f.evidence.split("; measured over").next().unwrap_or_default().into())).collect()
        };
        let (plain, mut signed) = (found(&single), found(&opposite));
        assert!(matches!(plain.first(), Some((Fault::Of(TorqueSign(2), _), _))), "{plain:?}");
        // The other finding is the common factor of all torques, detected after the single sign is corrected.
        let shared: Vec<&Fault> = plain.iter().skip(1).map(|(fault, _)| fault).collect();
        match shared.as_slice() {
            [] => assert_eq!(factor, 1.0, "{plain:?}"),
            [Fault::Factor(found)] => assert!((found / factor - 1.0).abs() < 0.05, "{factor}: {found}"),
            _ => panic!("{factor}: {plain:?}"),
        }
        assert_eq!(signed.extract_if(.., |f| f.0 == Fault::TorqueSigns).count(), 1, "{factor}: {signed:?}");
        assert_eq!(signed, plain, "{factor}");
    }
}

#[test]
fn nothing_is_found_in_good_logs() {
    let here = folder("good_logs");
    let ur5 = ur5().0;
    let r3g = Model::read(workspace().join("tests/data/robots/r3g.yaml")).unwrap();
    for model in [ur5, r3g, other_robot(&here, 1), other_robot(&here, 2)] {
        for seed in [5, 6] {
            let log_check = look(&model, &here, &swinging(&model.robot, &unlike(&model.robot, seed), 1.2, 0.0));
            assert!(log_check.findings.is_empty(), "{}: {log_check}{:?}", model.robot.name, log_check.findings);
        }
    }
    // A description without inertial parameters: some properties can be checked, and a sentence names the others.
    let model = Model::read(test_robot_path("planar2r_vertical.yaml")).unwrap();
    let x = Random(41).physical_parameters(&model.robot);
    let log_check = look(&model, &here, &swinging(&model.robot, &x, 1.2, 0.0));
    assert!(log_check.findings.is_empty() && log_check.not_checked.len() == 1, "{log_check:?}");
    let backwards = changed(&swinging(&model.robot, &x, 1.2, 0.0), |l| each(&mut l.tau, |x| -x));
    let log_check = look(&model, &here, &backwards);
    assert_eq!(log_check.findings.iter().map(|f| f.fault).collect::<Vec<_>>(), [Fault::TorqueSigns], "{log_check}");
}

/// The URDF of a robot with two arms on one base, with three joints each. The arms are mirror images of each other.
fn two_arms() -> String {
    let mut text = String::from("<robot name=\"two_arms\"><link name=\"base\"/>\n");
    for (side, y) in [("left", 1.0), ("right", -1.0)] {
        let mut parent = "base".to_string();
        let joints = [("1 0 0", 0.2 * y, 0.0, 0.06), ("0 1 0", 0.1 * y, 0.0, 0.03), ("0 1 0", 0.0, -0.35, 0.02)];
        for (k, (axis, out, down, eccentric)) in joints.into_iter().enumerate() {
            let link = format!("{side}_l{}", k + 1);
            text += &format!(
                "<link name=\"{link}\"><inertial><origin xyz=\"0.02 {} -0.12\"/><mass value=\"{}\"/><inertia ixx=\"0.02\" \
                 iyy=\"0.018\" izz=\"0.006\" ixy=\"{}\" ixz=\"0.001\" iyz=\"{}\"/></inertial></link>\n<joint \
                 name=\"{side}_j{}\" type=\"revolute\"><parent link=\"{parent}\"/><child link=\"{link}\"/><origin xyz=\"0 {out} \
                 {down}\"/><axis xyz=\"{axis}\"/><limit lower=\"-2\" upper=\"2\" velocity=\"5\" effort=\"90\"/></joint>\n",
                eccentric * y,
                2.5 - 0.5 * k as f64,
                0.002 * y,
                -0.001 * y,
                k + 1
            );
            parent = link;
        }
    }
    text + "</robot>"
}

/// The columns of the left and the right arm are exchanged: all six joints are named, and no output trusts the estimate. If the
/// user gives the columns in order, the output states whether another order would have been detected.
#[test]
fn exchanged_sides_are_named_and_never_trusted() {
    let here = folder("sides");
    let path = here.join("two_arms.urdf");
    std::fs::write(&path, two_arms()).unwrap();
    let model = Model::read(&path).unwrap();
    let names: Vec<String> = (0..6).map(|k| k.to_string()).collect();
    let columns = "columns: {position: \"q_{}\", velocity: \"dq_{}\", torque: \"tau_{}\"}\nmodel: two_arms\n";
    let options = Options::parse("options.yaml", columns).unwrap();
    let swap =
        |log: &JointLog| changed(log, |l| [&mut l.q, &mut l.dq, &mut l.tau].into_iter().for_each(|x| x.rotate_left(3)));
    for seed in [3, 4] {
        let x = unlike(&model.robot, seed);
        for is_swapped in [false, true] {
            let log = |name: &str, amplitude: f64| {
                let log = swinging(&model.robot, &x, amplitude, 0.0);
                let file = here.join(format!("{name}.csv"));
                let log = if is_swapped { swap(&log) } else { log };
                log.write(&file, &names);
                model.open_log(&file, &options.columns).unwrap().0
            };
            let (first, other) = (log("first", 0.7), log("other", 0.9));
            let logs = [first];
            let log_check = rist::examine(&model, &logs, &options).unwrap();
            let mut request = rist::IdentifyRequest::default();
            request.samples.rows.signals.options = Some(options.clone());
            let mut found = rist::identify(&model, &logs, &request).unwrap();
            let judged = found.verdict_of_logs(&model, std::slice::from_ref(&other), false).unwrap().verdict;
            let validated = rist::fit::verdict::validation_verdict(
                &model,
                &found.estimate,
                std::slice::from_ref(&other),
                0.01,
                true,
            );
            let read_again = rist::fit::verdict::fitted_verdict(&model, &found.estimate, &logs);
            let all = [judged, validated.unwrap(), read_again.unwrap()];
            for verdict in &all {
                // If bodies with free parameters explain the log, it is not contradicted, but it is not trusted either.
                let is_yes = verdict.trust == rist::fit::verdict::Trust::Yes;
                assert!(!(is_swapped && is_yes), "{seed}: {verdict}");
                assert!(is_swapped || verdict.trust != rist::fit::verdict::Trust::No, "{seed}: {verdict}");
                let says = verdict.to_string().replace('\n', " ").contains("are in another order (position, velocity");
                assert_eq!(says, is_swapped, "{seed}: {verdict}");
            }
            let explained = log_check.explained.iter().map(|explained| &explained.finding);
            let found: Vec<_> = log_check.findings.iter().chain(explained).collect();
            match is_swapped {
                false => assert!(found.is_empty(), "{seed}: {found:?}"),
                true => {
                    let faults: Vec<Fault> = found.iter().map(|f| f.fault).collect();
                    assert_eq!(faults, [Fault::Permuted(ColumnKind::All)], "{seed}: {found:?}");
                    assert_eq!(found[0].joints, model.regressor().coordinates(), "{seed}");
                }
            }
        }
    }
}

/// The last body of the machine is rotated about the last joint, compared with the description. The torques are the same as for a
/// zero error of this joint, so no zero error is reported. The robot is a UR5 with an eccentric tool.
#[test]
fn a_last_body_that_lies_otherwise_is_no_wrong_zero() {
    let here = folder("last_body");
    let text = std::fs::read_to_string(model_path("ur5.urdf")).unwrap();
    let tool = "<link name=\"tool_body\"><inertial><origin xyz=\"0.12 0.03 0.05\"/><mass value=\"1.5\"/><inertia ixx=\"0.004\" \
                iyy=\"0.003\" izz=\"0.005\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial></link>";
    // The axis of the last joint is z of wrist_3.
    let mount = |turn: f64| {
        format!(
            "{tool}<joint name=\"tool_mount\" type=\"fixed\"><parent link=\"wrist_3\"/><child link=\"tool_body\"/>\
             <origin xyz=\"0 0 0\" rpy=\"0 0 {turn}\"/></joint></robot>"
        )
    };
    let with = |turn: f64, name: &str| {
        let path = here.join(name);
        std::fs::write(&path, text.replace("</robot>", &mount(turn))).unwrap();
        Model::read(&path).unwrap()
    };
    let model = with(0.0, "described.urdf");
    for turn in [1.3, -2.2] {
        let machine = with(turn, "machine.urdf");
        let log = swinging(&machine.robot, &described(&machine.robot), 1.2, 0.0);
        let log_check = look(&model, &here, &log);
        assert!(log_check.findings.is_empty(), "{turn}: {:?}", log_check.findings);
        let [explained] = log_check.explained.as_slice() else { panic!("{turn}: {log_check:?}") };
        assert!(matches!(explained.finding.fault, Fault::Of(Zero(_), _)) && explained.is_likely, "{explained:?}");
        // The same log can also be added to stored sums of logs.
        let request = fleet::SumsRequest::default();
        let mut sums = fleet::accumulator(&model, &request).unwrap();
        let (source, _) = model.open_log(&here.join("log.csv"), &Default::default()).unwrap();
        fleet::update(&model, &mut sums, &source, false).unwrap();
    }
}

/// The machine has rotors that its URDF does not contain. Delayed torques are named nevertheless, as `rist identify` also finds
/// them.
#[test]
fn late_torques_are_named_without_rotors_in_the_description() {
    let here = folder("late_rotors");
    let model = Model::read(model_path("ur5.urdf")).unwrap();
    let rotating = ModelOptions { rotor_inertia: Some(RotorInertias::Actuated), ..ModelOptions::default() };
    let machine = Model::read_with(model_path("ur5.urdf"), &rotating).unwrap();
    let mut x = unlike(&machine.robot, 6);
    // The rotors of geared arms have inertias as large as the inertias of the links.
    let all = robot::StandardParameter::all(&machine.robot);
    let rotor = |(p, x): (&robot::StandardParameter, &mut f64)| {
        if p.inertial == robot::Inertial::Ia {
            *x = 1.2;
        }
    };
    all.iter().zip(&mut x).for_each(rotor);
    for seconds in [0.006, 0.02, 0.06] {
        let found = look(&model, &here, &swinging(&machine.robot, &x, 1.2, seconds)).findings;
        let is_late = |f: &Finding| matches!(f.fault, Fault::Of(Late(None), s) if (s / seconds - 1.0).abs() < 0.34);
        assert!(found.len() == 1 && is_late(&found[0]), "{seconds}: {found:?}");
    }
    let found = look(&model, &here, &swinging(&machine.robot, &x, 1.2, 0.0)).findings;
    assert!(found.is_empty(), "{found:?}");
}

/// A Panda with inertial parameters and fixed fingers, because the logs contain only the arm.
fn panda(shared: &Path, here: &Path) -> PathBuf {
    let text = std::fs::read_to_string(shared.join("oracle/panda.urdf")).unwrap();
    let path = here.join("panda.urdf");
    std::fs::write(&path, text.replace("prismatic", "fixed")).unwrap();
    path
}

/// The descriptions of a measured robot. For the Panda and the TX40, a description with inertial parameters is added.
fn description(dataset: &Dataset, shared: &Path, here: &Path) -> Vec<PathBuf> {
    let data = shared.join("data").join(&dataset.name);
    let places = [data, workspace().join("models"), workspace().join("tests/data/robots")];
    let mut all: Vec<PathBuf> = places.iter().map(|p| p.join(&dataset.model)).filter(|p| p.is_file()).collect();
    if dataset.name == "panda_gaz2019" {
        all.push(panda(shared, here));
    }
    all
}

/// Log checks of the measured logs, with the options of their recipe and with default options.
fn passports(dataset: &Dataset, shared: &Path, model: &Path) -> Vec<(String, LogCheck)> {
    let rotor_inertia = dataset.rotors.then_some(RotorInertias::Actuated);
    let model = Model::read_with(model, &ModelOptions { rotor_inertia, ..ModelOptions::default() }).unwrap();
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
            let log_check = rist::examine(&model, &[LogSource::Held(log)], options).unwrap();
            found.push((format!("{} by {}", path.display(), model.path.display()), log_check));
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
            for (name, log_check) in passports(&dataset, &shared, &model) {
                println!("{name}\n{log_check}");
                assert!(log_check.findings.is_empty(), "{name}: {:?}", log_check.findings);
                logs += 1;
            }
        }
    }
    assert!(logs >= 18, "{logs} passports");
}

/// Only one joint moves. Its friction is not reported as a delay, and joints at rest are not used to explain its torque.
#[test]
fn a_joint_that_moves_alone_accuses_nobody() {
    let here = folder("moves_alone");
    let (model, _) = ur5();
    for k in 0..6 {
        let amplitude: Vec<f64> = (0..6).map(|j| if j == k { 1.0 } else { 0.0 }).collect();
        let log = swinging_by(&model.robot, &unlike(&model.robot, 5), &amplitude, 0.0);
        let findings = look(&model, &here, &log).findings;
        assert!(findings.is_empty(), "joint {}: {findings:?}", k + 1);
    }
    // Measured logs of a UR10e in which each joint moves alone, for the identification of friction.
    let Some(shared) = shared() else { return };
    let folder = shared.join("data/ur10e_innopolis");
    let ur10e = Model::read(folder.join("ur10e.urdf")).unwrap();
    for k in 1..=6 {
        let file = folder.join(format!("friction_joint{k}.csv.gz"));
        let log = measured(&ur10e, &file, &[14.87, 13.26, 11.13, 10.62, 11.03, 11.47]);
        let findings = look(&ur10e, &here, &log).findings;
        assert!(findings.is_empty(), "{}: {findings:?}", file.display());
    }
}

/// The URDF of the TX40 lacks the zero offsets of two joints. The transmission options in its recipe lack them too.
#[test]
fn the_zeros_of_the_tx40_are_found() {
    let Some(shared) = shared() else { return };
    let dataset = Dataset::known().unwrap().into_iter().find(|d| d.name == "tx40_staubli").unwrap();
    let model = shared.join("data/tx40_staubli/tx40.urdf");
    for (name, log_check) in passports(&dataset, &shared, &model) {
        let found: Vec<(Fault, &str)> = log_check.findings.iter().map(|f| (f.fault, f.joints[0].as_str())).collect();
        let right = std::f64::consts::FRAC_PI_2;
        let expected = [(Fault::Of(Zero(1), -right), "joint_2"), (Fault::Of(Zero(2), right), "joint_3")];
        assert_eq!(found, expected, "{name}");
        // A single option corrects both zero errors.
        let remedy = "in the file of [options]: transmission: {offsets: [0, -1.5708, 1.5708, 0, 0, 0]}";
        assert!(log_check.findings.iter().all(|f| f.remedy == remedy), "{name}: {:?}", log_check.findings);
    }
}

fn measured(model: &Model, file: &Path, gains: &[f64]) -> JointLog {
    let (log, _) = Log::read(file, model.regressor().coordinates(), &Default::default()).unwrap();
    let gain = |k: usize| gains.get(k).copied().unwrap_or(1.0);
    let tau = log.effort.iter().enumerate().map(|(k, x)| x.iter().map(|x| gain(k) * x).collect()).collect();
    JointLog { t: log.t, q: log.q, dq: log.dq.expect("a velocity"), tau }
}

fn identified(model: &Model, here: &Path, log: &JointLog) -> Vec<f64> {
    let source = log.opened(model, &here.join("log.csv"));
    let estimate = rist::identify(model, &[source], &Default::default()).unwrap().estimate;
    estimate.parameters.iter().take(model.regressor().parameters().len()).map(|p| p.value.unwrap()).collect()
}

/// The fifteen mistakes of `tests::faults`, in measured logs of a Panda and a UR10e; and each log with the description of the
/// other robot.
#[test]
fn faults_are_named_in_measured_logs() {
    let Some(shared) = shared() else { return };
    let here = folder("measured_faults");
    let panda = Model::read(panda(&shared, &here)).unwrap();
    // The model has no rotor inertias. Their columns could explain a part of the mistakes.
    let without = ModelOptions { rotor_inertia: Some(RotorInertias::None), ..ModelOptions::default() };
    let ur10e = Model::read_with(shared.join("data/ur10e_innopolis/ur10e.urdf"), &without).unwrap();
    let gains = [14.87, 13.26, 11.13, 10.62, 11.03, 11.47];
    let sets: [(&Model, &str, &[f64], usize); 2] = [
        (&panda, "data/panda_gaz2019/exciting_traj_1.csv.gz", &[], 20),
        (&ur10e, "data/ur10e_innopolis/id_40s_12harm.csv.gz", &gains, 6),
    ];
    for (model, file, gains, rows) in sets {
        let good = measured(model, &shared.join(file), gains);
        let n = good.q.len();
        let identified = identified(model, &here, &good);
        let weight = |log: &JointLog, r: usize| {
            let q: Vec<f64> = log.q.iter().map(|q| q[r]).collect();
            let mut y = vec![0.0; n * identified.len()];
            model.regressor().fill(&q, &vec![0.0; n], &vec![0.0; n], &mut y);
            y.chunks(identified.len()).map(|row| row.iter().zip(&identified).map(|(y, x)| y * x).sum()).collect()
        };
        let mut named = 0;
        let mistakes = injected(&good, [1, 3], weight, rows);
        for mistake in &mistakes {
            let found = look(model, &here, &mistake.log).findings;
            let is_named = names(model, &found, mistake);
            named += usize::from(is_named);
            let text = found.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n    ");
            println!("{}: {}: {} {text}", model.robot.name, mistake.name, if is_named { "named" } else { "NOT NAMED" });
        }
        println!("{}: {named} of {}", model.robot.name, mistakes.len());
        assert!(named + 1 >= mistakes.len(), "{}: {named} of {}", model.robot.name, mistakes.len());
    }
}

/// A wrong sign is also detected in a short log, for two reasons: the friction drives the joint, and the measured torque is
/// opposite to the nominal torque.
#[test]
fn a_wrong_sign_is_named_in_a_short_log() {
    let here = folder("short_sign");
    let model = Model::read(model_path("ur5.urdf")).unwrap();
    let text = std::fs::read_to_string(workspace().join("docs/ur5/log.csv")).unwrap();
    let turned = |(k, line): (usize, &str)| match line.rsplit_once(',') {
        Some((others, last)) if k > 0 => format!("{others},{}", -last.parse::<f64>().unwrap()),
        _ => line.to_string(),
    };
    let path = here.join("log.csv");
    std::fs::write(&path, text.lines().enumerate().map(turned).collect::<Vec<_>>().join("\n")).unwrap();
    let (source, _) = model.open_log(&path, &Default::default()).unwrap();
    let log_check = rist::examine(&model, &[source], &Options::default()).unwrap();
    assert!(log_check.is_short, "{log_check}");
    let [finding] = log_check.findings.as_slice() else { panic!("{:?}", log_check.findings) };
    assert!(matches!(finding.fault, Fault::FrictionSign | Fault::Of(TorqueSign(5), _)), "{finding}");
    assert_eq!(finding.joints, ["wrist_3"]);
    // A joint whose torque has the wrong sign must have no claim that it agrees with the description.
    let claims = rist::fit::doctor::claims_of_log(&log_check, &[]);
    assert!(
        !claims
            .iter()
            .any(|claim| claim.to_string().starts_with("sign of") && claim.to_string().contains("wrist_3; agrees"))
    );
}
