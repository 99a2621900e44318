//! Bias, rms error and coverage of the 95 % intervals of the estimators, over many simulated experiments of a pendulum.
//!
//! For a whole arm, `cargo bench -p tests --bench synthetic` computes the same numbers.

use experiments::simulate::dynamics::torque;
use identification::estimate::identify::identify;
use identification::estimate::options::Options;
use identification::estimators::consistent::{Prior, consistent};
use identification::estimators::huber::reweighted;
use identification::estimators::loss::Loss;
use identification::estimators::replicate_deviation::{replicate_deviation, state_bands};
use identification::estimators::weighted::{Weights, fit};
use identification::rows::observation::{Observation, weighted};
use identification::rows::residual_sums::residual_sums;
use identification::signals::signal_options::Signal;
use linear_model::friction::terms::sign;
use linear_model::linear_model::Model;
use linear_model::regressor::Regressor;
use linear_model::standard_map::StandardMap;
use linear_model::states::States;
use logs::Log;
use nalgebra::DMatrix;
use random::Random;
use tests::benchmark::robots::pendulum;
use tests::benchmark::tally::Tally;
use tests::joint_log::even_log;
use tests::tape_robot::TapeRobot;

/// Standard deviation of the torque noise, N m.
const NOISE: f64 = 0.1;

/// Largest |bias| of a parameter, rms error over the parameters (both divided by the Cramer-Rao bound), and coverage of the
/// intervals.
fn summary(tally: &Tally, name: &str) -> (f64, f64, f64) {
    let (bias, rmse, coverage) = (tally.bias(), tally.rmse(), tally.coverage());
    println!("{name:<28} bias {bias:6.2}  RMSE/CRLB {rmse:6.2}  coverage {:5.1} %", 100.0 * coverage);
    (bias, rmse, coverage)
}

/// Noise-free states of a motion with two harmonics, sampled every 10 ms.
fn states(arm: &TapeRobot, len: usize) -> States {
    let mut states = States { n: 1, period: 0.01, ..States::default() };
    for r in 0..len {
        let t = 0.01 * r as f64;
        let (w1, w2) = (2.0, 5.1);
        let q = (w1 * t).sin() + 0.3 * (w2 * t).cos();
        let dq = w1 * (w1 * t).cos() - 0.3 * w2 * (w2 * t).sin();
        let ddq = -w1 * w1 * (w1 * t).sin() - 0.3 * w2 * w2 * (w2 * t).cos();
        states.t.push(t);
        states.q.push(q);
        states.dq.push(dq);
        states.direction.push(sign(dq));
        states.ddq.push(ddq);
        states.tau.extend(torque(arm, &arm.truth, &[q], &[dq], &[ddq]));
        states.used.push(true);
    }
    states
}

/// Cramer-Rao standard deviations of the parameters, computed at noise-free states.
fn bound(model: &Model, states: &States) -> Vec<f64> {
    let (solution, _) = fit(&Observation::of(model, states, 1).joints(|_| true), Weights::None);
    (0..model.p()).map(|c| NOISE * solution.inverse[(c, c)].sqrt()).collect()
}

/// The factor by which a variance that is estimated from twenty blocks is inflated: the 95 % quantile of Student's t with 19
/// degrees of freedom, divided by the quantile of the normal distribution, squared.
fn student_variance_ratio() -> f64 {
    let [of_parts, normal] = [19.0, f64::INFINITY].map(|freedom| numerics::student::two_sided_quantile(0.05, freedom));
    (of_parts / normal).powi(2)
}

#[test]
fn estimators_against_the_bound() {
    let arm = pendulum();
    let model = Model::new(&arm, &[], &[]);
    let clean = states(&arm, 400);
    let bound = bound(&model, &clean);
    let mut random = Random::new(71);
    let mut ratios = 0.0;
    let mut tallies: [Tally; 6] = Default::default();
    for _ in 0..300 {
        let (mut white, mut spikes, mut slow) = (clean.clone(), clean.clone(), clean.clone());
        let mut drift = 0.0;
        for r in 0..clean.len() {
            let e = NOISE * random.normal();
            white.tau[r] += e;
            spikes.tau[r] += if random.uniform() < 0.05 { 20.0 * NOISE } else { e };
            drift = 0.9 * drift + (1.0f64 - 0.81).sqrt() * e;
            slow.tau[r] += drift;
        }
        let solve = |states: &States, weights| fit(&Observation::of(&model, states, 1).joints(|_| true), weights);
        let sigma = |s: &numerics::least_squares::Solution| -> Vec<f64> {
            (0..model.p()).map(|c| (s.variance * s.inverse[(c, c)]).sqrt()).collect()
        };
        let (ols, _) = solve(&white, Weights::None);
        let huber = reweighted(&model, std::slice::from_ref(&white), &ols, Loss::Huber).unwrap().solution;
        tallies[0].add(&ols.x, &arm.truth, &bound, &sigma(&ols));
        tallies[1].add(&huber.x, &arm.truth, &bound, &sigma(&huber));
        let (ols, _) = solve(&spikes, Weights::None);
        let found = reweighted(&model, std::slice::from_ref(&spikes), &ols, Loss::Huber).unwrap();
        let (huber, weights) = (&found.solution, &found.weights);
        let records = std::slice::from_ref(&spikes);
        let bands = state_bands(&model, &found.observation, weights, Some(&found));
        let bands = residual_sums(&model, records, &huber.x, bands).unwrap();
        let wide = replicate_deviation(&model, &found.observation, huber, weights, Some(&found), bands);
        let ratio = (0..3).map(|c| (wide.by_part[c] / sigma(huber)[c]).powi(2)).sum::<f64>() / 3.0;
        ratios += ratio / 300.0;
        tallies[2].add(&ols.x, &arm.truth, &bound, &sigma(&ols));
        tallies[3].add(&huber.x, &arm.truth, &bound, &sigma(huber));
        let observation = Observation::of(&model, &slow, 20);
        let (ols, weights) = fit(&observation.joints(|_| true), Weights::Joint);
        let bands = state_bands(&model, &observation, &weights, None);
        let bands = residual_sums(&model, std::slice::from_ref(&slow), &ols.x, bands).unwrap();
        let wide = replicate_deviation(&model, &observation, &ols, &weights, None, bands);
        tallies[4].add(&ols.x, &arm.truth, &bound, &sigma(&ols));
        tallies[5].add(&ols.x, &arm.truth, &bound, &wide.sigma());
    }
    let names = [
        "OLS, white",
        "Huber, white",
        "OLS, 5 % outliers",
        "Huber, 5 % outliers",
        "WLS, slow noise",
        "robust, slow noise",
    ];
    let s: Vec<_> = tallies.iter().zip(names).map(|(t, n)| summary(t, n)).collect();
    // With 300 runs, the standard error is 0.06 for a bias, 0.7 % for a coverage, and 4 % for the rms error.
    assert!(s[0].0 < 0.2 && (0.88..1.12).contains(&s[0].1) && (0.92..0.98).contains(&s[0].2));
    assert!(s[1].0 < 0.2 && (0.88..1.18).contains(&s[1].1), "95 % efficiency");
    assert!((0.92..0.98).contains(&s[1].2), "Huber's variance: {}", s[1].2);
    // The residuals are white except for outliers, and robust weights limit the influence of these. So the variance from blocks
    // equals the variance for white noise, except for the factor of Student's t for twenty blocks.
    assert!((0.8..1.25).contains(&(ratios / student_variance_ratio())), "{ratios}");
    assert!(s[3].1 < 0.6 * s[2].1 && s[3].0 < 0.5 * s[2].0, "outliers pull the robust estimate less");
    assert!(s[4].2 < 0.7, "intervals for white noise do not hold in slow noise: {}", s[4].2);
    // 400 samples with a correlation of 0.9 are equivalent to 20 independent ones. With so few, 89 % of the intervals contain the
    // true value. The limit is lower by three standard errors of 900 intervals.
    assert!(s[5].2 > 0.85, "robust intervals hold better: {}", s[5].2);
}

/// A body whose ten parameters are all measured. The constraint of physical consistency improves an estimate from poor data, and
/// does not change an estimate from good data.
#[test]
fn consistency_helps_poor_data_only() {
    let body = [0.30, 0.01, -0.02, 0.28, 0.015, 0.20, 0.4, -0.1, 0.2, 2.0];
    let standard = (0..10).map(|i| format!("P{i}")).collect();
    let matrix = DMatrix::identity(10, 10);
    let map = StandardMap { standard, matrix, bodies: vec![("body".into(), 0)], rotors: Vec::new() };
    let mut random = Random::new(72);
    for (noise, improvement) in [(0.01, (0.99, 1.01)), (3.0, (0.0, 0.8))] {
        let (mut ls, mut bodies) = (0.0, 0.0);
        for _ in 0..40 {
            let mut rows = numerics::triangle::TriangleBuilder::new(10);
            for _ in 0..60 {
                let row: Vec<f64> = (0..10).map(|_| random.normal()).collect();
                let y: f64 = row.iter().zip(body).map(|(a, b)| a * b).sum();
                rows.push(&row, y + noise * random.normal());
            }
            let white = weighted(&[rows.finish()], &[1.0 / noise]);
            let free = numerics::least_squares::solve(&white);
            let prior = Prior { bodies: vec![None], scale: 1.0, gamma: 1e-3, discount: 1.0, friction: Vec::new() };
            let constrained = consistent(&white, &map, &prior);
            for c in 0..10 {
                ls += (free.x[c] - body[c]).powi(2);
                bodies += (constrained.x[c] - body[c]).powi(2);
            }
        }
        let ratio = (bodies / ls).sqrt();
        println!("noise {noise}: error of the consistent estimate over least squares {ratio:.3}");
        assert!(ratio >= improvement.0 && ratio <= improvement.1, "noise {noise}: {ratio}");
    }
}

/// A noise-free simulated log is written to a file and identified by the whole program. The result is the true parameters up to
/// rounding.
#[test]
fn noise_free_logs_give_the_truth_back() {
    let arm = pendulum();
    let states = states(&arm, 500);
    let effort = states.dq.iter().zip(&states.tau).map(|(v, t)| t + 0.4 * v + 0.7 * v.signum()).collect();
    let log = even_log(arm.coordinates(), 0.01, [vec![states.q], vec![states.dq], vec![effort]]);
    let log = Log { ddq: Some(vec![states.ddq]), ..log };
    let signal = Signal { order: 0, ..Signal::default() };
    let estimate = identify(&arm, &log, &Options { signal, ..Options::default() }).unwrap();
    let truth = [("ZZ1", 0.3), ("MX1", 0.8), ("MY1", -0.1), ("FV1", 0.4), ("FS1", 0.7), ("OFF1", 0.0)];
    for (name, value) in truth {
        // Tolerance for the rounding of 500 rows with a condition number of ten.
        assert!((estimate.value(&name.parse().unwrap()).unwrap() - value).abs() < 1e-12, "{name}: {estimate}");
    }
}
