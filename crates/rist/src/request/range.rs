//! Allowed ranges of numeric fields.
//!
//! A field is one option of a request (a struct with all options of a command).

use std::ops::{RangeFrom, RangeInclusive};

use crate::error::Error;

/// An allowed range of numbers. NaN is only allowed by `Any`.
#[derive(Clone, Debug, PartialEq)]
pub enum Range {
    /// Every number is allowed. Also used for fields that are no numbers.
    Any,
    /// From the first number to the second, both included.
    Between(f64, f64),
    /// At least this number.
    From(f64),
    /// Above zero, and finite.
    Positive,
    /// Not zero, and finite.
    NonZero,
    /// Above zero and at most one.
    Share,
}

impl From<RangeInclusive<i32>> for Range {
    fn from(range: RangeInclusive<i32>) -> Range {
        Range::Between((*range.start()).into(), (*range.end()).into())
    }
}

impl From<RangeInclusive<f64>> for Range {
    fn from(range: RangeInclusive<f64>) -> Range {
        Range::Between(*range.start(), *range.end())
    }
}

impl From<RangeFrom<i32>> for Range {
    fn from(range: RangeFrom<i32>) -> Range {
        Range::From(range.start.into())
    }
}

impl Range {
    /// Whether the range contains the number `x`.
    pub fn holds(&self, x: f64) -> bool {
        match *self {
            Range::Any => true,
            Range::Between(from, to) => (from..=to).contains(&x),
            Range::From(from) => x >= from,
            Range::Positive => x.is_finite() && x > 0.0,
            Range::NonZero => x.is_finite() && x != 0.0,
            Range::Share => x > 0.0 && x <= 1.0,
        }
    }

    /// The range in words: `a number from 1 to 40`; empty for [`Range::Any`].
    pub fn text(&self) -> String {
        match self {
            Range::Any => String::new(),
            Range::Between(from, to) => format!("a number from {} to {}", number(*from), number(*to)),
            Range::From(from) => format!("a number from {} up", number(*from)),
            Range::Positive => "a positive number".into(),
            Range::NonZero => "a number that is not 0".into(),
            Range::Share => "a number above 0 and at most 1".into(),
        }
    }
}

/// A number in its short form: 5, 0.1, 1e300.
pub fn number(x: f64) -> String {
    let exact = format!("{x:?}");
    if exact.contains('e') { exact } else { x.to_string() }
}

impl Range {
    /// The error for a number `x` of the field `field` that is out of range.
    pub(crate) fn refusal(&self, field: &str, x: f64) -> Error {
        let x = number(x);
        match self {
            Range::Positive => Error::new(format_args!("[{field}] must be a positive number, not {x}")),
            Range::Share => Error::new(format_args!("[{field}] is above 0 and at most 1, not {x}")),
            _ => Error::new(format_args!("[{field}] is {x}; expected is {}", self.text())),
        }
    }
}
