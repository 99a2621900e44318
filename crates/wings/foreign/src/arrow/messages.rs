//! Reads the messages of an Arrow stream, or the messages that the index of an Arrow file lists.
//!
//! A message consists of four bytes 0xff, the length of its description in four bytes, the description (a flatbuffer), and its
//! body. Before Arrow 0.15, the bytes 0xff were missing. A stream begins with the schema. A file has an index at its end, with
//! the schema and the positions of the batches. A file is read by its index, because some writers omit the schema message.

use std::io::{self, Read};

use crate::arrow::flatbuffer::FlatTable;
use crate::arrow::schema::ArrowField;
use logs::reading::MAX_FILE_BYTES;

/// The first bytes of a file. A file also ends with these bytes, but without the two zeros.
pub(crate) const FILE_MAGIC: &[u8] = b"ARROW1\0\0";
/// Number of bytes after the index: its length, and the magic bytes.
const TAIL_BYTES: usize = 10;
/// The first bytes of every message since Arrow 0.15.
const CONTINUED: [u8; 4] = [0xff; 4];
/// Largest length of the description of a message, bytes.
const MAX_DESCRIPTION_BYTES: usize = 1 << 26;

/// Kinds of messages: `SCHEMA` is the schema of a table, `RECORD_BATCH` a group of rows.
const SCHEMA: u8 = 1;
pub(crate) const RECORD_BATCH: u8 = 3;

/// A message: its kind, description and body.
pub(crate) struct Message {
    pub kind: u8,
    pub description: Vec<u8>,
    pub body: Vec<u8>,
}

/// A function that reads bytes of a file. Arguments: position and number of bytes.
pub(crate) type ReadRange<'a> = Box<dyn Fn(u64, usize) -> io::Result<Vec<u8>> + Send + 'a>;

/// The source of the messages: a stream or a file.
pub(crate) enum Messages<'a> {
    Stream {
        source: Box<dyn Read + Send + 'a>,
        at: u64,
    },
    /// A file, and the positions and lengths of the batches that are not read yet.
    File {
        pieces: ReadRange<'a>,
        batches: std::vec::IntoIter<MessageRange>,
        all: usize,
    },
}

/// Position and lengths of a message in a file.
pub(crate) struct MessageRange {
    at: u64,
    /// Number of bytes of the description, with the bytes before it (0xff and length). `body`: number of bytes of the body.
    description: usize,
    body: usize,
}

impl<'a> Messages<'a> {
    /// Opens a stream, and reads its schema.
    pub(crate) fn of_stream(source: Box<dyn Read + Send + 'a>) -> Result<(Messages<'a>, Vec<ArrowField>), String> {
        let mut messages = Messages::Stream { source, at: 0 };
        let message = messages.next()?.filter(|message| message.kind == SCHEMA);
        let message = message.ok_or("it does not begin with the schema of a table: it is no Arrow stream")?;
        let schema = FlatTable::root(&message.description)?.table(2)?.ok_or("its schema is empty")?;
        let fields = ArrowField::all(&schema)?;
        Ok((messages, fields))
    }

    /// Opens a file of `length` bytes, and reads its schema.
    pub(crate) fn of_file(pieces: ReadRange<'a>, length: u64) -> Result<(Messages<'a>, Vec<ArrowField>), String> {
        let failed = |e: io::Error| format!("cannot be read: {e}");
        let tail = pieces(length.saturating_sub(TAIL_BYTES as u64), TAIL_BYTES.min(length as usize)).map_err(failed)?;
        let cut = "it does not end with ARROW1: it is cut short, or its writer was never closed; its index stands at the \
                   end, so nothing can be read: write or copy it again";
        let size = tail.strip_suffix(&FILE_MAGIC[..6]).and_then(|size| size.try_into().ok()).map(u32::from_le_bytes);
        let size = size.ok_or(cut)? as usize;
        let start = (length - TAIL_BYTES as u64).checked_sub(size as u64).filter(|_| size <= MAX_DESCRIPTION_BYTES);
        let start = start.ok_or_else(|| format!("the index claims {size} bytes of a file of {length}"))?;
        let index = pieces(start, size).map_err(failed)?;
        let index = FlatTable::root(&index)?;
        let fields = ArrowField::all(&index.table(1)?.ok_or("its schema is empty")?)?;
        // An entry of the index has 24 bytes: position of the message, 8 bytes; length of its description, 4 bytes and 4 bytes of
        // padding; length of its body, 8 bytes.
        let place = |block: &[u8]| {
            let word = |at: usize| block[at..].first_chunk().map_or(0, |b| u64::from_le_bytes(*b));
            let [description, body] = [word(8) & 0xffff_ffff, word(16)];
            let end = word(0).checked_add(description).and_then(|end| end.checked_add(body));
            let inside = end.is_some_and(|end| end <= length) && body <= MAX_FILE_BYTES;
            let place = || MessageRange { at: word(0), description: description as usize, body: body as usize };
            inside
                .then(place)
                .ok_or_else(|| format!("the index has a batch of {body} bytes at byte {} of {length}", word(0)))
        };
        let batches = index.elements(3, 24)?.chunks_exact(24).map(place).collect::<Result<Vec<_>, _>>()?;
        let all = batches.len();
        Ok((Messages::File { pieces, batches: batches.into_iter(), all }, fields))
    }

    /// Reads the next message. `None` at the end of the file or stream.
    pub(crate) fn next(&mut self) -> Result<Option<Message>, String> {
        match self {
            Messages::Stream { source, at } => streamed(source, at),
            Messages::File { pieces, batches, .. } => batches.next().map(|place| placed(pieces, &place)).transpose(),
        }
    }

    /// Describes the position of the message that was read last, for error messages.
    pub(crate) fn place(&self) -> String {
        match self {
            Messages::Stream { at, .. } => format!("batch before byte {at}"),
            Messages::File { batches, all, .. } => format!("batch {} of {all}", all - batches.len()),
        }
    }
}

fn placed(pieces: &ReadRange, place: &MessageRange) -> Result<Message, String> {
    let failed = |e: io::Error| format!("cannot be read: {e}");
    let head = pieces(place.at, place.description).map_err(failed)?;
    let before = if head.starts_with(&CONTINUED) { 8 } else { 4 };
    let description = head.get(before..).unwrap_or_default().to_vec();
    let kind = FlatTable::root(&description)?.number(1)?.map_or(0, u8::from_le_bytes);
    let body = pieces(place.at + place.description as u64, place.body).map_err(failed)?;
    Ok(Message { kind, description, body })
}

fn streamed(source: &mut dyn Read, at: &mut u64) -> Result<Option<Message>, String> {
    // Reads `count` bytes. Memory is allocated only for bytes that exist, so a wrong length in the file does no harm.
    let mut piece = |count: u64, may_end: bool| {
        let mut piece = Vec::new();
        (&mut *source).take(count).read_to_end(&mut piece).map_err(|e| format!("cannot be read: {e}"))?;
        *at += piece.len() as u64;
        match piece.len() as u64 == count || (may_end && piece.is_empty()) {
            true => Ok(piece),
            false => {
                Err(format!("it is cut short at byte {at}, or its writer was never closed: write or copy it again"))
            }
        }
    };
    let mut length = piece(4, true)?;
    if length == CONTINUED {
        length = piece(4, false)?;
    }
    // A stream ends with a length of zero, or without any end marker.
    let length = <[u8; 4]>::try_from(length).map_or(0, u32::from_le_bytes);
    if length == 0 {
        return Ok(None);
    }
    if length as usize > MAX_DESCRIPTION_BYTES {
        return Err(format!("a description claims {length} bytes; at most {MAX_DESCRIPTION_BYTES} are expected"));
    }
    let description = piece(length.into(), false)?;
    let message = FlatTable::root(&description)?;
    let (kind, size) = (message.number(1)?.map_or(0, u8::from_le_bytes), message.length(3)? as u64);
    if size > MAX_FILE_BYTES {
        return Err(format!("a batch of {size} bytes: at most {MAX_FILE_BYTES} are read; write smaller batches"));
    }
    let body = piece(size, false)?;
    Ok(Some(Message { kind, description, body }))
}
