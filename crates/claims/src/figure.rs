//! Numbers with their unit, and bounds of quantities, as claims (statements with their evidence) contain and print them.

use std::fmt;

use serde::Serialize;

/// Prints `x` with at most `digits` significant digits, without trailing zeros: `0.5`, `-6.283`. Numbers below 1e-5 or from 1e7
/// on have an exponent.
pub fn significant(x: f64, digits: usize) -> String {
    let rounded: f64 = format!("{x:.*e}", digits.saturating_sub(1)).parse().unwrap_or(x);
    match rounded.abs() {
        // 0.0 also matches -0.0.
        0.0 => "0".into(),
        1e-5..1e7 => rounded.to_string(),
        _ => format!("{rounded:e}"),
    }
}

/// A number with its unit.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Figure {
    /// The number, in the unit `unit`.
    pub value: f64,
    /// The printed unit: `N m`, `%`, `columns`.
    pub unit: String,
}

impl Figure {
    /// Makes a number with its printed unit.
    pub fn new(value: f64, unit: impl Into<String>) -> Figure {
        Figure { value, unit: unit.into() }
    }

    /// Prints the number with four significant digits, and its unit. If rounding would make a statement about the number false
    /// (`is_false` of the rounded number), all digits are printed. So a printed bound holds.
    fn rounded(&self, is_false: impl Fn(f64) -> bool) -> String {
        let rounded = format!("{:.3e}", self.value).parse().unwrap_or(self.value);
        format!("{} {}", if is_false(rounded) { self.value } else { rounded }, self.unit)
    }
}

impl fmt::Display for Figure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.rounded(|_| false))
    }
}

/// A bound of a quantity, with its unit.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Bound {
    /// The quantity is at most this figure.
    AtMost(Figure),
    /// The quantity is at least this figure.
    AtLeast(Figure),
    /// The quantity equals this figure.
    Exactly(Figure),
}

impl Bound {
    /// The figure of the bound.
    pub fn figure(&self) -> &Figure {
        match self {
            Bound::AtMost(figure) | Bound::AtLeast(figure) | Bound::Exactly(figure) => figure,
        }
    }
}

impl fmt::Display for Bound {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Bound::AtMost(most) => write!(f, "at most {}", most.rounded(|shown| shown < most.value)),
            Bound::AtLeast(least) => write!(f, "at least {}", least.rounded(|shown| shown > least.value)),
            Bound::Exactly(figure) => write!(f, "exactly {}", figure.rounded(|shown| shown != figure.value)),
        }
    }
}

#[test]
fn digits_that_count() {
    let all = [(0.1 + 0.2, "0.3"), (-209.43951, "-209.4"), (0.0, "0"), (-0.0, "0"), (38.800000000000004, "38.8")];
    all.iter().for_each(|(x, text)| assert_eq!(significant(*x, 4), *text));
    assert_eq!((significant(-5.3004e-13, 3), significant(123456.0, 3)), ("-5.3e-13".into(), "123000".into()));
}

#[test]
fn a_bound_is_true_as_printed() {
    let of = |value: f64| Figure::new(value, "m");
    assert_eq!(of(0.66664).to_string(), "0.6666 m");
    assert_eq!(Bound::AtMost(of(0.66666)).to_string(), "at most 0.6667 m");
    assert_eq!(Bound::AtMost(of(0.66664)).to_string(), "at most 0.66664 m");
    assert_eq!(Bound::AtLeast(of(0.66664)).to_string(), "at least 0.6666 m");
    assert_eq!(Bound::AtLeast(of(0.66666)).to_string(), "at least 0.66666 m");
    assert_eq!(Bound::Exactly(of(12345.0)).to_string(), "exactly 12345 m");
}
