//! What ends the program: Ctrl-C while a search is on ends it with the best that it has, and pressed again the program. A file that
//! is being written is written whole before the program ends.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, LazyLock};

use rist::motion::exciting::Interruption;
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag::{register, register_conditional_shutdown, register_usize};
use signal_hook::low_level::emulate_default_handler;

use crate::failure::Failure;

/// What a shell says of a program that Ctrl-C ended, and of one that was told to end.
const INTERRUPTED: i32 = 130;
const TERMINATED: i32 = 143;

/// Does work that the first Ctrl-C ends early.
pub(crate) fn interruptible<T>(work: impl FnOnce() -> T) -> Result<T, Failure> {
    let interruption = Interruption::default();
    let flag = interruption.flag();
    // The handler of the second comes first, and sees whether there was one before.
    register_conditional_shutdown(SIGINT, INTERRUPTED, flag.clone())
        .and_then(|_| register(SIGINT, flag.clone()))
        .map_err(|e| Failure::new(format_args!("Ctrl-C cannot be waited for: {e}")))?;
    let outcome = interruption.during(work);
    // Behind the search, what is undivided decides when the program ends.
    flag.store(false, Ordering::Relaxed);
    Ok(outcome)
}

/// Whether the program may end at once, and the signal that came while it might not.
struct Ending {
    at_once: Arc<AtomicBool>,
    asked: Arc<AtomicUsize>,
}

/// Heeds signals from the first undivided work on; before that they end the program as they do any other.
static ENDING: LazyLock<Ending> = LazyLock::new(|| {
    let (at_once, asked) = (Arc::new(AtomicBool::new(true)), Arc::new(AtomicUsize::new(0)));
    for (signal, code) in [(SIGINT, INTERRUPTED), (SIGTERM, TERMINATED)] {
        // Where a signal cannot be waited for, it ends the program as before.
        let _ = register_conditional_shutdown(signal, code, at_once.clone())
            .and_then(|_| register_usize(signal, asked.clone(), signal as usize));
    }
    Ending { at_once, asked }
});

/// Does work that Ctrl-C and SIGTERM do not cut in two: the program ends behind it.
pub(crate) fn undivided<T>(work: impl FnOnce() -> T) -> T {
    ENDING.at_once.store(false, Ordering::SeqCst);
    let outcome = work();
    ENDING.at_once.store(true, Ordering::SeqCst);
    if let Ok(signal @ 1..) = i32::try_from(ENDING.asked.load(Ordering::SeqCst)) {
        // It does not come back.
        let _ = emulate_default_handler(signal);
    }
    outcome
}
