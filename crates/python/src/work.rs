//! Long work without the interpreter lock: it tells how far it is, and Ctrl-C ends it.
//!
//! The library works on a thread of its own. The caller's thread waits, hands progress to the callback, and looks for
//! signals; what it finds raises the flag that the work looks at between its parts.

use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::time::Duration;

use pyo3::prelude::*;
use rist::exciting::Interruption;

use crate::error::OrError;

/// Between two looks for signals.
const PATIENCE: Duration = Duration::from_millis(50);

/// Derivations recurse: the thread gets what a main thread has.
const STACK: usize = 8 << 20;

/// How far the work is: parts done, parts in all, and what is best so far, in words.
pub struct Progress {
    done: usize,
    all: usize,
    text: String,
}

/// Where the work says how far it is.
pub struct Reporter(Sender<Progress>);

impl Reporter {
    /// Nobody may listen any more.
    pub fn tell(&self, done: usize, all: usize, text: &str) {
        let _ = self.0.send(Progress { done, all, text: text.into() });
    }
}

/// Does the work; `callback(done, all, text)` is told how far it is. What the callback raises ends the work, as a signal
/// does.
pub fn work<T: Send>(
    py: Python<'_>,
    callback: Option<&Bound<'_, PyAny>>,
    task: impl FnOnce(&Reporter) -> Result<T, rist::Error> + Send,
) -> PyResult<T> {
    let (interruption, (send, mut receive)) = (Interruption::default(), channel());
    std::thread::scope(|scope| {
        let flag = interruption.clone();
        let of_task = move || flag.during(|| task(&Reporter(send)));
        let thread = std::thread::Builder::new().stack_size(STACK).spawn_scoped(scope, of_task)?;
        let mut raised = Ok(());
        loop {
            let message;
            (receive, message) = py.detach(move || {
                let message = receive.recv_timeout(PATIENCE);
                (receive, message)
            });
            let looked = match message {
                Err(RecvTimeoutError::Disconnected) => break,
                Err(RecvTimeoutError::Timeout) => py.check_signals(),
                Ok(Progress { done, all, text }) => py.check_signals().and_then(|()| match callback {
                    Some(callback) => callback.call1((done, all, text)).map(drop),
                    None => Ok(()),
                }),
            };
            if raised.is_ok() {
                raised = looked;
            }
            // Again and again: a search that is ended would make something of what it has.
            if raised.is_err() {
                interruption.raise();
            }
        }
        let outcome = py.detach(move || thread.join());
        raised?;
        match outcome {
            Ok(outcome) => outcome.or_error(),
            Err(panic) => std::panic::resume_unwind(panic),
        }
    })
}
