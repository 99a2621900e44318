//! Tests hypotheses at a fit. A hypothesis is a possible fault of a log, or a rotor inertia that the model lacks. Each
//! hypothesis is estimated as one additional unknown u.
//!
//! The parameters X are re-fitted in each test, so wrong nominal bodies do not look like a fault. W: regressor; Y_j: row of
//! joint j; x: fitted parameters; h: column of the unknown, with the entry h_j for joint j (other entries are zero):
//!
//! ```text
//! tau = W X + h u        zero of k     h_j = d(Y_j x)/dq_k
//!                        scale of k    h_k = Y_k x, without friction
//!                        spring of k   h_k = q_k
//!                        rotor of k    h_k = ddq_k
//!                        drift of k    h_k = s tau_k, s from -1/2 at the first sample of a record to 1/2 at its last
//!                        mount         h   = the torques per angle of a tilted gravity
//!                        late          h_k = -d tau_k/dt, of one joint or of all
//!                        dead current  h_k = K_k sign(tau_k), K_k: torque per current
//!                        play of k     h_j = -s/2 d(Y_j x)/dq_k, and likewise for velocity and acceleration (`play`)
//!                        load of k     h_k = sign(dq_k) |Y_k x|
//!                        talk of i     h_k = tau_i, the torque of another joint
//! ```
//! A QR factorisation (triangle) projects h and tau onto the orthogonal complement of the columns of W. The projections give u
//! and the smallest u that would be found. The standard deviation of u is a jackknife over tenths of the record, and at least the
//! standard deviation for white noise. A fault is found under three conditions: u exceeds `FOUND_FAULT_SIGMAS` standard
//! deviations, the fault multiplies the error of cross-validation by less than `WORTHWHILE_ERROR_RATIO`, and it explains at least
//! `least_share` of the torque.
//!
//! A significant fault that explains too little to be named still changes the parameters, so it inflates their standard
//! deviations. A fault that the data do not exclude does the same (`sigma_inflation`). Delays, load friction and cross talk
//! only inflate standard deviations: the first two are detected elsewhere (log check, `friction: auto`), and one of the many
//! columns of cross talk explains a small part of any residual by chance.
//!
//! A rotor is not identifiable if its column is a combination of other columns; [`HypothesisTest::within`] lists the parameters
//! of these columns. A common scale of all torques, and the zero of a joint with unknown bodies, are not identifiable either.

use linear_model::linear_model::Model;
use logs::Error;
use numerics::triangle::{Triangle, TriangleBuilder, select};
use numerics::vector::dot;

use crate::estimate::claims::gaps::settle_play;
use crate::estimate::claims::hypothesis_test::WORTHWHILE_ERROR_RATIO;
pub use crate::estimate::claims::hypothesis_test::{FOUND_FAULT_SIGMAS, HypothesisTest};
pub use crate::estimate::hypothesis::{FitPoint, Hypothesis, Tilt, UndeterminedMechanics};
use crate::estimate::hypothesis::{all, columns};
use crate::estimators::huber::row_factor;
use crate::signals::records::Records;
use crate::signals::thinned::MOST_THINNED_SAMPLES;

/// Number of blocks of the record in cross-validation and in the jackknife.
pub(super) const LEFT_OUT_PARTS: usize = 10;
/// Weight of the row that regularises a parameter towards its fitted value, divided by the norm of the parameter's column.
const HELD_COLUMN_SHARE: f64 = 1e-4;
/// A hypothesis is not identifiable if less than this share of the norm of its column is orthogonal to all parameter columns.
pub(super) const EXPLAINED_COLUMN_SHARE: f64 = 1e-3;
/// If the column of a hypothesis is a linear combination of parameter columns, a parameter is listed in
/// `HypothesisTest::within` if its term has at least this share of the norm of the hypothesis column.
const WITHIN_COLUMN_SHARE: f64 = 0.01;
/// Largest number of coordinates for which hypotheses are tested. With more coordinates, the tests take too long.
pub(super) const MOST_COORDINATES: usize = 12;

/// Tests every hypothesis at a fit. `fit`: the solution and the weights of its rows. Empty if the robot has more than 12
/// coordinates or no parameters.
///
/// Fails when a record cannot be read.
pub fn hypotheses<R: Records + ?Sized>(
    model: &Model,
    records: &R,
    fit: FitPoint,
    open: UndeterminedMechanics,
) -> Result<Vec<HypothesisTest>, Error> {
    let all = hypotheses_of(model, open);
    if all.is_empty() {
        return Ok(Vec::new());
    }
    let (parts, torques) = triangles(model, records, fit, open, &all, LEFT_OUT_PARTS)?;
    let share = |of: &Hypothesis| of.joint().map_or(1.0, |k| (torques[k] / torques.iter().sum::<f64>()).sqrt());
    let mut found = tested(&parts, fit.x, &all);
    settle_play(&mut found, model.n(), |play, all| {
        Ok(tested(
            &triangles(model, records, fit, UndeterminedMechanics { play, ..open }, all, LEFT_OUT_PARTS)?.0,
            fit.x,
            all,
        ))
    })?;
    Ok(found.into_iter().map(|one| HypothesisTest { torque_share: share(&one.of), ..one }).collect())
}

/// Lists every hypothesis on a model that is tested; empty if the robot has more than 12 coordinates or no parameters.
pub fn hypotheses_of(model: &Model, open: UndeterminedMechanics) -> Vec<Hypothesis> {
    match model.n() > MOST_COORDINATES || model.regressor.parameters().is_empty() {
        true => Vec::new(),
        false => all(model, open),
    }
}

/// Computes the triangle (R of QR) of the weighted rows [W | h | tau] of each block of the records; and, for each joint, the
/// sum of squares of the weighted torque. h: one column per hypothesis in `all`.
///
/// Fails when a record cannot be read.
pub fn triangles<R: Records + ?Sized>(
    model: &Model,
    records: &R,
    fit: FitPoint,
    open: UndeterminedMechanics,
    all: &[Hypothesis],
    count_of_parts: usize,
) -> Result<(Vec<Triangle>, Vec<f64>), Error> {
    let n = model.n();
    // The records are thinned, because each sample needs several evaluations of the regressor.
    let thinned = records.thinned(MOST_THINNED_SAMPLES)?;
    let (count, every) = (thinned.count, thinned.every);
    let (p, width) = (model.p(), model.p() + all.len());
    let mut parts: Vec<TriangleBuilder> = (0..count_of_parts).map(|_| TriangleBuilder::new(width)).collect();
    let (mut torques, mut taken_out) = (vec![0.0; n], vec![0.0; count_of_parts]);
    for (first, kept) in &thinned.records {
        let columns = columns(model, kept, fit.x, all, open);
        let mut row = vec![0.0; width];
        model.rows(kept, 0..kept.len(), |r, w| {
            let part = ((first + r * every) * count_of_parts / count.max(1)).min(count_of_parts - 1);
            for j in (0..n).filter(|j| kept.used[r * n + j]) {
                let (w, tau) = (&w[j * p..(j + 1) * p], kept.tau[r * n + j]);
                let weight = fit.weights[j] * row_factor(fit.robust, j, tau - dot(w, fit.x));
                for (out, w) in row.iter_mut().zip(w) {
                    *out = weight * w;
                }
                for (out, column) in row[p..].iter_mut().zip(&columns) {
                    *out = weight * column[r * n + j];
                }
                let torque = weight * tau;
                let measured = torque + weight * model.spring(kept, r, j);
                torques[j] += measured * measured;
                taken_out[part] += measured * measured - torque * torque;
                parts[part].push(&row, torque);
            }
        });
    }
    let parts = parts.into_iter().map(TriangleBuilder::finish).zip(taken_out);
    Ok((parts.map(|(part, taken_out)| part.with_taken_out(taken_out)).collect(), torques))
}

/// Tests the hypotheses `all`, one result each. `parts`: triangles (R of QR) of the blocks; `x`: fitted parameters.
pub fn tested(parts: &[Triangle], x: &[f64], all: &[Hypothesis]) -> Vec<HypothesisTest> {
    let p = x.len();
    // Rows of weight `HELD_COLUMN_SHARE` regularise the parameters towards x, so that parameters that the data do not determine
    // keep the values in x.
    let whole = merged(parts, None);
    let held = held(&whole, x);
    let left = |out: Option<usize>| {
        let mut sum = merged(parts, out);
        sum.merge(&held, 1.0);
        UnknownsResidual::of(&sum, p)
    };
    let mut all_rows = whole.clone();
    all_rows.merge(&held, 1.0);
    let columns = |e: usize| (0..p).chain([p + e]).collect::<Vec<usize>>();
    let without = select(&all_rows, &columns(0)[..p]).solution();
    let all_in = left(None);
    let leaving: Vec<UnknownsResidual> = (0..parts.len()).map(|part| left(Some(part))).collect();
    let rows = whole.rows.saturating_sub(p + 1).max(1) as f64;
    let noise = (all_in.square() / rows).sqrt();
    // Each hypothesis is tested alone. A hypothesis is not identifiable if the columns of W explain its column.
    let test = |(e, hypothesis): (usize, &Hypothesis)| {
        let (value, norm) = all_in.unknown(e);
        let is_identifiable = norm > EXPLAINED_COLUMN_SHARE * whole.column_norm(p + e) && norm > 0.0;
        if !is_identifiable {
            return HypothesisTest {
                within: explaining(&all_rows, p, p + e),
                ..HypothesisTest::not_identifiable(hypothesis)
            };
        }
        // The standard deviation is a jackknife over the blocks, and at least the standard deviation for white noise.
        let others: Vec<f64> = leaving.iter().map(|left| left.unknown(e).0).collect();
        let deviation = jackknife(&others).max(noise / norm);
        let with = select(&all_rows, &columns(e)).solution();
        let effect = with.iter().zip(&without).map(|(with, without)| with - without).take(p).collect();
        let mut one = HypothesisTest { value, deviation, effect, ..HypothesisTest::not_identifiable(hypothesis) };
        // A fault is found under two conditions: the error falls by enough, and u is significant. Each condition gives a least
        // |u|. The larger of the two is the detection limit.
        let by_ratio = (1.0 / (WORTHWHILE_ERROR_RATIO * WORTHWHILE_ERROR_RATIO) - 1.0).sqrt() * all_in.square().sqrt();
        let torque = (whole.column_norm(whole.columns()).powi(2) + whole.taken_out).sqrt();
        let by_error = by_ratio.max(hypothesis.kind().least_share * torque) / norm;
        one.power = by_error.max(FOUND_FAULT_SIGMAS * deviation).max(hypothesis.kind().least);
        if one.is_significant() {
            one.held_out = Some(held_out(parts, &held, &columns(e), p));
        }
        one
    };
    all.iter().enumerate().map(test).collect()
}

/// Indices of those of the first p columns whose linear combination gives column c.
fn explaining(triangle: &Triangle, p: usize, c: usize) -> Vec<usize> {
    let least = WITHIN_COLUMN_SHARE * triangle.column_norm(c);
    let made_of = coefficients(triangle, p, c);
    (0..p).filter(|&i| (made_of[i] * triangle.column_norm(i)).abs() > least).collect()
}

/// Coefficients of the least-squares approximation of column c by the first p columns. `triangle`: R of QR.
pub(super) fn coefficients(triangle: &Triangle, p: usize, c: usize) -> Vec<f64> {
    let mut left: Vec<f64> = (0..p).map(|i| triangle.at(i, c)).collect();
    let mut found = vec![0.0; p];
    for i in (0..p).rev().filter(|&i| triangle.at(i, i) != 0.0) {
        found[i] = left[i] / triangle.at(i, i);
        (0..i).for_each(|k| left[k] -= found[i] * triangle.at(k, i));
    }
    found
}

/// The standard deviation of an estimate by the jackknife. `others`: for each block, the estimate without this block.
pub(super) fn jackknife(others: &[f64]) -> f64 {
    let m = others.len() as f64;
    let mean = others.iter().sum::<f64>() / m;
    (others.iter().map(|u| (u - mean).powi(2)).sum::<f64>() * (m - 1.0) / m).sqrt()
}

/// Relative errors of cross-validation over the blocks: (with the first p of `columns`, with all `columns`). `parts`:
/// triangle of each block; `held`: rows that regularise the parameters.
fn held_out(parts: &[Triangle], held: &Triangle, columns: &[usize], p: usize) -> (f64, f64) {
    let (mut whole, mut without, mut with) = (0.0, 0.0, 0.0);
    for (k, part) in parts.iter().enumerate() {
        let mut rest = merged(parts, Some(k));
        rest.merge(held, 1.0);
        let error = |columns: &[usize]| {
            let x = select(&rest, columns).solution();
            select(part, columns).squares(&x)
        };
        let (all, more) = error(columns);
        (whole, with, without) = (whole + all, with + more, without + error(&columns[..p]).1);
    }
    ((without / whole).sqrt(), (with / whole).sqrt())
}

pub(super) fn merged(parts: &[Triangle], out: Option<usize>) -> Triangle {
    let kept = parts.iter().enumerate().filter(|(k, _)| Some(*k) != out);
    Triangle::sum(parts[0].columns(), kept.map(|(_, part)| part))
}

/// Rows that regularise each parameter weakly towards its fitted value `x`, as a triangle (R of QR).
pub(super) fn held(rows: &Triangle, x: &[f64]) -> Triangle {
    let mut block = TriangleBuilder::new(rows.columns());
    for (c, x) in x.iter().enumerate() {
        let mut row = vec![0.0; rows.columns()];
        row[c] = HELD_COLUMN_SHARE * rows.column_norm(c).max(f64::MIN_POSITIVE);
        block.push(&row, row[c] * x);
    }
    block.finish()
}

/// The columns of the unknowns and of the torque, projected onto the complement of the columns of the parameters.
struct UnknownsResidual {
    /// One projected column per unknown.
    columns: Vec<Vec<f64>>,
    torque: Vec<f64>,
}

impl UnknownsResidual {
    /// Takes the projections from a triangle (R of QR) whose first p columns belong to the parameters.
    fn of(triangle: &Triangle, p: usize) -> UnknownsResidual {
        let width = triangle.columns();
        let column = |c: usize| (p..=width).map(|i| if i <= c { triangle.at(i, c) } else { 0.0 }).collect();
        UnknownsResidual { columns: (p..width).map(column).collect(), torque: column(width) }
    }

    /// Value of unknown e if no other unknown is fitted, and the norm of the projected column of e.
    fn unknown(&self, e: usize) -> (f64, f64) {
        let column = &self.columns[e];
        let square: f64 = column.iter().map(|x| x * x).sum();
        let product: f64 = column.iter().zip(&self.torque).map(|(a, b)| a * b).sum();
        (if square > 0.0 { product / square } else { 0.0 }, square.sqrt())
    }

    fn square(&self) -> f64 {
        self.torque.iter().map(|x| x * x).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_arm::Pendulum;
    use linear_model::friction::terms::FrictionTerm;
    use linear_model::states::States;

    /// The test result of a hypothesis on states that are modified by `change`; and the relative errors of the parameters:
    /// [hypothesis not fitted, hypothesis fitted].
    fn tested_with(of: &Hypothesis, change: impl Fn(&mut States)) -> (HypothesisTest, [f64; 2]) {
        let arm = Pendulum::new();
        let model = Model::new(&arm, &FrictionTerm::STANDARD, &[]);
        let mut states = arm.states(1000);
        change(&mut states);
        let exact = [&arm.truth[..], &[0.0; 3]].concat();
        let mut rows = TriangleBuilder::new(exact.len());
        model.rows(&states, 0..states.len(), |r, w| rows.push(w, states.tau[r]));
        let x = rows.finish().solution();
        let found = hypotheses(
            &model,
            &[states][..],
            FitPoint { x: &x, weights: &[1.0], robust: None },
            UndeterminedMechanics::default(),
        )
        .unwrap();
        let found = found.into_iter().find(|tested| tested.of == *of).unwrap();
        let norm = |x: &mut dyn Iterator<Item = f64>| x.map(|x| x * x).sum::<f64>().sqrt();
        let error = |with: f64| {
            let left = x.iter().zip(&found.effect).zip(&exact).map(|((x, effect), exact)| x + with * effect - exact);
            norm(&mut { left }) / norm(&mut exact.iter().copied())
        };
        let errors = [error(0.0), error(1.0)];
        (found, errors)
    }

    #[test]
    fn late_torques_are_told() {
        let late = |states: &mut States| {
            states.tau.rotate_right(1);
            states.tau[0] = states.tau[1];
        };
        for joint in [None, Some(0)] {
            let (found, [without, with]) = tested_with(&Hypothesis::Late(joint), late);
            // Tolerance: the central difference has the relative error (w h)^2/6 (w: angular frequency, h: sample time), and
            // the error of the fit grows with the square of the delay. Together, both errors are some per cent at 5.1 rad/s.
            assert!((found.value - 0.01).abs() < 5e-4, "{found:?}");
            assert!(found.is_significant() && !found.is_found(), "{found:?}");
            // The error that remains after the correction grows with the square of the delay.
            assert!(with < 0.2 * without, "{without} {with}");
        }
        let (none, _) = tested_with(&Hypothesis::Late(None), |_| {});
        assert!(none.value.abs() < 1e-4, "{none:?}");
    }

    #[test]
    fn friction_of_the_load_is_told() {
        let loaded = |states: &mut States| {
            let load: Vec<f64> = states.tau.iter().map(|tau| tau.abs()).collect();
            states.tau.iter_mut().zip(load).zip(&states.direction).for_each(|((tau, load), s)| *tau += 0.1 * s * load);
        };
        let (found, [without, with]) = tested_with(&Hypothesis::LoadFriction(0), loaded);
        // The load |Y_k x| is not exact, because x comes from a fit without load friction.
        assert!((found.value - 0.1).abs() < 0.02 && found.is_significant() && !found.is_found(), "{found:?}");
        assert!(with < 0.2 * without, "{without} {with}");
    }
}
