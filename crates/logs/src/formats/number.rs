//! Interprets a cell of text: a number, a missing number, a date, or a word.

/// The number in a cell; NaN if the cell denotes a missing number; `None` for other text.
///
/// If the delimiter is not a comma, a comma is a decimal point. A date with a time is converted to s since 1970.
pub fn number(cell: &[u8], delimiter: Option<u8>) -> Option<f64> {
    if cell.is_empty() {
        return Some(f64::NAN);
    }
    if let Ok(x) = fast_float2::parse(cell) {
        return Some(x);
    }
    let absent = ["na", "n/a", "null", "none", "-", "?"];
    if absent.iter().any(|word| cell.eq_ignore_ascii_case(word.as_bytes())) {
        return Some(f64::NAN);
    }
    let commas = cell.iter().filter(|&&b| b == b',').count();
    if delimiter != Some(b',') && commas == 1 && !cell.contains(&b'.') {
        let pointed: Vec<u8> = cell.iter().map(|&b| if b == b',' { b'.' } else { b }).collect();
        return fast_float2::parse(pointed).ok();
    }
    date(std::str::from_utf8(cell).ok()?)
}

/// The number at the start of the bytes, and its length in bytes.
///
/// m 10^-k with integers m, k needs only one division if m and 10^k are exact floating-point numbers: m <= 2^53 and k <= 22
/// [Clinger 1990]. Controllers write such numbers. All other numbers are read by `fast_float2`.
pub(super) fn leading(bytes: &[u8]) -> Option<(f64, usize)> {
    let is_negative = bytes.first() == Some(&b'-');
    let start = usize::from(is_negative);
    let (mut integer, mut at) = (0u64, start);
    // Reads one digit at a time. There are few digits before the point, and their number is often the same as in the row above,
    // so that the processor predicts the end of the loop.
    while let Some(digit) = bytes.get(at).map(|b| b.wrapping_sub(b'0')).filter(|digit| *digit < 10) {
        integer = integer.wrapping_mul(10).wrapping_add(u64::from(digit));
        at += 1;
    }
    let mut count = at - start;
    let mut decimals = 0;
    if bytes.get(at) == Some(&b'.') {
        let mut end = at + 1;
        loop {
            let (value, digits) = some_digits(&bytes[end..]);
            integer = integer.wrapping_mul(INTEGER_POWERS_OF_TEN[digits]).wrapping_add(value);
            end += digits;
            if digits < 8 {
                break;
            }
        }
        decimals = end - at - 1;
        (count, at) = (count + decimals, end);
    }
    // Eighteen digits do not overflow. If a letter follows, it may be an exponent.
    let is_plain = (1..=18).contains(&count) && !bytes.get(at).is_some_and(u8::is_ascii_alphabetic);
    if !is_plain || integer > 1 << 53 {
        return fast_float2::parse_partial(bytes).ok();
    }
    let x = integer as f64 / EXACT_POWERS_OF_TEN[decimals];
    Some((if is_negative { -x } else { x }, at))
}

/// The value of the digits at the start, at most eight, and the number of digits.
///
/// Reads eight bytes at once: the digits are shifted to the end, after zeros, and combined in pairs, fours and eights [Lemire
/// 2021].
fn some_digits(bytes: &[u8]) -> (u64, usize) {
    let Some(eight) = bytes.first_chunk::<8>() else {
        let digit = |b: &u8| Some(u64::from(b.wrapping_sub(b'0'))).filter(|digit| *digit < 10);
        return bytes.iter().map_while(digit).fold((0, 0), |(value, count), digit| (10 * value + digit, count + 1));
    };
    let values = u64::from_le_bytes(*eight) ^ 0x3030_3030_3030_3030;
    // Sets the highest bit of each byte that is above nine. A carry only affects bytes after such a byte.
    let others = (values.wrapping_add(0x7676_7676_7676_7676) | values) & 0x8080_8080_8080_8080;
    let count = others.trailing_zeros() as usize / 8;
    if count == 0 {
        return (0, 0);
    }
    (eight_digits(values << (64 - 8 * count)), count)
}

/// The value of eight digits, one per byte. The first digit is in the lowest byte.
#[inline(always)]
fn eight_digits(values: u64) -> u64 {
    let pairs = values.wrapping_mul(10).wrapping_add(values >> 8);
    let low = (pairs & 0x0000_00ff_0000_00ff).wrapping_mul(0x000f_4240_0000_0064);
    let high = (pairs >> 16 & 0x0000_00ff_0000_00ff).wrapping_mul(0x0000_2710_0000_0001);
    low.wrapping_add(high) >> 32
}

/// The number in the bytes from `start` to `end`, if it has only digits and at most one point, with at most eight characters
/// after its sign. Otherwise `None`.
///
/// All characters are read at once, and the point is removed. The result equals the result of [`leading`].
#[inline(always)]
pub(super) fn short(bytes: &[u8], start: usize, end: usize) -> Option<f64> {
    let is_negative = usize::from(*bytes.get(start)? == b'-');
    let length = end.wrapping_sub(start + is_negative);
    let eight = bytes.get(end.wrapping_sub(8)..)?.first_chunk::<8>()?;
    if !(1..=8).contains(&length) {
        return None;
    }
    let outside = 64 - 8 * length as u32;
    let mut values = (u64::from_le_bytes(*eight) ^ 0x3030_3030_3030_3030) >> outside << outside;
    // Sets the highest bit of each byte above nine, as in `some_digits`. Only one such byte is allowed: the point.
    let others = (values.wrapping_add(0x7676_7676_7676_7676) | values) & 0x8080_8080_8080_8080;
    let mut decimals = 0;
    if others != 0 {
        let point = others.trailing_zeros() - 7;
        if others & (others - 1) != 0 || values >> point & 0xff != u64::from(b'.' ^ b'0') || length == 1 {
            return None;
        }
        let before = values & ((1 << point) - 1);
        let behind = values ^ before ^ u64::from(b'.' ^ b'0') << point;
        values = before << 8 | behind;
        decimals = (56 - point) as usize / 8;
    }
    Some(eight_digits(values).cast_signed() as f64 / SIGNED_POWERS_OF_TEN[is_negative][decimals])
}

/// Powers of ten as integers; the index is the exponent.
const INTEGER_POWERS_OF_TEN: [u64; 9] = [1, 10, 100, 1_000, 10_000, 100_000, 1_000_000, 10_000_000, 100_000_000];

/// Powers of ten as floating-point numbers, all exact; the index is the exponent.
const EXACT_POWERS_OF_TEN: [f64; 19] =
    [1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18];

/// 10^k and -10^k. The division by -10^k gives the negative number.
const SIGNED_POWERS_OF_TEN: [[f64; 8]; 2] =
    [[1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7], [-1e0, -1e1, -1e2, -1e3, -1e4, -1e5, -1e6, -1e7]];

/// Whether a cell is a word: text that is not a number.
pub(super) fn is_word(cell: &[u8], delimiter: Option<u8>) -> bool {
    std::str::from_utf8(cell).is_ok() && number(cell, delimiter).is_none()
}

/// Converts `2026-11-21 07:49:04.25` to s since 1970. There may be a `T` between date and time, and a `Z` at the end.
fn date(cell: &str) -> Option<f64> {
    let (day, time) = cell.trim_end_matches('Z').split_once(['T', ' '])?;
    let parts = |text: &str, separator: char| -> Option<[f64; 3]> {
        let numbers: Option<Vec<f64>> = text.split(separator).map(|n| n.parse().ok()).collect();
        numbers?.try_into().ok()
    };
    let ([year, month, day], [hours, minutes, seconds]) = (parts(day, '-')?, parts(time, ':')?);
    let inside = (1970.0..2100.0).contains(&year) && (1.0..13.0).contains(&month) && (1.0..32.0).contains(&day);
    // Days since 1970 in the Gregorian calendar. The year is counted from March, so that the leap day is its last day.
    let (y, m) = if month > 2.0 { (year, month - 3.0) } else { (year - 1.0, month + 9.0) };
    let days = 365.0 * y + (y / 4.0).floor() - (y / 100.0).floor() + (y / 400.0).floor();
    let days = days + ((153.0 * m + 2.0) / 5.0).floor() + day - 719_469.0;
    inside.then_some(86_400.0 * days + 3600.0 * hours + 60.0 * minutes + seconds)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_are_seconds() {
        // The expected seconds are from `date -u -d .. +%s`.
        for (text, seconds) in [
            ("1970-01-01 00:00:00", 0.0),
            ("2000-02-29T12:00:00Z", 951_825_600.0),
            ("2026-11-21 07:49:04.25", 1_795_247_344.25),
        ] {
            assert_eq!(date(text), Some(seconds), "{text}");
        }
        assert_eq!(date("2026-13-01 00:00:00"), None);
        assert_eq!(date("elbow up"), None);
    }

    #[test]
    fn plain_numbers_are_those_of_the_library() {
        let numbers =
            ["0", "-0", "7", "-12.5", "123456789.123456", "12345678", "0.00000001", "99999999.9", ".5", "3.", "1e3"];
        for text in numbers {
            for behind in ["", ",", ",123456789", "\n0", " ", "\u{ff}\u{ff}9999999"] {
                let bytes = format!("{text}{behind}");
                let (x, length) = leading(bytes.as_bytes()).unwrap();
                let expected: f64 = fast_float2::parse(text).unwrap();
                assert_eq!((x.to_bits(), length), (expected.to_bits(), text.len()), "{bytes:?}");
                let bytes = format!("9,999,99{bytes}");
                let short = short(bytes.as_bytes(), 8, 8 + text.len());
                let is_short = text.trim_start_matches('-').len() <= 8 && !text.contains('e');
                assert_eq!(short.map(f64::to_bits), is_short.then_some(expected.to_bits()), "{bytes:?}");
            }
        }
        for text in ["", "-", "x", ","] {
            assert_eq!(leading(text.as_bytes()), None, "{text:?}");
        }
        let no_plain = [
            "", "-", ".", "-.", "1.2.3", "1 2", "--1", "+1", "1e3", "nan", "0x10", "\u{663}", "1\u{ff}", "/", ":",
            " 7", "7\r",
        ];
        for text in no_plain {
            let bytes = format!("99999999{text},9");
            assert_eq!(short(bytes.as_bytes(), 8, 8 + text.len()), None, "{text:?}");
        }
        assert_eq!(short(b"1.5", 0, 3), None, "there are no eight bytes");
    }

    #[test]
    fn what_is_no_number() {
        for none in ["", "NA", "n/a", "Null", "NONE", "-", "?", "nan", "-NaN"] {
            assert!(number(none.as_bytes(), Some(b',')).is_some_and(f64::is_nan), "{none}");
        }
        for word in ["auto", "1e", "1 2", "0x10", "1_000", "--1", "\u{663}"] {
            assert_eq!(number(word.as_bytes(), Some(b',')), None, "{word}");
            assert!(is_word(word.as_bytes(), Some(b',')));
        }
        assert_eq!(number(b"1,5", Some(b';')), Some(1.5));
        assert_eq!(number(b"1,5", Some(b',')), None);
        assert!(!is_word(b"\xff\xfe", Some(b',')));
    }
}
