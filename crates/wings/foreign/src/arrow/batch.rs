//! Reads the numbers of a record batch (a group of rows) of an Arrow table.
//!
//! A batch has a node (its number of elements) for every column and for each child of a column. It also has buffers. The first
//! buffer of a column has one bit per row: whether the row is valid. Then come the numbers, or the offsets of lists. A missing
//! number becomes NaN. A buffer may be compressed; then it starts with its uncompressed length.

use std::borrow::Cow;

use gate::budget::Budget;

use crate::arrow::flatbuffer::FlatTable;
use crate::arrow::schema::{ArrowField, Layout};
use logs::reading::Compression;
use logs::reading::{MAX_CELLS, MAX_COLUMNS};
use logs::reading::{NumberType, Numbers};

/// Memory per list during reading, bytes: the range of its elements, and the same range as an option (`None` if the list is
/// missing).
const LIST_BYTES: usize = size_of::<[usize; 2]>() + size_of::<Option<[usize; 2]>>();

/// A batch, not decoded yet.
pub(crate) struct Batch {
    pub rows: usize,
    /// Number of elements of each node.
    nodes: Vec<usize>,
    /// Position and length of each buffer in `body`.
    buffers: Vec<[usize; 2]>,
    /// For each column of views (a layout of Arrow for texts), the number of buffers in addition to the first two.
    view_buffers: Vec<usize>,
    compression: Option<Compression>,
    body: Vec<u8>,
}

/// A column of the table. A column with lists of length k gives k columns of the log.
pub(crate) struct BatchColumn {
    pub name: String,
    numbers: Numbers,
    is_list: bool,
    /// Number of elements of each list; 1 for a plain column; `None` until it is known.
    width: Option<usize>,
    /// The reason why the column has no numbers; `None` if it has numbers.
    pub text: Option<String>,
    pub wanted: bool,
    /// The values that were read but not returned yet, one series per list element.
    pub series: Vec<Vec<f64>>,
}

impl BatchColumn {
    pub(crate) fn new(field: &ArrowField) -> BatchColumn {
        let kind = field.kind().cloned().unwrap_or_else(|| NumberType::Other("nothing".into()));
        let (is_list, text) = (matches!(field.layout, Layout::Lists { .. }), field.text());
        BatchColumn {
            name: field.name.clone(),
            numbers: Numbers::new(kind),
            is_list,
            width: (!is_list || text.is_some()).then_some(1),
            text,
            wanted: true,
            series: Vec::new(),
        }
    }

    /// Whether the numbers of the column are times, so that its name may contain a unit.
    pub(crate) fn is_timed(&self) -> bool {
        matches!(self.numbers.kind, NumberType::Time { .. }) && self.text.is_none()
    }

    pub(crate) fn is_list(&self) -> bool {
        self.is_list && self.text.is_none()
    }

    pub(crate) fn is_read(&self) -> bool {
        self.wanted && self.text.is_none()
    }

    /// Number of columns of the log that this column gives.
    pub(crate) fn width(&self) -> usize {
        self.width.unwrap_or(1)
    }

    /// Marks the column as a column without numbers. `why`: the reason.
    fn refuse(&mut self, why: String) {
        (self.text, self.series) = (Some(why), Vec::new());
    }

    /// Adds the lists of some rows. A list is given by the range of its elements in `values`; `None` if it is missing.
    fn push_lists(&mut self, lists: &[Option<[usize; 2]>], values: &[f64], budget: &mut Budget) -> Result<(), String> {
        let lengths = || lists.iter().flatten().map(|[from, to]| to - from).filter(|length| *length > 0);
        let Some(width) = self.width.or_else(|| lengths().next()) else {
            self.refuse("empty lists".into());
            return Ok(());
        };
        if let Some(odd) = lengths().find(|length| *length != width) {
            self.refuse(format!("lists of {width} and of {odd} numbers"));
            return Ok(());
        }
        if width > MAX_COLUMNS || width.saturating_mul(lists.len()) > MAX_CELLS {
            self.refuse(format!("lists of {width} numbers"));
            return Ok(());
        }
        budget.draw(width.saturating_mul(lists.len()).saturating_mul(size_of::<f64>()))?;
        self.width = Some(width);
        self.series.resize_with(width, Vec::new);
        for (k, series) in self.series.iter_mut().enumerate() {
            let element = |[from, to]: &[usize; 2]| values[*from..*to].get(k).copied();
            series.extend(lists.iter().map(|list| list.as_ref().and_then(element).unwrap_or(f64::NAN)));
        }
        Ok(())
    }
}

impl Batch {
    /// Decodes the structure of a batch from its message (`RecordBatch` of Message.fbs) and its body. The numbers are decoded
    /// later.
    pub(crate) fn new(message: &FlatTable, body: Vec<u8>) -> Result<Batch, String> {
        let compression = match message.table(3)? {
            None => None,
            Some(of) => match of.number(0)?.map_or(0, i8::from_le_bytes) {
                0 => Some(Compression::Lz4Frame),
                1 => Some(Compression::Zstd),
                other => return Err(format!("its buffers are compressed by method {other}; lz4 and zstd are read")),
            },
        };
        let words = |bytes: &[u8]| -> Result<Vec<usize>, String> {
            let word = |b: &[u8; 8]| usize::try_from(i64::from_le_bytes(*b)).map_err(|_| "a length is negative".into());
            bytes.as_chunks().0.iter().map(word).collect()
        };
        let rows = message.length(0)?;
        if rows > MAX_CELLS {
            return Err(format!("a batch claims {rows} rows; at most {MAX_CELLS} are expected"));
        }
        let nodes = words(message.elements(1, 16)?)?.chunks(2).map(|node| node[0]).collect();
        let buffers = words(message.elements(2, 16)?)?.as_chunks().0.to_vec();
        Ok(Batch { rows, nodes, buffers, view_buffers: words(message.elements(4, 8)?)?, compression, body })
    }

    /// Adds the rows of the batch to the columns that are wanted. `columns`: the columns of `fields`, in depth-first order.
    pub(crate) fn read(
        &self,
        fields: &[ArrowField],
        columns: &mut [BatchColumn],
        budget: &mut Budget,
    ) -> Result<(), String> {
        let mut walk = BatchCursor { batch: self, node: 0, buffer: 0, views: 0, budget };
        let mut columns = columns.iter_mut();
        fields.iter().try_for_each(|field| walk.field(field, self.rows, None, &mut columns))
    }
}

/// A position in the nodes and buffers of a batch.
struct BatchCursor<'a> {
    batch: &'a Batch,
    node: usize,
    buffer: usize,
    views: usize,
    budget: &'a mut Budget,
}

/// For each row, whether it is valid. `None`: all rows are valid.
type Present = Option<Vec<bool>>;

impl<'a> BatchCursor<'a> {
    fn field<'b>(
        &mut self,
        field: &ArrowField,
        rows: usize,
        within: Option<&[bool]>,
        columns: &mut impl Iterator<Item = &'b mut BatchColumn>,
    ) -> Result<(), String> {
        let named = |e: String| format!("column `{}`: {e}", field.name);
        if field.layout == Layout::Structure {
            self.node(rows).map_err(named)?;
            let present = self.present(rows, within).map_err(named)?;
            return field.below.iter().try_for_each(|below| self.field(below, rows, present.as_deref(), columns));
        }
        let column = columns.next().ok_or("a column is not in the schema")?;
        if !column.is_read() {
            return self.skip(field).map_err(named);
        }
        self.column(field, rows, within, column).map_err(named)
    }

    fn column(
        &mut self,
        field: &ArrowField,
        rows: usize,
        within: Option<&[bool]>,
        column: &mut BatchColumn,
    ) -> Result<(), String> {
        self.node(rows)?;
        let present = self.present(rows, within)?;
        match (&field.layout, &field.below[..]) {
            (Layout::Numbers { bytes, .. }, _) => {
                let values = self.numbers(rows, *bytes, present.as_deref(), &mut column.numbers)?;
                column.series.resize_with(1, Vec::new);
                column.series[0].extend(values);
                Ok(())
            }
            (Layout::Lists { length, offset_bytes }, [ArrowField { layout: Layout::Numbers { bytes, .. }, .. }]) => {
                // The memory for the ranges of the lists is taken from the budget before they are read.
                self.budget.draw(rows.saturating_mul(LIST_BYTES))?;
                let places = match length {
                    Some(length) => (0..rows).map(|r| [r * length, (r + 1) * length]).collect(),
                    None => self.offsets(rows, *offset_bytes)?,
                };
                let count = self.any_node()?;
                if places.iter().any(|[from, to]| from > to || *to > count) {
                    return Err(format!("a list ends behind its {count} elements: the file is damaged"));
                }
                let elements = self.present(count, None)?;
                let values = self.numbers(count, *bytes, elements.as_deref(), &mut column.numbers)?;
                let is_there = |r: usize| present.as_ref().is_none_or(|present| present[r]);
                let lists: Vec<_> =
                    places.into_iter().enumerate().map(|(r, list)| is_there(r).then_some(list)).collect();
                column.push_lists(&lists, &values, self.budget)
            }
            // Other layouts were already refused when the schema was read.
            _ => Err("it holds no numbers".into()),
        }
    }

    /// Skips the nodes and buffers of a field and of its children.
    fn skip(&mut self, field: &ArrowField) -> Result<(), String> {
        self.any_node()?;
        self.buffer += match &field.layout {
            Layout::Numbers { .. } => 2,
            Layout::Structure => 1,
            Layout::Lists { length, .. } => 2 - usize::from(length.is_some()),
            Layout::Other { buffers, views, .. } => {
                let more = if *views { self.batch.view_buffers.get(self.views).copied().unwrap_or(0) } else { 0 };
                self.views += usize::from(*views);
                buffers.saturating_add(more)
            }
        };
        field.below.iter().try_for_each(|below| self.skip(below))
    }

    fn any_node(&mut self) -> Result<usize, String> {
        let node = self.batch.nodes.get(self.node).copied().ok_or("a batch lacks it: the file is damaged")?;
        self.node += 1;
        Ok(node)
    }

    fn node(&mut self, rows: usize) -> Result<(), String> {
        match self.any_node()? {
            found if found == rows => Ok(()),
            found => Err(format!("it has {found} rows in a batch of {rows}: the file is damaged")),
        }
    }

    /// The next buffer, decompressed.
    fn bytes(&mut self) -> Result<Cow<'a, [u8]>, String> {
        let batch = self.batch;
        let [start, length] = batch.buffers.get(self.buffer).copied().ok_or("a batch lacks it: the file is damaged")?;
        self.buffer += 1;
        let end = start.checked_add(length);
        let bytes = end.and_then(|end| batch.body.get(start..end)).ok_or("it stands outside its batch")?;
        let (Some(compression), Some((size, packed))) = (batch.compression, bytes.split_first_chunk()) else {
            return Ok(Cow::Borrowed(bytes));
        };
        match i64::from_le_bytes(*size) {
            -1 => Ok(Cow::Borrowed(packed)),
            size => {
                let size = usize::try_from(size).map_err(|_| "a length is negative: the file is damaged")?;
                self.budget.draw(size)?;
                Ok(Cow::Owned(compression.unpack(packed, size)?))
            }
        }
    }

    /// For each row, whether it is valid. A row is also invalid if it is invalid in the structure that contains it (`within`).
    fn present(&mut self, rows: usize, within: Option<&[bool]>) -> Result<Present, String> {
        let bits = self.bytes()?;
        if bits.is_empty() {
            return Ok(within.map(<[bool]>::to_vec));
        }
        if bits.len() < rows.div_ceil(8) {
            return Err(short(rows));
        }
        let is_there = |r: usize| bits[r / 8] >> (r % 8) & 1 == 1 && within.is_none_or(|within| within[r]);
        Ok(Some((0..rows).map(is_there).collect()))
    }

    /// For each list, the range of its elements, from the buffer of offsets.
    fn offsets(&mut self, rows: usize, bytes: usize) -> Result<Vec<[usize; 2]>, String> {
        let offsets = self.bytes()?;
        if offsets.len() / bytes < rows + usize::from(rows > 0) {
            return Err(short(rows));
        }
        let place = |r: usize| {
            let mut word = [0; 8];
            word[..bytes].copy_from_slice(&offsets[bytes * r..bytes * (r + 1)]);
            usize::try_from(u64::from_le_bytes(word)).unwrap_or(usize::MAX)
        };
        Ok((0..rows).map(|r| [place(r), place(r + 1)]).collect())
    }

    fn numbers(
        &mut self,
        count: usize,
        bytes: usize,
        present: Option<&[bool]>,
        numbers: &mut Numbers,
    ) -> Result<Vec<f64>, String> {
        let data = self.bytes()?;
        if bytes == 0 || data.len() / bytes < count {
            return Err(short(count));
        }
        self.budget.draw(count.saturating_mul(2 * size_of::<f64>()))?;
        let words = data.chunks_exact(bytes).take(count).enumerate();
        let is_there = |r: usize| present.is_none_or(|present| present[r]);
        Ok(words.map(|(r, word)| if is_there(r) { number(word, numbers) } else { f64::NAN }).collect())
    }
}

fn short(rows: usize) -> String {
    format!("it does not hold the {rows} values that it claims: the file is damaged")
}

/// The number in these little-endian bytes.
fn number(word: &[u8], numbers: &mut Numbers) -> f64 {
    let signed = matches!(numbers.kind, NumberType::Integer { signed: true } | NumberType::Time { .. });
    match (&numbers.kind, word) {
        (NumberType::Real, &[a, b, c, d, e, f, g, h]) => f64::from_le_bytes([a, b, c, d, e, f, g, h]),
        (NumberType::Real, &[a, b, c, d]) => f64::from(f32::from_le_bytes([a, b, c, d])),
        (NumberType::Half, [_, _]) => numbers.bytes(word),
        (NumberType::Decimal { .. }, _) => numbers.bytes(&word.iter().rev().copied().collect::<Vec<_>>()),
        (NumberType::Integer { .. } | NumberType::Time { .. }, &[.., last]) if word.len() <= 8 => {
            let sign = if signed && last & 0x80 != 0 { 0xff } else { 0 };
            let mut whole = [sign; 8];
            whole[..word.len()].copy_from_slice(word);
            numbers.integer(i64::from_le_bytes(whole), 64)
        }
        _ => f64::NAN,
    }
}
