//! Drive gains from the data: torque per unit of current, one joint's gain known.
//!
//! W_j X - k_j i_j = 0 for joints of unknown gain, W_j X = k_j i_j for those of known gain: linear in
//! (X, k). Currents are noisy columns, so least squares shrinks k; the maximum-likelihood estimate
//! divides each row by k_j,
//!   min sum_j |i_j - W_j X / k_j|^2 / sigma_j^2,
//! and is found from it by alternating Gauss-Newton steps [Gautier, Vandanjon, Presse 1994 for the
//! total least squares of the same equations; docs of `total_least_squares`]. Works on the triangles
//! by joint, with currents as right-hand sides.
//!
//! Wrist joints carry little that other joints feel: their gains are weakly observable, and errors of
//! the model decide them. An expected value with its deviation holds them, weighed against the data
//! at what correlated residuals are worth: 1/s, s = (1 + rho) / (1 - rho), rho the residuals'
//! correlation from sample to sample.

use nalgebra::{DMatrix, DVector};

use crate::identify::{Options, Weights, fit, states};
use crate::least_squares::solve;
use crate::log::{Effort, Log};
use crate::observation::{Model, Observation};
use crate::robust::correlation;
use crate::triangle::{Block, Triangle};
use crate::{Error, Regressor};

/// What is known of a joint's gain, N m/A, before the data.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Gain {
    Known(f64),
    /// About this value, with this standard deviation.
    Expected(f64, f64),
    Free,
}

/// Gains and parameters.
#[derive(Clone, Debug)]
pub struct DriveGains {
    /// N m/A, a joint; the known ones as given.
    pub gains: Vec<f64>,
    /// Standard deviation, the discount of the data included; zero for the known ones.
    pub sigma: Vec<f64>,
    /// Parameters of the columns, SI.
    pub x: Vec<f64>,
    /// Standard deviation of the current's residual, A, a joint.
    pub noise: Vec<f64>,
    /// How many correlated samples count as one.
    pub discount: f64,
    pub iterations: usize,
}

const ITERATIONS: usize = 50;

/// From triangles by joint (currents on the right), what is known of the gains, and the discount of
/// the data (1: independent samples).
///
/// Fails when no gain is known or expected: the scale of everything is then free; and when a gain is
/// not determined by these data.
pub fn drive_gains(joints: &[Triangle], known: &[Gain], discount: f64) -> Result<DriveGains, Error> {
    let n = joints.len();
    if known.len() != n || known.iter().all(|k| *k == Gain::Free) {
        let message = format!(
            "{n} drive gains, at least one of them known, are needed: data alone leave the scale of all gains and masses free"
        );
        return Err(Error::new(message));
    }
    let p = joints.first().map_or(0, Triangle::columns);
    let unknown: Vec<usize> = (0..n).filter(|&j| !matches!(known[j], Gain::Known(_))).collect();
    // Least squares in torque, expected gains held, is the start.
    let start = |k: &Gain| match k {
        Gain::Known(value) | Gain::Expected(value, _) => Some(*value),
        Gain::Free => None,
    };
    let held: Vec<Option<f64>> = known.iter().map(start).collect();
    let free: Vec<usize> = (0..n).filter(|&j| held[j].is_none()).collect();
    let (mut x, mut gains) = linear(joints, &held, &free)?;
    let discount = discount.max(1.0);
    let noises = |gains: &[f64], x: &[f64]| -> Vec<f64> {
        noises(joints, gains, x).iter().map(|s| s * discount.sqrt()).collect()
    };
    let (mut noise, mut iterations) = (noises(&gains, &x), 0);
    let mut normal = DMatrix::identity(0, 0);
    for iteration in 0..ITERATIONS {
        iterations = iteration + 1;
        let (step, matrix) = gauss_newton(joints, &unknown, known, &x, &gains, &noise).ok_or_else(|| {
            Error::new("the drive gains are not determined by these data: excite the coupling of joints")
        })?;
        // A gain changes by at most half in one step: it keeps its sign.
        let change = unknown.iter().enumerate().map(|(i, &j)| (step[p + i] / gains[j]).abs()).fold(0.0, f64::max);
        let length = if change > 0.5 { 0.5 / change } else { 1.0 };
        for c in 0..p {
            x[c] += length * step[c];
        }
        for (i, &j) in unknown.iter().enumerate() {
            gains[j] += length * step[p + i];
        }
        (noise, normal) = (noises(&gains, &x), matrix);
        if change < 1e-10 {
            break;
        }
    }
    let covariance = normal.try_inverse().unwrap_or_else(|| DMatrix::zeros(p + unknown.len(), p + unknown.len()));
    let mut sigma = vec![0.0; n];
    for (i, &j) in unknown.iter().enumerate() {
        sigma[j] = covariance[(p + i, p + i)].max(0.0).sqrt();
    }
    let noise = noise.iter().map(|s| s / discount.sqrt()).collect();
    Ok(DriveGains { gains, sigma, x, noise, discount, iterations })
}

/// Gains from logs of motor currents; `known` where a gain is known, everything else as in `options`.
///
/// Fails as `identify` does, for logs without currents, and as [`drive_gains`] does.
pub fn estimate_drive_gains(
    regressor: &dyn Regressor,
    logs: &[Log],
    options: &Options,
    known: &[Gain],
) -> Result<DriveGains, Error> {
    if let Some(log) = logs.iter().find(|l| l.effort_is != Effort::Current) {
        return Err(Error::at(&log.name, 0, "the log holds torques; drive gains are estimated from currents"));
    }
    let mut options = options.clone();
    options.transmission.drive_gains = Some(vec![1.0; regressor.coordinates().len()]);
    let couplings = options.transmission.coupled();
    let model = Model::new(regressor, &options.friction, &couplings);
    let records = logs.iter().map(|log| states(regressor, log, &options)).collect::<Result<Vec<_>, _>>()?;
    let joints = Observation::of_records(&model, records.as_slice(), None)?.joints(|_| true);
    let (currents, _) = fit(&joints, Weights::Joint);
    let rho = records.iter().map(|s| correlation(&model, s, &currents.x)).fold(0.0, f64::max).min(0.999);
    drive_gains(&joints, known, (1.0 + rho) / (1.0 - rho))
}

/// Least squares for (X, k) in torque.
fn linear(joints: &[Triangle], known: &[Option<f64>], unknown: &[usize]) -> Result<(Vec<f64>, Vec<f64>), Error> {
    let p = joints.first().map_or(0, Triangle::columns);
    let m = p + unknown.len();
    let (mut total, mut block) = (Triangle::new(m), Block::new(m));
    for (j, t) in joints.iter().enumerate() {
        for i in 0..=p {
            if block.is_full() {
                total.fold(&mut block);
            }
            let mut row = vec![0.0; m];
            (i..p).for_each(|c| row[c] = t.at(i, c));
            let current = t.at(i, p);
            let y = match known[j] {
                Some(gain) => gain * current,
                None => {
                    let c = unknown.iter().position(|&u| u == j).unwrap_or(0);
                    row[p + c] = -current;
                    0.0
                }
            };
            block.push(&row, y);
        }
    }
    total.fold(&mut block);
    let solution = solve(&total);
    if let Some(i) = (0..unknown.len()).find(|i| !solution.determined[p + i] || solution.x[p + i] == 0.0) {
        let message = format!("the drive gain of joint {} is not determined by these data", unknown[i] + 1);
        return Err(Error::new(message));
    }
    let mut gains: Vec<f64> = known.iter().map(|k| k.unwrap_or(1.0)).collect();
    unknown.iter().enumerate().for_each(|(i, &j)| gains[j] = solution.x[p + i]);
    Ok((solution.x[..p].to_vec(), gains))
}

/// Root mean square of i_j - W_j X / k_j.
fn noises(joints: &[Triangle], gains: &[f64], x: &[f64]) -> Vec<f64> {
    let noise = |(t, k): (&Triangle, &f64)| {
        let scaled: Vec<f64> = x.iter().map(|x| x / k).collect();
        let (total, residual) = t.squares(&scaled);
        (residual.max(1e-20 * total) / t.rows.max(1) as f64).sqrt().max(f64::MIN_POSITIVE)
    };
    joints.iter().zip(gains).map(noise).collect()
}

/// One step for (X, k) and the normal matrix; `None` when it is singular.
fn gauss_newton(
    joints: &[Triangle],
    unknown: &[usize],
    known: &[Gain],
    x: &[f64],
    gains: &[f64],
    noise: &[f64],
) -> Option<(DVector<f64>, DMatrix<f64>)> {
    let p = x.len();
    let m = p + unknown.len();
    let mut normal = DMatrix::zeros(m, m);
    let mut rhs = DVector::zeros(m);
    let xv = DVector::from_column_slice(x);
    for (j, t) in joints.iter().enumerate() {
        let (k, s) = (gains[j], noise[j]);
        let r = DMatrix::from_fn(p + 1, p, |i, c| if i <= c { t.at(i, c) } else { 0.0 });
        let z = DVector::from_fn(p + 1, |i, _| t.at(i, p));
        let fit = &r * &xv / k;
        let mut jacobian = DMatrix::zeros(p + 1, m);
        jacobian.view_mut((0, 0), (p + 1, p)).copy_from(&(r / k));
        if let Some(i) = unknown.iter().position(|&u| u == j) {
            jacobian.column_mut(p + i).copy_from(&(-&fit / k));
        }
        jacobian /= s;
        normal += jacobian.transpose() * &jacobian;
        rhs += jacobian.transpose() * ((z - fit) / s);
    }
    for (i, &j) in unknown.iter().enumerate() {
        if let Gain::Expected(value, deviation) = known[j] {
            normal[(p + i, p + i)] += 1.0 / (deviation * deviation);
            rhs[p + i] += (value - gains[j]) / (deviation * deviation);
        }
    }
    let d = normal.diagonal().map(|x: f64| if x > 0.0 { 1.0 / x.sqrt() } else { 1.0 });
    let scaled = DMatrix::from_fn(m, m, |i, j| normal[(i, j)] * d[i] * d[j]);
    let step = scaled.cholesky()?.solve(&rhs.component_mul(&d)).component_mul(&d);
    Some((step, normal))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    /// Two joints that share two parameters, currents with noise.
    fn joints(noise: f64, seed: u64) -> Vec<Triangle> {
        let (x, k) = ([2.0, -1.0], [3.0, 0.5]);
        let mut random = Random::new(seed);
        let mut out = vec![Triangle::new(2), Triangle::new(2)];
        for (j, t) in out.iter_mut().enumerate() {
            let mut block = Block::new(2);
            for _ in 0..500 {
                let row = [random.normal(), random.normal()];
                let torque = row[0] * x[0] + row[1] * x[1];
                block.push(&row, torque / k[j] + noise * random.normal());
                if block.is_full() {
                    t.fold(&mut block);
                }
            }
            t.fold(&mut block);
        }
        out
    }

    #[test]
    fn gains_come_back_exactly_without_noise() {
        let found = drive_gains(&joints(0.0, 1), &[Gain::Known(3.0), Gain::Free], 1.0).unwrap();
        assert!((found.gains[1] - 0.5).abs() < 1e-10, "{found:?}");
        assert!((found.x[0] - 2.0).abs() < 1e-10);
    }

    /// Noise of a third of the current: least squares in torque is 10 % low, maximum likelihood is not.
    #[test]
    fn noise_does_not_shrink_the_gain() {
        let runs = 60;
        let (mut mean, mut chi) = (0.0, 0.0);
        for seed in 0..runs {
            let found = drive_gains(&joints(1.5, 100 + seed), &[Gain::Known(3.0), Gain::Free], 1.0).unwrap();
            mean += found.gains[1] / runs as f64;
            chi += ((found.gains[1] - 0.5) / found.sigma[1]).powi(2) / runs as f64;
        }
        // The standard error of the mean is about 0.006.
        assert!((mean - 0.5).abs() < 0.02, "{mean}");
        assert!((0.5..1.7).contains(&chi), "{chi}");
    }

    /// With hardly any data the expected value stays; with good data it gives way.
    #[test]
    fn an_expected_gain_is_weighed_against_the_data() {
        let expected = [Gain::Known(3.0), Gain::Expected(0.8, 0.1)];
        let weak = drive_gains(&joints(0.1, 3), &expected, 1e9).unwrap();
        assert!((weak.gains[1] - 0.8).abs() < 0.01, "{weak:?}");
        let strong = drive_gains(&joints(0.01, 3), &expected, 1.0).unwrap();
        assert!((strong.gains[1] - 0.5).abs() < 0.01, "{strong:?}");
    }

    #[test]
    fn the_scale_must_be_given() {
        let message = drive_gains(&joints(0.0, 1), &[Gain::Free; 2], 1.0).unwrap_err().to_string();
        assert!(message.contains("at least one of them known"), "{message}");
    }
}
