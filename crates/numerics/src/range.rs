//! The least and greatest values that functions of one variable take on an interval, proved by subdivision.
//!
//! An enclosure gives, for a part I of the span, intervals that hold what each function does on I. A part is divided
//! until no function can exceed there, by more than its tolerance, the value that it is known to reach (branch and
//! bound, in a fixed order), or until they stay where it is enough to know that they do. The values reached are proved too, by enclosures at single instants.

use crate::interval::Interval;

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
    /// A part where the function stays between minus this and this needs no division.
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
    /// Largest number of enclosures. The parts that are left then are bounded without further division.
    pub enclosures: usize,
}

/// Widths of an instant's enclosure that a part may exceed what is reached by: what is reached is the far end of one, and a
/// part is rounded in a few operations more.
const ROUNDINGS: f64 = 4.0;

/// The ranges over `span` of the functions whose enclosures `enclose` gives, one for each that is sought.
pub fn ranges(
    span: Interval,
    subdivision: Subdivision,
    sought: &[Sought],
    mut enclose: impl FnMut(Interval) -> Vec<Interval>,
) -> Vec<Range> {
    let never = |sign: f64| Extreme { reached: sign * f64::INFINITY, time: span.low, proved: sign * f64::INFINITY };
    let mut found = vec![Range { least: never(1.0), greatest: never(-1.0) }; sought.len()];
    // The width that rounding leaves the enclosure of an instant.
    let mut rounding = vec![0.0_f64; sought.len()];
    let reach = |found: &mut [Range], rounding: &mut [f64], time: f64, values: &[Interval]| {
        for ((range, value), rounding) in found.iter_mut().zip(values).zip(rounding) {
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
    };
    let parts = subdivision.parts.max(1);
    let at = |k: usize| if k == parts { span.high } else { span.low + span.width() * (k as f64 / parts as f64) };
    let mut left: Vec<Interval> = (0..parts).rev().map(|k| Interval::new(at(k), at(k + 1))).collect();
    for k in 0..=2 * parts {
        let time = if k % 2 == 0 { at(k / 2) } else { Interval::new(at(k / 2), at(k / 2 + 1)).middle() };
        reach(&mut found, &mut rounding, time, &enclose(Interval::point(time)));
    }
    let mut enclosures = 0;
    while let Some(part) = left.pop() {
        let held = enclose(part);
        enclosures += 1;
        let settled =
            held.iter().zip(&found).zip(sought.iter().zip(&rounding)).all(|((held, range), (sought, least))| {
                // Nearer than rounding no division comes.
                let tolerance = sought.tolerance.max(ROUNDINGS * least);
                held.high <= (range.greatest.reached + tolerance).max(sought.enough)
                    && held.low >= (range.least.reached - tolerance).min(-sought.enough)
            });
        let middle = part.middle();
        let is_point = middle <= part.low || middle >= part.high;
        if settled || is_point || enclosures >= subdivision.enclosures {
            for (range, held) in found.iter_mut().zip(&held) {
                range.greatest.proved = range.greatest.proved.max(held.high);
                range.least.proved = range.least.proved.min(held.low);
            }
        } else {
            reach(&mut found, &mut rounding, middle, &enclose(Interval::point(middle)));
            left.push(Interval::new(middle, part.high));
            left.push(Interval::new(part.low, middle));
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::jet::Jet;

    fn enclose(part: Interval) -> Vec<Interval> {
        // t sin t and t^2.
        let jet = |t: Interval| Jet([t, Interval::point(1.0), Interval::ZERO]);
        let product = |t: Interval| jet(t) * jet(t).sin();
        let from_middle = part - Interval::point(part.middle());
        vec![Jet::over_interval(product(Interval::point(part.middle())), product(part), from_middle), part.square()]
    }

    #[test]
    fn ends_are_found_and_proved() {
        let found = ranges(
            Interval::new(-3.0, 6.0),
            Subdivision { parts: 8, enclosures: 100_000 },
            &[Sought::to(1e-9); 2],
            enclose,
        );
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
        let mut count = 0;
        let large = |part: Interval| {
            count += 1;
            // A difference of large numbers, as in a blend of a microsecond, leaves their rounding.
            let [far, near] = [1e15, -1e15].map(Interval::point);
            enclose(part).into_iter().map(|x| (x * Interval::point(1e5) + far) + near).collect()
        };
        let subdivision = Subdivision { parts: 8, enclosures: 100_000 };
        let found = ranges(Interval::new(-3.0, 6.0), subdivision, &[Sought::to(1e-9); 2], large);
        assert!((found[0].greatest.proved / 1.819705741e5 - 1.0).abs() < 1e-4, "{found:?}");
        assert!(count < 10_000, "{count}");
    }

    /// Parts that stay within what is enough are not divided; a function that leaves it is told to its tolerance.
    #[test]
    fn what_is_enough_costs_few_parts() {
        let counted = |enough: f64| {
            let mut count = 0;
            let subdivision = Subdivision { parts: 8, enclosures: 100_000 };
            let sought = [Sought { tolerance: 1e-9, enough }, Sought { tolerance: 1.0, enough: 40.0 }];
            let counting = |part: Interval| {
                count += 1;
                enclose(part)
            };
            (ranges(Interval::new(-3.0, 6.0), subdivision, &sought, counting)[0], count)
        };
        // The least is -4.81447, the greatest 1.81971.
        let ((loose, few), (exact, many)) = (counted(4.9), counted(4.8));
        assert!(loose.least.proved >= -4.9 && loose.greatest.proved <= 4.9 && few < 60, "{few}");
        assert!((exact.least.proved + 4.814469889).abs() < 1e-8 && many > 2 * few, "{many} {few}");
        // Its greatest stays within what is enough, so that it is told by a bound alone.
        assert!(exact.greatest.proved <= 4.8);
    }

    #[test]
    fn what_is_left_at_the_end_of_the_budget_is_still_bounded() {
        let found =
            ranges(Interval::new(-3.0, 6.0), Subdivision { parts: 8, enclosures: 8 }, &[Sought::to(1e-9); 2], enclose);
        assert!(found[0].greatest.proved >= 1.819705741 && found[0].least.proved <= -4.814469889);
        assert!(found[0].greatest.reached <= 1.819705742);
    }
}
