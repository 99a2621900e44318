//! Tapes of one robot that several threads evaluate at the same time. Each thread has its own memory.
//!
//! A tape is a list of arithmetic operations; it needs a workspace for intermediate results. The memory of a thread keeps the
//! workspaces of the set of tapes that this thread evaluated last.

use std::cell::RefCell;
use std::sync::atomic::{AtomicUsize, Ordering};

use expr::{Tape, Workspace};

/// A set of tapes (lists of arithmetic operations) that are evaluated together.
pub(crate) struct ThreadTapes {
    tapes: Vec<Tape>,
    /// Number of this set of tapes. The memory of a thread stores the number of the set to which the memory belongs. The two
    /// numbers are compared before the memory is used.
    number: usize,
}

/// Number of sets made so far, which is the number of the next set.
static MADE: AtomicUsize = AtomicUsize::new(0);

/// Memory of one thread for evaluating the set with the number `number`.
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
    /// Makes a set of tapes with a new number.
    pub(crate) fn new(tapes: Vec<Tape>) -> ThreadTapes {
        ThreadTapes { tapes, number: MADE.fetch_add(1, Ordering::Relaxed) }
    }

    /// Calls `run` with the tapes, this thread's workspace for each tape, and an empty list for the inputs.
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
