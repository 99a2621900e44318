//! From logs to parameters that a simulator accepts: the way in to `estimators::consistent`.
//!
//! The weights by joint are those of WLS. The data are discounted by the median of (sigma by parts / white sigma)^2
//! over the parameters, so that the reference is weighed against what the residuals are worth. Friction that the motion
//! does not show is bounded by the torque that it would make. The standard deviation of FV_j is max|tau_j| / (fastest
//! joint's speed), and that of FS_j, FT_j and OFF_j is max|tau_j|. The offset of a joint that carries the same weight in every
//! pose is held at zero: no motion tells the two apart, and a file of bodies has no offset.

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
use crate::estimators::barrier::{LARGEST_BOUNDED_RATIO, Outcome};
use crate::estimators::consistent::{Consistent, Prior, consistent};
use crate::estimators::weighted::Weights;
use crate::rows::observation::{sum_by_joint, weighted};

/// Share of the weight of described bodies that guessed ones have.
const GUESSED_BODIES_SHARE: f64 = 0.1;

/// The options of the consistent estimate.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Consistency {
    /// Nats per unit of entropic divergence from the bodies of the description; a tenth of it where none is described,
    /// since a ball is a guess.
    pub prior_weight: f64,
    /// Discount the data for correlated residuals.
    pub discount: bool,
    /// Bound the friction that the motion does not show.
    pub bounded_friction: bool,
}

impl Default for Consistency {
    fn default() -> Consistency {
        Consistency { prior_weight: 1.0, discount: true, bounded_friction: true }
    }
}

/// A consistent estimate, with least squares and the solver's account beside it.
pub struct ConsistentFit {
    /// Residual of least squares on the same rows, over the torques.
    pub least_residual: f64,
    /// The solver's account, with all standard parameters.
    pub consistent: Consistent,
    /// Base parameters and friction, values of the consistent solution.
    pub estimate: Estimate,
}

/// Finds bodies that can exist from the data of a least-squares fit; `references` are in the order of the map's bodies,
/// where known.
///
/// Fails when the map does not fit the regressor, or the prior has no weight.
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
    let consistent = with_held_friction(&model, weighted(&joints, &weights), |rows| consistent(rows, map, &prior));
    let residual = residuals(&model, &joints, &consistent.x);
    let mut estimate = Estimate {
        method: format!("physically consistent, {}", fit.estimate.method),
        joints: residual.joints,
        total: Some(residual.total),
        // The parts left out were predicted by least squares, not by this.
        cross_validation: None,
        tenths: Vec::new(),
        ..fit.estimate.clone()
    };
    for (joint, of_fit) in estimate.joints.iter_mut().zip(&fit.estimate.joints) {
        joint.f95 = of_fit.f95;
        joint.memory = of_fit.memory;
    }
    for (parameter, &x) in estimate.parameters.iter_mut().zip(&consistent.x) {
        // The deviation is that of least squares, which the constraints can only lessen. What the data leave open comes
        // from the reference and is no finding.
        *parameter = parameter.clone().with_value(x);
    }
    estimate.remarks.push(account(&consistent, &estimate, &fit.estimate, prior.discount));
    Ok(ConsistentFit { least_residual: left(&fit.estimate), consistent, estimate })
}

/// Quarters of the record are predicted from the others: what a poor record lacks, a tenth does not show.
const QUARTERS: usize = 4;

/// Errors on quarters of the record, each predicted from the others: by least squares, and by bodies that can exist. `None` where no
/// such bodies are found.
pub fn errors_on_quarters(
    regressor: &dyn Regressor,
    map: &StandardMap,
    references: &[Option<Ten>],
    fit: &Fit,
    options: &Options,
) -> Option<[f64; 2]> {
    let model = options.linear_model(regressor);
    let parts = &fit.observation.parts;
    let quarters: Vec<Vec<Triangle>> = parts.chunks(parts.len().div_ceil(QUARTERS).max(1)).map(sum_by_joint).collect();
    let (weights, prior) = (weights(fit, options), prior(&model, fit, references, &Consistency::default()));
    let error = |solve: &dyn Fn(Triangle) -> Vec<f64>| {
        together(&model, &predicted_from_others(&model, &quarters, &weights, solve)).total
    };
    let is_stalled = Cell::new(false);
    let possible = |rest: Triangle| {
        let found = with_held_friction(&model, rest, |rows| consistent(rows, map, &prior));
        is_stalled.set(is_stalled.get() || found.outcome == Outcome::Stalled);
        found.x
    };
    let errors = [error(&|rest| least_squares(rest, &fit.solution.x)), error(&possible)];
    (!is_stalled.get()).then_some(errors)
}

/// The weights of the joints; without any, all have that of the whole.
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

/// The solution whose friction grows with the load by at most what a gear can waste, and never shrinks with it; offsets beside
/// weight are zero.
///
/// A coefficient beyond is put to the nearer end, one after the other; each is then as good as known.
fn with_held_friction(model: &Model, mut rows: Triangle, solve: impl Fn(&Triangle) -> Consistent) -> Consistent {
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

/// Adds a row that knows parameter c.
fn hold(rows: &mut Triangle, c: usize, value: f64) {
    let mut row = vec![0.0; rows.columns()];
    row[c] = KNOWN_ROW_RATIO * rows.column_norm(c);
    let mut known = TriangleBuilder::new(row.len());
    known.push(&row, row[c] * value);
    rows.merge(&known.finish(), 1.0);
}

/// A coefficient this near to its end is at it.
const LOAD_COEFFICIENT_TOLERANCE: f64 = 1e-3;
/// Weight of a known parameter's row over the norm of its column.
const KNOWN_ROW_RATIO: f64 = 1e3;

/// Share of the torques that an estimate leaves; one of samples has it.
fn left(estimate: &Estimate) -> f64 {
    estimate.total.unwrap_or(f64::NAN)
}

/// How the solver ended, and by how much the bodies are worse than the best there are.
fn account(consistent: &Consistent, estimate: &Estimate, least_squares: &Estimate, discount: f64) -> String {
    let residuals = format!("residual {:.4}, least squares {:.4}", left(estimate), left(least_squares));
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

/// A residual this many times that of least squares is not due to noise, where it is also large beside the torques.
const LARGE_RESIDUAL_RATIO: f64 = 2.0;
/// Share of the torques above which a residual is large.
const LARGE_RESIDUAL_SHARE: f64 = 0.02;

impl ConsistentFit {
    /// Why these bodies are not to be used; `None` where nothing speaks against them.
    pub fn refusal(&self) -> Option<String> {
        let (total, least) = (left(&self.estimate), self.least_residual);
        if self.consistent.outcome == Outcome::Stalled {
            return Some("the bodies nearest to the data were not found: the solver stalled".into());
        }
        (total > LARGE_RESIDUAL_SHARE && total > LARGE_RESIDUAL_RATIO * least).then(|| {
            format!(
                "no bodies explain these logs: they leave a residual of {total:.4}, least squares {least:.4}; look at \
                 signs, units and columns of the torques"
            )
        })
    }
}

/// Mass of the ball that stands for unknown bodies, kg.
///
/// It puts the largest first moment at an arm of 0.3 m, and is 1 kg where no first moment is among the parameters.
fn scale(model: &Model, fit: &Fit) -> f64 {
    let moment = |(p, x): (&Parameter, &f64)| (p.unit() == Unit::FIRST_MOMENT).then_some(x.abs());
    let largest = model.parameters.iter().zip(&fit.solution.x).filter_map(moment).fold(0.0, f64::max);
    if largest > 0.0 { largest / 0.3 } else { 1.0 }
}

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

/// The standard parameters of each body, by name.
pub fn bodies<'a>(map: &'a StandardMap, phi: &'a [f64]) -> impl Iterator<Item = (&'a str, Ten)> {
    map.bodies.iter().map(|(name, first)| (name.as_str(), std::array::from_fn(|i| phi[first + i])))
}
