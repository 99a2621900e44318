//! A Parquet file as a table of named columns.
//!
//! Columns of INT32, INT64, FLOAT and DOUBLE are read; null is NaN. A list column `q` becomes q_1 .. q_k, as an
//! array of a .npz does, if all its lists are of one length; a field of a struct is `struct.field`.
//! Times with a unit (TIMESTAMP, TIME) become seconds from the first: nanoseconds since 1970 have more
//! digits than a number keeps. A column of another type is a column of text: refused when it is used.
//!
//! The format: parquet.apache.org; pages are in `parquet_pages`. Not here: encryption, columns in other files.

use crate::Error;
use crate::formats::parquet::pages as parquet_pages;
use crate::formats::parquet::pages::{Cell, Cells, Shape};
use crate::formats::parquet::thrift::Thrift;
use crate::table::{MAX_COLUMNS, Table, check_header};

const MAGIC: &[u8] = b"PAR1";

/// More numbers than this, 2 GiB, are to be cut before: three hours of 22 columns at 1 kHz.
const MAX_CELLS: usize = 1 << 28;

/// Deeper nesting is not a log of a robot.
const MAX_DEPTH: usize = 16;

pub fn is_parquet(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC) || bytes.starts_with(b"PARE")
}

/// Reads the columns of a file.
pub fn read(file: &str, bytes: &[u8]) -> Result<Table, Error> {
    let at = |message: String| Error::at(file, 0, message);
    let metadata = footer(bytes).map_err(at)?;
    let schema = metadata.list(2);
    let mut leaves = Vec::new();
    let mut next = 0;
    children(schema, &mut next, &Parent::default(), &mut leaves).map_err(at)?;
    if leaves.len() > MAX_COLUMNS {
        return Err(at(format!("{} columns; at most {MAX_COLUMNS} are expected", leaves.len())));
    }
    let rows = rows(&metadata).map_err(at)?;
    let mut table = Table { file: file.into(), ..Table::default() };
    for (place, leaf) in leaves.iter().enumerate() {
        let room = MAX_CELLS / rows.iter().sum::<usize>().max(1) - table.header.len();
        let column = column(bytes, &metadata, &rows, place, leaf, room);
        let column = column.map_err(|e| at(format!("column `{}`: {e}", leaf.name)))?;
        let width = column.series.len();
        if width > room || table.header.len() + width > MAX_COLUMNS {
            let message = format!(
                "more than {MAX_COLUMNS} columns or {MAX_CELLS} numbers, with column `{}`; keep the columns of the \
                 robot, or a part of the rows",
                leaf.name
            );
            return Err(at(message));
        }
        for (k, series) in column.series.into_iter().enumerate() {
            table.header.push(if column.lists { format!("{}_{}", leaf.name, k + 1) } else { leaf.header() });
            table.columns.push(series);
            table.texts.push(column.text.clone().map(|text| (0, text)));
        }
        table.notes.extend(column.note);
    }
    check_header(file, 0, &table.header)?;
    // A column without numbers has no length of its own.
    let Some(rows) = table.columns.iter().map(Vec::len).max().filter(|&n| n > 0) else {
        let what = if rows.iter().all(|&n| n == 0) { "the file has no row" } else { "no column holds numbers" };
        return Err(at(format!("{what}; the columns are: {}", table.header.join(", "))));
    };
    table.columns.iter_mut().for_each(|c| c.resize(rows, f64::NAN));
    Ok(table)
}

/// The rows of every row group.
fn rows(metadata: &Thrift) -> Result<Vec<usize>, String> {
    let rows: Option<Vec<usize>> = metadata.list(4).iter().map(|g| g.size(3)).collect();
    let rows = rows.ok_or("a row group has no length")?;
    let all = rows.iter().try_fold(0usize, |a, &b| a.checked_add(b)).filter(|&n| n <= MAX_CELLS);
    all.ok_or_else(|| format!("more than {MAX_CELLS} rows are claimed"))?;
    Ok(rows)
}

/// The metadata at the end of the file.
fn footer(bytes: &[u8]) -> Result<Thrift<'_>, String> {
    if bytes.starts_with(b"PARE") || bytes.ends_with(b"PARE") {
        return Err("the file is encrypted; write it without encryption".into());
    }
    let cut = "the Parquet file does not end with PAR1: it is cut short, or its writer was never closed; its index \
               stands at the end, so nothing can be read: write or copy it again";
    let body = bytes.strip_suffix(MAGIC).filter(|b| b.len() >= 8).ok_or(cut)?;
    let (body, length) = body.split_last_chunk::<4>().ok_or(cut)?;
    let length = u32::from_le_bytes(*length) as usize;
    let start = body.len().checked_sub(length);
    let start = start.ok_or_else(|| format!("the index claims {length} bytes of a file of {}", bytes.len()))?;
    Thrift::read(&body[start..]).map(|(metadata, _)| metadata)
}

/// A column of the file.
#[derive(Debug)]
struct Leaf {
    name: String,
    kind: Kind,
    max_definition: u32,
    max_repetition: u32,
    element: u32,
}

/// What the numbers of a column are.
#[derive(Clone, Debug, PartialEq)]
enum Kind {
    Double,
    Float,
    Integer {
        width: usize,
        signed: bool,
    },
    Time {
        width: usize,
        per_second: f64,
    },
    /// The name of a type that is not read.
    Other(String),
}

/// What the groups above an element of the schema make of it.
#[derive(Clone, Default)]
struct Parent {
    path: Vec<String>,
    max_definition: u32,
    max_repetition: u32,
    element: u32,
    depth: usize,
    /// The element of a list is no part of the name.
    is_list: bool,
}

/// Walks one element of the schema and what is below it; leaves come in the order of their chunks.
fn children(schema: &[Thrift], next: &mut usize, parent: &Parent, out: &mut Vec<Leaf>) -> Result<(), String> {
    let element = schema.get(*next).ok_or("the schema ends too early")?;
    let root = *next == 0;
    *next += 1;
    let mut here = Parent { depth: parent.depth + 1, is_list: false, ..parent.clone() };
    if here.depth > MAX_DEPTH {
        return Err("the schema is nested too deeply".into());
    }
    let n = element.size(5).unwrap_or(0);
    if !root {
        let repeated = element.integer(3) == Some(2);
        here.max_definition += u32::from(element.integer(3) != Some(0));
        if repeated {
            here.max_repetition += 1;
            here.element = here.max_definition;
        }
        here.is_list = repeated && n == 1;
        if !here.is_list && !parent.is_list {
            here.path.push(element.text(4).unwrap_or_default());
        }
    }
    if n > 0 || root {
        for _ in 0..n {
            children(schema, next, &here, out)?;
        }
        return Ok(());
    }
    let kind = if here.max_repetition > 1 { Kind::Other("lists of lists".into()) } else { kind(element) };
    let Parent { path, max_definition, max_repetition, element, .. } = here;
    out.push(Leaf { name: path.join("."), kind, max_definition, max_repetition, element });
    Ok(())
}

fn kind(element: &Thrift) -> Kind {
    let width = match element.integer(1) {
        Some(1) => 4,
        Some(2) => 8,
        Some(4) => return Kind::Float,
        Some(5) => return Kind::Double,
        other => {
            let names = ["BOOLEAN", "INT32", "INT64", "INT96", "FLOAT", "DOUBLE", "text (BYTE_ARRAY)", "bytes"];
            let name = other.and_then(|t| names.get(usize::try_from(t).ok()?));
            return Kind::Other(name.unwrap_or(&"unknown type").to_string());
        }
    };
    let logical = element.field(10);
    let unit = logical.and_then(|l| l.field(7).or(l.field(8))).and_then(|time| time.field(2));
    let per_second = match (unit, element.integer(6)) {
        (Some(unit), _) => [1e3, 1e6, 1e9].into_iter().zip(1..).find(|(_, id)| unit.field(*id).is_some()).map(|u| u.0),
        (None, Some(7 | 9)) => Some(1e3),
        (None, Some(8 | 10)) => Some(1e6),
        _ => None,
    };
    let integer = logical.and_then(|l| l.field(10));
    match (per_second, element.integer(6), logical) {
        (Some(per_second), ..) => Kind::Time { width, per_second },
        (None, Some(5), _) => Kind::Other("DECIMAL".into()),
        (None, Some(6), _) => Kind::Other("DATE".into()),
        (None, converted, _) => {
            let unsigned = integer.is_some_and(|i| i.bool(2) == Some(false)) || matches!(converted, Some(11..=14));
            Kind::Integer { width, signed: !unsigned }
        }
    }
}

impl Leaf {
    /// `None` where the numbers are not read.
    fn shape(&self) -> Option<Shape> {
        let width = match self.kind {
            Kind::Double => 8,
            Kind::Float => 4,
            Kind::Integer { width, .. } | Kind::Time { width, .. } => width,
            Kind::Other(_) => return None,
        };
        let Leaf { max_definition, max_repetition, element, .. } = *self;
        Some(Shape { width, max_definition, max_repetition, element })
    }

    /// Times are seconds, whatever unit the name of the column has.
    fn header(&self) -> String {
        let name = match self.kind {
            Kind::Time { .. } => ["_ms", "_us", "_ns"].iter().find_map(|unit| self.name.strip_suffix(unit)),
            _ => None,
        };
        name.unwrap_or(&self.name).to_string()
    }
}

/// What became of a column: one series, or one for each element of its lists.
#[derive(Default)]
struct Column {
    series: Vec<Vec<f64>>,
    lists: bool,
    /// Why it holds no numbers; the series is empty then.
    text: Option<String>,
    note: Option<String>,
}

/// Reads a column; lists of more than `room` elements are not taken apart.
fn column(
    bytes: &[u8],
    metadata: &Thrift,
    rows: &[usize],
    place: usize,
    leaf: &Leaf,
    room: usize,
) -> Result<Column, String> {
    let text = |text: String| Ok(Column { series: vec![Vec::new()], text: Some(text), ..Column::default() });
    let shape = match (&leaf.kind, leaf.shape()) {
        (_, Some(shape)) => shape,
        (Kind::Other(name), _) => return text(name.clone()),
        _ => return text("unknown type".into()),
    };
    let mut origin = None;
    let mut number = |cell: &Cell| match cell {
        Cell::Number(bits) => value(*bits, &leaf.kind, &mut origin),
        _ => f64::NAN,
    };
    let lists = shape.max_repetition > 0;
    let mut series: Vec<Vec<f64>> = if lists { Vec::new() } else { vec![Vec::new()] };
    let mut done = 0;
    for (group, &rows) in metadata.list(4).iter().zip(rows) {
        let chunk = group.list(1).get(place).ok_or("a row group lacks it")?;
        if chunk.field(1).is_some() {
            return Err("its data are in another file".into());
        }
        let chunk = chunk.field(3).ok_or("its metadata are missing or encrypted")?;
        let most = if lists { rows.saturating_mul(room.clamp(1, MAX_COLUMNS)) } else { rows };
        let count = chunk.size(5).unwrap_or(usize::MAX);
        if count > most || (!lists && count < rows) {
            return Err(format!("it claims {count} values where its row group has {rows} rows"));
        }
        let cells = parquet_pages::read(bytes, chunk, shape)?;
        if !lists {
            series[0].extend(cells.cells.iter().map(&mut number));
            continue;
        }
        for row in rows_of_lists(&cells, rows)? {
            if series.is_empty() && !row.is_empty() {
                if row.len() > room.min(MAX_COLUMNS) {
                    return text(format!("lists of {} numbers", row.len()));
                }
                series = vec![vec![f64::NAN; done]; row.len()];
            }
            if !row.is_empty() && row.len() != series.len() {
                return text(format!("lists of {} and of {} numbers", series.len(), row.len()));
            }
            for (k, series) in series.iter_mut().enumerate() {
                series.push(row.get(k).map_or(f64::NAN, &mut number));
            }
            done += 1;
        }
    }
    if series.is_empty() {
        return text("empty lists".into());
    }
    let timed = matches!(leaf.kind, Kind::Time { .. });
    let note = timed.then(|| format!("column `{}` holds times; they are counted in seconds from the first", leaf.name));
    Ok(Column { series, lists, text: None, note })
}

/// The rows of a list column; one without elements is empty.
fn rows_of_lists(cells: &Cells, rows: usize) -> Result<Vec<&[Cell]>, String> {
    let starts: Vec<usize> = (0..cells.cells.len()).filter(|&i| cells.starts.get(i) == Some(&true)).collect();
    if starts.len() != rows || starts.first().is_some_and(|&s| s != 0) {
        return Err(format!("it has {} lists where its row group has {rows} rows", starts.len()));
    }
    let ends = starts.iter().skip(1).copied().chain([cells.cells.len()]);
    let row = |(a, b): (&usize, usize)| match &cells.cells[*a..b] {
        [Cell::NoElement] => &[],
        row => row,
    };
    Ok(starts.iter().zip(ends).map(row).collect())
}

fn value(bits: u64, kind: &Kind, origin: &mut Option<i64>) -> f64 {
    let signed = |width: usize| if width == 4 { i64::from(bits as u32 as i32) } else { bits as i64 };
    match *kind {
        Kind::Double => f64::from_bits(bits),
        Kind::Float => f64::from(f32::from_bits(bits as u32)),
        Kind::Integer { width, signed: true } => signed(width) as f64,
        Kind::Integer { width: 4, .. } => f64::from(bits as u32),
        Kind::Integer { .. } => bits as f64,
        Kind::Time { width, per_second } => {
            let time = signed(width);
            let first = *origin.get_or_insert(time);
            // In whole numbers, divided once: the nearest number to the decimals.
            (i128::from(time) - i128::from(first)) as f64 / per_second
        }
        Kind::Other(_) => f64::NAN,
    }
}
