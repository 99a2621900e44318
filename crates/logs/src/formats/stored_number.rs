//! The numbers of a column whose file says their type, as Parquet and Arrow do, from the bits of each.
//!
//! These are whole and real numbers; decimals, scaled; and times with a unit. Times are in s from the first, because
//! nanoseconds since 1970 have more digits than an f64 keeps.

/// What the numbers of a column are.
#[derive(Clone, Debug, PartialEq)]
pub enum Kind {
    /// As they are, single or double precision.
    Real,
    /// Half precision.
    Half,
    /// Whole numbers.
    Integer {
        /// Whether they may be negative.
        signed: bool,
    },
    /// Whole numbers that are divided by a power of ten.
    Decimal {
        /// Its exponent.
        scale: i32,
    },
    /// Whole numbers of a unit of time.
    Time {
        /// How many units a second has.
        per_second: f64,
    },
    /// The name of a type that is not read.
    Other(String),
}

/// Makes numbers of the values of one column, in their order.
pub struct Numbers {
    /// What they are.
    pub kind: Kind,
    /// The first time.
    origin: Option<i64>,
}

impl Numbers {
    /// Of a column of this kind.
    pub fn new(kind: Kind) -> Numbers {
        Numbers { kind, origin: None }
    }

    /// The number of a value that is stored as a whole number of `bits` bits.
    pub fn integer(&mut self, value: i64, bits: u32) -> f64 {
        match self.kind {
            Kind::Time { per_second } => {
                let first = *self.origin.get_or_insert(value);
                // The difference of whole numbers is exact, so that one division gives the nearest f64.
                (i128::from(value) - i128::from(first)) as f64 / per_second
            }
            Kind::Decimal { scale } => value as f64 / 10f64.powi(scale),
            Kind::Integer { signed: false } if bits == 32 => f64::from(value as u32),
            Kind::Integer { signed: false } => value.cast_unsigned() as f64,
            _ => value as f64,
        }
    }

    /// The number of the bytes of a decimal, the highest first, or of a number of half precision.
    pub fn bytes(&self, bytes: &[u8]) -> f64 {
        match (&self.kind, bytes) {
            (Kind::Half, [low, high]) => half(u16::from_le_bytes([*low, *high])),
            (Kind::Decimal { scale }, [first, rest @ ..]) => {
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

/// What was done with a column of times.
pub fn time_note(name: &str) -> String {
    format!("column `{name}` holds times; they are counted in seconds from the first")
}

/// One bit of sign, five of exponent, ten of fraction.
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
        let decimal = Numbers::new(Kind::Decimal { scale: 2 });
        assert_eq!((decimal.bytes(&[0x01, 0x00]), decimal.bytes(&[0xff, 0x85])), (2.56, -1.23));
        for (bits, value) in [(0x3c00, 1.0), (0xc000, -2.0), (0x0001, 2f64.powi(-24)), (0x7c00, f64::INFINITY)] {
            assert_eq!(half(bits), value);
        }
        let mut days = Numbers::new(Kind::Time { per_second: 1.0 / 86_400.0 });
        assert_eq!((days.integer(20_000, 32), days.integer(20_002, 32)), (0.0, 172_800.0));
        assert_eq!(Numbers::new(Kind::Integer { signed: false }).integer(-1, 32), f64::from(u32::MAX));
    }
}
