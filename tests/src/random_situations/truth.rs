//! Determines the true base parameters of a machine (the true robot) in the frames of a model: least squares on noise-free
//! torques at random states. The torques are from independent mechanics (`chain`). A residual above rounding errors means that
//! the two mechanics differ.
//!
//! A rotor contributes to base parameters if the columns of the model can represent it (as ZZR of the first link), or if the
//! program states that other parameters or torque offsets contain it. In all other cases the model has no rotor inertias, and the
//! true parameters are those of the bodies.

use linear_model::regressor::Regressor;
use nalgebra::{DMatrix, DVector};

use super::chain::Chain;
use super::draw::Draw;

/// Largest relative residual that is only rounding. A rotor without a column gives a residual that is thousands of times larger.
const ROUNDING: f64 = 1e-7;

/// The true base parameters, and the residual.
pub struct Truth {
    pub base: Vec<f64>,
    /// Contribution of rotors to the torque offset of each joint, for rotors that other parameters include.
    pub offsets: Vec<f64>,
    /// Relative residual of the torques of the bodies: norm of the residual divided by the norm of the torques.
    pub left: f64,
    /// Indices of rotors whose inertia the columns of the regressor cannot represent.
    pub unsaid: Vec<usize>,
}

/// The true base parameters of a chain without a tilted base. `within`: rotors whose inertia is included in other parameters,
/// according to the program.
pub fn truth(chain: &Chain, regressor: &dyn Regressor, within: &[usize]) -> Truth {
    let (n, p) = (chain.len(), regressor.parameters().len());
    let states = 4 * p / n + 20;
    let mut draw = Draw::of(1, 1);
    // The unknowns are the base parameters, then an offset for each joint.
    let mut rows = DMatrix::zeros(states * n, p + n);
    let mut bodies = DVector::zeros(states * n);
    let mut rotors = vec![DVector::zeros(states * n); n];
    let mut y = vec![0.0; n * p];
    for s in 0..states {
        let mut some = |scale: f64| (0..n).map(|_| draw.uniform(-scale, scale)).collect::<Vec<f64>>();
        let (q, dq, ddq) = (some(2.5), some(2.0), some(6.0));
        regressor.fill(&q, &dq, &ddq, &mut y);
        let tau = chain.torque(&q, &dq, &ddq);
        for k in 0..n {
            bodies[s * n + k] = tau[k];
            rotors[k][s * n + k] = chain.joints[k].rotor * ddq[k];
            (0..p).for_each(|c| rows[(s * n + k, c)] = y[k * p + c]);
            rows[(s * n + k, p + k)] = 1.0;
        }
    }
    // The columns are scaled to equal norms, because first moments and moments of inertia have very different magnitudes.
    let lengths: Vec<f64> = (0..p + n).map(|c| rows.column(c).norm().max(f64::MIN_POSITIVE)).collect();
    (0..p + n).for_each(|c| rows.column_mut(c).scale_mut(1.0 / lengths[c]));
    let explained = |tau: &DVector<f64>, columns: usize| {
        let rows = rows.columns(0, columns).clone_owned();
        let qr = rows.clone().qr();
        let solved = qr.r().solve_upper_triangular(&(qr.q().transpose() * tau));
        let scaled = solved.unwrap_or_else(|| DVector::zeros(columns));
        let left = (&rows * &scaled - tau).norm() / tau.norm().max(f64::MIN_POSITIVE);
        (scaled.resize_vertically(p + n, 0.0), left)
    };
    let (mut sum, left) = explained(&bodies, p);
    let mut unsaid = Vec::new();
    for k in (0..n).filter(|&k| chain.joints[k].rotor > 0.0) {
        let columns = if within.contains(&k) { p + n } else { p };
        match explained(&rotors[k], columns) {
            (of_rotor, left) if left < ROUNDING => sum += of_rotor,
            _ => unsaid.push(k),
        }
    }
    let mut base: Vec<f64> = sum.iter().zip(&lengths).map(|(x, l)| x / l).collect();
    let offsets = base.split_off(p);
    Truth { base, offsets, left, unsaid }
}
