//! Mount, zeros, scales and springs as unknowns beside the parameters: on logs of the simulator of `random_situations`
//! each comes out within its own deviation, and the parameters with it.

use identification::estimate::ledger::hypotheses::Hypothesis;
use logs::ColumnNames;
use rist::Model;
use rist::request::{IdentifyRequest, Unknown};
use rist::samples::Identification;
use tests::random_situations::Situation;
use tests::random_situations::defects::{Defect, Kind};
use tests::random_situations::draw::Draw;
use tests::random_situations::robots::machine;
use tests::random_situations::sensors::{Noise, Sensors, zero};

/// A machine with one defect at a joint, good sensors, its own description, and rotors that are none.
fn situation(seed: u64, kind: Kind, joint: usize, size: f64) -> Situation {
    let mut machine = machine(&mut Draw::of(seed, 1));
    machine.chain.joints.iter_mut().for_each(|j| j.rotor = 0.0);
    machine.described = Some(machine.chain.joints.iter().map(|j| j.body).collect());
    let defect = Defect { kind, joint, other: 0, size, more: 0.25 };
    let sensors = Sensors { rate: 200.0, noise: Noise::White, level: 0.002, bits: None, speed: Some(0.0005) };
    Situation { sensors, ..Situation::with(seed, machine, vec![defect]) }
}

fn identified(situation: &Situation, unknowns: &[Unknown]) -> Identification {
    let model = situation.model();
    let (log, _) = model.log_of_table(situation.log(0), &ColumnNames::default()).unwrap();
    let mut request = IdentifyRequest::default();
    request.samples.unknowns = unknowns.to_vec();
    rist::identify(&model, &[log], &request).unwrap()
}

/// Of a normal error 1 in 3.5 million is beyond five deviations; t of the nine freedoms of the jackknife, 1 in 1400.
const DEVIATIONS: f64 = 5.0;

/// The values that were found, each with its truth and deviation, of joints that the log tells.
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
        let Some(step) = found.unknowns.iter().find(|s| s.of == of(k)) else { continue };
        let Some((_, deviation)) = step.told else { continue };
        let (off, deviation) = (value[k] - exact[k], deviation * share[k]);
        assert!(off.abs() < DEVIATIONS * deviation, "seed {seed}, {k}: {} for {} +- {deviation}", value[k], exact[k]);
        told += 1;
    }
    assert!(told > 0, "seed {seed}: nothing is told");
}

/// A zero of seven degrees at the second joint; the other zeros are where they are described.
#[test]
fn zeros_come_out() {
    for seed in [5, 25] {
        let situation = situation(seed, Kind::Zero, 1, 0.12);
        let found = identified(&situation, &[Unknown::Zeros]);
        let offsets = found.estimate.options.as_ref().unwrap().transmission.offsets.clone().unwrap();
        let exact: Vec<f64> = (0..offsets.len()).map(|k| zero(&situation.machine, &situation.defects, k)).collect();
        assert_true(seed, &found, Hypothesis::Zero, &offsets, &exact, &vec![1.0; offsets.len()]);
        let said = &found.estimate.remarks[0];
        assert!(said.starts_with("zeros: ") && said.contains("transmission: {offsets: ["), "{said}");
        assert!(found.estimate.remarks.iter().all(|remark| !remark.contains("do not settle")), "seed {seed}");
        assert_held_are_said(&found);
    }
}

/// The parts of the remark on zeros: one a joint, of those that were asked for.
fn zeros_said(found: &Identification) -> Vec<&str> {
    let remark = found.estimate.remarks.iter().find_map(|r| r.strip_prefix("zeros: ")).expect("a remark on zeros");
    remark.split(';').next().unwrap().split(", ").filter(|part| !part.starts_with("within ")).collect()
}

/// A zero is said to be held where the prior told it, and only there; every other one is said with its deviation.
fn assert_held_are_said(found: &Identification) -> usize {
    let said = zeros_said(found);
    let zeros: Vec<_> = found.unknowns.iter().filter(|s| matches!(s.of, Hypothesis::Zero(_))).collect();
    assert_eq!(said.len(), zeros.len(), "{said:?}");
    for (said, zero) in said.iter().zip(&zeros) {
        assert_eq!(said.ends_with(" is held to what it was"), zero.told.is_some() && zero.is_prior, "{said}");
        assert_eq!(said.contains(" +- "), zero.told.is_some() && !zero.is_prior, "{said}");
    }
    zeros.iter().filter(|zero| zero.is_prior).count()
}

/// The first axis of an upright arm is along gravity: its zero leaves no trace in a log. The description holds it, that is
/// said, and the others and the mount come out.
#[test]
fn a_zero_about_gravity_is_held_and_said() {
    let model = Model::read(tests::model_path("ur5.urdf")).unwrap();
    let log = tests::workspace().join("docs/ur5/log.csv");
    let (log, _) = model.open_log(&log, &ColumnNames::default()).unwrap();
    let mut request = IdentifyRequest::default();
    request.samples.unknowns = vec![Unknown::Zeros, Unknown::Mount];
    let found = rist::identify(&model, &[log], &request).unwrap();
    let said = zeros_said(&found);
    assert!(said[0].starts_with("shoulder_pan cannot be told and is held to what it was"), "{said:?}");
    assert_eq!(assert_held_are_said(&found), 1, "{said:?}");
    assert!(found.estimate.remarks.iter().all(|remark| !remark.contains("do not settle")));
}

/// A torque that is a quarter too large beside the others. Of all scales one is not told, and the others count from it.
#[test]
fn scales_come_out() {
    for seed in [5, 25] {
        let situation = situation(seed, Kind::ScaleOfJoint, 1, 0.22);
        let found = identified(&situation, &[Unknown::Scales]);
        let scales = found.estimate.options.as_ref().unwrap().transmission.scales.clone().unwrap();
        let mut exact = vec![1.0; scales.len()];
        exact[1] = situation.defects[0].factor();
        assert_true(seed, &found, Hypothesis::Scale, &scales, &exact, &scales);
    }
}

/// A spring at the second joint, which the option takes out again.
#[test]
fn springs_come_out() {
    for seed in [5, 25] {
        let situation = situation(seed, Kind::Spring, 1, 0.5);
        let found = identified(&situation, &[Unknown::Springs]);
        let springs = found.estimate.options.as_ref().unwrap().transmission.springs.clone().unwrap();
        let mut exact = vec![0.0; springs.len()];
        exact[1] = situation.defects[0].size * situation.machine.size[1] / situation.machine.chain.joints[1].range;
        assert_true(seed, &found, Hypothesis::Spring, &springs, &exact, &vec![1.0; springs.len()]);
    }
}

/// A base that leans by twenty degrees: gravity as the found mount has it is that of the machine.
#[test]
fn the_mount_comes_out() {
    for seed in [5, 25] {
        let situation = situation(seed, Kind::Tilt, 0, 0.35);
        let found = identified(&situation, &[Unknown::Mount]);
        let model = situation.model();
        let gravity = found.used(&model).robot.gravity_number();
        let exact = situation.defects[0].tilted(situation.machine.chain.gravity);
        let off = (0..3).map(|i| (gravity[i] - exact[i]).powi(2)).sum::<f64>().sqrt() / 9.81;
        let both =
            (0..2).filter_map(|axis| Some(found.unknowns.iter().find(|s| s.of == Hypothesis::Mount(axis))?.told?.1));
        let deviation = both.map(|deviation| deviation * deviation).sum::<f64>().sqrt();
        assert!(deviation > 0.0 && off < DEVIATIONS * deviation, "seed {seed}: {off} rad +- {deviation}");
        let said = &found.estimate.remarks[0];
        assert!(said.starts_with("mount: ") && said.contains("[base=") && said.contains("<origin rpy="), "{said}");
    }
}
