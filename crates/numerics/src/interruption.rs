//! A flag that ends long work early. The caller that waits for the work raises the flag, and the work checks the flag between
//! its steps.
//!
//! Functions do not take the flag as an argument. [`Interruption::during`] sets the flag of the current thread, and work that
//! starts its own threads passes the flag on with [`Interruption::here`]. A thread without a flag uses a default flag, which is
//! never raised. No result of complete work depends on the flag.

use std::cell::RefCell;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use crate::error::Error;

/// A flag with which a caller stops work early. All clones share one flag.
#[derive(Clone, Debug, Default)]
pub struct Interruption(Arc<AtomicBool>);

thread_local! {
    /// The flag of the work in this thread.
    static FLAG_OF_THIS_THREAD: RefCell<Interruption> = RefCell::default();
}

impl Interruption {
    /// Raises the flag: the work ends at its next check.
    pub fn raise(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Raises the flag after `delay`.
    pub fn raise_within(&self, delay: Duration) {
        let flag = self.clone();
        std::thread::spawn(move || {
            std::thread::sleep(delay);
            flag.raise();
        });
    }

    /// Whether the flag is raised.
    #[inline]
    pub fn is_raised(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    /// The flag as an atomic, for code that raises it from outside, such as a signal handler.
    pub fn flag(&self) -> Arc<AtomicBool> {
        Arc::clone(&self.0)
    }

    /// Lowers the flag of this thread, and returns whether it was raised. The caller can then end its work and return the
    /// result so far.
    pub fn take() -> bool {
        FLAG_OF_THIS_THREAD.with_borrow(|here| here.0.swap(false, Ordering::Relaxed))
    }

    /// Runs `work` in this thread and returns its result. Raising `self` can end the work early.
    pub fn during<T>(&self, work: impl FnOnce() -> T) -> T {
        let before = FLAG_OF_THIS_THREAD.replace(self.clone());
        let outcome = work();
        FLAG_OF_THIS_THREAD.set(before);
        outcome
    }

    /// The flag of the work in this thread.
    pub fn here() -> Interruption {
        FLAG_OF_THIS_THREAD.with_borrow(Clone::clone)
    }

    /// Fails if the flag of the work in this thread is raised.
    pub fn check() -> Result<(), Error> {
        match FLAG_OF_THIS_THREAD.with_borrow(Interruption::is_raised) {
            true => Err(Error::new("interrupted before there was a result")),
            false => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flag_reaches_its_own_work_alone() {
        let (flag, other) = (Interruption::default(), Interruption::default());
        flag.raise();
        assert!(flag.during(|| Interruption::check().is_err() && other.during(|| Interruption::check().is_ok())));
        assert!(Interruption::check().is_ok());
        let taken = flag.during(Interruption::here);
        assert!(std::thread::spawn(move || taken.during(Interruption::check)).join().unwrap().is_err());
        assert!(flag.during(|| Interruption::take() && !Interruption::take()) && !flag.is_raised());
    }
}
