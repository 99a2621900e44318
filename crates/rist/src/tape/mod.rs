//! Evaluates functions of a robot by tapes (lists of arithmetic operations), with one workspace per thread.

pub(crate) mod state_tape;
pub(crate) mod tape_regressor;
pub(crate) mod thread_tapes;
