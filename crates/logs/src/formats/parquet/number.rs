//! Determines the number type of a Parquet column: integers, floating-point numbers, decimals, times, dates or INT96.

use parquet::basic::{ConvertedType, LogicalType, TimeUnit, Type};
use parquet::schema::types::ColumnDescriptor;

use crate::formats::stored_number::NumberType;

/// The number type of a column.
pub(crate) fn kind(column: &ColumnDescriptor) -> NumberType {
    let unit = |unit: &TimeUnit| match unit {
        TimeUnit::MILLIS => 1e3,
        TimeUnit::MICROS => 1e6,
        TimeUnit::NANOS => 1e9,
    };
    // The logical type is used first. Old files have only the converted type.
    match (column.logical_type_ref(), column.converted_type()) {
        (Some(LogicalType::Timestamp(t) | LogicalType::Time(t)), _) => {
            return NumberType::Time { per_second: unit(&t.unit) };
        }
        (_, ConvertedType::TIME_MILLIS | ConvertedType::TIMESTAMP_MILLIS) => {
            return NumberType::Time { per_second: 1e3 };
        }
        (_, ConvertedType::TIME_MICROS | ConvertedType::TIMESTAMP_MICROS) => {
            return NumberType::Time { per_second: 1e6 };
        }
        (Some(LogicalType::Date), _) | (_, ConvertedType::DATE) => {
            return NumberType::Time { per_second: 1.0 / 86_400.0 };
        }
        (Some(LogicalType::Decimal(_)), _) | (_, ConvertedType::DECIMAL) => {
            return NumberType::Decimal { scale: column.type_scale() };
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
    // Without a logical type of a time or a decimal, the physical type determines the number type.
    match column.physical_type() {
        Type::FLOAT | Type::DOUBLE => NumberType::Real,
        Type::INT32 | Type::INT64 => NumberType::Integer { signed: !unsigned },
        Type::INT96 => NumberType::Time { per_second: 1e9 },
        Type::FIXED_LEN_BYTE_ARRAY if column.logical_type_ref() == Some(&LogicalType::Float16) => NumberType::Half,
        Type::BOOLEAN => NumberType::Other("BOOLEAN".into()),
        Type::BYTE_ARRAY => NumberType::Other("text (BYTE_ARRAY)".into()),
        Type::FIXED_LEN_BYTE_ARRAY => NumberType::Other("bytes".into()),
    }
}
