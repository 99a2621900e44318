//! Torque per unit of current of each drive, with the parameters, from currents alone.
//!
//! Of joint j, with friction and other nuisance already projected out: D_j X = kt_j I_j. One gain
//! (or one known quantity in X) fixes the scale: without it everything is known up to a factor.
//!
//! - Maximum likelihood: min sum_j |I_j - g_j D_j X|^2, g_j = 1/kt_j, rows in units of their noise;
//!   Gauss-Newton from least squares. Noise is in the currents alone, so no scaling is needed.
//! - Total least squares: [D, -I_1, -I_2, ... | I_ref], D exact: the exact columns are taken out by QR and
//!   the rest is the direction of the least singular value [Van Huffel, Vandewalle 1991], after
//!   scaling column c by G_c^-1/2, G_c = sum over its rows of diag(1 - Q Q'): the noise that is
//!   left in the column. Unscaled it is biased, because the parameters use up the rows of the
//!   joints unequally.
//!
//! [Gautier, Vandanjon, Presse 1994], [Vandanjon, Gautier, Desbats 1995], section 4.2.

use nalgebra::DMatrix;

use crate::least_squares::{Solution, solve};
use crate::triangle::{Block, Triangle};

/// The equations of one joint in currents: `rows[r]` X = kt `current[r]`, each current with noise of unit
/// variance.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JointEquations {
    pub rows: Vec<Vec<f64>>,
    pub current: Vec<f64>,
}

/// Gains and parameters.
#[derive(Clone, Debug)]
pub struct GainEstimate {
    /// N m per unit of current, one a joint.
    pub gain: Vec<f64>,
    /// Standard deviations; 0 for the gain that was given.
    pub gain_deviation: Vec<f64>,
    /// Base parameters.
    pub parameters: Vec<f64>,
    pub deviation: Vec<f64>,
    /// Whether the data determine the parameter.
    pub determined: Vec<bool>,
    /// Gauss-Newton steps; `None`: it did not converge.
    pub steps: Option<usize>,
    /// Sum of squares of the residuals, of unit variance when noise is all there is.
    pub chi_square: f64,
    pub freedom: usize,
    /// Of the linearised equations, columns scaled.
    pub condition_number: f64,
}

/// Equations with nuisance columns to equations without: the rows of the triangle below them.
///
/// `rows[r]`: nuisance, then p parameters; weighted. With `calibrate` the noise is taken from what the
/// joint's own best parameters leave, not from the weights.
pub fn without_nuisance(rows: &[Vec<f64>], current: &[f64], nuisance: usize, calibrate: bool) -> JointEquations {
    let Some(width) = rows.first().map(Vec::len) else { return JointEquations::default() };
    let mut triangle = Triangle::new(width);
    let mut block = Block::new(width);
    for (row, &y) in rows.iter().zip(current) {
        if block.is_full() {
            triangle.fold(&mut block);
        }
        block.push(row, y);
    }
    triangle.fold(&mut block);
    let own = solve(&triangle);
    let scale = if calibrate && own.variance > 0.0 { own.variance.sqrt() } else { 1.0 };
    // The last row is what no parameters explain; it says nothing about them.
    let kept = || nuisance..width;
    JointEquations {
        rows: kept()
            .map(|i| (nuisance..width).map(|j| if j >= i { triangle.at(i, j) / scale } else { 0.0 }).collect())
            .collect(),
        current: kept().map(|i| triangle.at(i, width) / scale).collect(),
    }
}

/// Least squares in torque, the start of the others: unknown gains multiply the noisy currents.
fn least_squares(joints: &[JointEquations], p: usize, known: usize, gain: f64) -> (Vec<f64>, Vec<f64>) {
    let unknown: Vec<usize> = (0..joints.len()).filter(|&j| j != known).collect();
    let width = p + unknown.len();
    let mut triangle = Triangle::new(width);
    let mut block = Block::new(width);
    for (j, equations) in joints.iter().enumerate() {
        for (d, &i) in equations.rows.iter().zip(&equations.current) {
            let mut row = d.clone();
            row.extend(unknown.iter().map(|&u| if u == j { -i } else { 0.0 }));
            if block.is_full() {
                triangle.fold(&mut block);
            }
            block.push(&row, if j == known { gain * i } else { 0.0 });
        }
    }
    triangle.fold(&mut block);
    let x = solve(&triangle).x;
    let mut gains = vec![gain; joints.len()];
    unknown.iter().enumerate().for_each(|(at, &u)| gains[u] = x[p + at]);
    (x[..p].to_vec(), gains)
}

/// Gains and parameters by maximum likelihood; the gain of joint `known` is `gain`.
pub fn maximum_likelihood(joints: &[JointEquations], p: usize, known: usize, gain: f64) -> GainEstimate {
    let unknown: Vec<usize> = (0..joints.len()).filter(|&j| j != known).collect();
    let (mut x, gains) = least_squares(joints, p, known, gain);
    let mut g: Vec<f64> = gains.iter().map(|k| if *k > 0.0 { 1.0 / k } else { 1.0 / gain }).collect();
    let width = p + unknown.len();
    let mut steps = None;
    let mut last: Option<Solution> = None;
    let mut rows = 0;
    for step in 0..50 {
        let mut triangle = Triangle::new(width);
        let mut block = Block::new(width);
        for (j, equations) in joints.iter().enumerate() {
            for (d, &i) in equations.rows.iter().zip(&equations.current) {
                let torque: f64 = d.iter().zip(&x).map(|(d, x)| d * x).sum();
                let mut row: Vec<f64> = d.iter().map(|d| g[j] * d).collect();
                row.extend(unknown.iter().map(|&u| if u == j { torque } else { 0.0 }));
                if block.is_full() {
                    triangle.fold(&mut block);
                }
                block.push(&row, i - g[j] * torque);
            }
        }
        triangle.fold(&mut block);
        rows = triangle.rows;
        let solution = solve(&triangle);
        let step_size: f64 = (0..width)
            .filter(|&c| solution.determined[c] && solution.inverse[(c, c)] > 0.0)
            .map(|c| solution.x[c].powi(2) / solution.inverse[(c, c)])
            .fold(0.0, f64::max);
        x.iter_mut().zip(&solution.x).for_each(|(x, d)| *x += d);
        unknown.iter().enumerate().for_each(|(at, &u)| g[u] += solution.x[p + at]);
        last = Some(solution);
        // A step below a millionth of every standard deviation changes nothing.
        if step_size < 1e-12 {
            steps = Some(step + 1);
            break;
        }
    }
    let chi_square = joints
        .iter()
        .zip(&g)
        .flat_map(|(e, g)| e.rows.iter().zip(&e.current).map(move |(d, i)| (d, i, g)))
        .map(|(d, i, g)| (i - g * d.iter().zip(&x).map(|(d, x)| d * x).sum::<f64>()).powi(2))
        .sum();
    let deviation = |c: usize| last.as_ref().map_or(f64::INFINITY, |s| s.inverse[(c, c)].max(0.0).sqrt());
    let mut gain_deviation = vec![0.0; joints.len()];
    unknown.iter().enumerate().for_each(|(at, &u)| gain_deviation[u] = deviation(p + at) / (g[u] * g[u]));
    GainEstimate {
        gain: g.iter().map(|g| 1.0 / g).collect(),
        gain_deviation,
        deviation: (0..p).map(deviation).collect(),
        determined: last.as_ref().map_or(vec![false; p], |s| s.determined[..p].to_vec()),
        parameters: x,
        condition_number: last.as_ref().map_or(f64::INFINITY, |s| s.condition_number),
        steps,
        chi_square,
        freedom: rows.saturating_sub(last.as_ref().map_or(0, |s| s.rank)),
    }
}

/// How the columns of currents are scaled in total least squares.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scaling {
    /// To the noise left in each column.
    Noise,
    /// Not at all: biased where the noise is large.
    None,
}

/// (gains, parameters) by mixed least squares and total least squares.
///
/// `None` when there are fewer equations than unknowns or no direction singles itself out.
pub fn gains_by_total_least_squares(
    joints: &[JointEquations],
    p: usize,
    known: usize,
    gain: f64,
    scaling: Scaling,
) -> Option<(Vec<f64>, Vec<f64>)> {
    let (_, start) = least_squares(joints, p, known, gain);
    let start: Vec<f64> = start.iter().map(|k| if *k > 0.0 { *k } else { gain }).collect();
    // Rows over the first guess of the gain: the noise of every current column is one.
    let order: Vec<usize> = (0..joints.len()).filter(|&j| j != known).chain([known]).collect();
    let place: Vec<(usize, usize)> =
        order.iter().flat_map(|&j| (0..joints[j].rows.len()).map(move |r| (j, r))).collect();
    let (count, currents) = (place.len(), joints.len());
    if count <= p + currents {
        return None;
    }
    let exact = DMatrix::from_fn(count, p, |r, c| joints[place[r].0].rows[place[r].1][c] / start[place[r].0]);
    let noisy = DMatrix::from_fn(count, currents, |r, c| {
        let (j, at) = place[r];
        let sign = if j == known { 1.0 } else { -1.0 };
        if order[c] == j { sign * joints[j].current[at] } else { 0.0 }
    });
    let svd = exact.clone().svd(true, true);
    let tolerance = 1e-10 * svd.singular_values.max();
    let u = svd.u.as_ref()?;
    let kept: Vec<usize> = (0..svd.singular_values.len()).filter(|&i| svd.singular_values[i] > tolerance).collect();
    let basis = DMatrix::from_fn(count, kept.len(), |r, c| u[(r, kept[c])]);
    let rest = &noisy - &basis * (basis.transpose() * &noisy);
    let left = |r: usize| 1.0 - basis.row(r).norm_squared();
    let scale: Vec<f64> = (0..currents)
        .map(|c| match scaling {
            Scaling::None => 1.0,
            Scaling::Noise => {
                let g: f64 = (0..count).filter(|&r| place[r].0 == order[c]).map(left).sum();
                1.0 / g.max(1e-12).sqrt()
            }
        })
        .collect();
    let scaled = DMatrix::from_fn(count, currents, |r, c| rest[(r, c)] * scale[c]);
    let values = scaled.svd(false, true);
    let smallest = values.singular_values.imin();
    let v = values.v_t.as_ref()?.row(smallest).transpose();
    let last = currents - 1;
    let direction = v[last] * scale[last];
    if direction.abs() < 1e-12 {
        return None;
    }
    // Known rows read D X / k0 = (k/k0) I with k = gain = k0.
    let ratio: Vec<f64> = (0..currents).map(|c| -v[c] * scale[c] / direction).collect();
    let mut gains = vec![gain; currents];
    (0..last).for_each(|c| gains[order[c]] = ratio[c] * start[order[c]]);
    let right = DMatrix::from_fn(count, 1, |r, _| {
        let (j, at) = place[r];
        gains[j] / start[j] * joints[j].current[at]
    });
    let x = svd.solve(&right, tolerance).ok()?;
    Some((gains, x.iter().copied().collect()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    const GAINS: [f64; 3] = [2.393, 0.870, 1.0];
    const TRUTH: [f64; 5] = [0.3, -0.1, 0.05, 1.2, -0.4];

    /// The first joint has hardly more rows than its own parameters, as on a real arm.
    fn joints(random: &mut Random, noise: f64) -> Vec<JointEquations> {
        let mut pattern = Random::new(1);
        let mut joint = |j: usize, count: usize| {
            let mut e = JointEquations::default();
            for _ in 0..count {
                let row: Vec<f64> =
                    (0..5).map(|c| if j == 0 || c > 0 { 200.0 * pattern.normal() } else { 0.0 }).collect();
                let torque: f64 = row.iter().zip(TRUTH).map(|(d, x)| d * x).sum();
                e.current.push(torque / GAINS[j] / noise + random.normal());
                e.rows.push(row.iter().map(|d| d / noise).collect());
            }
            e
        };
        vec![joint(0, 4), joint(1, 12), joint(2, 10)]
    }

    #[test]
    fn without_noise_the_gains_come_back() {
        let joints = joints(&mut Random::new(2), 1e-6);
        let ml = maximum_likelihood(&joints, 5, 2, 1.0);
        let (gains, x) = gains_by_total_least_squares(&joints, 5, 2, 1.0, Scaling::Noise).unwrap();
        assert!(ml.steps.is_some());
        for j in 0..3 {
            // Noise of 1e-6 beside torques of some hundred.
            assert!((ml.gain[j] - GAINS[j]).abs() < 1e-7 && (gains[j] - GAINS[j]).abs() < 1e-7);
        }
        for c in 0..5 {
            assert!((ml.parameters[c] - TRUTH[c]).abs() < 1e-7 && (x[c] - TRUTH[c]).abs() < 1e-7);
        }
    }

    #[test]
    fn likelihood_is_unbiased_with_honest_deviations_and_total_least_squares_agrees() {
        let mut random = Random::new(3);
        let draws = 400;
        let (mut chi, mut bias, mut bias_tls, mut sigma) = (0.0, 0.0, 0.0, 0.0);
        for _ in 0..draws {
            let joints = joints(&mut random, 20.0);
            let ml = maximum_likelihood(&joints, 5, 2, 1.0);
            let (gains, _) = gains_by_total_least_squares(&joints, 5, 2, 1.0, Scaling::Noise).unwrap();
            let e = (ml.gain[0] - GAINS[0]) / ml.gain_deviation[0];
            chi += e * e / f64::from(draws);
            bias += e / f64::from(draws);
            bias_tls += (gains[0] - GAINS[0]) / ml.gain_deviation[0] / f64::from(draws);
            sigma = ml.gain_deviation[0] / GAINS[0];
        }
        assert!(sigma > 0.005 && sigma < 0.2, "the noise is felt: {sigma}");
        // Mean and variance of 400 unit normals, five standard errors, and the bias of the second order.
        assert!(bias.abs() < 0.25 + sigma && bias_tls.abs() < 0.25 + sigma, "{bias} {bias_tls}");
        assert!((chi - 1.0).abs() < 0.4, "{chi}");
    }

    #[test]
    fn nuisance_is_projected_out() {
        let mut random = Random::new(6);
        let (mut rows, mut current) = (vec![], vec![]);
        for _ in 0..40 {
            let row: Vec<f64> = (0..5).map(|_| random.normal()).collect();
            current.push(7.0 * row[0] - 3.0 * row[1] + 0.5 * row[2] + 0.2 * row[3] - row[4]);
            rows.push(row);
        }
        let e = without_nuisance(&rows, &current, 2, false);
        assert_eq!(e.rows.len(), 3);
        for (d, i) in e.rows.iter().zip(&e.current) {
            let torque = 0.5 * d[0] + 0.2 * d[1] - d[2];
            // Rounding of forty rows.
            assert!((torque - i).abs() < 1e-12);
        }
    }
}
