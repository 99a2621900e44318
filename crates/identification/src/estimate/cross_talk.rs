//! The motion of one joint in the residual of another.
//!
//! The residual e_j of a joint is regressed on ddq_k, dq_k and the direction of each other joint k. The share of
//! |e_j|^2 that they explain is near zero where the model is complete. It is large where a motor also turns with
//! another joint and the model lacks its inertia and friction.

use logs::Error;
use nalgebra::{Matrix3, Matrix4};

use crate::model::linear_model::Model;
use crate::signals::records::Records;

/// The motion of joint `of` shows in the residual of joint `joint`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CrossTalk {
    /// The joint whose residual is explained.
    pub joint: usize,
    /// The joint whose motion explains it.
    pub of: usize,
    /// Share of the squares of the residual.
    pub share: f64,
}

/// For each joint the other joint that explains most of its residual under parameters `x`.
///
/// Fails when a record cannot be read.
pub fn cross_talk<R: Records + ?Sized>(model: &Model, records: &R, x: &[f64]) -> Result<Vec<CrossTalk>, Error> {
    let n = model.n();
    // Products of ddq_k, dq_k, direction_k and e_j.
    let mut products = vec![Matrix4::<f64>::zeros(); n * n];
    records.each(&mut |states| {
        model.residuals(states, x, |r, j, e| {
            for k in (0..n).filter(|&k| k != j) {
                let at = r * n + k;
                let row = [states.ddq[at], states.dq[at], states.direction[at], e];
                let row = nalgebra::Vector4::from(row);
                products[j * n + k] += row * row.transpose();
            }
        });
    })?;
    let of_joint = |j: usize| {
        let all = (0..n).filter(|&k| k != j);
        let talk = all.map(|k| CrossTalk { joint: j, of: k, share: explained(&products[j * n + k]) });
        talk.max_by(|a, b| a.share.total_cmp(&b.share))
    };
    Ok((0..n).filter_map(of_joint).collect())
}

/// The share of the last square that the other three explain.
fn explained(products: &Matrix4<f64>) -> f64 {
    let total = products[(3, 3)];
    let scale = |i: usize| if products[(i, i)] > 0.0 { products[(i, i)].sqrt().recip() } else { 0.0 };
    let gram = Matrix3::from_fn(|i, k| scale(i) * products[(i, k)] * scale(k));
    let right = nalgebra::Vector3::from_fn(|i, _| scale(i) * products[(i, 3)]);
    // A column that repeats others, or is zero, explains nothing of its own.
    let solved = gram.pseudo_inverse(1e-9).map(|inverse| right.dot(&(inverse * right)));
    match solved {
        Ok(square) if total > 0.0 => square / total,
        _ => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::algebra::random::Random;
    use crate::model::friction::terms::sign;
    use crate::model::parameter::BaseParameter;
    use crate::model::regressor::Regressor;
    use crate::model::states::States;

    /// Two joints that have nothing to do with one another.
    struct Wheels([String; 2], [BaseParameter; 2]);

    impl Regressor for Wheels {
        fn coordinates(&self) -> &[String] {
            &self.0
        }

        fn parameters(&self) -> &[BaseParameter] {
            &self.1
        }

        fn fill(&self, _: &[f64], _: &[f64], ddq: &[f64], y: &mut [f64]) {
            y.copy_from_slice(&[ddq[0], 0.0, 0.0, ddq[1]]);
        }
    }

    #[test]
    fn a_coupled_motor_is_found() {
        let wheels = Wheels(
            ["q1".into(), "q2".into()],
            [0, 1].map(|k| BaseParameter::turning(&format!("ZZ{}", k + 1), k).unwrap()),
        );
        let model = Model::new(&wheels, &[], &[]);
        let share = |coupling: f64| {
            let mut random = Random::new(3);
            let mut states = States { n: 2, ..States::default() };
            for r in 0..500 {
                let t = 0.01 * f64::from(r);
                let dq = [(3.0 * t).sin(), (5.0 * t).cos()];
                let ddq = [3.0 * (3.0 * t).cos(), -5.0 * (5.0 * t).sin()];
                states.t.push(t);
                states.q.extend([0.0, 0.0]);
                states.dq.extend(dq);
                states.ddq.extend(ddq);
                states.direction.extend(dq.map(sign));
                let noise = [0.1 * random.normal(), 0.1 * random.normal()];
                states
                    .tau
                    .extend([ddq[0] + coupling * (0.2 * ddq[1] + sign(dq[1])) + noise[0], 2.0 * ddq[1] + noise[1]]);
                states.used.extend([true, true]);
            }
            let talk = cross_talk(&model, [states].as_slice(), &[1.0, 2.0]).unwrap();
            assert_eq!((talk[0].joint, talk[0].of, talk[1].joint), (0, 1, 1));
            (talk[0].share, talk[1].share)
        };
        let (coupled, other) = share(1.0);
        // Noise of variance 0.01 beside squares of more than 1.
        assert!(coupled > 0.95, "{coupled}");
        // Three columns explain 3 of 500 parts of white noise, up to chance.
        assert!(other < 0.05 && share(0.0).0 < 0.05, "{other}");
    }
}
