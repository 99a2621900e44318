//! Finds physically consistent parameters from logs, with the solver `estimators::consistent`. A body stands for its ten
//! inertial parameters; it is consistent if its pseudo-inertia is positive definite.
//!
//! The rows are weighted by joint as in weighted least squares (WLS). Because residuals are correlated, the information of the
//! data is divided by a discount: the median over the parameters of (sigma / white sigma)^2. White sigma: standard deviation for
//! white noise. The discount lowers the weight of the data compared with the prior.
//!
//! A prior about zero bounds friction parameters that the motion does not identify. The standard deviation of this prior is
//! max|tau_j| for parameters of joint j in the unit of torque (Coulomb friction, offset), and max|tau_j| / (largest speed of
//! all joints) for viscous friction. The offset of a joint that carries the same weight in every pose is fixed to zero, because
//! no motion separates weight and offset.

use std::cell::Cell;

use linear_model::coupling_parameter::CouplingParameter;
use linear_model::linear_model::Model;
use linear_model::parameter::{FrictionParameter, Parameter, ParameterId};
use linear_model::pseudo_inertia::Ten;
use linear_model::regressor::Regressor;
use linear_model::standard_map::StandardMap;
use linear_model::unit::Unit;
use logs::Error;
use numerics::triangle::{Triangle, TriangleBuilder};
use serde::{Deserialize, Serialize};

use crate::estimate::artefact::Estimate;
use crate::estimate::held_out::{least_squares, predicted_from_others, residuals, together};
use crate::estimate::identify::Fit;
use crate::estimate::joint_terms::LARGEST_LOAD_COEFFICIENT;
use crate::estimate::options::Options;
use crate::estimate::standing_torque::offset_beside_weight;
use crate::estimators::barrier::{BarrierStatus, LARGEST_BOUNDED_RATIO};
use crate::estimators::consistent::{Consistent, Prior, consistent};
use crate::estimators::weighted::Weights;
use crate::rows::observation::{sum_by_joint, weighted};

/// Factor on the weight of the prior if no nominal bodies are known, because the prior then uses guessed bodies.
const GUESSED_BODIES_SHARE: f64 = 0.1;

/// Assumed distance of a centre of mass from the link frame, m. The mass of a guessed body is the largest first moment of all
/// links divided by this distance.
const GUESSED_ARM_M: f64 = 0.3;

/// Options of the physically consistent estimate.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Consistency {
    /// Weight of the prior, nats per unit of entropic divergence from the nominal bodies. Without nominal bodies, the prior
    /// uses the divergence from a guessed ball, with a tenth of this weight.
    pub prior_weight: f64,
    /// Whether the information of the data is divided by a discount, because residuals are correlated.
    pub discount: bool,
    /// Whether a prior keeps friction parameters small that the motion does not identify.
    pub bounded_friction: bool,
}

impl Default for Consistency {
    fn default() -> Consistency {
        Consistency { prior_weight: 1.0, discount: true, bounded_friction: true }
    }
}

/// A physically consistent estimate, with the result of its solver and the residual of least squares for comparison.
pub struct ConsistentFit {
    /// Relative residual |tau - W X| / |tau| of least squares on the same rows.
    pub least_residual: f64,
    /// Result of the solver, with all standard parameters (ten per link).
    pub consistent: Consistent,
    /// The estimate with the base parameters and the friction of the consistent solution.
    pub estimate: Estimate,
}

/// Finds physically consistent bodies from the rows of a least-squares fit. `map`: map from standard to base parameters;
/// `references`: the ten nominal parameters of each body of the map, `None` if unknown.
///
/// Fails if the map has the wrong size for the regressor, or if the weight of the prior is not a positive number.
pub fn identify_consistent(
    regressor: &dyn Regressor,
    map: &StandardMap,
    references: &[Option<Ten>],
    fit: &Fit,
    options: &Options,
    consistency: &Consistency,
) -> Result<ConsistentFit, Error> {
    let (rows, base) = (map.matrix.nrows(), regressor.parameters().len());
    if rows != base || map.matrix.ncols() != map.standard.len() {
        return Err(Error::new(format!(
            "the map from standard parameters has {rows} rows, the regressor {base} columns"
        )));
    }
    if !(consistency.prior_weight > 0.0 && consistency.prior_weight.is_finite()) {
        return Err(Error::new(format!("prior_weight is {}; a positive number is needed", consistency.prior_weight)));
    }
    let model = options.linear_model(regressor);
    let joints = fit.observation.joints(|_| true);
    let (weights, prior) = (weights(fit, options), prior(&model, fit, references, consistency));
    let consistent = with_fixed_friction(&model, weighted(&joints, &weights), |rows| consistent(rows, map, &prior));
    let residual = residuals(&model, &joints, &consistent.x);
    let mut estimate = Estimate {
        method: format!("physically consistent, {}", fit.estimate.method),
        joints: residual.joints,
        total: Some(residual.total),
        // Cross-validation was done with least squares, not with this estimator.
        cross_validation: None,
        tenths: Vec::new(),
        ..fit.estimate.clone()
    };
    for (joint, of_fit) in estimate.joints.iter_mut().zip(&fit.estimate.joints) {
        joint.f95 = of_fit.f95;
        joint.memory = of_fit.memory;
    }
    for (parameter, &x) in estimate.parameters.iter_mut().zip(&consistent.x) {
        // The sigma of least squares is kept, since the constraints of consistent bodies can only reduce sigma. A parameter
        // that the data do not determine gets the value of the prior. The status of such a parameter stays "not identifiable".
        *parameter = parameter.clone().with_value(x);
    }
    estimate.remarks.push(account(&consistent, &estimate, &fit.estimate, prior.discount));
    Ok(ConsistentFit { least_residual: relative_residual(&fit.estimate), consistent, estimate })
}

/// Number of blocks of the record in cross-validation. If tenths were left out, the other tenths would contain nearly the whole
/// motion. Then the error would not show that the motion does not determine the parameters.
const HELD_OUT_BLOCKS: usize = 4;

/// Relative errors of cross-validation: [least squares, physically consistent bodies]. Each quarter of the record is
/// predicted by a fit to the other quarters. `None` if the solver of the consistent bodies stalls.
pub fn errors_on_quarters(
    regressor: &dyn Regressor,
    map: &StandardMap,
    references: &[Option<Ten>],
    fit: &Fit,
    options: &Options,
) -> Option<[f64; 2]> {
    let model = options.linear_model(regressor);
    let parts = &fit.observation.parts;
    let quarters: Vec<Vec<Triangle>> =
        parts.chunks(parts.len().div_ceil(HELD_OUT_BLOCKS).max(1)).map(sum_by_joint).collect();
    let (weights, prior) = (weights(fit, options), prior(&model, fit, references, &Consistency::default()));
    let error = |solve: &dyn Fn(Triangle) -> Vec<f64>| {
        together(&model, &predicted_from_others(&model, &quarters, &weights, solve)).total
    };
    let is_stalled = Cell::new(false);
    let possible = |rest: Triangle| {
        let found = with_fixed_friction(&model, rest, |rows| consistent(rows, map, &prior));
        is_stalled.set(is_stalled.get() || found.outcome == BarrierStatus::Stalled);
        found.x
    };
    let errors = [error(&|rest| least_squares(rest, &fit.solution.x)), error(&possible)];
    (!is_stalled.get()).then_some(errors)
}

/// Weight of the rows of each joint: 1 / rms residual of the joint. With ordinary least squares (OLS), all joints have the same
/// weight, 1 / rms residual of all rows.
fn weights(fit: &Fit, options: &Options) -> Vec<f64> {
    match options.weights {
        Weights::None => vec![1.0 / fit.solution.variance.sqrt().max(f64::MIN_POSITIVE); fit.weights.len()],
        _ => fit.weights.clone(),
    }
}

fn prior(model: &Model, fit: &Fit, references: &[Option<Ten>], consistency: &Consistency) -> Prior {
    let share = if references.iter().any(Option::is_some) { 1.0 } else { GUESSED_BODIES_SHARE };
    Prior {
        bodies: references.to_vec(),
        scale: scale(model, fit),
        gamma: consistency.prior_weight * share,
        discount: if consistency.discount { fit.deviation.correlated } else { 1.0 },
        friction: friction_deviation(model, fit, consistency.bounded_friction),
    }
}

/// Solves the rows with bounds on friction. The load-friction coefficient of a joint (friction torque / load torque) is
/// between 0 and `LARGEST_LOAD_COEFFICIENT`; drive offsets that are not separable from a weight are fixed to zero.
///
/// The coefficient farthest outside its bounds is fixed to the nearer bound, and the rows are solved again, until all
/// coefficients are inside.
fn with_fixed_friction(model: &Model, mut rows: Triangle, solve: impl Fn(&Triangle) -> Consistent) -> Consistent {
    let is_load = |p: &Parameter| matches!(p.id, ParameterId::Friction(FrictionParameter::Load, _));
    let mut open: Vec<usize> = match model.friction.iter().any(|term| term.is_of_one_joint()) {
        true => (0..model.p()).filter(|&c| is_load(&model.parameters[c])).collect(),
        false => Vec::new(),
    };
    let is_held = |c: &usize| offset_beside_weight(model, &model.parameters[*c]).is_some();
    let mut known: Vec<(usize, f64)> = (0..model.p()).filter(is_held).map(|c| (c, 0.0)).collect();
    loop {
        known.drain(..).for_each(|(c, value)| hold(&mut rows, c, value));
        let found = solve(&rows);
        let beyond = |c: usize| (found.x[c] - found.x[c].clamp(0.0, LARGEST_LOAD_COEFFICIENT)).abs();
        let worst = open.iter().copied().max_by(|&a, &b| beyond(a).total_cmp(&beyond(b)));
        let Some(c) = worst.filter(|&c| beyond(c) > LOAD_COEFFICIENT_TOLERANCE) else { return found };
        open.retain(|&other| other != c);
        known.push((c, found.x[c].clamp(0.0, LARGEST_LOAD_COEFFICIENT)));
    }
}

/// Fixes parameter c to `value` by an additional row with a large weight.
fn hold(rows: &mut Triangle, c: usize, value: f64) {
    let mut row = vec![0.0; rows.columns()];
    row[c] = KNOWN_ROW_RATIO * rows.column_norm(c);
    let mut known = TriangleBuilder::new(row.len());
    known.push(&row, row[c] * value);
    rows.merge(&known.finish(), 1.0);
}

/// Largest accepted excess of a load-friction coefficient over its bounds.
const LOAD_COEFFICIENT_TOLERANCE: f64 = 1e-3;
/// Weight of the row that fixes a parameter, divided by the norm of the column of the parameter.
const KNOWN_ROW_RATIO: f64 = 1e3;

/// Relative residual |tau - W X| / |tau| of an estimate; NaN if not computed.
fn relative_residual(estimate: &Estimate) -> f64 {
    estimate.total.unwrap_or(f64::NAN)
}

/// A sentence for the user on the result of the solver: steps, residuals, and the suboptimality bound of the objective.
fn account(consistent: &Consistent, estimate: &Estimate, least_squares: &Estimate, discount: f64) -> String {
    let residuals =
        format!("residual {:.4}, least squares {:.4}", relative_residual(estimate), relative_residual(least_squares));
    let (steps, objective) = (consistent.newton_steps, consistent.objective);
    let Some(excess) = consistent.excess else {
        return format!(
            "not solved: no step leads on after {steps} of Newton's method, and these bodies are not those nearest to the \
             data; {residuals}; look at signs and units of the torques"
        );
    };
    let yields = match consistent.prior_share {
        1.0 => String::new(),
        share => format!("; the description has 1/{:.0} of its weight, since the data contradict it", 1.0 / share),
    };
    format!(
        "physically consistent in {steps} Newton steps: {residuals}; 1/2 chi^2 = {objective:.3}, data counted \
         1/{discount:.1}, at most {excess:.1e} above the least over all bodies up to {LARGEST_BOUNDED_RATIO} times as large{yields}"
    )
}

/// The bodies are refused if their relative residual exceeds the residual of least squares by this factor, and is above
/// `LARGE_RESIDUAL_SHARE`. Noise does not explain such a difference.
const LARGE_RESIDUAL_RATIO: f64 = 2.0;
/// The bodies are refused only if their relative residual |tau - W X| / |tau| is above this value.
const LARGE_RESIDUAL_SHARE: f64 = 0.02;

impl ConsistentFit {
    /// Reason not to use these bodies (solver stalled, residual too large); `None` if the bodies can be used.
    pub fn refusal(&self) -> Option<String> {
        let (total, least) = (relative_residual(&self.estimate), self.least_residual);
        if self.consistent.outcome == BarrierStatus::Stalled {
            return Some("the bodies nearest to the data were not found: the solver stalled".into());
        }
        (total > LARGE_RESIDUAL_SHARE && total > LARGE_RESIDUAL_RATIO * least).then(|| {
            format!(
                "no bodies explain these logs: their relative residual is {total:.4}, that of least squares {least:.4}; look at \
                 signs, units and columns of the torques"
            )
        })
    }
}

/// Mass of the ball that replaces a body without nominal parameters, kg: the largest identified first moment divided by 0.3
/// m; 1 kg without first moments.
fn scale(model: &Model, fit: &Fit) -> f64 {
    let moment = |(p, x): (&Parameter, &f64)| (p.unit() == Unit::FIRST_MOMENT).then_some(x.abs());
    let largest = model.parameters.iter().zip(&fit.solution.x).filter_map(moment).fold(0.0, f64::max);
    if largest > 0.0 { largest / GUESSED_ARM_M } else { 1.0 }
}

/// Prior standard deviations about zero of friction and coupling parameters (all parameters after the base parameters), each
/// in its unit. Infinite: no prior. `bounded`: false if no parameter gets a prior.
fn friction_deviation(model: &Model, fit: &Fit, bounded: bool) -> Vec<f64> {
    let fastest = fit.observation.speed.iter().copied().fold(0.0, f64::max);
    let peak = |j: usize| fit.observation.effort[j];
    let deviation = |p: &Parameter| match (&p.id, p.coordinates.as_slice()) {
        (ParameterId::Friction(friction, _), &[j]) if bounded && friction.is_viscous() => peak(j) / fastest,
        (ParameterId::Coupling(CouplingParameter::Viscous, _), &[j]) if bounded => peak(j) / fastest,
        (_, &[j]) if bounded && p.unit() == Unit::TORQUE.along(p.is_prismatic) => peak(j),
        _ => f64::INFINITY,
    };
    let base = model.regressor.parameters().len();
    let deviations = model.parameters[base..].iter().map(deviation);
    deviations.map(|d| if d > 0.0 { d } else { f64::INFINITY }).collect()
}

/// The name and the ten standard parameters of each body. `phi`: all standard parameters, in the order of the map.
pub fn bodies<'a>(map: &'a StandardMap, phi: &'a [f64]) -> impl Iterator<Item = (&'a str, Ten)> {
    map.bodies.iter().map(|(name, first)| (name.as_str(), std::array::from_fn(|i| phi[first + i])))
}
