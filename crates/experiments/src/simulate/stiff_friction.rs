//! One integration step for stiff friction: implicit in friction, explicit in all other torques.
//!
//! A(q) dv/dt = (tau - h(q, v)) - G(v); A: inertia matrix, h: bias torque, G: friction. A flange of 1e-4 kg m^2 with a friction
//! of 1 N m loses a small velocity within a microsecond, so Runge-Kutta would need hundreds of steps per sample. The method
//! ARS(2, 2, 2) is of second order and evaluates the dynamics four times per step, like Runge-Kutta 4 (Ascher, Ruuth, Spiteri,
//! Applied Numerical Mathematics 25, 1997, section 2.6).

use linear_model::friction::law::FrictionLaw;
use numerics::positive_definite::solve_positive;

/// gamma of ARS(2, 2, 2): time of the middle stage as a fraction of the step, 1 - 1 / sqrt(2).
const GAMMA: f64 = 1.0 - std::f64::consts::FRAC_1_SQRT_2;
/// delta of ARS(2, 2, 2): weight of the first stage in the explicit part, 1 - 1 / (2 gamma).
const DELTA: f64 = 1.0 - 0.5 / GAMMA;
/// Greatest number of Newton steps for the velocities after friction. If more would be needed, the integration fails.
const MAX_NEWTON_STEPS: usize = 100;
/// Greatest number of bisections that shorten one Newton step; they find the kink of a friction law.
const MAX_BISECTIONS: usize = 60;
/// The velocity has converged if the next Newton step is shorter than this value, rad/s (m/s).
const CONVERGED_NEWTON_STEP: f64 = 1e-10;
/// A Newton step is accepted if the slope of the minimised function at its end is at most this share of the slope at its start.
const ACCEPTED_SLOPE_RATIO: f64 = 0.1;

/// Intermediate results of one integration step: accelerations of its stages, rad/s^2 (m/s^2).
pub(crate) struct StiffStep {
    /// Acceleration without friction at the start of the step, A^-1 (tau - h). A: inertia matrix; tau: drive torque; h: bias
    /// torque.
    at_begin: Vec<f64>,
    /// Acceleration by friction alone at the middle stage, - A^-1 G. A: inertia matrix; G: friction torque.
    stopping: Vec<f64>,
}

/// Friction laws, drive torques and length of one integration step.
pub(crate) struct FrictionLoad<'a> {
    /// The friction law of each coordinate.
    pub friction: &'a [FrictionLaw],
    /// Torques of the drives, N m (N).
    pub tau: &'a [f64],
    /// Length of the integration step, s.
    pub length: f64,
}

impl StiffStep {
    pub(crate) fn new(n: usize) -> StiffStep {
        StiffStep { at_begin: vec![0.0; n], stopping: vec![0.0; n] }
    }

    /// Advances by evaluation number `stage` (0 to 3) of a step. `inertia` (A, n x n, row by row) and `free` (drive torque minus
    /// bias torque, tau - h) belong to the state (q, v). This state is replaced by the state of the next evaluation, or of the
    /// end of the step. Returns false if A is not positive definite or no velocity was found.
    pub(crate) fn take(
        &mut self,
        stage: usize,
        felt: &FrictionLoad,
        begin: (&[f64], &[f64]),
        (q, v): (&mut [f64], &mut [f64]),
        (inertia, free): (&mut [f64], &mut [f64]),
    ) -> bool {
        let (n, h, (q0, v0)) = (q.len(), felt.length, begin);
        match stage {
            // Explicit part up to the middle stage: q0 + gamma h v0 and v0 + gamma h a. h: length of the step; a = A^-1 `free`:
            // acceleration without friction.
            0 => {
                if !solve_positive(inertia, free) {
                    return false;
                }
                self.at_begin.copy_from_slice(free);
                for k in 0..n {
                    q[k] = q0[k] + GAMMA * h * v0[k];
                    v[k] = v0[k] + GAMMA * h * free[k];
                }
                true
            }
            1 => {
                // Implicit part at the middle stage. The acceleration by friction is - A^-1 G; A: inertia matrix, G: friction
                // torque.
                let without = v.to_vec();
                let found = slowed(inertia, felt, v0, v);
                for k in 0..n {
                    self.stopping[k] = (v[k] - without[k]) / (GAMMA * h);
                }
                found
            }
            2 => {
                if !solve_positive(inertia, free) {
                    return false;
                }
                // Explicit part up to the end of the step, with weights delta and 1 - delta for the two stages.
                for k in 0..n {
                    q[k] = q0[k] + h * (DELTA * v0[k] + (1.0 - DELTA) * v[k]);
                    let explicit = DELTA * self.at_begin[k] + (1.0 - DELTA) * free[k];
                    v[k] = v0[k] + h * (explicit + (1.0 - GAMMA) * self.stopping[k]);
                }
                true
            }
            _ => slowed(inertia, felt, v0, v),
        }
    }
}

/// Applies friction during the time gamma h to the velocities `v`, and replaces `v` by the new velocities u, with
///
/// A (u - v) + gamma h G(u) = 0.
///
/// A: inertia matrix; G: friction torque; h: length of the integration step. Newton's method finds u, starting from `near`. The
/// solution u minimises the convex function
///
/// f(u) = 1/2 (u - v)^T A (u - v) + gamma h sum_k (integral of G_k from 0 to u_k),   k: coordinate.
///
/// A Newton step that goes beyond the minimum of f along its direction is shortened to a point near this minimum. Returns false
/// if the matrix of a Newton step is not positive definite, or if Newton's method does not converge.
fn slowed(inertia: &[f64], felt: &FrictionLoad, near: &[f64], v: &mut [f64]) -> bool {
    let n = v.len();
    let weight = GAMMA * felt.length;
    let without = v.to_vec();
    let times = |x: &[f64], k: usize| -> f64 { inertia[k * n..(k + 1) * n].iter().zip(x).map(|(a, x)| a * x).sum() };
    v.copy_from_slice(near);
    for _ in 0..MAX_NEWTON_STEPS {
        let ahead: Vec<f64> = (0..n).map(|k| v[k] - without[k]).collect();
        let linear: Vec<f64> = (0..n).map(|k| times(&ahead, k)).collect();
        let mut matrix = inertia.to_vec();
        let mut step = vec![0.0; n];
        for k in 0..n {
            let (law, tau) = (&felt.friction[k], felt.tau[k]);
            matrix[k * n + k] += weight * law.slope(v[k], tau).max(0.0);
            step[k] = -(linear[k] + weight * law.torque(v[k], tau));
        }
        if !solve_positive(&mut matrix, &mut step) {
            return false;
        }
        let turned: Vec<f64> = (0..n).map(|k| times(&step, k)).collect();
        // The slope of f along the Newton step, at the share `share` of this step.
        let slope = |share: f64| -> f64 {
            let at = |k: usize| {
                let friction = felt.friction[k].torque(v[k] + share * step[k], felt.tau[k]);
                step[k] * (linear[k] + share * turned[k] + weight * friction)
            };
            (0..n).map(at).sum()
        };
        let share = as_far_as_it_descends(slope);
        let longest = step.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        v.iter_mut().zip(&step).for_each(|(v, step)| *v += share * step);
        if longest < CONVERGED_NEWTON_STEP {
            return true;
        }
    }
    false
}

/// The share of a Newton step, in (0, 1], at which the slope along the step is at most a tenth of the initial slope. `slope`
/// increases along the step, and is negative at its start.
fn as_far_as_it_descends(slope: impl Fn(f64) -> f64) -> f64 {
    let enough = ACCEPTED_SLOPE_RATIO * slope(0.0).abs();
    let (mut low, mut high) = (0.0, 1.0);
    if slope(high) <= enough {
        return high;
    }
    for _ in 0..MAX_BISECTIONS {
        let middle = 0.5 * (low + high);
        let at = slope(middle);
        if at.abs() <= enough {
            return middle;
        }
        if at < 0.0 { low = middle } else { high = middle }
    }
    high
}
