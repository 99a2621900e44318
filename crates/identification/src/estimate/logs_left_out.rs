//! For each log of a fit, computes the error with which parameters fitted to the other logs predict this log.
//!
//! W_i, tau_i: rows and torques of log i. X, X_-i, X_i: parameters fitted to all logs, to all logs except i, and to log i
//! alone. The relative errors are
//!
//! ```text
//! e(x) = |tau_i - W_i x| / |tau_i|
//! error = e(X_-i)     by_parameters^2 = e(X_-i)^2 - e(X_i)^2     apart^2 = e(X)^2 - e(X_i)^2
//! ```
//! The standard deviations of X_-i show how large `error` may be without a contradiction between the logs. These standard
//! deviations are the deviations for white noise, multiplied by the factors (sigma / white sigma) of X.

use linear_model::linear_model::Model;
use numerics::least_squares::solve;
use numerics::triangle::Triangle;

use crate::estimate::digits::percent;
use crate::estimate::held_out::{of_parameters, residuals, unsure, without_each};
use crate::estimate::identify::{Fit, with_deviations};
use crate::estimate::nominal_prediction::nominal_residuals;
use crate::estimators::replicate_deviation::white_deviation;
use crate::estimators::weighted::{Weights, fit};

/// Relative errors |tau - W x| / |tau| on one log, if the parameters x are fitted to the other logs only.
#[derive(Clone, Debug, PartialEq)]
pub struct LogLeftOut {
    /// Number of the log, from 0.
    pub log: usize,
    /// Relative error of the prediction by parameters that are fitted to all other logs.
    pub error: f64,
    /// Part of `error` that follows from the standard deviations of the parameters fitted to the other logs. This part is
    /// infinite if the other logs determine fewer parameters than all logs together.
    pub unsure: f64,
    /// Part of `error` that comes from wrong parameters: sqrt(`error`^2 - own^2). own: relative error with parameters fitted
    /// to this log alone.
    pub by_parameters: f64,
    /// Error that the parameters of the common fit cause on this log: sqrt(common^2 - own^2). common, own: relative errors
    /// with parameters fitted to all logs, and to this log alone.
    pub apart: f64,
    /// Relative error with the nominal parameters and fitted friction; `None` if the description has no inertials.
    pub described: Option<f64>,
}

/// For each log, computes the errors when this log is left out of the fit; empty if there is only one log. `described`: nominal
/// base parameters.
pub fn logs_left_out(model: &Model, fitted: &Fit, described: Option<&[f64]>) -> Vec<LogLeftOut> {
    let logs = fitted.observation.logs();
    if logs.is_empty() {
        return Vec::new();
    }
    let (numbers, parts): (Vec<usize>, Vec<Vec<Triangle>>) = logs.into_iter().unzip();
    let wider: Vec<f64> = fitted.deviation.sigma().iter().zip(&fitted.deviation.white).map(|(s, w)| s / w).collect();
    // `wider`: the factors (sigma / white sigma) of the fit of all logs. `rests`: for each log, the rows of all other logs.
    let rests = without_each(model, &parts, &fitted.weights);
    let one = |((log, joints), rest): ((usize, &Vec<Triangle>), Triangle)| {
        let solution = solve(&rest);
        let deviations = white_deviation(&solution).into_iter().zip(&wider);
        let deviations: Vec<f64> =
            deviations.map(|(white, wider)| if white > 0.0 { wider * white } else { 0.0 }).collect();
        let covariance = with_deviations(&solution.inverse, &deviations);
        let is_identifiable = solution.rank >= fitted.solution.rank;
        let error = residuals(model, joints, &solution.x).total;
        let least = residuals(model, joints, &fit(joints, Weights::None).0.x).total;
        let of_description = |x| nominal_residuals(model, joints, &vec![1.0; joints.len()], x).total;
        LogLeftOut {
            log,
            error,
            unsure: if is_identifiable { unsure(model, joints, &covariance) } else { f64::INFINITY },
            by_parameters: of_parameters(error, least),
            apart: of_parameters(residuals(model, joints, &fitted.solution.x).total, least),
            described: described.map(of_description),
        }
    };
    numbers.into_iter().zip(&parts).zip(rests).map(one).collect()
}

/// Largest number of logs that a sentence names.
const MOST_NAMED_LOGS: usize = 8;

/// A sentence with the prediction error of each log, or only of the worst logs if there are many; `None` if there is only one
/// log. `logs`: names of the logs.
pub fn sentence(left_out: &[LogLeftOut], logs: &[String]) -> Option<String> {
    let mut named: Vec<&LogLeftOut> = left_out.iter().collect();
    let which = match named.len() {
        0 => return None,
        1..=MOST_NAMED_LOGS => "",
        _ => {
            named.sort_by(|a, b| b.error.total_cmp(&a.error));
            "; the worst"
        }
    };
    let one = |left: &&LogLeftOut| Some(format!("{} {}", logs.get(left.log)?, percent(left.error)));
    let each: Vec<String> = named.iter().take(MOST_NAMED_LOGS).filter_map(one).collect();
    Some(format!("each log is predicted by parameters from the others{which}: {}", each.join(", ")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::options::Options;
    use crate::test_arm::Pendulum;
    use linear_model::states::States;
    use random::Random;

    /// Two logs of the pendulum with noise; `change` modifies the second.
    fn left_out(change: impl Fn(&mut States)) -> Vec<LogLeftOut> {
        let arm = Pendulum::new();
        let options = Options { friction: Vec::new(), ..Options::default() };
        let mut random = Random::new(3);
        let mut logs = [0, 1].map(|log| States { log, ..arm.states(1000) });
        for states in &mut logs {
            states.tau.iter_mut().for_each(|tau| *tau += 0.01 * random.normal());
        }
        change(&mut logs[1]);
        let fit = Fit::of_records(&arm, logs.as_slice(), Vec::new(), &options).unwrap();
        logs_left_out(&options.linear_model(&arm), &fit, Some(&arm.truth))
    }

    #[test]
    fn logs_of_one_robot_predict_each_other() {
        let found = left_out(|_| ());
        assert_eq!(found.iter().map(|left| left.log).collect::<Vec<_>>(), [0, 1]);
        for left in &found {
            // The limits follow from noise of 0.01 N m, a torque of about 5 N m, three parameters and a thousand rows.
            assert!(left.error < 0.01 && left.by_parameters < 1e-3 && left.apart < 1e-3, "{left:?}");
            assert!(left.unsure < 1e-3 && (left.described.unwrap() / left.error - 1.0).abs() < 0.01, "{left:?}");
        }
    }

    #[test]
    fn each_log_is_named() {
        let left = |log: usize| LogLeftOut { error: 0.01 * (log + 1) as f64, log, ..left_out(|_| ()).swap_remove(0) };
        let names: Vec<String> = (0..9).map(|log| format!("{log}.csv")).collect();
        let of = |count: usize| sentence(&(0..count).map(left).collect::<Vec<_>>(), &names);
        assert_eq!(of(0), None);
        let two = "each log is predicted by parameters from the others: 0.csv 1.00 %, 1.csv 2.00 %";
        assert_eq!(of(2).as_deref(), Some(two));
        let many = of(9).unwrap();
        assert!(many.contains("; the worst: 8.csv 9.00 %, 7.csv 8.00 %") && !many.contains(" 0.csv"), "{many}");
    }

    /// The torques of one log are 10 % too large. So the error of each log is 10 % with parameters fitted to the other log, and
    /// 5 % with parameters fitted to both logs.
    #[test]
    fn logs_of_two_robots_are_apart() {
        for left in left_out(|states| states.tau.iter_mut().for_each(|tau| *tau *= 1.1)) {
            assert!((0.08..0.11).contains(&left.error) && (0.04..0.06).contains(&left.apart), "{left:?}");
        }
    }

    /// In one log the robot stands still at one pose, so this log determines one parameter only. Parameters that this log does
    /// not determine must not count as a contradiction between the logs.
    #[test]
    fn what_the_others_leave_open_is_infinitely_unsure() {
        let rest = |states: &mut States| {
            let (arm, q, mut y) = (Pendulum::new(), states.q[0], [0.0; 3]);
            states.q.fill(q);
            states.dq.fill(0.0);
            states.ddq.fill(0.0);
            linear_model::regressor::Regressor::fill(&arm, &[q], &[0.0], &[0.0], &mut y);
            states.tau.fill(y.iter().zip(arm.truth).map(|(y, x)| y * x).sum());
        };
        let found = left_out(rest);
        assert!(found[0].unsure.is_infinite() && found[1].unsure < 0.01, "{found:?}");
        assert!(found[1].error < 0.01 && found.iter().all(|left| left.apart < 0.01), "{found:?}");
    }
}
