//! Reads a Parquet file as tables of named columns, some rows at a time.
//!
//! The crate `parquet` reads the index and decodes the pages. This module names the columns and bounds their size; `column` reads
//! one column. Null becomes NaN. A list column `q` becomes q_1 .. q_k, as for a .npz, if all lists have the same length. A field
//! of a struct becomes `struct.field`. `number` defines the numbers of each type. A column of another type is a text column;
//! using it is an error.
//!
//! For a file on disk, only the current page of each column is in memory, so the memory does not depend on the size of the file.
//!
//! Not supported: encryption, and columns in other files.

use std::sync::Arc;

use bytes::Bytes;
use gate::budget::Budget;
use gate::source::RandomAccessFile;
use parquet::basic::Repetition;
use parquet::file::metadata::{ParquetMetaData, ParquetMetaDataReader};
use parquet::file::reader::Length;
use parquet::schema::types::Type;

use crate::Error;
use crate::formats::parquet::column::{ListSurvey, ParquetColumn, RowRange};
use crate::formats::parquet::file_bytes::FileBytes;
use crate::formats::parquet::schema_guard;
use crate::formats::stored_number::time_note;
use crate::table::{MAX_CELLS, MAX_COLUMNS, RowReader, Table, check_header};

/// The magic bytes at the start and at the end of a Parquet file.
const PARQUET_MAGIC: &[u8] = b"PAR1";

/// Number of bytes after the index: its length and the magic bytes.
const TAIL_BYTES: usize = 8;

/// Reads all columns of a file. The memory is taken from `budget`.
pub(crate) fn read(file: &str, bytes: &[u8], budget: &mut Budget) -> Result<Table, Error> {
    let bytes = FileBytes::Held(Bytes::copy_from_slice(bytes));
    let mut reader = ParquetReader::new(file, bytes, budget.clone())?;
    let table = reader.rows(usize::MAX);
    *budget = reader.budget;
    table
}

/// Reads the rows of a Parquet file.
pub(crate) struct ParquetReader {
    file: String,
    bytes: FileBytes,
    metadata: ParquetMetaData,
    columns: Vec<ParquetColumn>,
    budget: Budget,
    /// Number of rows of each row group.
    groups: Vec<usize>,
    /// The current row group. `before`: number of its rows that were already read.
    group: usize,
    before: usize,
    /// Number of rows that were returned so far.
    handed: usize,
    /// Names of the columns in every table.
    header: Vec<String>,
    notes: Vec<String>,
}

impl ParquetReader {
    /// Opens a file on disk and reads its index.
    pub(crate) fn of_file(file: &str, pieces: RandomAccessFile) -> Result<ParquetReader, Error> {
        let budget = Budget::of(usize::try_from(pieces.length()).unwrap_or(usize::MAX));
        ParquetReader::new(file, FileBytes::Pieces(Arc::new(pieces)), budget)
    }

    fn new(file: &str, bytes: FileBytes, budget: Budget) -> Result<ParquetReader, Error> {
        let at = |message: String| Error::at(file, 0, message);
        let metadata = footer(&bytes).map_err(at)?;
        let schema = metadata.file_metadata().schema_descr();
        if schema.num_columns() > MAX_COLUMNS {
            return Err(at(format!("{} columns; at most {MAX_COLUMNS} are expected", schema.num_columns())));
        }
        let groups = rows(&metadata).map_err(at)?;
        let mut names = Vec::new();
        let fields = schema.root_schema().get_fields();
        fields.iter().for_each(|field| leaves(field, &mut Vec::new(), false, &mut names));
        let columns = schema.columns().iter().zip(names).enumerate();
        let mut columns: Vec<ParquetColumn> =
            columns.map(|(place, (leaf, name))| ParquetColumn::new(place, leaf, name)).collect();
        let room = (MAX_CELLS / groups.iter().sum::<usize>().max(1)).saturating_sub(columns.len());
        let content = ListSurvey { bytes: &bytes, metadata: &metadata, groups: &groups, room };
        for column in &mut columns {
            // The rows that are read to find the length of the lists are not kept; they are read again later.
            let measured = column.measure_lists(&content, &mut budget.clone());
            measured.map_err(|e| at(format!("column `{}`: {e}", column.name)))?;
        }
        let mut header: Vec<String> = columns.iter().flat_map(ParquetColumn::headers).collect();
        check_header(file, 0, &mut header)?;
        let timed = columns.iter().filter(|column| column.timed);
        let notes = timed.map(|column| time_note(&column.name)).collect();
        let file = file.into();
        let reader = ParquetReader {
            file,
            bytes,
            metadata,
            columns,
            budget,
            groups,
            group: 0,
            before: 0,
            handed: 0,
            header,
            notes,
        };
        Ok(reader)
    }

    /// Reads the next rows into the columns.
    fn read(&mut self, rows: usize) -> Result<(), Error> {
        let (file, open) = (&self.file, self.columns.iter().filter(|column| column.is_read()).count());
        let named = |column: &ParquetColumn, e: String| Error::at(file, 0, format!("column `{}`: {e}", column.name));
        let budget = &mut self.budget;
        self.columns.iter_mut().try_for_each(|column| column.begin(rows, budget).map_err(|e| named(column, e)))?;
        // Largest number of elements of a list. With more elements, the table would exceed the largest number of cells.
        let room = MAX_CELLS / rows.max(1);
        let mut left = rows;
        while left > 0 {
            let all = self.groups[self.group];
            let count = left.min(all - self.before);
            let (group, before) = (self.metadata.row_group(self.group), self.before);
            if count > 0 {
                let rows = RowRange { bytes: &self.bytes, group, all, before, count, columns: open };
                let mut read =
                    |column: &mut ParquetColumn| column.read(&rows, room, budget).map_err(|e| named(column, e));
                self.columns.iter_mut().try_for_each(&mut read)?;
            }
            (left, self.before) = (left - count, before + count);
            if self.before == all {
                (self.group, self.before) = (self.group + 1, 0);
            }
        }
        Ok(())
    }

    /// Makes a table of the rows that were read. `rows`: their number.
    fn table(&mut self, rows: usize) -> Table {
        let (file, header, notes) = (self.file.clone(), self.header.clone(), self.notes.clone());
        let mut table = Table { file, header, notes, skipped: self.handed, ..Table::default() };
        let mut without_numbers = Vec::new();
        for column in &mut self.columns {
            let (mut series, text) = column.take();
            if column.wanted && text.is_some() {
                without_numbers.extend(table.columns.len()..table.columns.len() + series.len());
            }
            table.texts.extend(vec![text.clone().map(|text| (0, text)); series.len()]);
            let has_numbers = series.iter().any(|x| !x.is_empty());
            if has_numbers {
                series.iter_mut().for_each(|x| x.resize(rows, f64::NAN));
            }
            table.columns.extend(series);
        }
        // A text column gets NaN in every row; a column that is not read stays empty.
        if table.rows() > 0 {
            without_numbers.iter().for_each(|&c| table.columns[c] = vec![f64::NAN; rows]);
        }
        table
    }
}

impl RowReader for ParquetReader {
    fn width(&self) -> usize {
        self.header.len()
    }

    fn keep(&mut self, columns: &[usize]) {
        let mut first = 0;
        for column in &mut self.columns {
            let next = first + column.width();
            column.wanted = columns.iter().any(|c| (first..next).contains(c));
            if !column.wanted {
                column.close();
            }
            first = next;
        }
    }

    fn rows(&mut self, most: usize) -> Result<Table, Error> {
        let left = self.groups[self.group..].iter().sum::<usize>() - self.before;
        let rows = most.min(left);
        let is_read = self.columns.iter().filter(|column| column.is_read());
        let width: usize = is_read.map(ParquetColumn::width).sum();
        if self.header.len() > MAX_COLUMNS || rows.saturating_mul(width) > MAX_CELLS {
            let message = format!(
                "{rows} rows of {width} columns: at most {MAX_COLUMNS} columns and {MAX_CELLS} numbers are expected; keep the \
                 columns of the robot, or a part of the rows"
            );
            return Err(Error::at(&self.file, 0, message));
        }
        self.read(rows)?;
        let table = self.table(rows);
        if rows == left {
            let unchanged = self.bytes.unchanged();
            unchanged.map_err(|e| Error::at(&self.file, 0, format!("cannot be read: {e}")))?;
        }
        if self.handed == 0 && table.rows() == 0 {
            let what = if rows == 0 { "the file has no row" } else { "no column holds numbers" };
            let message = format!("{what}; the columns are: {}", table.header.join(", "));
            return Err(Error::at(&self.file, 0, message));
        }
        self.handed += rows;
        Ok(table)
    }
}

/// The metadata at the end of the file. Fails if the file is encrypted or damaged.
fn footer(bytes: &FileBytes) -> Result<ParquetMetaData, String> {
    let all = bytes.len();
    let piece = |place: u64, count: usize| bytes.piece(place, count).map_err(|e| format!("cannot be read: {e}"));
    let (head, tail) = (piece(0, PARQUET_MAGIC.len())?, piece(all.saturating_sub(TAIL_BYTES as u64), TAIL_BYTES)?);
    if head.starts_with(b"PARE") || tail.ends_with(b"PARE") {
        return Err("the file is encrypted; write it without encryption".into());
    }
    let cut = "the Parquet file does not end with PAR1: it is cut short, or its writer was never closed; its index \
               stands at the end, so nothing can be read: write or copy it again";
    let length = tail.strip_suffix(PARQUET_MAGIC).filter(|_| all >= (PARQUET_MAGIC.len() + TAIL_BYTES) as u64);
    let length = length.and_then(|length| length.try_into().ok()).map(u32::from_le_bytes).ok_or(cut)?;
    let start = (all - TAIL_BYTES as u64).checked_sub(u64::from(length));
    let start = start.ok_or_else(|| format!("the index claims {length} bytes of a file of {all}"))?;
    let index = piece(start, length as usize)?;
    schema_guard::check(&index)?;
    ParquetMetaDataReader::decode_metadata(&index).map_err(|e| format!("the index of the file is damaged: {e}"))
}

/// The number of rows of each row group. Fails if there are too many rows.
fn rows(metadata: &ParquetMetaData) -> Result<Vec<usize>, String> {
    let rows: Result<Vec<usize>, _> = metadata.row_groups().iter().map(|g| usize::try_from(g.num_rows())).collect();
    let rows = rows.map_err(|_| "a row group has no length")?;
    let all = rows.iter().try_fold(0usize, |a, &b| a.checked_add(b)).filter(|&n| n <= MAX_CELLS);
    all.ok_or_else(|| format!("more than {MAX_CELLS} rows are claimed"))?;
    Ok(rows)
}

/// The column names below a field. A list and its element add no level to the name.
fn leaves<'a>(field: &'a Type, path: &mut Vec<&'a str>, in_list: bool, out: &mut Vec<String>) {
    let info = field.get_basic_info();
    let repeated = info.has_repetition() && info.repetition() == Repetition::REPEATED;
    let is_list = repeated && field.is_group() && field.get_fields().len() == 1;
    let named = !is_list && !in_list;
    if named {
        path.push(field.name());
    }
    if field.is_group() {
        field.get_fields().iter().for_each(|below| leaves(below, path, is_list, out));
    } else {
        out.push(path.join("."));
    }
    if named {
        path.pop();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use gate::source::Source;
    use parquet::data_type::DoubleType;
    use parquet::file::properties::WriterProperties;
    use parquet::file::writer::SerializedFileWriter;
    use parquet::schema::parser::parse_message_type;

    /// A file with row groups of 1000, 1, 700 and 999 rows. Columns: a clock; lists of two numbers, the first 1500 of them empty;
    /// and a torque that is null in every ninth row.
    fn file() -> Vec<u8> {
        let schema = "message log { REQUIRED DOUBLE t; REPEATED DOUBLE q; OPTIONAL DOUBLE tau; }";
        let schema = Arc::new(parse_message_type(schema).unwrap());
        let mut bytes = Vec::new();
        let mut file =
            SerializedFileWriter::new(&mut bytes, schema, Arc::new(WriterProperties::builder().build())).unwrap();
        let mut first = 0;
        for rows in [1000, 1, 700, 999] {
            let range = first..first + rows;
            first += rows;
            let mut group = file.next_row_group().unwrap();
            let (mut values, mut definition, mut repetition) = (Vec::new(), Vec::new(), Vec::new());
            for row in range.clone() {
                let elements = if row < 1500 { 0 } else { 2 };
                repetition.extend((0..elements.max(1)).map(|k: i16| k.min(1)));
                definition.extend(vec![elements.min(1); elements.max(1) as usize]);
                values.extend((0..elements).map(|k| f64::from(row) + 0.5 * f64::from(k)));
            }
            let times: Vec<f64> = range.clone().map(|row| 0.01 * f64::from(row)).collect();
            let present: Vec<i16> = range.clone().map(|row| i16::from(row % 9 > 0)).collect();
            let torques: Vec<f64> = range.filter(|row| row % 9 > 0).map(f64::from).collect();
            let columns =
                [(times, None, None), (values, Some(definition), Some(repetition)), (torques, Some(present), None)];
            for (values, definition, repetition) in columns {
                let mut column = group.next_column().unwrap().unwrap();
                column
                    .typed::<DoubleType>()
                    .write_batch(&values, definition.as_deref(), repetition.as_deref())
                    .unwrap();
                column.close().unwrap();
            }
            group.close().unwrap();
        }
        file.close().unwrap();
        bytes
    }

    #[test]
    fn rows_across_row_groups() {
        let bytes = file();
        let whole = Table::from_bytes("log", &bytes).unwrap();
        assert_eq!((whole.rows(), whole.header.join(" ")), (2700, "t q_1 q_2 tau".into()));
        let bits = |x: &[f64]| x.iter().map(|x| x.to_bits()).collect::<Vec<u64>>();
        for (row, q) in [(1499, [f64::NAN; 2]), (1500, [1500.0, 1500.5]), (2699, [2699.0, 2699.5])] {
            assert_eq!(bits(&[whole.columns[1][row], whole.columns[2][row]]), bits(&q), "{row}");
        }
        assert!(whole.columns[3][2600].is_finite() && whole.columns[3][18].is_nan());
        let path = std::env::temp_dir().join(format!("rist-row-groups-{}.parquet", std::process::id()));
        std::fs::write(&path, &bytes).unwrap();
        for (most, kept) in [(1, vec![0, 1, 2, 3]), (7, vec![0, 2]), (1300, vec![3]), (5000, vec![0, 1, 2, 3])] {
            let pieces = Source::open(&path).unwrap().pieces().unwrap().unwrap_or_else(|_| panic!("it is a file"));
            let mut reader = ParquetReader::of_file("log", pieces).unwrap();
            reader.keep(&kept);
            let mut found = vec![Vec::new(); 4];
            loop {
                let table = reader.rows(most).unwrap();
                if table.rows() == 0 {
                    break;
                }
                assert_eq!((table.skipped, table.header), (found[kept[0]].len(), whole.header.clone()));
                found.iter_mut().zip(&table.columns).for_each(|(found, some)| found.extend_from_slice(some));
            }
            for (c, found) in found.iter().enumerate() {
                // Either all elements of a list are read, or no element.
                let is_read = kept.contains(&c) || (c == 1 && kept.contains(&2));
                assert_eq!(bits(found), if is_read { bits(&whole.columns[c]) } else { Vec::new() }, "{most} {c}");
            }
        }
        std::fs::remove_file(&path).unwrap();
    }
}
