//! Determines the columns of an Arrow table, and their layout in a batch (a group of rows), from its schema.
//!
//! The columns are in depth-first order: the fields of a structure follow the structure, the elements of a list follow the list.
//! A list column `q` becomes q_1 .. q_k. A field of a structure becomes `struct.field`. A column without numbers counts as a text
//! column, and it is an error if the user selects it.

use crate::arrow::flatbuffer::FlatTable;
use logs::reading::NumberType;

/// Largest depth of nested structures.
const MAX_DEPTH: usize = 8;

/// The layout of a column in a batch: which buffers it has, in their order. The first buffer says which rows are valid.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Layout {
    /// The buffer of valid rows, then a buffer with numbers of `bytes` bytes each.
    Numbers { kind: NumberType, bytes: usize },
    /// The buffer of valid rows; then the buffers of the fields of the structure.
    Structure,
    /// The buffer of valid rows; for lists of variable length also a buffer of offsets of `offset_bytes` bytes each. Then the
    /// buffers of the elements.
    Lists { length: Option<usize>, offset_bytes: usize },
    /// `buffers` buffers without numbers, then the buffers of the children. If `views` is set, each batch states how many further
    /// buffers there are.
    Other { buffers: usize, views: bool, what: String },
}

/// A column, or a child of a column (a field of a structure, or the element of a list).
pub(crate) struct ArrowField {
    /// Name of the field, preceded by the names of the structures that contain it.
    pub name: String,
    pub layout: Layout,
    pub below: Vec<ArrowField>,
}

impl ArrowField {
    /// The fields of a schema.
    pub(crate) fn all(schema: &FlatTable) -> Result<Vec<ArrowField>, String> {
        if schema.short(0, 0)? != 0 {
            return Err("it was written in the byte order of another machine: write it again on this one".into());
        }
        schema.tables(1)?.iter().map(|field| ArrowField::of(field, "", 0)).collect()
    }

    fn of(field: &FlatTable, path: &str, depth: usize) -> Result<ArrowField, String> {
        if depth == MAX_DEPTH {
            return Err(format!("more than {MAX_DEPTH} structures and lists stand in one another at `{path}`"));
        }
        let own = field.text(0)?;
        let name = if path.is_empty() { own.to_string() } else { format!("{path}.{own}") };
        let layout = layout(field)?;
        // The field of a list's element has a name without meaning, so it does not appear in the path.
        let path = if layout == Layout::Structure { &name } else { path };
        let below =
            field.tables(5)?.iter().map(|below| ArrowField::of(below, path, depth + 1)).collect::<Result<_, _>>()?;
        Ok(ArrowField { name, layout, below })
    }

    /// The reason why the field has no numbers; `None` if it has numbers.
    pub(crate) fn text(&self) -> Option<String> {
        match (&self.layout, &self.below[..]) {
            (Layout::Other { what, .. }, _) => Some(what.clone()),
            (Layout::Lists { .. }, [ArrowField { layout: Layout::Numbers { .. }, .. }]) => None,
            (Layout::Lists { .. }, _) => Some("lists of what is no number".into()),
            _ => None,
        }
    }

    /// The type of the numbers in the field, or in the lists of the field; `None` if it has no numbers.
    pub(crate) fn kind(&self) -> Option<&NumberType> {
        match (&self.layout, &self.below[..]) {
            (Layout::Numbers { kind, .. }, _) => Some(kind),
            (Layout::Lists { .. }, [element]) => element.kind(),
            _ => None,
        }
    }
}

/// The layout of a field, determined by its type in Schema.fbs.
fn layout(field: &FlatTable) -> Result<Layout, String> {
    let other = |buffers, what: &str| Layout::Other { buffers, views: false, what: what.into() };
    let views = |what: &str| Layout::Other { buffers: 2, views: true, what: what.into() };
    let numbers = |kind, bits: i32| Layout::Numbers { kind, bytes: usize::try_from(bits / 8).unwrap_or(0) };
    if field.table(4)?.is_some() {
        return Ok(other(2, "words of a dictionary"));
    }
    let kind = field.number(2)?.map_or(0, u8::from_le_bytes);
    let Some(of) = field.table(3)? else { return Ok(other(0, "nothing")) };
    Ok(match kind {
        // Types with numbers. Decimals and times state their width in bits.
        2 => numbers(NumberType::Integer { signed: of.number(1)? == Some([1]) }, of.int(0, 0)?),
        3 => match of.short(0, 0)? {
            0 => numbers(NumberType::Half, 16),
            1 => numbers(NumberType::Real, 32),
            _ => numbers(NumberType::Real, 64),
        },
        4 => other(3, "bytes"),
        5 => other(3, "text"),
        6 => other(2, "booleans"),
        7 => numbers(NumberType::Decimal { scale: of.int(1, 0)? }, of.int(2, 128)?),
        8 if of.short(0, 1)? == 0 => numbers(NumberType::Time { per_second: 1.0 / 86_400.0 }, 32),
        8 => numbers(NumberType::Time { per_second: 1e3 }, 64),
        9 => numbers(time(of.short(0, 1)?), of.int(1, 32)?),
        10 => numbers(time(of.short(0, 0)?), 64),
        18 => numbers(time(of.short(0, 1)?), 64),
        // Lists with offsets of 4 bytes, with offsets of 8 bytes, and of fixed length.
        12 => Layout::Lists { length: None, offset_bytes: 4 },
        21 => Layout::Lists { length: None, offset_bytes: 8 },
        16 => Layout::Lists { length: Some(usize::try_from(of.int(0, 0)?).unwrap_or(0)), offset_bytes: 0 },
        13 => Layout::Structure,
        // Other types are skipped, so only the number of their buffers is needed.
        11 => other(2, "intervals of the calendar"),
        14 if of.short(0, 0)? == 0 => other(1, "a union"),
        14 => other(2, "a union"),
        15 => other(2, "bytes"),
        17 => other(2, "a map"),
        19 => other(3, "bytes"),
        20 => other(3, "text"),
        22 => other(0, "runs"),
        23 => views("bytes"),
        24 => views("text"),
        25 | 26 => other(3, "views of lists"),
        1 => other(0, "nothing"),
        unknown => {
            return Err(format!("column `{}` is of the type {unknown}, which Arrow did not have", field.text(0)?));
        }
    })
}

/// The type of a time. `unit`: 0 for seconds, 1 for milliseconds, 2 for microseconds, 3 for nanoseconds.
fn time(unit: i16) -> NumberType {
    NumberType::Time { per_second: 1e3f64.powi(i32::from(unit)) }
}
