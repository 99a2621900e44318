//! Friction columns of one joint for a periodic motion, in the time domain.
//!
//! The cell of a sample at time t is [t - h/2, t + h/2], h: sample time. s+ is the share of the cell in which the velocity is
//! positive. At time t + s in the cell, the velocity is taken as v + a s (v, a: velocity and acceleration at t). The sign of
//! this velocity is smoothed: it changes over the velocity range w. So
//!
//! s+ = 1/2 + w / (2 a h) [ln cosh((v + a h/2)/w) - ln cosh((v - a h/2)/w)],   s- = 1 - s+.
//!
//! The viscous columns are max(v, 0) and min(v, 0), smoothed in the same manner: v+ = w/2 ln(1 + exp(2 v/w)) and v- = v - v+.
//! If the controller makes the joint chatter at rest, w is large: the sign of the velocity alternates at rest, and the mean of
//! this sign over the periods changes smoothly with the velocity.
//!
//! Without the mean over the cell, the sign at the samples would shift every reversal by up to half a sample. Coulomb friction
//! would then have the phase of the acceleration. The mean over the cell has no such shift, and the recorded torque is also a
//! mean over the cell.
//!
//! | columns | term |
//! |---|---|
//! | v+, s+, v-, s- | asymmetric viscous and Coulomb friction, equation (5) of [Vandanjon, Gautier, Desbats 1995] |
//! | s+ abs(tau), s- abs(tau) | Coulomb friction that grows with the load |
//! | s+ exp(-(v/v_s)^2), s- exp(-(v/v_s)^2) | Stribeck friction |

use crate::parameter::FrictionParameter;

/// The choice of the friction columns of a joint, with the velocities that occur in these columns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrictionShape {
    /// Velocity w over which the sign changes, rad/s.
    pub rest_velocity: f64,
    /// Whether the columns include Coulomb friction that grows with the load.
    pub load: bool,
    /// Stribeck velocity v_s, rad/s. `None`: no Stribeck columns.
    pub stribeck: Option<f64>,
}

impl FrictionShape {
    /// Only the columns v+, s+, v-, s- (equation (5) of [Vandanjon, Gautier, Desbats 1995]).
    pub const ASYMMETRIC: FrictionShape = FrictionShape { rest_velocity: 0.005, load: false, stribeck: None };

    /// Number of columns.
    #[inline]
    pub fn columns(&self) -> usize {
        4 + 2 * usize::from(self.load) + 2 * usize::from(self.stribeck.is_some())
    }

    /// The friction parameters, in the order of the columns.
    pub fn parameters(&self) -> Vec<FrictionParameter> {
        use FrictionParameter::*;
        let mut parameters = vec![ViscousForward, CoulombForward, ViscousBackward, CoulombBackward];
        if self.load {
            parameters.extend([LoadForward, LoadBackward]);
        }
        if self.stribeck.is_some() {
            parameters.extend([StribeckForward, StribeckBackward]);
        }
        parameters
    }

    /// The columns at a series of samples, one vector per column. `v`: velocity, rad/s; `a`: acceleration, rad/s^2; `tau`: drive
    /// torque, N m; `h`: sample time, s.
    pub fn fill(&self, v: &[f64], a: &[f64], tau: &[f64], h: f64) -> Vec<Vec<f64>> {
        let share: Vec<f64> = v.iter().zip(a).map(|(&v, &a)| positive_share(v, a, h, self.rest_velocity)).collect();
        let column = |f: &dyn Fn(usize) -> f64| (0..v.len()).map(f).collect::<Vec<f64>>();
        let mut columns = vec![
            column(&|i| soft_plus(v[i], self.rest_velocity)),
            share.clone(),
            column(&|i| v[i] - soft_plus(v[i], self.rest_velocity)),
            column(&|i| 1.0 - share[i]),
        ];
        if self.load {
            columns.push(column(&|i| share[i] * tau[i].abs()));
            columns.push(column(&|i| (1.0 - share[i]) * tau[i].abs()));
        }
        if let Some(speed) = self.stribeck {
            let bump = |i: usize| (-(v[i] / speed).powi(2)).exp();
            columns.push(column(&|i| share[i] * bump(i)));
            columns.push(column(&|i| (1.0 - share[i]) * bump(i)));
        }
        columns
    }
}

/// If |a h / (2 w)| is below this value, the velocity counts as constant in the cell, because the rounding error of the
/// quotient would be larger than the effect of the acceleration.
const SMALL_CELL_CHANGE: f64 = 1e-3;

/// s+: mean of (1 + tanh((v + a s)/w))/2 over times s in [-h/2, h/2]. v: velocity, a: acceleration, h: sample time, w: velocity
/// over which the sign changes.
fn positive_share(v: f64, a: f64, h: f64, w: f64) -> f64 {
    let half = 0.5 * a * h / w;
    let x = v / w;
    if half.abs() < SMALL_CELL_CHANGE {
        return 0.5 * (1.0 + x.tanh());
    }
    0.5 + (log_cosh(x + half) - log_cosh(x - half)) / (4.0 * half)
}

/// The smoothed max(v, 0): w/2 ln(1 + exp(2 v/w)).
fn soft_plus(v: f64, w: f64) -> f64 {
    v.max(0.0) + 0.5 * w * (-2.0 * v.abs() / w).exp().ln_1p()
}

fn log_cosh(x: f64) -> f64 {
    let x = x.abs();
    x + (-2.0 * x).exp().ln_1p() - std::f64::consts::LN_2
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_share_is_the_mean_over_the_cell() {
        let (h, w) = (1e-3, 0.005);
        for (v, a) in [(0.0, 40.0), (0.004, -30.0), (-0.01, 12.0), (0.2, 60.0), (0.001, 1e-4), (-0.02, 0.3)] {
            let steps = 4000;
            let at = |i: usize| 0.5 * (1.0 + ((v + a * h * ((i as f64 + 0.5) / steps as f64 - 0.5)) / w).tanh());
            let mean = (0..steps).map(at).sum::<f64>() / steps as f64;
            // Allowed error: error of the midpoint rule with 4000 steps.
            assert!((positive_share(v, a, h, w) - mean).abs() < 1e-7, "{v} {a}");
        }
        assert_eq!(positive_share(1e3, 1e5, h, w), 1.0);
        assert_eq!(positive_share(-1e3, 1e5, h, w), 0.0);
    }

    #[test]
    fn columns_follow_the_shape() {
        let shape = FrictionShape { rest_velocity: 1e-6, load: true, stribeck: Some(0.1) };
        let columns = shape.fill(&[1.0, -2.0], &[0.0; 2], &[3.0, -4.0], 1e-3);
        assert_eq!(columns.len(), shape.columns());
        assert_eq!(columns.len(), shape.parameters().len());
        assert_eq!(columns[0], [1.0, 0.0]);
        assert_eq!(columns[2], [0.0, -2.0]);
        assert_eq!((columns[4][0], columns[5][1]), (3.0, 4.0));
        assert_eq!(FrictionShape::ASYMMETRIC.columns(), 4);
    }
}
