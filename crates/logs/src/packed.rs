//! Samples of a log held in memory, in fewer bytes where that loses nothing.
//!
//! What controllers write has few decimals: x = m 10^-k with the integer m in 32 bits. A series of such numbers is held by
//! its integers (`integers`), and m / 10^k is, bit for bit, what was read. A series in single precision is held in it.
//! Other series are held as they are.

use std::ops::Range;

use processor::{Work, widely};

use crate::abreast::abreast;
use crate::integers::Integers;
use crate::log::Log;

/// A part of a log, its series packed.
pub(crate) struct PackedLog {
    /// All but the series and the rows.
    head: Log,
    len: usize,
    /// s, the first instant.
    start: f64,
    /// In the order of [`Log::series`].
    series: Vec<Series>,
    rows: Rows,
}

/// The numbers of one series.
enum Series {
    Plain(Vec<f64>),
    /// In single precision.
    Single(Vec<f32>),
    /// m, and 10^k.
    Decimal(Integers, f64),
}

/// Rows of the file that the samples come from. Mostly they are consecutive.
enum Rows {
    From(usize),
    Listed(Vec<usize>),
}

/// Stands for -0, which an integer cannot express.
const MINUS_ZERO: i32 = i32::MIN;

/// Adding this to a number below 2^31 leaves the nearest integer in the lower half of the sum.
const ROUNDING_SUMMAND: f64 = 6_755_399_441_055_744.0;

/// Powers of ten that are tried.
const TRIED_POWERS_OF_TEN: [f64; 10] = [1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9];

#[inline(always)]
fn integer(x: f64, power: f64) -> i32 {
    // Without a branch, so that several are made at once.
    if x.to_bits() == (-0.0_f64).to_bits() { MINUS_ZERO } else { (x * power + ROUNDING_SUMMAND).to_bits() as i32 }
}

#[inline(always)]
fn number(integer: i32, power: f64) -> f64 {
    let quotient = f64::from(integer) / power;
    if integer == MINUS_ZERO { -0.0 } else { quotient }
}

/// The integers of numbers; `None` where one is no decimal of this power.
#[inline(always)]
fn integers(x: &[f64], power: f64) -> Option<Integers> {
    Integers::of(x.len(), |first, integers| {
        let x = &x[first..first + integers.len()];
        integers.iter_mut().zip(x).for_each(|(m, x)| *m = integer(*x, power));
        let wrong = |(m, x): (&i32, &f64)| number(*m, power).to_bits() ^ x.to_bits();
        integers.iter().zip(x).map(wrong).fold(0, |all, wrong| all | wrong) == 0
    })
}

/// The numbers of integers, appended.
#[inline(always)]
fn append_numbers(integers: &[i32], power: f64, all: &mut Vec<f64>) {
    // As many as a processor makes at once, and more.
    const ABREAST: usize = 32;
    let mut chunks = integers.chunks_exact(ABREAST);
    for integers in &mut chunks {
        let mut numbers = [0.0; ABREAST];
        numbers.iter_mut().zip(integers).for_each(|(x, m)| *x = number(*m, power));
        all.extend_from_slice(&numbers);
    }
    all.extend(chunks.remainder().iter().map(|&m| number(m, power)));
}

impl Series {
    #[inline(always)]
    fn of(x: Vec<f64>) -> Series {
        for power in TRIED_POWERS_OF_TEN {
            if let Some(integers) = integers(&x, power) {
                return Series::Decimal(integers, power);
            }
        }
        match x.iter().all(|x| f64::from(*x as f32).to_bits() == x.to_bits()) {
            true => Series::Single(x.iter().map(|&x| x as f32).collect()),
            false => Series::Plain(x),
        }
    }

    #[inline(always)]
    fn append_to(&self, all: &mut Vec<f64>, range: Range<usize>) {
        match self {
            Series::Plain(x) => all.extend_from_slice(&x[range]),
            Series::Single(x) => all.extend(x[range].iter().map(|&x| f64::from(x))),
            Series::Decimal(integers, power) => {
                integers.each(range, |some| append_numbers(some, *power, all));
            }
        }
    }
}

struct Packing(Vec<f64>);

impl Work for Packing {
    type Output = Series;

    #[inline(always)]
    fn run(self) -> Series {
        Series::of(self.0)
    }
}

struct Unpacking<'a> {
    series: &'a Series,
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
    /// Holds a log.
    pub(crate) fn new(mut log: Log) -> PackedLog {
        let (len, start) = (log.len(), log.t.first().copied().unwrap_or(0.0));
        let series = log.series_mut().map(std::mem::take).collect();
        let series = abreast(len, series, |x| widely(Packing(x)));
        let rows = std::mem::take(&mut log.rows);
        let first = rows.first().copied().unwrap_or(0);
        let follow = rows.iter().enumerate().all(|(i, row)| *row == first + i);
        PackedLog { head: log, len, start, series, rows: if follow { Rows::From(first) } else { Rows::Listed(rows) } }
    }

    /// Number of samples.
    pub(crate) fn len(&self) -> usize {
        self.len
    }

    /// Bytes of the samples.
    pub(crate) fn bytes(&self) -> usize {
        let rows = match &self.rows {
            Rows::From(_) => 0,
            Rows::Listed(rows) => size_of_val(rows.as_slice()),
        };
        let series = self.series.iter().map(|series| match series {
            Series::Plain(x) => size_of_val(x.as_slice()),
            Series::Single(x) => size_of_val(x.as_slice()),
            Series::Decimal(integers, _) => integers.bytes(),
        });
        rows + series.sum::<usize>()
    }

    /// s, the first instant; 0 of no sample.
    pub(crate) fn start(&self) -> f64 {
        self.start
    }

    /// The log without its samples.
    pub(crate) fn head(&self) -> Log {
        self.head.clone()
    }

    /// Time and positions of all samples; the other series are left out.
    pub(crate) fn positions(&self) -> Log {
        let mut log = self.head.clone();
        (log.dq, log.ddq, log.effort) = (None, None, Vec::new());
        log.reserve(self.len);
        self.append_to(&mut log, 0..self.len);
        log
    }

    /// Appends samples to a log of the same series, or of the first of them.
    pub(crate) fn append_to(&self, log: &mut Log, range: Range<usize>) {
        let pairs: Vec<(&mut Vec<f64>, &Series)> = log.series_mut().zip(&self.series).collect();
        abreast(range.len(), pairs, |(all, series)| {
            widely(Unpacking { series, all, range: range.clone() });
        });
        match &self.rows {
            Rows::From(first) => log.rows.extend(range.map(|i| first + i)),
            Rows::Listed(rows) => log.rows.extend_from_slice(&rows[range]),
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
            let series = Series::of(x.clone());
            let kind = match series {
                Series::Plain(_) => "plain",
                Series::Single(_) => "single",
                Series::Decimal(..) => "decimal",
            };
            assert_eq!(kind, expected, "{:?}", x.first());
            let mut found = Vec::new();
            series.append_to(&mut found, 0..x.len());
            assert!(x.iter().zip(&found).all(|(a, b)| a.to_bits() == b.to_bits()) && x.len() == found.len());
        }
    }
}
