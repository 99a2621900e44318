//! Checks the sign of friction in each joint, without using the description's parameters.
//!
//! The torque of joint j is projected onto the complement of the columns of Y_j (row j of the regressor). The result is
//! regressed on dq_j and on its direction.
//!
//! tau_j = Y_j X_j + b dq_j + c direction_j + d, with free parameters X_j for each joint. So a wrong sign, unit or zero of
//! another joint has no influence. Real friction dissipates: its power b dq^2 + c |dq| is positive. If the power is
//! negative, the torque or the motion of this joint has the wrong sign.

use linear_model::regressor::Regressor;
use linear_model::states::States;

use crate::estimate::log_check::change::{MIN_SAMPLES_PER_JOINT, column, used};
use crate::estimate::log_check::regression::{Basis, product, square};

/// Friction of one joint, estimated from the equation of this joint alone.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct JointFriction {
    /// Normalised power f . dq / (|tau| |dq|), with the friction torque f, and tau without its mean; positive if friction
    /// dissipates.
    pub brakes: f64,
    /// Standard deviation of `brakes`, which allows for residuals with a long autocorrelation time.
    pub deviation: f64,
    /// Relative residual |residual| / |tau|, with tau without its mean.
    pub residual: f64,
    /// Whether the power of friction is significantly negative, and neither term is significantly positive.
    pub drives: bool,
}

/// Estimates the friction of joint j. `None` if the joint hardly moves, is used in too few samples, or if the standard
/// deviation is too large.
pub(crate) fn own_friction(
    regressor: &dyn Regressor,
    states: &States,
    rows: &[usize],
    j: usize,
) -> Option<JointFriction> {
    let (n, p) = (states.n, regressor.parameters().len());
    let rows: Vec<usize> = used(states, rows, j).into_iter().map(|i| rows[i]).collect();
    if rows.len() < MIN_SAMPLES_PER_JOINT.max(3 * p / 2) {
        return None;
    }
    let mut base = vec![vec![0.0; rows.len()]; p];
    let mut y = vec![0.0; n * p];
    for (i, &r) in rows.iter().enumerate() {
        let at = r * n..(r + 1) * n;
        regressor.fill(&states.q[at.clone()], &states.dq[at.clone()], &states.ddq[at], &mut y);
        base.iter_mut().zip(&y[j * p..(j + 1) * p]).for_each(|(column, x)| column[i] = *x);
    }
    let ones = vec![1.0; rows.len()];
    let mean = Basis::of(vec![ones.clone()]);
    base.insert(0, ones);
    let basis = Basis::of(base);
    let (dq, direction) = (column(&states.dq, n, j, &rows), column(&states.direction, n, j, &rows));
    let tau = column(&states.tau, n, j, &rows);
    let (v, d, left) = (basis.without(dq.clone()), basis.without(direction.clone()), basis.without(tau.clone()));
    let (vv, vd, dd) = (square(&v), product(&v, &d), square(&d));
    let (vt, dt) = (product(&v, &left), product(&d, &left));
    let determinant = vv * dd - vd * vd;
    let size = square(&mean.without(tau)).sqrt();
    if determinant <= SMALLEST_SQUARED_SINE * vv * dd || size == 0.0 {
        return None;
    }
    let (viscous, dry) = ((dd * vt - vd * dt) / determinant, (vv * dt - vd * vt) / determinant);
    let friction: Vec<f64> = dq.iter().zip(&direction).map(|(v, d)| viscous * v + dry * d).collect();
    let speed = square(&dq).sqrt();
    let unexplained = (square(&left) - viscous * vt - dry * dt).max(0.0).sqrt();
    // The power is w . (b, c), w = (dq.dq, dq.direction); its variance is w' M^-1 w times the variance of the residual.
    let (w, u) = (square(&dq), product(&dq, &direction));
    let spread = (dd * w * w - 2.0 * vd * w * u + vv * u * u) / determinant;
    let deviation = unexplained * (spread / MAX_INDEPENDENT_SAMPLES).sqrt();
    // Whether a friction term x is positive by more than its standard deviation.
    let above = |x: f64, other: f64| x > unexplained * (other / (MAX_INDEPENDENT_SAMPLES * determinant)).sqrt();
    let found = JointFriction {
        brakes: product(&friction, &dq) / (size * speed),
        deviation: deviation / (size * speed),
        residual: unexplained / size,
        drives: false,
    };
    let is_negative = -found.brakes > SMALLEST_DRIVING_SHARE.max(DRIVING_FRICTION_SIGMAS * found.deviation);
    let drives = is_negative && !above(viscous, dd) && !above(dry, vv);
    (found.deviation < LARGEST_FRICTION_DEVIATION).then_some(JointFriction { drives, ..found })
}

/// Assumed number of independent samples of a residual, since it is mainly a model error with a long autocorrelation time.
const MAX_INDEPENDENT_SAMPLES: f64 = 30.0;

/// Friction counts as driving only if its normalised power is below minus this.
const SMALLEST_DRIVING_SHARE: f64 = 0.02;
/// Friction counts as driving only if it is negative by more than this many standard deviations.
const DRIVING_FRICTION_SIGMAS: f64 = 4.0;

/// Friction is unknown if its normalised standard deviation exceeds this. A slow log in which gravity and friction are
/// correlated (KR300) has 0.5 to 2.
const LARGEST_FRICTION_DEVIATION: f64 = 0.25;

/// The columns dq and direction are separable if the squared sine of the angle between them is above this.
const SMALLEST_SQUARED_SINE: f64 = 1e-6;
