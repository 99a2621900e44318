//! The smallest and largest values of functions of one variable on an interval, proven by subdivision.
//!
//! An enclosure gives, for a subinterval I of the span, intervals that contain the values of each function on I. A subinterval
//! is divided until, for every function, the upper bound on the subinterval exceeds the largest known value of the function by
//! at most the tolerance. The smallest value is found in the same manner (branch and bound in a fixed order). The known values
//! are proven by enclosures at single instants.
//!
//! Often it is enough to know that functions stay within bounds. These bounds are proven first, with a separate maximum number
//! of enclosures, because the exact range may need too many enclosures.

use crate::interruption::Interruption;
use crate::interval::Interval;
use processor::{in_parallel, threads};

/// The smallest or the largest value of one function.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extreme {
    /// A value that the function certainly reaches: at the instant `time` the function has at least this value (in a search for
    /// the smallest value: at most this value).
    pub reached: f64,
    /// The instant of the value `reached`, in the unit of the span (s).
    pub time: f64,
    /// A proven bound: the function has no value beyond it.
    pub proved: f64,
}

/// The range of one function.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// The smallest value of the function.
    pub least: Extreme,
    /// The largest value of the function.
    pub greatest: Extreme,
}

/// The goal of the search for one function.
#[derive(Clone, Copy, Debug)]
pub struct RangeGoal {
    /// Largest allowed distance between the proven bound and the reached value, in the unit of the function.
    pub tolerance: f64,
    /// The search for a function may end when the function is proven to stay between -`enough` and `enough`. Minus infinity:
    /// the range of the function is always searched.
    pub enough: f64,
}

impl RangeGoal {
    /// The goal to find the range to a tolerance.
    pub fn to(tolerance: f64) -> RangeGoal {
        RangeGoal { tolerance, enough: f64::NEG_INFINITY }
    }
}

/// Limits of the work of a search: numbers of subintervals and of enclosures.
#[derive(Clone, Copy, Debug)]
pub struct Subdivision {
    /// Number of subintervals at the start.
    pub parts: usize,
    /// Maximum number of enclosures for the exact ranges. After this number of enclosures, the remaining subintervals are not
    /// divided further, and the bounds follow from their enclosures.
    pub enclosures: usize,
    /// Maximum number of enclosures for the first proof: the proof that functions stay within `enough`. If a function exceeds
    /// `enough`, the maximum is `enclosures` instead.
    pub enclosures_within: usize,
}

/// Intervals that contain the values of each function on a subinterval and at its middle.
#[derive(Clone, Debug)]
pub struct Enclosed {
    /// Enclosure of each function over the subinterval.
    pub over: Vec<Interval>,
    /// Enclosure of each function at the middle of the subinterval.
    pub middle: Vec<Interval>,
}

/// Least tolerance, as a multiple of the width of an enclosure at one instant (the rounding error). If the bound on a
/// subinterval exceeds the reached value by less than this tolerance, the excess is only rounding, and the subinterval is not
/// divided. The factor is above one for two reasons: the reached value is the end of an enclosure on the safe side, and the
/// bound contains a few more roundings.
const ROUNDING_WIDTHS: f64 = 4.0;

/// Number of subintervals that are enclosed in parallel at a time.
const PARTS_AT_A_TIME: usize = 512;

/// The range of each function over `span`, one per goal in `sought`. `enclose`: encloses all functions on a subinterval. The
/// result does not depend on the number of threads. If the work is interrupted, subintervals are no longer divided, and the
/// bounds still hold.
pub fn ranges(
    span: Interval,
    subdivision: Subdivision,
    sought: &[RangeGoal],
    enclose: impl Fn(Interval) -> Enclosed + Sync,
) -> Vec<Range> {
    let Subdivision { parts, enclosures, enclosures_within } = subdivision;
    let parts = parts.max(1);
    let at = |k: usize| if k == parts { span.high } else { span.low + span.width() * (k as f64 / parts as f64) };
    let never = |sign: f64| Extreme { reached: sign * f64::INFINITY, time: span.low, proved: sign * f64::INFINITY };
    let mut search = RangeSearch {
        sought,
        found: vec![Range { least: never(1.0), greatest: never(-1.0) }; sought.len()],
        rounding: vec![0.0; sought.len()],
    };
    // First the functions are enclosed at the instants between subintervals, then on the subintervals. Then subintervals are
    // divided.
    for time in (0..=parts).map(at) {
        search.include_instant(time, &enclose(Interval::point(time)).over);
    }
    let first = search.enclosed((0..parts).map(|k| Interval::new(at(k), at(k + 1))).collect(), &enclose);
    let within =
        search.divided(first, SubdivisionGoal::Within, enclosures_within.max(enclosures), enclosures, &enclose);
    let exact = search.divided(within, SubdivisionGoal::Range, enclosures, enclosures, &enclose);
    for part in &exact {
        for (range, held) in search.found.iter_mut().zip(&part.held) {
            range.greatest.proved = range.greatest.proved.max(held.high);
            range.least.proved = range.least.proved.min(held.low);
        }
    }
    search.found
}

/// A subinterval of the span, with an enclosure of each function on it.
struct SpanPart {
    span: Interval,
    held: Vec<Interval>,
}

/// The goal of a division of subintervals.
#[derive(Clone, Copy, PartialEq)]
enum SubdivisionGoal {
    /// Prove that all functions stay within `enough`.
    Within,
    /// Find the ranges of the functions.
    Range,
}

/// The state of a search: the ranges found so far.
struct RangeSearch<'a> {
    sought: &'a [RangeGoal],
    found: Vec<Range>,
    /// For each function, the largest width of its enclosures at single instants. This width is the rounding error of the
    /// function.
    rounding: Vec<f64>,
}

impl RangeSearch<'_> {
    /// Updates the reached values with the enclosures of the functions at an instant.
    fn include_instant(&mut self, time: f64, values: &[Interval]) {
        for ((range, value), rounding) in self.found.iter_mut().zip(values).zip(&mut self.rounding) {
            if value.width().is_finite() {
                *rounding = rounding.max(value.width());
            }
            // The value lies between the ends of its interval. So the greatest value is at least its lower end, and the least
            // value is at most its upper end.
            if value.low > range.greatest.reached {
                (range.greatest.reached, range.greatest.time) = (value.low, time);
            }
            if value.high < range.least.reached {
                (range.least.reached, range.least.time) = (value.high, time);
            }
        }
    }

    /// Encloses the functions on each of `spans`, and updates the reached values with the enclosures at the middles.
    fn enclosed(&mut self, spans: Vec<Interval>, enclose: &(impl Fn(Interval) -> Enclosed + Sync)) -> Vec<SpanPart> {
        let all = in_parallel(spans, threads(), |span| (span, enclose(span)));
        let part = |(span, Enclosed { over, middle }): (Interval, Enclosed)| {
            self.include_instant(span.middle(), &middle);
            SpanPart { span, held: over }
        };
        all.into_iter().map(part).collect()
    }

    /// Halves subintervals round by round until the goal `aim` is met or `enclosures` are used up. `beyond`: the maximum number
    /// of enclosures that applies instead of `enclosures` if a function exceeds `enough`.
    fn divided(
        &mut self,
        parts: Vec<SpanPart>,
        aim: SubdivisionGoal,
        enclosures: usize,
        beyond: usize,
        enclose: &(impl Fn(Interval) -> Enclosed + Sync),
    ) -> Vec<SpanPart> {
        let (mut done, mut used, mut left) = (vec![], 0, parts);
        while !left.is_empty() {
            let (mut settled, open): (Vec<SpanPart>, Vec<SpanPart>) =
                left.into_iter().partition(|part| self.is_done(part, aim));
            done.append(&mut settled);
            used += 2 * open.len();
            let most = if self.is_beyond() { beyond } else { enclosures };
            if used > most || Interruption::check().is_err() {
                done.extend(open);
                break;
            }
            // The halves are enclosed in parallel. If the work is interrupted, the remaining subintervals stay undivided.
            left = Vec::with_capacity(2 * open.len());
            let mut open = open.into_iter();
            while !open.as_slice().is_empty() {
                let some = open.by_ref().take(PARTS_AT_A_TIME / 2);
                if Interruption::check().is_err() {
                    done.extend(some);
                    continue;
                }
                let halves = |part: SpanPart| {
                    let (span, middle) = (part.span, part.span.middle());
                    [Interval::new(span.low, middle), Interval::new(middle, span.high)]
                };
                left.extend(self.enclosed(some.flat_map(halves).collect(), enclose));
            }
        }
        done
    }

    /// Whether a subinterval needs no further division for `aim`, or is too small to divide.
    fn is_done(&self, part: &SpanPart, aim: SubdivisionGoal) -> bool {
        let middle = part.span.middle();
        let is_point = middle <= part.span.low || middle >= part.span.high;
        let mut all = part.held.iter().zip(&self.found).zip(self.sought.iter().zip(&self.rounding));
        is_point
            || all.all(|((held, range), (sought, least))| {
                // A tolerance below the rounding of the function cannot be met by division.
                let tolerance = sought.tolerance.max(ROUNDING_WIDTHS * least);
                let enough = if aim == SubdivisionGoal::Within { sought.enough } else { f64::NEG_INFINITY };
                held.high <= (range.greatest.reached + tolerance).max(enough)
                    && held.low >= (range.least.reached - tolerance).min(-enough)
            })
    }

    /// Whether a function is known to exceed `enough`.
    fn is_beyond(&self) -> bool {
        let is_beyond =
            |(range, s): (&Range, &RangeGoal)| range.greatest.reached > s.enough || range.least.reached < -s.enough;
        self.found.iter().zip(self.sought).any(is_beyond)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;
    use crate::jet::Jet;

    /// The enclosures that `on` computes over the subinterval and at its middle.
    fn both(on: impl Fn(Interval) -> Vec<Interval>, part: Interval) -> Enclosed {
        Enclosed { over: on(part), middle: on(Interval::point(part.middle())) }
    }

    /// Encloses t sin t and t^2 over the subinterval.
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
        let found = ranges(SPAN, of(100_000, 0), &[RangeGoal::to(1e-9); 2], |part| both(on, part));
        // t sin t is largest at t = 2.028757838 (tan t = -t), and smallest at t = 4.913180439.
        let (greatest, least) = (found[0].greatest, found[0].least);
        assert!((greatest.reached - 1.819705741).abs() < 1e-8 && (greatest.time.abs() - 2.028757838).abs() < 1e-3);
        assert!((least.reached + 4.814469889).abs() < 1e-8 && (least.time - 4.913180439).abs() < 1e-3);
        assert!(greatest.proved >= greatest.reached && greatest.proved < greatest.reached + 2e-9);
        assert!(least.proved <= least.reached && least.proved > least.reached - 2e-9);
        assert!((found[1].greatest.reached - 36.0).abs() < 1e-12 && found[1].least.reached < 1e-9);
    }

    /// If a tolerance is below the rounding of the values, the search ends before all enclosures are used.
    #[test]
    fn values_far_beyond_their_tolerance_end_soon() {
        let count = AtomicUsize::new(0);
        let large = |part: Interval| {
            count.fetch_add(1, Ordering::Relaxed);
            // Adding and subtracting 1e15 leaves a rounding error in the value. Such errors occur in a motion whose start or end
            // lasts only a microsecond.
            let [far, near] = [1e15, -1e15].map(Interval::point);
            on(part).into_iter().map(|x| (x * Interval::point(1e5) + far) + near).collect()
        };
        let found = ranges(SPAN, of(100_000, 0), &[RangeGoal::to(1e-9); 2], |part| both(large, part));
        assert!((found[0].greatest.proved / 1.819705741e5 - 1.0).abs() < 1e-4, "{found:?}");
        assert!(count.into_inner() < 10_000);
    }

    #[test]
    fn what_is_enough_costs_few_parts() {
        let counted = |enough: f64, subdivision: Subdivision| {
            let count = AtomicUsize::new(0);
            let sought = [RangeGoal { tolerance: 1e-9, enough }, RangeGoal { tolerance: 1.0, enough: 40.0 }];
            let counting = |part: Interval| {
                count.fetch_add(1, Ordering::Relaxed);
                both(on, part)
            };
            (ranges(SPAN, subdivision, &sought, counting)[0], count.into_inner())
        };
        // The smallest value of t sin t is -4.81447, the largest 1.81971.
        let is_exact = |range: Range| {
            (range.least.proved + 4.814469889).abs() < 1e-8 && (range.greatest.proved - 1.819705741).abs() < 1e-8
        };
        let (within, few) = counted(4.9, of(0, 100_000));
        assert!(within.least.proved >= -4.9 && within.greatest.proved <= 4.9 && !is_exact(within) && few < 60, "{few}");
        let (exact, many) = counted(4.9, of(100_000, 100_000));
        assert!(is_exact(exact) && many > 2 * few, "{many} {few}");
        assert!(is_exact(counted(4.8, of(100_000, 100_000)).0));
        // If a function exceeds `enough`, `enclosures_within` is not used. At most 25 enclosures are then computed: nine instants
        // and eight subintervals at the start, and eight more.
        let (beyond, fewest) = counted(4.8, of(8, 100_000));
        assert!(beyond.least.proved <= -4.814469889 && !is_exact(beyond) && fewest <= 25, "{fewest}");
    }

    #[test]
    fn what_is_left_at_the_end_of_the_budget_is_still_bounded() {
        let found = ranges(SPAN, of(8, 0), &[RangeGoal::to(1e-9); 2], |part| both(on, part));
        assert!(found[0].greatest.proved >= 1.819705741 && found[0].least.proved <= -4.814469889);
        assert!(found[0].greatest.reached <= 1.819705742);
    }
}
