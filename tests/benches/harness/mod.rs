//! Times of alternatives, side by side: what one machine says of another run is worth little.
//!
//! The alternatives take turns; of each turn's repetitions the median counts, and of the medians the
//! best: other programs on the machine can only slow a turn down, and seldom all of them.

use std::hint::black_box;
use std::time::{Duration, Instant};

const TURNS: usize = 15;
const REPETITIONS: usize = 9;
/// A repetition lasts at least about this long, so that the clock's own time does not count.
const REPETITION: Duration = Duration::from_micros(300);
/// What takes longer than this gets one turn.
const LONG: Duration = Duration::from_millis(50);

/// One way to do `units` units of work.
pub struct Alternative<'a> {
    name: &'a str,
    units: usize,
    work: Box<dyn FnMut() + 'a>,
}

pub fn alternative<'a, T>(name: &'a str, units: usize, mut work: impl FnMut() -> T + 'a) -> Alternative<'a> {
    Alternative { name, units, work: Box::new(move || drop(black_box(work()))) }
}

/// Prints ns a unit of each alternative, and how many times faster it is than the first.
pub fn compare(title: &str, mut alternatives: Vec<Alternative>) {
    let once: Vec<f64> = alternatives
        .iter_mut()
        .map(|a| {
            (a.work)();
            time(1, &mut a.work).max(1e-9)
        })
        .collect();
    let calls: Vec<u32> = once.iter().map(|once| (REPETITION.as_secs_f64() / once).ceil() as u32).collect();
    let long = once.iter().any(|once| *once > LONG.as_secs_f64());
    let mut best = vec![f64::INFINITY; alternatives.len()];
    for _ in 0..if long { 1 } else { TURNS } {
        for (k, a) in alternatives.iter_mut().enumerate() {
            let mut seconds: [f64; REPETITIONS] = std::array::from_fn(|_| time(calls[k], &mut a.work));
            seconds.sort_by(f64::total_cmp);
            best[k] = best[k].min(seconds[REPETITIONS / 2] / f64::from(calls[k]) / a.units as f64);
        }
    }
    for (a, seconds) in alternatives.iter().zip(&best) {
        println!("| {title} | {} | {:.1} | {:.2} |", a.name, seconds * 1e9, best[0] / seconds);
    }
}

fn time(calls: u32, work: &mut dyn FnMut()) -> f64 {
    let start = Instant::now();
    for _ in 0..calls {
        work();
    }
    start.elapsed().as_secs_f64()
}
