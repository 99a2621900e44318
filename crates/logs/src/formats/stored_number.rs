//! Converts stored values of a typed column, as in Parquet and Arrow, to numbers.
//!
//! The types are integers, floating-point numbers, scaled decimals, and times with a unit. Times are counted from the first
//! time (s), because nanoseconds since 1970 have more digits than an f64.

/// The type of the numbers in a column.
#[derive(Clone, Debug, PartialEq)]
pub enum NumberType {
    /// Floating-point numbers of single or double precision.
    Real,
    /// Floating-point numbers of half precision.
    Half,
    /// Integers.
    Integer {
        /// Whether the integers may be negative.
        signed: bool,
    },
    /// Integers divided by a power of ten.
    Decimal {
        /// The exponent of the power of ten.
        scale: i32,
    },
    /// Times, stored as integers.
    Time {
        /// Number of time units per second.
        per_second: f64,
    },
    /// A type that cannot be read: its name.
    Other(String),
}

/// Converts the values of one column to numbers, in their order.
pub struct Numbers {
    /// The type of the values.
    pub kind: NumberType,
    /// The first time of the column, which is subtracted; `None` before the first value.
    origin: Option<i64>,
}

impl Numbers {
    /// Starts a column with this type.
    pub fn new(kind: NumberType) -> Numbers {
        Numbers { kind, origin: None }
    }

    /// Converts a value that is stored as an integer of `bits` bits.
    pub fn integer(&mut self, value: i64, bits: u32) -> f64 {
        match self.kind {
            NumberType::Time { per_second } => {
                let first = *self.origin.get_or_insert(value);
                // The difference of integers is exact, so a single division gives the nearest f64.
                (i128::from(value) - i128::from(first)) as f64 / per_second
            }
            NumberType::Decimal { scale } => value as f64 / 10f64.powi(scale),
            NumberType::Integer { signed: false } if bits == 32 => f64::from(value as u32),
            NumberType::Integer { signed: false } => value.cast_unsigned() as f64,
            _ => value as f64,
        }
    }

    /// Converts the bytes of a decimal (highest byte first), or of a number of half precision.
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

/// The name of a time column without its unit, because times are converted to s.
pub fn without_unit(name: &str) -> &str {
    ["_ms", "_us", "_ns"].iter().find_map(|unit| name.strip_suffix(unit)).unwrap_or(name)
}

/// The note on a time column.
pub fn time_note(name: &str) -> String {
    format!("column `{name}` holds times; they are counted in seconds from the first")
}

/// Converts a number of half precision: one sign bit, five exponent bits, ten fraction bits.
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
