//! Stores the samples of a log in memory, compressed without loss.
//!
//! The numbers of controllers have few decimals: x = m 10^-k with a 32-bit integer m. For such a series the integers m are stored
//! (`integers`); m / 10^k gives each number bit for bit. A series of single-precision values is stored in single precision. Other
//! series are stored unchanged.

use std::ops::Range;

use processor::{Work, widely};

use crate::integers::Integers;
use crate::log::Log;
use crate::parallel_series::in_parallel_series;

/// A block of a log with compressed series.
pub(crate) struct PackedLog {
    /// All fields of the log except the series and the rows.
    head: Log,
    len: usize,
    /// Time of the first sample, s.
    start: f64,
    /// The compressed series, in the order of [`Log::series`].
    series: Vec<PackedSeries>,
    rows: RowIndices,
}

/// The numbers of one series in one of three forms.
enum PackedSeries {
    Plain(Vec<f64>),
    /// Numbers of single precision.
    Single(Vec<f32>),
    /// The integers m, and the divisor 10^k.
    Decimal(Integers, f64),
}

/// The rows of the samples in the file. They are usually consecutive.
enum RowIndices {
    From(usize),
    Listed(Vec<usize>),
}

/// The code for -0, which no integer can represent.
const MINUS_ZERO: i32 = i32::MIN;

/// If this number is added to a number below 2^31, the lower half of the sum is the nearest integer.
const ROUNDING_SUMMAND: f64 = 6_755_399_441_055_744.0;

/// The powers of ten that are tried as divisors.
const TRIED_POWERS_OF_TEN: [f64; 10] = [1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9];

#[inline(always)]
fn integer(x: f64, power: f64) -> i32 {
    // Written without a branch, so that the compiler vectorises it.
    if x.to_bits() == (-0.0_f64).to_bits() { MINUS_ZERO } else { (x * power + ROUNDING_SUMMAND).to_bits() as i32 }
}

#[inline(always)]
fn number(integer: i32, power: f64) -> f64 {
    let quotient = f64::from(integer) / power;
    if integer == MINUS_ZERO { -0.0 } else { quotient }
}

/// The integers m for numbers x = m / power; `None` if a number does not have this form.
#[inline(always)]
fn integers(x: &[f64], power: f64) -> Option<Integers> {
    Integers::of(x.len(), |first, integers| {
        let x = &x[first..first + integers.len()];
        integers.iter_mut().zip(x).for_each(|(m, x)| *m = integer(*x, power));
        let wrong = |(m, x): (&i32, &f64)| number(*m, power).to_bits() ^ x.to_bits();
        integers.iter().zip(x).map(wrong).fold(0, |all, wrong| all | wrong) == 0
    })
}

/// Converts integers to numbers, and appends them to `all`.
#[inline(always)]
fn append_numbers(integers: &[i32], power: f64, all: &mut Vec<f64>) {
    // A multiple of the number of SIMD lanes of a processor.
    const NUMBERS_AT_ONCE: usize = 32;
    let mut chunks = integers.chunks_exact(NUMBERS_AT_ONCE);
    for integers in &mut chunks {
        let mut numbers = [0.0; NUMBERS_AT_ONCE];
        numbers.iter_mut().zip(integers).for_each(|(x, m)| *x = number(*m, power));
        all.extend_from_slice(&numbers);
    }
    all.extend(chunks.remainder().iter().map(|&m| number(m, power)));
}

impl PackedSeries {
    #[inline(always)]
    fn of(x: Vec<f64>) -> PackedSeries {
        for power in TRIED_POWERS_OF_TEN {
            if let Some(integers) = integers(&x, power) {
                return PackedSeries::Decimal(integers, power);
            }
        }
        match x.iter().all(|x| f64::from(*x as f32).to_bits() == x.to_bits()) {
            true => PackedSeries::Single(x.iter().map(|&x| x as f32).collect()),
            false => PackedSeries::Plain(x),
        }
    }

    #[inline(always)]
    fn append_to(&self, all: &mut Vec<f64>, range: Range<usize>) {
        match self {
            PackedSeries::Plain(x) => all.extend_from_slice(&x[range]),
            PackedSeries::Single(x) => all.extend(x[range].iter().map(|&x| f64::from(x))),
            PackedSeries::Decimal(integers, power) => {
                integers.each(range, |some| append_numbers(some, *power, all));
            }
        }
    }
}

struct Packing(Vec<f64>);

impl Work for Packing {
    type Output = PackedSeries;

    #[inline(always)]
    fn run(self) -> PackedSeries {
        PackedSeries::of(self.0)
    }
}

struct Unpacking<'a> {
    series: &'a PackedSeries,
    all: &'a mut Vec<f64>,
    range: Range<usize>,
}

impl Work for Unpacking<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.series.append_to(self.all, self.range);
    }
}

impl PackedLog {
    /// Compresses a log.
    pub(crate) fn new(mut log: Log) -> PackedLog {
        let (len, start) = (log.len(), log.t.first().copied().unwrap_or(0.0));
        let series = log.series_mut().map(std::mem::take).collect();
        let series = in_parallel_series(len, series, |x| widely(Packing(x)));
        let rows = std::mem::take(&mut log.rows);
        let first = rows.first().copied().unwrap_or(0);
        let follow = rows.iter().enumerate().all(|(i, row)| *row == first + i);
        PackedLog {
            head: log,
            len,
            start,
            series,
            rows: if follow { RowIndices::From(first) } else { RowIndices::Listed(rows) },
        }
    }

    /// Number of samples.
    pub(crate) fn len(&self) -> usize {
        self.len
    }

    /// Memory in use for the samples, bytes.
    pub(crate) fn bytes(&self) -> usize {
        let rows = match &self.rows {
            RowIndices::From(_) => 0,
            RowIndices::Listed(rows) => size_of_val(rows.as_slice()),
        };
        let series = self.series.iter().map(|series| match series {
            PackedSeries::Plain(x) => size_of_val(x.as_slice()),
            PackedSeries::Single(x) => size_of_val(x.as_slice()),
            PackedSeries::Decimal(integers, _) => integers.bytes(),
        });
        rows + series.sum::<usize>()
    }

    /// Time of the first sample, s; 0 if there are no samples.
    pub(crate) fn start(&self) -> f64 {
        self.start
    }

    /// The log without its samples.
    pub(crate) fn head(&self) -> Log {
        self.head.clone()
    }

    /// A log with time and positions of all samples, without the other series.
    pub(crate) fn positions(&self) -> Log {
        let mut log = self.head.clone();
        (log.dq, log.ddq, log.effort) = (None, None, Vec::new());
        log.reserve(self.len);
        self.append_to(&mut log, 0..self.len);
        log
    }

    /// Appends the samples in a range to a log. The log must have the same series, or only the first few of these series.
    pub(crate) fn append_to(&self, log: &mut Log, range: Range<usize>) {
        let pairs: Vec<(&mut Vec<f64>, &PackedSeries)> = log.series_mut().zip(&self.series).collect();
        in_parallel_series(range.len(), pairs, |(all, series)| {
            widely(Unpacking { series, all, range: range.clone() });
        });
        match &self.rows {
            RowIndices::From(first) => log.rows.extend(range.map(|i| first + i)),
            RowIndices::Listed(rows) => log.rows.extend_from_slice(&rows[range]),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packing_loses_nothing() {
        let decimals: Vec<f64> =
            (-5000..5000).map(|i| f64::from(i) * 317.0 / 1e6).map(|x| (x * 1e6).round() / 1e6).collect();
        let cases = [
            (vec![0.0, -0.0, 1.5, -2.25, 0.001], "decimal"),
            (decimals, "decimal"),
            (vec![0.1 + 0.2], "plain"),
            (vec![f64::from(0.1_f32), -0.0], "single"),
            (vec![2_147_483_647.0, -2_147_483_647.0], "decimal"),
            (vec![2_147_483_649.0], "plain"),
            (vec![1e300, -1e-300], "plain"),
            (vec![f64::from(i32::MIN)], "single"),
            (Vec::new(), "decimal"),
        ];
        for (x, expected) in cases {
            let series = PackedSeries::of(x.clone());
            let kind = match series {
                PackedSeries::Plain(_) => "plain",
                PackedSeries::Single(_) => "single",
                PackedSeries::Decimal(..) => "decimal",
            };
            assert_eq!(kind, expected, "{:?}", x.first());
            let mut found = Vec::new();
            series.append_to(&mut found, 0..x.len());
            assert!(x.iter().zip(&found).all(|(a, b)| a.to_bits() == b.to_bits()) && x.len() == found.len());
        }
    }
}
