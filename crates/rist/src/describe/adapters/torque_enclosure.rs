//! Interval bounds of the torques of a robot along a motion: each node of the function's expression graph is evaluated with jets
//! (value and two time derivatives, each an interval).
//!
//! The function is tau(q, dq, ddq, X) with the standard parameters of the description, or Y(q, dq, ddq) times identified base
//! parameters X.

use experiments::excitation::proof::EnclosedTorque;
use expr::{Expr, Function, Node};
use numerics::interval::Interval;
use numerics::jet::Jet;

use crate::describe::model::Model;

/// Interval bounds of tau(q, dq, ddq) with fixed numbers for the parameters.
pub(crate) struct TorqueEnclosure<'a> {
    function: &'a Function,
    /// The values of the standard parameters, the last inputs of the function.
    values: Vec<f64>,
    /// Base parameters X, by which the outputs Y are multiplied. If empty, the outputs are the torques.
    multiples: Vec<f64>,
}

impl<'a> TorqueEnclosure<'a> {
    /// The torques of the description. `None` if no link has inertial parameters, or if joints are solved numerically.
    pub(crate) fn new(model: &'a Model) -> Option<TorqueEnclosure<'a>> {
        if !model.robot.passive.is_empty() || model.nominal_parameters().is_none() {
            return None;
        }
        let value = |p: &robot::StandardParameter| p.value(&model.robot).unwrap_or(0.0);
        let values = model.parameters.standard.iter().map(value).collect();
        Some(TorqueEnclosure { function: &model.torque, values, multiples: vec![] })
    }

    /// The torques of identified base parameters. `None` if joints are solved numerically, or if the number of parameters is
    /// zero or differs from the model's.
    pub(crate) fn identified(model: &'a Model, parameters: &[f64]) -> Option<TorqueEnclosure<'a>> {
        let fits = model.robot.passive.is_empty()
            && !parameters.is_empty()
            && parameters.len() == model.regressor().parameters().len();
        let function = &model.base_regressor;
        fits.then(|| TorqueEnclosure { function, values: vec![], multiples: parameters.to_vec() })
    }
}

impl EnclosedTorque for TorqueEnclosure<'_> {
    fn torque(&self, q: &[Jet], dq: &[Jet], ddq: &[Jet]) -> Vec<Jet> {
        let nodes = self.function.graph().nodes();
        let mut values = vec![Jet::constant(Interval::ZERO); nodes.len()];
        let constants = self.values.iter().map(|x| Jet::constant(Interval::point(*x)));
        // Values of the inputs in the order of the function: q, dq, ddq, then the standard parameters. The standard parameters
        // are intervals of width zero.
        let given = q.iter().chain(dq).chain(ddq).copied().chain(constants);
        for (e, jet) in self.function.inputs.iter().flat_map(|i| &i.entries).zip(given) {
            values[e.node()] = jet;
        }
        let signed = |values: &[Jet], e: Expr| if e.is_negative() { -values[e.node()] } else { values[e.node()] };
        for (i, &node) in nodes.iter().enumerate() {
            let at = |e: Expr| signed(&values, e);
            values[i] = match node {
                Node::Constant(x) => Jet::constant(Interval::point(x)),
                Node::Symbol(_) => continue,
                Node::Sin(a) => at(a).sin(),
                Node::Cos(a) => at(a).cos(),
                Node::Add(a, b) => at(a) + at(b),
                Node::Mul(a, b) => at(a) * at(b),
                Node::Div(a, b) => at(a).over(at(b)),
                Node::Sqrt(a) => at(a).sqrt(),
            };
        }
        let outputs = self.function.outputs.iter().flat_map(|o| &o.entries);
        let outputs: Vec<Jet> = outputs.map(|e| signed(&values, *e)).collect();
        // Without identified parameters, the outputs are torques. With identified parameters X, the outputs are Y, and tau = Y
        // X.
        if self.multiples.is_empty() {
            return outputs;
        }
        let zero = Jet::constant(Interval::ZERO);
        let sum = |row: &[Jet]| {
            let terms = row.iter().zip(&self.multiples).filter(|(y, x)| **x != 0.0 && **y != zero);
            terms.fold(zero, |sum, (y, x)| sum + *y * Jet::constant(Interval::point(*x)))
        };
        outputs.chunks_exact(self.multiples.len()).map(sum).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn torques_lie_within() {
        let models = concat!(env!("CARGO_MANIFEST_DIR"), "/../../models");
        let model = Model::read(format!("{models}/ur5.urdf")).unwrap();
        let described = model.nominal_parameters().unwrap();
        // Both forms of the function, tau(X_standard) and Y X, must enclose the same torques.
        for enclosure in [TorqueEnclosure::new(&model), TorqueEnclosure::identified(&model, &described)] {
            hold(&model, &enclosure.unwrap(), &described);
        }
    }

    fn hold(model: &Model, enclosure: &TorqueEnclosure, described: &[f64]) {
        let n = model.regressor().coordinates().len();
        // The motion is q_k = sin((k + 1) t). This closure gives the derivative of order `d` of this motion at time `t`.
        let derivative = |k: usize, d: i32, t: f64| {
            let w = (k + 1) as f64;
            w.powi(d) * (w * t + f64::from(d) * std::f64::consts::FRAC_PI_2).sin()
        };
        let jets = |d: i32, t: Interval| -> Vec<Jet> {
            let wave = |k: usize, d: i32| {
                let w = (k + 1) as f64;
                (t * w + Interval::pi() * (0.5 * f64::from(d))).sin() * w.powi(d)
            };
            (0..n).map(|k| Jet::of_derivatives(wave(k, d), wave(k, d + 1), wave(k, d + 2))).collect()
        };
        let on = |t: Interval| enclosure.torque(&jets(0, t), &jets(1, t), &jets(2, t));
        for i in 0..50 {
            let (low, high) = (0.1 * f64::from(i), 0.1 * f64::from(i) + 0.004);
            let (part, middle) = (Interval::new(low, high), 0.5 * (low + high));
            let (thin, wide) = (on(Interval::point(middle)), on(part));
            for step in 0..=4 {
                let t = low + (high - low) * f64::from(step) / 4.0;
                let state = |d: i32| -> Vec<f64> { (0..n).map(|k| derivative(k, d, t)).collect() };
                let (q, dq, ddq) = (state(0), state(1), state(2));
                let tau = experiments::simulate::dynamics::torque(model.regressor(), described, &q, &dq, &ddq);
                for k in 0..n {
                    let held = Jet::over_interval(thin[k], wide[k], part - Interval::point(middle));
                    // Tolerance: the two formulas differ by the rounding of some hundred operations at 100 N m.
                    assert!(held.low <= tau[k] + 1e-10 && held.high >= tau[k] - 1e-10, "{t} {k}: {held:?} {}", tau[k]);
                    // Bound of the width: torques change by at most 1000 N m/s during 4 ms.
                    assert!(held.width() < 8.0, "{held:?}");
                }
            }
        }
    }
}
