//! A base regressor evaluated by tape: any robot, no compiler.

use std::cell::RefCell;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use expr::{Function, Tape, Workspace};
use identification::model::parameter::BaseParameter;
use identification::model::regressor::{Coordinate, Regressor};
use modeling::Closure;

/// tau = Y(q, dq, ddq) X by interpreting the function of Y.
pub struct TapeRegressor {
    tape: Tape,
    /// Tells this tape's workspace from another's on the same thread.
    number: usize,
    /// Where loops are closed numerically, the solver.
    closure: Option<Mutex<Closure>>,
    coordinates: Vec<String>,
    prismatic: Vec<bool>,
    parameters: Vec<BaseParameter>,
    non_zeros: Vec<(usize, usize)>,
}

/// Tapes made so far.
static TAPES: AtomicUsize = AtomicUsize::new(0);

thread_local! {
    /// Number, workspace and inputs of the tape last evaluated on this thread.
    static SCRATCH: RefCell<Option<(usize, Workspace, Vec<f64>)>> = const { RefCell::new(None) };
}

impl TapeRegressor {
    /// The function of Y, with the solver of its passive joints where it has some.
    pub fn new(
        base: &Function,
        closure: Option<Closure>,
        coordinates: Vec<Coordinate>,
        parameters: Vec<BaseParameter>,
    ) -> TapeRegressor {
        TapeRegressor {
            tape: Tape::new(base),
            number: TAPES.fetch_add(1, Ordering::Relaxed),
            closure: closure.map(Mutex::new),
            prismatic: coordinates.iter().map(|c| c.is_prismatic).collect(),
            coordinates: coordinates.into_iter().map(|c| c.name).collect(),
            parameters,
            non_zeros: base.non_zeros(0),
        }
    }
}

impl Regressor for TapeRegressor {
    fn coordinates(&self) -> &[String] {
        &self.coordinates
    }

    fn parameters(&self) -> &[BaseParameter] {
        &self.parameters
    }

    fn is_prismatic(&self, k: usize) -> bool {
        self.prismatic[k]
    }

    fn non_zeros(&self) -> Vec<(usize, usize)> {
        self.non_zeros.clone()
    }

    fn fill(&self, q: &[f64], dq: &[f64], ddq: &[f64], y: &mut [f64]) {
        let passive = match &self.closure {
            None => Vec::new(),
            Some(closure) => {
                let mut closure = closure.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
                match closure.passive(q) {
                    Ok(passive) => passive,
                    // No torque is known where the loops do not close: not a number, which is refused later.
                    Err(_) => return y.fill(f64::NAN),
                }
            }
        };
        SCRATCH.with_borrow_mut(|scratch| {
            let fresh = || (self.number, self.tape.workspace(), Vec::new());
            if scratch.as_ref().is_none_or(|s| s.0 != self.number) {
                *scratch = Some(fresh());
            }
            let (_, work, inputs) = scratch.get_or_insert_with(fresh);
            inputs.clear();
            inputs.extend(q.iter().chain(&passive).chain(dq).chain(ddq));
            self.tape.evaluate(inputs, work, y);
        });
    }
}
