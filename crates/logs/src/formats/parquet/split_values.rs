//! Converts a page from the encoding BYTE_STREAM_SPLIT, which stores the bytes of values separately, to PLAIN.
//!
//! ```text
//! byte b of value i of n:  split[b n + i] -> plain[i w + b],    w bytes a value
//! ```
//! In this encoding, all first bytes are stored first, then all second bytes (Encodings.md of the Parquet format). The crate
//! `parquet` 60.1 panics if such a page has too few values, but not for a page in PLAIN.
//!
//! Null values of a page are not treated here.

use parquet::basic::Encoding;

/// Converts bytes from BYTE_STREAM_SPLIT to the order of the values; `None` if their number is no multiple of `width`.
pub(crate) fn joined(split: &[u8], width: usize) -> Option<Vec<u8>> {
    let count = split.len().checked_div(width).filter(|count| count * width == split.len())?;
    Some((0..split.len()).map(|k| split[k % width * count + k / width]).collect())
}

/// The position of the values in a data page of version 1, after the repetition levels and the definition levels. `None` if the
/// page ends before. `levels`: for each kind, its largest level and its encoding.
///
/// Levels in RLE start with their length in four bytes. In BIT_PACKED, each level has as many bits as the largest level needs
/// (Encodings.md of the Parquet format).
pub(crate) fn values_begin(page: &[u8], values: u32, levels: [(i16, Encoding); 2]) -> Option<usize> {
    let mut begin = 0_usize;
    for (largest, encoding) in levels.into_iter().filter(|level| level.0 > 0) {
        #[expect(deprecated, reason = "old files have it")]
        let length = match encoding {
            Encoding::BIT_PACKED => {
                let bits = usize::try_from(i16::BITS - largest.leading_zeros()).ok()?;
                usize::try_from(values).ok()?.checked_mul(bits)?.div_ceil(8)
            }
            _ => {
                let length = page.get(begin..)?.first_chunk::<4>()?;
                usize::try_from(u32::from_le_bytes(*length)).ok()?.checked_add(4)?
            }
        };
        begin = begin.checked_add(length).filter(|begin| *begin <= page.len())?;
    }
    Some(begin)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_come_together() {
        let numbers = [1.5_f64, -2.25, 3e100];
        let split: Vec<u8> = (0..8).flat_map(|b| numbers.map(|x| x.to_le_bytes()[b])).collect();
        assert_eq!(joined(&split, 8).unwrap(), numbers.map(f64::to_le_bytes).concat());
        assert_eq!(joined(&[], 8), Some(vec![]));
        for (bytes, width) in [(7, 8), (9, 4), (3, 0)] {
            assert_eq!(joined(&vec![0; bytes], width), None, "{bytes} {width}");
        }
    }

    #[test]
    #[expect(deprecated, reason = "old files have it")]
    fn values_stand_behind_the_levels() {
        let page = [[2, 0, 0, 0].as_slice(), &[7; 2], &[3, 0, 0, 0], &[7; 3], &[1; 8]].concat();
        let (rle, packed) = (Encoding::RLE, Encoding::BIT_PACKED);
        assert_eq!(values_begin(&page, 9, [(0, rle), (0, rle)]), Some(0));
        assert_eq!(values_begin(&page, 9, [(1, rle), (1, rle)]), Some(13));
        // Nine levels of at most 2 need 18 bits.
        assert_eq!(values_begin(&page, 9, [(0, rle), (2, packed)]), Some(3));
        for short in 0..13 {
            assert_eq!(values_begin(&page[..short], 9, [(1, rle), (1, rle)]), None, "{short}");
        }
        assert_eq!(values_begin(&page, u32::MAX, [(0, rle), (2, packed)]), None);
    }
}
