//! A Parquet file as a table of named columns.
//!
//! The crate `parquet` reads the index and decodes the pages. This module names the columns and bounds their size. Null
//! is NaN. A list column `q` becomes q_1 .. q_k, as an array of a .npz does, if all its lists are of one length. A
//! field of a struct is `struct.field`. `number` defines the numbers of each type. A column of another type is a column
//! of text: it is refused when it is used.
//!
//! Not here: encryption, columns in other files.

use std::panic::{AssertUnwindSafe, catch_unwind};

use bytes::Bytes;
use gate::budget::Budget;
use parquet::basic::Repetition;
use parquet::column::reader::{ColumnReader, ColumnReaderImpl, get_column_reader};
use parquet::data_type::{AsBytes, DataType};
use parquet::file::metadata::{ParquetMetaData, ParquetMetaDataReader};
use parquet::schema::types::{ColumnDescPtr, Type};

use crate::Error;
use crate::formats::parquet::number::{Kind, Numbers};
use crate::formats::parquet::pages::UnpackedPages;
use crate::formats::parquet::schema_guard;
use crate::table::{MAX_CELLS, MAX_COLUMNS, Table, check_header};

/// The last bytes of a parquet file.
const PARQUET_MAGIC: &[u8] = b"PAR1";

/// Rows decoded at a time.
const ROWS_PER_BATCH: usize = 1 << 13;

/// Bytes of a number of a table, whose columns grow by doubling.
const NUMBER_BYTES: usize = 2 * size_of::<f64>();

/// Times that a page is in memory at once: unpacked, in its plain encoding, and joined with its levels.
const PAGE_COPIES: usize = 3;

/// Reads the columns of a file within a budget.
pub(crate) fn read(file: &str, bytes: &[u8], budget: &mut Budget) -> Result<Table, Error> {
    let at = |message: String| Error::at(file, 0, message);
    let metadata = footer(bytes).map_err(at)?;
    let bytes = Bytes::copy_from_slice(bytes);
    let columns = metadata.file_metadata().schema_descr().columns();
    if columns.len() > MAX_COLUMNS {
        return Err(at(format!("{} columns; at most {MAX_COLUMNS} are expected", columns.len())));
    }
    let rows = rows(&metadata).map_err(at)?;
    let content = Content { bytes: &bytes, metadata: &metadata, rows: &rows };
    let mut table = Table { file: file.into(), ..Table::default() };
    let fields = metadata.file_metadata().schema_descr().root_schema();
    let mut names = Vec::new();
    fields.get_fields().iter().for_each(|field| leaves(field, &mut Vec::new(), false, &mut names));
    for (place, (leaf, name)) in columns.iter().zip(&names).enumerate() {
        let room = MAX_CELLS / rows.iter().sum::<usize>().max(1) - table.header.len();
        let column = content.column(place, leaf, name, room, budget);
        let column = column.map_err(|e| at(format!("column `{name}`: {e}")))?;
        let width = column.series.len();
        if width > room || table.header.len() + width > MAX_COLUMNS {
            let message = format!(
                "more than {MAX_COLUMNS} columns or {MAX_CELLS} numbers, with column `{name}`; keep the columns of the \
                 robot, or a part of the rows"
            );
            return Err(at(message));
        }
        for (k, series) in column.series.into_iter().enumerate() {
            let header = if column.timed { without_unit(name) } else { name };
            table.header.push(if column.lists { format!("{name}_{}", k + 1) } else { header.to_string() });
            table.columns.push(series);
            table.texts.push(column.text.clone().map(|text| (0, text)));
        }
        if column.timed {
            let note = format!("column `{name}` holds times; they are counted in seconds from the first");
            table.notes.push(note);
        }
    }
    check_header(file, 0, &mut table.header)?;
    // A column without numbers is empty, so the rows are those of the longest column.
    let Some(rows) = table.columns.iter().map(Vec::len).max().filter(|&n| n > 0) else {
        let what = if rows.iter().all(|&n| n == 0) { "the file has no row" } else { "no column holds numbers" };
        return Err(at(format!("{what}; the columns are: {}", table.header.join(", "))));
    };
    table.columns.iter_mut().for_each(|c| c.resize(rows, f64::NAN));
    Ok(table)
}

/// The metadata at the end of the file.
fn footer(bytes: &[u8]) -> Result<ParquetMetaData, String> {
    if bytes.starts_with(b"PARE") || bytes.ends_with(b"PARE") {
        return Err("the file is encrypted; write it without encryption".into());
    }
    let cut = "the Parquet file does not end with PAR1: it is cut short, or its writer was never closed; its index \
               stands at the end, so nothing can be read: write or copy it again";
    let body = bytes.strip_suffix(PARQUET_MAGIC).filter(|b| b.len() >= 8).ok_or(cut)?;
    let (body, length) = body.split_last_chunk::<4>().ok_or(cut)?;
    let length = u32::from_le_bytes(*length) as usize;
    let start = body.len().checked_sub(length);
    let start = start.ok_or_else(|| format!("the index claims {length} bytes of a file of {}", bytes.len()))?;
    schema_guard::check(&body[start..])?;
    ParquetMetaDataReader::decode_metadata(&body[start..]).map_err(|e| format!("the index of the file is damaged: {e}"))
}

/// The rows of every row group.
fn rows(metadata: &ParquetMetaData) -> Result<Vec<usize>, String> {
    let rows: Result<Vec<usize>, _> = metadata.row_groups().iter().map(|g| usize::try_from(g.num_rows())).collect();
    let rows = rows.map_err(|_| "a row group has no length")?;
    let all = rows.iter().try_fold(0usize, |a, &b| a.checked_add(b)).filter(|&n| n <= MAX_CELLS);
    all.ok_or_else(|| format!("more than {MAX_CELLS} rows are claimed"))?;
    Ok(rows)
}

/// The names of the columns below a field; a list and its element are no part of them.
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

/// The name without its unit, since times are converted to seconds.
fn without_unit(name: &str) -> &str {
    ["_ms", "_us", "_ns"].iter().find_map(|unit| name.strip_suffix(unit)).unwrap_or(name)
}

/// The result of reading a column: one series, or one for each element of its lists.
#[derive(Default)]
struct Column {
    series: Vec<Vec<f64>>,
    lists: bool,
    /// Why it holds no numbers; the series is empty then.
    text: Option<String>,
    timed: bool,
}

/// A file and the rows of its row groups.
struct Content<'a> {
    bytes: &'a Bytes,
    metadata: &'a ParquetMetaData,
    rows: &'a [usize],
}

impl Content<'_> {
    /// Reads a column; lists of more than `room` elements are not taken apart.
    fn column(
        &self,
        place: usize,
        leaf: &ColumnDescPtr,
        name: &str,
        room: usize,
        budget: &mut Budget,
    ) -> Result<Column, String> {
        let text = |text: String| Ok(Column { series: vec![Vec::new()], text: Some(text), ..Column::default() });
        let kind = if leaf.max_rep_level() > 1 { Kind::Other("lists of lists".into()) } else { Kind::of(leaf) };
        if let Kind::Other(what) = kind {
            return text(what);
        }
        let timed = matches!(kind, Kind::Time { .. });
        let lists = leaf.max_rep_level() > 0;
        let mut numbers = Numbers::new(kind);
        let mut series = Series { lists, room: room.min(MAX_COLUMNS), ..Series::default() };
        for (group, &rows) in self.metadata.row_groups().iter().zip(self.rows) {
            let chunk = group.columns().get(place).ok_or("a row group lacks it")?;
            if chunk.file_path().is_some() {
                return Err("its data are in another file".into());
            }
            let most = if lists { rows.saturating_mul(room.clamp(1, MAX_COLUMNS)).min(MAX_CELLS) } else { rows };
            let count = usize::try_from(chunk.num_values()).unwrap_or(usize::MAX);
            if count > most || (!lists && count < rows) {
                return Err(format!("it claims {count} values where its row group has {rows} rows"));
            }
            budget.draw(count.saturating_mul(NUMBER_BYTES))?;
            let pages = Box::new(UnpackedPages::of(self.bytes, chunk, rows, budget.left() / PAGE_COPIES)?);
            if chunk.column_type() != leaf.physical_type() {
                return Err(format!("its type is {} in a row group and {name} in the schema", chunk.column_type()));
            }
            // The library may panic on damaged pages. `pages` refuses all damage that is known to cause this, so the catch
            // is for unknown cases. The series it was writing to are dropped with the error.
            let decode = || cells(get_column_reader(leaf.clone(), pages), leaf, rows, &mut numbers, &mut series);
            let found = catch_unwind(AssertUnwindSafe(decode));
            let found = found.unwrap_or_else(|_| Err("its pages are damaged".into()))?;
            if found != rows {
                return Err(format!("it has {found} rows where its row group has {rows}"));
            }
            if let Some(odd) = series.odd.take() {
                return text(odd);
            }
        }
        if series.columns.is_empty() {
            return if lists {
                text("empty lists".into())
            } else {
                Ok(Column { series: vec![Vec::new()], ..Column::default() })
            };
        }
        Ok(Column { series: series.columns, lists, text: None, timed })
    }
}

/// Numbers of the rows read so far.
#[derive(Default)]
struct Series {
    columns: Vec<Vec<f64>>,
    rows: usize,
    lists: bool,
    room: usize,
    /// Why lists are not the rows of a table, where they are not.
    odd: Option<String>,
}

impl Series {
    /// Appends rows. Each cell has its repetition level in `starts`, which is 0 where a row begins. An element that a
    /// list lacks is `None`.
    fn push(&mut self, cells: &[Option<f64>], starts: &[i16]) {
        if !self.lists {
            if self.columns.is_empty() {
                self.columns.push(Vec::new());
            }
            self.columns[0].extend(cells.iter().map(|cell| cell.unwrap_or(f64::NAN)));
            return;
        }
        let mut from = 0;
        while from < cells.len() && self.odd.is_none() {
            let next = starts[from + 1..].iter().position(|&level| level == 0);
            let to = next.map_or(cells.len(), |n| from + 1 + n);
            let row = if cells[from..to] == [None] { &[][..] } else { &cells[from..to] };
            if self.columns.is_empty() && !row.is_empty() {
                if row.len() > self.room {
                    self.odd = Some(format!("lists of {} numbers", row.len()));
                    return;
                }
                self.columns = vec![vec![f64::NAN; self.rows]; row.len()];
            }
            if !row.is_empty() && row.len() != self.columns.len() {
                self.odd = Some(format!("lists of {} and of {} numbers", self.columns.len(), row.len()));
                return;
            }
            for (k, column) in self.columns.iter_mut().enumerate() {
                column.push(row.get(k).copied().flatten().unwrap_or(f64::NAN));
            }
            self.rows += 1;
            from = to;
        }
    }
}

/// Reads the rows of a chunk into the series; returns how many there were.
fn cells(
    reader: ColumnReader,
    leaf: &ColumnDescPtr,
    rows: usize,
    numbers: &mut Numbers,
    series: &mut Series,
) -> Result<usize, String> {
    use ColumnReader::*;
    match reader {
        BoolColumnReader(_) => Err("booleans are no numbers".into()),
        Int32ColumnReader(r) => typed(r, leaf, rows, series, &mut |x| numbers.integer(i64::from(*x), 32)),
        Int64ColumnReader(r) => typed(r, leaf, rows, series, &mut |x| numbers.integer(*x, 64)),
        Int96ColumnReader(r) => typed(r, leaf, rows, series, &mut |x| numbers.integer(x.to_nanos(), 64)),
        FloatColumnReader(r) => typed(r, leaf, rows, series, &mut |x| f64::from(*x)),
        DoubleColumnReader(r) => typed(r, leaf, rows, series, &mut |x| *x),
        ByteArrayColumnReader(r) => typed(r, leaf, rows, series, &mut |x| numbers.bytes(x.as_bytes())),
        FixedLenByteArrayColumnReader(r) => typed(r, leaf, rows, series, &mut |x| numbers.bytes(x.as_bytes())),
    }
}

fn typed<T: DataType>(
    mut reader: ColumnReaderImpl<T>,
    leaf: &ColumnDescPtr,
    rows: usize,
    series: &mut Series,
    number: &mut dyn FnMut(&T::T) -> f64,
) -> Result<usize, String> {
    let (present, element) = (leaf.max_def_level(), leaf.repeated_ancestor_def_level());
    let (mut definition, mut repetition, mut values) = (Vec::new(), Vec::new(), Vec::new());
    let mut done = 0;
    while done < rows && series.odd.is_none() {
        definition.clear();
        repetition.clear();
        values.clear();
        let batch = ROWS_PER_BATCH.min(rows - done);
        let read = reader.read_records(batch, Some(&mut definition), Some(&mut repetition), &mut values);
        let (records, _, levels) = read.map_err(|e| e.to_string())?;
        if records == 0 {
            break;
        }
        let mut values = values.iter();
        let cell = |k: usize| match definition.get(k) {
            Some(&level) if level < element => None,
            Some(&level) if level < present => Some(f64::NAN),
            _ => Some(values.next().map_or(f64::NAN, &mut *number)),
        };
        let cells: Vec<Option<f64>> = (0..levels).map(cell).collect();
        if series.lists && repetition.first() != Some(&0) {
            return Err("its first list does not begin with a row".into());
        }
        series.push(&cells, &repetition);
        done += records;
    }
    Ok(if series.odd.is_some() { rows } else { done })
}
