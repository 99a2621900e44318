//! The numbers of a column with a type in the file, as in Parquet and Arrow, from their bits.
//!
//! Whole and real numbers; decimals, scaled; and times with a unit. Times are in s since the first, because nanoseconds since
//! 1970 have more digits than an f64.

/// The kind of the numbers of a column.
#[derive(Clone, Debug, PartialEq)]
pub enum NumberType {
    /// Single or double precision.
    Real,
    /// Half precision.
    Half,
    /// Integers.
    Integer {
        /// Whether they may be negative.
        signed: bool,
    },
    /// Integers divided by a power of ten.
    Decimal {
        /// The exponent of the power of ten.
        scale: i32,
    },
    /// Times as integers.
    Time {
        /// Units in a second.
        per_second: f64,
    },
    /// The name of a type that is not read.
    Other(String),
}

/// Converts the values of one column to numbers, in their order.
pub struct Numbers {
    /// The kind of the values.
    pub kind: NumberType,
    /// The first time.
    origin: Option<i64>,
}

impl Numbers {
    /// For a column of this kind.
    pub fn new(kind: NumberType) -> Numbers {
        Numbers { kind, origin: None }
    }

    /// The number of a value that is stored as an integer of `bits` bits.
    pub fn integer(&mut self, value: i64, bits: u32) -> f64 {
        match self.kind {
            NumberType::Time { per_second } => {
                let first = *self.origin.get_or_insert(value);
                // The difference of integers is exact, so one division gives the nearest f64.
                (i128::from(value) - i128::from(first)) as f64 / per_second
            }
            NumberType::Decimal { scale } => value as f64 / 10f64.powi(scale),
            NumberType::Integer { signed: false } if bits == 32 => f64::from(value as u32),
            NumberType::Integer { signed: false } => value.cast_unsigned() as f64,
            _ => value as f64,
        }
    }

    /// The number from the bytes of a decimal, the highest first, or of a number of half precision.
    pub fn bytes(&self, bytes: &[u8]) -> f64 {
        match (&self.kind, bytes) {
            (NumberType::Half, [low, high]) => half(u16::from_le_bytes([*low, *high])),
            (NumberType::Decimal { scale }, [first, rest @ ..]) => {
                let first = f64::from(first.cast_signed());
                rest.iter().fold(first, |n, b| 256.0 * n + f64::from(*b)) / 10f64.powi(*scale)
            }
            _ => f64::NAN,
        }
    }
}

/// The name of a column of times without its unit, since times are converted to seconds.
pub fn without_unit(name: &str) -> &str {
    ["_ms", "_us", "_ns"].iter().find_map(|unit| name.strip_suffix(unit)).unwrap_or(name)
}

/// The note on a column of times.
pub fn time_note(name: &str) -> String {
    format!("column `{name}` holds times; they are counted in seconds from the first")
}

/// The number of half precision: one bit of sign, five of exponent, ten of fraction.
fn half(bits: u16) -> f64 {
    let (exponent, fraction) = (i32::from(bits >> 10 & 31), f64::from(bits & 1023));
    let size = match exponent {
        0 => fraction / 1024.0 * 2f64.powi(-14),
        31 if fraction == 0.0 => f64::INFINITY,
        31 => f64::NAN,
        _ => (1.0 + fraction / 1024.0) * 2f64.powi(exponent - 15),
    };
    if bits >> 15 == 1 { -size } else { size }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_of_numbers() {
        let decimal = Numbers::new(NumberType::Decimal { scale: 2 });
        assert_eq!((decimal.bytes(&[0x01, 0x00]), decimal.bytes(&[0xff, 0x85])), (2.56, -1.23));
        for (bits, value) in [(0x3c00, 1.0), (0xc000, -2.0), (0x0001, 2f64.powi(-24)), (0x7c00, f64::INFINITY)] {
            assert_eq!(half(bits), value);
        }
        let mut days = Numbers::new(NumberType::Time { per_second: 1.0 / 86_400.0 });
        assert_eq!((days.integer(20_000, 32), days.integer(20_002, 32)), (0.0, 172_800.0));
        assert_eq!(Numbers::new(NumberType::Integer { signed: false }).integer(-1, 32), f64::from(u32::MAX));
    }
}
