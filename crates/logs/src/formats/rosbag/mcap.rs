//! Reads the messages of an MCAP file (mcap.dev, version 0), in the order of the file.
//!
//! A record has an opcode, its length in eight bytes, and its content. Numbers are little-endian; a text follows its length. Four
//! kinds of records are decoded: schemas, channels, messages and chunks (compressed records). The index at the end is not used,
//! so a file without it, of a recorder that was killed, is read up to its last complete record.

use std::collections::BTreeMap;
use std::io::Read;

use gate::budget::Budget;

use crate::formats::compression::{Compression, MAX_UNPACKED_BYTES};
use crate::formats::message::{Channel, Message, ReadOutcome, Receiver};
use crate::formats::rosbag::cdr::Cursor;

/// A record of a chunk may use the memory budget of the file divided by this number.
const RECORD_BUDGET_SHARE: usize = 4;
/// The first bytes of an MCAP file.
const MAGIC: &[u8] = b"\x89MCAP0\r\n";

/// The byte at the start of a record that states its type.
mod opcode {
    pub(super) const SCHEMA: u8 = 3;
    pub(super) const CHANNEL: u8 = 4;
    pub(super) const MESSAGE: u8 = 5;
    pub(super) const CHUNK: u8 = 6;
    /// The record that ends the data, and the record that ends the file. After the data there is only the index.
    pub(super) const ENDS: [u8; 2] = [15, 2];
}

/// A function that receives the opcode and the content of each record.
type RecordReceiver<'a> = dyn FnMut(u8, &[u8]) -> Result<(), String> + 'a;

/// Passes every message of a file to `each`. `length`: bytes of the file. Decompressed bytes of chunks are taken from `work`.
///
/// Fails if a record is damaged. A file that ends early is not an error: the outcome states the position.
pub(crate) fn read(
    mut source: impl Read,
    length: u64,
    work: &mut Budget,
    each: &mut Receiver,
) -> Result<ReadOutcome, String> {
    let mut reader = ChunkReader { schemas: BTreeMap::new(), channels: BTreeMap::new(), work, each };
    let mut at = MAGIC.len() as u64;
    let mut magic = [0; MAGIC.len()];
    source.read_exact(&mut magic).map_err(|e| format!("cannot be read: {e}"))?;
    if magic != MAGIC {
        return Err(format!("begins with the bytes {magic:02x?} and not with those of MCAP, {MAGIC:02x?}"));
    }
    let whole = records(source, length.saturating_sub(at), MAX_UNPACKED_BYTES, &mut |opcode, content| {
        let start = at;
        at += 9 + content.len() as u64;
        reader.record(opcode, content).map_err(|e| format!("record at byte {start}: {e}"))
    });
    let whole = whole.map_err(|e| if e.starts_with("record at") { e } else { format!("record at byte {at}: {e}") })?;
    let cut = format!("is cut short: whole up to byte {at} of {length}; what is behind is not read");
    Ok(ReadOutcome { channels: reader.channels.into_values().collect(), cut: (!whole).then_some(cut) })
}

/// Passes the records in `length` bytes to `each`, up to the record that ends the data. Returns `false` if the bytes end before
/// this record. `longest`: largest size of a record, bytes.
fn records(mut source: impl Read, length: u64, longest: usize, each: &mut RecordReceiver) -> Result<bool, String> {
    let failed = |e: std::io::Error| format!("cannot be read: {e}");
    let (mut left, mut content) = (length, Vec::new());
    loop {
        let mut head = Vec::with_capacity(9);
        source.by_ref().take(left.min(9)).read_to_end(&mut head).map_err(failed)?;
        let Some((&opcode, size)) = head.split_first().and_then(|(o, size)| Some((o, <[u8; 8]>::try_from(size).ok()?)))
        else {
            return Ok(false);
        };
        if opcode::ENDS.contains(&opcode) {
            return Ok(true);
        }
        // The stated length is compared with the number of remaining bytes before memory is allocated.
        left -= 9;
        let size = u64::from_le_bytes(size);
        if size > left {
            return Ok(false);
        }
        if size > longest as u64 {
            return Err(format!("a record unfolds to {size} bytes, and of a file of this size {longest} are read"));
        }
        content.clear();
        source.by_ref().take(size).read_to_end(&mut content).map_err(failed)?;
        if (content.len() as u64) < size {
            return Ok(false);
        }
        left -= size;
        each(opcode, &content)?;
    }
}

/// The fields at the start of a chunk, before its compressed records.
struct ChunkHead<'a> {
    unpacked_size: u64,
    unpacked_crc: u32,
    compression: &'a str,
}

struct ChunkReader<'a, 'b> {
    /// For each message type, its name and its definition.
    schemas: BTreeMap<u16, (String, Option<(String, String)>)>,
    channels: BTreeMap<u16, Channel>,
    work: &'a mut Budget,
    each: &'a mut Receiver<'b>,
}

impl ChunkReader<'_, '_> {
    fn record(&mut self, opcode: u8, content: &[u8]) -> Result<(), String> {
        let mut fields = Cursor::plain(content, "whole record");
        match opcode {
            opcode::SCHEMA => self.schema(&mut fields),
            opcode::CHANNEL => self.channel(&mut fields),
            opcode::MESSAGE => self.message(&mut fields),
            opcode::CHUNK => {
                let _first_and_last_time: [[u8; 8]; 2] = [fields.number()?, fields.number()?];
                let unpacked_size = fields.number().map(u64::from_le_bytes)?;
                let unpacked_crc = fields.u32()?;
                let compression = fields.text()?;
                let packed_size = fields.number().map(u64::from_le_bytes)?;
                let packed = fields.bytes(usize::try_from(packed_size).unwrap_or(usize::MAX))?;
                self.chunk(&ChunkHead { unpacked_size, unpacked_crc, compression }, packed)
            }
            _ => Ok(()),
        }
    }

    fn schema(&mut self, fields: &mut Cursor) -> Result<(), String> {
        let id = fields.number().map(u16::from_le_bytes)?;
        let (name, encoding) = (fields.text()?, fields.text()?);
        let length = fields.u32()? as usize;
        let definition = std::str::from_utf8(fields.bytes(length)?).ok();
        let definition = definition.map(|text| (encoding.to_string(), text.to_string()));
        self.schemas.insert(id, (name.to_string(), definition));
        Ok(())
    }

    fn channel(&mut self, fields: &mut Cursor) -> Result<(), String> {
        let [id, schema] = [fields.number()?, fields.number()?].map(u16::from_le_bytes);
        let (topic, encoding) = (fields.text()?.to_string(), fields.text()?.to_string());
        let metadata = fields.u32()? as usize;
        fields.bytes(metadata)?;
        let (schema, definition) = self.schemas.get(&schema).cloned().unwrap_or_default();
        self.channels.insert(id, Channel { topic, schema, encoding, definition });
        Ok(())
    }

    fn message(&mut self, fields: &mut Cursor) -> Result<(), String> {
        let id = fields.number().map(u16::from_le_bytes)?;
        let _sequence = fields.u32()?;
        let log_time = fields.number().map(i64::from_le_bytes)?;
        let _publish_time: [u8; 8] = fields.number()?;
        let data = fields.bytes(fields.left())?;
        let channel = self.channels.get(&id).ok_or(format!("a message of undeclared channel {id}"))?;
        (self.each)(&Message { channel, log_time, data }).map_err(|e| format!("message of {}: {e}", channel.topic))
    }

    fn chunk(&mut self, head: &ChunkHead, packed: &[u8]) -> Result<(), String> {
        let compression = match head.compression {
            "" => Compression::None,
            "zstd" => Compression::Zstd,
            "lz4" => Compression::Lz4Frame,
            other => {
                return Err(format!(
                    "a chunk is compressed with `{other}`; zstd, lz4 and none are read: recompress the file with \
                     `mcap compress`"
                ));
            }
        };
        let damaged = |e: String| format!("the chunk is damaged: {e}; `mcap recover` saves the others");
        let size = usize::try_from(head.unpacked_size).unwrap_or(usize::MAX);
        self.work.draw(size).map_err(damaged)?;
        let unpacked = compression.reader(packed).map_err(damaged)?;
        let mut unpacked = Summed { source: unpacked, sum: flate2::Crc::new() };
        let mut taken = 0;
        // The buffer for a record is copied when it grows by doubling, so a record may use only a share of the memory.
        let longest = self.work.whole() / RECORD_BUDGET_SHARE;
        let mut take = |opcode: u8, content: &[u8]| {
            taken += 9 + content.len();
            match opcode {
                // No record has the opcode 0. The decompressed bytes are zeros at the end, so the chunk is damaged.
                0 => Err("the chunk is damaged: it holds records of the opcode 0".into()),
                opcode::CHUNK => Ok(()),
                _ => self.record(opcode, content),
            }
        };
        let read = records(&mut unpacked, size as u64, longest, &mut take);
        // If the bytes are damaged, this damage is reported before any error of the records.
        let rest = std::io::copy(&mut unpacked.by_ref().take(1 + size as u64), &mut std::io::sink());
        let (found, claimed) = (&unpacked.sum, head.unpacked_crc);
        rest.map_err(|e| damaged(format!("it cannot be unpacked: {e}")))?;
        if u64::from(found.amount()) != (size as u64) % (1 << 32) {
            return Err(damaged(format!("it does not unpack to the {size} bytes it claims")));
        }
        // A checksum of zero means that the writer computed none.
        if claimed != 0 && claimed != found.sum() {
            return Err(damaged(format!("its checksum is {:08x} instead of {claimed:08x}", found.sum())));
        }
        read?;
        if taken == size { Ok(()) } else { Err(damaged("it ends within a record".into())) }
    }
}

/// Computes the checksum of the bytes that are read from a source.
struct Summed<R> {
    source: R,
    sum: flate2::Crc,
}

impl<R: Read> Read for Summed<R> {
    fn read(&mut self, out: &mut [u8]) -> std::io::Result<usize> {
        let count = self.source.read(out)?;
        self.sum.update(&out[..count]);
        Ok(count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file with schema 1 `T`, channel 2 `/a` of this type, one message `x` at 5 ns, one record of another kind, and the end.
    fn file() -> Vec<u8> {
        let record =
            |opcode: u8, content: &[u8]| [&[opcode, content.len() as u8, 0, 0, 0, 0, 0, 0, 0], content].concat();
        let message = [&[2, 0, 0, 0, 0, 0][..], &5u64.to_le_bytes(), &6u64.to_le_bytes(), b"x"].concat();
        let channel = [&[2, 0, 1, 0, 2, 0, 0, 0][..], b"/a", &[3, 0, 0, 0], b"cdr", &[0; 4]].concat();
        [
            MAGIC.to_vec(),
            record(opcode::SCHEMA, &[1, 0, 1, 0, 0, 0, b'T', 0, 0, 0, 0, 0, 0, 0, 0]),
            record(opcode::CHANNEL, &channel),
            record(9, b"an attachment"),
            record(opcode::MESSAGE, &message),
            record(opcode::ENDS[0], &[0; 4]),
        ]
        .concat()
    }

    type Found = Vec<(Channel, i64, Vec<u8>)>;

    fn messages(bytes: &[u8]) -> (Found, Result<ReadOutcome, String>) {
        let mut found = Vec::new();
        let outcome = read(bytes, bytes.len() as u64, &mut Budget::of(bytes.len()), &mut |m| {
            found.push((m.channel.clone(), m.log_time, m.data.to_vec()));
            Ok(())
        });
        (found, outcome)
    }

    #[test]
    fn a_message_with_its_channel() {
        let (found, outcome) = messages(&file());
        let channel = Channel {
            topic: "/a".into(),
            schema: "T".into(),
            encoding: "cdr".into(),
            definition: Some((String::new(), String::new())),
        };
        assert_eq!(found, [(channel.clone(), 5, b"x".to_vec())]);
        let outcome = outcome.unwrap();
        assert_eq!((outcome.channels, outcome.cut), (vec![channel], None));
    }

    #[test]
    fn the_place_of_a_cut() {
        let whole = file();
        let ends: Vec<u64> = [8, 32, 62, 84, 116].to_vec();
        for cut in 8..whole.len() - 4 {
            let (found, outcome) = messages(&whole[..cut]);
            let cut_message = outcome.unwrap().cut;
            let expected = *ends.iter().rfind(|&&end| end <= cut as u64).unwrap();
            // The head of the last record marks the end of the data, so the content of this record may be missing.
            let expected = format!("is cut short: whole up to byte {expected} of {cut}; what is behind is not read");
            assert_eq!(cut_message, (cut < 125).then_some(expected), "{cut}");
            assert_eq!(found.len(), usize::from(cut >= 116), "{cut}");
        }
    }

    #[test]
    fn an_error_of_the_receiver_has_its_place() {
        let bytes = file();
        let refuse = &mut |_: &Message| Err("it is not liked".to_string());
        let message = read(&bytes[..], bytes.len() as u64, &mut Budget::of(bytes.len()), refuse).unwrap_err();
        assert_eq!(message, "record at byte 84: message of /a: it is not liked");
    }
}
