//! Chooses friction terms of single joints by forward selection with cross-validation.
//!
//! Candidates for a joint are friction that grows with the load, Stribeck friction that decays over 5 or 15 % of the joint's
//! largest speed, viscous asymmetry, and friction proportional to the root of the speed. Candidates are added one by one to the
//! friction terms that every joint has. In cross-validation, each tenth k of the records is predicted from the other tenths.
//! W_k, y_k: weighted rows and torques of tenth k; x_k: the parameters fitted to all other tenths. The squared error is
//!
//! ```text
//! E^2 = sum_k |W_k x_k - y_k|^2
//! ```
//! The candidate with the smallest E is added, as long as it reduces E by more than 1.5 %. The rows are weighted by joint, so
//! that all joints have the same influence. The load is the torque of the bodies predicted by an earlier fit. The measured torque
//! is not used as load, because it would then be on both sides of the equation.
//!
//! The records are read once, with the columns of all candidates. The products W_k' W_k then give E for any set of columns.
//! To test a candidate, one column is added to the Cholesky factor of the set.

use std::fmt;

use linear_model::friction::terms::{FrictionTerm, JointTerm, columns_before, columns_of};
use linear_model::linear_model::Model;
use linear_model::regressor::Regressor;
use logs::Error;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use numerics::triangle::{Triangle, select};

use crate::estimate::options::Options;
use crate::estimators::huber::{Robust, row_factor};
use crate::estimators::weighted::fit;
use crate::rows::observation::{Observation, RowWeight, weighted};
use crate::signals::records::Records;

/// A term is added only if it multiplies the error E of cross-validation by less than this value.
const WORTHWHILE_ERROR_RATIO: f64 = 0.985;
/// A Stribeck candidate decays over one of these shares of the joint's largest speed.
const STRIBECK_SPEED_SHARES: [f64; 2] = [0.05, 0.15];
/// Largest accepted load-friction coefficient (friction torque / load torque): no gear dissipates a larger share of the load.
pub(crate) const LARGEST_LOAD_COEFFICIENT: f64 = 0.2;
/// Regularisation of the fits of cross-validation: share of the squared norm of a column (as in `held_out`).
const FOLD_REGULARISATION_SHARE: f64 = 1e-6;
/// Regularisation of the fit to the whole record: share of the squared norm of a column. The regularisation keeps undetermined
/// parameters near zero.
const WHOLE_REGULARISATION_SHARE: f64 = 1e-12;

/// A friction term that was added, and the error of cross-validation with this term.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TakenTerm {
    /// The friction term.
    pub term: FrictionTerm,
    /// Error E of cross-validation with this term and all terms added before it, divided by E without terms of single joints.
    pub ratio: f64,
}

/// The chosen friction terms of single joints, and the error of cross-validation without these terms.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JointTerms {
    /// Relative error of cross-validation without terms of single joints: |W x - y| / |y| with weighted rows W and torques y.
    pub error: f64,
    /// The chosen terms, in the order in which they were added.
    pub taken: Vec<TakenTerm>,
}

impl JointTerms {
    /// Whether one of the added terms is friction that grows with the load.
    pub fn has_load(&self) -> bool {
        self.taken.iter().any(|taken| matches!(taken.term, FrictionTerm::At(_, JointTerm::Load)))
    }
}

/// The candidate friction terms of all joints that move. `speed`: largest speed of each joint, rad/s (m/s); 0 if the joint
/// stands still.
pub fn joint_candidates(speed: &[f64]) -> Vec<FrictionTerm> {
    let mut out = Vec::new();
    for (j, &fastest) in speed.iter().enumerate().filter(|(_, v)| **v > 0.0) {
        let mut add = |term| out.push(FrictionTerm::At(j + 1, term));
        add(JointTerm::Load);
        STRIBECK_SPEED_SHARES.iter().for_each(|share| add(JointTerm::Stribeck(share * fastest)));
        add(JointTerm::ViscousAsymmetry);
        add(JointTerm::Root);
    }
    out
}

/// Chooses the `candidates` that are added to `options.friction`. The records must contain the predicted load. `other_columns`:
/// parameters of a fit without the candidates, and the robust weights of the rows in that fit; `None` for equal weights.
///
/// Fails if a record cannot be read.
pub fn choose_joint_terms<R: Records + ?Sized>(
    regressor: &dyn Regressor,
    records: &R,
    options: &Options,
    candidates: &[FrictionTerm],
    other_columns: Option<(&[f64], &Robust)>,
) -> Result<JointTerms, Error> {
    let terms = [options.friction.as_slice(), candidates].concat();
    let wide = options.linear_model_with(regressor, &terms);
    let places: Vec<usize> = (0..candidates.len()).map(|i| place(&wide, options, candidates, i)).collect();
    let kept: Vec<usize> = (0..wide.p()).filter(|c| !places.contains(c)).collect();
    let mut x = vec![0.0; wide.p()];
    kept.iter().zip(other_columns.map_or(&[][..], |(x, _)| x)).for_each(|(&c, value)| x[c] = *value);
    let weight = |j: usize, e: f64| row_factor(other_columns.map(|(_, rows)| rows), j, e);
    let rows = Observation::of_records(&wide, records, other_columns.map(|_| RowWeight { x: &x, weight: &weight }))?;
    // The weights by joint come from a fit without the candidates.
    let joints: Vec<Triangle> = rows.joints(|_| true).iter().map(|joint| select(joint, &kept)).collect();
    let (_, weights) = fit(&joints, options.weights);
    let folds = Folds::new(&rows, &weights);

    // Forward selection by the error E of cross-validation.
    let mut set = kept;
    let first = folds.error(&set);
    let torque = folds.torque() + weighted(&joints, &weights).taken_out;
    let mut found = JointTerms { error: (first / torque).sqrt(), taken: Vec::new() };
    let mut error = first;
    let mut open: Vec<usize> = (0..candidates.len()).collect();
    while error > 0.0 && !open.is_empty() {
        let columns: Vec<usize> = open.iter().map(|&i| places[i]).collect();
        let tried = folds.with_each(&set, &columns);
        let is_possible = |i: usize, value: f64| match candidates[i] {
            FrictionTerm::At(_, JointTerm::Load) => (0.0..=LARGEST_LOAD_COEFFICIENT).contains(&value),
            _ => true,
        };
        let possible = open.iter().zip(&tried).filter(|(i, tried)| is_possible(**i, tried.value));
        let Some((&best, tried)) = possible.min_by(|a, b| a.1.error.total_cmp(&b.1.error)) else { break };
        // `error` is E^2, so the ratio is squared.
        if tried.error.is_nan() || tried.error >= WORTHWHILE_ERROR_RATIO * WORTHWHILE_ERROR_RATIO * error {
            break;
        }
        error = tried.error;
        set.push(places[best]);
        found.taken.push(TakenTerm { term: candidates[best], ratio: (error / first).sqrt() });
        // A joint has at most one parameter of each name, so candidates with the name of the added term are dropped.
        let named = |i: usize| wide.parameters[places[i]].id.clone();
        let taken = named(best);
        open.retain(|&i| named(i) != taken);
    }
    Ok(found)
}

/// Index of the column of candidate i in the model with all candidates.
fn place(wide: &Model, options: &Options, candidates: &[FrictionTerm], i: usize) -> usize {
    let FrictionTerm::At(number, _) = candidates[i] else { return 0 };
    let (base, j) = (wide.regressor.parameters().len(), number - 1);
    base + columns_before(wide.friction, j) + columns_of(&options.friction, j) + columns_of(&candidates[..i], j)
}

/// The effect of adding one candidate term.
struct CandidateEffect {
    /// Squared error E^2 of cross-validation with the candidate; infinite if it cannot be computed.
    error: f64,
    /// Parameter of the candidate, fitted to the whole record.
    value: f64,
}

/// Products [W y]' [W y] of the weighted rows W and torques y: for each tenth of the record, and for the whole record. The
/// columns of W are scaled to unit norm.
struct Folds {
    tenths: Vec<DMatrix<f64>>,
    all: DMatrix<f64>,
    /// For each column of W: factor from the parameter of the scaled column to the parameter of the model.
    scale: DVector<f64>,
}

impl Folds {
    fn new(rows: &Observation, weights: &[f64]) -> Folds {
        let products = |joints: &Vec<Triangle>| {
            let triangle = weighted(joints, weights);
            let m = triangle.columns() + 1;
            let r = DMatrix::from_fn(m, m, |i, j| if i <= j { triangle.at(i, j) } else { 0.0 });
            r.transpose() * r
        };
        let parts: Vec<DMatrix<f64>> = rows.parts.iter().map(products).collect();
        let m = parts.first().map_or(0, DMatrix::nrows);
        let sum = |parts: &[DMatrix<f64>]| parts.iter().fold(DMatrix::zeros(m, m), |sum, part| sum + part);
        let mut folds =
            Folds { tenths: parts.chunks(2).map(sum).collect(), all: sum(&parts), scale: DVector::zeros(m) };
        folds.scale = folds.all.diagonal().map(|x| if x > 0.0 { 1.0 / x.sqrt() } else { 1.0 });
        // The last column contains the torques and is not scaled.
        if let Some(last) = m.checked_sub(1) {
            folds.scale[last] = 1.0;
        }
        for products in folds.tenths.iter_mut().chain([&mut folds.all]) {
            let scale = &folds.scale;
            *products = DMatrix::from_fn(m, m, |i, j| scale[i] * products[(i, j)] * scale[j]);
        }
        folds
    }

    /// Squared norm of the weighted torque of the whole record.
    fn torque(&self) -> f64 {
        self.all.diagonal().as_slice().last().copied().unwrap_or(0.0)
    }

    /// Squared error E^2 of cross-validation with the columns in `set`; infinite if the normal equations cannot be solved.
    fn error(&self, set: &[usize]) -> f64 {
        let Some(whole) = Normal::new(&self.all, set, WHOLE_REGULARISATION_SHARE) else { return f64::INFINITY };
        let x = whole.solution(&DVector::zeros(set.len()));
        let of_tenth = |tenth: &DMatrix<f64>| {
            let rest = Normal::new(&(&self.all - tenth), set, FOLD_REGULARISATION_SHARE)?;
            Some(residual_square(tenth, set, &rest.solution(&x)))
        };
        self.tenths.iter().map(of_tenth).sum::<Option<f64>>().unwrap_or(f64::INFINITY)
    }

    /// The effect of adding one of `columns` to the columns in `set`; one result per entry of `columns`.
    fn with_each(&self, set: &[usize], columns: &[usize]) -> Vec<CandidateEffect> {
        let last = self.all.nrows() - 1;
        let none = || CandidateEffect { error: f64::INFINITY, value: 0.0 };
        let Some(whole) = Normal::new(&self.all, set, WHOLE_REGULARISATION_SHARE) else {
            return columns.iter().map(|_| none()).collect();
        };
        let alone = whole.solution(&DVector::zeros(set.len()));
        let starts: Vec<DVector<f64>> = columns.iter().map(|&c| whole.bordered(c, &alone, 0.0)).collect();
        let value = |(start, &c): (&DVector<f64>, &usize)| start[set.len()] * self.scale[c] / self.scale[last];
        let mut tried: Vec<CandidateEffect> =
            starts.iter().zip(columns).map(|one| CandidateEffect { error: 0.0, value: value(one) }).collect();
        for tenth in &self.tenths {
            let Some(rest) = Normal::new(&(&self.all - tenth), set, FOLD_REGULARISATION_SHARE) else {
                return columns.iter().map(|_| none()).collect();
            };
            for ((tried, start), &c) in tried.iter_mut().zip(&starts).zip(columns) {
                let held = start.rows(0, set.len()).into_owned();
                let x = rest.bordered(c, &rest.solution(&held), start[set.len()]);
                tried.error += residual_square(tenth, &[set, &[c]].concat(), &x);
            }
        }
        tried
    }
}

/// |W x - y|^2 for the columns of W in `set`. `products`: [W y]' [W y].
fn residual_square(products: &DMatrix<f64>, set: &[usize], x: &DVector<f64>) -> f64 {
    let last = products.nrows() - 1;
    let mut all = DVector::zeros(last + 1);
    set.iter().zip(x.iter()).for_each(|(&c, x)| all[c] = *x);
    all[last] = -1.0;
    all.dot(&(products * &all)).max(0.0)
}

/// Regularised normal equations of the columns in `set`. `hold`: regularisation, as a share of the squared norm of a column.
struct Normal<'a> {
    products: DMatrix<f64>,
    set: &'a [usize],
    hold: f64,
    factor: Cholesky<f64, Dyn>,
}

impl<'a> Normal<'a> {
    /// Sets up and factorises the normal equations; `None` if they cannot be solved.
    fn new(products: &DMatrix<f64>, set: &'a [usize], hold: f64) -> Option<Normal<'a>> {
        let entry = |i: usize, j: usize| {
            let held = if i == j { hold * products[(set[i], set[i])] + WHOLE_REGULARISATION_SHARE } else { 0.0 };
            products[(set[i], set[j])] + held
        };
        let factor = Cholesky::new(DMatrix::from_fn(set.len(), set.len(), entry))?;
        Some(Normal { products: products.clone(), set, hold, factor })
    }

    /// Solves for the parameters of the set, which are regularised towards `start`.
    fn solution(&self, start: &DVector<f64>) -> DVector<f64> {
        let last = self.products.nrows() - 1;
        let right = |i: usize| {
            let c = self.set[i];
            self.products[(c, last)] + self.hold * self.products[(c, c)] * start[i]
        };
        self.factor.solve(&DVector::from_fn(self.set.len(), |i, _| right(i)))
    }

    /// Solves for the parameters of the set and of an additional column c (last entry). `alone`: solution without c; `start`:
    /// value towards which the parameter of c is regularised. The cost is only one solution with the known Cholesky factor of
    /// the set.
    fn bordered(&self, c: usize, alone: &DVector<f64>, start: f64) -> DVector<f64> {
        let last = self.products.nrows() - 1;
        let beside = DVector::from_fn(self.set.len(), |i, _| self.products[(self.set[i], c)]);
        let by_others = self.factor.solve(&beside);
        let (own, right) = (self.products[(c, c)], self.products[(c, last)]);
        let pivot = own * (1.0 + self.hold) - beside.dot(&by_others);
        let is_identifiable = pivot > WHOLE_REGULARISATION_SHARE.sqrt() * own;
        let x = if is_identifiable { (right + self.hold * own * start - beside.dot(alone)) / pivot } else { 0.0 };
        let mut all = alone - by_others * x;
        all = all.push(x);
        all
    }
}

impl fmt::Display for JointTerms {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.taken.is_empty() {
            let least = 100.0 * (1.0 - WORTHWHILE_ERROR_RATIO);
            return writeln!(f, "no term of a single joint lowers the held-out error by {least:.1} %");
        }
        writeln!(f, "terms of single joints, and the held-out error relative to the fit without them:")?;
        self.taken.iter().try_for_each(|taken| writeln!(f, "   {:.3}  {}", taken.ratio, taken.term))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_arm::Pendulum;
    use linear_model::regressor::predict_load;
    use random::Random;

    /// The friction terms that are chosen for a simulated pendulum with the friction torque `friction(dq, load)`. The load is
    /// predicted with the true parameters.
    fn found(friction: impl Fn(f64, f64) -> f64) -> (JointTerms, f64) {
        let arm = Pendulum::new();
        let mut states = arm.states(3000);
        predict_load(&arm, &mut states, &arm.truth);
        let mut random = Random::new(5);
        for r in 0..states.len() {
            states.tau[r] += friction(states.dq[r], states.load[r]) + 0.05 * random.normal();
        }
        let fastest = states.dq.iter().fold(0.0, |a: f64, v| a.max(v.abs()));
        let candidates = joint_candidates(&[fastest]);
        let terms = choose_joint_terms(&arm, [states].as_slice(), &Options::default(), &candidates, None).unwrap();
        (terms, fastest)
    }

    #[test]
    fn the_term_that_is_there_is_taken() {
        let (none, fastest) = found(|dq, _| 0.3 * dq + 0.5 * dq.signum());
        assert_eq!(none.taken, []);
        let first = |friction: &dyn Fn(f64, f64) -> f64| {
            let (terms, _) = found(friction);
            assert!(terms.taken[0].ratio < 0.9, "{terms}");
            terms.taken[0].term
        };
        let at = |term| FrictionTerm::At(1, term);
        assert_eq!(first(&|dq, load| 0.3 * dq + (0.5 + 0.1 * load.abs()) * dq.signum()), at(JointTerm::Load));
        let slow = STRIBECK_SPEED_SHARES[1] * fastest;
        let bump = |dq: f64| (-(dq / slow) * (dq / slow)).exp();
        assert_eq!(first(&|dq, _| 0.3 * dq + (0.5 + bump(dq)) * dq.signum()), at(JointTerm::Stribeck(slow)));
        assert_eq!(first(&|dq, _| 0.3 * dq + 0.2 * dq.abs()), at(JointTerm::ViscousAsymmetry));
        assert_eq!(first(&|dq, _| 0.3 * dq + dq.abs().sqrt() * dq.signum()), at(JointTerm::Root));
        // Load coefficients below 0 or above `LARGEST_LOAD_COEFFICIENT` are rejected.
        for coefficient in [-0.1, 0.4] {
            let (terms, _) = found(|dq, load| 0.3 * dq + (5.0 + coefficient * load.abs()) * dq.signum());
            assert!(!terms.has_load(), "{terms}");
        }
    }

    /// The error E from products, directly and with a column added, equals the error of cross-validation from triangles (R of
    /// QR).
    #[test]
    fn products_give_the_error_of_cross_validation() {
        use crate::estimate::held_out::cross_validate;
        use crate::estimators::weighted::Weights;
        let arm = Pendulum::new();
        let mut states = arm.states(2000);
        let mut random = Random::new(6);
        states.tau.iter_mut().for_each(|tau| *tau += 0.3 * random.normal());
        let terms = [FrictionTerm::Viscous, FrictionTerm::Coulomb];
        let model = Model::new(&arm, &terms, &[]);
        let rows = Observation::of(&model, &states, 20);
        let (_, weights) = fit(&rows.joints(|_| true), Weights::Joint);
        let folds = Folds::new(&rows, &weights);
        let whole: Vec<usize> = (0..model.p()).collect();
        let (before, column) = whole.split_at(model.p() - 1);
        let (bordered, direct) = (folds.with_each(before, column)[0].error, folds.error(&whole));
        assert!((bordered / direct - 1.0).abs() < 1e-9, "{bordered} {direct}");
        let torque: f64 = states.tau.iter().map(|tau| tau * tau).sum();
        let expected = cross_validate(&model, &rows, Weights::Joint).total;
        let found = (direct / torque).sqrt() / weights[0];
        // Tolerance: the two methods regularise differently.
        assert!((found / expected - 1.0).abs() < 1e-4, "{found} {expected}");
    }
}
