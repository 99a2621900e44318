//! Computes the uncertainty of predicted torques from the noise of the fit, log faults, drive gains, and changes between logs.
//!
//! Another log of the same robot has the same faults and gains, so it adds information on the noise alone. Therefore logs are
//! combined by their noise, and the errors by faults and gains are added afterwards. A gain adds to the variance of each
//! parameter. A fault that changes the parameters by e adds (y e)^2 to the squared error of a torque y x (y: row of the
//! regressor, x: parameters).
//!
//! Results are errors of predicted torques, one for each use of an estimate (gravity compensation, feedforward, ..). "Open" are
//! changes of the parameters that have no effect on the torques of the logs (the null space of the regression rows). A triangle
//! is the matrix R of the QR decomposition of regression rows. Each log has one triangle per joint.

use identification::estimate::claims::hypotheses::HypothesisTest;
use identification::estimate::claims::{effects_of_faults, inflate_by_faults, inflate_by_undetected_faults};
use identification::estimate::identified::{Identified, Status};
use identification::estimate::identify::{Fit, with_deviations};
use identification::estimate::options::Options;
use identification::estimate::other_logs::mean_square_errors;
use identification::estimate::torque_error::{ErrorContributions, MotionRange, TorqueError, shown_rank, torque_errors};
use identification::estimators::drive_gains::likelihood::DriveGains;
use nalgebra::DMatrix;
use numerics::triangle::Triangle;

use crate::describe::model::Model;
use crate::fit::drive_gains::inflate_sigma;
use crate::fit::motion_range::{allowed, seen};
use identification::estimate::artefact::Estimate;

/// The uncertainty of the fitted parameters by noise.
pub struct Noise {
    /// The covariance of the parameters for white noise, up to a factor.
    inverse: DMatrix<f64>,
    /// Standard deviations for parameters that are not identifiable, taken from the least-norm solution. Like all other
    /// standard deviations, they are computed for white noise and inflated by the autocorrelation.
    of_open: Vec<f64>,
    /// For each parameter, the standard deviation by noise within logs, divided by the total standard deviation, which includes
    /// changes between logs.
    within_logs: Vec<f64>,
    /// If there are several logs: for each log, the change of the parameters that the error of this log causes.
    moved_by_logs: Vec<Vec<f64>>,
    /// Basis of the null space of the regression rows: parameter changes without any effect on the torques of the logs.
    open: Vec<Vec<f64>>,
    /// Number of autocorrelated rows that contain as much information as one independent row.
    discount: f64,
    /// Range of motion that the logs cover.
    seen: MotionRange,
}

impl Noise {
    /// The uncertainty of the parameters of a fit by noise.
    pub fn of(fit: &Fit) -> Noise {
        let discount = fit.estimate.discount();
        let of_open = fit.deviation.white.iter().map(|white| discount.sqrt() * white).collect();
        let within = fit.deviation.within_logs().into_iter().zip(fit.deviation.sigma());
        Noise {
            inverse: fit.solution.inverse.clone(),
            of_open,
            within_logs: within.map(|(within, sigma)| if sigma > 0.0 { within / sigma } else { 1.0 }).collect(),
            moved_by_logs: fit.deviation.moved_by_logs.clone(),
            open: fit.solution.open().map(<[f64]>::to_vec).collect(),
            discount,
            seen: seen(&fit.observation),
        }
    }

    /// Standard deviation of each parameter of an estimate. If the estimate gives none, the standard deviation of the
    /// least-norm solution is used.
    fn deviations(&self, estimate: &Estimate) -> Vec<f64> {
        let deviation = |(c, p): (usize, &Identified)| p.sigma.or(self.of_open.get(c).copied()).unwrap_or(0.0);
        estimate.parameters.iter().enumerate().map(deviation).collect()
    }
}

/// Data from which the uncertainty of predicted torques is computed.
pub struct UnsureTorques {
    /// Whether no motion at all can identify the parameters that the logs do not identify. If so, no torque depends on these
    /// parameters.
    pub opens_in_any_motion: bool,
    /// Range of motion of the logs. The field `discount` below is the number of rows that contain as much information as one
    /// independent row.
    seen: MotionRange,
    discount: f64,
    covariance: Covariance,
    /// Parameter changes that have no effect on the torques of the logs, but on torques of some other motion.
    open: Vec<Vec<f64>>,
    /// Whether some parameter is not identified although another motion would identify this parameter.
    is_open: bool,
}

/// The covariance of the parameters and the contributions to this covariance, in the order of the parameters.
struct Covariance {
    of_noise: Vec<Vec<f64>>,
    /// If there are several logs: for each log, the change of the parameters that the error of this log causes.
    of_logs: Vec<Vec<f64>>,
    /// For each parameter, the variance that the gains add.
    of_gains: Vec<f64>,
    /// For each fault, the change of the parameters that the fault causes.
    of_faults: Vec<Vec<f64>>,
    /// Covariance by noise, gains and faults together.
    whole: Vec<Vec<f64>>,
}

impl UnsureTorques {
    /// Inflates the standard deviations of an estimate by gains and faults, and stores the uncertainty of torques in the
    /// estimate.
    pub fn inflation(
        estimate: &mut Estimate,
        noise: Noise,
        gains: Option<&DriveGains>,
        faults: &[HypothesisTest],
        model: &Model,
        options: &Options,
    ) -> UnsureTorques {
        let of_noise = noise.deviations(estimate);
        gains.into_iter().for_each(|found| inflate_sigma(estimate, found));
        let with_gains = noise.deviations(estimate);
        inflate_by_faults(estimate, faults);
        let unsure = UnsureTorques::of(noise, [&of_noise, &with_gains], faults, model, options, estimate);
        inflate_by_undetected_faults(estimate, faults);
        estimate.torque_errors = unsure.errors(model, options, estimate);
        unsure
    }

    /// Makes the data from the standard deviations of the parameters: `of_noise` by noise; `with_gains` by noise and gains; in
    /// `estimate` by noise, gains and `faults`.
    fn of(
        noise: Noise,
        [of_noise, with_gains]: [&[f64]; 2],
        faults: &[HypothesisTest],
        model: &Model,
        options: &Options,
        estimate: &Estimate,
    ) -> UnsureTorques {
        let is_open = estimate.parameters.iter().any(|p| p.status == Status::NotIdentifiable);
        let opens_in_any_motion = is_open && is_all_that_shows(model, options, estimate, &noise.seen);
        let variance = |(with, of_noise): (&f64, &f64)| (with * with - of_noise * of_noise).max(0.0);
        let within_logs: Vec<f64> =
            of_noise.iter().zip(&noise.within_logs).map(|(sigma, share)| sigma * share).collect();
        let covariance = Covariance {
            of_noise: with_deviations(&noise.inverse, &within_logs),
            of_logs: noise.moved_by_logs.clone(),
            of_gains: with_gains.iter().zip(of_noise).map(variance).collect(),
            of_faults: effects_of_faults(estimate, faults),
            whole: with_deviations(&noise.inverse, &noise.deviations(estimate)),
        };
        let is_open = is_open && !opens_in_any_motion;
        let open = if is_open { noise.open } else { Vec::new() };
        UnsureTorques { opens_in_any_motion, seen: noise.seen, discount: noise.discount, covariance, open, is_open }
    }

    /// Errors of predicted torques, one entry per use of the estimate (gravity compensation, feedforward).
    fn errors(&self, model: &Model, options: &Options, estimate: &Estimate) -> Vec<TorqueError> {
        self.errors_by(&self.covariance.of_noise, model, options, estimate)
    }

    /// The covariance of the parameters. `None` if the logs do not identify a parameter that some other motion would identify.
    pub(crate) fn covariance(&self) -> Option<&[Vec<f64>]> {
        (!self.is_open).then_some(&self.covariance.whole)
    }

    /// Errors of predicted torques if logs of another motion are added. One entry per use of the estimate. `logs`: for each log,
    /// one triangle (R of the QR decomposition of the regression rows) per joint. `None` if these logs give no information on the
    /// errors, or if a parameter is undetermined.
    pub(crate) fn errors_with(
        &self,
        model: &Model,
        estimate: &Estimate,
        logs: &[&[Triangle]],
    ) -> Option<Vec<TorqueError>> {
        let (covariance, options) = (&self.covariance, estimate.options.as_ref()?);
        if logs.is_empty() || self.is_open {
            return None;
        }
        let (linear, x) = (options.linear_model(model.regressor()), values(estimate));
        let both = mean_square_errors(&linear, &x, &covariance.of_noise, logs, options.weights, self.discount)?;
        Some(self.errors_by(&both, model, options, estimate))
    }

    /// Errors of predicted torques, one entry per use of the estimate, from four sources: the covariance `noise`, gains,
    /// faults, and changes between logs.
    fn errors_by(&self, noise: &[Vec<f64>], model: &Model, options: &Options, estimate: &Estimate) -> Vec<TorqueError> {
        let (rest, range) = (&self.covariance, allowed(model, &self.seen));
        let noise = widened(noise, &rest.of_gains);
        let unsure =
            ErrorContributions { covariance: &noise, changes: &rest.of_faults, logs: &rest.of_logs, open: &self.open };
        let linear = options.linear_model(model.regressor());
        torque_errors(&linear, &values(estimate), unsure, &self.seen, &range)
    }
}

/// A covariance whose variances are increased by `added`, one entry per parameter. The correlations stay.
fn widened(covariance: &[Vec<f64>], added: &[f64]) -> Vec<Vec<f64>> {
    let p = added.len();
    let deviations: Vec<f64> = (0..p).map(|c| (covariance[c][c] + added[c]).max(0.0).sqrt()).collect();
    with_deviations(&DMatrix::from_fn(p, p, |i, j| covariance[i][j]), &deviations)
}

fn values(estimate: &Estimate) -> Vec<f64> {
    estimate.parameters.iter().map(Identified::prediction).collect()
}

/// Whether the logs identify all parameters that any motion within the limits can identify. A deficit may remain: a sliding
/// joint that carries its weight has, in any motion, one independent column too few for mass, rotor inertia and offset.
fn is_all_that_shows(model: &Model, options: &Options, estimate: &Estimate, range: &MotionRange) -> bool {
    let (linear, values) = (options.linear_model(model.regressor()), values(estimate));
    let base = linear.regressor.parameters().len();
    values.len() == linear.p() && estimate.rank >= shown_rank(&linear, &values[..base], &allowed(model, range))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_gains_add_is_added_afterwards() {
        let wide = widened(&[vec![4.0, -1.0], vec![-1.0, 1.0]], &[5.0, 0.0]);
        assert!((wide[0][0] - 9.0).abs() < 1e-12 && wide[1][1] == 1.0, "{wide:?}");
        assert!((wide[0][1] + 1.5).abs() < 1e-12 && wide[0][1] == wide[1][0], "{wide:?}");
    }
}
