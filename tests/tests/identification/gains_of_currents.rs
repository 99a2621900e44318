//! Drive gains are estimated by least squares from currents. Their errors agree with their standard deviations.

use identification::estimate::drive_gains::estimate_drive_gains;
use identification::estimate::identify::with_deviations;
use identification::estimate::options::Options;
use identification::estimators::drive_gains::likelihood::Gain;
use identification::signals::signal_options::Signal;
use linear_model::regressor::Regressor;
use logs::{Effort, Log, LogSource};
use nalgebra::{DMatrix, DVector};
use random::Random;
use tests::joint_log::even_log;
use tests::model;
use tests::tape_robot::TapeRobot;

/// True drive gains, N m/A.
const GAINS: [f64; 2] = [11.5, 7.0];

/// Standard deviation of the currents, A.
const NOISE: f64 = 0.05;

/// A log of twelve seconds of a moving arm, with noise-free currents.
fn currents(arm: &TapeRobot) -> Log {
    let (len, period) = (1200, 0.01);
    let [mut q, mut dq, mut ddq, mut current] = [(); 4].map(|()| vec![Vec::new(); 2]);
    for r in 0..len {
        let t = period * r as f64;
        let [p, v, a, tau] = arm.swing_of_two(t);
        for j in 0..2 {
            q[j].push(p[j]);
            dq[j].push(v[j]);
            ddq[j].push(a[j]);
            current[j].push(tau[j] / GAINS[j]);
        }
    }
    let log = even_log(arm.coordinates(), period, [q, dq, current]);
    Log { ddq: Some(ddq), effort_is: Effort::Current, ..log }
}

/// Mean squares over the draws, in this order: error of the gain of q2, divided by its standard deviation; errors of the
/// parameters, divided by their standard deviations; variance of the gain; e' C^-1 e / p for all parameters (e: errors, C:
/// covariance, p: number).
///
/// The noise has the correlation `rho` between samples. If `expected` is given, an expected gain is drawn with this standard
/// deviation.
fn errors(rho: f64, expected: Option<f64>) -> [f64; 4] {
    let arm = TapeRobot::new(model("planar2r_vertical.yaml"));
    let clean = currents(&arm);
    let signal = Signal { order: 0, ..Signal::default() };
    let options = Options { signal, friction: Vec::new(), ..Options::default() };
    let mut random = Random::new(31);
    let draws = 480;
    let mut sums = [0.0; 4];
    for _ in 0..draws {
        let mut log = clean.clone();
        for current in &mut log.effort {
            let mut noise = NOISE * random.normal();
            for i in current.iter_mut() {
                noise = rho * noise + (1.0 - rho * rho).sqrt() * NOISE * random.normal();
                *i += noise;
            }
        }
        let free = expected.map_or(Gain::Free, |sigma| Gain::Expected(GAINS[1] + sigma * random.normal(), sigma));
        let known = [Gain::Known(GAINS[0]), free];
        let found = estimate_drive_gains(&arm, &[LogSource::Held(log)], &options, &known).unwrap();
        let errors = found.parameters.iter().zip(&arm.truth).zip(&found.deviation);
        let squares: Vec<f64> = errors.map(|((x, truth), sigma)| ((x - truth) / sigma).powi(2)).collect();
        let sigma = found.gain_deviation[1];
        let p = found.parameters.len();
        let covariance = with_deviations(&found.covariance, &found.deviation);
        let error = DVector::from_fn(p, |c, _| found.parameters[c] - arm.truth[c]);
        let information = DMatrix::from_fn(p, p, |i, j| covariance[i][j]).try_inverse().unwrap();
        let one = [
            ((found.gain[1] - GAINS[1]) / sigma).powi(2),
            squares.iter().sum::<f64>() / squares.len() as f64,
            sigma * sigma,
            error.dot(&(information * &error)) / p as f64,
        ];
        sums.iter_mut().zip(one).for_each(|(sum, one)| *sum += one / f64::from(draws));
    }
    println!("rho {rho}, expected {expected:?}: {sums:?}");
    sums
}

#[test]
fn gains_and_parameters_err_by_what_they_say() {
    // With 480 draws, a mean square has a standard error of 7 %. The standard deviation from twenty blocks varies, and is
    // intentionally too large for white noise (`replicate_deviation`), by up to 1.4.
    for (rho, honest) in [(0.0, 0.45..1.4), (0.9, 0.6..1.6)] {
        let [gain, parameters, _, together] = errors(rho, None);
        let all = [gain, parameters, together];
        assert!(all.iter().all(|x| honest.contains(x)), "{rho}: {all:?}");
    }
}

/// An expected gain is weighted by its standard deviation. If this standard deviation equals the standard deviation of the gain
/// from the log alone, the combination has half the variance.
#[test]
fn an_expected_gain_counts_by_its_deviation() {
    let [_, _, of_data, _] = errors(0.9, None);
    let [gain, parameters, variance, _] = errors(0.9, Some(of_data.sqrt()));
    assert!((0.6..1.6).contains(&gain) && (0.6..1.6).contains(&parameters), "{gain} {parameters}");
    assert!((0.4..0.65).contains(&(variance / of_data)), "{variance} {of_data}");
    let [gain, _, variance, _] = errors(0.9, Some(0.01 * of_data.sqrt()));
    assert!((0.6..1.4).contains(&gain) && (variance / of_data / 1e-4 - 1.0).abs() < 0.01, "{gain} {variance}");
}
