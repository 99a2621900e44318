//! Least squares inside the cone of physically consistent bodies: Newton's method with a logarithmic barrier.
//!
//! minimise  1/2 |A y - z|^2  +  w/2 sum_i (y_i / sd_i)^2
//!           + gamma [sum_j (tr P_j - log det P_j - 4) + sum_k (y_k - log y_k - 1)],   w = min(gamma / gamma_0, 1)
//!
//! A, z: rows and right-hand side of the weighted data. y: the unknowns, that is, the pseudo-inertias P_j of the bodies and the
//! rotor inertias y_k, both relative to reference values, and the friction parameters y_i. sd_i: standard deviation of the
//! prior of y_i. gamma: weight of the barrier; gamma_0: full weight of the prior. Each Newton step has a line search that stays
//! in the cone. The module `consistent` makes A, z and the reference values.
//!
//! The suboptimality bound limits chi^2(y)/2 - chi^2(x)/2, where y is the solution and x is any other point. The bound holds
//! because chi^2 is convex, and because the gradient of the minimised function is zero at y. Let t be the sum of traces
//! t(y) = sum tr P_j + sum y_k. The bound is
//!
//! chi^2(y)/2 - chi^2(x)/2 <= gamma (4 bodies + rotors + t(x) - t(y)) + w sum_i y_i (x_i - y_i) / sd_i^2
//!
//! [Boyd, Vandenberghe 2004, 3.1.3 and 11.2]. The bound is evaluated for the worst x that is up to `LARGEST_BOUNDED_RATIO`
//! times as large as y.
//!
//! chi^2 is computed from the residual and not as 1/2 y'A'A y - z'A y + c. If the torques are a thousand times larger than their
//! noise, the rounding of these three terms is a ten-thousandth of a nat, and a line search cannot find a descent.

use nalgebra::{Cholesky, DMatrix, DVector, Matrix4};

/// How Newton's method of the barrier problem ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BarrierStatus {
    /// The squared Newton decrement fell below its tolerance, or the objective could decrease only by rounding errors.
    Converged,
    /// The decrement stayed above its tolerance: the line search found no descent because of rounding, or the step limit was
    /// reached.
    Stalled,
}

/// Newton's method stops if half the squared Newton decrement is below this value, nats.
const DECREMENT_TOLERANCE_NATS: f64 = 1e-10;
/// Largest number of Newton steps.
const MAX_NEWTON_STEPS: usize = 40;
/// A point counts as near the solution if the squared Newton decrement divided by gamma (weight of the barrier) is below this
/// value. The objective divided by gamma is self-concordant, so Newton's method converges quadratically near the solution.
const NEAR_DECREMENT: f64 = 0.1;
/// Near the solution, each Newton step must reduce the squared decrement to at most this share. Otherwise the Hessian is too
/// inaccurate.
const LARGEST_DECREMENT_RATIO: f64 = 0.25;
/// Armijo condition of the line search: least decrease of the objective, divided by the product of the squared Newton decrement
/// and the step length.
const SUFFICIENT_DECREASE: f64 = 0.1;
/// Shortest step of the line search, relative to the Newton step.
const SHORTEST_STEP: f64 = 5e-11;
/// If the line search finds no descent, the iteration still counts as converged if the squared Newton decrement divided by the
/// objective is below this value.
const STALLED_DECREMENT_SHARE: f64 = 1e-9;
/// Ridges that are added to the Hessian of unit diagonal. The ridges are tried in this order until the Hessian is positive
/// definite.
const RELATIVE_RIDGES: [f64; 4] = [0.0, 1e-14, 1e-12, 1e-10];

/// The suboptimality bound compares the solution with other bodies up to this size: the traces of their pseudo-inertias are at
/// most this many times the traces in the solution. The bound also holds for friction parameters up to this many prior standard
/// deviations.
pub(crate) const LARGEST_BOUNDED_RATIO: f64 = 100.0;

/// The minimisation problem of the module in the scaled variables y.
pub(crate) struct Problem {
    /// A: the weighted rows of the data, one column per scaled variable y_i.
    pub rows: DMatrix<f64>,
    /// z: the weighted right-hand side of the data.
    pub right: DVector<f64>,
    /// A'A.
    pub hessian: DMatrix<f64>,
    /// For each friction parameter with a prior: its index in y, and the standard deviation sd of the prior.
    pub friction: Vec<(usize, f64)>,
    /// gamma_0: full weight of the prior, nats per unit of log-determinant divergence.
    pub gamma: f64,
    /// For each body: the index in y of the first of its ten parameters.
    pub bodies: Vec<usize>,
    /// For each rotor inertia: its index in y.
    pub rotors: Vec<usize>,
    /// The pseudo-inertia P of a body is linear in the ten parameters y_i of this body. `units` are the ten derivatives
    /// dP/dy_i.
    pub units: [Matrix4<f64>; 10],
}

impl Problem {
    /// Number of logarithms in the barrier: four per body (det of a 4 x 4 matrix) and one per rotor.
    pub(crate) fn barriers(&self) -> f64 {
        (4 * self.bodies.len() + self.rotors.len()) as f64
    }

    /// Suboptimality bound, nats: how much larger 1/2 chi^2 of the solution y can be than 1/2 chi^2 of any x up to
    /// `LARGEST_BOUNDED_RATIO` times as large. `share`: weight of the prior at y relative to its full weight. The head of this
    /// file has the equation.
    pub(crate) fn suboptimality_bound(&self, y: &DVector<f64>, share: f64) -> f64 {
        let traces = self.bodies.iter().map(|&first| self.body(y, first).trace());
        let size: f64 = traces.chain(self.rotors.iter().map(|&c| y[c])).sum();
        let friction = self.friction.iter().map(|&(c, sd)| (y[c] / sd).abs());
        let pull: f64 = friction.map(|f| f * (LARGEST_BOUNDED_RATIO + f)).sum();
        share * (self.gamma * (self.barriers() + (LARGEST_BOUNDED_RATIO - 1.0) * size) + pull)
    }

    /// Weight w of the prior of friction at the barrier weight gamma: proportional to gamma, at most 1.
    fn friction_weight(&self, gamma: f64) -> f64 {
        (gamma / self.gamma).min(1.0)
    }

    /// 1/2 chi^2 of the data, nats.
    pub(crate) fn quadratic(&self, y: &DVector<f64>) -> f64 {
        0.5 * (&self.rows * y - &self.right).norm_squared()
    }

    fn body(&self, y: &DVector<f64>, first: usize) -> Matrix4<f64> {
        (0..10).fold(Matrix4::zeros(), |sum, i| sum + self.units[i] * y[first + i])
    }

    /// The minimised function at y, nats. `None` if y is outside the cone of physically consistent bodies.
    fn value(&self, y: &DVector<f64>, gamma: f64) -> Option<f64> {
        let mut value = self.quadratic(y);
        value +=
            self.friction.iter().map(|&(c, sd)| 0.5 * self.friction_weight(gamma) * (y[c] / sd).powi(2)).sum::<f64>();
        for &first in &self.bodies {
            let p = self.body(y, first);
            let log_det: f64 = 2.0 * p.cholesky()?.l_dirty().diagonal().iter().map(|d| d.ln()).sum::<f64>();
            value += gamma * (p.trace() - log_det - 4.0);
        }
        for &c in &self.rotors {
            if y[c] <= 0.0 {
                return None;
            }
            value += gamma * (y[c] - y[c].ln() - 1.0);
        }
        value.is_finite().then_some(value)
    }

    fn derivatives(&self, y: &DVector<f64>, gamma: f64) -> Option<(DVector<f64>, DMatrix<f64>)> {
        // P: pseudo-inertia of a body, U_i = dP/dy_i. d(tr P - log det P)/dy_i = tr U_i - tr(P^-1 U_i); second derivative:
        // tr(P^-1 U_i P^-1 U_k).
        let mut g = self.rows.tr_mul(&(&self.rows * y - &self.right));
        let mut h = self.hessian.clone();
        for &(c, sd) in &self.friction {
            let weight = self.friction_weight(gamma) / (sd * sd);
            g[c] += weight * y[c];
            h[(c, c)] += weight;
        }
        for &first in &self.bodies {
            let inverse = self.body(y, first).cholesky()?.inverse();
            let scaled: [Matrix4<f64>; 10] = std::array::from_fn(|i| inverse * self.units[i]);
            for i in 0..10 {
                g[first + i] += gamma * (self.units[i].trace() - scaled[i].trace());
                for k in 0..10 {
                    h[(first + i, first + k)] += gamma * (scaled[i] * scaled[k]).trace();
                }
            }
        }
        for &c in &self.rotors {
            g[c] += gamma * (1.0 - 1.0 / y[c]);
            h[(c, c)] += gamma / (y[c] * y[c]);
        }
        Some((g, h))
    }

    /// A gamma at which y is near the solution: the first of `least` times 1, 10, 100, .. at which the squared Newton decrement
    /// divided by gamma is at most one.
    ///
    /// The objective divided by gamma is self-concordant, so each step of Newton's method decreases this objective by a fixed
    /// amount until the decrement is below one. From a smaller gamma, Newton's method would take about chi^2 / gamma steps.
    /// [Boyd, Vandenberghe 2004, 9.6.4]
    pub(crate) fn starting_gamma(&self, y: &DVector<f64>, least: f64) -> f64 {
        let decrement = |gamma: f64| {
            let (g, h) = self.derivatives(y, gamma)?;
            Some(solve_scaled(h, &g)?.dot(&g) / gamma)
        };
        let mut gammas = (0..MAX_NEWTON_STEPS as i32).map(|k| least * 10.0_f64.powi(k));
        gammas.find(|&gamma| decrement(gamma).is_none_or(|d| d <= 1.0)).unwrap_or(least)
    }

    /// Runs Newton's method at one gamma and changes y in place. Returns the number of steps and the reason for the end.
    ///
    /// The direction comes from the Hessian. If this direction gives no descent, or if convergence is too slow, A'A is too
    /// ill-conditioned compared with the barrier, and the direction comes from the rows (QR).
    pub(crate) fn newton(&self, y: &mut DVector<f64>, gamma: f64) -> (usize, BarrierStatus) {
        let Some(mut value) = self.value(y, gamma) else { return (0, BarrierStatus::Stalled) };
        // `is_right`: whether the Hessian is accurate enough, that is, whether convergence near the solution is quadratic.
        // `last`: previous squared decrement.
        let (mut is_right, mut last) = (true, f64::INFINITY);
        for step in 0..MAX_NEWTON_STEPS {
            let Some((g, h)) = self.derivatives(y, gamma) else { return (step, BarrierStatus::Stalled) };
            // A decrease of the objective below its rounding error cannot be detected.
            let tolerance = (2.0 * DECREMENT_TOLERANCE_NATS).max(self.rounding(y, gamma));
            let by_hessian = is_right.then(|| solve_scaled(h, &g)).flatten();
            let by_hessian = by_hessian.map(|direction| (g.dot(&direction), direction));
            if by_hessian.as_ref().is_some_and(|(decrement, _)| *decrement <= tolerance) {
                return (step, BarrierStatus::Converged);
            }
            if let Some((decrement, _)) = &by_hessian {
                is_right = last > NEAR_DECREMENT * gamma || *decrement < LARGEST_DECREMENT_RATIO * last;
                last = *decrement;
            }
            let by_hessian = by_hessian.filter(|_| is_right);
            if let Some(found) = by_hessian.and_then(|(decrement, d)| self.down(y, value, gamma, decrement, &d)) {
                (*y, value) = found;
                continue;
            }
            let Some((decrement, direction)) = self.direction_by_rows(y, gamma) else {
                return (step, BarrierStatus::Stalled);
            };
            if decrement <= tolerance {
                return (step, BarrierStatus::Converged);
            }
            match self.down(y, value, gamma, decrement, &direction) {
                Some(found) => (*y, value) = found,
                None if decrement < STALLED_DECREMENT_SHARE * value.abs().max(1.0) => {
                    return (step, BarrierStatus::Converged);
                }
                None => return (step, BarrierStatus::Stalled),
            }
        }
        (MAX_NEWTON_STEPS, BarrierStatus::Stalled)
    }

    /// Squared Newton decrement and direction, first from the Hessian, then from the rows (QR).
    #[cfg(test)]
    pub(crate) fn directions(&self, y: &DVector<f64>, gamma: f64) -> ((f64, DVector<f64>), (f64, DVector<f64>)) {
        let (g, h) = self.derivatives(y, gamma).expect("y is in the cone");
        let direction = solve_scaled(h, &g).expect("the Hessian is definite");
        ((g.dot(&direction), direction), self.direction_by_rows(y, gamma).expect("y is in the cone"))
    }

    /// Line search: halves the step until the objective decreases enough. Returns the point after the step and the objective at
    /// this point. `None` if no step is sufficient.
    fn down(
        &self,
        y: &DVector<f64>,
        value: f64,
        gamma: f64,
        decrement: f64,
        direction: &DVector<f64>,
    ) -> Option<(DVector<f64>, f64)> {
        let mut lengths =
            std::iter::successors(Some(1.0), |length| Some(0.5 * length)).take_while(|length| *length > SHORTEST_STEP);
        lengths.find_map(|length| {
            let candidate = y - length * direction;
            let found = self.value(&candidate, gamma)?;
            (found <= value - SUFFICIENT_DECREASE * length * decrement).then_some((candidate, found))
        })
    }

    /// The rounding error of the objective, nats: the rounding of the residual, whose terms cancel, and of the logarithms.
    fn rounding(&self, y: &DVector<f64>, gamma: f64) -> f64 {
        let terms = self.rows.abs() * y.abs() + self.right.abs();
        let residual = (&self.rows * y - &self.right).abs();
        let traces: f64 = self.bodies.iter().map(|&first| self.body(y, first).trace()).sum();
        f64::EPSILON * (2.0 * residual.dot(&terms) + gamma * (traces + 10.0 * self.barriers()))
    }

    /// The squared Newton decrement and the Newton direction d by QR. The Hessian is M'M and the gradient M'r, so min |M d - r|
    /// gives d without squaring the condition number of A.
    ///
    /// ```text
    /// M = A,  r = A y - z;   of a body P = L L': vec(L^-1 U_i L^-T), vec(L'L - 1);   of a rotor: 1 / y, y - 1
    /// ```
    /// U_i = dP/dy_i. The rows of bodies and rotors are multiplied by sqrt(gamma). Each symmetric matrix is written as ten
    /// entries; entries off the diagonal are multiplied by sqrt(2).
    fn direction_by_rows(&self, y: &DVector<f64>, gamma: f64) -> Option<(f64, DVector<f64>)> {
        let (data, n) = self.rows.shape();
        let count = data + 10 * self.bodies.len() + self.rotors.len() + self.friction.len();
        let (mut m, mut r) = (DMatrix::zeros(count.max(n), n), DVector::zeros(count.max(n)));
        // M and r with M'M = H and M'r = g. Order of the rows: data, bodies, rotors, friction.
        m.rows_mut(0, data).copy_from(&self.rows);
        r.rows_mut(0, data).copy_from(&(&self.rows * y - &self.right));
        let (mut at, root) = (data, gamma.sqrt());
        for &first in &self.bodies {
            let l = self.body(y, first).cholesky()?.unpack();
            let inverse = l.try_inverse()?;
            for (i, unit) in self.units.iter().enumerate() {
                m.view_mut((at, first + i), (10, 1))
                    .copy_from(&(root * entries(&(inverse * unit * inverse.transpose()))));
            }
            r.rows_mut(at, 10).copy_from(&(root * entries(&(l.transpose() * l - Matrix4::identity()))));
            at += 10;
        }
        for &c in &self.rotors {
            (m[(at, c)], r[at]) = (root / y[c], root * (y[c] - 1.0));
            at += 1;
        }
        for &(c, sd) in &self.friction {
            let weight = self.friction_weight(gamma).sqrt() / sd;
            (m[(at, c)], r[at]) = (weight, weight * y[c]);
            at += 1;
        }
        // The columns are scaled to unit norm. Then d = R^-1 Q'r, and the squared decrement is |Q'r|^2.
        let scale = DVector::from_iterator(n, m.column_iter().map(|c| 1.0 / c.norm().max(f64::MIN_POSITIVE)));
        for (mut column, scale) in m.column_iter_mut().zip(&scale) {
            column *= *scale;
        }
        let qr = m.qr();
        qr.q_tr_mul(&mut r);
        let top = r.rows(0, n).into_owned();
        let direction = qr.unpack_r().solve_upper_triangular(&top)?;
        Some((top.norm_squared(), direction.component_mul(&scale)))
    }
}

/// The ten entries of a symmetric matrix. Entries off the diagonal are multiplied by sqrt(2), so that the norm is the Frobenius
/// norm of the matrix.
fn entries(m: &Matrix4<f64>) -> DVector<f64> {
    let weight = |i: usize, k: usize| if i == k { 1.0 } else { std::f64::consts::SQRT_2 };
    DVector::from_iterator(10, (0..4).flat_map(|i| (i..4).map(move |k| (i, k))).map(|(i, k)| weight(i, k) * m[(i, k)]))
}

/// Largest factor between two successive values of gamma on the central path. gamma: weight of the barrier.
const LARGEST_GAMMA_FACTOR: f64 = 5.0;
/// gamma decreases along the central path. If the step to the next gamma fails, the ratio of the two values of gamma is
/// reduced. Below this ratio, following the path has failed.
const SMALLEST_GAMMA_FACTOR: f64 = 1.05;

/// If a decrease of gamma needs fewer Newton steps than this number, the factor between successive values of gamma grows again.
const MANY_NEWTON_STEPS: usize = 20;

/// The central path: the solution y of the barrier problem as a function of the barrier weight gamma.
pub(crate) struct CentralPath<'a> {
    problem: &'a Problem,
    /// The solution at the present gamma, in scaled variables.
    pub y: DVector<f64>,
    gamma: f64,
    factor: f64,
    /// Number of Newton steps so far.
    pub steps: usize,
}

impl CentralPath<'_> {
    /// Starts the path at the barrier weight `gamma` with Newton steps from y, which must be near the solution there.
    pub(crate) fn new(problem: &Problem, mut y: DVector<f64>, gamma: f64) -> CentralPath<'_> {
        let (steps, _) = problem.newton(&mut y, gamma);
        CentralPath { problem, y, gamma, factor: LARGEST_GAMMA_FACTOR, steps }
    }

    /// Follows the path to the solution at a lower gamma. Returns false if no step succeeds; `y` is then the last solution.
    ///
    /// If Newton's method stalls, the factor between two values of gamma was too large: bodies far from their reference grow
    /// along the path, and Newton's method makes short steps along the boundary of the cone. The step is then repeated with the
    /// square root of the factor.
    pub(crate) fn follow(&mut self, gamma: f64) -> bool {
        while self.gamma > gamma {
            let next = (self.gamma / self.factor).max(gamma);
            let mut y = self.y.clone();
            let (steps, outcome) = self.problem.newton(&mut y, next);
            self.steps += steps;
            match outcome {
                BarrierStatus::Converged => (self.y, self.gamma) = (y, next),
                BarrierStatus::Stalled if self.factor > SMALLEST_GAMMA_FACTOR => self.factor = self.factor.sqrt(),
                BarrierStatus::Stalled => return false,
            }
            if outcome == BarrierStatus::Converged && steps < MANY_NEWTON_STEPS {
                self.factor = (self.factor * self.factor).min(LARGEST_GAMMA_FACTOR);
            }
        }
        true
    }
}

/// Solves H x = g, with H scaled to a unit diagonal and, if needed, with a ridge at the level of rounding. `None` if H is not
/// positive definite with any of the ridges.
fn solve_scaled(h: DMatrix<f64>, g: &DVector<f64>) -> Option<DVector<f64>> {
    let d = h.diagonal().map(|x| if x > 0.0 { 1.0 / x.sqrt() } else { 1.0 });
    let n = h.nrows();
    let scaled = DMatrix::from_fn(n, n, |i, j| h[(i, j)] * d[i] * d[j]);
    let rhs = g.component_mul(&d);
    RELATIVE_RIDGES.into_iter().find_map(|ridge| {
        let m = &scaled + DMatrix::from_diagonal_element(n, n, ridge);
        Cholesky::new(m).map(|c| c.solve(&rhs).component_mul(&d))
    })
}
