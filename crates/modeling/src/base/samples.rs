//! The regressor at random states, from which the numbers tell the rank.

use expr::{Function, Tape};
use nalgebra::DMatrix;
use random::SplitMix;

use crate::kinematics::closure::Closure;

/// D at random states with closed loops, stacked state by state; `constants`: values of inputs behind q, dq and ddq.
pub(crate) fn sampled(regressor: &Function, closure: Option<Closure>, constants: &[f64]) -> DMatrix<f64> {
    let tape = Tape::new(regressor);
    let (n, p) = (regressor.outputs[0].rows, regressor.outputs[0].columns);
    // Three times as many rows as columns, even where a link's columns are non-zero only in the row of its own joint.
    let n_states = if n == 0 { 0 } else { 3 * p.div_ceil(n) + 8 };
    let mut random = SplitMix(1995);
    let closed = closure.map(|mut closure| closure.sample(n, n_states, &mut random));
    let n_states = closed.as_ref().map_or(n_states, Vec::len);
    let mut states = Vec::with_capacity(n_states * tape.n_inputs());
    for s in 0..n_states {
        match &closed {
            Some(closed) => states.extend(closed[s].0.iter().chain(&closed[s].1)),
            None => states.extend((0..n).map(|_| std::f64::consts::PI * random.unit())),
        }
        // Rates that let inertia, centrifugal and gravity terms weigh alike.
        for scale in [2.0, 4.0] {
            states.extend((0..n).map(|_| scale * random.unit()));
        }
        states.extend_from_slice(constants);
    }
    let mut values = vec![0.0; n_states * n * p];
    tape.evaluate_many(&states, &mut tape.workspace(), &mut values);
    DMatrix::from_row_slice(n_states * n, p, &values)
}
