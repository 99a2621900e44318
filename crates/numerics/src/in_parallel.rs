//! Work shared by threads, of which the result does not depend on their number.

use std::sync::Mutex;

/// What `of` makes of each item, in their order, by so many threads.
pub fn in_parallel<T: Send, R: Send>(items: Vec<T>, threads: usize, of: impl Fn(T) -> R + Sync) -> Vec<R> {
    if threads <= 1 || items.len() <= 1 {
        return items.into_iter().map(of).collect();
    }
    let next = Mutex::new(items.into_iter().enumerate());
    let work = || {
        let mut done = Vec::new();
        loop {
            let item = next.lock().ok().and_then(|mut next| next.next());
            let Some((at, item)) = item else { return done };
            done.push((at, of(item)));
        }
    };
    let mut all: Vec<(usize, R)> = std::thread::scope(|scope| {
        let others: Vec<_> = (1..threads).map(|_| scope.spawn(work)).collect();
        let mut all = work();
        all.extend(others.into_iter().flat_map(|t| t.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))));
        all
    });
    all.sort_by_key(|(at, _)| *at);
    all.into_iter().map(|(_, result)| result).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_stand_in_the_order_of_the_items() {
        for threads in [0, 1, 3] {
            assert_eq!(
                in_parallel((0..50).collect(), threads, |i: usize| i * i),
                (0..50).map(|i| i * i).collect::<Vec<_>>()
            );
        }
    }
}
