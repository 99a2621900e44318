//! Tests of logs in which one joint moves and the other joints are at rest. Parameters that are not identifiable get no value,
//! and no use that needs them is trusted.

use claims::Outcome;
use identification::estimate::topics::{MOUNT, ROTOR, SCALE, SPRING, ZERO};
use rist::Model;
use rist::fit::verdict::Trust;
use rist::request::IdentifyRequest;
use tests::joint_log::unlike;
use tests::model_path;
use tests::program::folder;
use tests::random::{Random, State};
use tests::recursion;

/// No parameter of these robots has a larger magnitude: kg, kg m, kg m^2, and friction.
const LARGEST_PARAMETER: f64 = 300.0;

/// Position at which the other joints stand, and how their encoders measure it.
#[derive(Clone, Copy)]
struct Standing {
    pose: f64,
    /// Standard deviation of the measured positions, rad (m).
    noise: f64,
    /// Resolution of the encoders, rad (m); 0: no rounding.
    step: f64,
}

/// CSV text of a log of eight seconds at 100 Hz. `joint` swings; `standing` describes the other joints, which are at rest.
fn log(model: &Model, joint: usize, standing: Standing) -> String {
    let (n, truth) = (model.robot.n_coordinates(), unlike(&model.robot, 4));
    let mut random = Random(5);
    let names = model.regressor().coordinates();
    let header = |quantity: &str| names.iter().map(|name| format!("{quantity}_{name}")).collect::<Vec<_>>().join(",");
    let mut rows = format!("t,{},{}\n", header("q"), header("tau"));
    for i in 0..800 {
        let t = 0.01 * f64::from(i);
        let at = |k: usize, d: usize| {
            let of = |a: f64, w: f64| [a * (w * t).sin(), a * w * (w * t).cos(), -a * w * w * (w * t).sin()][d];
            let pose = if d == 0 { standing.pose * (0.4 + 0.3 * k as f64) } else { 0.0 };
            pose + if k == joint { of(0.4, 2.0) + of(0.15, 5.1) } else { 0.0 }
        };
        let of = |d: usize| (0..n).map(|k| at(k, d)).collect::<Vec<f64>>();
        let state = State { q: of(0), dq: of(1), ddq: of(2) };
        let tau = recursion::torque(&model.robot, &state, &truth);
        let mut row = vec![t];
        for q in &state.q {
            let read = q + standing.noise * random.unit();
            row.push(if standing.step > 0.0 { (read / standing.step).round() * standing.step } else { read });
        }
        for (tau, dq) in tau.iter().zip(&state.dq) {
            let friction = if *dq == 0.0 { 0.0 } else { 0.5 * dq.signum() };
            row.push(tau + friction + 0.05 * random.unit());
        }
        rows += &(row.iter().map(|x| format!("{x:?}")).collect::<Vec<_>>().join(",") + "\n");
    }
    rows
}

#[test]
fn what_one_joint_does_not_tell_has_no_value_and_no_use() {
    let exact = Standing { pose: 0.0, noise: 0.0, step: 0.0 };
    let noisy = Standing { pose: 1.0, noise: 1e-5, step: 0.0 };
    let coarse = Standing { pose: 1.0, noise: 1e-5, step: 1e-4 };
    for file in
        ["kuka_lwr.yaml", "ur5.urdf", "panda.yaml", "tx40.yaml", "stanford.yaml", "scara.yaml", "cartesian3p.yaml"]
    {
        let model = Model::read(model_path(file)).unwrap();
        for joint in 0..model.robot.n_coordinates() {
            for (standing, consistent) in [(exact, false), (noisy, false), (coarse, joint == 1)] {
                judged(&model, file, joint, standing, consistent);
            }
        }
    }
}

fn judged(model: &Model, file: &str, joint: usize, standing: Standing, consistent: bool) {
    let names = model.regressor().coordinates();
    let path = folder("standing").join(format!("{file}_{joint}_{}.csv", standing.step));
    std::fs::write(&path, log(model, joint, standing)).unwrap();
    let (source, _) = model.open_log(&path, &Default::default()).unwrap();
    let request = IdentifyRequest { consistent, ..Default::default() };
    let mut found = rist::identify(model, &[source], &request).unwrap();
    let verdict = found.verdict_of_logs(model, &[], false).unwrap().verdict;
    let at = format!("{file}, joint {}, {} +- {}", joint + 1, standing.pose, standing.noise);
    for p in &found.estimate.parameters {
        let is_possible = |x: Option<f64>| x.is_none_or(|x| x.abs() < LARGEST_PARAMETER);
        assert!(
            is_possible(p.value) && is_possible(p.sigma) && p.prediction().abs() < LARGEST_PARAMETER,
            "{at}: {p:?}"
        );
    }
    // Gravity compensation is excepted, because it may be trusted: the weight of a lift is identifiable at rest, and the other
    // joints have no gravity torque.
    for used in verdict.uses.iter().filter(|used| used.name != "gravity compensation") {
        assert_eq!(used.trust, Trust::No, "{at}: {verdict}");
    }
    assert_eq!(verdict.trust, Trust::No, "{at}: {verdict}");
    for claim in verdict.claims.iter().filter(|claim| matches!(claim.outcome(), Outcome::Agrees { .. })) {
        let subject = claim.subject();
        let is_of_another = subject.of.iter().any(|name| *name != names[joint]);
        let is_told = [MOUNT, ROTOR, SCALE, SPRING, ZERO].contains(&subject.topic) && is_of_another;
        assert!(!is_told, "{at}: {claim}");
    }
}
