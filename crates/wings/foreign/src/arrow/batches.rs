//! Reads an Arrow file (Feather, version 2) or stream as a table with named columns, batch by batch (a batch is a group of rows).
//!
//! Only one batch and the rows that were not returned yet are in memory. A null value becomes NaN.
//!
//! Not supported: dictionary-encoded values, tensors, big-endian files.

use std::io::Read;

use gate::budget::Budget;

use crate::arrow::batch::{Batch, BatchColumn};
use crate::arrow::flatbuffer::FlatTable as Description;
use crate::arrow::messages::{FILE_MAGIC, Messages, RECORD_BATCH, ReadRange};
use crate::arrow::schema::{ArrowField, Layout};
use logs::Error;
use logs::Table;
use logs::reading::{MAX_CELLS, MAX_COLUMNS, RowReader, check_header};
use logs::reading::{time_note, without_unit};

/// Reads the rows of an Arrow file or stream.
pub(crate) struct ArrowReader<'a> {
    file: String,
    messages: Messages<'a>,
    /// Memory budget; it grows with the number of bytes of the file that were read.
    budget: Budget,
    fields: Vec<ArrowField>,
    columns: Vec<BatchColumn>,
    header: Vec<String>,
    notes: Vec<String>,
    /// Number of rows that `columns` hold now. `taken`: number of these rows that were already returned to the caller.
    rows: usize,
    taken: usize,
    /// Number of rows that were returned in total.
    handed: usize,
    ended: bool,
}

impl<'a> ArrowReader<'a> {
    /// Opens a file of `length` bytes: reads its index and its first rows.
    pub(crate) fn of_file(file: &str, pieces: ReadRange<'a>, length: u64) -> Result<ArrowReader<'a>, Error> {
        ArrowReader::new(file, Messages::of_file(pieces, length))
    }

    /// Opens a stream: reads its schema and its first rows.
    pub(crate) fn of_stream(file: &str, source: impl Read + Send + 'a) -> Result<ArrowReader<'a>, Error> {
        ArrowReader::new(file, Messages::of_stream(Box::new(source)))
    }

    /// Opens a file or a stream whose whole content `bytes` is in memory.
    pub(crate) fn of_bytes(file: &str, bytes: &'a [u8]) -> Result<ArrowReader<'a>, Error> {
        if !bytes.starts_with(FILE_MAGIC) {
            return ArrowReader::of_stream(file, bytes);
        }
        let piece = |at: u64, count: usize| {
            let start = usize::try_from(at).unwrap_or(usize::MAX);
            let piece = bytes.get(start..start.saturating_add(count));
            piece.map(<[u8]>::to_vec).ok_or_else(|| std::io::ErrorKind::UnexpectedEof.into())
        };
        ArrowReader::of_file(file, Box::new(piece), bytes.len() as u64)
    }

    /// Makes a reader and reads the first rows, because the lengths of the lists in them determine the columns.
    fn new(file: &str, begun: Result<(Messages<'a>, Vec<ArrowField>), String>) -> Result<ArrowReader<'a>, Error> {
        let at = |e: String| Error::at(file, 0, e);
        let (messages, fields) = begun.map_err(at)?;
        let mut columns = Vec::new();
        leaves(&fields, &mut columns);
        if columns.is_empty() || columns.len() > MAX_COLUMNS {
            return Err(at(format!("{} columns; at least one and at most {MAX_COLUMNS} are expected", columns.len())));
        }
        let mut reader = ArrowReader {
            file: file.into(),
            messages,
            budget: Budget::of(0),
            fields,
            columns,
            header: Vec::new(),
            notes: Vec::new(),
            rows: 0,
            taken: 0,
            handed: 0,
            ended: false,
        };
        // Empty batches at the start are skipped.
        while reader.rows == 0 && !reader.ended {
            reader.next_batch().map_err(at)?;
        }
        reader.header = reader.columns.iter().flat_map(headers).collect();
        check_header(file, 0, &mut reader.header)?;
        let timed = reader.columns.iter().filter(|column| column.is_timed());
        reader.notes = timed.map(|column| time_note(&column.name)).collect();
        Ok(reader)
    }

    /// Reads the next message. If it is a batch, adds its rows.
    fn next_batch(&mut self) -> Result<(), String> {
        let Some(message) = self.messages.next()? else {
            self.ended = true;
            return Ok(());
        };
        if message.kind != RECORD_BATCH {
            return Ok(());
        }
        self.budget.grow(message.description.len() + message.body.len());
        let added = (|| {
            let description = Description::root(&message.description)?.table(2)?.ok_or("it has no description")?;
            let batch = Batch::new(&description, message.body)?;
            // Rows that were returned already are removed before new rows are added.
            for series in self.columns.iter_mut().flat_map(|column| &mut column.series) {
                series.drain(..self.taken.min(series.len()));
            }
            (self.rows, self.taken) = (self.rows - self.taken, 0);
            let rows = self.rows + batch.rows;
            let width: usize = self.columns.iter().filter(|column| column.is_read()).map(BatchColumn::width).sum();
            if rows.saturating_mul(width.max(1)) > MAX_CELLS {
                return Err(format!(
                    "{rows} rows of {width} columns: at most {MAX_CELLS} numbers are expected; keep the columns of the \
                     robot, or a part of the rows"
                ));
            }
            batch.read(&self.fields, &mut self.columns, &mut self.budget)?;
            self.rows = rows;
            Ok(())
        })();
        added.map_err(|e: String| format!("{}: {e}", self.messages.place()))
    }

    /// The next `count` rows as a table.
    fn table(&mut self, count: usize) -> Result<Table, String> {
        let rows = self.taken..self.taken + count;
        let mut table = Table {
            file: self.file.clone(),
            header: self.header.clone(),
            notes: self.notes.clone(),
            skipped: self.handed,
            ..Table::default()
        };
        for column in &self.columns {
            let text = column.text.clone().map(|text| (0, text));
            for k in 0..column.width() {
                let numbers = match column.series.get(k) {
                    Some(series) if column.is_read() => series[rows.clone()].to_vec(),
                    // A wanted column without numbers: all its rows are NaN.
                    _ if column.wanted => {
                        self.budget.draw(count.saturating_mul(size_of::<f64>()))?;
                        vec![f64::NAN; count]
                    }
                    _ => Vec::new(),
                };
                table.columns.push(numbers);
                table.texts.push(text.clone());
            }
        }
        Ok(table)
    }
}

/// Collects the columns of these fields, depth first.
fn leaves(fields: &[ArrowField], columns: &mut Vec<BatchColumn>) {
    for field in fields {
        match field.layout {
            Layout::Structure => leaves(&field.below, columns),
            _ => columns.push(BatchColumn::new(field)),
        }
    }
}

/// The names of the log columns that this column gives.
fn headers(column: &BatchColumn) -> Vec<String> {
    let name = if column.is_timed() { without_unit(&column.name) } else { &column.name };
    match column.is_list() {
        true => (1..=column.width()).map(|k| format!("{name}_{k}")).collect(),
        false => vec![name.to_string()],
    }
}

impl RowReader for ArrowReader<'_> {
    fn width(&self) -> usize {
        self.header.len()
    }

    fn keep(&mut self, places: &[usize]) {
        let mut first = 0;
        for column in &mut self.columns {
            let next = first + column.width();
            column.wanted = places.iter().any(|c| (first..next).contains(c));
            if !column.wanted {
                column.series = Vec::new();
            }
            first = next;
        }
    }

    fn rows(&mut self, most: usize) -> Result<Table, Error> {
        let file = self.file.clone();
        let failed = |e: String| Error::at(&file, 0, e);
        while self.rows - self.taken < most && !self.ended {
            self.next_batch().map_err(failed)?;
        }
        let count = most.min(self.rows - self.taken);
        let has_numbers = self.columns.iter().any(BatchColumn::is_read);
        if self.handed == 0 && (count == 0 || !has_numbers) {
            let what = if count == 0 { "the file has no row" } else { "no column holds numbers" };
            return Err(failed(format!("{what}; the columns are: {}", self.header.join(", "))));
        }
        let table = self.table(count).map_err(failed)?;
        self.taken += count;
        self.handed += count;
        Ok(table)
    }
}
