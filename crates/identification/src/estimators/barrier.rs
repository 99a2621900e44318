//! Least squares inside the cone of bodies: Newton's method on a barrier.
//!
//! minimise  1/2 |A y - z|^2  +  w/2 sum_i (y_i / sd_i)^2
//!           + gamma [sum_j (tr P_j - log det P_j - 4) + sum_k (y_k - log y_k - 1)],   w = min(gamma / gamma_0, 1)
//!
//! y: bodies P_j and rotors y_k relative to their references, and friction y_i. Each step is one of Newton's with a
//! line search that stays in the cone.
//!
//! By how much is 1/2 chi^2 of a solution y above that of any other x? chi^2 is convex and the gradient of the whole is
//! zero at y. With the traces t(y) = sum tr P_j + sum y_k this gives
//!
//! chi^2(y)/2 - chi^2(x)/2 <= gamma (4 bodies + rotors + t(x) - t(y)) + w sum_i y_i (x_i - y_i) / sd_i^2
//!
//! [Boyd, Vandenberghe 2004, 3.1.3 and 11.2]. `slack` is this bound for every x up to `LARGEST_BOUNDED_RATIO` times
//! as large. `consistent` says what stands in A and where the references come from.
//!
//! chi^2 is computed from the residual and not as 1/2 y'A'A y - z'A y + c. With torques a thousand times their noise,
//! rounding of the three terms leaves a ten-thousandth of a nat, and no line search finds its way down.

use nalgebra::{Cholesky, DMatrix, DVector, Matrix4};

/// How the iteration ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The gradient vanished at the smallest barrier.
    Converged,
    /// The gradient did not vanish: the line search found no way down, because of rounding, or the steps ran out.
    Stalled,
}

/// Newton's method stops when half the squared decrement is below this, nats.
const DECREMENT_TOLERANCE_NATS: f64 = 1e-10;
/// Most steps of Newton's method.
const MAX_NEWTON_STEPS: usize = 40;
/// So near the solution, in gammas, a step of Newton's leaves a small share of the squared decrement, since the objective over
/// gamma is self-concordant; a Hessian whose step leaves more is wrong.
const NEAR_DECREMENT: f64 = 0.1;
const LARGEST_SHARE_LEFT: f64 = 0.25;

/// A bound on chi^2 covers traces up to this many times those of the solution, and friction up to this many of its
/// deviations.
pub(crate) const LARGEST_BOUNDED_RATIO: f64 = 100.0;

/// The problem in scaled variables.
pub(crate) struct Problem {
    /// A and z of the data in scaled variables, and A'A.
    pub rows: DMatrix<f64>,
    pub right: DVector<f64>,
    pub hessian: DMatrix<f64>,
    /// Scaled column and standard deviation of the friction that has one.
    pub friction: Vec<(usize, f64)>,
    /// Nats per unit of divergence at the full weight of the prior.
    pub gamma: f64,
    /// First scaled column of each body, then the rotors.
    pub bodies: Vec<usize>,
    pub rotors: Vec<usize>,
    pub units: [Matrix4<f64>; 10],
}

impl Problem {
    /// Number of logarithms in the barrier, which is the order of the cone.
    pub(crate) fn barriers(&self) -> f64 {
        (4 * self.bodies.len() + self.rotors.len()) as f64
    }

    /// Nats by which 1/2 chi^2 of the solution for a share of the prior can at most exceed that of any x up to
    /// `LARGEST_BOUNDED_RATIO` times as large: the bound in the head.
    pub(crate) fn slack(&self, y: &DVector<f64>, share: f64) -> f64 {
        let traces = self.bodies.iter().map(|&first| self.body(y, first).trace());
        let size: f64 = traces.chain(self.rotors.iter().map(|&c| y[c])).sum();
        let friction = self.friction.iter().map(|&(c, sd)| (y[c] / sd).abs());
        let pull: f64 = friction.map(|f| f * (LARGEST_BOUNDED_RATIO + f)).sum();
        share * (self.gamma * (self.barriers() + (LARGEST_BOUNDED_RATIO - 1.0) * size) + pull)
    }

    /// The weight of the friction's prior at a gamma; it falls with gamma and is at most one.
    fn friction_weight(&self, gamma: f64) -> f64 {
        (gamma / self.gamma).min(1.0)
    }

    /// 1/2 chi^2 of the data.
    pub(crate) fn quadratic(&self, y: &DVector<f64>) -> f64 {
        0.5 * (&self.rows * y - &self.right).norm_squared()
    }

    fn body(&self, y: &DVector<f64>, first: usize) -> Matrix4<f64> {
        (0..10).fold(Matrix4::zeros(), |sum, i| sum + self.units[i] * y[first + i])
    }

    /// The objective; `None` outside the cone.
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

    /// A gamma at which y is near the solution: `least`, or ten, a hundred, .. times that.
    ///
    /// The objective over gamma is self-concordant, so Newton's method takes steps of fixed gain until its decrement is
    /// below one. From a smaller gamma on it would take as many steps as chi^2 has gammas.
    /// [Boyd, Vandenberghe 2004, 9.6.4]
    pub(crate) fn starting_gamma(&self, y: &DVector<f64>, least: f64) -> f64 {
        let decrement = |gamma: f64| {
            let (g, h) = self.derivatives(y, gamma)?;
            Some(solve_scaled(h, &g)?.dot(&g) / gamma)
        };
        let mut gammas = (0..MAX_NEWTON_STEPS as i32).map(|k| least * 10.0_f64.powi(k));
        gammas.find(|&gamma| decrement(gamma).is_none_or(|d| d <= 1.0)).unwrap_or(least)
    }

    /// Newton steps at one gamma, in place.
    ///
    /// A direction is that of the Hessian. Where no step along it leads down, or arrives too slowly, A'A is beyond doubles beside the
    /// barrier, and the direction is that of the rows.
    pub(crate) fn newton(&self, y: &mut DVector<f64>, gamma: f64) -> (usize, Outcome) {
        let Some(mut value) = self.value(y, gamma) else { return (0, Outcome::Stalled) };
        let (mut is_right, mut last) = (true, f64::INFINITY);
        for step in 0..MAX_NEWTON_STEPS {
            let Some((g, h)) = self.derivatives(y, gamma) else { return (step, Outcome::Stalled) };
            // A decrease below the rounding of the objective is not seen.
            let tolerance = (2.0 * DECREMENT_TOLERANCE_NATS).max(self.rounding(y, gamma));
            let by_hessian = is_right.then(|| solve_scaled(h, &g)).flatten();
            let by_hessian = by_hessian.map(|direction| (g.dot(&direction), direction));
            if by_hessian.as_ref().is_some_and(|(decrement, _)| *decrement <= tolerance) {
                return (step, Outcome::Converged);
            }
            if let Some((decrement, _)) = &by_hessian {
                is_right = last > NEAR_DECREMENT * gamma || *decrement < LARGEST_SHARE_LEFT * last;
                last = *decrement;
            }
            let by_hessian = by_hessian.filter(|_| is_right);
            if let Some(found) = by_hessian.and_then(|(decrement, d)| self.down(y, value, gamma, decrement, &d)) {
                (*y, value) = found;
                continue;
            }
            let Some((decrement, direction)) = self.direction_by_rows(y, gamma) else {
                return (step, Outcome::Stalled);
            };
            if decrement <= tolerance {
                return (step, Outcome::Converged);
            }
            match self.down(y, value, gamma, decrement, &direction) {
                Some(found) => (*y, value) = found,
                None if decrement < 1e-9 * value.abs().max(1.0) => return (step, Outcome::Converged),
                None => return (step, Outcome::Stalled),
            }
        }
        (MAX_NEWTON_STEPS, Outcome::Stalled)
    }

    /// Decrement and direction by the Hessian, and by the rows.
    #[cfg(test)]
    pub(crate) fn directions(&self, y: &DVector<f64>, gamma: f64) -> ((f64, DVector<f64>), (f64, DVector<f64>)) {
        let (g, h) = self.derivatives(y, gamma).expect("y is in the cone");
        let direction = solve_scaled(h, &g).expect("the Hessian is definite");
        ((g.dot(&direction), direction), self.direction_by_rows(y, gamma).expect("y is in the cone"))
    }

    /// Where a step, halved until it is one, leads down, and the objective there.
    fn down(
        &self,
        y: &DVector<f64>,
        value: f64,
        gamma: f64,
        decrement: f64,
        direction: &DVector<f64>,
    ) -> Option<(DVector<f64>, f64)> {
        let mut lengths =
            std::iter::successors(Some(1.0), |length| Some(0.5 * length)).take_while(|length| *length > 5e-11);
        lengths.find_map(|length| {
            let candidate = y - length * direction;
            let found = self.value(&candidate, gamma)?;
            (found <= value - 0.1 * length * decrement).then_some((candidate, found))
        })
    }

    /// By how much rounding may move the objective: that of the residual, whose terms cancel, and of the logarithms.
    fn rounding(&self, y: &DVector<f64>, gamma: f64) -> f64 {
        let terms = self.rows.abs() * y.abs() + self.right.abs();
        let residual = (&self.rows * y - &self.right).abs();
        let traces: f64 = self.bodies.iter().map(|&first| self.body(y, first).trace()).sum();
        f64::EPSILON * (2.0 * residual.dot(&terms) + gamma * (traces + 10.0 * self.barriers()))
    }

    /// The square of Newton's decrement, and Newton's direction d, by least squares: the Hessian is M'M and the gradient
    /// M'r, so that min |M d - r| has it without squares of what A holds.
    ///
    /// ```text
    /// M = A,  r = A y - z;   of a body P = L L': vec(L^-1 U_i L^-T), vec(L'L - 1);   of a rotor: 1 / y, y - 1
    /// ```
    /// those of bodies and rotors times sqrt(gamma), and a symmetric matrix as its ten entries, off the diagonal times sqrt(2).
    fn direction_by_rows(&self, y: &DVector<f64>, gamma: f64) -> Option<(f64, DVector<f64>)> {
        let (data, n) = self.rows.shape();
        let count = data + 10 * self.bodies.len() + self.rotors.len() + self.friction.len();
        let (mut m, mut r) = (DMatrix::zeros(count.max(n), n), DVector::zeros(count.max(n)));
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

/// The ten entries of a symmetric matrix; their squares sum up to those of the matrix.
fn entries(m: &Matrix4<f64>) -> DVector<f64> {
    let weight = |i: usize, k: usize| if i == k { 1.0 } else { std::f64::consts::SQRT_2 };
    DVector::from_iterator(10, (0..4).flat_map(|i| (i..4).map(move |k| (i, k))).map(|(i, k)| weight(i, k) * m[(i, k)]))
}

/// Largest factor between two gammas of the path.
const LARGEST_GAMMA_FACTOR: f64 = 5.0;
/// Factor between two gammas at which the path is given up.
const SMALLEST_GAMMA_FACTOR: f64 = 1.05;

/// A round with fewer Newton steps than this did not come from too far, so the next may come from further.
const NEWTON_STEPS_OF_A_FAR_START: usize = 20;

/// The solution as a function of gamma.
pub(crate) struct CentralPath<'a> {
    problem: &'a Problem,
    /// The solution at `gamma`.
    pub y: DVector<f64>,
    gamma: f64,
    factor: f64,
    /// Newton's steps so far.
    pub steps: usize,
}

impl CentralPath<'_> {
    /// Starts near the solution at `gamma`.
    pub(crate) fn new(problem: &Problem, mut y: DVector<f64>, gamma: f64) -> CentralPath<'_> {
        let (steps, _) = problem.newton(&mut y, gamma);
        CentralPath { problem, y, gamma, factor: LARGEST_GAMMA_FACTOR, steps }
    }

    /// Goes down to the solution at a lower gamma; false where no step leads on, and `y` is the last solution.
    ///
    /// A round that takes too many steps came from too far: bodies far from their reference grow along the path, and
    /// Newton's method creeps along the boundary of the cone. The round is done again from half as far, in logarithms.
    pub(crate) fn follow(&mut self, gamma: f64) -> bool {
        while self.gamma > gamma {
            let next = (self.gamma / self.factor).max(gamma);
            let mut y = self.y.clone();
            let (steps, outcome) = self.problem.newton(&mut y, next);
            self.steps += steps;
            match outcome {
                Outcome::Converged => (self.y, self.gamma) = (y, next),
                Outcome::Stalled if self.factor > SMALLEST_GAMMA_FACTOR => self.factor = self.factor.sqrt(),
                Outcome::Stalled => return false,
            }
            if outcome == Outcome::Converged && steps < NEWTON_STEPS_OF_A_FAR_START {
                self.factor = (self.factor * self.factor).min(LARGEST_GAMMA_FACTOR);
            }
        }
        true
    }
}

/// H^-1 g with H scaled to a unit diagonal, and with a ridge at the level of rounding where it is needed.
fn solve_scaled(h: DMatrix<f64>, g: &DVector<f64>) -> Option<DVector<f64>> {
    let d = h.diagonal().map(|x| if x > 0.0 { 1.0 / x.sqrt() } else { 1.0 });
    let n = h.nrows();
    let scaled = DMatrix::from_fn(n, n, |i, j| h[(i, j)] * d[i] * d[j]);
    let rhs = g.component_mul(&d);
    [0.0, 1e-14, 1e-12, 1e-10].into_iter().find_map(|ridge| {
        let m = &scaled + DMatrix::from_diagonal_element(n, n, ridge);
        Cholesky::new(m).map(|c| c.solve(&rhs).component_mul(&d))
    })
}
