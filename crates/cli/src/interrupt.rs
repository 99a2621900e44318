//! Handles Ctrl-C. The first Ctrl-C ends a search with the best result of the search; the second Ctrl-C ends the program. A
//! file that is being written is completed first.
//!
//! `interruptible` runs a search that the first Ctrl-C may end. `undivided` runs work that no signal interrupts, such as
//! writing a file.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, LazyLock};

use rist::motion::exciting::Interruption;
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag::{register, register_conditional_shutdown, register_usize};
use signal_hook::low_level::emulate_default_handler;

use crate::failure::Failure;

/// Exit codes after SIGINT and SIGTERM, by the convention of shells.
const INTERRUPTED: i32 = 130;
const TERMINATED: i32 = 143;

/// Runs work that a first Ctrl-C ends early. The work then returns its best result so far.
pub(crate) fn interruptible<T>(work: impl FnOnce() -> T) -> Result<T, Failure> {
    let interruption = Interruption::default();
    let flag = interruption.flag();
    // The handler that ends the program must be registered before the handler that sets the flag. At the first Ctrl-C it runs
    // first, finds the flag unset and does nothing; at the second Ctrl-C it finds the flag set and ends the program.
    register_conditional_shutdown(SIGINT, INTERRUPTED, flag.clone())
        .and_then(|_| register(SIGINT, flag.clone()))
        .map_err(|e| Failure::new(format_args!("Ctrl-C cannot be waited for: {e}")))?;
    let outcome = interruption.during(work);
    // After the work, the first Ctrl-C ends the program again, but only when `undivided` allows it.
    flag.store(false, Ordering::Relaxed);
    Ok(outcome)
}

/// `at_once`: whether a signal may end the program now. `asked`: the number of a signal that came while the program could not
/// end; 0 if none came.
struct Ending {
    at_once: Arc<AtomicBool>,
    asked: Arc<AtomicUsize>,
}

/// The signal handlers. They are registered at the first call of [`undivided`]; before that, signals have their default effect.
static ENDING: LazyLock<Ending> = LazyLock::new(|| {
    let (at_once, asked) = (Arc::new(AtomicBool::new(true)), Arc::new(AtomicUsize::new(0)));
    for (signal, code) in [(SIGINT, INTERRUPTED), (SIGTERM, TERMINATED)] {
        // If a handler cannot be registered, the signal keeps its default effect.
        let _ = register_conditional_shutdown(signal, code, at_once.clone())
            .and_then(|_| register_usize(signal, asked.clone(), signal as usize));
    }
    Ending { at_once, asked }
});

/// Runs work that Ctrl-C and SIGTERM do not interrupt. If such a signal comes during the work, the program ends after the work.
pub(crate) fn undivided<T>(work: impl FnOnce() -> T) -> T {
    ENDING.at_once.store(false, Ordering::SeqCst);
    let outcome = work();
    ENDING.at_once.store(true, Ordering::SeqCst);
    if let Ok(signal @ 1..) = i32::try_from(ENDING.asked.load(Ordering::SeqCst)) {
        // The default handler of the signal ends the program.
        let _ = emulate_default_handler(signal);
    }
    outcome
}
