//! Stores integers compactly: differences between successive integers, with only as many bits as they need.
//!
//! A measured signal changes little between samples, so its first or second differences are small. The numbers are divided into
//! frames x_0 .. x_(n-1). For each frame, the differences of one order k are stored:
//!
//! d_i = x_i,   x_i - x_(i-1),   or   x_i - 2 x_(i-1) + x_(i-2);   stored: d_i - min d in `width` bits, from i = k on
//!
//! The order k is 0, 1 or 2, whichever needs the fewest bits. The first k numbers are stored separately. Frames are independent,
//! so each can be read alone [Zukowski, Heman, Nes, Boncz 2006].

use std::ops::Range;

/// Number of integers in a frame.
const NUMBERS_PER_FRAME: usize = 512;

/// Number of orders of differences that are tried. Higher orders would mainly contain noise.
const DIFFERENCE_ORDERS: usize = 3;

/// A compressed list of integers.
#[derive(Default)]
pub(crate) struct Integers {
    frames: Vec<IntegerFrame>,
    /// The bits of the frames. Spare bytes follow each frame, so that eight bytes can be read at the start of any number.
    bytes: Vec<u8>,
}

/// The description of a frame in the bytes.
struct IntegerFrame {
    /// Index of the first byte of the frame.
    byte: usize,
    order: u8,
    width: u8,
    /// The smallest difference, which is subtracted from all differences.
    least: i64,
    /// The first numbers, which have no difference.
    first: [i32; DIFFERENCE_ORDERS - 1],
}

/// Number of bytes that are read at once. A second difference of 32-bit numbers needs 34 bits, and begins at most 7 bits after
/// the start of a byte.
const BYTES_AT_ONCE: usize = size_of::<u64>();

/// Largest number of bits of a difference.
const MAX_DIFFERENCE_BITS: usize = 34;
/// Largest number of bytes of a frame, with the spare bytes after it.
const MAX_FRAME_BYTES: usize = NUMBERS_PER_FRAME * MAX_DIFFERENCE_BITS / 8 + 2 * BYTES_AT_ONCE;

impl Integers {
    /// Compresses `len` integers. `fill`: writes the integers of a frame, given the index of the first one. `None` if `fill`
    /// fails.
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
        packed.bytes.shrink_to_fit();
        packed.frames.shrink_to_fit();
        Some(packed)
    }

    /// Appends a frame with the integers x.
    #[inline(always)]
    fn push(&mut self, x: &[i32]) {
        // The differences of small numbers fit in 32 bits, so the processor computes them in SIMD lanes.
        let is_small = x.iter().all(|x| (-SMALL_NUMBER..SMALL_NUMBER).contains(x));
        let bounds: [(i64, u32); DIFFERENCE_ORDERS] = if is_small { bounds_of_small(x) } else { bounds(x) };
        let order = (0..DIFFERENCE_ORDERS).min_by_key(|&order| bounds[order].1).unwrap_or(0);
        let (least, width) = bounds[order];
        let first = std::array::from_fn(|i| x.get(i).map_or(0, |&x| x));
        self.frames.push(IntegerFrame { byte: self.bytes.len(), order: order as u8, width: width as u8, least, first });
        let mut bytes = [0; MAX_FRAME_BYTES];
        let wide = |x: i32| i64::from(x);
        let len = match order {
            0 => put(x.iter().map(|x| wide(*x)), least, width, &mut bytes),
            1 => put(x.windows(2).map(|x| wide(x[1]) - wide(x[0])), least, width, &mut bytes),
            _ => put(x.windows(3).map(|x| wide(x[2]) - 2 * wide(x[1]) + wide(x[0])), least, width, &mut bytes),
        };
        // One more byte is kept, because the last byte may contain only some bits.
        self.bytes.extend_from_slice(&bytes[..len + 1 + BYTES_AT_ONCE]);
    }

    /// Memory in use, bytes.
    pub(crate) fn bytes(&self) -> usize {
        self.bytes.len() + size_of_val(self.frames.as_slice())
    }

    /// Decompresses the integers of a range, and passes them to `take` frame by frame.
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

    /// Decompresses the first numbers of a frame, as many as `numbers` has.
    ///
    /// The sums are computed modulo 2^32. This gives the correct 32-bit numbers, even if differences have more than 32 bits.
    #[inline(always)]
    fn unpack(&self, frame: usize, numbers: &mut [i32]) {
        let &IntegerFrame { byte, order, width, least, first } = &self.frames[frame];
        let order = usize::from(order);
        let (head, differences) = numbers.split_at_mut(order.min(numbers.len()));
        head.copy_from_slice(&first[..head.len()]);
        differences_of(&self.bytes[byte..], usize::from(width), least, differences);
        let mut x = first[order.saturating_sub(1)];
        match order {
            0 => {}
            1 => differences.iter_mut().for_each(|difference| {
                x = x.wrapping_add(*difference);
                *difference = x;
            }),
            _ => {
                let mut step = first[1].wrapping_sub(first[0]);
                differences.iter_mut().for_each(|difference| {
                    step = step.wrapping_add(*difference);
                    x = x.wrapping_add(step);
                    *difference = x;
                });
            }
        }
    }
}

/// The lower 32 bits of the differences in `bytes`. Eight differences need `width` bytes, so each group of eight begins at a
/// whole byte.
#[inline(always)]
fn differences_of(bytes: &[u8], width: usize, least: i64, differences: &mut [i32]) {
    let mask = (1_u64 << width) - 1;
    let places: [(usize, usize); 8] = std::array::from_fn(|i| (i * width / 8, i * width % 8));
    for (eight, differences) in differences.chunks_mut(8).enumerate() {
        let bytes = &bytes[eight * width..];
        for (difference, (byte, bit)) in differences.iter_mut().zip(places) {
            let word = bytes[byte..].first_chunk().map_or(0, |word| u64::from_le_bytes(*word));
            *difference = least.wrapping_add((word >> bit & mask).cast_signed()) as i32;
        }
    }
}

/// Writes the bits of differences to bytes, and returns the number of full bytes.
#[inline(always)]
fn put(differences: impl Iterator<Item = i64>, least: i64, width: u32, bytes: &mut [u8; MAX_FRAME_BYTES]) -> usize {
    // The bits that do not fill a byte yet, and their number.
    let (mut byte, mut pending, mut count) = (0, 0, 0);
    for difference in differences {
        pending |= (difference - least).cast_unsigned() << count;
        if let Some(behind) = bytes[byte..].first_chunk_mut() {
            *behind = pending.to_le_bytes();
        }
        count += width;
        byte += (count / u8::BITS) as usize;
        pending >>= count & !(u8::BITS - 1);
        count %= u8::BITS;
    }
    byte
}

/// For numbers of smaller magnitude, the second differences are below 2^31.
const SMALL_NUMBER: i32 = 1 << 29;

/// For each order: the smallest difference, and the number of bits for the range of the differences.
#[inline(always)]
fn bounds(x: &[i32]) -> [(i64, u32); DIFFERENCE_ORDERS] {
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

/// The result of [`bounds`] for numbers below [`SMALL_NUMBER`], computed in 32 bits.
#[inline(always)]
fn bounds_of_small(x: &[i32]) -> [(i64, u32); DIFFERENCE_ORDERS] {
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

/// The lowest value, and the number of bits for the range. Zero bits if there are no differences.
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

    #[test]
    fn packing_loses_nothing() {
        let mut state = 1_u32;
        let mut noise = |bits: u32| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> (32 - bits)).cast_signed()
        };
        // Allowance for the overhead of a frame: 32 bytes for its description, eight spare bytes, and one partly filled byte.
        check(&(0..10_000).collect::<Vec<i32>>(), 1.0);
        let sine = |i: i32| (1e5 * (1e-3 * f64::from(i)).sin()) as i32;
        check(&(0..10_000).map(sine).collect::<Vec<i32>>(), 3.0);
        check(&(0..10_000).map(|i| sine(i) + noise(12)).collect::<Vec<i32>>(), 14.0);
        check(&(0..10_000).map(|_| noise(17)).collect::<Vec<i32>>(), 18.0);
        assert!(Integers::of(1000, |first, _| first == 0).is_none());
        for x in [i32::MIN, i32::MAX, SMALL_NUMBER, -SMALL_NUMBER, 0] {
            check(&[x, -SMALL_NUMBER, SMALL_NUMBER - 1, x], 1000.0);
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
