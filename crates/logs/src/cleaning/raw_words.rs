//! Finds signals of register words that were read without their sign: two's complement, or a sign bit.
//!
//! A servo stores -3 as 65533 (two's complement in 16 bits), or as 1027 (the bit of 1024 is the sign). If such a word is read
//! as an unsigned number, the signal is never negative, and it jumps by nearly the whole range of the word at each change of
//! sign. The signal does not jump after its sign is corrected.

use std::fmt;

use serde::Serialize;

use crate::cleaning::turns::extremes;

/// How a register word represents the sign. `count`: value of one count, in the unit of the series.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum RawWord {
    /// Negative numbers have 2^bits counts added to them.
    TwosComplement {
        /// Number of bits of the word.
        bits: i32,
        /// Value of one count.
        count: f64,
    },
    /// Negative numbers are stored as their magnitude plus 2^bit counts.
    SignBit {
        /// Number of the sign bit.
        bit: i32,
        /// Value of one count.
        count: f64,
    },
}

/// Possible numbers of bits of a register word.
const WORD_BITS: std::ops::RangeInclusive<i32> = 7..=32;

/// Smallest number of sign changes for a decision.
const MIN_SIGN_CHANGES: usize = 4;
/// Smallest median jump of the unsigned series at its sign changes, as a fraction of the word's range.
const MIN_JUMP_BEFORE: f64 = 0.5;
/// Largest median jump at these samples after the sign is corrected, as a fraction of the word's range.
const MAX_JUMP_AFTER: f64 = 0.1;
/// Smallest number of distinct values on each side of zero. A valve, for example, is open or closed and has only one value on
/// each side, so it is excluded.
const MIN_DISTINCT_VALUES: usize = 8;
/// A value counts as a whole number of counts if its distance to the nearest whole number is at most this many counts.
const COUNT_ROUNDING: f64 = 1e-3;
/// Smallest jump that may be a sign change, as a fraction of the largest value.
const MIN_JUMP_OF_LARGEST: f64 = 0.25;

impl RawWord {
    /// The word type of a series; `None` if the series has negative numbers, or is not made of register words.
    pub(crate) fn of(x: &[f64]) -> Option<RawWord> {
        let (low, high) = extremes(x);
        // A series with negative numbers was read with its sign, so only series without negative numbers are examined.
        if !(low >= 0.0 && high.is_finite())
            || x.windows(2).filter(|w| (w[1] - w[0]).abs() > MIN_JUMP_OF_LARGEST * high).count() < MIN_SIGN_CHANGES
        {
            return None;
        }
        let count = count_of(x)?;
        let power = |bits: i32| count * 2f64.powi(bits);
        // Two's complement is tried first, with the smallest number of bits that can hold the largest value.
        let word = WORD_BITS.clone().find(|bits| power(*bits) > high + 0.5 * count);
        let word = word.map(|bits| RawWord::TwosComplement { bits, count });
        let bits = WORD_BITS.rev().filter(|bit| power(*bit) <= high).map(|bit| RawWord::SignBit { bit, count });
        word.into_iter().chain(bits).find(|word| word.explains(x))
    }

    /// The signed number for a number x of the series.
    pub fn signed(self, x: f64) -> f64 {
        let size = self.size();
        match self {
            RawWord::TwosComplement { .. } if x >= 0.5 * size => x - size,
            RawWord::SignBit { .. } if x >= size => size - x,
            _ => x,
        }
    }

    /// The range of the word (two's complement), or the value of its sign bit, in the unit of the series.
    fn size(self) -> f64 {
        let (RawWord::TwosComplement { bits, count } | RawWord::SignBit { bit: bits, count }) = self;
        count * 2f64.powi(bits)
    }

    /// Whether the jumps of a series are changes of sign with this word type.
    fn explains(self, x: &[f64]) -> bool {
        let size = self.size();
        let changes = x.windows(2).filter(|w| (self.signed(w[0]) < 0.0) != (self.signed(w[1]) < 0.0));
        let jumps: Vec<(f64, f64)> =
            changes.map(|w| ((w[1] - w[0]).abs(), (self.signed(w[1]) - self.signed(w[0])).abs())).collect();
        if jumps.len() < MIN_SIGN_CHANGES {
            return false;
        }
        let middle = |mut jumps: Vec<f64>| {
            let middle = jumps.len() / 2;
            *jumps.select_nth_unstable_by(middle, f64::total_cmp).1
        };
        let (before, after) = (jumps.iter().map(|j| j.0).collect(), jumps.iter().map(|j| j.1).collect());
        let mut sides = [true, false].map(|is_negative| {
            let side = x.iter().map(|x| self.signed(*x)).filter(|x| (*x < 0.0) == is_negative);
            side.map(f64::to_bits).collect::<Vec<u64>>()
        });
        let are_many = sides.iter_mut().all(|side| {
            side.sort_unstable();
            side.dedup();
            side.len() >= MIN_DISTINCT_VALUES
        });
        are_many && middle(before) >= MIN_JUMP_BEFORE * size && middle(after) <= MAX_JUMP_AFTER * size
    }
}

/// The value of one count: the smallest difference of two numbers of the series, if all numbers are multiples of it; otherwise
/// `None`.
fn count_of(x: &[f64]) -> Option<f64> {
    let mut sorted = x.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    sorted.dedup();
    let count = sorted.windows(2).map(|w| w[1] - w[0]).fold(f64::INFINITY, f64::min);
    let is_whole = |x: &f64| (x / count - (x / count).round()).abs() < COUNT_ROUNDING;
    (count.is_finite() && sorted.iter().all(is_whole)).then_some(count)
}

impl fmt::Display for RawWord {
    /// Writes the correction in counts, because the numbers of the file may be in another unit.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (RawWord::TwosComplement { bits, count } | RawWord::SignBit { bit: bits, count }) = *self;
        let whole = 2f64.powi(bits);
        // If one count has the value one, the numbers of the file are counts.
        let counts = if count == 1.0 { "" } else { " counts" };
        match self {
            RawWord::TwosComplement { .. } => {
                write!(
                    f,
                    "subtract {whole}{counts} from the numbers from {}{counts} on (two's complement)",
                    0.5 * whole
                )?;
            }
            RawWord::SignBit { .. } => {
                write!(f, "write the numbers x from {whole}{counts} on as {whole}{counts} - x (that bit is the sign)")?;
            }
        }
        if count == 1.0 { Ok(()) } else { write!(f, "; a count is {} in SI", significant(count)) }
    }
}

/// A number with six significant digits.
fn significant(x: f64) -> String {
    let decimals = (5 - x.log10().floor() as i32).clamp(0, 12) as usize;
    let text = format!("{x:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A motor current in counts that changes its sign.
    fn counts() -> Vec<f64> {
        (0..2000).map(|i| 0.01 * f64::from(i)).map(|t| (300.0 * t.sin() + 90.0 * (3.1 * t).cos()).round()).collect()
    }

    fn complement(x: f64) -> f64 {
        if x < 0.0 { x + 65_536.0 } else { x }
    }

    fn sign_bit(x: f64) -> f64 {
        if x < 0.0 { 1024.0 - x } else { x }
    }

    #[test]
    fn a_word_without_its_sign_is_found_and_undone() {
        // One count is 1, or 2.69 mA in A.
        for scale in [1.0, 2.69e-3] {
            for (read, said) in [(complement as fn(f64) -> f64, "two's complement"), (sign_bit, "that bit is the sign")]
            {
                let logged: Vec<f64> = counts().iter().map(|x| scale * read(*x)).collect();
                let word = RawWord::of(&logged).unwrap();
                assert!(word.to_string().contains(said), "{word}");
                let is_right =
                    |(x, logged): (&f64, &f64)| (word.signed(*logged) - scale * x).abs() < 1e-6 * scale * 65_536.0;
                assert!(counts().iter().zip(&logged).all(is_right), "{word}");
            }
        }
        let said = |scale: f64| {
            let logged: Vec<f64> = counts().iter().map(|x| scale * complement(*x)).collect();
            RawWord::of(&logged).unwrap().to_string()
        };
        assert_eq!(said(1.0), "subtract 65536 from the numbers from 32768 on (two's complement)");
        let expected =
            "subtract 65536 counts from the numbers from 32768 counts on (two's complement); a count is 0.00269 in SI";
        assert_eq!(said(2.69e-3), expected);
    }

    #[test]
    fn other_signals_are_no_words() {
        let counts = counts();
        let smooth: Vec<f64> = (0..2000).map(|i| 3.0 + 2.9 * (0.01 * f64::from(i)).sin()).collect();
        let lifted: Vec<f64> = counts.iter().map(|x| x + 500.0).collect();
        let valve: Vec<f64> = (0..2000).map(|i| f64::from((i / 50) % 2 * 250 + i % 3)).collect();
        let steps: Vec<f64> = (0..2000).map(|i| f64::from((i / 50) % 2 * 60 + i % 30 + 1)).collect();
        for x in [&counts, &smooth, &lifted, &valve, &steps, &vec![0.0; 2000], &Vec::new()] {
            assert_eq!(RawWord::of(x), None);
        }
    }
}
