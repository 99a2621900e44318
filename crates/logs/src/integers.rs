//! Whole numbers in as few bits as they differ by.
//!
//! A measured signal changes little from sample to sample, so its first or second differences are small. Of each frame of
//! numbers x_0 .. x_(n-1) the differences of one order k are kept:
//!
//! d_i = x_i,   x_i - x_(i-1),   or   x_i - 2 x_(i-1) + x_(i-2);   stored: d_i - min d in `width` bits, from i = k on
//!
//! with the order of 0, 1, 2 that needs the fewest bits. The first k numbers stand beside them. Frames are independent, so
//! that any of them can be read alone [Zukowski, Heman, Nes, Boncz 2006].

use std::ops::Range;

/// Numbers of a frame.
const NUMBERS_PER_FRAME: usize = 512;

/// Differences of higher orders are noise.
const ORDERS: usize = 3;

/// Whole numbers, packed.
#[derive(Default)]
pub(crate) struct Integers {
    frames: Vec<Frame>,
    /// The bits of the frames. Behind each stands a word more, so that two words can be read wherever a number begins.
    words: Vec<u64>,
}

/// A frame of numbers.
struct Frame {
    /// Where its words begin.
    word: usize,
    order: u8,
    width: u8,
    /// The smallest difference.
    least: i64,
    /// The numbers before the differences.
    first: [i32; ORDERS - 1],
}

impl Integers {
    /// Frame by frame as `fill` makes the numbers, given the place of the first; `None` as soon as it makes none.
    #[inline(always)]
    pub(crate) fn of(len: usize, mut fill: impl FnMut(usize, &mut [i32]) -> bool) -> Option<Integers> {
        let (mut packed, mut numbers) = (Integers::default(), [0; NUMBERS_PER_FRAME]);
        for first in (0..len).step_by(NUMBERS_PER_FRAME) {
            let numbers = &mut numbers[..NUMBERS_PER_FRAME.min(len - first)];
            if !fill(first, numbers) {
                return None;
            }
            packed.push(numbers);
        }
        packed.words.shrink_to_fit();
        packed.frames.shrink_to_fit();
        Some(packed)
    }

    /// Appends a frame.
    #[inline(always)]
    fn push(&mut self, x: &[i32]) {
        // Small numbers have differences of 32 bits, of which the processor takes several at once.
        let is_small = x.iter().all(|x| (-SMALL..SMALL).contains(x));
        let bounds: [(i64, u32); ORDERS] = if is_small { bounds_of_small(x) } else { bounds(x) };
        let order = (0..ORDERS).min_by_key(|&order| bounds[order].1).unwrap_or(0);
        let (least, width) = bounds[order];
        let first = std::array::from_fn(|i| x.get(i).map_or(0, |&x| x));
        self.frames.push(Frame { word: self.words.len(), order: order as u8, width: width as u8, least, first });
        let (mut word, mut filled) = (0, 0);
        let mut push = |difference: i64| {
            let bits = (difference - least).cast_unsigned();
            word |= bits << filled;
            filled += width;
            if filled >= u64::BITS {
                self.words.push(word);
                filled -= u64::BITS;
                word = bits.checked_shr(width - filled).unwrap_or(0);
            }
        };
        let wide = |x: i32| i64::from(x);
        match order {
            0 => x.iter().for_each(|x| push(wide(*x))),
            1 => x.windows(2).for_each(|x| push(wide(x[1]) - wide(x[0]))),
            _ => x.windows(3).for_each(|x| push(wide(x[2]) - 2 * wide(x[1]) + wide(x[0]))),
        }
        self.words.extend([word, 0]);
    }

    /// Bytes in memory.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(self.words.as_slice()) + size_of_val(self.frames.as_slice())
    }

    /// Hands over numbers, frame by frame.
    #[inline(always)]
    pub(crate) fn each(&self, range: Range<usize>, mut take: impl FnMut(&[i32])) {
        let mut numbers = [0; NUMBERS_PER_FRAME];
        let mut at = range.start;
        while at < range.end {
            let frame = at / NUMBERS_PER_FRAME;
            let first = frame * NUMBERS_PER_FRAME;
            let end = range.end.min(first + NUMBERS_PER_FRAME);
            self.unpack(frame, &mut numbers[..end - first]);
            take(&numbers[at - first..end - first]);
            at = end;
        }
    }

    /// The first numbers of a frame.
    #[inline(always)]
    fn unpack(&self, frame: usize, numbers: &mut [i32]) {
        let &Frame { word, order, width, least, first } = &self.frames[frame];
        let (words, order, width) = (&self.words[word..], usize::from(order), u32::from(width));
        let head = order.min(numbers.len());
        numbers[..head].copy_from_slice(&first[..head]);
        let mask = 1_u64.checked_shl(width).map_or(u64::MAX, |bit| bit - 1);
        let (mut x, mut step) = (i64::from(first[order.saturating_sub(1)]), 0);
        if order == 2 {
            step = i64::from(first[1]) - i64::from(first[0]);
        }
        let mut bit = 0;
        for number in &mut numbers[head..] {
            let (word, shift) = ((bit >> 6) as usize, bit & 63);
            // Of a shift by 64 nothing is left, which one shift cannot express.
            let bits = (words[word] >> shift | words[word + 1] << 1 << (63 - shift)) & mask;
            bit += width;
            let difference = least + bits.cast_signed();
            match order {
                0 => x = difference,
                1 => x += difference,
                _ => {
                    step += difference;
                    x += step;
                }
            }
            *number = x as i32;
        }
    }
}

/// Numbers below have second differences below 2^31.
const SMALL: i32 = 1 << 29;

/// The smallest difference of each order, and the bits by which the others are larger.
#[inline(always)]
fn bounds(x: &[i32]) -> [(i64, u32); ORDERS] {
    let wide = |x: i32| i64::from(x);
    [
        spread(x.iter().map(|x| wide(*x))),
        spread(x.windows(2).map(|x| wide(x[1]) - wide(x[0]))),
        spread(x.windows(3).map(|x| wide(x[2]) - 2 * wide(x[1]) + wide(x[0]))),
    ]
}

#[inline(always)]
fn spread(differences: impl Iterator<Item = i64>) -> (i64, u32) {
    bits(differences.fold((i64::MAX, i64::MIN), |(low, high), d| (low.min(d), high.max(d))))
}

/// The same of numbers below [`SMALL`].
#[inline(always)]
fn bounds_of_small(x: &[i32]) -> [(i64, u32); ORDERS] {
    let (one, two) = (x.get(1..).unwrap_or_default(), x.get(2..).unwrap_or_default());
    [
        spread_of_small(x.iter().copied()),
        spread_of_small(one.iter().zip(x).map(|(b, a)| b - a)),
        spread_of_small(two.iter().zip(one).zip(x).map(|((c, b), a)| c - 2 * b + a)),
    ]
}

#[inline(always)]
fn spread_of_small(differences: impl Iterator<Item = i32>) -> (i64, u32) {
    let (low, high) = differences.fold((i32::MAX, i32::MIN), |(low, high), d| (low.min(d), high.max(d)));
    bits((i64::from(low), i64::from(high)))
}

/// Of no difference there are no bits.
#[inline(always)]
fn bits((low, high): (i64, i64)) -> (i64, u32) {
    if low > high { (0, 0) } else { (low, u64::BITS - (high - low).cast_unsigned().leading_zeros()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(x: &[i32], most_bits: f64) {
        let packed = Integers::of(x.len(), |first, numbers| {
            numbers.copy_from_slice(&x[first..first + numbers.len()]);
            true
        });
        let packed = packed.unwrap();
        let bits = 8.0 * packed.bytes() as f64 / x.len().max(1) as f64;
        assert!(bits <= most_bits, "{bits} bits a number");
        for range in [0..x.len(), x.len() / 3..x.len() / 2, x.len()..x.len()] {
            let mut found = Vec::new();
            packed.each(range.clone(), |some| found.extend_from_slice(some));
            assert_eq!(found, x[range]);
        }
    }

    /// No number is lost, and signals take the bits of their noise.
    #[test]
    fn packing_loses_nothing() {
        let mut state = 1_u32;
        let mut noise = |bits: u32| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> (32 - bits)).cast_signed()
        };
        // Overhead of a frame: 32 bytes, a word more, and a word that is not full.
        check(&(0..10_000).collect::<Vec<i32>>(), 1.0);
        let sine = |i: i32| (1e5 * (1e-3 * f64::from(i)).sin()) as i32;
        check(&(0..10_000).map(sine).collect::<Vec<i32>>(), 3.0);
        check(&(0..10_000).map(|i| sine(i) + noise(12)).collect::<Vec<i32>>(), 14.0);
        check(&(0..10_000).map(|_| noise(17)).collect::<Vec<i32>>(), 18.0);
        assert!(Integers::of(1000, |first, _| first == 0).is_none());
        for x in [i32::MIN, i32::MAX, SMALL, -SMALL, 0] {
            check(&[x, -SMALL, SMALL - 1, x], 1000.0);
            check(&[x], 1000.0);
            check(&[x, i32::MAX], 1000.0);
            check(&[x, i32::MIN, i32::MAX, i32::MIN], 1000.0);
        }
        let extremes: Vec<i32> = (0..3000).map(|i| [i32::MIN, i32::MAX, 0, 7, -7][i % 5 * i % 5]).collect();
        check(&extremes, 34.0);
        check(&[], 1000.0);
        for len in [511_u32, 512, 513, 1024, 1025] {
            check(&(0..len).map(|i| noise(1 + i % 31)).collect::<Vec<i32>>(), 33.0);
        }
    }
}
