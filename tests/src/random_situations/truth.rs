//! The base parameters of a machine in the frames of a model, from torques alone: least squares of the chain's torques
//! at random states, without noise. What is left over tells whether both are the same mechanics.
//!
//! A rotor counts where the columns of the model can say it, as that of the first joint within ZZR of its link, and where
//! the program says that it is part of parameters, offsets among them. Where it is neither, because the model has no rotor
//! inertias, the truth of a parameter is that of the bodies.

use linear_model::regressor::Regressor;
use nalgebra::{DMatrix, DVector};

use super::chain::Chain;
use super::draw::Draw;

/// What a rounding leaves over, relative to the torque; a rotor without a column leaves thousands of times more.
const ROUNDING: f64 = 1e-7;

/// Base parameters, and what they leave.
pub struct Truth {
    pub base: Vec<f64>,
    /// What rotors that are part of parameters add to the offset of each joint.
    pub offsets: Vec<f64>,
    /// What the bodies leave: the norm of the torques that no parameters explain over that of the torques.
    pub left: f64,
    /// Rotors that the columns cannot say.
    pub unsaid: Vec<usize>,
}

/// The base parameters of a chain that stands as described. `within`: rotors that parameters contain, as the program says.
pub fn truth(chain: &Chain, regressor: &dyn Regressor, within: &[usize]) -> Truth {
    let (n, p) = (chain.len(), regressor.parameters().len());
    let states = 4 * p / n + 20;
    let mut draw = Draw::of(1, 1);
    // The base parameters, then an offset of each joint.
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
    // Columns of one length: first moments and moments of inertia differ by orders.
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
