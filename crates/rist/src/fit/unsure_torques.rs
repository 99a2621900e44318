//! How unsure torques are: by the noise of the fit, by what faults and gains add to it, and by logs that were not fitted.
//!
//! Another log of the same robot has the same faults and gains. So it tells of the noise alone: both are combined without what
//! faults and gains add, and that is added afterwards. A gain adds to the variance of each parameter, a fault that moves the
//! parameters by e adds (y e)^2 to the square of the error of a torque y x.

use identification::estimate::identified::{Identified, Status};
use identification::estimate::identify::{Fit, with_deviations};
use identification::estimate::ledger::hypotheses::Tested;
use identification::estimate::ledger::{effects_of_faults, widen_by_faults, widen_by_what_may_be_there};
use identification::estimate::options::Options;
use identification::estimate::other_logs::mean_square_errors;
use identification::estimate::torque_error::{MotionRange, TorqueError, Unsure, shown_rank, torque_errors};
use identification::estimators::drive_gains::likelihood::DriveGains;
use nalgebra::DMatrix;
use numerics::triangle::Triangle;

use crate::describe::model::Model;
use crate::fit::drive_gains::widen;
use crate::fit::motion_range::{allowed, seen};
use identification::estimate::artefact::Estimate;

/// What a fit tells of its noise.
pub struct Noise {
    /// Any multiple of the covariance for white noise.
    inverse: DMatrix<f64>,
    /// Deviations of the solution of least norm, of parameters that are open: those for white noise, as much wider as those
    /// of the others are.
    of_open: Vec<f64>,
    /// Of each deviation, the share that stays where what changes from log to log does not count.
    within_logs: Vec<f64>,
    /// By how much the error of each of several logs moves the parameters.
    moved_by_logs: Vec<Vec<f64>>,
    /// Changes of the parameters that leave every row as it is.
    open: Vec<Vec<f64>>,
    /// How many correlated rows are worth one.
    discount: f64,
    /// Where the logs moved.
    seen: MotionRange,
}

impl Noise {
    /// Of a fit.
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

    /// The deviations of an estimate, as far as they are given there.
    fn deviations(&self, estimate: &Estimate) -> Vec<f64> {
        let deviation = |(c, p): (usize, &Identified)| p.sigma.or(self.of_open.get(c).copied()).unwrap_or(0.0);
        estimate.parameters.iter().enumerate().map(deviation).collect()
    }
}

/// What tells how unsure torques are.
pub struct UnsureTorques {
    /// Whether what the logs leave open of the parameters is open in every motion, so that no torque shows it.
    pub opens_in_any_motion: bool,
    /// Where the logs moved, and how many of their rows are worth one.
    seen: MotionRange,
    discount: f64,
    covariance: Covariance,
    /// Changes of the parameters that leave every row as it is, and show in some motion.
    open: Vec<Vec<f64>>,
    /// Whether a parameter is open that some motion tells.
    is_open: bool,
}

/// sigma_i sigma_j rho_ij, the parameters in their order.
struct Covariance {
    of_noise: Vec<Vec<f64>>,
    /// By how much the error of each of several logs moves the parameters.
    of_logs: Vec<Vec<f64>>,
    /// By parameter, what gains add to its variance.
    of_gains: Vec<f64>,
    /// By fault, by how much it moves the parameters.
    of_faults: Vec<Vec<f64>>,
    /// With all that.
    whole: Vec<Vec<f64>>,
}

impl UnsureTorques {
    /// Widens the deviations of an estimate by gains and faults, and says in it how unsure torques are.
    pub fn widening(
        estimate: &mut Estimate,
        noise: Noise,
        gains: Option<&DriveGains>,
        faults: &[Tested],
        model: &Model,
        options: &Options,
    ) -> UnsureTorques {
        let of_noise = noise.deviations(estimate);
        gains.into_iter().for_each(|found| widen(estimate, found));
        let with_gains = noise.deviations(estimate);
        widen_by_faults(estimate, faults);
        let unsure = UnsureTorques::of(noise, [&of_noise, &with_gains], faults, model, options, estimate);
        widen_by_what_may_be_there(estimate, faults);
        estimate.torque_errors = unsure.errors(model, options, estimate);
        unsure
    }

    /// The deviations `of_noise`, and `with_gains` beside it; the estimate has those of the `faults` too.
    fn of(
        noise: Noise,
        [of_noise, with_gains]: [&[f64]; 2],
        faults: &[Tested],
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

    /// By use.
    fn errors(&self, model: &Model, options: &Options, estimate: &Estimate) -> Vec<TorqueError> {
        self.errors_by(&self.covariance.of_noise, model, options, estimate)
    }

    /// The covariance of the parameters; `None` where one is open that some motion tells.
    pub(crate) fn covariance(&self) -> Option<&[Vec<f64>]> {
        (!self.is_open).then_some(&self.covariance.whole)
    }

    /// By use, where logs of another motion tell too; `logs`: by log, the triangles of its joints. `None` where they tell nothing.
    pub(crate) fn errors_beside(
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

    /// With the covariance that noise leaves, and the rest that makes the parameters unsure.
    fn errors_by(&self, noise: &[Vec<f64>], model: &Model, options: &Options, estimate: &Estimate) -> Vec<TorqueError> {
        let (rest, range) = (&self.covariance, allowed(model, &self.seen));
        let noise = widened(noise, &rest.of_gains);
        let unsure = Unsure { covariance: &noise, changes: &rest.of_faults, logs: &rest.of_logs, open: &self.open };
        let linear = options.linear_model(model.regressor());
        torque_errors(&linear, &values(estimate), unsure, &self.seen, &range)
    }
}

/// A covariance with more variance of each parameter; correlations stay.
fn widened(covariance: &[Vec<f64>], added: &[f64]) -> Vec<Vec<f64>> {
    let p = added.len();
    let deviations: Vec<f64> = (0..p).map(|c| (covariance[c][c] + added[c]).max(0.0).sqrt()).collect();
    with_deviations(&DMatrix::from_fn(p, p, |i, j| covariance[i][j]), &deviations)
}

fn values(estimate: &Estimate) -> Vec<f64> {
    estimate.parameters.iter().map(Identified::prediction).collect()
}

/// Whether the rows have as many independent columns as those of any motion within the limits, so that no motion is to blame
/// for what is open. A sliding joint that carries its weight is an example: mass, rotor and offset are one column too few.
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
