//! Runs long work without the interpreter lock, with progress reports. Ctrl-C ends the work.
//!
//! The library works on a thread of its own. The calling thread waits, passes progress to the callback, and checks for signals.
//! A panic becomes a Python exception. A signal or an exception sets a flag, which the work checks from time to time.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::time::Duration;

use pyo3::prelude::*;
use rist::motion::exciting::Interruption;

use crate::error::{OrError, error};

/// Time between two checks for signals.
const SIGNAL_CHECK_INTERVAL: Duration = Duration::from_millis(50);

/// Stack size of the worker thread, equal to that of a main thread, because derivations are recursive.
const WORKER_STACK_BYTES: usize = 8 << 20;

/// Progress of the work: number of finished steps, number of all steps, and a text on the best result so far.
pub struct Progress {
    done: usize,
    all: usize,
    text: String,
}

/// The channel through which the work reports its progress.
pub struct Reporter(Sender<Progress>);

impl Reporter {
    /// Reports the progress. It is ignored if nobody receives it.
    pub fn tell(&self, done: usize, all: usize, text: &str) {
        let _ = self.0.send(Progress { done, all, text: text.into() });
    }
}

/// Runs the work, and reports its progress by `callback(done, all, text)`. An exception in the callback ends the work, like a
/// signal.
pub fn work<T: Send>(
    py: Python<'_>,
    callback: Option<&Bound<'_, PyAny>>,
    task: impl FnOnce(&Reporter) -> Result<T, rist::Error> + Send,
) -> PyResult<T> {
    let (interruption, (send, mut receive)) = (Interruption::default(), channel());
    std::thread::scope(|scope| {
        let flag = interruption.clone();
        let of_task = move || flag.during(|| task(&Reporter(send)));
        let thread = std::thread::Builder::new().stack_size(WORKER_STACK_BYTES).spawn_scoped(scope, of_task)?;
        let mut raised = Ok(());
        loop {
            let message;
            (receive, message) = py.detach(move || {
                let message = receive.recv_timeout(SIGNAL_CHECK_INTERVAL);
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
            // The interruption flag is raised again at each check, because the end of a search lowers it. Otherwise the work
            // would continue with the best result of the search.
            if raised.is_err() {
                interruption.raise();
            }
        }
        let outcome = py.detach(move || thread.join());
        raised?;
        match outcome {
            Ok(outcome) => outcome.or_error(),
            Err(panic) => Err(defect(panic.as_ref())),
        }
    })
}

/// Runs the work on the calling thread, without the interpreter lock.
pub fn alone<T: Send>(py: Python<'_>, task: impl FnOnce() -> T + Send) -> PyResult<T> {
    py.detach(|| catch_unwind(AssertUnwindSafe(task)).map_err(|panic| defect(panic.as_ref())))
}

/// Converts a panic to `rist.Error`. `except Exception` would not catch PanicException.
fn defect(panic: &(dyn Any + Send)) -> PyErr {
    let text = panic.downcast_ref::<&str>().map(ToString::to_string);
    let text = text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or("without a message".into());
    error(format_args!("a defect of rist, please report it with its input: {text}"))
}
