//! Writes columns as a Parquet file with one uncompressed row group. A number that is not finite becomes null.

use std::sync::Arc;

use parquet::basic::{LogicalType, Repetition, Type as PhysicalType};
use parquet::column::writer::ColumnWriter;
use parquet::data_type::ByteArray;
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::Type;

use crate::formats::cells::Cells;

/// The bytes of a Parquet file with these named columns.
pub(crate) fn written(columns: &[(String, Cells<'_>)]) -> Result<Vec<u8>, ParquetError> {
    let fields = columns.iter().map(|(name, cells)| field(name, cells).map(Arc::new)).collect::<Result<_, _>>()?;
    let schema = Type::group_type_builder("table").with_fields(fields).build()?;
    let mut bytes = Vec::new();
    let mut file =
        SerializedFileWriter::new(&mut bytes, Arc::new(schema), Arc::new(WriterProperties::builder().build()))?;
    let mut rows = file.next_row_group()?;
    for (name, cells) in columns {
        let Some(mut column) = rows.next_column()? else {
            return Err(ParquetError::General(format!("no place for column {name}")));
        };
        write(&mut column, cells)?;
        column.close()?;
    }
    rows.close()?;
    file.close()?;
    Ok(bytes)
}

fn field(name: &str, cells: &Cells<'_>) -> Result<Type, ParquetError> {
    match cells {
        Cells::Texts(_) => Type::primitive_type_builder(name, PhysicalType::BYTE_ARRAY)
            .with_repetition(Repetition::REQUIRED)
            .with_logical_type(Some(LogicalType::String))
            .build(),
        Cells::Numbers(_) => {
            Type::primitive_type_builder(name, PhysicalType::DOUBLE).with_repetition(Repetition::OPTIONAL).build()
        }
    }
}

fn write(column: &mut SerializedColumnWriter<'_>, cells: &Cells<'_>) -> Result<(), ParquetError> {
    match (column.untyped(), cells) {
        (ColumnWriter::ByteArrayColumnWriter(writer), Cells::Texts(texts)) => {
            let texts: Vec<ByteArray> = texts.iter().map(|text| ByteArray::from(*text)).collect();
            writer.write_batch(&texts, None, None)?;
        }
        (ColumnWriter::DoubleColumnWriter(writer), Cells::Numbers(numbers)) => {
            let present: Vec<f64> = numbers.iter().copied().filter(|x| x.is_finite()).collect();
            let levels: Vec<i16> = numbers.iter().map(|x| i16::from(x.is_finite())).collect();
            writer.write_batch(&present, Some(&levels), None)?;
        }
        _ => return Err(ParquetError::General("a column of another type".into())),
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Table;

    /// The reader of this crate reads the same numbers. It is also tested with files of other writers.
    #[test]
    fn what_is_written_is_read() {
        let (t, q) = (vec![0.0, 0.1, 0.2], vec![1.5e-300, f64::NAN, -2.0 / 3.0]);
        let columns = [("t".to_string(), Cells::Numbers(t.clone())), ("q1".to_string(), Cells::Numbers(q.clone()))];
        let bytes = written(&columns).unwrap();
        assert_eq!(bytes, written(&columns).unwrap());
        let table = Table::from_bytes("series.parquet", &bytes).unwrap();
        let read = |name: &str| table.columns[table.header.iter().position(|n| n == name).unwrap()].clone();
        assert_eq!(read("t"), t);
        let found = read("q1");
        assert!(found[0] == q[0] && found[1].is_nan() && found[2] == q[2], "{found:?}");
        let texts = ("t".to_string(), Cells::Texts(vec!["a"; 2]));
        assert!(written(&[columns[0].clone(), texts]).is_err());
    }
}
