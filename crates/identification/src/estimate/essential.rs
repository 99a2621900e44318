//! Estimates the essential parameters [Pham, Gautier 1991]: parameters that are not significant are set to zero.
//!
//! `estimators::essential` eliminates parameters one by one, until the squared residual has grown by 3.84 times the discount
//! times the noise variance of a row. 3.84 is the 95 % quantile of chi^2 for one parameter; the discount accounts for
//! correlated residuals.
//!
//! The standard deviation of a kept parameter is its white-noise deviation in the reduced model, times the ratio (sigma /
//! white sigma) in the full model.

use linear_model::regressor::Regressor;

use crate::estimate::held_out::residuals;
use crate::estimate::identified::{Deviations, Identified, Status};
use crate::estimate::identify::Fit;
use crate::estimate::options::Options;
use crate::estimate::residuals::JointResidual;
use crate::estimators::essential::{Elimination, essential};
use crate::estimators::replicate_deviation::white_deviation;
use crate::rows::observation::weighted;

/// 95 % quantile of chi^2 with one degree of freedom (one eliminated parameter).
const SIGNIFICANT_CHI_SQUARE: f64 = 3.84;

/// Reduces a fit to its essential parameters. The eliminated parameters get the value zero and keep their standard deviations.
pub fn keep_essential(regressor: &dyn Regressor, fit: &mut Fit, options: &Options) {
    let model = options.linear_model(regressor);
    let joints = fit.observation.joints(|_| true);
    let triangle = weighted(&joints, &fit.weights);
    // `Elimination` limits the relative growth of the norm of the residual. For small changes, this growth is half the relative
    // growth of the squared norm.
    let growth = 0.5 * SIGNIFICANT_CHI_SQUARE * fit.estimate.discount() / triangle.rows.max(1) as f64;
    let found = essential(&triangle, Elimination { growth, ..Elimination::default() });
    let (white, sigma) = (white_deviation(&fit.solution), fit.deviation.sigma());
    let smaller = white_deviation(&found.solution);
    let estimate = &mut fit.estimate;
    // sigma = (white sigma in the reduced model) * (sigma / white sigma in the full model).
    for (c, parameter) in estimate.parameters.iter_mut().enumerate() {
        let (id, unit, weak) = (parameter.id.clone(), parameter.unit, parameter.status == Status::Weak);
        *parameter = match found.kept.iter().position(|&k| k == c) {
            Some(i) if found.solution.determined[i] => {
                let ratio = if white[c] > 0.0 { sigma[c] / white[c] } else { 1.0 };
                let ratio = if ratio.is_finite() { ratio } else { 1.0 };
                let deviations = Deviations { sigma: ratio * smaller[i], white: Some(smaller[i]), weak };
                Identified::new(id, unit, found.x[c], deviations)
            }
            None if fit.solution.determined[c] => {
                let deviations = Deviations { sigma: sigma[c], white: Some(white[c]), weak };
                Identified::new(id, unit, 0.0, deviations)
            }
            _ => Identified::unidentifiable(id, unit, found.x[c]),
        };
    }
    let left = residuals(&model, &joints, &found.x);
    for (joint, new) in estimate.joints.iter_mut().zip(left.joints) {
        let (held_out, f95, memory) = (joint.held_out, joint.f95, joint.memory);
        *joint = JointResidual { held_out, f95, memory, ..new };
    }
    estimate.total = Some(left.total);
    estimate.method = format!("essential parameters, {}", estimate.method);
    (estimate.rank, estimate.condition_number) = (found.solution.rank, Some(found.solution.condition_number));
    // Directions and covariance were computed for the full model and are not valid for the reduced one.
    estimate.directions.clear();
    estimate.covariance.clear();
    let names: Vec<String> = found.dropped.iter().map(|&c| estimate.parameters[c].id.to_string()).collect();
    estimate.remarks.push(match names.is_empty() {
        true => "every parameter is essential: without any of them the residual grows by more than noise explains".into(),
        false => format!(
            "{} of {} parameters are essential; left out, as zero: {}; the residual grows by {:.3} %, no more than noise explains",
            found.kept.len(),
            estimate.parameters.len(),
            names.join(" "),
            100.0 * (found.growth - 1.0)
        ),
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_arm::Pendulum;
    use random::Random;

    #[test]
    fn friction_that_is_not_there_goes() {
        let arm = Pendulum::new();
        let mut random = Random::new(8);
        let mut states = arm.states(4000);
        states.tau.iter_mut().for_each(|tau| *tau += 0.05 * random.normal());
        states.f95 = vec![1.0];
        let options = Options::default();
        let records = [states];
        let fit = || Fit::of_records(&arm, &records[..], vec!["a".into()], &options).unwrap();
        let (whole, mut fit) = (fit(), fit());
        keep_essential(&arm, &mut fit, &options);
        let base = arm.truth.len();
        for (c, (p, before)) in fit.estimate.parameters.iter().zip(&whole.estimate.parameters).enumerate() {
            if c < base && arm.truth[c].abs() > 0.1 {
                let sigma = p.sigma.unwrap();
                assert!((p.value.unwrap() - arm.truth[c]).abs() < 4.0 * sigma, "{p:?} {:?}", arm.truth);
                // The factor 1.001 allows for the variance of the residual: with fewer parameters, the residual has more
                // degrees of freedom.
                assert!(sigma <= 1.001 * before.sigma.unwrap(), "{p:?} {before:?}");
            }
        }
        let zero = |p: &&Identified| p.value == Some(0.0);
        let gone: Vec<&Identified> = fit.estimate.parameters.iter().filter(zero).collect();
        assert!(!gone.is_empty() && gone.iter().all(|p| p.status == Status::NotSignificant), "{gone:?}");
        assert!(fit.estimate.total.unwrap() < 1.001 * whole.estimate.total.unwrap());
        let said = fit.estimate.remarks.iter().any(|r| r.contains("left out, as zero: "));
        assert!(said, "{:?}", fit.estimate.remarks);
    }
}
