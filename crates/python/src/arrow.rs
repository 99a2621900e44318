//! Reads numbers from Arrow streams, which pandas, polars and pyarrow offer by `__arrow_c_stream__`, and exports tables.
//!
//! A stream is a struct of columns that comes in batches. Integers, floats and times (in seconds) are read; a null becomes NaN.
//! Other columns are not read, only their format is reported, because libraries have their own formats. The numbers are copied
//! into f64, so no buffer outlives the call. The crate `arrow-array` provides the structures, their release, and the exported
//! stream.
//!
//! `unsafe` is needed to take a stream out of a capsule, whose name states the type, to call its functions, and to read columns
//! of a batch. It is sound if the owner filled the structures as the specification requires.
#![allow(unsafe_code)]

use std::ffi::c_void;
use std::ptr::NonNull;

use arrow_array::ffi::{FFI_ArrowArray, FFI_ArrowSchema, from_ffi_and_data_type};
use arrow_array::ffi_stream::FFI_ArrowArrayStream;
use arrow_array::types::*;
use arrow_array::{ArrayRef, PrimitiveArray, RecordBatch, RecordBatchIterator};
use arrow_schema::DataType::{self, *};
use arrow_schema::TimeUnit;
use pyo3::prelude::*;
use pyo3::types::{PyCapsule, PyCapsuleMethods};

use crate::error::error;

/// A column of a frame.
pub struct FrameColumn {
    /// The name of the column.
    pub name: String,
    /// The numbers; for a column without numbers, its Arrow format.
    pub content: Result<Vec<f64>, String>,
}

/// Reads all columns of an object that has `__arrow_c_stream__`.
pub fn columns(frame: &Bound<'_, PyAny>) -> PyResult<Vec<FrameColumn>> {
    let capsule = frame.call_method0("__arrow_c_stream__")?.cast_into::<PyCapsule>()?;
    let pointer: NonNull<c_void> = capsule.pointer_checked(Some(c"arrow_array_stream"))?;
    // SAFETY: a capsule of this name holds a stream. `from_raw` moves it out, so we own it, and leaves a released stream in the
    // capsule.
    let mut stream = unsafe { FFI_ArrowArrayStream::from_raw(pointer.as_ptr().cast()) };
    // If another consumer took the stream, it has no `release`, and its functions must not be called.
    if stream.release().is_none() {
        return Err(error("the Arrow stream was released: another reader took it; ask its owner for a new one"));
    }
    let (mut schema, get_schema) = (FFI_ArrowSchema::empty(), stream.get_schema());
    // SAFETY: the call follows the specification, and we own both structures.
    let code = get_schema.map(|get| unsafe { get(&mut stream, &mut schema) });
    if code != Some(0) || schema.release().is_none() {
        return Err(failed("schema"));
    }
    if schema.format() != "+s" {
        return Err(error("a table with columns is expected, not a single column"));
    }
    let (mut columns, kinds): (Vec<FrameColumn>, Vec<Option<DataType>>) =
        schema.children().map(FrameColumn::of).unzip();
    let mut origins = vec![None; columns.len()];
    loop {
        let (mut batch, get_next) = (FFI_ArrowArray::empty(), stream.get_next());
        // SAFETY: the call follows the specification, as for the schema.
        if get_next.map(|next| unsafe { next(&mut stream, &mut batch) }) != Some(0) {
            return Err(failed("rows"));
        }
        if batch.is_released() {
            return Ok(columns);
        }
        if batch.num_children() != columns.len() {
            return Err(failed("batch of the columns of its schema"));
        }
        for (k, (column, kind)) in columns.iter_mut().zip(&kinds).enumerate() {
            if let (Ok(numbers), Some(kind)) = (&mut column.content, kind) {
                append(&batch, k, kind, &mut origins[k], numbers)?;
            }
        }
    }
}

fn failed(what: &str) -> PyErr {
    error(format_args!("the Arrow stream gives no {what}"))
}

impl FrameColumn {
    /// An empty column, and the type of its numbers; `None` if it has no numbers. Times are converted to seconds, so a unit at
    /// the end of their name (`_ms`) is removed.
    fn of(schema: &FFI_ArrowSchema) -> (FrameColumn, Option<DataType>) {
        let is_number =
            |kind: &DataType| kind.is_integer() || matches!(kind, Float32 | Float64 | Timestamp(..) | Duration(_));
        let kind = DataType::try_from(schema).ok().filter(is_number);
        let name = schema.name().unwrap_or_default();
        let unit = ["_ms", "_us", "_ns"].iter().find_map(|unit| name.strip_suffix(unit));
        let name = if let Some(Timestamp(..) | Duration(_)) = kind { unit.unwrap_or(name) } else { name };
        let content = if kind.is_some() { Ok(Vec::new()) } else { Err(schema.format().into()) };
        (FrameColumn { name: name.into(), content }, kind)
    }
}

/// Appends the numbers of column `k` of a batch; times in seconds. Instants are counted from `origin`, the first instant of the
/// column, because f64 has too few digits for a count from 1970. Fails if the column is shorter than the batch states.
fn append(
    batch: &FFI_ArrowArray,
    k: usize,
    kind: &DataType,
    origin: &mut Option<i64>,
    numbers: &mut Vec<f64>,
) -> PyResult<()> {
    let per_second = |unit: &TimeUnit| match unit {
        TimeUnit::Second => 1.0,
        TimeUnit::Millisecond => 1e3,
        TimeUnit::Microsecond => 1e6,
        TimeUnit::Nanosecond => 1e9,
    };
    macro_rules! take {
        ($kind:ty) => {
            take!($kind, |x| x as f64)
        };
        ($kind:ty, $number:expr) => {{
            let (values, mut number) = (values::<$kind>(batch, k)?, $number);
            numbers.extend(values.iter().map(|x| x.map_or(f64::NAN, &mut number)))
        }};
    }
    match kind {
        Float64 => take!(Float64Type),
        Float32 => take!(Float32Type),
        Int64 => take!(Int64Type),
        Int32 => take!(Int32Type),
        Int16 => take!(Int16Type),
        Int8 => take!(Int8Type),
        UInt64 => take!(UInt64Type),
        UInt32 => take!(UInt32Type),
        UInt16 => take!(UInt16Type),
        UInt8 => take!(UInt8Type),
        Duration(unit) => take!(Int64Type, |x| x as f64 / per_second(unit)),
        Timestamp(unit, _) => {
            take!(Int64Type, |x: i64| x.wrapping_sub(*origin.get_or_insert(x)) as f64 / per_second(unit))
        }
        // `FrameColumn::of` accepts only the types above as numbers.
        _ => {}
    }
    Ok(())
}

/// The values of column `k` of a batch. Fails if the column is shorter than the batch states.
fn values<T: ArrowPrimitiveType>(batch: &FFI_ArrowArray, k: usize) -> PyResult<PrimitiveArray<T>> {
    let refused = || failed("values of a column of numbers");
    let (column, first, length) = (batch.child(k), batch.offset(), batch.len());
    if length == 0 {
        return Ok(PrimitiveArray::from_iter_values([]));
    }
    if column.num_buffers() != 2 || first.checked_add(length).is_none_or(|end| end > column.len()) {
        return Err(refused());
    }
    // SAFETY: a column of numbers has two buffers (validity, values) of the stated lengths. The copied structure releases
    // nothing, and is dropped before the batch.
    let data = unsafe {
        let mut lent = std::ptr::read(column);
        lent.set_release(None);
        from_ffi_and_data_type(lent, T::DATA_TYPE)
    };
    Ok(PrimitiveArray::from(data.map_err(|_| refused())?.slice(first, length)))
}

/// Exports columns of equal length as an Arrow stream in a capsule.
pub fn stream<'py>(py: Python<'py>, columns: Vec<(&str, ArrayRef)>) -> PyResult<Bound<'py, PyCapsule>> {
    let columns = columns.into_iter().map(|(name, column)| (name, column, true));
    let batch = RecordBatch::try_from_iter_with_nullable(columns).map_err(error)?;
    let schema = batch.schema();
    let stream = FFI_ArrowArrayStream::new(Box::new(RecordBatchIterator::new([Ok(batch)], schema)));
    PyCapsule::new_with_value(py, stream, c"arrow_array_stream")
}
