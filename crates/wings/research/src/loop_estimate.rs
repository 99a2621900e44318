//! Estimates parameters from the states of experiments and a simulator of their control loop, by IDIM-IV (instrumental
//! variables) or DIDIM (direct and inverse dynamic identification), see `simulated_loop`.
//!
//! The start values are the least squares estimate from the same rows. The signal statistics, remarks and ranges of validity of
//! this estimate are kept; values and standard deviations are from [`simulated`].

use linear_model::regressor::Regressor;
use linear_model::states::States;
use logs::Error;

use crate::simulated_loop::{ClosedLoop, Simulator, simulated};
use identification::estimate::artefact::Estimate;
use identification::estimate::held_out::residuals;
use identification::estimate::identified::{Deviations, Identified, Status};
use identification::estimate::identify::Fit;
use identification::estimate::options::Options;

/// Identifies parameters from measured states. The simulator must return the states of all experiments in one list, in the order
/// of `measured`.
///
/// Fails if there are no rows, if the simulator fails, or if the motion does not determine all parameters.
pub fn identify_closed_loop(
    regressor: &dyn Regressor,
    measured: &[States],
    logs: Vec<String>,
    simulator: &dyn Simulator,
    options: &Options,
    method: ClosedLoop,
) -> Result<Estimate, Error> {
    let model = options.linear_model(regressor);
    let fit = Fit::of_records(regressor, measured, logs, options)?;
    let joined = States::joined(measured);
    let found = simulated(&model, &joined, simulator, &fit.solution.x, method)?;
    let mut estimate = fit.estimate;
    for (c, parameter) in estimate.parameters.iter_mut().enumerate() {
        let (id, unit, weak) = (parameter.id.clone(), parameter.unit, parameter.status == Status::Weak);
        let deviations = Deviations { sigma: found.robust[c].max(found.sigma[c]), white: Some(found.sigma[c]), weak };
        *parameter = Identified::new(id, unit, found.x[c], deviations);
    }
    let errors = residuals(&model, &fit.observation.joints(|_| true), &found.x);
    for (joint, new) in estimate.joints.iter_mut().zip(errors.joints) {
        (joint.rms, joint.relative) = (new.rms, new.relative);
    }
    estimate.total = Some(errors.total);
    estimate.method = match method {
        ClosedLoop::InstrumentalVariables => "IDIM-IV: instruments of the simulated loop".into(),
        ClosedLoop::DirectAndInverse => "DIDIM: torques of the simulated loop".into(),
    };
    // Covariance, directions and held-out errors are results of the least squares estimate, not of this method. So these
    // entries are removed from the estimate.
    estimate.covariance.clear();
    estimate.directions.clear();
    estimate.tenths.clear();
    estimate.cross_validation = None;
    estimate.joints.iter_mut().for_each(|joint| joint.held_out = None);
    estimate.settled = Some(found.converged);
    // In simulations with other controllers, only 33 to 75 of 100 intervals with a nominal coverage of 95 % contained the true
    // value.
    estimate
        .doubts
        .push("the intervals of this method are too narrow: they know no error of the loop that was simulated".into());
    estimate.remarks.push(match found.converged {
        true => format!("settled after {} simulations of every experiment", found.iterations),
        false => format!(
            "did not settle: after {} simulations the parameters still change by {:.1e} of themselves",
            found.iterations, found.change
        ),
    });
    Ok(estimate)
}
