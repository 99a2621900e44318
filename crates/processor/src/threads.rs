//! Runs work on several threads. The results and their order do not depend on the threads.
//!
//! The code that runs the threads is not generic: it is compiled once and calls a `dyn Fn` with the number of an item. Generic
//! code took 18 % of the compiler's optimisation time for `experiments`.

use std::panic::resume_unwind;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, mpsc};

/// The number of threads that this processor runs at once; at least one.
pub fn threads() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// Calls `of` for each item on at most `threads` threads, the caller's thread included. The results are in the order of the
/// items.
pub fn in_parallel<T: Send, R: Send>(items: Vec<T>, threads: usize, of: impl Fn(T) -> R + Sync) -> Vec<R> {
    let items: Vec<Mutex<(Option<T>, Option<R>)>> =
        items.into_iter().map(|item| Mutex::new((Some(item), None))).collect();
    each(items.len(), threads, &|i| {
        if let Some(mut item) = items.get(i).and_then(|item| item.lock().ok()) {
            item.1 = item.0.take().map(&of);
        }
    });
    items.into_iter().filter_map(|item| item.into_inner().ok()?.1).collect()
}

/// Runs `work` on each item on at most `threads` threads. Calls `take` on the caller's thread with the results, in the order of
/// the items.
///
/// Stops at the first error of `take` and returns it.
pub fn in_order<T: Sync, R: Send, E>(
    items: &[T],
    threads: usize,
    work: impl Fn(usize, &T) -> R + Sync,
    mut take: impl FnMut(usize, R) -> Result<(), E>,
) -> Result<(), E> {
    let (results, mut outcome): (Vec<Mutex<Option<R>>>, _) = (items.iter().map(|_| Mutex::new(None)).collect(), Ok(()));
    let result = |i: usize| results.get(i).and_then(|result| result.lock().ok());
    let piece = |i: usize| {
        if let (Some(mut result), Some(item)) = (result(i), items.get(i)) {
            *result = Some(work(i, item));
        }
    };
    each_in_order(items.len(), threads, &piece, &mut |i| {
        if let Some(result) = result(i).and_then(|mut result| result.take()) {
            outcome = take(i, result);
        }
        outcome.is_ok()
    });
    outcome
}

/// Calls `piece(i)` for each i < `count`, on at most `threads` threads.
fn each(count: usize, threads: usize, piece: &(dyn Fn(usize) + Sync)) {
    let next = AtomicUsize::new(0);
    let work = || {
        // `Relaxed` is enough, because a thread is joined before its results are read.
        while let Some(i) = Some(next.fetch_add(1, Ordering::Relaxed)).filter(|i| *i < count) {
            piece(i);
        }
    };
    std::thread::scope(|scope| {
        let others: Vec<_> = (1..threads.min(count)).map(|_| scope.spawn(work)).collect();
        work();
        others.into_iter().for_each(|thread| thread.join().unwrap_or_else(|panic| resume_unwind(panic)));
    });
}

/// Calls `piece(i)` for each i < `count` on several threads, and `take(i)` on the caller's thread in the order of i, until `take`
/// returns false.
fn each_in_order(count: usize, threads: usize, piece: &(dyn Fn(usize) + Sync), take: &mut dyn FnMut(usize) -> bool) {
    let threads = threads.min(count);
    if threads < 2 {
        let _ = (0..count).all(|i| {
            piece(i);
            take(i)
        });
        return;
    }
    let next = AtomicUsize::new(0);
    let (send, receive) = mpsc::channel();
    std::thread::scope(|scope| {
        for send in vec![send; threads] {
            let next = &next;
            scope.spawn(move || {
                while let Some(i) = Some(next.fetch_add(1, Ordering::Relaxed)).filter(|i| *i < count) {
                    piece(i);
                    // Sending fails after `take` returned false, because the receiver is dropped.
                    if send.send(i).is_err() {
                        break;
                    }
                }
            });
        }
        // Threads finish in any order, so results wait here until all earlier ones were passed to `take`.
        let (mut is_done, mut at) = (vec![false; count], 0);
        for i in receive {
            is_done[i] = true;
            while is_done.get(at) == Some(&true) {
                if !take(at) {
                    return;
                }
                at += 1;
            }
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_stand_in_the_order_of_the_items() {
        for threads in [0, 1, 3] {
            let squares: Vec<usize> = (0..50).map(|i| i * i).collect();
            assert_eq!(in_parallel((0..50).collect(), threads, |i: usize| i * i), squares);
        }
    }

    #[test]
    fn results_come_in_order_on_any_number_of_threads() {
        let items: Vec<u64> = (0..200).collect();
        // The items need very different times.
        let work = |i: usize, x: &u64| (0..(x * 7919) % 20_000).fold(i as u64, |s, k| s.wrapping_mul(31) ^ k);
        let of = |threads| {
            let mut found = Vec::new();
            let done: Result<(), ()> = in_order(&items, threads, work, |i, r| {
                assert_eq!(i, found.len());
                found.push(r);
                Ok(())
            });
            done.unwrap();
            found
        };
        let alone = of(1);
        assert_eq!(alone.len(), 200);
        for threads in [0, 2, 3, 16] {
            assert_eq!(of(threads), alone);
        }
    }

    #[test]
    fn the_first_error_ends_it() {
        for threads in [1, 4] {
            let mut taken = 0;
            let take = |i, _| {
                taken += 1;
                if i < 5 { Ok(()) } else { Err(i) }
            };
            assert_eq!(in_order(&[0; 100], threads, |_, x| *x, take), Err(5));
            assert_eq!(taken, 6);
        }
    }

    #[test]
    fn a_panic_goes_on_in_the_caller() {
        for threads in [1, 3] {
            let broken = |i: usize| assert_ne!(i, 7, "seven");
            let panics = |run: &dyn Fn()| std::panic::catch_unwind(std::panic::AssertUnwindSafe(run)).is_err();
            assert!(panics(&|| drop(in_parallel((0..20).collect(), threads, broken))));
            assert!(panics(&|| in_order(&[0; 20], threads, |i, _| broken(i), |_, ()| Ok::<(), ()>(())).unwrap()));
        }
    }
}
