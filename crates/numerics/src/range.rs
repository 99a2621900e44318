//! The least and greatest values that functions of one variable take on an interval, proved by subdivision.
//!
//! An enclosure gives, for a part I of the span, intervals that hold what each function does on I. A part is divided
//! until no function can exceed there, by more than its tolerance, the value that it is known to reach (branch and
//! bound, in a fixed order). The values reached are proved too, by enclosures at single instants.
//!
//! Where it is enough to know that functions stay within bounds, that is proved first, with more enclosures: the exact
//! range of what is enclosed widely may take too many.

use crate::interruption::Interruption;
use crate::interval::Interval;
use processor::{in_parallel, threads};

/// An end of the range of one function.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extreme {
    /// The value reached at `time`.
    pub reached: f64,
    /// s.
    pub time: f64,
    /// A bound that is nowhere exceeded.
    pub proved: f64,
}

/// The range of one function.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// The least value.
    pub least: Extreme,
    /// The greatest value.
    pub greatest: Extreme,
}

/// What is sought of one function.
#[derive(Clone, Copy, Debug)]
pub struct Sought {
    /// How near a proved bound comes to what is reached.
    pub tolerance: f64,
    /// What the function is to stay within, between minus this and this; minus infinity where only its range is sought.
    pub enough: f64,
}

impl Sought {
    /// The range, to a tolerance.
    pub fn to(tolerance: f64) -> Sought {
        Sought { tolerance, enough: f64::NEG_INFINITY }
    }
}

/// How far to go.
#[derive(Clone, Copy, Debug)]
pub struct Subdivision {
    /// Parts to begin with.
    pub parts: usize,
    /// Most enclosures for the exact ranges. The parts that are left then are bounded without further division.
    pub enclosures: usize,
    /// Most enclosures before them, to know that functions stay within what is enough; where one is seen to leave it,
    /// they are those for the ranges.
    pub enclosures_within: usize,
}

/// What functions do on a part, and at its middle.
#[derive(Clone, Debug)]
pub struct Enclosed {
    /// On the part.
    pub over: Vec<Interval>,
    /// At the middle of the part.
    pub middle: Vec<Interval>,
}

/// Widths of an instant's enclosure that a part may exceed what is reached by: what is reached is the far end of one, and a
/// part is rounded in a few operations more.
const ROUNDINGS: f64 = 4.0;

/// Parts that threads share at a time.
const PARTS_AT_A_TIME: usize = 512;

/// The ranges over `span` of the functions that `enclose` encloses, one for each that is sought. They are the same for any
/// number of threads. Work that is interrupted ends without further division.
pub fn ranges(
    span: Interval,
    subdivision: Subdivision,
    sought: &[Sought],
    enclose: impl Fn(Interval) -> Enclosed + Sync,
) -> Vec<Range> {
    let Subdivision { parts, enclosures, enclosures_within } = subdivision;
    let parts = parts.max(1);
    let at = |k: usize| if k == parts { span.high } else { span.low + span.width() * (k as f64 / parts as f64) };
    let never = |sign: f64| Extreme { reached: sign * f64::INFINITY, time: span.low, proved: sign * f64::INFINITY };
    let mut search = Search {
        sought,
        found: vec![Range { least: never(1.0), greatest: never(-1.0) }; sought.len()],
        rounding: vec![0.0; sought.len()],
    };
    for time in (0..=parts).map(at) {
        search.reach(time, &enclose(Interval::point(time)).over);
    }
    let first = search.enclosed((0..parts).map(|k| Interval::new(at(k), at(k + 1))).collect(), &enclose);
    let within = search.divided(first, Aim::Within, enclosures_within.max(enclosures), enclosures, &enclose);
    let exact = search.divided(within, Aim::Range, enclosures, enclosures, &enclose);
    for part in &exact {
        for (range, held) in search.found.iter_mut().zip(&part.held) {
            range.greatest.proved = range.greatest.proved.max(held.high);
            range.least.proved = range.least.proved.min(held.low);
        }
    }
    search.found
}

/// A part of the span, and what holds each function on it.
struct Part {
    span: Interval,
    held: Vec<Interval>,
}

/// What parts are divided for.
#[derive(Clone, Copy, PartialEq)]
enum Aim {
    /// To know that functions stay within what is enough.
    Within,
    /// To know their ranges.
    Range,
}

/// What is known so far.
struct Search<'a> {
    sought: &'a [Sought],
    found: Vec<Range>,
    /// The width that rounding leaves the enclosure of an instant.
    rounding: Vec<f64>,
}

impl Search<'_> {
    /// Takes what functions are at an instant.
    fn reach(&mut self, time: f64, values: &[Interval]) {
        for ((range, value), rounding) in self.found.iter_mut().zip(values).zip(&mut self.rounding) {
            if value.width().is_finite() {
                *rounding = rounding.max(value.width());
            }
            // The value lies between the ends of its interval, so the far end is not reached for certain.
            if value.low > range.greatest.reached {
                (range.greatest.reached, range.greatest.time) = (value.low, time);
            }
            if value.high < range.least.reached {
                (range.least.reached, range.least.time) = (value.high, time);
            }
        }
    }

    /// The parts with what holds the functions on them; their middles are reached.
    fn enclosed(&mut self, spans: Vec<Interval>, enclose: &(impl Fn(Interval) -> Enclosed + Sync)) -> Vec<Part> {
        let all = in_parallel(spans, threads(), |span| (span, enclose(span)));
        let part = |(span, Enclosed { over, middle }): (Interval, Enclosed)| {
            self.reach(span.middle(), &middle);
            Part { span, held: over }
        };
        all.into_iter().map(part).collect()
    }

    /// Divides parts, all of a size before any that is smaller, until nothing is left to divide for the aim or so many
    /// enclosures are used; `beyond`: where a function leaves what is enough.
    fn divided(
        &mut self,
        parts: Vec<Part>,
        aim: Aim,
        enclosures: usize,
        beyond: usize,
        enclose: &(impl Fn(Interval) -> Enclosed + Sync),
    ) -> Vec<Part> {
        let (mut done, mut used, mut left) = (vec![], 0, parts);
        while !left.is_empty() {
            let (mut settled, open): (Vec<Part>, Vec<Part>) =
                left.into_iter().partition(|part| self.is_done(part, aim));
            done.append(&mut settled);
            used += 2 * open.len();
            let most = if self.is_beyond() { beyond } else { enclosures };
            if used > most || Interruption::check().is_err() {
                done.extend(open);
                break;
            }
            left = Vec::with_capacity(2 * open.len());
            let mut open = open.into_iter();
            while !open.as_slice().is_empty() {
                let some = open.by_ref().take(PARTS_AT_A_TIME / 2);
                if Interruption::check().is_err() {
                    done.extend(some);
                    continue;
                }
                let halves = |part: Part| {
                    let (span, middle) = (part.span, part.span.middle());
                    [Interval::new(span.low, middle), Interval::new(middle, span.high)]
                };
                left.extend(self.enclosed(some.flat_map(halves).collect(), enclose));
            }
        }
        done
    }

    /// Whether a part needs no division, or has none.
    fn is_done(&self, part: &Part, aim: Aim) -> bool {
        let middle = part.span.middle();
        let is_point = middle <= part.span.low || middle >= part.span.high;
        let mut all = part.held.iter().zip(&self.found).zip(self.sought.iter().zip(&self.rounding));
        is_point
            || all.all(|((held, range), (sought, least))| {
                // Nearer than rounding no division comes.
                let tolerance = sought.tolerance.max(ROUNDINGS * least);
                let enough = if aim == Aim::Within { sought.enough } else { f64::NEG_INFINITY };
                held.high <= (range.greatest.reached + tolerance).max(enough)
                    && held.low >= (range.least.reached - tolerance).min(-enough)
            })
    }

    /// Whether a function is seen to leave what is enough.
    fn is_beyond(&self) -> bool {
        let is_beyond =
            |(range, s): (&Range, &Sought)| range.greatest.reached > s.enough || range.least.reached < -s.enough;
        self.found.iter().zip(self.sought).any(is_beyond)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;
    use crate::jet::Jet;

    /// On the part and at its middle.
    fn both(on: impl Fn(Interval) -> Vec<Interval>, part: Interval) -> Enclosed {
        Enclosed { over: on(part), middle: on(Interval::point(part.middle())) }
    }

    /// t sin t and t^2.
    fn on(part: Interval) -> Vec<Interval> {
        let jet = |t: Interval| Jet([t, Interval::point(1.0), Interval::ZERO]);
        let product = |t: Interval| jet(t) * jet(t).sin();
        let from_middle = part - Interval::point(part.middle());
        vec![Jet::over_interval(product(Interval::point(part.middle())), product(part), from_middle), part.square()]
    }

    fn of(enclosures: usize, enclosures_within: usize) -> Subdivision {
        Subdivision { parts: 8, enclosures, enclosures_within }
    }

    const SPAN: Interval = Interval { low: -3.0, high: 6.0 };

    #[test]
    fn ends_are_found_and_proved() {
        let found = ranges(SPAN, of(100_000, 0), &[Sought::to(1e-9); 2], |part| both(on, part));
        // t sin t: greatest at t = 2.028757838 (tan t = -t), least at t = 4.913180439.
        let (greatest, least) = (found[0].greatest, found[0].least);
        assert!((greatest.reached - 1.819705741).abs() < 1e-8 && (greatest.time.abs() - 2.028757838).abs() < 1e-3);
        assert!((least.reached + 4.814469889).abs() < 1e-8 && (least.time - 4.913180439).abs() < 1e-3);
        assert!(greatest.proved >= greatest.reached && greatest.proved < greatest.reached + 2e-9);
        assert!(least.proved <= least.reached && least.proved > least.reached - 2e-9);
        assert!((found[1].greatest.reached - 36.0).abs() < 1e-12 && found[1].least.reached < 1e-9);
    }

    /// A tolerance below the rounding of the values is no reason to divide until the budget ends.
    #[test]
    fn values_far_beyond_their_tolerance_end_soon() {
        let count = AtomicUsize::new(0);
        let large = |part: Interval| {
            count.fetch_add(1, Ordering::Relaxed);
            // A difference of large numbers, as in a blend of a microsecond, leaves their rounding.
            let [far, near] = [1e15, -1e15].map(Interval::point);
            on(part).into_iter().map(|x| (x * Interval::point(1e5) + far) + near).collect()
        };
        let found = ranges(SPAN, of(100_000, 0), &[Sought::to(1e-9); 2], |part| both(large, part));
        assert!((found[0].greatest.proved / 1.819705741e5 - 1.0).abs() < 1e-4, "{found:?}");
        assert!(count.into_inner() < 10_000);
    }

    #[test]
    fn what_is_enough_costs_few_parts() {
        let counted = |enough: f64, subdivision: Subdivision| {
            let count = AtomicUsize::new(0);
            let sought = [Sought { tolerance: 1e-9, enough }, Sought { tolerance: 1.0, enough: 40.0 }];
            let counting = |part: Interval| {
                count.fetch_add(1, Ordering::Relaxed);
                both(on, part)
            };
            (ranges(SPAN, subdivision, &sought, counting)[0], count.into_inner())
        };
        // The least is -4.81447, the greatest 1.81971.
        let is_exact = |range: Range| {
            (range.least.proved + 4.814469889).abs() < 1e-8 && (range.greatest.proved - 1.819705741).abs() < 1e-8
        };
        let (within, few) = counted(4.9, of(0, 100_000));
        assert!(within.least.proved >= -4.9 && within.greatest.proved <= 4.9 && !is_exact(within) && few < 60, "{few}");
        let (exact, many) = counted(4.9, of(100_000, 100_000));
        assert!(is_exact(exact) && many > 2 * few, "{many} {few}");
        assert!(is_exact(counted(4.8, of(100_000, 100_000)).0));
        // What leaves it is not divided by what was meant for proofs that it stays within: nine instants and eight parts to begin
        // with, and eight enclosures.
        let (beyond, fewest) = counted(4.8, of(8, 100_000));
        assert!(beyond.least.proved <= -4.814469889 && !is_exact(beyond) && fewest <= 25, "{fewest}");
    }

    #[test]
    fn what_is_left_at_the_end_of_the_budget_is_still_bounded() {
        let found = ranges(SPAN, of(8, 0), &[Sought::to(1e-9); 2], |part| both(on, part));
        assert!(found[0].greatest.proved >= 1.819705741 && found[0].least.proved <= -4.814469889);
        assert!(found[0].greatest.reached <= 1.819705742);
    }
}
