//! The numbers of a Parquet column, from the bits of each type.
//!
//! These are whole and real numbers; decimals, scaled; and times with a unit, dates and INT96. Times are in s from the
//! first, because nanoseconds since 1970 have more digits than an f64 keeps.

use parquet::basic::{ConvertedType, LogicalType, TimeUnit, Type};
use parquet::schema::types::ColumnDescriptor;

/// What the numbers of a column are.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Kind {
    /// As they are, single or double precision.
    Real,
    /// Half precision.
    Half,
    Integer {
        signed: bool,
    },
    /// Whole numbers of ten to this power.
    Decimal {
        scale: i32,
    },
    /// Whole numbers of a unit of time.
    Time {
        per_second: f64,
    },
    /// The name of a type that is not read.
    Other(String),
}

impl Kind {
    pub(crate) fn of(column: &ColumnDescriptor) -> Kind {
        let unit = |unit: &TimeUnit| match unit {
            TimeUnit::MILLIS => 1e3,
            TimeUnit::MICROS => 1e6,
            TimeUnit::NANOS => 1e9,
        };
        match (column.logical_type_ref(), column.converted_type()) {
            (Some(LogicalType::Timestamp(t) | LogicalType::Time(t)), _) => {
                return Kind::Time { per_second: unit(&t.unit) };
            }
            (_, ConvertedType::TIME_MILLIS | ConvertedType::TIMESTAMP_MILLIS) => {
                return Kind::Time { per_second: 1e3 };
            }
            (_, ConvertedType::TIME_MICROS | ConvertedType::TIMESTAMP_MICROS) => {
                return Kind::Time { per_second: 1e6 };
            }
            (Some(LogicalType::Date), _) | (_, ConvertedType::DATE) => {
                return Kind::Time { per_second: 1.0 / 86_400.0 };
            }
            (Some(LogicalType::Decimal(_)), _) | (_, ConvertedType::DECIMAL) => {
                return Kind::Decimal { scale: column.type_scale() };
            }
            _ => {}
        }
        let unsigned = match column.logical_type_ref() {
            Some(LogicalType::Integer(integer)) => !integer.is_signed,
            _ => matches!(
                column.converted_type(),
                ConvertedType::UINT_8 | ConvertedType::UINT_16 | ConvertedType::UINT_32 | ConvertedType::UINT_64
            ),
        };
        match column.physical_type() {
            Type::FLOAT | Type::DOUBLE => Kind::Real,
            Type::INT32 | Type::INT64 => Kind::Integer { signed: !unsigned },
            Type::INT96 => Kind::Time { per_second: 1e9 },
            Type::FIXED_LEN_BYTE_ARRAY if column.logical_type_ref() == Some(&LogicalType::Float16) => Kind::Half,
            Type::BOOLEAN => Kind::Other("BOOLEAN".into()),
            Type::BYTE_ARRAY => Kind::Other("text (BYTE_ARRAY)".into()),
            Type::FIXED_LEN_BYTE_ARRAY => Kind::Other("bytes".into()),
        }
    }
}

/// Makes numbers of the values of one column, in their order.
pub(crate) struct Numbers {
    pub kind: Kind,
    /// The first time.
    origin: Option<i64>,
}

impl Numbers {
    pub(crate) fn new(kind: Kind) -> Numbers {
        Numbers { kind, origin: None }
    }

    /// The number of a value that is stored as a whole number of `bits` bits.
    pub(crate) fn integer(&mut self, value: i64, bits: u32) -> f64 {
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
    pub(crate) fn bytes(&self, bytes: &[u8]) -> f64 {
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
