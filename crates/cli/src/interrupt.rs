//! Ctrl-C while a search is on: it ends with the best that it has; pressed again, the program ends.

use rist::exciting::Interruption;
use signal_hook::consts::SIGINT;
use signal_hook::flag::{register, register_conditional_shutdown};

use crate::failure::Failure;

/// What a shell says of a program that Ctrl-C ended.
const INTERRUPTED: i32 = 130;

/// Does work that the first Ctrl-C ends early.
pub(crate) fn interruptible<T>(work: impl FnOnce() -> T) -> Result<T, Failure> {
    let interruption = Interruption::default();
    let flag = interruption.flag();
    // The handler of the second comes first, and sees whether there was one before.
    register_conditional_shutdown(SIGINT, INTERRUPTED, flag.clone())
        .and_then(|_| register(SIGINT, flag))
        .map_err(|e| Failure::new(format_args!("Ctrl-C cannot be waited for: {e}")))?;
    Ok(interruption.during(work))
}
