//! Compares the run times of alternative implementations in the same process. Times of different processes are not comparable.
//! Each result is also compared with the true result, because the time of a wrong result has no meaning.
//!
//! The alternatives run in turns. A turn has several repetitions, and its time is their median. The time of an alternative is the
//! smallest of these medians: other programs can only increase the time of a turn, and seldom increase it in all turns.

use std::hint::black_box;
use std::time::{Duration, Instant};

const TURNS: usize = 15;
const REPETITIONS: usize = 9;
/// The work is called so often that a repetition lasts at least about this long. Then the resolution of the clock has no effect.
const REPETITION: Duration = Duration::from_micros(300);
/// Work that takes longer than this is timed in only one turn.
const LONG: Duration = Duration::from_millis(50);

/// A relative difference above this is not only rounding. Rounding: about ten thousand operations with errors of 1e-16, on terms
/// up to ten times the largest torque of a joint.
const ROUNDING: f64 = 1e-11;

/// One implementation of some work, which does `units` units of work (such as samples) in a call; and the difference of its
/// result from the true result.
pub(crate) struct Alternative<'a> {
    name: &'a str,
    units: usize,
    work: Result<Box<dyn FnMut() + 'a>, &'a str>,
    difference: Option<Box<dyn Fn() -> f64 + 'a>>,
}

impl<'a> Alternative<'a> {
    pub(crate) fn new<T>(name: &'a str, units: usize, mut work: impl FnMut() -> T + 'a) -> Alternative<'a> {
        Alternative { name, units, work: Ok(Box::new(move || drop(black_box(work())))), difference: None }
    }

    /// An alternative that cannot be timed. `why`: the reason, which is printed.
    pub(crate) fn not_timed(name: &'a str, why: &'a str) -> Alternative<'a> {
        Alternative { name, units: 1, work: Err(why), difference: None }
    }

    /// Adds a function that computes the relative difference of the result from the true result.
    pub(crate) fn held(self, difference: impl Fn() -> f64 + 'a) -> Alternative<'a> {
        Alternative { difference: Some(Box::new(difference)), ..self }
    }

    /// Time of this number of calls, s. Infinite if the alternative cannot be timed.
    fn run(&mut self, calls: u32) -> f64 {
        let Ok(work) = &mut self.work else { return f64::INFINITY };
        let start = Instant::now();
        for _ in 0..calls {
            work();
        }
        start.elapsed().as_secs_f64()
    }

    fn difference(&self) -> f64 {
        self.difference.as_ref().map_or(f64::INFINITY, |difference| difference())
    }
}

/// Prints tables of alternatives. `wrong`: the alternatives whose result was wrong.
#[derive(Default)]
pub(crate) struct Comparison {
    wrong: Vec<String>,
}

impl Comparison {
    /// Prints a line for each alternative: time per unit, ns; how many times faster than the first alternative that was timed;
    /// and difference from the true result.
    pub(crate) fn of(&mut self, work: &str, mut alternatives: Vec<Alternative>) {
        let before: Vec<f64> = alternatives.iter().map(Alternative::difference).collect();
        let best = best_times(&mut alternatives);
        let first = best.iter().copied().find(|seconds| seconds.is_finite()).unwrap_or(f64::INFINITY);
        for ((alternative, seconds), before) in alternatives.iter().zip(&best).zip(before) {
            let name = alternative.name;
            if let Err(why) = alternative.work {
                println!("| {work} | {name} | not timed | | {why} |");
                continue;
            }
            let difference = before.max(alternative.difference());
            if difference > ROUNDING {
                self.wrong.push(format!("{work}, {name}: {difference:.1e}"));
            }
            println!("| {work} | {name} | {:.1} | {:.2} | {difference:.0e} |", seconds * 1e9, first / seconds);
        }
    }

    /// Ends the program with an error if a result was wrong.
    pub(crate) fn finish(self) {
        if !self.wrong.is_empty() {
            eprintln!("not what the recursion says, beyond rounding: {}", self.wrong.join("; "));
            std::process::exit(1);
        }
    }
}

/// Time per unit of each alternative, s. Infinite if it cannot be timed.
fn best_times(alternatives: &mut [Alternative]) -> Vec<f64> {
    let once: Vec<f64> = alternatives
        .iter_mut()
        .map(|a| {
            a.run(1);
            a.run(1).max(1e-9)
        })
        .collect();
    let calls: Vec<u32> = once.iter().map(|once| (REPETITION.as_secs_f64() / once).ceil().max(1.0) as u32).collect();
    let is_long = once.iter().any(|once| once.is_finite() && *once > LONG.as_secs_f64());
    let mut best = vec![f64::INFINITY; alternatives.len()];
    for _ in 0..if is_long { 1 } else { TURNS } {
        for ((a, calls), best) in alternatives.iter_mut().zip(&calls).zip(&mut best) {
            let mut seconds: [f64; REPETITIONS] = std::array::from_fn(|_| a.run(*calls));
            seconds.sort_by(f64::total_cmp);
            *best = best.min(seconds[REPETITIONS / 2] / f64::from(*calls) / a.units as f64);
        }
    }
    best
}
