//! Predicts the standard deviation of each parameter in an identification from a motion.
//!
//! sigma_c = sqrt((A^-1 B A^-1)_cc),   A = sum over the rows of y'y / r_i^2,   B = sum of y'y s_i^2 / r_i^4,
//!
//! sigma_c is the standard deviation of parameter c. The sums are over the rows y of the identification matrix W (regressor and
//! friction columns), at the sample rate of the motion, over its whole periods. s_i is the white noise of the torques of joint i.
//! r_i is the divisor of the rows of joint i in an identification: s_i combined with the noise from the encoders
//! ([`JointNoise`]). The prediction assumes that the model is exact and that the joints follow their reference. The sign of dry
//! friction is exact here.

use linear_model::friction::terms::{columns_before, sign};
use linear_model::linear_model::Model;
use linear_model::parameter::{Parameter, ParameterId};
use linear_model::unit::Unit;
use numerics::least_squares::{Solution, solve};
use numerics::triangle::{Triangle, TriangleBuilder};
use serde::{Deserialize, Serialize};

use crate::excitation::columns::visible_columns;
use crate::excitation::limits::CoordinateLimits;
use crate::excitation::motion::Motion;
use crate::excitation::proof::CertificateRow;

/// Expected noise of one torque sample in an identification: standard deviations, N m (N), one per coordinate.
#[derive(Clone, Debug, PartialEq)]
pub struct JointNoise {
    /// Standard deviation of the white noise of the measured torques, N m (N), one per coordinate.
    pub torque: Vec<f64>,
    /// Standard deviation of the noise that the encoders add to the torque residual, N m (N), one per coordinate.
    pub encoders: Vec<f64>,
}

impl JointNoise {
    /// Makes the noise of torque sensors only; the encoders have no noise.
    pub fn of_torques(torque: Vec<f64>) -> JointNoise {
        JointNoise { encoders: vec![0.0; torque.len()], torque }
    }

    /// The divisor of the rows of each joint in an identification: the standard deviation of the joint's torque residual, N m
    /// (N).
    pub fn weights(&self) -> Vec<f64> {
        self.torque.iter().zip(&self.encoders).map(|(s, e)| s.hypot(*e)).collect()
    }
}

/// The standard deviation of one parameter, predicted for an identification from a motion.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct VisibleParameter {
    /// Name of the parameter.
    #[serde(rename = "name")]
    pub id: ParameterId,
    /// SI unit of the parameter and of its standard deviation.
    pub unit: Unit,
    /// Nominal value from the description. `None` if the description has no value.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub described: Option<f64>,
    /// Predicted standard deviation, in `unit`. `None` if the motion does not make the parameter identifiable.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub deviation: Option<f64>,
    /// The standard deviation divided by the magnitude of the nominal value. `None` if the nominal value is zero or not known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub relative_deviation: Option<f64>,
    /// For a weak or not identifiable parameter: the joints that cause it with their lock or limit, in words. `None`: no such
    /// joint.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub to_blame: Option<String>,
}

impl VisibleParameter {
    /// Whether the parameter is weak: its predicted standard deviation is more than 30 % of its nominal value.
    pub fn is_weak(&self) -> bool {
        self.relative_deviation.is_some_and(|r| r > WEAK_RELATIVE_DEVIATION)
    }

    /// A remark for users if the parameter is weak or not identifiable. `None`: there is nothing to remark.
    pub fn remark(&self) -> Option<String> {
        match (self.deviation, self.relative_deviation, &self.to_blame) {
            (None, _, Some(why)) => Some(format!("not visible ({why})")),
            (None, _, None) => Some("not visible".into()),
            (_, Some(r), Some(why)) if r > WEAK_RELATIVE_DEVIATION => Some(format!("weak ({why})")),
            _ => None,
        }
    }
}

/// A parameter is weak if its standard deviation exceeds this share of its nominal value.
const WEAK_RELATIVE_DEVIATION: f64 = 0.3;

/// A nominal value below this share of the greatest one counts as zero; then the parameter has no relative standard deviation.
const ZERO_VALUE_SHARE: f64 = 1e-9;

/// Predicted standard deviations of all parameters for one motion, with two criteria of the motion.
#[derive(Clone, Debug, PartialEq)]
pub struct Visibility {
    /// The parameters, in the order of the model.
    pub parameters: Vec<VisibleParameter>,
    /// Determinant criterion det(W'W / instants)^(1/p). W: regressor columns of the p parameters that motions within the limits
    /// can separate.
    pub determinant: f64,
    /// Condition number of these p regressor columns after scaling to unit norm.
    pub condition_number: f64,
}

/// States of a motion at equally spaced instants, which an identification would use as samples.
pub struct SeenStates<'a> {
    /// Number of instants at which the motion is sampled.
    pub count: usize,
    /// Position, velocity and acceleration of each coordinate at instant number i.
    pub at: &'a dyn Fn(usize) -> Vec<[f64; 3]>,
    /// Number of times that the motion repeats these instants.
    pub repetitions: usize,
}

/// Predicts the standard deviation of torques that are computed from identified parameters.
pub struct TorqueForecast {
    columns: Vec<usize>,
    /// Least-squares solution for the parameters with the indices `columns`, and the R of its QR decomposition, which gives the
    /// covariance. `None` if there are no columns.
    solution: Option<(Solution, Triangle)>,
    repetitions: f64,
}

impl TorqueForecast {
    /// Standard deviation of the torque `row` times X, N m (N); X: identified parameters; `row`: one entry per column of the
    /// model. `None` if the torque needs a parameter that is not identifiable.
    pub fn torque_deviation(&self, row: &[f64]) -> Option<f64> {
        let (solution, seen) = self.solution.as_ref()?;
        let picked: Vec<f64> = self.columns.iter().map(|&c| row[c]).collect();
        if picked.iter().zip(&solution.determined).any(|(x, determined)| *x != 0.0 && !determined) {
            return None;
        }
        let at = |i: usize| (0..picked.len()).map(|k| solution.inverse[(i, k)] * picked[k]).sum::<f64>();
        let along: Vec<f64> = (0..picked.len()).map(at).collect();
        Some((seen.squares(&along).1 / self.repetitions).sqrt())
    }
}

/// Predicts standard deviations of all parameters for a motion and prior information. `described`: nominal values, one per
/// parameter; `certificate`: rows of the motion's certificate; `prior`: rows of prior information, each with one entry per
/// parameter.
pub fn visibility(
    model: &Model,
    motion: &Motion,
    limits: &[CoordinateLimits],
    noise: &JointNoise,
    described: &[Option<f64>],
    certificate: &[CertificateRow],
    prior: &[f64],
) -> Visibility {
    // The instants of one whole period of the motion, at its sample rate.
    let at = |r: usize| -> Vec<[f64; 3]> {
        let state = motion.at(motion.shape.blend() + r as f64 / motion.rate);
        state.iter().map(|x| [x[0], x[1], x[2]]).collect()
    };
    let count = (motion.shape.period() * motion.rate).round() as usize;
    let seen = SeenStates { count, at: &at, repetitions: motion.repetitions.max(1) };
    visibility_of(model, &seen, limits, noise, described, certificate, prior).0
}

/// Predicts the standard deviations of all parameters for any states. Also gives the predictor for standard deviations of
/// torques.
pub fn visibility_of(
    model: &Model,
    states: &SeenStates,
    limits: &[CoordinateLimits],
    noise: &JointNoise,
    described: &[Option<f64>],
    certificate: &[CertificateRow],
    prior: &[f64],
) -> (Visibility, TorqueForecast) {
    let visible = visible_columns(model, limits);
    let columns: Vec<usize> = (0..model.p()).filter(|&c| visible[c]).collect();
    let repetitions = states.repetitions as f64;
    // The QR decomposition covers one period, so the prior information is divided by the square root of the number of
    // repetitions.
    let known: Vec<f64> = prior.iter().map(|x| x / repetitions.sqrt()).collect();
    let triangle_over = |divisor: &[f64]| information(model, states, limits, divisor, &columns, &known);
    let triangle = triangle_over(&noise.torque);
    // Without columns there is no least-squares problem to solve.
    let solution = (!columns.is_empty()).then(|| solve(&triangle));
    let weights = noise.weights();
    let square: Vec<f64> = weights.iter().zip(&noise.torque).map(|(r, s)| r * r / s).collect();
    let weighted = solution.as_ref().map(|_| (solve(&triangle_over(&weights)), triangle_over(&square)));
    let greatest = described.iter().flatten().fold(0.0_f64, |m, x| m.max(x.abs()));
    let one = |(c, parameter): (usize, &Parameter)| {
        let place = columns.iter().position(|k| *k == c);
        let found = place.filter(|&i| solution.as_ref().is_some_and(|s| s.determined[i]));
        let deviation = found.zip(weighted.as_ref()).map(|(i, (weighted, seen))| {
            let along: Vec<f64> = weighted.inverse.column(i).iter().copied().collect();
            (seen.squares(&along).1 / repetitions).sqrt()
        });
        let value = described.get(c).copied().flatten();
        let size = value.map(f64::abs).filter(|x| *x > ZERO_VALUE_SHARE * greatest);
        let relative_deviation = deviation.zip(size).map(|(d, x)| d / x);
        let to_blame = match deviation {
            None => Some(hiding_joint(model, limits, c)),
            Some(_) => relative_deviation
                .filter(|r| *r > WEAK_RELATIVE_DEVIATION)
                .and_then(|_| slowest(model, &parameter.coordinates, certificate)),
        };
        VisibleParameter {
            id: parameter.id.clone(),
            unit: parameter.unit(),
            described: value,
            deviation,
            relative_deviation,
            to_blame,
        }
    };
    let instants = states.count.max(1) as f64;
    let logarithms: f64 = (0..columns.len()).map(|i| triangle.at(i, i).abs().ln()).sum();
    let seen = Visibility {
        parameters: model.parameters.iter().enumerate().map(one).collect(),
        determinant: (2.0 * logarithms / columns.len().max(1) as f64).exp() / instants,
        condition_number: solution.as_ref().map_or(f64::INFINITY, |s| s.condition_number),
    };
    (seen, TorqueForecast { columns, solution: weighted, repetitions })
}

/// Fills the row of the identification matrix W for joint i: the joint's row of the regressor Y, then its friction columns with
/// the exact sign of dq. `y`: Y at the instant, row by row.
pub fn fill_row(model: &Model, i: usize, y: &[f64], dq: f64, ddq: f64, row: &mut [f64]) {
    let base = model.regressor.parameters().len();
    row.fill(0.0);
    row[..base].copy_from_slice(&y[i * base..][..base]);
    let mut places = &mut row[base + columns_before(model.friction, i)..];
    for term in model.friction {
        let (own, rest) = places.split_at_mut(term.parameters_of(i).len());
        term.fill(dq, ddq, 0.0, sign(dq), own);
        places = rest;
    }
}

/// R of the QR decomposition of the identification matrix W at the states, for the columns with the indices `columns`. The rows
/// of W are divided by `noise`. The rows of prior information are added.
fn information(
    model: &Model,
    states: &SeenStates,
    limits: &[CoordinateLimits],
    noise: &[f64],
    columns: &[usize],
    known: &[f64],
) -> Triangle {
    let (n, p, base) = (model.n(), model.p(), model.regressor.parameters().len());
    let mut block = TriangleBuilder::new(columns.len());
    let (mut y, mut row, mut picked) = (vec![0.0; n * base], vec![0.0; p], vec![0.0; columns.len()]);
    for r in 0..states.count {
        let state = (states.at)(r);
        let of = |d: usize| -> Vec<f64> { state.iter().map(|x| x[d]).collect() };
        let (dq, ddq) = (of(1), of(2));
        model.regressor.fill(&of(0), &dq, &ddq, &mut y);
        for i in (0..n).filter(|&i| limits[i].locked.is_none()) {
            fill_row(model, i, &y, dq[i], ddq[i], &mut row);
            picked.iter_mut().zip(columns).for_each(|(x, &c)| *x = row[c] / noise[i]);
            block.push(&picked, 0.0);
        }
    }
    // Prior information from an earlier identification, as rows.
    for row in known.chunks_exact(p.max(1)) {
        picked.iter_mut().zip(columns).for_each(|(x, &c)| *x = row[c]);
        block.push(&picked, 0.0);
    }
    block.finish()
}

/// Names the locked joints that make parameter number `column` not identifiable, in words.
fn hiding_joint(model: &Model, limits: &[CoordinateLimits], column: usize) -> String {
    let names = model.regressor.coordinates();
    let locked: Vec<usize> = (0..limits.len()).filter(|&k| limits[k].locked.is_some()).collect();
    let shows = |free: &[usize]| {
        let mut limits = limits.to_vec();
        free.iter().for_each(|&k| limits[k].locked = None);
        visible_columns(model, &limits)[column]
    };
    let alone: Vec<usize> = locked.iter().copied().filter(|k| shows(&[*k])).collect();
    let list = |these: &[usize]| these.iter().map(|&k| names[k].as_str()).collect::<Vec<_>>().join(", ");
    match (alone.as_slice(), shows(&locked)) {
        ([], true) => format!("locked: {}", list(&locked)),
        ([], false) => "no motion separates it from the others".into(),
        (one, _) => format!("locked: {}", list(one)),
    }
}

/// The limit of these coordinates with the least relative distance to its bound, in words. `None` if the certificate has no row
/// for these coordinates.
fn slowest(model: &Model, coordinates: &[usize], certificate: &[CertificateRow]) -> Option<String> {
    let names = model.regressor.coordinates();
    let own = |row: &&CertificateRow| coordinates.iter().any(|&k| names[k] == row.subject);
    let share = |row: &CertificateRow| row.room() / row.bound.abs().max(f64::MIN_POSITIVE);
    let least = certificate.iter().filter(own).min_by(|a, b| share(a).total_cmp(&share(b)))?;
    Some(format!("{}: {}", least.subject, least.limit))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::excitation::fourier_series::FourierSeries;
    use crate::excitation::motion::MotionShape;
    use crate::excitation::search::tests::pendulum_limits;
    use crate::pendulum::Pendulum;
    use linear_model::friction::terms::FrictionTerm;
    use linear_model::regressor::Regressor;
    use random::Random;

    fn motion() -> Motion {
        let shape = MotionShape::Fourier(FourierSeries { period: 5.0, blend: 1.0, harmonics: 2 });
        Motion { rate: 50.0, repetitions: 2, shape, joints: vec![vec![0.2, 0.6, 0.1, 0.5, -0.3]] }
    }

    /// Checks that least-squares estimates from noisy torques of the motion have the predicted standard deviations.
    #[test]
    fn deviations_are_those_of_least_squares() {
        let (arm, motion, limits) = (Pendulum::new(), motion(), [pendulum_limits()]);
        let friction = [FrictionTerm::Viscous];
        let model = Model::new(&arm, &friction, &[]);
        let truth = [0.3, 0.8, -0.1, 0.5];
        let noise = JointNoise::of_torques(vec![0.2]);
        let described = truth.map(Some);
        let predicted = visibility(&model, &motion, &limits, &noise, &described, &[], &[]).parameters;
        let draws = 200;
        let mut squares = [0.0; 4];
        let mut random = Random::new(9);
        for _ in 0..draws {
            let mut block = TriangleBuilder::new(4);
            for r in 0..500 {
                let [q, dq, ddq, _] = motion.at(1.0 + 0.02 * f64::from(r))[0];
                let mut row = [0.0; 4];
                arm.fill(&[q], &[dq], &[ddq], &mut row[..3]);
                row[3] = dq;
                let torque: f64 = row.iter().zip(truth).map(|(y, x)| y * x).sum();
                block.push(&row, torque + 0.2 * random.normal());
            }
            let triangle = block.finish();
            let found = solve(&triangle).x;
            (0..4).for_each(|c| squares[c] += (found[c] - truth[c]).powi(2) / f64::from(draws));
        }
        for c in 0..4 {
            let (sigma, seen) = (predicted[c].deviation.unwrap(), squares[c].sqrt());
            // The standard deviation from 200 draws has a relative error of 1/sqrt(400) = 5 %; the tolerance is four times as
            // large.
            assert!((seen / sigma - 1.0).abs() < 0.2, "{c}: {seen} {sigma}");
            let relative = predicted[c].relative_deviation.unwrap();
            assert!((relative - sigma / truth[c].abs()).abs() < 1e-12);
        }
        // With only one joint, a larger divisor of all rows does not change the standard deviations.
        let rough = JointNoise { encoders: vec![0.3], ..noise.clone() };
        let weighted = visibility(&model, &motion, &limits, &rough, &described, &[], &[]).parameters;
        for (a, b) in weighted.iter().zip(&predicted) {
            let (a, b) = (a.deviation.unwrap(), b.deviation.unwrap());
            assert!((a / b - 1.0).abs() < 1e-9, "{a} {b}");
        }
        // Prior information on one parameter, equal to the information from the motion. Both add up, so the variance is halved.
        let mut known = [0.0; 4];
        known[3] = 1.0 / predicted[3].deviation.unwrap();
        let both = visibility(&model, &motion, &limits, &noise, &described, &[], &known).parameters;
        let (alone, both) = (predicted[3].deviation.unwrap(), both[3].deviation.unwrap());
        assert!((both / alone - 0.5_f64.sqrt()).abs() < 1e-9, "{both} {alone}");
    }

    #[test]
    fn what_is_hidden_names_the_joint() {
        let (arm, motion) = (Pendulum::new(), motion());
        let model = Model::new(&arm, &[], &[]);
        let limits = [CoordinateLimits { locked: Some(0.0), ..pendulum_limits() }];
        let found =
            visibility(&model, &motion, &limits, &JointNoise::of_torques(vec![0.2]), &[None; 3], &[], &[]).parameters;
        assert!(
            found.iter().all(|p| p.deviation.is_none() && p.to_blame.as_deref() == Some("locked: q1")),
            "{found:?}"
        );
    }
}
