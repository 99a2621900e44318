//! Reads numbers from the Arrow C data interface, which pandas, polars and pyarrow offer by `__arrow_c_stream__`.
//!
//! The layout is that of the specification "The Arrow C data interface" and "The Arrow C stream interface": a struct of
//! columns, batch by batch. Integers, floats and times (in seconds) are read, and a null becomes NaN. Other columns
//! are reported by their format. No buffer outlives the call, because the numbers are copied into f64. The other
//! direction is `arrow_export`.
//!
//! `unsafe` stands in these two files alone. It is sound here because every pointer comes from a structure that its
//! owner filled by the specification and that is released once, at the end, and because lengths are those that the
//! structure states.
#![allow(unsafe_code)]

use std::ffi::{CStr, c_char, c_void};
use std::ptr::NonNull;

use pyo3::prelude::*;
use pyo3::types::{PyCapsule, PyCapsuleMethods};

use crate::error::error;

/// A type: `+s` for a struct, `g` for doubles.
#[repr(C)]
pub(crate) struct Schema {
    pub format: *const c_char,
    pub name: *const c_char,
    pub metadata: *const c_char,
    pub flags: i64,
    pub n_children: i64,
    pub children: *mut *mut Schema,
    pub dictionary: *mut Schema,
    pub release: Option<unsafe extern "C" fn(*mut Schema)>,
    pub private: *mut c_void,
}

/// The values of a type.
#[repr(C)]
pub(crate) struct Batch {
    pub length: i64,
    pub null_count: i64,
    pub offset: i64,
    pub n_buffers: i64,
    pub n_children: i64,
    pub buffers: *mut *const c_void,
    pub children: *mut *mut Batch,
    pub dictionary: *mut Batch,
    pub release: Option<unsafe extern "C" fn(*mut Batch)>,
    pub private: *mut c_void,
}

/// Batches of one type.
#[repr(C)]
pub(crate) struct Stream {
    pub get_schema: Option<unsafe extern "C" fn(*mut Stream, *mut Schema) -> i32>,
    pub get_next: Option<unsafe extern "C" fn(*mut Stream, *mut Batch) -> i32>,
    pub get_last_error: Option<unsafe extern "C" fn(*mut Stream) -> *const c_char>,
    pub release: Option<unsafe extern "C" fn(*mut Stream)>,
    pub private: *mut c_void,
}

impl Drop for Schema {
    fn drop(&mut self) {
        if let Some(release) = self.release {
            // SAFETY: the owner's own function is called once, because it clears `release`.
            unsafe { release(self) }
        }
    }
}

impl Drop for Batch {
    fn drop(&mut self) {
        if let Some(release) = self.release {
            // SAFETY: as of a schema.
            unsafe { release(self) }
        }
    }
}

/// A column of a frame.
pub struct Column {
    /// Its name.
    pub name: String,
    /// Its numbers, or the Arrow format of a column that holds none.
    pub content: Result<Vec<f64>, String>,
}

/// All columns of an object that has `__arrow_c_stream__`.
pub fn columns(frame: &Bound<'_, PyAny>) -> PyResult<Vec<Column>> {
    let capsule = frame.call_method0("__arrow_c_stream__")?.cast_into::<PyCapsule>()?;
    let pointer: NonNull<c_void> = capsule.pointer_checked(Some(c"arrow_array_stream"))?;
    // SAFETY: the capsule of this name holds a stream and keeps it alive; the capsule releases it.
    let stream = unsafe { &mut *pointer.as_ptr().cast::<Stream>() };
    // A stream that another consumer took has no functions left to call, and its owner says so by `release`.
    if stream.release.is_none() {
        return Err(error("the Arrow stream was released: another reader took it; ask its owner for a new one"));
    }
    let failed = |what: &str| error(format_args!("the Arrow stream gives no {what}"));
    // SAFETY: a released structure is all zeros, which the owner fills.
    let (mut schema, get_schema) = (unsafe { std::mem::zeroed::<Schema>() }, stream.get_schema);
    // SAFETY: by the specification; the structures are ours.
    let code = get_schema.map(|get| unsafe { get(stream, &mut schema) });
    if code != Some(0) || schema.release.is_none() {
        return Err(failed("schema"));
    }
    if text(schema.format) != "+s" {
        return Err(error("a table with columns is expected, not a single column"));
    }
    let mut columns = Vec::new();
    for k in 0..schema.n_children.max(0) as usize {
        // SAFETY: k is less than the number of children.
        let child = unsafe { &**schema.children.add(k) };
        let format = text(child.format);
        let content = match Kind::of(&format) {
            Some(_) if child.dictionary.is_null() => Ok(Vec::new()),
            _ => Err(format),
        };
        columns.push((Column { name: text(child.name), content }, text(child.format), None));
    }
    loop {
        // SAFETY: as of the schema.
        let mut batch = unsafe { std::mem::zeroed::<Batch>() };
        // SAFETY: by the specification; the structures are ours.
        let code = stream.get_next.map(|next| unsafe { next(stream, &mut batch) });
        if code != Some(0) {
            return Err(failed("rows"));
        }
        if batch.release.is_none() {
            break;
        }
        if batch.n_children != columns.len() as i64 {
            return Err(failed("batch of the columns of its schema"));
        }
        for (k, (column, format, origin)) in columns.iter_mut().enumerate() {
            let (Ok(numbers), Some(kind)) = (&mut column.content, Kind::of(format)) else { continue };
            // SAFETY: k is less than the number of children.
            let values = unsafe { &**batch.children.add(k) };
            // SAFETY: the second of two buffers.
            if values.n_buffers != 2 || values.buffers.is_null() || unsafe { (*values.buffers.add(1)).is_null() } {
                // A column of no rows may be without.
                if batch.length > 0 {
                    return Err(failed("values of a column of numbers"));
                }
                continue;
            }
            // SAFETY: a column of numbers has two buffers, of the lengths it states.
            unsafe { kind.append(values, batch.offset, batch.length, numbers, origin) }
        }
    }
    Ok(columns.into_iter().map(|(column, format, _)| in_seconds(column, &format)).collect())
}

/// Units of times of Arrow by their letter: how many are a second.
const UNITS_PER_SECOND: [(&str, f64); 4] = [("s", 1.0), ("m", 1e3), ("u", 1e6), ("n", 1e9)];

/// A column of times in seconds: instants (`tsn:UTC`) from the first of them, durations (`tDn`) as they are. The unit
/// that its name ends with is that of the integers, so that it goes.
fn in_seconds(column: Column, format: &str) -> Column {
    let (Some(unit), Ok(numbers)) = (format.strip_prefix("ts").or(format.strip_prefix("tD")), &column.content) else {
        return column;
    };
    let Some((_, per_second)) = UNITS_PER_SECOND.iter().find(|(letter, _)| unit.starts_with(letter)) else {
        return Column { content: Err(format.into()), ..column };
    };
    let name = ["_ms", "_us", "_ns"].iter().find_map(|unit| column.name.strip_suffix(unit)).unwrap_or(&column.name);
    let content = Ok(numbers.iter().map(|x| x / per_second).collect());
    Column { name: name.into(), content }
}

fn text(pointer: *const c_char) -> String {
    if pointer.is_null() {
        return String::new();
    }
    // SAFETY: strings of a schema end in a zero.
    unsafe { CStr::from_ptr(pointer) }.to_string_lossy().into_owned()
}

/// The type of the numbers in a buffer.
#[derive(Clone, Copy)]
enum Kind {
    F64,
    F32,
    I64,
    /// Instants, which are counted from the first: since 1970 they have more digits than an f64 keeps.
    Instant,
    I32,
    I16,
    I8,
    U64,
    U32,
    U16,
    U8,
}

impl Kind {
    /// The type for the format of a schema. Times are integers.
    fn of(format: &str) -> Option<Kind> {
        Some(match format {
            "g" => Kind::F64,
            "f" => Kind::F32,
            "l" => Kind::I64,
            "i" => Kind::I32,
            "s" => Kind::I16,
            "c" => Kind::I8,
            "L" => Kind::U64,
            "I" => Kind::U32,
            "S" => Kind::U16,
            "C" => Kind::U8,
            _ if format.starts_with("ts") => Kind::Instant,
            _ if format.starts_with("tD") => Kind::I64,
            _ => return None,
        })
    }

    /// Appends `length` numbers of a column from `first` on. A null becomes NaN. `origin` is the first instant.
    unsafe fn append(self, column: &Batch, first: i64, length: i64, numbers: &mut Vec<f64>, origin: &mut Option<i64>) {
        let (first, length) = (column.offset.saturating_add(first).max(0) as usize, length.max(0) as usize);
        if length == 0 {
            return;
        }
        // SAFETY: validity and values, by the specification; values hold offset + length entries.
        let (validity, values) = unsafe { (*column.buffers, *column.buffers.add(1)) };
        let validity = if column.null_count == 0 { std::ptr::null() } else { validity.cast::<u8>() };
        // SAFETY: a bit for each value.
        let is_null = |k: usize| !validity.is_null() && unsafe { *validity.add(k / 8) } >> (k % 8) & 1 == 0;
        macro_rules! take {
            ($t:ty) => {
                take!($t, |x: $t| x as f64)
            };
            ($t:ty, $number:expr) => {{
                let (values, number) = (values.cast::<$t>(), &mut $number as &mut dyn FnMut($t) -> f64);
                // SAFETY: as above; a buffer may be unaligned.
                let mut cell =
                    |k: usize| if is_null(k) { f64::NAN } else { number(unsafe { values.add(k).read_unaligned() }) };
                numbers.extend((first..first + length).map(&mut cell));
            }};
        }
        match self {
            Kind::F64 => take!(f64),
            Kind::F32 => take!(f32),
            Kind::I64 => take!(i64),
            Kind::Instant => take!(i64, |x: i64| x.wrapping_sub(*origin.get_or_insert(x)) as f64),
            Kind::I32 => take!(i32),
            Kind::I16 => take!(i16),
            Kind::I8 => take!(i8),
            Kind::U64 => take!(u64),
            Kind::U32 => take!(u32),
            Kind::U16 => take!(u16),
            Kind::U8 => take!(u8),
        }
    }
}
