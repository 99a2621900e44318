//! Reads one column of a Parquet file, some rows at a time.
//!
//! A Parquet file consists of row groups; a row group has one chunk per column, and a chunk consists of pages. Nulls and lists
//! are encoded by levels: the repetition level of a value is 0 if the value begins a new row, and the definition level states
//! whether the value exists. A series is one column of the resulting table; a column of lists has one series for each position
//! in the list.

use std::panic::{AssertUnwindSafe, catch_unwind};

use gate::budget::Budget;
use parquet::column::reader::{ColumnReader, ColumnReaderImpl, get_column_reader};
use parquet::data_type::{AsBytes, DataType};
use parquet::file::metadata::{ParquetMetaData, RowGroupMetaData};
use parquet::schema::types::ColumnDescPtr;

use crate::formats::parquet::file_bytes::FileBytes;
use crate::formats::parquet::number::kind;
use crate::formats::parquet::pages::UnpackedPages;
use crate::formats::stored_number::{NumberType, Numbers, without_unit};
use crate::table::{MAX_CELLS, MAX_COLUMNS};

/// Number of rows that are decoded at a time.
const ROWS_PER_BATCH: usize = 1 << 13;

/// Memory of an element of a list, bytes: its number, its levels, and the number in a column that grows by doubling.
const MEMORY_PER_ELEMENT_BYTES: usize = 2 * size_of::<f64>();

/// Number of copies of a page in memory at the same time: decompressed, in plain encoding, and with its levels.
const PAGE_COPIES: usize = 3;

/// A column of the file. A column of lists becomes one column per list element.
pub(crate) struct ParquetColumn {
    pub name: String,
    /// Whether the numbers are times.
    pub timed: bool,
    lists: bool,
    /// Whether the column is read.
    pub wanted: bool,
    place: usize,
    leaf: ColumnDescPtr,
    numbers: Numbers,
    /// The pages of the current row group.
    reader: Option<ColumnReader>,
    /// The rows that were read since the last [`Column::take`]: one series for each list element.
    series: NumbersRead,
    /// Number of series of the column in every table: the number of list elements, or one.
    width: usize,
    /// The reason why the column has no numbers; `None` if it has numbers.
    text: Option<String>,
    /// Definition levels and repetition levels (Parquet's encoding of nulls and lists) of the rows that were decoded last.
    definition: Vec<i16>,
    repetition: Vec<i16>,
}

/// The file, as needed to find the number of elements in its lists.
pub(crate) struct ListSurvey<'a> {
    pub bytes: &'a FileBytes,
    pub metadata: &'a ParquetMetaData,
    /// Number of rows of each row group.
    pub groups: &'a [usize],
    /// Largest number of elements of a list.
    pub room: usize,
}

/// The rows of a row group that are to be read.
pub(crate) struct RowRange<'a> {
    pub bytes: &'a FileBytes,
    pub group: &'a RowGroupMetaData,
    /// `all`: number of rows of the group. `before`: number of its rows that were read before. `count`: number of rows to read
    /// now.
    pub all: usize,
    pub before: usize,
    pub count: usize,
    /// Number of columns whose pages are in memory at the same time.
    pub columns: usize,
}

impl ParquetColumn {
    pub(crate) fn new(place: usize, leaf: &ColumnDescPtr, name: String) -> ParquetColumn {
        let kind = if leaf.max_rep_level() > 1 { NumberType::Other("lists of lists".into()) } else { kind(leaf) };
        let text = match &kind {
            NumberType::Other(what) => Some(what.clone()),
            _ => None,
        };
        ParquetColumn {
            name,
            timed: matches!(kind, NumberType::Time { .. }),
            lists: text.is_none() && leaf.max_rep_level() > 0,
            wanted: true,
            place,
            leaf: leaf.clone(),
            numbers: Numbers::new(kind),
            reader: None,
            series: NumbersRead::default(),
            width: 1,
            text,
            definition: Vec::new(),
            repetition: Vec::new(),
        }
    }

    /// Names of the series of the column.
    pub(crate) fn headers(&self) -> Vec<String> {
        let header = if self.timed { without_unit(&self.name) } else { &self.name };
        match self.lists && self.text.is_none() {
            true => (1..=self.width).map(|k| format!("{}_{k}", self.name)).collect(),
            false => vec![header.to_string()],
        }
    }

    /// Whether the pages of the column are read.
    pub(crate) fn is_read(&self) -> bool {
        self.wanted && self.text.is_none()
    }

    /// Number of series of the column in every table, at least one.
    pub(crate) fn width(&self) -> usize {
        self.width
    }

    /// Releases the pages of a column that is no longer needed.
    pub(crate) fn close(&mut self) {
        self.reader = None;
    }

    /// Finds the number of list elements from the first list that is not empty.
    pub(crate) fn measure_lists(&mut self, content: &ListSurvey<'_>, budget: &mut Budget) -> Result<(), String> {
        if !self.lists {
            return Ok(());
        }
        for (index, &all) in content.groups.iter().enumerate() {
            let mut before = 0;
            while before < all && self.text.is_none() && self.series.width.is_none() {
                let count = ROWS_PER_BATCH.min(all - before);
                let group = content.metadata.row_group(index);
                self.read(
                    &RowRange { bytes: content.bytes, group, all, before, count, columns: 1 },
                    content.room,
                    budget,
                )?;
                before += count;
            }
        }
        let width = self.series.width;
        if width.is_none() && self.text.is_none() {
            self.text = Some("empty lists".into());
        }
        self.width = width.filter(|_| self.text.is_none()).unwrap_or(1);
        self.series = NumbersRead { width: Some(self.width), ..NumbersRead::default() };
        self.numbers = Numbers::new(self.numbers.kind.clone());
        self.close();
        Ok(())
    }

    /// Reserves memory for `rows` rows of a table.
    pub(crate) fn begin(&mut self, rows: usize, budget: &mut Budget) -> Result<(), String> {
        if self.is_read() && !self.lists {
            budget.draw(rows.saturating_mul(size_of::<f64>()))?;
            self.series.columns = vec![Vec::with_capacity(rows)];
        }
        Ok(())
    }

    /// Reads the next rows. `room`: largest number of elements of a list.
    pub(crate) fn read(&mut self, rows: &RowRange<'_>, room: usize, budget: &mut Budget) -> Result<(), String> {
        if !self.is_read() {
            return Ok(());
        }
        self.series.room = room.min(MAX_COLUMNS);
        if rows.before == 0 {
            self.reader = Some(self.open(rows, room, budget)?);
        }
        let Some(mut reader) = self.reader.take() else { return Err("its pages are not opened".into()) };
        // The library may panic on damaged pages. `pages` refuses all known cases; unknown cases are caught here. The reader is
        // then dropped.
        let decoded = catch_unwind(AssertUnwindSafe(|| self.decode(&mut reader, rows.count, budget)));
        let found = decoded.unwrap_or_else(|_| Err("its pages are damaged".into()))?;
        if found != rows.count && self.series.odd.is_none() {
            return Err(format!("it has {} rows where its row group has {}", rows.before + found, rows.all));
        }
        self.reader = Some(reader);
        if let Some(odd) = self.series.odd.take() {
            self.text = Some(odd);
            self.close();
        }
        Ok(())
    }

    /// Opens the pages of a row group. Lists with more than `room` elements do not become series.
    fn open(&self, rows: &RowRange<'_>, room: usize, budget: &mut Budget) -> Result<ColumnReader, String> {
        let chunk = rows.group.columns().get(self.place).ok_or("a row group lacks it")?;
        if chunk.file_path().is_some() {
            return Err("its data are in another file".into());
        }
        let all = rows.all;
        let most = if self.lists { all.saturating_mul(room.clamp(1, MAX_COLUMNS)).min(MAX_CELLS) } else { all };
        let count = usize::try_from(chunk.num_values()).unwrap_or(usize::MAX);
        if count > most || (!self.lists && count < all) {
            return Err(format!("it claims {count} values where its row group has {all} rows"));
        }
        if self.lists {
            budget.draw(count.saturating_mul(MEMORY_PER_ELEMENT_BYTES))?;
        }
        let most = budget.left() / PAGE_COPIES / rows.columns.max(1);
        let pages = Box::new(UnpackedPages::of(rows.bytes, chunk, all, most)?);
        if chunk.column_type() != self.leaf.physical_type() {
            let (found, name) = (chunk.column_type(), self.leaf.name());
            return Err(format!("its type is {found} in a row group and {name} in the schema"));
        }
        Ok(get_column_reader(self.leaf.clone(), pages))
    }

    /// Decodes rows into the series, and returns the number of rows.
    fn decode(&mut self, reader: &mut ColumnReader, rows: usize, budget: &mut Budget) -> Result<usize, String> {
        use ColumnReader::*;
        let levels = [&mut self.definition, &mut self.repetition];
        let mut to = Destination { leaf: &self.leaf, levels, series: &mut self.series, budget };
        let numbers = &mut self.numbers;
        match reader {
            BoolColumnReader(_) => Err("booleans are no numbers".into()),
            Int32ColumnReader(r) => to.typed(r, rows, |x| numbers.integer(i64::from(*x), 32)),
            Int64ColumnReader(r) => to.typed(r, rows, |x| numbers.integer(*x, 64)),
            Int96ColumnReader(r) => to.typed(r, rows, |x| numbers.integer(x.to_nanos(), 64)),
            FloatColumnReader(r) => to.typed(r, rows, |x| f64::from(*x)),
            DoubleColumnReader(r) => to.typed(r, rows, |x| *x),
            ByteArrayColumnReader(r) => to.typed(r, rows, |x| numbers.bytes(x.as_bytes())),
            FixedLenByteArrayColumnReader(r) => to.typed(r, rows, |x| numbers.bytes(x.as_bytes())),
        }
    }

    /// The series of the rows that were read; their number is the same in every table. A column without numbers has empty series,
    /// and the text gives the reason.
    pub(crate) fn take(&mut self) -> (Vec<Vec<f64>>, Option<String>) {
        let series = std::mem::take(&mut self.series);
        self.series.width = Some(self.width);
        let mut columns = if self.is_read() { series.columns } else { Vec::new() };
        columns.resize_with(self.width, Vec::new);
        (columns, self.text.clone())
    }
}

/// The numbers of the rows that were read so far.
#[derive(Default)]
struct NumbersRead {
    columns: Vec<Vec<f64>>,
    rows: usize,
    /// Largest number of elements of a list.
    room: usize,
    /// Number of elements of each list; `None` until it is known.
    width: Option<usize>,
    /// The reason why the lists cannot become columns; `None` if they can.
    odd: Option<String>,
}

impl NumbersRead {
    /// Appends rows of lists. `starts`: the repetition level of each cell, which is 0 at the start of a row. A missing list
    /// element is `None`.
    fn push(&mut self, cells: &[Option<f64>], starts: &[i16], budget: &mut Budget) -> Result<(), String> {
        let mut from = 0;
        while from < cells.len() && self.odd.is_none() {
            let next = starts[from + 1..].iter().position(|&level| level == 0);
            let to = next.map_or(cells.len(), |n| from + 1 + n);
            let row = if cells[from..to] == [None] { &[][..] } else { &cells[from..to] };
            let width = match (self.width, row.len()) {
                (Some(width), _) => width,
                (None, width) if width > self.room => {
                    self.odd = Some(format!("lists of {width} numbers"));
                    return Ok(());
                }
                (None, width) => width,
            };
            // The first list that is not empty determines the number of columns.
            if self.columns.is_empty() && width > 0 {
                budget.draw(self.rows.saturating_mul(width).saturating_mul(MEMORY_PER_ELEMENT_BYTES))?;
                self.columns = vec![vec![f64::NAN; self.rows]; width];
                self.width = Some(width);
            }
            if !row.is_empty() && row.len() != self.columns.len() {
                self.odd = Some(format!("lists of {} and of {} numbers", self.columns.len(), row.len()));
                return Ok(());
            }
            // An empty list becomes a row of missing numbers, which also needs memory.
            if row.len() < self.columns.len() {
                budget.draw(self.columns.len().saturating_mul(MEMORY_PER_ELEMENT_BYTES))?;
            }
            for (k, column) in self.columns.iter_mut().enumerate() {
                column.push(row.get(k).copied().flatten().unwrap_or(f64::NAN));
            }
            self.rows += 1;
            from = to;
        }
        Ok(())
    }
}

/// Where decoded rows are stored.
struct Destination<'a> {
    leaf: &'a ColumnDescPtr,
    levels: [&'a mut Vec<i16>; 2],
    series: &'a mut NumbersRead,
    budget: &'a mut Budget,
}

impl Destination<'_> {
    fn typed<T: DataType>(
        &mut self,
        reader: &mut ColumnReaderImpl<T>,
        rows: usize,
        mut number: impl FnMut(&T::T) -> f64,
    ) -> Result<usize, String> {
        let (present, element) = (self.leaf.max_def_level(), self.leaf.repeated_ancestor_def_level());
        let lists = self.leaf.max_rep_level() > 0;
        let [definition, repetition] = &mut self.levels;
        let (mut values, mut done) = (Vec::new(), 0);
        while done < rows && self.series.odd.is_none() {
            // The library decodes a batch. Null elements have levels but no values.
            definition.clear();
            repetition.clear();
            values.clear();
            let batch = ROWS_PER_BATCH.min(rows - done);
            let read = reader.read_records(batch, Some(definition), Some(repetition), &mut values);
            let (records, _, levels) = read.map_err(|e| e.to_string())?;
            if records == 0 {
                break;
            }
            done += records;
            // If there are no nulls and no lists, each value is a row.
            if !lists && values.len() == levels {
                self.series.columns[0].extend(values.iter().map(&mut number));
                continue;
            }
            let mut values = values.iter();
            let cells = (0..levels).map(|k| match definition.get(k) {
                Some(&level) if level < element => None,
                Some(&level) if level < present => Some(f64::NAN),
                _ => Some(values.next().map_or(f64::NAN, &mut number)),
            });
            if !lists {
                self.series.columns[0].extend(cells.map(|cell| cell.unwrap_or(f64::NAN)));
                continue;
            }
            // A batch must start with a new row, so its first repetition level must be 0.
            if repetition.first() != Some(&0) {
                return Err("its first list does not begin with a row".into());
            }
            let cells: Vec<Option<f64>> = cells.collect();
            self.series.push(&cells, repetition, self.budget)?;
        }
        Ok(done)
    }
}
