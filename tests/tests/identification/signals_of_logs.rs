//! Tests of findings about signals: values that are repeated over several rows; motors behind gears that turn far between rows;
//! unsigned integers instead of signed ones; rows of two publishers; wrong velocity or acceleration columns. Each must be found
//! in a log that has it, and in no other log.

use std::fmt::Write as _;
use std::path::Path;

use identification::estimate::log_check::LogCheck;
use identification::estimate::log_check::finding::Fault;
use identification::estimate::options::Options;
use logs::LogSource;
use rist::fit::doctor::claims_of_log;
use rist::fit::samples::Identification;
use rist::{FrictionTerm, IdentifyRequest, Model};
use tests::faults::{changed, each};
use tests::joint_log::{JointLog, ur5};
use tests::program::folder;
use tests::shared;

fn opened(model: &Model, log: &JointLog, name: &str) -> LogSource {
    log.opened(model, &folder("signals").join(format!("{name}.csv")))
}

fn look(model: &Model, log: &JointLog, name: &str) -> LogCheck {
    rist::examine(model, &[opened(model, log, name)], &Options::default()).unwrap()
}

fn request(options: &Options) -> IdentifyRequest {
    let mut request = IdentifyRequest::default();
    request.samples.rows.signals.options = Some(options.clone());
    request
}

fn identified(model: &Model, source: LogSource, options: &Options) -> Identification {
    rist::identify(model, &[source], &request(options)).unwrap()
}

/// The log with `change` applied to the velocities and torques of each row for which `is_other` holds.
fn mixed(log: &JointLog, is_other: impl Fn(usize) -> bool, change: impl Fn(f64) -> f64) -> JointLog {
    changed(log, |log| {
        for series in log.dq.iter_mut().chain(&mut log.tau) {
            series.iter_mut().enumerate().filter(|(r, _)| is_other(*r)).for_each(|(_, x)| *x = change(*x));
        }
    })
}

#[test]
fn rows_of_two_publishers_are_named_and_spikes_are_not() {
    let (model, good) = ur5();
    assert!(look(&model, &good, "one_source").findings.is_empty());
    for (name, every, scale) in [("halves", 2, 0.0), ("thirds", 3, 0.0), ("another_unit", 2, 0.1)] {
        let log = mixed(&good, |r| r % every == 1, |x| scale * x);
        let log_check = look(&model, &log, name);
        let [finding] = log_check.findings.as_slice() else { panic!("{name}: {:?}", log_check.findings) };
        assert!(matches!(finding.fault, Fault::TwoSources(_)), "{name}: {finding}");
        assert_eq!(finding.evidence.contains("there it is zero"), scale == 0.0, "{finding}");
    }
    let spiked = mixed(&good, |r| r % 50 == 7, |x| x + 176.0);
    assert!(!look(&model, &spiked, "spikes").findings.iter().any(|f| matches!(f.fault, Fault::TwoSources(_))));
    // An estimate from such a log cannot be trusted. The verdict first says how to repair the log.
    let halves = opened(&model, &mixed(&good, |r| r % 2 == 1, |_| 0.0), "halves_fitted");
    let verdict = identified(&model, halves, &Options::default()).verdict_of_logs(&model, &[], false).unwrap().verdict;
    assert!(verdict.to_string().contains("are of another source"), "{verdict}");
}

#[test]
fn words_without_their_sign_are_named_with_what_mends_them() {
    let (model, good) = ur5();
    let counts = changed(&good, |log| each(&mut log.tau, |x| (x / 0.05).round()));
    for (word, said) in
        [(65_536.0, "subtract 65536 from the numbers from 32768 on"), (-4096.0, "from 4096 on as 4096 - x")]
    {
        let read = |x: f64| match x < 0.0 {
            true if word > 0.0 => x + word,
            true => -word - x,
            false => x,
        };
        let log_check = look(&model, &changed(&counts, |log| each(&mut log.tau, read)), "words");
        let [finding] = log_check.findings.as_slice() else { panic!("{:?}", log_check.findings) };
        assert!(finding.fault == Fault::RawWords && finding.remedy.contains(said), "{finding}");
        // The torques of at least the base and the wrists often change their sign. So the finding is expected for these joints.
        assert!(finding.joints.len() >= 3 && finding.joints[0] == "shoulder_pan", "{finding}");
    }
    let clean = look(&model, &counts, "counts");
    assert!(clean.findings.iter().all(|f| f.fault != Fault::RawWords), "{:?}", clean.findings);
}

/// Motors behind gears of ratio 121 turn by up to 40 rad between rows. Their positions must not be unwrapped. The estimate equals
/// the estimate from joint positions.
#[test]
fn a_motor_behind_its_gear_keeps_its_turns() {
    let (model, good) = ur5();
    let joints = good.every(10);
    let ratio = 121.0;
    let motors = changed(&joints, |log| {
        log.q.iter_mut().chain(&mut log.dq).flatten().for_each(|x| *x *= ratio);
        log.tau.iter_mut().flatten().for_each(|x| *x /= ratio);
    });
    let turned = motors.q.iter().flat_map(|q| q.windows(2)).filter(|w| {
        let step = (w[1] - w[0]).abs();
        (step - std::f64::consts::TAU).abs() < 0.5
    });
    assert!(turned.count() > 20);
    let mut options = Options::default();
    let expected = identified(&model, opened(&model, &joints, "joints"), &options);
    options.transmission.ratios = Some(vec![ratio; 6]);
    let source = opened(&model, &motors, "motors");
    assert_eq!(source.report().wrapped, 0);
    let found = identified(&model, source, &options);
    for (a, b) in found.estimate.parameters.iter().zip(&expected.estimate.parameters) {
        let (a, b, sigma) = (a.value.unwrap(), b.value.unwrap(), b.sigma.unwrap());
        // The estimates differ only by rounding when positions are multiplied by the ratio. This is far below the noise.
        assert!((a - b).abs() < 1e-6 * (sigma + b.abs()), "{a} {b}");
    }
}

/// The signals have new values at 125 Hz but are logged at 500 Hz. Estimate and standard deviations equal the result of a log at
/// 125 Hz.
#[test]
fn a_held_log_has_the_rows_of_its_own_rate() {
    let (model, good) = ur5();
    let held = changed(&good, |log| {
        for series in log.q.iter_mut().chain(&mut log.dq).chain(&mut log.tau) {
            *series = (0..series.len()).map(|r| series[r - r % 4]).collect();
        }
    });
    let source = opened(&model, &held, "held");
    assert!(source.report().to_string().contains("new values come 125 times a second"), "{}", source.report());
    assert!(!opened(&model, &good, "fresh").report().to_string().contains("times a second"));
    let [found, expected] =
        [source, opened(&model, &good.every(4), "fourth")].map(|s| identified(&model, s, &Options::default()).estimate);
    let hertz = |e: &rist::Estimate| e.cutoff.unwrap();
    assert!((hertz(&found) / hertz(&expected) - 1.0).abs() < 0.05, "{} {}", hertz(&found), hertz(&expected));
    // The first new value comes one row (8 ms) later than in the other log.
    assert!(found.rows.abs_diff(expected.rows) <= 12, "{} {}", found.rows, expected.rows);
    for (a, b) in found.parameters.iter().zip(&expected.parameters) {
        let ratio = a.sigma.unwrap() / b.sigma.unwrap();
        assert!((0.7..1.4).contains(&ratio), "{}: {ratio}", a.id);
    }
}

/// CSV text of the log. Velocities pass a first-order filter of `filter` Hz; the column ddq holds accelerations or a false
/// signal.
fn with_columns(log: &JointLog, filter: Option<f64>, is_acceleration: bool) -> String {
    let joints = log.q.len();
    let names = |what: &str| (1..=joints).map(|k| format!("{what}{k}")).collect::<Vec<_>>().join(",");
    let mut text = format!("t,{},{},{},{}\n", names("q"), names("dq"), names("ddq"), names("tau"));
    let mut behind: Vec<f64> = log.dq.iter().map(|dq| dq[0]).collect();
    for r in 1..log.t.len() - 1 {
        let step = log.t[r] - log.t[r - 1];
        let share = filter.map_or(1.0, |hz| 1.0 - (-std::f64::consts::TAU * hz * step).exp());
        behind.iter_mut().zip(&log.dq).for_each(|(x, dq)| *x += share * (dq[r] - *x));
        let slope = |dq: &Vec<f64>| (dq[r + 1] - dq[r - 1]) / (2.0 * step);
        // A wrong acceleration signal: nine times the slope of the velocity half a second earlier.
        let before = r.saturating_sub(250).max(1);
        let other = |dq: &Vec<f64>| 9.0 * (dq[before + 1] - dq[before - 1]) / (2.0 * step);
        let rates: Vec<f64> = log.dq.iter().map(|dq| if is_acceleration { slope(dq) } else { other(dq) }).collect();
        let at = |series: &[Vec<f64>]| series.iter().map(|x| x[r]).collect::<Vec<f64>>();
        let row: Vec<String> =
            [at(&log.q), behind.clone(), rates, at(&log.tau)].concat().iter().map(f64::to_string).collect();
        let _ = writeln!(text, "{},{}", log.t[r], row.join(","));
    }
    text
}

#[test]
fn columns_of_rates_are_claimed_by_their_slopes() {
    let (model, good) = ur5();
    let said = |name: &str, filter: Option<f64>, is_acceleration: bool| {
        let path = folder("signals").join(format!("{name}.csv"));
        std::fs::write(&path, with_columns(&good, filter, is_acceleration)).unwrap();
        let (source, _) = model.open_log(&path, &Default::default()).unwrap();
        let log_check = rist::examine(&model, &[source], &Options::default()).unwrap();
        let claims: Vec<String> = claims_of_log(&log_check, &[]).iter().map(ToString::to_string).collect();
        assert!(log_check.findings.is_empty(), "{name}: {:?}", log_check.findings);
        ["velocity column", "acceleration column"]
            .map(|column| claims.iter().find(|c| c.starts_with(column)).cloned().unwrap())
    };
    let [velocity, acceleration] = said("good_rates", None, true);
    assert!(velocity.contains("agrees; a fault of 2 ms of lag would have shown"), "{velocity}");
    assert!(acceleration.contains("agrees"), "{acceleration}");
    // With steps h of 2 ms, a first-order filter of 10 Hz, p = exp(-2 pi 10 h), lags by h p / (1 - p) = 14.9 ms.
    let [velocity, acceleration] = said("late_rates", Some(10.0), false);
    assert!(velocity.contains("assumed by default: the slopes of the positions"), "{velocity}");
    assert!(velocity.contains("lag them by 14.9 ms"), "{velocity}");
    assert!(acceleration.contains("assumed by default: the slopes of the velocities"), "{acceleration}");
}

/// Opens a log of the folder `../shared/findings/inputs`. An error is returned as text.
fn public(model: &Model, path: &Path, options: &Options) -> Result<LogSource, String> {
    model.open_log(path, &options.columns).map(|(log, _)| log).map_err(|e| e.to_string())
}

/// The logs of users on which these faults were first seen get the right findings.
#[test]
fn the_public_files_end_as_they_should() {
    let Some(shared) = shared() else { return };
    let inputs = shared.join("findings/inputs");
    if !inputs.is_dir() {
        return;
    }
    let field = |name: &str| inputs.join("field/logs").join(format!("{name}.csv.gz"));
    let arm = Model::read(inputs.join("field/a0_arm.urdf")).unwrap();
    let fault = |name: &str| {
        let source = public(&arm, &field(name), &Options::default()).unwrap();
        let options = changed_gains(&source);
        rist::examine(&arm, &[source], &options).unwrap().findings.first().map(|f| (f.fault, f.remedy.clone()))
    };
    assert!(matches!(fault("two_publishers"), Some((Fault::TwoSources(rows), _)) if rows > 1000));
    let (found, remedy) = fault("dxl_unsigned").unwrap();
    assert!(found == Fault::RawWords && remedy.contains("two's complement"), "{remedy}");
    let (found, remedy) = fault("feetech_signmag_tau").unwrap();
    assert!(found == Fault::RawWords && remedy.contains("from 1024 on as 1024 - x"), "{remedy}");
    for name in ["good", "held", "held_tau", "jitter", "joint_side_50hz"] {
        assert_eq!(fault(name), None, "{name}");
    }
    let bursts = public(&arm, &field("bursts"), &Options::default()).err().unwrap();
    assert!(bursts.contains("arrived in bursts") && bursts.contains("multiply by 0.00499"), "{bursts}");
    // In this log, positions are angles of the motors. With the gear ratios, the inertia of joint 1 is right.
    let mut options = Options::default();
    options.transmission.ratios = Some(vec![121.0, 121.0, 101.0]);
    let found = identified(&arm, public(&arm, &field("motor_side_50hz"), &options).unwrap(), &options).estimate;
    let first = found.parameters.iter().find(|p| p.id.to_string() == "ZZR_j1").unwrap();
    assert!((first.value.unwrap() - 0.308).abs() < 3.0 * first.sigma.unwrap() + 0.01, "{first:?}");
    assert!(found.total.unwrap() < 0.02, "{:?}", found.total);
}

/// Options in which currents count as torques: each drive gain is 1.
fn changed_gains(source: &LogSource) -> Options {
    let mut options = Options::default();
    if source.effort_is() == logs::Effort::Current {
        options.transmission.drive_gains = Some(vec![1.0; 3]);
    }
    options
}

/// The current loop of a drive oscillates at 105 Hz. The default cut-off follows the motion nevertheless, and the large
/// parameters are right within 2 %.
#[test]
fn a_chattering_drive_does_not_decide_the_cutoff() {
    let Some(shared) = shared() else { return };
    let folder = shared.join("findings/inputs/statistics/lag1ms");
    if !folder.is_dir() {
        return;
    }
    let model = Model::read(folder.join("r3g.yaml")).unwrap();
    let mut options = Options::default();
    options.transmission.drive_gains = Some(vec![2.393, 0.870, 1.0]);
    options.friction = vec![FrictionTerm::Asymmetric];
    let logs: Vec<LogSource> =
        (1..=8).map(|k| public(&model, &folder.join(format!("e0{k}.csv.gz")), &options).unwrap()).collect();
    let found = rist::identify(&model, &logs, &request(&options)).unwrap();
    assert!(found.estimate.cutoff.unwrap() < 50.0, "{:?}", found.estimate.cutoff);
    assert!(found.log_check.findings.is_empty(), "{:?}", found.log_check.findings);
    let described = found.described_parameters.as_ref().unwrap();
    let largest = described.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    for (p, truth) in found.estimate.parameters.iter().zip(described).filter(|(_, x)| x.abs() > 0.2 * largest) {
        assert!((p.value.unwrap() / truth - 1.0).abs() < 0.02, "{}: {:?} for {truth}", p.id, p.value);
    }
}

/// A log without a clock: positions, velocities and torques are in separate files with equal column names. If the rate and the
/// columns are given as options, the estimate equals the estimate from the complete log. Without a rate the log is refused; the
/// message proposes the rate that follows from the velocities.
#[test]
fn a_log_without_a_clock_in_two_files_is_the_log() {
    let here = folder("clockless");
    let (model, good) = ur5();
    let table = |series: &[Vec<f64>]| {
        let mut text = "Joint_1,Joint_2,Joint_3,Joint_4,Joint_5,Joint_6\n".to_string();
        for r in 0..good.t.len() {
            let row: Vec<String> = series.iter().map(|x| format!("{:?}", x[r])).collect();
            writeln!(text, "{}", row.join(",")).unwrap();
        }
        text
    };
    for (name, series) in [("pos.csv", &good.q), ("vel.csv", &good.dq), ("tau.csv", &good.tau)] {
        std::fs::write(here.join(name), table(series)).unwrap();
    }
    let path = std::path::PathBuf::from(
        ["pos.csv", "vel.csv", "tau.csv"].map(|name| here.join(name).display().to_string()).join("+"),
    );
    let rate = 1.0 / (good.t[1] - good.t[0]);
    let names = |rate: Option<f64>| -> Options {
        let rate = rate.map_or(String::new(), |rate| format!("rate: {rate}, "));
        let columns = r#"position: "pos.Joint_{}", velocity: "vel.Joint_{}", torque: "tau.Joint_{}""#;
        Options::parse("o.yaml", &format!("columns: {{{rate}{columns}}}")).unwrap()
    };
    let refused = model.open_log(&path, &names(None).columns).err().unwrap().to_string();
    assert!(refused.contains(&format!("agree with the velocities at {rate:.0} Hz")), "{refused}");
    let proposed = rist::propose_columns(&model.robot, &path, None, None).unwrap().to_string();
    // The velocities determine the rate, which the message states.
    let shown = format!("rate: {rate:.0} ");
    for line in [r#"position: "pos.Joint_{}""#, r#"torque: "tau.Joint_{}""#, shown.as_str()] {
        assert!(proposed.contains(line), "{line}: {proposed}");
    }
    let options = names(Some(rate));
    let (source, columns) = model.open_log(&path, &options.columns).unwrap();
    assert!(columns.to_string().contains("rows per second, as given"), "{columns}");
    let found = identified(&model, source, &options).estimate;
    let whole = identified(&model, opened(&model, &good, "whole_clock"), &Options::default()).estimate;
    for (found, whole) in found.parameters.iter().zip(&whole.parameters) {
        // The clock of the complete file is rounded to 1e-6 s; the clock from the given rate is exact; the period is 5 ms.
        let (found, whole, sigma) = (found.value.unwrap(), whole.value.unwrap(), whole.sigma_or_infinity());
        assert!((found - whole).abs() <= 0.05 * sigma, "{found} {whole} {sigma}");
    }
}
