//! Tapes of one robot with their memory on each thread, so that many threads evaluate them through a shared reference.

use std::cell::RefCell;
use std::sync::atomic::{AtomicUsize, Ordering};

use expr::{Tape, Workspace};

/// N tapes that are evaluated together.
pub struct ThreadTapes<const N: usize> {
    tapes: [Tape; N],
    /// Tells their memory from that of others on the same thread.
    number: usize,
}

/// A tape with the memory of one thread.
pub struct OnThread<'a> {
    tape: &'a Tape,
    work: &'a mut Workspace,
}

impl OnThread<'_> {
    /// One evaluation: all inputs one after the other -> all outputs one after the other.
    pub fn evaluate(&mut self, inputs: &[f64], outputs: &mut [f64]) {
        self.tape.evaluate(inputs, self.work, outputs);
    }

    /// As many evaluations as there are inputs, samples one after the other.
    pub fn evaluate_many(&mut self, inputs: &[f64], outputs: &mut [f64]) {
        self.tape.evaluate_many(inputs, self.work, outputs);
    }
}

/// Sets of tapes made so far.
static MADE: AtomicUsize = AtomicUsize::new(0);

/// Memory of the set with this number.
struct Memory {
    number: usize,
    work: Vec<Workspace>,
    inputs: Vec<f64>,
}

thread_local! {
    /// That of the set last evaluated on this thread.
    static MEMORY: RefCell<Memory> = const { RefCell::new(Memory { number: usize::MAX, work: Vec::new(), inputs: Vec::new() }) };
}

impl<const N: usize> ThreadTapes<N> {
    /// Gives them a number of their own.
    pub fn new(tapes: [Tape; N]) -> ThreadTapes<N> {
        ThreadTapes { tapes, number: MADE.fetch_add(1, Ordering::Relaxed) }
    }

    /// The tapes, in order.
    pub fn tapes(&self) -> &[Tape; N] {
        &self.tapes
    }

    /// Hands out the tapes with this thread's memory, and an empty list for their inputs.
    pub fn with<T>(&self, run: impl FnOnce([OnThread; N], &mut Vec<f64>) -> T) -> T {
        MEMORY.with_borrow_mut(|memory| {
            if memory.number != self.number {
                memory.work = self.tapes.iter().map(Tape::workspace).collect();
                memory.number = self.number;
            }
            memory.inputs.clear();
            let mut work = memory.work.iter_mut();
            let on_thread = self.tapes.each_ref().map(|tape| OnThread { tape, work: work.next().expect("one a tape") });
            run(on_thread, &mut memory.inputs)
        })
    }
}
