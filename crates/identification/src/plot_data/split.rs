//! Splits a torque into components, sample by sample.
//!
//! ```text
//! gravity  Y(q, 0, 0) X        Coriolis and centrifugal  Y(q, dq, 0) X - Y(q, 0, 0) X
//! inertia  Y(q, dq, ddq) X - Y(q, dq, 0) X               friction  the columns beyond the base parameters
//! ```
//! If a rotor inertia is among the friction columns, its torque counts as inertia. The torque of a coupled motor counts as
//! friction.

use linear_model::friction::terms::{FrictionTerm, columns_before, columns_of};
use linear_model::linear_model::Model;
use linear_model::states::States;

/// Names of the components of a torque, in the order of `JointTorque::parts`.
pub const TORQUE_PART_NAMES: [&str; 4] = ["inertia", "Coriolis and centrifugal", "gravity", "friction"];

/// Motion and torques of one joint at one sample. Torques are in N m (N), the position in rad (m), and the derivatives of the
/// position in the same unit per s and s^2.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct JointTorque {
    /// Position, rad (m).
    pub q: f64,
    /// Velocity, rad/s (m/s).
    pub dq: f64,
    /// Acceleration, rad/s^2 (m/s^2).
    pub ddq: f64,
    /// The measured torque.
    pub measured: f64,
    /// Components of the predicted torque: inertia, Coriolis and centrifugal, gravity, friction.
    pub parts: [f64; 4],
    /// The nominal torque with fitted friction; NaN if the description has no inertials.
    pub described: f64,
    /// Whether the row is used. A row is not used if the joint is at standstill, because stiction may hold the joint.
    pub counts: bool,
}

impl JointTorque {
    /// The predicted torque: sum of the components.
    pub fn predicted(&self) -> f64 {
        self.parts.iter().sum()
    }

    /// Measured minus predicted torque.
    pub fn residual(&self) -> f64 {
        self.measured - self.predicted()
    }

    /// The predicted torque without friction.
    pub fn rigid(&self) -> f64 {
        self.parts[..3].iter().sum()
    }
}

/// Splits the torques that parameters `x` predict for a record. Calls `take(r, joints)` for each sample r with the torques of all
/// joints. `described`: nominal value of each parameter of the model; `None` if unknown.
pub fn split(
    model: &Model,
    x: &[f64],
    described: Option<&[f64]>,
    states: &States,
    mut take: impl FnMut(usize, &[JointTorque]),
) {
    let (n, p, base) = (model.n(), model.p(), model.regressor.parameters().len());
    let rotor = rotor_columns(model);
    let (mut inputs, mut y) = (vec![0.0; 6 * n], vec![0.0; 2 * n * base]);
    let mut torques = vec![JointTorque::default(); n];
    let product = |row: &[f64], x: &[f64]| row.iter().zip(x).map(|(a, b)| a * b).sum::<f64>();
    model.rows(states, 0..states.len(), |r, w| {
        let at = r * n..(r + 1) * n;
        // Two states for which the regressor is computed: at rest, and with velocities but without accelerations.
        inputs[..n].copy_from_slice(&states.q[at.clone()]);
        inputs[3 * n..4 * n].copy_from_slice(&states.q[at.clone()]);
        inputs[4 * n..5 * n].copy_from_slice(&states.dq[at]);
        model.regressor.fill_many(&inputs, &mut y);
        for (j, torque) in torques.iter_mut().enumerate() {
            let row = |y: &[f64]| product(&y[j * base..(j + 1) * base], &x[..base]);
            let (rest, coasting) = (row(&y[..n * base]), row(&y[n * base..]));
            let w = &w[j * p..(j + 1) * p];
            let (whole, beside) = (product(&w[..base], &x[..base]), product(&w[base..], &x[base..]));
            let turned = rotor[j].map_or(0.0, |c| w[c] * x[c]);
            let (i, scale, spring) = (r * n + j, model.scale(j), model.spring(states, r, j));
            *torque = JointTorque {
                q: states.q[i],
                dq: states.dq[i],
                ddq: states.ddq[i],
                measured: scale * (states.tau[i] + spring),
                parts: [whole - coasting + turned, coasting - rest, rest, beside - turned + spring].map(|x| scale * x),
                described: described.map_or(f64::NAN, |x| scale * (product(w, x) + spring)),
                counts: states.used[i],
            };
        }
        take(r, &torques);
    });
}

/// For each joint, the index of the column of its rotor inertia; `None` if the model has no such column.
fn rotor_columns(model: &Model) -> Vec<Option<usize>> {
    let rotor = model.friction.iter().position(|t| *t == FrictionTerm::Rotor);
    let base = model.regressor.parameters().len();
    let column = |i: usize, j: usize| columns_before(model.friction, j) + columns_of(&model.friction[..i], j);
    (0..model.n()).map(|j| rotor.map(|i| base + column(i, j))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_arm::Pendulum;

    #[test]
    fn the_parts_of_a_pendulum() {
        let arm = Pendulum::new();
        let friction = [FrictionTerm::Viscous, FrictionTerm::Rotor];
        let model = Model::new(&arm, &friction, &[]);
        let states = arm.states(50);
        let [zz, mx, my] = arm.truth;
        let (fv, ia) = (0.4, 0.07);
        let mut count = 0;
        split(&model, &[zz, mx, my, fv, ia], Some(&[0.0, 2.0, 0.0, 0.0, 0.0]), &states, |r, torques| {
            let (q, dq, ddq) = (states.q[r], states.dq[r], states.ddq[r]);
            let expected = [(zz + ia) * ddq, 0.0, 9.81 * (mx * q.cos() - my * q.sin()), fv * dq];
            for (part, expected) in torques[0].parts.iter().zip(expected) {
                // Tolerance: rounding of sums of three products of numbers below fifty.
                assert!((part - expected).abs() < 1e-12, "{part} {expected}");
            }
            assert!((torques[0].predicted() - torques[0].measured - ia * ddq - fv * dq).abs() < 1e-12);
            assert!((torques[0].described - 2.0 * 9.81 * q.cos()).abs() < 1e-12);
            count += 1;
        });
        assert_eq!(count, 50);
    }
}
