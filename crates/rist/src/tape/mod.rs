//! Evaluates a function of a robot at states, as a tape with one workspace per thread.

pub(crate) mod state_tape;
pub(crate) mod tape_regressor;
pub(crate) mod thread_tapes;
