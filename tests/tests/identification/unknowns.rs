//! Tests of additional unknowns that are estimated together with the parameters: orientation of the base, joint zeros, torque
//! scales and springs. On logs of the simulator `random_situations`, each true value is within the printed standard deviations.

use identification::estimate::claims::hypotheses::Hypothesis;
use identification::estimators::drive_gains::likelihood::Gain;
use identification::signals::transmission::Transmission;
use logs::{ColumnNames, LogSource, Table};
use nalgebra::{Rotation3, Vector3};
use rist::fit::samples::Identification;
use rist::request::{IdentifyRequest, UnknownKind};
use rist::{Model, ModelOptions};
use tests::random_situations::Situation;
use tests::random_situations::defects::{Defect, Kind};
use tests::random_situations::draw::Draw;
use tests::random_situations::robots::machine;
use tests::random_situations::sensors::{Noise, Sensors, zero};

/// A simulated situation with one defect at a joint, good sensors, an exact model file, and no rotor inertia.
fn situation(seed: u64, kind: Kind, joint: usize, size: f64) -> Situation {
    let mut machine = machine(&mut Draw::of(seed, 1));
    machine.chain.joints.iter_mut().for_each(|j| j.rotor = 0.0);
    machine.described = Some(machine.chain.joints.iter().map(|j| j.body).collect());
    let defect = Defect { kind, joint, other: 0, size, more: 0.25 };
    let sensors = Sensors { rate: 200.0, noise: Noise::White, level: 0.002, bits: None, speed: Some(0.0005) };
    Situation { sensors, ..Situation::with(seed, machine, vec![defect]) }
}

fn identified(situation: &Situation, unknowns: &[UnknownKind]) -> Identification {
    identified_by(situation, |request| request.samples.unknowns = unknowns.to_vec())
}

fn identified_by(situation: &Situation, ask: impl FnOnce(&mut IdentifyRequest)) -> Identification {
    let (model, mut request) = (situation.model(), IdentifyRequest::default());
    ask(&mut request);
    rist::identify(&model, &[log(&model, situation.log(0))], &request).unwrap()
}

fn log(model: &Model, table: Table) -> LogSource {
    model.log_of_table(table, &ColumnNames::default()).unwrap().0
}

/// Allowed error in standard deviations. A larger error has a probability of 1 in 3.5 million for a normal distribution, and of 1
/// in 1400 for Student's t with nine degrees of freedom, as the jackknife has.
const DEVIATIONS: f64 = 5.0;

/// Checks that each identified value is within `DEVIATIONS` standard deviations of its true value. `share`: factor for the
/// standard deviation.
fn assert_true(
    seed: u64,
    found: &Identification,
    of: fn(usize) -> Hypothesis,
    value: &[f64],
    exact: &[f64],
    share: &[f64],
) {
    let mut told = 0;
    for k in 0..value.len() {
        let Some(step) = found.decided.unknowns.iter().find(|s| s.of == of(k)) else { continue };
        let Some((_, deviation)) = step.identified else { continue };
        let (off, deviation) = (value[k] - exact[k], deviation * share[k]);
        assert!(off.abs() < DEVIATIONS * deviation, "seed {seed}, {k}: {} for {} +- {deviation}", value[k], exact[k]);
        told += 1;
    }
    assert!(told > 0, "seed {seed}: nothing is told");
}

/// A zero error of 0.12 rad at the second joint is identified; the zeros of the other joints stay as in the description.
#[test]
fn zeros_come_out() {
    for seed in [5, 25] {
        let situation = situation(seed, Kind::Zero, 1, 0.12);
        let found = identified(&situation, &[UnknownKind::Zeros]);
        let offsets = found.estimate.options.as_ref().unwrap().transmission.offsets.clone().unwrap();
        let exact: Vec<f64> = (0..offsets.len()).map(|k| zero(&situation.machine, &situation.defects, k)).collect();
        assert_true(seed, &found, Hypothesis::Zero, &offsets, &exact, &vec![1.0; offsets.len()]);
        let said = &found.estimate.remarks[0];
        assert!(said.starts_with("zeros: ") && said.contains("transmission: {offsets: ["), "{said}");
        assert!(found.estimate.remarks.iter().all(|remark| !remark.contains("do not settle")), "seed {seed}");
        assert_held_are_said(&found);
    }
}

/// The text on each zero in the remark on zeros, in the order of the requested joints.
fn zeros_said(found: &Identification) -> Vec<&str> {
    let remark = found.estimate.remarks.iter().find_map(|r| r.strip_prefix("zeros: ")).expect("a remark on zeros");
    remark.split(';').next().unwrap().split(", ").filter(|part| !part.starts_with("within ")).collect()
}

/// Checks the remark on zeros. If only the prior determines a zero, the remark says that it stays as it was; any other identified
/// zero has a standard deviation. Returns the number of zeros that only the prior determines.
fn assert_held_are_said(found: &Identification) -> usize {
    let said = zeros_said(found);
    let zeros: Vec<_> = found.decided.unknowns.iter().filter(|s| matches!(s.of, Hypothesis::Zero(_))).collect();
    assert_eq!(said.len(), zeros.len(), "{said:?}");
    for (said, zero) in said.iter().zip(&zeros) {
        assert_eq!(said.ends_with(" of what it was"), zero.identified.is_some() && zero.is_prior, "{said}");
        assert_eq!(said.contains(" +- "), zero.identified.is_some() && !zero.is_prior, "{said}");
    }
    zeros.iter().filter(|zero| zero.is_prior).count()
}

/// The first axis of an upright arm is parallel to gravity, so its zero has no effect on a log. It stays at the nominal value,
/// and the remark says so. The other zeros and the orientation of the base are identified.
#[test]
fn a_zero_about_gravity_is_held_and_said() {
    let model = Model::read(tests::model_path("ur5.urdf")).unwrap();
    let log = tests::workspace().join("docs/ur5/log.csv");
    let (log, _) = model.open_log(&log, &ColumnNames::default()).unwrap();
    let mut request = IdentifyRequest::default();
    request.samples.unknowns = vec![UnknownKind::Zeros, UnknownKind::Mount];
    let found = rist::identify(&model, &[log], &request).unwrap();
    let said = zeros_said(&found);
    assert!(said[0].starts_with("shoulder_pan is not identifiable and stays within"), "{said:?}");
    assert_eq!(assert_held_are_said(&found), 1, "{said:?}");
    assert!(found.estimate.remarks.iter().all(|remark| !remark.contains("do not settle")));
}

/// The torques of the second joint are too large by a factor. One common factor of all scales is unobservable, so one scale is
/// the reference.
#[test]
fn scales_come_out() {
    for seed in [5, 25] {
        let situation = situation(seed, Kind::ScaleOfJoint, 1, 0.22);
        let found = identified(&situation, &[UnknownKind::Scales]);
        let scales = found.estimate.options.as_ref().unwrap().transmission.scales.clone().unwrap();
        let mut exact = vec![1.0; scales.len()];
        exact[1] = situation.defects[0].factor();
        assert_true(seed, &found, Hypothesis::Scale, &scales, &exact, &scales);
    }
}

/// A spring at the second joint is identified. Its stiffness is written to the options.
#[test]
fn springs_come_out() {
    for seed in [5, 25] {
        let situation = situation(seed, Kind::Spring, 1, 0.5);
        let found = identified(&situation, &[UnknownKind::Springs]);
        let springs = found.estimate.options.as_ref().unwrap().transmission.springs.clone().unwrap();
        let mut exact = vec![0.0; springs.len()];
        exact[1] = situation.defects[0].size * situation.machine.size[1] / situation.machine.chain.joints[1].range;
        assert_true(seed, &found, Hypothesis::Spring, &springs, &exact, &vec![1.0; springs.len()]);
    }
}

/// The base is tilted by 0.35 rad. The identified orientation gives the gravity vector of the simulated machine.
#[test]
fn the_mount_comes_out() {
    for seed in [5, 25] {
        let situation = situation(seed, Kind::Tilt, 0, 0.35);
        let found = identified(&situation, &[UnknownKind::Mount]);
        let model = situation.model();
        let gravity = found.used(&model).robot.gravity_number();
        let exact = situation.defects[0].tilted(situation.machine.chain.gravity);
        let off = (0..3).map(|i| (gravity[i] - exact[i]).powi(2)).sum::<f64>().sqrt() / 9.81;
        let both = (0..2).filter_map(|axis| {
            Some(found.decided.unknowns.iter().find(|s| s.of == Hypothesis::Mount(axis))?.identified?.1)
        });
        let deviation = both.map(|deviation| deviation * deviation).sum::<f64>().sqrt();
        assert!(deviation > 0.0 && off < DEVIATIONS * deviation, "seed {seed}: {off} rad +- {deviation}");
        let said = &found.estimate.remarks[0];
        assert!(said.starts_with("mount: ") && said.contains("[base=") && said.contains("<origin rpy="), "{said}");
    }
}

/// Roll and pitch of six base orientations, rad: upright, on two walls, on a ceiling, leaning, and a general rotation.
const MOUNTS: [[f64; 2]; 6] = [
    [0.0, 0.0],
    [std::f64::consts::FRAC_PI_2, 0.0],
    [0.0, std::f64::consts::FRAC_PI_2],
    [std::f64::consts::PI, 0.0],
    [std::f64::consts::FRAC_PI_6, 0.0],
    [1.1, -0.7],
];

/// A machine whose base has this roll and pitch, and its gravity vector, m/s^2. In its description the base is upright.
fn mounted(seed: u64, [roll, pitch]: [f64; 2]) -> (Situation, Vector3<f64>) {
    let mut situation = situation(seed, Kind::Tilt, 0, 0.0);
    let base = Rotation3::from_euler_angles(roll, pitch, 0.0);
    let gravity = base.inverse() * Vector3::from(situation.machine.chain.gravity);
    situation.machine.chain.gravity = gravity.into();
    (situation, gravity)
}

fn number_behind(text: &str, phrase: &str) -> f64 {
    let rest = text.split(phrase).nth(1).unwrap_or_else(|| panic!("no `{phrase}` in {text}"));
    rest.split([' ', ',', ']', ')']).next().unwrap().parse().unwrap_or_else(|e| panic!("{phrase}: {e}: {text}"))
}

/// Roll, pitch and yaw, rad, of the first `[base=..]` in a text.
fn printed_base(text: &str) -> [f64; 3] {
    let values = text.split("[base=").nth(1).and_then(|rest| rest.split(']').next());
    let numbers: Vec<f64> = values.unwrap_or_else(|| panic!("{text}")).split(',').map(|x| x.parse().unwrap()).collect();
    numbers.try_into().unwrap()
}

/// For each base orientation, the error of the gravity direction agrees with the printed standard deviation. The model can be
/// read again with the printed `[base=..]`, or with the description options in the estimate. The result equals the used model,
/// bit by bit.
#[test]
fn any_mount_comes_out_and_is_made_again() {
    for seed in [5, 25] {
        for [roll, pitch] in MOUNTS {
            let (situation, exact) = mounted(seed, [roll, pitch]);
            let found = identified(&situation, &[UnknownKind::Mount]);
            let model = situation.model();
            let used = found.used(&model);
            let off = Vector3::from(used.robot.gravity_number()).angle(&exact).to_degrees();
            let said = found.estimate.remarks.iter().find(|r| r.starts_with("mount: ")).expect("a remark on the mount");
            let deviation = number_behind(said, "of the base +- ");
            assert!(off < DEVIATIONS * deviation, "seed {seed} {roll} {pitch}: {off} deg: {said}");
            // The sensors are good, so the standard deviation must be small. A huge one would make the check above useless.
            assert!(deviation < 1.0, "seed {seed} {roll} {pitch}: {said}");
            assert!(!said.contains("is not identifiable"), "{said}");
            let described = used.description.clone().unwrap();
            assert_eq!(described.base, Some(printed_base(said)), "{said}");
            let read = |options: &ModelOptions| {
                Model::parse(&situation.description(), "situation.urdf", options).unwrap().reference.fingerprint
            };
            let of_estimate = ModelOptions::of_description(found.estimate.description.as_ref().unwrap());
            assert_eq!(read(&of_estimate), used.reference.fingerprint, "seed {seed} {roll} {pitch}");
            let plain = ModelOptions { base: None, ..of_estimate };
            let printed = ModelOptions { base: Some(printed_base(said)), ..Default::default() };
            // Options on the command line replace the same options of the estimate. Other options of the estimate, such as rotor
            // inertias, remain.
            let repeated = printed.over(&plain.description().unwrap_or_default()).unwrap();
            assert_eq!(read(&repeated), used.reference.fingerprint, "seed {seed} {roll} {pitch}");
        }
    }
}

/// The log check proposes the base orientation if it differs from the description. The proposed orientation is accurate within
/// one degree.
#[test]
fn the_line_that_a_verdict_prints_is_where_gravity_is() {
    for [roll, pitch] in &MOUNTS[1..] {
        let (situation, exact) = mounted(25, [*roll, *pitch]);
        let found = identified(&situation, &[]);
        let mount = found.log_check.findings.iter().find(|f| f.remedy.contains("[base="));
        let remedy = &mount.unwrap_or_else(|| panic!("{roll} {pitch}: {:?}", found.log_check.findings)).remedy;
        let [roll, pitch, yaw] = printed_base(remedy);
        let turn = Rotation3::from_euler_angles(roll, pitch, yaw);
        let off = (turn.inverse() * Vector3::new(0.0, 0.0, -9.81)).angle(&exact).to_degrees();
        // The nominal bodies are exact here, so the error comes only from the log.
        assert!(off < 1.0, "{roll} {pitch}: {off} deg: {remedy}");
        assert!(remedy.contains("[unknowns=mount]"), "{remedy}");
    }
}

/// A log of currents with known gains gives the same base orientation as a log of torques.
#[test]
fn the_mount_of_a_log_of_currents() {
    let situation = situation(5, Kind::Tilt, 0, 0.35);
    let model = situation.model();
    let torques = identified(&situation, &[UnknownKind::Mount]);
    let mut table = situation.log(0);
    let gains: Vec<(String, Gain)> =
        model.regressor().coordinates().iter().map(|name| (name.clone(), Gain::Known(4.0))).collect();
    let is_torque = |k: usize| table.header[k].starts_with("tau_");
    for k in (0..table.header.len()).filter(|&k| is_torque(k)).collect::<Vec<_>>() {
        table.header[k] = table.header[k].replace("tau_", "i_");
        // The factor between currents and torques is a power of two, so the torques are equal bit by bit.
        table.columns[k].iter_mut().for_each(|x| *x *= 0.25);
    }
    let mut request = IdentifyRequest::default();
    request.samples.unknowns = vec![UnknownKind::Mount];
    request.samples.gain = gains;
    let currents = rist::identify(&model, &[log(&model, table)], &request).unwrap();
    assert_eq!(currents.estimate.description, torques.estimate.description);
    assert!(currents.estimate.description.unwrap().base.is_some());
}

/// In a log without springs, no spring is estimated, and a remark says so. The estimate equals the estimate without springs as
/// unknowns.
#[test]
fn springs_that_are_not_told_are_not_taken() {
    for seed in [5, 25] {
        let situation = situation(seed, Kind::Spring, 1, 0.0);
        let (found, plain) = (identified(&situation, &[UnknownKind::Springs]), identified(&situation, &[]));
        assert_eq!(found.estimate.options.as_ref().unwrap().transmission, Transmission::default(), "seed {seed}");
        assert_eq!(found.estimate.parameters, plain.estimate.parameters, "seed {seed}");
        let said = &found.estimate.remarks[0];
        assert!(
            said.starts_with("springs: ") && said.contains("not taken, because below 6 sigma: ") && !said.contains('['),
            "{said}"
        );
        // If one joint has a spring, only this spring is estimated; the remark names the others.
        let found = identified(&self::situation(seed, Kind::Spring, 1, 0.5), &[UnknownKind::Springs]);
        let springs = found.estimate.options.as_ref().unwrap().transmission.springs.clone().unwrap();
        let taken: Vec<usize> = (0..springs.len()).filter(|&k| springs[k] != 0.0).collect();
        assert_eq!(taken, [1], "seed {seed}: {}", found.estimate.remarks[0]);
    }
}

/// Springs and scales change the torque that is fitted. The relative errors still refer to the measured torque, even if springs
/// and scales are absurd: rms divided by relative error gives the rms of the measured torque, for the fit and for a predicted
/// log.
#[test]
fn errors_are_relative_to_the_torque_as_measured() {
    for seed in [5, 25] {
        let situation = situation(seed, Kind::Spring, 1, 0.5);
        let model = situation.model();
        let n = model.regressor().coordinates().len();
        let source = [log(&model, situation.log(0))];
        let of = |springs: Option<Vec<f64>>, scales: Option<Vec<f64>>| {
            let found = identified_by(&situation, |request| {
                let mut options = request.samples.options();
                (options.transmission.springs, options.transmission.scales) = (springs, scales);
                request.samples.rows.signals.options = Some(options);
            });
            let used = found.used(&model);
            let predicted = rist::validate(used, &found.estimate, &source).unwrap();
            let series =
                rist::fit::validation::predicted_torques(used, &found.estimate, &source).unwrap().swap_remove(0);
            let measured: Vec<f64> = found.estimate.joints.iter().map(|joint| joint.rms / joint.relative).collect();
            let validated: Vec<f64> = predicted.joints.iter().map(|joint| joint.rms / joint.relative).collect();
            let square: f64 = found.estimate.joints.iter().map(|j| j.rms * j.rms * j.rows as f64).sum();
            let whole: f64 = measured.iter().zip(&found.estimate.joints).map(|(x, j)| x * x * j.rows as f64).sum();
            (measured, validated, series.measured, found.estimate.total.unwrap() / (square / whole).sqrt())
        };
        let (exact, _, series, _) = of(None, None);
        let springs: Vec<f64> = (0..n).map(|k| if k == 1 { 3000.0 } else { 0.0 }).collect();
        let scales: Vec<f64> = (0..n).map(|k| if k == 1 { 0.1 } else { 1.0 }).collect();
        for (springs, scales) in
            [(Some(springs.clone()), None), (None, Some(scales.clone())), (Some(springs), Some(scales))]
        {
            let (measured, validated, drawn, total) = of(springs.clone(), scales.clone());
            for (j, exact) in exact.iter().enumerate() {
                // A zero-phase filter is linear, so only rounding remains. The tolerance is large because the measured torque is
                // a thousand times smaller than the torque of the spring.
                assert!((measured[j] / exact - 1.0).abs() < 1e-6, "seed {seed}, {j}: {} {exact}", measured[j]);
                assert!((validated[j] / exact - 1.0).abs() < 1e-6, "seed {seed}, {j}: {} {exact}", validated[j]);
            }
            // The total over joints is not checked for robots with prismatic joints, since N m and N cannot be added.
            let slides = (0..n).any(|k| model.regressor().is_prismatic(k));
            assert!(slides || (total - 1.0).abs() < 1e-9, "seed {seed}: {total}");
            let largest = series.iter().fold(0.0f64, |m, x| m.max(x.abs()));
            assert!(series.iter().zip(&drawn).all(|(a, b)| (a - b).abs() < 1e-6 * largest), "seed {seed}");
        }
    }
}
