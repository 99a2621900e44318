//! A function of a robot as a tape, evaluated at states, with one workspace per thread.

pub mod state_tape;
pub mod tape_regressor;
pub mod thread_tapes;
