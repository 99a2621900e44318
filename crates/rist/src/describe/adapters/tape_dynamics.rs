//! Inertia matrix A and bias torque h of a robot, evaluated by tapes (functions compiled to lists of operations).
//!
//! A and h could also be computed from the regressor Y, with n + 1 evaluations of Y. The functions derived for A and h take a
//! tenth of that time.

use experiments::simulate::dynamics::{Dynamics, RegressorDynamics};
use expr::Tape;
use modeling::Derivation;

use crate::describe::model::Model;
use crate::tape::thread_tapes::ThreadTapes;

/// tau = A(q) ddq + h(q, dq) of a robot with given base parameters.
struct TapeDynamics {
    /// The tape of A(q), then the tape of h(q, dq).
    tapes: ThreadTapes,
    n: usize,
}

/// The dynamics of a model with the base parameters `parameters`, in N m and rad; missing parameters count as zero.
///
/// If loops are closed numerically, A and h are computed from the regressor, which has the solver for the passive joints.
pub fn dynamics(model: &Model, mut parameters: Vec<f64>) -> Box<dyn Dynamics + '_> {
    parameters.resize(model.regressor().parameters().len(), 0.0);
    let derivation = Derivation::new(&model.robot).ok().filter(|_| model.robot.passive.is_empty());
    let Some(mut derivation) = derivation else {
        return Box::new(RegressorDynamics::new(model.regressor(), parameters));
    };
    let inertia = derivation.inertia_matrix(&model.parameters).bound();
    let bias = derivation.bias(&model.parameters).bound();
    Box::new(TapeDynamics {
        // The parameters X are the last input of both functions.
        tapes: ThreadTapes::new([inertia, bias].map(|of| Tape::new(&of).with_last_inputs(&parameters)).into()),
        n: model.robot.n_coordinates(),
    })
}

impl Dynamics for TapeDynamics {
    fn n_coordinates(&self) -> usize {
        self.n
    }

    fn fill(&self, q: &[f64], dq: &[f64], inertia: &mut [f64], bias: &mut [f64]) {
        self.fill_each(&[(q, dq)], inertia, bias);
    }

    fn fill_each(&self, states: &[(&[f64], &[f64])], inertia: &mut [f64], bias: &mut [f64]) {
        self.tapes.with(|tapes, work, inputs| {
            states.iter().for_each(|(q, _)| inputs.extend_from_slice(q));
            tapes[0].evaluate_many(inputs, &mut work[0], inertia);
            inputs.clear();
            states.iter().for_each(|(q, dq)| inputs.extend(q.iter().chain(*dq)));
            tapes[1].evaluate_many(inputs, &mut work[1], bias);
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use random::Random;

    #[test]
    fn tapes_and_regressor_agree() {
        for name in ["ur5.yaml", "scara.yaml", "stanford.yaml", "race.yaml"] {
            let path = format!("{}/../../models/{name}", env!("CARGO_MANIFEST_DIR"));
            let model = Model::read(&path).unwrap();
            let (n, p) = (model.robot.n_coordinates(), model.regressor().parameters().len());
            let mut random = Random::new(3);
            let mut normal = |count: usize| (0..count).map(|_| random.normal()).collect::<Vec<f64>>();
            let x = normal(p);
            let (tapes, regressor) = (dynamics(&model, x.clone()), RegressorDynamics::new(model.regressor(), x));
            assert_eq!(tapes.n_coordinates(), n);
            let of = |d: &dyn Dynamics, q: &[f64], dq: &[f64]| {
                let (mut a, mut h) = (vec![0.0; n * n], vec![0.0; n]);
                d.fill(q, dq, &mut a, &mut h);
                [a, h]
            };
            for _ in 0..20 {
                let (q, dq) = (normal(n), normal(n));
                let (found, expected) = (of(tapes.as_ref(), &q, &dq), of(&regressor, &q, &dq));
                for (found, expected) in found.iter().flatten().zip(expected.iter().flatten()) {
                    let largest = expected.abs().max(1.0);
                    // Tolerance: rounding of sums of a few hundred terms of order one, since A by the regressor is a difference
                    // of torques.
                    assert!((found - expected).abs() < 1e-10 * largest, "{name}: {found} {expected}");
                }
            }
        }
    }
}
