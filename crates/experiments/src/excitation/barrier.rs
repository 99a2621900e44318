//! The kinematic limits of a motion as a logarithmic barrier, which keeps the steps of a minimizer inside the limits.
//!
//! Position, velocity, acceleration and jerk at instants of a period, and the control points of the blends (polynomials from rest
//! to the periodic motion and back), are linear in the coefficients x of a joint: low <= r x <= high, with one row vector r per
//! limited value. With S instants per period, the barrier is
//!
//! B(x) = -1/S sum [log((high - r x) / half) + log((r x - low) / half)],   half = (high - low) / 2
//!
//! The sum is over all rows r. x is in the units of [`MotionShape::units`], in which a coefficient of 1 is a large share of its
//! range. [Boyd, Vandenberghe 2004, 11.2]

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use numerics::information_matrix::add_products;
use processor::in_parallel;

use crate::excitation::limits::{CoordinateLimits, LimitKind};
use crate::excitation::motion::MotionShape;

/// Number of instants at which the barrier is evaluated, per instant at which the criterion of the search is evaluated.
///
/// With thirty instants in a period of the highest harmonic, a peak between two instants can be (pi/30)^2 / 2 = 0.5 % greater
/// than the values at these instants. If the motion is scaled down by this share, the determinant criterion decreases by twice
/// this share.
const BARRIER_INSTANTS_PER_SAMPLE: usize = 2;
/// Least number of joints for which several threads save time in the evaluation of the barrier.
const MIN_JOINTS_FOR_THREADS: usize = 12;
/// Share of the distance to a limit that one step of the minimizer may use.
const STEP_TO_BOUND_SHARE: f64 = 0.99;

/// The rows r of the barrier for one joint, with their limits.
#[derive(Clone)]
struct BarrierRows {
    /// Coefficients of the rows r, one row after the other, m (coefficients per joint) entries per row.
    rows: Vec<f64>,
    bounds: Vec<(f64, f64)>,
    /// Kind of limit (position, velocity, acceleration or jerk) of each row.
    kinds: Vec<LimitKind>,
    /// Metric (inner product) of the scaled coefficients of the joint, m x m for m coefficients: see [`MotionShape::metric`].
    metric: DMatrix<f64>,
}

/// The logarithmic barrier B of the kinematic limits of all joints that are not locked.
#[derive(Clone)]
pub struct Barrier {
    m: usize,
    weight: f64,
    joints: Vec<BarrierRows>,
}

impl Barrier {
    /// Makes the barrier for joints with these limits. No joint may be locked. `samples`: number of instants per period at which
    /// the criterion is evaluated.
    pub fn new(shape: &MotionShape, samples: usize, limits: &[&CoordinateLimits]) -> Barrier {
        let samples = BARRIER_INSTANTS_PER_SAMPLE * samples;
        let mut rows: Vec<(LimitKind, Vec<f64>)> = Vec::new();
        for (k, kind) in LimitKind::KINEMATIC.into_iter().enumerate() {
            rows.extend(shape.rows(k, samples, std::iter::empty()).into_iter().map(|row| (kind, row)));
            rows.extend(shape.blend_control(k).into_iter().map(|row| (kind, row)));
        }
        // A row of zeros limits nothing. Such rows come from the ends of the motion, where the robot is at rest.
        rows.retain(|(_, row)| row.iter().any(|x| *x != 0.0));
        let joint = |limits: &&CoordinateLimits| {
            let (m, scale) = (shape.size(), shape.units(limits));
            let bound = |kind: LimitKind| limits.bounds(kind).unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
            BarrierRows {
                rows: rows.iter().flat_map(|(_, row)| row.iter().zip(&scale).map(|(x, s)| x * s)).collect(),
                bounds: rows.iter().map(|(kind, _)| bound(*kind)).collect(),
                kinds: rows.iter().map(|(kind, _)| *kind).collect(),
                metric: DMatrix::from_row_slice(m, m, &shape.metric(limits, samples)),
            }
        };
        let joints = limits.iter().map(joint).collect();
        Barrier { m: shape.size(), weight: 1.0 / samples as f64, joints }
    }

    /// The linear form r of each limited value of one joint, with the value r x and its bounds (low, high). `x`: coefficients of
    /// all joints.
    fn rows<'a>(&'a self, joint: usize, x: &'a [f64]) -> impl Iterator<Item = (&'a [f64], f64, (f64, f64))> {
        let rows = &self.joints[joint];
        let x = &x[joint * self.m..][..self.m];
        rows.rows.chunks_exact(self.m).zip(&rows.bounds).map(move |(row, bounds)| (row, dot(row, x), *bounds))
    }

    /// The value of the barrier B at the coefficients x of all joints. Adds `factor` times the gradient of B to `gradient`.
    /// `None` if x is outside the limits. `threads` threads share the joints; their number does not change the result, bit for
    /// bit.
    pub fn value(&self, x: &[f64], factor: f64, gradient: &mut [f64], threads: usize) -> Option<f64> {
        let of_joint = |(joint, gradient): (usize, &mut [f64])| {
            let mut logarithms = Vec::with_capacity(self.joints[joint].bounds.len());
            for (row, value, (low, high)) in self.rows(joint, x) {
                let (above, below, half) = (high - value, value - low, 0.5 * (high - low));
                if !(above > 0.0 && below > 0.0) {
                    return None;
                }
                logarithms.push((above / half * (below / half)).ln());
                let slope = factor * self.weight * (1.0 / above - 1.0 / below);
                for i in 0..self.m {
                    gradient[i] += slope * row[i];
                }
            }
            Some(logarithms)
        };
        let joints = gradient.chunks_exact_mut(self.m).enumerate().take(self.joints.len()).collect();
        let logarithms: Option<Vec<Vec<f64>>> =
            in_parallel(joints, self.shared_by(threads), of_joint).into_iter().collect();
        let sum = logarithms?.into_iter().flatten().fold(0.0, |sum, logarithm| sum - logarithm);
        Some(sum * self.weight)
    }

    /// Number of threads to use, at most `threads`. With few joints it is one, because starting a thread takes as long as the
    /// work of several joints.
    fn shared_by(&self, threads: usize) -> usize {
        if self.joints.len() < MIN_JOINTS_FOR_THREADS { 1 } else { threads }
    }

    /// The Hessian of `factor` times the barrier B, plus `ridge` times the metric of the coefficients ([`MotionShape::metric`]).
    /// It has one m x m block per joint; m: number of coefficients of a joint.
    pub(crate) fn bends(&self, x: &[f64], factor: f64, ridge: f64, threads: usize) -> Vec<DMatrix<f64>> {
        let m = self.m;
        let block = |joint: usize| {
            let BarrierRows { rows, metric, .. } = &self.joints[joint];
            let bend = |(_, value, (low, high)): (&[f64], f64, (f64, f64))| {
                factor * self.weight * ((high - value).powi(-2) + (value - low).powi(-2))
            };
            let bends: Vec<f64> = self.rows(joint, x).map(bend).collect();
            let mut lower: Vec<f64> = (0..m * m).map(|at| metric[(at / m, at % m)] * ridge).collect();
            add_products(&mut lower, m, rows, |r| bends[r]);
            let mut hessian = DMatrix::from_row_slice(m, m, &lower);
            hessian.fill_upper_triangle_with_lower_triangle();
            hessian
        };
        in_parallel((0..self.joints.len()).collect(), self.shared_by(threads), block)
    }

    /// The greatest step of the coefficients x along `direction` after which every limited value (such as a velocity) still has 1
    /// % of its distance to its limit.
    pub fn step(&self, x: &[f64], direction: &[f64]) -> f64 {
        let mut step = f64::INFINITY;
        for joint in 0..self.joints.len() {
            let d = &direction[joint * self.m..][..self.m];
            for (row, value, (low, high)) in self.rows(joint, x) {
                let rate = dot(row, d);
                let room = if rate > 0.0 { high - value } else { value - low };
                if rate != 0.0 {
                    step = step.min(STEP_TO_BOUND_SHARE * room / rate.abs());
                }
            }
        }
        step
    }

    /// The least distance of a limited value to its limit, divided by half the width of the limits; with the joint and kind of
    /// limit. `None` if there are no joints.
    pub(crate) fn least_room(&self, x: &[f64]) -> Option<(f64, usize, LimitKind)> {
        let all = (0..self.joints.len()).flat_map(|joint| {
            let kinds = &self.joints[joint].kinds;
            self.rows(joint, x).zip(kinds).map(move |((_, value, (low, high)), kind)| {
                ((high - value).min(value - low) / (0.5 * (high - low)), joint, *kind)
            })
        });
        all.min_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// Least and greatest value of one limited quantity (such as velocity) of one joint with coefficients x, over all instants.
    pub fn reached(&self, joint: usize, x: &[f64], limit: LimitKind) -> (f64, f64) {
        let kinds = &self.joints[joint].kinds;
        let of = self.rows(joint, x).zip(kinds).filter(|(_, kind)| **kind == limit).map(|((_, value, _), _)| value);
        of.fold((f64::INFINITY, f64::NEG_INFINITY), |m, v| (m.0.min(v), m.1.max(v)))
    }
}

/// A block-diagonal Hessian of a barrier, with the Cholesky factor of each block.
pub struct Curvature {
    m: usize,
    blocks: Vec<Cholesky<f64, Dyn>>,
}

impl Curvature {
    /// Factors a Hessian with one block per joint. `None` if a block is not positive definite.
    pub(crate) fn of_joints(bends: Vec<DMatrix<f64>>) -> Option<Curvature> {
        let m = bends.first()?.nrows();
        bends.into_iter().map(Cholesky::new).collect::<Option<Vec<_>>>().map(|blocks| Curvature { m, blocks })
    }

    /// Takes a Hessian that is already factored and has one block for all joints.
    pub(crate) fn of_all(factor: Cholesky<f64, Dyn>) -> Curvature {
        Curvature { m: factor.l_dirty().nrows(), blocks: vec![factor] }
    }

    /// Solves H y = x for this Hessian H of the barrier; the solution y replaces x.
    pub fn solve(&self, x: &mut [f64]) {
        for (block, x) in self.blocks.iter().zip(x.chunks_exact_mut(self.m)) {
            x.copy_from_slice(block.solve(&DVector::from_column_slice(x)).as_slice());
        }
    }
}

/// Dot product of two vectors. It uses indices, because an iterator made by `zip` is not inlined across codegen units, and this
/// function runs for every row in every step.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let b = &b[..a.len()];
    (0..a.len()).map(|i| a[i] * b[i]).sum()
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::excitation::fourier_series::FourierSeries;
    use crate::excitation::search::tests::limits;

    pub(crate) fn barrier() -> Barrier {
        let limits = limits((-1.0, 2.0), [1.5, 4.0, 60.0]);
        let series = FourierSeries { period: 5.0, blend: 1.0, harmonics: 2 };
        Barrier::new(&MotionShape::Fourier(series), 40, &[&limits, &limits])
    }

    #[test]
    fn slope_and_curvature_are_those_of_differences() {
        let barrier = barrier();
        let x = [0.1, 0.1, -0.2, 0.05, 0.1, 0.3, -0.1, 0.0, 0.1, 0.02];
        let slope = |x: &[f64]| {
            let mut g = vec![0.0; 10];
            let value = barrier.value(x, 1.0, &mut g, 1).unwrap();
            (value, g)
        };
        let (_, g) = slope(&x);
        let mut along = vec![0.3; 10];
        let direction = along.clone();
        Curvature::of_joints(barrier.bends(&x, 1.0, 0.0, 1)).unwrap().solve(&mut along);
        let h = 1e-6;
        let moved = |k: Option<usize>, h: f64| -> Vec<f64> {
            let step = |(i, x): (usize, &f64)| match k {
                Some(k) => x + if i == k { h } else { 0.0 },
                None => x + h * along[i],
            };
            x.iter().enumerate().map(step).collect()
        };
        for k in 0..10 {
            let difference = (slope(&moved(Some(k), h)).0 - slope(&moved(Some(k), -h)).0) / (2.0 * h);
            assert!((g[k] - difference).abs() < 1e-6 * (1.0 + g[k].abs()), "{k}: {} {difference}", g[k]);
        }
        // The change of the gradient along the solution `along` must equal `direction`, since H `along` = `direction`.
        let (after, before) = (slope(&moved(None, h)).1, slope(&moved(None, -h)).1);
        for k in 0..10 {
            let difference = (after[k] - before[k]) / (2.0 * h);
            assert!((difference - direction[k]).abs() < 1e-5, "{k}: {difference}");
        }
    }

    #[test]
    fn threads_change_no_bit() {
        let one = barrier();
        let joints: Vec<BarrierRows> = one.joints.iter().cycle().take(MIN_JOINTS_FOR_THREADS + 1).cloned().collect();
        let many = Barrier { joints, ..one };
        let x: Vec<f64> = (0..many.m * many.joints.len()).map(|k| 0.1 * (1.7 * k as f64).sin()).collect();
        let of = |threads: usize| {
            let mut gradient = vec![0.0; x.len()];
            let value = many.value(&x, 0.3, &mut gradient, threads).unwrap();
            let mut solved = gradient.clone();
            Curvature::of_joints(many.bends(&x, 0.3, 0.1, threads)).unwrap().solve(&mut solved);
            (value, gradient, solved)
        };
        assert_eq!((of(1), many.shared_by(3)), (of(3), 3));
    }

    #[test]
    fn the_wall_is_where_the_limits_are() {
        let barrier = barrier();
        let (x, mut direction) = ([0.1; 10], [0.0; 10]);
        direction[1] = 1.0;
        let step = barrier.step(&[0.0; 10], &direction);
        let at = |s: f64| -> Vec<f64> { direction.iter().map(|d| s * d).collect() };
        assert!(barrier.value(&at(step), 1.0, &mut [0.0; 10], 1).is_some());
        assert!(barrier.value(&at(step / 0.98), 1.0, &mut [0.0; 10], 1).is_none());
        let (low, high) = barrier.reached(0, &x, LimitKind::Velocity);
        assert!(low < 0.0 && high > 0.0 && high < 1.5);
    }
}
