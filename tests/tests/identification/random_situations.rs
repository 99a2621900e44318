//! Tests of the simulator that the bench `random_situations` uses: it conserves energy, and its torques agree with rist and with
//! the Newton-Euler recursion of the tests. Five of its situations end with a verdict.

use rist::Model;
use rist::fit::verdict::Trust;
use tests::random::{Random, State};
use tests::random_situations::Situation;
use tests::random_situations::chain::Chain;
use tests::random_situations::defects::{Defect, Kind};
use tests::random_situations::draw::Draw;
use tests::random_situations::motion::Motion;
use tests::random_situations::robots::{chain_of, gantry, machine, mirrored_arms, scara};
use tests::random_situations::sensors::{Noise, Sensors};
use tests::random_situations::torque::{FINE, series, standing};
use tests::random_situations::truth::truth;
use tests::recursion;

/// Seeds of situations with different robots.
const SEEDS: std::ops::RangeInclusive<u64> = 1..=5;

fn rms(x: &[f64]) -> f64 {
    (x.iter().map(|x| x * x).sum::<f64>() / x.len() as f64).sqrt()
}

/// The power of the joint torques equals the rate of the energy: d(T + V)/dt = dq' tau. T, V: kinetic and potential energy.
#[test]
fn the_power_of_the_torques_becomes_energy() {
    /// Step of the central differences, s. Their error is about STEP^2 times the third derivative of the energy.
    const STEP: f64 = 1e-4;
    let of_seed = |seed| machine(&mut Draw::of(seed, 1));
    let others = [gantry, scara, mirrored_arms].map(|draws| draws(&mut Draw::of(1, 1)));
    for (seed, machine) in SEEDS.zip(SEEDS.map(of_seed)).chain((6..).zip(others)) {
        let chain = machine.chain;
        let motion = Motion::of_use(&chain, &mut Draw::of(seed, 2));
        let energy = |t: f64| {
            let now = motion.at(t);
            let (kinetic, potential) = chain.energy(&now.q, &now.dq);
            kinetic + potential
        };
        let (mut power, mut difference) = (Vec::new(), Vec::new());
        for i in 1..200 {
            let t = 0.02 * f64::from(i);
            let now = motion.at(t);
            let tau = chain.torque(&now.q, &now.dq, &now.ddq);
            power.push(tau.iter().zip(&now.dq).map(|(tau, dq)| tau * dq).sum::<f64>());
            difference.push((energy(t + STEP) - energy(t - STEP)) / (2.0 * STEP) - power[power.len() - 1]);
        }
        assert!(rms(&difference) < 1e-5 * rms(&power), "seed {seed}: {} of {}", rms(&difference), rms(&power));
    }
}

/// If the second of two mirrored arms moves as the mirror image of the first, it has the torques of the first, with the sign of
/// the motion: with M = diag(1, -1, 1), M Rz(q) M = Rz(-q) and M Tz(r) M = Tz(r). If the columns of the sides are swapped, the
/// signals of one arm have the names of the other.
#[test]
fn mirrored_arms_take_mirrored_torques() {
    for seed in SEEDS {
        let mut machine = mirrored_arms(&mut Draw::of(seed, 1));
        let n = machine.chain.len() / 2;
        for k in 0..n {
            let scale = machine.chain.joints[k].body.mass / machine.chain.joints[k + n].body.mass;
            let body = &mut machine.chain.joints[k + n].body;
            body.mass *= scale;
            body.inertia.iter_mut().flatten().for_each(|x| *x *= scale);
        }
        let sign: Vec<f64> = machine.chain.joints.iter().map(|j| if j.slides { 1.0 } else { -1.0 }).collect();
        let mut random = Random(seed);
        let mut both = || {
            let left: Vec<f64> = (0..n).map(|_| random.unit()).collect();
            let right = left.iter().zip(&sign).map(|(x, s)| s * x);
            left.iter().copied().chain(right).collect::<Vec<f64>>()
        };
        let tau = machine.chain.torque(&both(), &both(), &both());
        // Rounding: about a thousand operations with an error of 1e-16 each.
        let size = tau.iter().fold(1e-3, |m: f64, x| m.max(x.abs()));
        (0..n).for_each(|k| assert!((tau[k + n] - sign[k] * tau[k]).abs() < 1e-11 * size, "seed {seed}: {tau:?}"));

        let sides = Defect { kind: Kind::Sides, joint: 0, other: 1, size: 1.0, more: 0.0 };
        let [right, exchanged] = [Vec::new(), vec![sides]].map(|defects| {
            let machine = mirrored_arms(&mut Draw::of(seed, 1));
            let sensors = Sensors { rate: 100.0, noise: Noise::None, level: 0.0, bits: None, speed: Some(0.0) };
            Situation { sensors, ..Situation::with(seed, machine, defects) }.log(0).columns
        });
        for signal in 0..3 {
            for k in 0..n {
                let (left, other) = (1 + 2 * n * signal + k, 1 + 2 * n * signal + n + k);
                assert_eq!((&right[left], &right[other]), (&exchanged[other], &exchanged[left]));
            }
        }
    }
}

#[test]
fn the_torque_is_that_of_the_recursion() {
    for file in ["ur5.urdf", "puma560.yaml", "scara.yaml", "planar2r_vertical.yaml"] {
        let robot = tests::model(file);
        let chain = chain_of(&robot);
        let value = |p: &robot::StandardParameter| match p.inertial {
            robot::Inertial::Ia => 0.0,
            _ => p.value(&robot).unwrap_or(0.0),
        };
        let x: Vec<f64> = robot::StandardParameter::all(&robot).iter().map(value).collect();
        let mut random = Random(7);
        for _ in 0..20 {
            let state: State = random.state(&robot);
            let theirs = recursion::torque(&robot, &state, &x);
            let ours = chain.torque(&state.q, &state.dq, &state.ddq);
            let size = theirs.iter().fold(1e-3, |m: f64, x| m.max(x.abs()));
            // Rounding: about a thousand operations with an error of 1e-16 each; both use gravity 9.81 m/s^2.
            theirs.iter().zip(&ours).for_each(|(a, b)| assert!((a - b).abs() < 1e-11 * size, "{file}: {a} {b}"));
        }
    }
}

/// The simulator and the description have the same bodies. The base regressor represents the true torques up to rounding, and the
/// nominal base parameters of an exact description equal the true ones.
#[test]
fn the_description_is_the_machine() {
    for seed in SEEDS {
        let mut machine = machine(&mut Draw::of(seed, 1));
        machine.chain.joints.iter_mut().for_each(|j| j.rotor = 0.0);
        machine.described = Some(machine.chain.joints.iter().map(|j| j.body).collect());
        let situation = Situation::with(seed, machine, Vec::new());
        let model: Model = situation.model();
        let truth = truth(&situation.machine.chain, model.regressor(), &[]);
        // The description writes angles with sixteen digits; the condition number of the columns is at most some thousand.
        assert!(truth.left < 1e-9, "seed {seed}: {:e}", truth.left);
        let described = model.nominal_parameters().unwrap_or_default();
        assert_eq!(described.len(), truth.base.len());
        let size = truth.base.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        for (a, b) in described.iter().zip(&truth.base) {
            assert!((a - b).abs() < 1e-7 * size, "seed {seed}: {a} {b}");
        }
    }
}

/// If a log has no noise and exact sensors, each row contains the torque of its own state, up to rounding.
#[test]
fn a_clean_log_is_the_motion() {
    let machine = machine(&mut Draw::of(3, 1));
    let situation = Situation {
        sensors: Sensors { rate: 250.0, noise: Noise::None, level: 0.0, bits: None, speed: Some(0.0) },
        ..Situation::with(3, machine, Vec::new())
    };
    let (table, n) = (situation.log(0), situation.machine.chain.len());
    for r in (10..table.rows()).step_by(101) {
        let now = situation.motions[0].at(table.columns[0][r]);
        let tau = situation.machine.chain.torque(&now.q, &now.dq, &now.ddq);
        for k in 0..n {
            let (joint, friction) = (&situation.machine.chain.joints[k], situation.machine.friction[k]);
            let direction = if now.dq[k] == 0.0 { 0.0 } else { now.dq[k].signum() };
            let lost = friction.viscous * now.dq[k] + friction.coulomb * direction + friction.offset;
            let exact = tau[k] + joint.rotor * now.ddq[k] + lost;
            let size = situation.machine.size[k];
            assert!((table.columns[1 + k][r] - now.q[k]).abs() < 1e-12);
            assert!((table.columns[1 + n + k][r] - now.dq[k]).abs() < 1e-12);
            assert!((table.columns[1 + 2 * n + k][r] - exact).abs() < 1e-9 * size, "row {r} joint {k}");
        }
    }
}

/// A log without noise gives the true parameters, up to the errors of the filter and of the differences.
#[test]
fn a_clean_log_gives_the_parameters_back() {
    for seed in SEEDS {
        let mut machine = machine(&mut Draw::of(seed, 1));
        machine.chain.joints.iter_mut().for_each(|j| j.rotor = 0.0);
        let motion = Motion::of_use(&machine.chain, &mut Draw::of(seed, 9));
        let situation = Situation {
            sensors: Sensors { rate: 500.0, noise: Noise::None, level: 0.0, bits: None, speed: Some(0.0) },
            motions: vec![motion],
            ..Situation::with(seed, machine, Vec::new())
        };
        let outcome = situation.outcome(true);
        let judgement = outcome.judgement.unwrap_or_else(|| panic!("seed {seed}: {}", outcome.said));
        // The filter smooths the jump of Coulomb friction at reversals, and central differences have a second-order error.
        assert!(judgement.torque < 2e-3, "seed {seed}: {}", judgement.torque);
        assert!(judgement.left < 1e-9, "seed {seed}: {}", judgement.left);
    }
}

/// Each kind of defect changes the log, either in the simulated torque or in the logged signals.
#[test]
fn every_defect_shows_in_the_log() {
    for kind in Kind::ALL {
        let machine = || machine(&mut Draw::of(4, 1));
        let n = machine().chain.len();
        let defect = Defect { more: 0.3, ..Defect::of(kind, n, &mut Draw::of(4, 2)) };
        // The defect must be on a joint that it can affect. This is a revolute joint.
        let turning = machine().chain.joints.iter().position(|j| !j.slides).unwrap_or(0);
        let defect = Defect { joint: turning, other: (turning + 1) % n, ..defect };
        let with = |defects: Vec<Defect>| {
            let situation = Situation::with(4, machine(), defects);
            let sensors = Sensors { speed: Some(1e-4), ..situation.sensors.clone() };
            Situation { sensors, ..situation }.log(0)
        };
        let (clean, faulty) = (with(Vec::new()), with(vec![defect]));
        let is_same = clean.columns == faulty.columns;
        assert!(!is_same, "{kind:?} changes nothing");
        assert!(faulty.columns.iter().flatten().all(|x| x.is_finite()), "{kind:?}");
    }
}

/// With a flexible joint and without friction, the work of the motors equals the change of energy of links, rotors and spring.
#[test]
fn a_flexible_joint_keeps_energy() {
    let mut machine = machine(&mut Draw::of(2, 1));
    machine.friction.iter_mut().for_each(|f| (f.viscous, f.coulomb, f.offset) = (0.0, 0.0, 0.0));
    let defect = Defect { kind: Kind::Flexible, joint: 0, other: 1, size: 12.0, more: 0.0 };
    let chain: Chain = standing(&machine, &[defect], false);
    let motion = Motion::of_use(&chain, &mut Draw::of(2, 2));
    let series = series(&machine, &chain, &motion, &[defect]);
    let stiffness = chain.own_inertia(&vec![0.3; chain.len()])[0].max(1e-4) * (std::f64::consts::TAU * 12.0).powi(2);
    let energy = |i: usize| {
        let of = |x: &[Vec<f64>]| x.iter().map(|x| x[i]).collect::<Vec<f64>>();
        let (kinetic, potential) = chain.energy(&of(&series.q), &of(&series.dq));
        let rotors = (0..chain.len()).map(|k| 0.5 * chain.joints[k].rotor * series.dtheta[k][i].powi(2)).sum::<f64>();
        let bend = series.theta[0][i] - series.q[0][i];
        kinetic + potential + rotors + 0.5 * stiffness * bend * bend
    };
    let power = |i: usize| (0..chain.len()).map(|k| series.tau[k][i] * series.dtheta[k][i]).sum::<f64>();
    let (mut work, mut largest, mut difference) = (0.0, 0.0_f64, 0.0_f64);
    for i in 11..series.steps() - 10 {
        work += 0.5 * (power(i - 1) + power(i)) / FINE;
        largest = largest.max((energy(i) - energy(10)).abs());
        difference = difference.max((energy(i) - energy(10) - work).abs());
    }
    // Error of central differences and of the trapezoidal rule with steps of 1 ms.
    assert!(difference < 1e-3 * largest, "{difference} of {largest}");
}

#[test]
fn five_situations_have_a_verdict() {
    for seed in SEEDS {
        let outcome = Situation::of(seed).outcome(true);
        assert!(outcome.trust.is_some(), "seed {seed}: {}", outcome.said);
        let judgement = outcome.judgement.as_ref();
        // A log in which only one joint moves identifies few parameters.
        let least = if Situation::of(seed).motions.iter().all(|m| m.said.ends_with("alone")) { 0 } else { 4 };
        assert!(judgement.is_some_and(|j| j.torque.is_finite() && j.parameters.len() > least), "seed {seed}");
        if seed == 1 {
            assert_eq!(Situation::of(seed).outcome(true).said, outcome.said);
        }
    }
}

/// Two defects can be explained by other bodies: a zero error that the last body can represent, and a common factor of all
/// torques. If the estimate differs from the description in such a way, the verdict is not a plain yes. Without the defect, the
/// same robot and log get a yes.
#[test]
fn what_free_bodies_explain_is_said_where_the_description_differs() {
    for (seed, kind, sentence) in
        [(24, Kind::Zero, "the zero of joint_2"), (14, Kind::ScaleOfAll, "times those of the description")]
    {
        let robot = || machine(&mut Draw::of(seed, 1));
        assert_eq!(robot().description, "exact");
        for is_wrong in [true, false] {
            let joint = if kind == Kind::Zero { 1 } else { 0 };
            let size = if kind == Kind::Zero { 8f64.to_radians() } else { 1.2f64.ln() };
            let defect = Defect { kind, joint, other: 0, size, more: 0.3 };
            let situation = Situation::with(seed, robot(), if is_wrong { vec![defect] } else { Vec::new() });
            let said = situation.outcome(true);
            let verdict = said.verdict.unwrap_or_else(|| panic!("seed {seed}: {}", said.said));
            let text = verdict.to_string();
            assert_eq!(text.contains(sentence), is_wrong, "seed {seed}: {text}");
            assert_eq!(said.trust == Some(Trust::Yes), !is_wrong, "seed {seed}: {text}");
        }
    }
}
