//! Checks the sign of friction in each joint, without the nominal parameters of the description.
//!
//! For each joint alone, tau_j = Y_j X_j + b dq_j + c direction_j + d is fitted (Y_j: regressor row; b, c: viscous and
//! Coulomb friction; d: offset). The parameters X_j are free, so a wrong sign, unit or zero of another joint has no
//! influence. Y_j and the offset are projected out of the torque, and the result is regressed on dq_j and direction_j.
//!
//! Real friction dissipates: its power b dq^2 + c |dq| is positive. If the power is negative, the torque or the motion of
//! this joint has the wrong sign.

use linear_model::regressor::Regressor;
use linear_model::states::States;

use crate::estimate::log_check::change::{MIN_SAMPLES_PER_JOINT, column, used};
use crate::estimate::log_check::regression::{Basis, product, square};

/// Friction of one joint, fitted to the torques of this joint alone.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct JointFriction {
    /// Normalised power of friction f . dq / (|tau| |dq|), positive if friction dissipates. f: friction torque; tau: torque
    /// without its mean.
    pub brakes: f64,
    /// Standard deviation of `brakes`, for residuals with a long autocorrelation time.
    pub deviation: f64,
    /// Relative residual |residual| / |tau| of the fit. tau: torque without its mean.
    pub residual: f64,
    /// Whether the power of friction is significantly negative, and neither viscous nor Coulomb friction is significantly
    /// positive.
    pub drives: bool,
}

/// Estimates the friction of joint j from the torques of this joint alone. `None` if the joint hardly moves, if it has too few
/// samples, or if the standard deviation is too large.
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
    // The power is w . (b, c) with w = (dq.dq, dq.direction). The variance of the power is w' M^-1 w times the variance of the
    // residual (M: normal matrix of b and c).
    let (w, u) = (square(&dq), product(&dq, &direction));
    let spread = (dd * w * w - 2.0 * vd * w * u + vv * u * u) / determinant;
    let deviation = unexplained * (spread / MAX_INDEPENDENT_SAMPLES).sqrt();
    // Whether a friction coefficient x exceeds its standard deviation, so that it is clearly positive.
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

/// Assumed number of independent samples of a residual. This number is small, because a residual is mainly a model error with a
/// long autocorrelation time.
const MAX_INDEPENDENT_SAMPLES: f64 = 30.0;

/// Friction counts as negative only if its normalised power (`brakes`) is below minus this value.
const SMALLEST_DRIVING_SHARE: f64 = 0.02;
/// Friction counts as negative only if its power is below zero by more than this many standard deviations.
const DRIVING_FRICTION_SIGMAS: f64 = 4.0;

/// Friction is not determined if the standard deviation of its normalised power exceeds this value. A slow log (KR300), in
/// which gravity and friction are correlated, has 0.5 to 2.
const LARGEST_FRICTION_DEVIATION: f64 = 0.25;

/// Velocity and direction of a joint are separable if the squared sine of the angle between their columns exceeds this value.
const SMALLEST_SQUARED_SINE: f64 = 1e-6;
