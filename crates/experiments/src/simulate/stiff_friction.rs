//! A step through friction that is stiff: implicit in friction alone, explicit in all else.
//!
//! A(q) dv/dt = (tau - h(q, v)) - G(v). A flange of 1e-4 kg m^2 behind a friction of 1 N m loses its velocity in a
//! microsecond where that turns its sign, and Runge-Kutta would need hundreds of steps a sample.
//! ARS(2, 2, 2) is of second order and takes four looks at the dynamics, as Runge-Kutta 4 does
//! (Ascher, Ruuth, Spiteri, Applied Numerical Mathematics 25, 1997, section 2.6).

use linear_model::friction::law::FrictionLaw;
use numerics::positive_definite::solve_positive;

/// 1 - 1 / sqrt(2): how far ahead, in steps, the stage in the middle looks.
const GAMMA: f64 = 1.0 - std::f64::consts::FRAC_1_SQRT_2;
/// Weight of the first stage in the explicit part, 1 - 1 / (2 gamma).
const DELTA: f64 = 1.0 - 0.5 / GAMMA;
/// Newton steps after which a velocity counts as not found.
const MOST_STEPS: usize = 100;
/// Halvings that bring a step of Newton to the kink of a friction.
const MOST_HALVINGS: usize = 60;
/// A velocity is found when the next step of Newton is shorter, rad/s (m/s).
const FOUND: f64 = 1e-10;

/// A step on its way: the accelerations of its stages, rad/s^2 (m/s^2).
pub(crate) struct StiffStep {
    /// A^-1 (tau - h) at the begin.
    at_begin: Vec<f64>,
    /// - A^-1 G in the middle.
    stopping: Vec<f64>,
}

/// What the coordinates of a step feel.
pub(crate) struct Felt<'a> {
    /// One law a coordinate.
    pub friction: &'a [FrictionLaw],
    /// Torques of the drives, N m (N).
    pub tau: &'a [f64],
    /// Length of the step, s.
    pub length: f64,
}

impl StiffStep {
    pub(crate) fn new(n: usize) -> StiffStep {
        StiffStep { at_begin: vec![0.0; n], stopping: vec![0.0; n] }
    }

    /// Goes on from the look number `stage` (0 to 3) at A (n x n, row by row) and tau - h of the state (q, v), which becomes
    /// that of the next look, or of the step's end. `false`: A is not positive definite, or no velocity was found.
    pub(crate) fn take(
        &mut self,
        stage: usize,
        felt: &Felt,
        begin: (&[f64], &[f64]),
        (q, v): (&mut [f64], &mut [f64]),
        (inertia, free): (&mut [f64], &mut [f64]),
    ) -> bool {
        let (n, h, (q0, v0)) = (q.len(), felt.length, begin);
        match stage {
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

/// What friction leaves of the velocities `v` over gamma h: the v' with A (v' - v) + gamma h G(v') = 0, sought from `near`.
///
/// It is where 1/2 (v' - v)' A (v' - v) + gamma h integral G is least, which is convex: Newton, each step as far as it descends.
fn slowed(inertia: &[f64], felt: &Felt, near: &[f64], v: &mut [f64]) -> bool {
    let n = v.len();
    let weight = GAMMA * felt.length;
    let without = v.to_vec();
    let times = |x: &[f64], k: usize| -> f64 { inertia[k * n..(k + 1) * n].iter().zip(x).map(|(a, x)| a * x).sum() };
    v.copy_from_slice(near);
    for _ in 0..MOST_STEPS {
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
        // The slope of what is least, along the step.
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
        if longest < FOUND {
            return true;
        }
    }
    false
}

/// The share of a step, in (0, 1], at which a slope that rises along it is a tenth of what it was, or still below zero.
fn as_far_as_it_descends(slope: impl Fn(f64) -> f64) -> f64 {
    let enough = 0.1 * slope(0.0).abs();
    let (mut low, mut high) = (0.0, 1.0);
    if slope(high) <= enough {
        return high;
    }
    for _ in 0..MOST_HALVINGS {
        let middle = 0.5 * (low + high);
        let at = slope(middle);
        if at.abs() <= enough {
            return middle;
        }
        if at < 0.0 { low = middle } else { high = middle }
    }
    high
}
