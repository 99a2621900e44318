//! Tapes of one robot, with separate memory for each thread, so that several threads can evaluate them through a shared
//! reference.

use std::cell::RefCell;
use std::sync::atomic::{AtomicUsize, Ordering};

use expr::{Tape, Workspace};

/// Tapes that are evaluated together.
pub(crate) struct ThreadTapes {
    tapes: Vec<Tape>,
    /// Number of this set of tapes, by which a thread knows whether its memory belongs to this set.
    number: usize,
}

/// Number of sets of tapes made so far; the next set gets this number.
static MADE: AtomicUsize = AtomicUsize::new(0);

/// Memory for evaluating the set with this number.
struct Memory {
    number: usize,
    work: Vec<Workspace>,
    inputs: Vec<f64>,
}

thread_local! {
    /// Memory of the set that was evaluated last on this thread.
    static MEMORY: RefCell<Memory> = const { RefCell::new(Memory { number: usize::MAX, work: Vec::new(), inputs: Vec::new() }) };
}

impl ThreadTapes {
    /// Makes a set of these tapes, with a new number.
    pub(crate) fn new(tapes: Vec<Tape>) -> ThreadTapes {
        ThreadTapes { tapes, number: MADE.fetch_add(1, Ordering::Relaxed) }
    }

    /// Calls `run` with the tapes, this thread's workspace of each, and an empty list for their inputs.
    pub(crate) fn with<T>(&self, run: impl FnOnce(&[Tape], &mut [Workspace], &mut Vec<f64>) -> T) -> T {
        MEMORY.with_borrow_mut(|memory| {
            if memory.number != self.number {
                memory.work = self.tapes.iter().map(Tape::workspace).collect();
                memory.number = self.number;
            }
            memory.inputs.clear();
            run(&self.tapes, &mut memory.work, &mut memory.inputs)
        })
    }
}
