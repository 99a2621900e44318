//! A table as an Arrow stream of one batch: what `__arrow_c_stream__` hands to pyarrow, polars and pandas.
//!
//! The layout is that of the specification "The Arrow C data interface" and "The Arrow C stream interface", whose structures
//! stand in `arrow`. Columns are f64 (`g`), where an absent number is a null, and texts (`u`).
//!
//! `unsafe`: a structure goes out by pointer. Its `private` holds the box of its buffers, and its `release` takes that
//! box back. This is sound because `release` is called once, by the consumer or by `Drop`, since it clears itself. A
//! child that the consumer has taken is cleared by the consumer, and `Drop` skips it.
#![allow(unsafe_code)]

use std::ffi::{CStr, CString, c_char, c_void};
use std::ptr::{null, null_mut};

use pyo3::prelude::*;
use pyo3::types::PyCapsule;

use crate::arrow::{Batch, Schema, Stream};
use crate::error::error;

/// A column that goes out.
pub enum Content {
    /// Numbers, null where there is none.
    Numbers(Vec<Option<f64>>),
    /// Texts.
    Texts(Vec<String>),
}

/// The flag of a column that may hold nulls.
const FLAG_NULLABLE: i64 = 2;

/// No error; no batch of this stream can fail.
const SUCCESS: i32 = 0;

/// A capsule that holds a stream of these columns, all of one length.
pub fn stream<'py>(py: Python<'py>, columns: Vec<(&str, Content)>) -> PyResult<Bound<'py, PyCapsule>> {
    let mut table = Table { schemas: Vec::new(), columns: Vec::new(), length: 0, is_done: false };
    for (name, content) in columns {
        table.schemas.push((CString::new(name).map_err(error)?, content.format()));
        let column = Buffers::of(content)?;
        table.length = column.length;
        table.columns.push(column);
    }
    let stream = Stream {
        get_schema: Some(get_schema),
        get_next: Some(get_next),
        get_last_error: Some(get_last_error),
        release: Some(release_stream),
        private: Box::into_raw(Box::new(table)).cast(),
    };
    PyCapsule::new_with_value(py, stream, c"arrow_array_stream")
}

/// What a stream holds until its batch is fetched.
struct Table {
    schemas: Vec<(CString, &'static CStr)>,
    columns: Vec<Buffers>,
    length: i64,
    is_done: bool,
}

// SAFETY: the box behind `private` belongs to the stream alone, and holds nothing that is bound to a thread.
unsafe impl Send for Stream {}

impl Drop for Stream {
    fn drop(&mut self) {
        if let Some(release) = self.release {
            // SAFETY: `release` is called once, because it clears itself.
            unsafe { release(self) }
        }
    }
}

/// The buffers of a column: validity, then numbers, or offsets and bytes.
struct Buffers {
    length: i64,
    nulls: i64,
    validity: Option<Vec<u8>>,
    numbers: Vec<f64>,
    offsets: Vec<i32>,
    bytes: Vec<u8>,
}

impl Content {
    /// Its type, as a schema has it.
    fn format(&self) -> &'static CStr {
        match self {
            Content::Numbers(_) => c"g",
            Content::Texts(_) => c"u",
        }
    }
}

impl Buffers {
    fn of(content: Content) -> PyResult<Buffers> {
        let mut buffers = Buffers {
            length: 0,
            nulls: 0,
            validity: None,
            numbers: Vec::new(),
            offsets: Vec::new(),
            bytes: Vec::new(),
        };
        match content {
            Content::Numbers(numbers) => {
                buffers.length = numbers.len() as i64;
                buffers.nulls = numbers.iter().filter(|x| x.is_none()).count() as i64;
                let mut validity = vec![0_u8; numbers.len().div_ceil(8)];
                let there = numbers.iter().enumerate().filter(|(_, x)| x.is_some());
                there.for_each(|(k, _)| validity[k / 8] |= 1 << (k % 8));
                buffers.validity = (buffers.nulls > 0).then_some(validity);
                buffers.numbers = numbers.into_iter().map(|x| x.unwrap_or(0.0)).collect();
            }
            Content::Texts(texts) => {
                buffers.length = texts.len() as i64;
                buffers.offsets.push(0);
                for text in texts {
                    buffers.bytes.extend(text.bytes());
                    // A table of parameters takes some kilobytes. Two gigabytes are the limit of this Arrow type.
                    buffers.offsets.push(i32::try_from(buffers.bytes.len()).map_err(error)?);
                }
            }
        }
        Ok(buffers)
    }

    /// Pointers to the buffers. They are valid as long as `self` lives.
    fn places(&self) -> Vec<*const c_void> {
        let mut places = vec![self.validity.as_ref().map_or(null(), |bits| bits.as_ptr().cast())];
        if self.offsets.is_empty() {
            places.push(self.numbers.as_ptr().cast());
        } else {
            places.extend([self.offsets.as_ptr().cast::<c_void>(), self.bytes.as_ptr().cast()]);
        }
        places
    }
}

/// What a schema points to: its name and its children.
struct SchemaParts {
    name: CString,
    children: Vec<*mut Schema>,
}

fn schema(name: CString, format: &'static CStr, children: Vec<Schema>) -> Schema {
    let children = children.into_iter().map(|child| Box::into_raw(Box::new(child))).collect();
    let parts = Box::into_raw(Box::new(SchemaParts { name, children }));
    // SAFETY: the box was made above.
    let SchemaParts { name, children } = unsafe { &mut *parts };
    Schema {
        format: format.as_ptr(),
        name: name.as_ptr(),
        metadata: null(),
        flags: FLAG_NULLABLE,
        n_children: children.len() as i64,
        children: children.as_mut_ptr(),
        dictionary: null_mut(),
        release: Some(release_schema),
        private: parts.cast(),
    }
}

unsafe extern "C" fn release_schema(schema: *mut Schema) {
    // SAFETY: the schema is one of `schema`, not yet released.
    unsafe {
        let parts = Box::from_raw((*schema).private.cast::<SchemaParts>());
        (*schema).release = None;
        parts.children.iter().for_each(|&child| drop(Box::from_raw(child)));
    }
}

/// What a batch points to: the buffers of its columns, and the children.
struct BatchParts {
    _buffers: Option<Buffers>,
    places: Vec<*const c_void>,
    children: Vec<*mut Batch>,
}

fn batch(length: i64, buffers: Option<Buffers>, children: Vec<Batch>) -> Batch {
    // A struct has one buffer: its validity, which is absent.
    let (places, nulls) = buffers.as_ref().map_or((vec![null()], 0), |b| (b.places(), b.nulls));
    let children = children.into_iter().map(|child| Box::into_raw(Box::new(child))).collect();
    let parts = Box::into_raw(Box::new(BatchParts { _buffers: buffers, places, children }));
    // SAFETY: the box was made above.
    let BatchParts { places, children, .. } = unsafe { &mut *parts };
    Batch {
        length,
        null_count: nulls,
        offset: 0,
        n_buffers: places.len() as i64,
        n_children: children.len() as i64,
        buffers: places.as_mut_ptr(),
        children: children.as_mut_ptr(),
        dictionary: null_mut(),
        release: Some(release_batch),
        private: parts.cast(),
    }
}

unsafe extern "C" fn release_batch(batch: *mut Batch) {
    // SAFETY: the batch is one of `batch`, not yet released.
    unsafe {
        let parts = Box::from_raw((*batch).private.cast::<BatchParts>());
        (*batch).release = None;
        parts.children.iter().for_each(|&child| drop(Box::from_raw(child)));
    }
}

unsafe extern "C" fn get_schema(stream: *mut Stream, out: *mut Schema) -> i32 {
    // SAFETY: the stream is one of `stream`, not yet released. Nothing that `out` held before is ours.
    unsafe {
        let table = &*(*stream).private.cast::<Table>();
        let columns = table.schemas.iter().map(|(name, format)| schema(name.clone(), format, Vec::new())).collect();
        out.write(schema(CString::default(), c"+s", columns));
    }
    SUCCESS
}

unsafe extern "C" fn get_next(stream: *mut Stream, out: *mut Batch) -> i32 {
    // SAFETY: as of `get_schema`.
    unsafe {
        let table = &mut *(*stream).private.cast::<Table>();
        if std::mem::replace(&mut table.is_done, true) {
            // A released batch, all zeros, is the end.
            out.write(std::mem::zeroed());
            return SUCCESS;
        }
        let columns = std::mem::take(&mut table.columns).into_iter();
        let columns = columns.map(|column| batch(column.length, Some(column), Vec::new())).collect();
        out.write(batch(table.length, None, columns));
    }
    SUCCESS
}

unsafe extern "C" fn get_last_error(_: *mut Stream) -> *const c_char {
    null()
}

unsafe extern "C" fn release_stream(stream: *mut Stream) {
    // SAFETY: the stream is one of `stream`, not yet released.
    unsafe {
        drop(Box::from_raw((*stream).private.cast::<Table>()));
        (*stream).release = None;
    }
}
