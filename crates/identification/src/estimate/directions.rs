//! Finds directions of the parameter space (combinations of parameters) that the data hardly determine.
//!
//! A direction d is a singular vector of the regressor W with scaled columns (`numerics::least_squares`). A unit step along d
//! changes the weighted torques by |W d|. So the estimate has the standard deviation sqrt(discount) sigma / |W d| along d
//! (sigma: noise of a row; discount: number of correlated rows that count as one). A step of 1.96 of these standard deviations
//! along d changes the parameters. If this step changes the parameters with the largest entries in d by more than their values,
//! the data do not determine the direction.

use linear_model::linear_model::Model;
use linear_model::parameter::ParameterId;
use numerics::least_squares::Solution;
use numerics::triangle::Triangle;
use serde::{Deserialize, Serialize};

use crate::estimate::identified::INTERVAL;

/// Largest number of directions that an estimate contains.
const MAX_KEPT_DIRECTIONS: usize = 6;
/// A parameter is named for a direction only if its entry in the direction is at least this share of the largest entry (columns
/// scaled to unit norm).
const SMALLEST_NAMED_MEMBER_SHARE: f64 = 0.25;
/// Largest number of parameters of a direction that are named.
const MAX_NAMED_MEMBERS: usize = 6;
/// A direction counts as undetermined if a step of 1.96 sigma changes this many parameters by more than their values. These are
/// the parameters with the largest entries in the direction.
const DECISIVE_MEMBERS: usize = 2;

/// A direction of the parameter space (combination of parameters) that the data hardly determine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Direction {
    /// Singular value of W (columns scaled) along the direction, divided by the largest singular value. 0: the torques do not
    /// depend on the direction.
    pub strength: f64,
    /// The parameters that change most along the direction, the largest entry (columns scaled) first.
    pub members: Vec<DirectionMember>,
    /// Whether the data do not determine the direction: a step of 1.96 sigma along the direction changes the parameters with
    /// the largest entries by at least their values.
    pub open: bool,
}

/// One parameter that changes along a direction.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DirectionMember {
    /// Identity of the parameter.
    pub parameter: ParameterId,
    /// Change of the parameter for one standard deviation along the direction, in the unit of the parameter.
    ///
    /// If the torques do not depend on the direction, the size of a step along the direction is arbitrary. Then only the ratios
    /// of the changes have a meaning.
    pub change: f64,
}

/// Finds the directions with the smallest singular values, the smallest first.
///
/// `joints`: triangles (R of QR) of the rows, one per joint; `weights`: weight of each joint; `discount`: number of
/// correlated rows that carry the information of one independent row.
pub fn directions(
    model: &Model,
    joints: &[Triangle],
    weights: &[f64],
    solution: &Solution,
    discount: f64,
) -> Vec<Direction> {
    let square = |of: &dyn Fn(&Triangle) -> f64| {
        joints.iter().zip(weights).map(|(joint, weight)| (weight * of(joint)).powi(2)).sum::<f64>().sqrt()
    };
    let norms: Vec<f64> = (0..model.p()).map(|c| square(&|joint| joint.column_norm(c))).collect();
    let sigma = (solution.variance * discount).sqrt();
    // The standard deviation along d is sigma / |W d|.
    let direction = |(strength, d): &(f64, Vec<f64>)| {
        let shown = square(&|joint| length(joint, d));
        let deviation = if *strength > 0.0 && shown > 0.0 { sigma / shown } else { f64::INFINITY };
        let mut order: Vec<usize> = (0..model.p()).filter(|&c| d[c] != 0.0).collect();
        let weight = |c: usize| (d[c] * norms[c]).abs();
        order.sort_by(|&a, &b| weight(b).total_cmp(&weight(a)));
        let largest = order.first().map_or(0.0, |&c| weight(c));
        order.retain(|&c| weight(c) >= SMALLEST_NAMED_MEMBER_SHARE * largest);
        order.truncate(MAX_NAMED_MEMBERS);
        let open = |&c: &usize| INTERVAL * deviation * d[c].abs() >= solution.x[c].abs();
        let change = if deviation.is_finite() { deviation } else { 1.0 };
        let member = |&c: &usize| DirectionMember { parameter: model.parameters[c].id.clone(), change: change * d[c] };
        Direction {
            strength: *strength,
            members: order.iter().map(member).collect(),
            open: order.iter().take(DECISIVE_MEMBERS).all(open),
        }
    };
    // Directions of zero columns are skipped, because remarks report the parameters of these columns as not identifiable.
    let shown = |d: &&(f64, Vec<f64>)| d.1.iter().zip(&norms).any(|(x, norm)| *x != 0.0 && *norm > 0.0);
    solution.weak.iter().filter(shown).take(MAX_KEPT_DIRECTIONS).map(direction).collect()
}

/// Norm |R d| of the change of the torques of one joint if the parameters change by d, N m (N). R: triangle of the joint.
fn length(triangle: &Triangle, d: &[f64]) -> f64 {
    let row = |i: usize| (i..d.len()).map(|c| triangle.at(i, c) * d[c]).sum::<f64>();
    (0..d.len()).map(|i| row(i).powi(2)).sum::<f64>().sqrt()
}

impl Direction {
    /// A sentence on the direction: `the data do not separate MX2 from MXR3: ..`; empty if `members` is empty.
    pub fn sentence(&self) -> String {
        let names: Vec<String> = self.members.iter().map(|m| m.parameter.to_string()).collect();
        let also = |rest: &[String]| match rest.len() {
            0 => String::new(),
            _ => format!(" (with {})", rest.join(", ")),
        };
        match (self.open, names.as_slice()) {
            (_, []) => String::new(),
            (true, [one]) => format!("the data hardly show {one}: the noise hides changes as large as its value"),
            (true, [a, b, rest @ ..]) => format!(
                "the data do not separate {a} from {b}{}: a change of both along one direction stays below the noise",
                also(rest)
            ),
            (false, [one]) => format!("{one} is the least identifiable parameter, but it is identifiable"),
            (false, [a, b, rest @ ..]) => {
                format!("{a} and {b}{} are the least separable parameters, but they are separable", also(rest))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimators::weighted::{Weights, fit};
    use crate::rows::observation::Observation;
    use crate::test_arm::pendulum;
    use numerics::least_squares::solve;
    use random::Random;

    /// A pendulum that stays near one angle determines only one combination of the first moments MX1 and MY1, so MX1 and MY1
    /// are not separable.
    #[test]
    fn what_is_not_told_apart_is_named() {
        let (arm, model) = pendulum();
        let mut random = Random::new(9);
        let mut of = |spread: f64, noise: f64| {
            let mut states = arm.states(2000);
            states.q.iter_mut().for_each(|q| *q = 0.5 + spread * *q);
            let mut torque = states.clone();
            model.rows(&states, 0..states.len(), |r, w| {
                let clean: f64 = w.iter().zip(&arm.truth).map(|(w, x)| w * x).sum();
                torque.tau[r] = clean + noise * random.normal();
            });
            let joints = Observation::of(&model, &torque, 1).joints(|_| true);
            let (solution, weights) = fit(&joints, Weights::None);
            directions(&model, &joints, &weights, &solution, 1.0)
        };
        let narrow = of(1e-4, 0.05);
        assert!(narrow[0].open, "{narrow:?}");
        let named: Vec<String> = narrow[0].members.iter().take(2).map(|m| m.parameter.to_string()).collect();
        assert!(named.contains(&"MX1".into()) && named.contains(&"MY1".into()), "{named:?}");
        assert!(narrow[0].sentence().contains("do not separate"), "{}", narrow[0].sentence());
        assert!(of(1.0, 1e-6).iter().all(|d| !d.open));
        let solution = solve(&Observation::of(&model, &arm.states(500), 1).joints(|_| true)[0]);
        assert!(solution.rank == 3);
    }
}
