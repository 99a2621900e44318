//! Independent pieces of work shared among threads, their results taken in order.
//!
//! Which thread does a piece, and when, changes neither a result nor the order in which results are taken.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;

/// The result of `work` on each item, on as many threads as the processor has, handed to `take` in the order of the items.
///
/// Ends with the first error of `take`.
pub fn in_order<I: Sync, R: Send, E>(
    items: &[I],
    work: impl Fn(usize, &I) -> R + Sync,
    take: impl FnMut(usize, R) -> Result<(), E>,
) -> Result<(), E> {
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    on_threads(threads, items, work, take)
}

/// The same on at most so many threads.
pub fn on_threads<I: Sync, R: Send, E>(
    threads: usize,
    items: &[I],
    work: impl Fn(usize, &I) -> R + Sync,
    mut take: impl FnMut(usize, R) -> Result<(), E>,
) -> Result<(), E> {
    let threads = threads.min(items.len());
    if threads < 2 {
        return items.iter().enumerate().try_for_each(|(i, item)| take(i, work(i, item)));
    }
    let (next, work) = (AtomicUsize::new(0), &work);
    let next = &next;
    std::thread::scope(|scope| {
        let (send, receive) = mpsc::channel();
        for _ in 0..threads {
            let send = send.clone();
            scope.spawn(move || {
                loop {
                    let i = next.fetch_add(1, Ordering::Relaxed);
                    let Some(item) = items.get(i) else { break };
                    // Nobody listens any more after an error.
                    if send.send((i, work(i, item))).is_err() {
                        break;
                    }
                }
            });
        }
        drop(send);
        let (mut early, mut at) = (BTreeMap::new(), 0);
        for (i, result) in receive {
            early.insert(i, result);
            while let Some(result) = early.remove(&at) {
                take(at, result)?;
                at += 1;
            }
        }
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_come_in_order_on_any_number_of_threads() {
        let items: Vec<u64> = (0..200).collect();
        // Pieces of very different length.
        let work = |i: usize, x: &u64| (0..(x * 7919) % 20_000).fold(i as u64, |s, k| s.wrapping_mul(31) ^ k);
        let of = |threads| {
            let mut found = Vec::new();
            let done: Result<(), ()> = on_threads(threads, &items, work, |i, r| {
                assert_eq!(i, found.len());
                found.push(r);
                Ok(())
            });
            done.unwrap();
            found
        };
        let alone = of(1);
        assert_eq!(alone.len(), 200);
        for threads in [2, 3, 16] {
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
            assert_eq!(on_threads(threads, &[0; 100], |_, x| *x, take), Err(5));
            assert_eq!(taken, 6);
        }
    }
}
