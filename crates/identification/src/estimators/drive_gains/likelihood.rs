//! Drive gains, N m/A, estimated together with the parameters from currents.
//!
//! The equation of joint j, after the elimination of friction and other nuisance parameters, is
//!
//! (D_j X + t_j) / k_j = I_j + noise,
//!
//! where D_j are rows of the regressor, X the parameters, k_j the gain, N m/A, I_j the currents, A, and t_j the torque of a
//! known load, N m. Currents alone determine gains and parameters only up to one common factor, unless one gain is known or t is
//! not zero [Gautier, Briot 2014, for the load]. Only the currents are noisy, so the maximum-likelihood estimate needs no
//! scaling of columns,
//!
//! min sum_j |I_j - g_j (D_j X + t_j)|^2 / s_j^2,   g_j = 1/k_j,
//!
//! which is found by Gauss-Newton. The iteration starts from least squares in torque, which underestimates k. s_j, the standard
//! deviation of the noise of the currents, is 1 if the weights of the rows already contain the noise. Otherwise s_j follows
//! from the residual of the joint at the present X and g.
//!
//! The equations come from filtered samples of any motion (`estimate::drive_gains`) or from the experiments of a plan
//! (`spectrum::rist_mh::gains`, `spectrum::identify`). `total_least_squares` solves them with another method.
//!
//! [Gautier, Vandanjon, Presse 1994; Vandanjon, Gautier, Desbats 1995, section 4.2]

use logs::Error;
use nalgebra::DMatrix;
use numerics::least_squares::{Solution, solve};
use numerics::triangle::{Triangle, TriangleBuilder};
use numerics::vector::dot;

use crate::estimators::drive_gains::equations::JointEquations;

/// Prior knowledge of a drive gain, N m/A.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Gain {
    /// The gain is known without error.
    Known(f64),
    /// The gain is expected near the first value. The second value is the standard deviation of this expectation.
    Expected(f64, f64),
    /// The gain is to be estimated.
    Free,
}

impl Gain {
    /// Whether the gain is estimated from the data.
    pub(crate) fn is_unknown(&self) -> bool {
        !matches!(self, Gain::Known(_))
    }
}

/// The estimated drive gains and parameters.
#[derive(Clone, Debug)]
pub struct DriveGains {
    /// Gain of each joint, N m/A. A known gain is returned unchanged.
    pub gain: Vec<f64>,
    /// Standard deviations of the gains, N m/A; 0 for a known gain.
    pub gain_deviation: Vec<f64>,
    /// Covariance of the logarithms of the gains for white noise, n x n; zero for a known gain.
    pub gain_covariance: DMatrix<f64>,
    /// For each joint, whether the data determine the gain; true for a known gain.
    pub gain_determined: Vec<bool>,
    /// The parameters X with these gains.
    pub parameters: Vec<f64>,
    /// Standard deviations of X, including the uncertainty of the gains.
    pub deviation: Vec<f64>,
    /// Covariance of X for white noise. The error of a gain makes the parameters of its joint correlated.
    pub covariance: DMatrix<f64>,
    /// For each parameter, whether the data determine the parameter.
    pub determined: Vec<bool>,
    /// Standard deviation of the noise of the currents of each joint, A. The value is 1 if the weights of the rows contain the
    /// noise.
    pub noise: Vec<f64>,
    /// Number of Gauss-Newton steps. `None`: the iteration did not converge.
    pub steps: Option<usize>,
    /// Condition number of the linearised equations with scaled columns.
    pub condition_number: f64,
}

/// Largest number of Gauss-Newton steps.
const MAX_GAUSS_NEWTON_STEPS: usize = 50;
/// Largest relative change of 1/gain in one step. This value is below one, so that a gain keeps its sign.
const LARGEST_GAIN_CHANGE: f64 = 0.5;
/// The iteration ends if no unknown changes by more than this many standard deviations.
const SETTLED_CHANGE_SIGMAS: f64 = 1e-6;
/// The iteration also ends if no gain changes by more than this share. Without noise in the data, this share is at the level of
/// rounding.
const SETTLED_GAIN_CHANGE: f64 = 1e-10;

/// Estimates gains and parameters by maximum likelihood. `joints`: equations of each joint; `known`: prior knowledge of each
/// gain.
///
/// Fails if nothing fixes the common scale: no gain is known or expected, and no torque is known. The result marks gains and
/// parameters that the data do not determine.
pub fn drive_gains(joints: &[JointEquations], known: &[Gain]) -> Result<DriveGains, Error> {
    check_scale(joints, known)?;
    let n = joints.len();
    let p = joints.iter().find_map(|e| e.rows.first()).map_or(0, Vec::len);
    let unknown: Vec<usize> = (0..n).filter(|&j| known[j].is_unknown()).collect();
    let (mut x, mut gain) = least_squares(joints, known);
    let mut g: Vec<f64> = gain.iter().map(|k| 1.0 / k).collect();
    let noises = |x: &[f64], g: &[f64], used: &dyn Fn(usize) -> f64| -> Vec<f64> {
        (0..n).map(|j| joints[j].noise(x, g[j], used(j))).collect()
    };
    // Gauss-Newton in (X, g = 1/gain). The noise of each joint is computed from its residual and its degrees of freedom.
    let mut noise = noises(&x, &g, &|_| 0.0);
    let (mut steps, mut last) = (None, solve(&Triangle::new(p + unknown.len())));
    for step in 0..MAX_GAUSS_NEWTON_STEPS {
        last = gauss_newton(joints, known, &unknown, &x, &g, &noise);
        let used = used(joints, &unknown, &x, &g, &noise, &last);
        let change = unknown.iter().enumerate().map(|(i, &j)| (last.x[p + i] / g[j]).abs()).fold(0.0, f64::max);
        let length = if change > LARGEST_GAIN_CHANGE { LARGEST_GAIN_CHANGE / change } else { 1.0 };
        x.iter_mut().zip(&last.x).for_each(|(x, d)| *x += length * d);
        unknown.iter().enumerate().for_each(|(i, &j)| g[j] += length * last.x[p + i]);
        noise = noises(&x, &g, &|j| used[j]);
        if in_sigmas(&last) < SETTLED_CHANGE_SIGMAS || change < SETTLED_GAIN_CHANGE {
            steps = Some(step + 1);
            break;
        }
    }
    // With k = 1/g: sigma(k) = sigma(g) / g^2, cov(ln k_i, ln k_j) = cov(g_i, g_j) / (g_i g_j).
    let deviation = |c: usize| last.inverse[(c, c)].max(0.0).sqrt();
    let (mut gain_deviation, mut gain_determined) = (vec![0.0; n], vec![true; n]);
    for (i, &j) in unknown.iter().enumerate() {
        gain[j] = 1.0 / g[j];
        gain_deviation[j] = deviation(p + i) / (g[j] * g[j]);
        gain_determined[j] = last.determined[p + i];
    }
    let place: Vec<Option<usize>> = (0..n).map(|j| unknown.iter().position(|&u| u == j)).collect();
    let gain_covariance = DMatrix::from_fn(n, n, |i, j| match (place[i], place[j]) {
        (Some(a), Some(b)) => last.inverse[(p + a, p + b)] / (g[i] * g[j]),
        _ => 0.0,
    });
    Ok(DriveGains {
        gain,
        gain_deviation,
        gain_covariance,
        gain_determined,
        deviation: (0..p).map(deviation).collect(),
        covariance: last.inverse.view((0, 0), (p, p)).into_owned(),
        determined: last.determined[..p].to_vec(),
        parameters: x,
        noise,
        steps,
        condition_number: last.condition_number,
    })
}

/// Number of unknowns that each joint j determines (degrees of freedom of the joint): tr J_j C J_j'. J_j: linearised rows of
/// joint j; C: covariance of the unknowns. The sum over the joints is the number of unknowns.
fn used(
    joints: &[JointEquations],
    unknown: &[usize],
    x: &[f64],
    g: &[f64],
    noise: &[f64],
    step: &Solution,
) -> Vec<f64> {
    let of_joint = |j: usize| {
        let rows = linearised(&joints[j], j, unknown, x, g[j], noise[j]);
        rows.iter().map(|(row, _)| variance(row, step)).sum()
    };
    (0..joints.len()).map(of_joint).collect()
}

/// The largest change of a determined unknown, in standard deviations of the unknown: max |step_c| / sqrt(C_cc), C: covariance.
fn in_sigmas(step: &Solution) -> f64 {
    let determined = (0..step.x.len()).filter(|&c| step.determined[c] && step.inverse[(c, c)] > 0.0);
    determined.map(|c| step.x[c].abs() / step.inverse[(c, c)].sqrt()).fold(0.0, f64::max)
}

/// Fails if nothing fixes the scale of the torques: there is no known or expected gain, and no known torque.
fn check_scale(joints: &[JointEquations], known: &[Gain]) -> Result<(), Error> {
    let n = joints.len();
    let is_loaded = joints.iter().any(|e| e.known.iter().any(|t| *t != 0.0));
    if known.len() != n || (!is_loaded && known.iter().all(|k| *k == Gain::Free)) {
        return Err(Error::new(format!(
            "{n} drive gains, at least one of them known, or a known load are needed: currents alone do not determine the common scale of gains and masses"
        )));
    }
    Ok(())
}

/// Solves least squares with residuals in torque; Gauss-Newton starts from this solution. Returns (X, gains).
///
/// A free gain is the coefficient of the noisy currents of its joint, and an expected gain is fixed. If no gain is known or
/// expected, the gain of the joint with the largest current is set to 1, and the coefficient of the known torque gives the common
/// factor.
pub(crate) fn least_squares(joints: &[JointEquations], known: &[Gain]) -> (Vec<f64>, Vec<f64>) {
    let p = joints.iter().find_map(|e| e.rows.first()).map_or(0, Vec::len);
    let mut held: Vec<Option<f64>> = known
        .iter()
        .map(|k| match k {
            Gain::Known(value) | Gain::Expected(value, _) => Some(*value),
            Gain::Free => None,
        })
        .collect();
    let relative = held.iter().all(Option::is_none);
    if relative {
        let current = |j: &usize| joints[*j].current.iter().map(|i| i * i).sum::<f64>();
        let most = (0..joints.len()).max_by(|a, b| current(a).total_cmp(&current(b)));
        most.into_iter().for_each(|j| held[j] = Some(1.0));
    }
    let free: Vec<usize> = (0..joints.len()).filter(|&j| held[j].is_none()).collect();
    let width = p + free.len() + usize::from(relative);
    let mut block = TriangleBuilder::new(width);
    for (j, equations) in joints.iter().enumerate() {
        for (d, t, i) in equations.each() {
            let mut row = d.clone();
            row.extend(free.iter().map(|&u| if u == j { -i } else { 0.0 }));
            row.extend(relative.then_some(t));
            block.push(&row, held[j].map_or(0.0, |k| k * i) - if relative { 0.0 } else { t });
        }
    }
    let triangle = block.finish();
    let mut x = solve(&triangle).x;
    // A gain that the data do not determine is zero in this solution. Gauss-Newton starts from 1 for such a gain.
    let unit = x.last().copied().filter(|c| relative && *c > 0.0).unwrap_or(1.0);
    x.iter_mut().for_each(|x| *x /= unit);
    let mut gain: Vec<f64> = held.iter().map(|k| k.unwrap_or(1.0) / unit).collect();
    free.iter().enumerate().filter(|(at, _)| x[p + at] != 0.0).for_each(|(at, &j)| gain[j] = x[p + at]);
    (x[..p].to_vec(), gain)
}

/// One Gauss-Newton step of (X, g = 1/gain), with its covariance. `unknown`: joints with an unknown gain; `noise`: standard
/// deviation of the currents of each joint.
fn gauss_newton(
    joints: &[JointEquations],
    known: &[Gain],
    unknown: &[usize],
    x: &[f64],
    g: &[f64],
    noise: &[f64],
) -> Solution {
    let width = x.len() + unknown.len();
    let mut block = TriangleBuilder::new(width);
    let mut push = |row: &[f64], y: f64| {
        block.push(row, y);
    };
    for (j, equations) in joints.iter().enumerate() {
        linearised(equations, j, unknown, x, g[j], noise[j]).iter().for_each(|(row, y)| push(row, *y));
    }
    for (at, &j) in unknown.iter().enumerate() {
        if let Gain::Expected(value, deviation) = known[j] {
            let mut row = vec![0.0; width];
            row[x.len() + at] = -1.0 / (g[j] * g[j] * deviation);
            push(&row, (value - 1.0 / g[j]) / deviation);
        }
    }
    solve(&block.finish())
}

/// Rows of joint j, linearised in (X, g = 1/gain) and divided by the noise of the joint, each with its residual.
fn linearised(
    equations: &JointEquations,
    j: usize,
    unknown: &[usize],
    x: &[f64],
    g: f64,
    noise: f64,
) -> Vec<(Vec<f64>, f64)> {
    let w = 1.0 / noise;
    let row = |(d, t, i): (&Vec<f64>, f64, f64)| {
        let torque = dot(d, x) + t;
        let mut row: Vec<f64> = d.iter().map(|d| w * g * d).collect();
        row.extend(unknown.iter().map(|&u| if u == j { w * torque } else { 0.0 }));
        (row, w * (i - g * torque))
    };
    equations.each().map(row).collect()
}

/// The variance of the prediction of a row, row C row', with the covariance C of the solution.
fn variance(row: &[f64], solution: &Solution) -> f64 {
    let along = |a: usize| row.iter().enumerate().map(|(b, x)| solution.inverse[(a, b)] * x).sum::<f64>();
    row.iter().enumerate().map(|(a, x)| x * along(a)).sum()
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use random::Random;

    pub(crate) const GAINS: [f64; 3] = [2.393, 0.870, 1.0];
    pub(crate) const TRUTH: [f64; 5] = [0.3, -0.1, 0.05, 1.2, -0.4];
    /// Parameters of the load. In experiments with the load, the true parameters are `TRUTH` + `LOAD`.
    pub(crate) const LOAD: [f64; 5] = [0.2, 0.0, 0.1, 0.8, 0.3];
    pub(crate) const THIRD: [Gain; 3] = [Gain::Free, Gain::Free, Gain::Known(1.0)];

    /// Equations of three joints. The first joint has hardly more rows than parameters, as on a real arm. If `is_loaded`, every
    /// experiment is repeated with a known load on the robot.
    pub(crate) fn joints(random: &mut Random, noise: f64, is_loaded: bool) -> Vec<JointEquations> {
        let mut pattern = Random::new(1);
        let mut joint = |j: usize, count: usize| {
            let mut e = JointEquations::default();
            for _ in 0..count {
                let row: Vec<f64> =
                    (0..5).map(|c| if j == 0 || c > 0 { 200.0 * pattern.normal() } else { 0.0 }).collect();
                for load in [0.0, 1.0].into_iter().take(1 + usize::from(is_loaded)) {
                    let known = load * dot(&row, &LOAD);
                    e.current.push((dot(&row, &TRUTH) + known) / GAINS[j] / noise + random.normal());
                    e.rows.push(row.iter().map(|d| d / noise).collect());
                    e.known.push(known / noise);
                }
            }
            e
        };
        vec![joint(0, 4), joint(1, 12), joint(2, 10)]
    }

    #[test]
    fn without_noise_the_gains_come_back() {
        for (is_loaded, known) in [(false, THIRD), (true, [Gain::Free; 3])] {
            let joints = joints(&mut Random::new(2), 1e-6, is_loaded);
            let ml = drive_gains(&joints, &known).unwrap();
            assert!(ml.steps.is_some() && ml.gain_determined.iter().chain(&ml.determined).all(|d| *d));
            for j in 0..3 {
                // The allowed error follows from the noise of 1e-6; the torques are some hundred.
                assert!((ml.gain[j] - GAINS[j]).abs() < 1e-7);
            }
            for c in 0..5 {
                assert!((ml.parameters[c] - TRUTH[c]).abs() < 1e-7);
            }
        }
    }

    #[test]
    fn likelihood_is_unbiased_with_honest_deviations() {
        for (is_loaded, known) in [(false, THIRD), (true, [Gain::Free; 3])] {
            let mut random = Random::new(3);
            let draws = 400;
            let (mut chi, mut bias, mut sigma) = (0.0, 0.0, 0.0);
            for _ in 0..draws {
                let joints = joints(&mut random, 20.0, is_loaded);
                let ml = drive_gains(&joints, &known).unwrap();
                let e = (ml.gain[0] - GAINS[0]) / ml.gain_deviation[0];
                chi += e * e / f64::from(draws);
                bias += e / f64::from(draws);
                sigma = ml.gain_deviation[0] / GAINS[0];
            }
            assert!(sigma > 0.005 && sigma < 0.2, "the noise is felt: {sigma}");
            // Allowed errors: five standard errors of the mean and of the variance of 400 standard normal numbers. A
            // maximum-likelihood estimate also has a bias of second order, about sigma, which is added.
            assert!(bias.abs() < 0.25 + sigma, "{is_loaded}: {bias}");
            assert!((chi - 1.0).abs() < 0.4, "{is_loaded}: {chi}");
        }
    }

    /// A load that is present in every experiment cannot be distinguished from the robot, so it does not fix the scale.
    #[test]
    fn the_scale_must_be_given() {
        let free = [Gain::Free; 3];
        let mut joints = joints(&mut Random::new(2), 1.0, false);
        let message = drive_gains(&joints, &free).unwrap_err().to_string();
        assert!(message.contains("at least one of them known, or a known load"), "{message}");
        for e in &mut joints {
            e.known = e.rows.iter().map(|d| dot(d, &LOAD)).collect();
        }
        let found = drive_gains(&joints, &free).unwrap();
        assert!(found.gain_determined.iter().all(|d| !d), "{found:?}");
    }
}
