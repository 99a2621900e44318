//! The friction columns of a generated monitor, as C expressions: the entries of [`FrictionTerm::fill`] at one sample.
//!
//! ```text
//! F_j = sum_k x_k e_k          F_j: friction torque of joint j, N m (N); x_k: its parameters; e_k: entries of its columns
//! ```
//! The expressions read arrays of the monitor, with one entry per joint: `dq`, rad/s (m/s); `ddq`, rad/s^2 (m/s^2); `tau`, the
//! measured torque, and `predicted`, the torque without friction by an earlier fit, N m (N); `direction`, the sign of dq, between
//! -1 and 1.

use codegen::FrictionColumn;
use linear_model::friction::terms::{FrictionTerm, JointTerm};
use linear_model::linear_model::Model as LinearModel;

/// The friction columns of a model, joint by joint in the order of its parameters. `x`: values of all parameters.
pub(crate) fn friction_columns(linear: &LinearModel, x: &[f64]) -> Vec<FrictionColumn> {
    let mut values = x.iter().skip(linear.regressor.parameters().len());
    let mut columns = Vec::new();
    for joint in 0..linear.n() {
        for term in linear.friction.iter().filter(|term| !term.parameters_of(joint).is_empty()) {
            let entries = entries(*term, joint).into_iter().zip(&mut values);
            columns.extend(entries.map(|(entry, value)| FrictionColumn { joint, entry, value: *value }));
        }
    }
    columns
}

/// The entries of the columns of a term in joint j, in the order of [`FrictionTerm::parameters`].
fn entries(term: FrictionTerm, j: usize) -> Vec<String> {
    use FrictionTerm::{Asymmetric, At, Coulomb, Load, Offset, Rotor, SmoothCoulomb, Stribeck, Viscous};
    let (dq, direction) = (format!("dq[{j}]"), format!("direction[{j}]"));
    let stribeck = |speed: f64| format!("{direction} * EXP(-SQUARE({dq} / (real){speed:?}))");
    let entry = match term {
        Viscous => dq,
        Coulomb => direction,
        Offset => "1".to_string(),
        SmoothCoulomb(width) => format!("TANH({dq} / (real){width:?})"),
        Asymmetric => {
            return vec![
                format!("{dq} > 0 ? {dq} : 0"),
                format!("(real)0.5 * (1 + {direction})"),
                format!("{dq} < 0 ? {dq} : 0"),
                format!("(real)0.5 * (1 - {direction})"),
            ];
        }
        Stribeck(speed) | At(_, JointTerm::Stribeck(speed)) => stribeck(speed),
        Load => format!("{direction} * ABS(tau[{j}])"),
        Rotor => format!("ddq[{j}]"),
        At(_, JointTerm::Load) => format!("{direction} * ABS(predicted[{j}])"),
        At(_, JointTerm::ViscousAsymmetry) => format!("ABS({dq})"),
        At(_, JointTerm::Root) => format!("{direction} * SQRT(ABS({dq}))"),
    };
    vec![entry]
}
