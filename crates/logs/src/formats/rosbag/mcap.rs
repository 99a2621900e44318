//! The messages of an MCAP file (mcap.dev, version 0), in file order.
//!
//! The crate `mcap` takes records apart. Chunks are unpacked here, record by record, and a record is passed to the crate
//! only if the file is long enough to hold it. The index at the end is not used. So the file of a recorder that was
//! killed is read as far as it is whole. Attachments and metadata are skipped unparsed.

use std::collections::BTreeMap;
use std::io::Read;

use gate::budget::Budget;
use mcap::McapError;
use mcap::records::{ChunkHeader, Record, op};
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};

use crate::formats::compression::{Compression, MAX_UNPACKED_BYTES};
use crate::formats::rosbag::message::{Channel, Message, Outcome, Receiver};

/// Of what a file may take, a record of a chunk may take one part in so many.
const RECORD_BUDGET_SHARE: usize = 4;
/// Bytes handed over at a time.
const BYTES_PER_PIECE: usize = 1 << 16;

/// Receiver of records: opcode and content.
type RecordReceiver<'a> = dyn FnMut(u8, &[u8]) -> Result<(), String> + 'a;

/// Hands every message of a file of `length` bytes to `each`. What its chunks unfold to is drawn from `work`.
///
/// Fails when a record is damaged; a file that ends early is no failure but an `Outcome`.
pub(crate) fn read(source: impl Read, length: u64, work: &mut Budget, each: &mut Receiver) -> Result<Outcome, String> {
    let mut reader = Reader { schemas: BTreeMap::new(), channels: BTreeMap::new(), work, each };
    let options = LinearReaderOptions::default().with_emit_chunks(true).with_skip_end_magic(true);
    let mut at = mcap::MAGIC.len() as u64;
    let whole = records(source, length, options, MAX_UNPACKED_BYTES, &mut |opcode, content| {
        let start = at;
        at += 9 + content.len() as u64;
        reader.record(opcode, content).map_err(|e| format!("record at byte {start}: {e}"))
    });
    let whole = whole.map_err(|e| if e.starts_with("record at") { e } else { format!("record at byte {at}: {e}") })?;
    let cut = format!("is cut short: whole up to byte {at} of {length}; what is behind is not read");
    Ok(Outcome { channels: reader.channels.into_values().collect(), cut: (!whole).then_some(cut) })
}

/// Hands over the records in `length` bytes, each of at most `longest`, up to the record that ends the data; `false` when
/// the bytes end before it.
fn records(
    mut source: impl Read,
    length: u64,
    options: LinearReaderOptions,
    longest: usize,
    each: &mut RecordReceiver,
) -> Result<bool, String> {
    let mut reader = LinearReader::new_with_options(options.with_record_length_limit(longest));
    let mut left = length;
    while let Some(event) = reader.next_event() {
        match event {
            Ok(LinearReadEvent::ReadRequest(need)) => {
                // A claimed length is checked against the bytes left before anything is allocated for it.
                if need as u64 > left {
                    return Ok(false);
                }
                let piece = usize::try_from(left).unwrap_or(BYTES_PER_PIECE).min(BYTES_PER_PIECE);
                let read = source.read(reader.insert(piece)).map_err(|e| format!("cannot be read: {e}"))?;
                reader.notify_read(read);
                left -= read as u64;
                if read == 0 {
                    return Ok(false);
                }
            }
            Ok(LinearReadEvent::Record { opcode: op::DATA_END, .. }) => return Ok(true),
            Ok(LinearReadEvent::Record { opcode, data }) => each(opcode, data)?,
            Err(McapError::RecordTooLarge { len, .. }) if len > length => return Ok(false),
            Err(McapError::RecordTooLarge { len, .. }) => {
                return Err(format!("a record unfolds to {len} bytes, and of a file of this size {longest} are read"));
            }
            Err(e) => return Err(format!("{e}: the record is damaged")),
        }
    }
    Ok(true)
}

/// Refuses a record whose strings claim to be longer than it is: the crate reserves what a string claims before it
/// reads, and an allocation that fails cannot be caught.
fn strings_fit(opcode: u8, content: &[u8]) -> Result<(), String> {
    // Bytes before the strings, how many strings there are, and whether a map of strings follows.
    let (mut at, strings, has_map) = match opcode {
        op::SCHEMA => (2, 2, false),
        op::CHANNEL => (4, 2, true),
        op::CHUNK => (28, 1, false),
        _ => return Ok(()),
    };
    let damaged = |claimed: usize| {
        let length = content.len();
        format!("a string claims {claimed} bytes in a record of {length}: the record is damaged")
    };
    let length = |at: usize| {
        let four = content.get(at..at.saturating_add(4)).and_then(|four| <[u8; 4]>::try_from(four).ok());
        four.map(|four| u32::from_le_bytes(four) as usize)
    };
    let skip = |at: &mut usize, end: usize| match length(*at) {
        Some(claimed) if claimed > end.saturating_sub(*at + 4) => Err(damaged(claimed)),
        Some(claimed) => {
            *at += 4 + claimed;
            Ok(())
        }
        // Cut short: the crate says so.
        None => {
            *at = end;
            Ok(())
        }
    };
    for _ in 0..strings {
        skip(&mut at, content.len())?;
    }
    if let Some(claimed) = length(at).filter(|_| has_map) {
        at += 4;
        let end = at.checked_add(claimed).filter(|&end| end <= content.len()).ok_or_else(|| damaged(claimed))?;
        while at < end {
            skip(&mut at, end)?;
        }
    }
    Ok(())
}

struct Reader<'a, 'b> {
    /// Name and definition of each type.
    schemas: BTreeMap<u16, (String, Option<(String, String)>)>,
    channels: BTreeMap<u16, Channel>,
    work: &'a mut Budget,
    each: &'a mut Receiver<'b>,
}

impl Reader<'_, '_> {
    fn record(&mut self, opcode: u8, content: &[u8]) -> Result<(), String> {
        if !matches!(opcode, op::SCHEMA | op::CHANNEL | op::MESSAGE | op::CHUNK) {
            return Ok(());
        }
        strings_fit(opcode, content)?;
        match mcap::parse_record(opcode, content).map_err(|e| format!("{e}: the record is damaged"))? {
            Record::Schema { header, data } => {
                let definition = std::str::from_utf8(&data).ok().map(|text| (header.encoding, text.to_string()));
                self.schemas.insert(header.id, (header.name, definition));
            }
            Record::Channel(channel) => {
                let (schema, definition) = self.schemas.get(&channel.schema_id).cloned().unwrap_or_default();
                let (topic, encoding) = (channel.topic, channel.message_encoding);
                self.channels.insert(channel.id, Channel { topic, schema, encoding, definition });
            }
            Record::Message { header, data } => {
                let id = header.channel_id;
                let channel = self.channels.get(&id).ok_or(format!("a message of undeclared channel {id}"))?;
                (self.each)(&Message { channel, log_time: header.log_time.cast_signed(), data: &data })
                    .map_err(|e| format!("message of {}: {e}", channel.topic))?;
            }
            Record::Chunk { header, data } => self.chunk(&header, &data)?,
            _ => {}
        }
        Ok(())
    }

    fn chunk(&mut self, header: &ChunkHeader, packed: &[u8]) -> Result<(), String> {
        let compression = match header.compression.as_str() {
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
        let size = usize::try_from(header.uncompressed_size).unwrap_or(usize::MAX);
        self.work.draw(size).map_err(damaged)?;
        let unpacked = compression.reader(packed).map_err(damaged)?;
        let mut unpacked = Summed { source: unpacked, sum: flate2::Crc::new() };
        let options = LinearReaderOptions::default().with_emit_chunks(true).with_skip_end_magic(true);
        let mut taken = 0;
        // A record grows in a buffer that is copied as it doubles.
        let longest = self.work.whole() / RECORD_BUDGET_SHARE;
        let mut take = |opcode: u8, content: &[u8]| {
            taken += 9 + content.len();
            match opcode {
                // No record has this number: what is unpacked is filled with zeros.
                0 => Err("the chunk is damaged: it holds records of the opcode 0".into()),
                op::CHUNK => Ok(()),
                _ => self.record(opcode, content),
            }
        };
        let read = records(&mut unpacked, size as u64, options.with_skip_start_magic(true), longest, &mut take);
        // Where the bytes are damaged, that is the reason and not what their records seem to be.
        let rest = std::io::copy(&mut unpacked.by_ref().take(1 + size as u64), &mut std::io::sink());
        let (found, claimed) = (&unpacked.sum, header.uncompressed_crc);
        rest.map_err(|e| damaged(format!("it cannot be unpacked: {e}")))?;
        if u64::from(found.amount()) != (size as u64) % (1 << 32) {
            return Err(damaged(format!("it does not unpack to the {size} bytes it claims")));
        }
        // A checksum of zero says that the writer made none.
        if claimed != 0 && claimed != found.sum() {
            return Err(damaged(format!("its checksum is {:08x} instead of {claimed:08x}", found.sum())));
        }
        read?;
        if taken == size { Ok(()) } else { Err(damaged("it ends within a record".into())) }
    }
}

/// A source of which a checksum is made.
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

    /// Schema 1 `T`, channel 2 `/a` of it, one message `x` at 5 ns, one record of another kind, the end.
    fn file() -> Vec<u8> {
        let record =
            |opcode: u8, content: &[u8]| [&[opcode, content.len() as u8, 0, 0, 0, 0, 0, 0, 0], content].concat();
        let message = [&[2, 0, 0, 0, 0, 0][..], &5u64.to_le_bytes(), &6u64.to_le_bytes(), b"x"].concat();
        let channel = [&[2, 0, 1, 0, 2, 0, 0, 0][..], b"/a", &[3, 0, 0, 0], b"cdr", &[0; 4]].concat();
        [
            mcap::MAGIC.to_vec(),
            record(op::SCHEMA, &[1, 0, 1, 0, 0, 0, b'T', 0, 0, 0, 0, 0, 0, 0, 0]),
            record(op::CHANNEL, &channel),
            record(9, b"an attachment"),
            record(op::MESSAGE, &message),
            record(op::DATA_END, &[0; 4]),
        ]
        .concat()
    }

    type Found = Vec<(Channel, i64, Vec<u8>)>;

    fn messages(bytes: &[u8]) -> (Found, Result<Outcome, String>) {
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

    /// A file cut anywhere before its end reports up to where it is whole, which is where a record ends.
    #[test]
    fn the_place_of_a_cut() {
        let whole = file();
        let ends: Vec<u64> = [8, 32, 62, 84, 116].to_vec();
        for cut in 8..whole.len() - 4 {
            let (found, outcome) = messages(&whole[..cut]);
            let told = outcome.unwrap().cut;
            let expected = *ends.iter().rfind(|&&end| end <= cut as u64).unwrap();
            // The head of the last record marks the end of the data, so its content is not needed.
            let expected = format!("is cut short: whole up to byte {expected} of {cut}; what is behind is not read");
            assert_eq!(told, (cut < 125).then_some(expected), "{cut}");
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
