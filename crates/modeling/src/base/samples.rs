//! Evaluates the regressor at random states. The numeric rank, and so the number of base parameters, is determined from the
//! resulting matrix.

use expr::{Function, Tape};
use nalgebra::DMatrix;
use random::SplitMix;

use crate::kinematics::closure::Closure;

/// Seed of the random states for the numeric rank.
const STATE_SEED: u64 = 1995;
/// Number of sampled rows per column of the regressor. This number is enough even if the columns of a link are non-zero only in
/// the row of the link's joint.
const ROWS_PER_COLUMN: usize = 3;
/// Number of random states in addition to the number that [`ROWS_PER_COLUMN`] requires.
const EXTRA_STATES: usize = 8;
/// Bounds of the random dq (rad/s or m/s) and ddq (rad/s^2 or m/s^2). With these bounds, inertia, centrifugal and gravity terms
/// have similar weights.
const RATE_BOUNDS: [f64; 2] = [2.0, 4.0];

/// The regressor at random states with closed loops, stacked state by state. `constants`: values of the inputs of the regressor
/// after q, dq and ddq.
pub(crate) fn sampled(regressor: &Function, closure: Option<Closure>, constants: &[f64]) -> DMatrix<f64> {
    let tape = Tape::new(regressor);
    let (n, p) = (regressor.outputs[0].rows, regressor.outputs[0].columns);
    let n_states = if n == 0 { 0 } else { ROWS_PER_COLUMN * p.div_ceil(n) + EXTRA_STATES };
    let mut random = SplitMix(STATE_SEED);
    let closed = closure.map(|mut closure| closure.sample(n, n_states, &mut random));
    let n_states = closed.as_ref().map_or(n_states, Vec::len);
    let mut states = Vec::with_capacity(n_states * tape.n_inputs());
    for s in 0..n_states {
        match &closed {
            Some(closed) => states.extend(closed[s].0.iter().chain(&closed[s].1)),
            None => states.extend((0..n).map(|_| std::f64::consts::PI * random.unit())),
        }
        for scale in RATE_BOUNDS {
            states.extend((0..n).map(|_| scale * random.unit()));
        }
        states.extend_from_slice(constants);
    }
    let mut values = vec![0.0; n_states * n * p];
    tape.evaluate_many(&states, &mut tape.workspace(), &mut values);
    DMatrix::from_row_slice(n_states * n, p, &values)
}
