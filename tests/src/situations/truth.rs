//! The base parameters of a machine in the frames of a model, from torques alone: least squares of the chain's torques
//! at random states, without noise. What is left over tells whether both are the same mechanics.

use linear_model::regressor::Regressor;
use nalgebra::{DMatrix, DVector};

use super::chain::Chain;
use super::draw::Draw;

/// Base parameters, and the norm of what they leave of the torques over that of the torques.
pub struct Truth {
    pub base: Vec<f64>,
    pub left: f64,
}

/// The base parameters of a chain that stands as described.
pub fn truth(chain: &Chain, regressor: &dyn Regressor, with_rotors: bool) -> Truth {
    let (n, p) = (chain.len(), regressor.parameters().len());
    let states = 4 * p / n + 20;
    let mut draw = Draw::of(1, 1);
    let (mut rows, mut tau) = (DMatrix::zeros(states * n, p), DVector::zeros(states * n));
    let mut y = vec![0.0; n * p];
    for s in 0..states {
        let mut some = |scale: f64| (0..n).map(|_| draw.uniform(-scale, scale)).collect::<Vec<f64>>();
        let (q, dq, ddq) = (some(2.5), some(2.0), some(6.0));
        regressor.fill(&q, &dq, &ddq, &mut y);
        let exact = chain.torque(&q, &dq, &ddq);
        for k in 0..n {
            let rotor = if with_rotors { chain.joints[k].rotor * ddq[k] } else { 0.0 };
            tau[s * n + k] = exact[k] + rotor;
            (0..p).for_each(|c| rows[(s * n + k, c)] = y[k * p + c]);
        }
    }
    // Columns of one length: first moments and moments of inertia differ by orders.
    let lengths: Vec<f64> = (0..p).map(|c| rows.column(c).norm().max(1e-300)).collect();
    (0..p).for_each(|c| rows.column_mut(c).scale_mut(1.0 / lengths[c]));
    let qr = rows.clone().qr();
    let upper = qr.r();
    let scaled = upper.solve_upper_triangular(&(qr.q().transpose() * &tau)).unwrap_or_else(|| panic!("singular"));
    let left = (&rows * &scaled - &tau).norm() / tau.norm();
    Truth { base: scaled.iter().zip(&lengths).map(|(x, l)| x / l).collect(), left }
}
