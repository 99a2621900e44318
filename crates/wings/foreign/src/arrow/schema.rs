//! The columns of an Arrow table, from its schema, and how each lies in a batch.
//!
//! Columns lie depth first: of a structure its fields follow, of a list its elements. A list column `q` becomes q_1 .. q_k; a
//! field of a structure is `struct.field`. A column without numbers is one of text: it is refused when it is used.

use crate::arrow::flatbuffer::Table;
use logs::reading::Kind;

/// Structures that stand in one another.
const MAX_DEPTH: usize = 8;

/// How a column lies in a batch.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Layout {
    /// Validity, and numbers of so many bytes.
    Numbers { kind: Kind, bytes: usize },
    /// Validity; the fields follow.
    Structure,
    /// Validity; for lists of any length, as `offset_bytes` tells, where each begins; the elements follow.
    Lists { length: Option<usize>, offset_bytes: usize },
    /// So many buffers without numbers, more as a batch says where `views`; what is below follows.
    Other { buffers: usize, views: bool, what: String },
}

/// A column, or what is below one.
pub(crate) struct Field {
    /// With the structures that it stands in.
    pub name: String,
    pub layout: Layout,
    pub below: Vec<Field>,
}

impl Field {
    /// The fields of a schema.
    pub(crate) fn all(schema: &Table) -> Result<Vec<Field>, String> {
        if schema.short(0, 0)? != 0 {
            return Err("it was written in the byte order of another machine: write it again on this one".into());
        }
        schema.tables(1)?.iter().map(|field| Field::of(field, "", 0)).collect()
    }

    fn of(field: &Table, path: &str, depth: usize) -> Result<Field, String> {
        if depth == MAX_DEPTH {
            return Err(format!("more than {MAX_DEPTH} structures and lists stand in one another at `{path}`"));
        }
        let own = field.text(0)?;
        let name = if path.is_empty() { own.to_string() } else { format!("{path}.{own}") };
        let layout = layout(field)?;
        // The element of a list has a name of no meaning.
        let path = if layout == Layout::Structure { &name } else { path };
        let below = field.tables(5)?.iter().map(|below| Field::of(below, path, depth + 1)).collect::<Result<_, _>>()?;
        Ok(Field { name, layout, below })
    }

    /// Why it holds no numbers of its own, if it does not.
    pub(crate) fn text(&self) -> Option<String> {
        match (&self.layout, &self.below[..]) {
            (Layout::Other { what, .. }, _) => Some(what.clone()),
            (Layout::Lists { .. }, [Field { layout: Layout::Numbers { .. }, .. }]) => None,
            (Layout::Lists { .. }, _) => Some("lists of what is no number".into()),
            _ => None,
        }
    }

    /// What its numbers are, or those of its lists.
    pub(crate) fn kind(&self) -> Option<&Kind> {
        match (&self.layout, &self.below[..]) {
            (Layout::Numbers { kind, .. }, _) => Some(kind),
            (Layout::Lists { .. }, [element]) => element.kind(),
            _ => None,
        }
    }
}

/// Types of Schema.fbs.
fn layout(field: &Table) -> Result<Layout, String> {
    let other = |buffers, what: &str| Layout::Other { buffers, views: false, what: what.into() };
    let views = |what: &str| Layout::Other { buffers: 2, views: true, what: what.into() };
    let numbers = |kind, bits: i32| Layout::Numbers { kind, bytes: usize::try_from(bits / 8).unwrap_or(0) };
    if field.table(4)?.is_some() {
        return Ok(other(2, "words of a dictionary"));
    }
    let kind = field.number(2)?.map_or(0, u8::from_le_bytes);
    let Some(of) = field.table(3)? else { return Ok(other(0, "nothing")) };
    Ok(match kind {
        2 => numbers(Kind::Integer { signed: of.number(1)? == Some([1]) }, of.int(0, 0)?),
        3 => match of.short(0, 0)? {
            0 => numbers(Kind::Half, 16),
            1 => numbers(Kind::Real, 32),
            _ => numbers(Kind::Real, 64),
        },
        4 => other(3, "bytes"),
        5 => other(3, "text"),
        6 => other(2, "booleans"),
        7 => numbers(Kind::Decimal { scale: of.int(1, 0)? }, of.int(2, 128)?),
        8 if of.short(0, 1)? == 0 => numbers(Kind::Time { per_second: 1.0 / 86_400.0 }, 32),
        8 => numbers(Kind::Time { per_second: 1e3 }, 64),
        9 => numbers(time(of.short(0, 1)?), of.int(1, 32)?),
        10 => numbers(time(of.short(0, 0)?), 64),
        18 => numbers(time(of.short(0, 1)?), 64),
        12 => Layout::Lists { length: None, offset_bytes: 4 },
        21 => Layout::Lists { length: None, offset_bytes: 8 },
        16 => Layout::Lists { length: Some(usize::try_from(of.int(0, 0)?).unwrap_or(0)), offset_bytes: 0 },
        13 => Layout::Structure,
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

/// A time in units that are counted so: seconds, milli-, micro- and nanoseconds.
fn time(unit: i16) -> Kind {
    Kind::Time { per_second: 1e3f64.powi(i32::from(unit)) }
}
