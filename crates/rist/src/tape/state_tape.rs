//! Evaluates a function of a robot's state by a tape (a list of arithmetic operations). If the loops of the robot are closed
//! numerically, the passive joints are solved for too.
//!
//! A state has q, dq and ddq. A lane is one of the numbers that a SIMD instruction processes at once; here, each lane is one
//! state.

use std::sync::{Mutex, PoisonError};

use expr::{Function, LaneOutputs, Tape, Workspace};
use modeling::Closure;

use crate::tape::thread_tapes::ThreadTapes;

/// A function f(q, passive joints, dq, ddq, X, others) as a tape (a list of arithmetic operations). A function need not have all
/// of these arguments.
pub(crate) struct StateTape {
    tapes: ThreadTapes,
    /// The arguments of the function, in order.
    pub(crate) arguments: Vec<StateArgument>,
    closure: Option<Mutex<Closure>>,
}

/// An argument of the function.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum StateArgument {
    /// Positions q, rad (m).
    Q,
    /// Positions of passive joints, rad (m). The number is the count of passive joints.
    Passive(usize),
    /// Velocities dq, rad/s (m/s).
    Dq,
    /// Accelerations ddq, rad/s^2 (m/s^2).
    Ddq,
    /// Base parameters X. The number is the count of base parameters.
    Parameters(usize),
    /// Another argument, for example torques or a wrench: its name, and its number of entries per state.
    Other(String, usize),
}

impl StateTape {
    /// Makes the tape of a function. `closure`: the solver for passive joints, which is required if the function depends on
    /// passive joints.
    pub(crate) fn new(function: &Function, closure: Option<Closure>) -> StateTape {
        let argument = |input: &expr::Input| match input.name.as_str() {
            "q" => StateArgument::Q,
            "dq" => StateArgument::Dq,
            "ddq" => StateArgument::Ddq,
            "x" => StateArgument::Parameters(input.entries.len()),
            "passive" => StateArgument::Passive(input.entries.len()),
            name => StateArgument::Other(name.into(), input.entries.len()),
        };
        let arguments: Vec<StateArgument> = function.inputs.iter().map(argument).collect();
        let has_passive = arguments.iter().any(|a| matches!(a, StateArgument::Passive(k) if *k > 0));
        StateTape {
            tapes: ThreadTapes::new(vec![Tape::new(function)]),
            arguments,
            closure: closure.filter(|_| has_passive).map(Mutex::new),
        }
    }

    /// Writes the outputs of all states into `outputs`, one state after the other. Arguments that the function does not need may
    /// be empty. `others`: the arguments of type [`StateArgument::Other`] in the order of `arguments`, each with one row per
    /// state.
    ///
    /// The outputs are NaN for a state where the loops do not close.
    pub(crate) fn fill<'a>(
        &self,
        states: impl Iterator<Item = [&'a [f64]; 3]>,
        parameters: &[f64],
        others: &[&[f64]],
        outputs: &mut [f64],
    ) {
        self.with_inputs(states, parameters, others, |tape, work, Inputs { inputs, count, open }| {
            tape.evaluate_many(inputs, work, outputs);
            let size = outputs.len() / count.max(1);
            open.iter().for_each(|k| outputs[k * size..][..size].fill(f64::NAN));
        });
    }

    /// Computes the outputs with the indices `wanted` at many states, in SIMD lanes (one state per lane). `states`: q, dq, ddq
    /// with n numbers each, state by state. `take(g, e, values)` gets the output `wanted[e]` at the states from index g x
    /// `Tape::LANES` on, one value per lane. In the last group, unused lanes repeat the last state.
    ///
    /// The outputs are NaN for a state where the loops do not close.
    pub(crate) fn lanes(
        &self,
        states: &[f64],
        n: usize,
        wanted: &[usize],
        mut take: impl FnMut(usize, usize, [f64; Tape::LANES]),
    ) {
        let mut take_all = |g: usize, outputs: LaneOutputs, open: &[usize]| {
            for (e, k) in wanted.iter().enumerate() {
                let mut values = outputs.of(*k);
                open.iter().filter(|r| *r / Tape::LANES == g).for_each(|r| values[r % Tape::LANES] = f64::NAN);
                take(g, e, values);
            }
        };
        if self.arguments == [StateArgument::Q, StateArgument::Dq, StateArgument::Ddq] {
            let (count, take) = (states.len() / (3 * n), &mut |g, outputs: LaneOutputs| take_all(g, outputs, &[]));
            return self.tapes.with(|tapes, work, _| tapes[0].evaluate_lanes(states, count, &mut work[0], take));
        }
        let states = states.chunks_exact(3 * n).map(|s| [&s[..n], &s[n..2 * n], &s[2 * n..]]);
        self.with_inputs(states, &[], &[], |tape, work, Inputs { inputs, count, open }| {
            tape.evaluate_lanes(inputs, count, work, &mut |g, outputs| take_all(g, outputs, open));
        });
    }

    /// Calls `run` with the tape, the workspace of the tape, and the inputs of the tape at all states.
    fn with_inputs<'a>(
        &self,
        states: impl Iterator<Item = [&'a [f64]; 3]>,
        parameters: &[f64],
        others: &[&[f64]],
        run: impl FnOnce(&Tape, &mut Workspace, Inputs),
    ) {
        let mut closure = self.closure.as_ref().map(|c| c.lock().unwrap_or_else(PoisonError::into_inner));
        let (mut count, mut open) = (0, Vec::new());
        self.tapes.with(|tapes, work, inputs| {
            // The inputs of each state are in the order of the function's arguments.
            for [q, dq, ddq] in states {
                let mut others = others.iter();
                for argument in &self.arguments {
                    match argument {
                        StateArgument::Q => inputs.extend(q),
                        StateArgument::Dq => inputs.extend(dq),
                        StateArgument::Ddq => inputs.extend(ddq),
                        StateArgument::Parameters(_) => inputs.extend(parameters),
                        StateArgument::Other(_, width) => {
                            let all = others.next().copied().unwrap_or_default();
                            inputs.extend(&all[count * width..][..*width]);
                        }
                        StateArgument::Passive(n) => match closure.as_mut().map(|closure| closure.passive(q)) {
                            Some(Ok(passive)) => inputs.extend(passive),
                            // If the loops do not close at a state, the index of this state is stored in `open`, and the
                            // passive joints are set to zero.
                            Some(Err(_)) => {
                                open.push(count);
                                inputs.extend(std::iter::repeat_n(0.0, *n));
                            }
                            None => {}
                        },
                    }
                }
                count += 1;
            }
            run(&tapes[0], &mut work[0], Inputs { inputs, count, open: &open });
        });
    }
}

/// The inputs of the function at many states.
struct Inputs<'a> {
    /// The inputs, state by state.
    inputs: &'a [f64],
    /// Number of states.
    count: usize,
    /// Indices of the states where loops do not close. The passive joints of these states are set to zero.
    open: &'a [usize],
}
