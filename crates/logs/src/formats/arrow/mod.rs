//! Arrow IPC: files (Feather, version 2) and streams.

mod batch;
pub(crate) mod batches;
mod flatbuffer;
mod messages;
mod schema;
