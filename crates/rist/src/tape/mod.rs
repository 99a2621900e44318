//! A function of a robot as a tape, evaluated at states, with one workspace per thread.

pub(crate) mod state_tape;
pub(crate) mod tape_regressor;
pub(crate) mod thread_tapes;
