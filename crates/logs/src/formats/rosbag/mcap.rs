//! The records of an MCAP file (mcap.dev, version 0), in file order.
//!
//! Magic, then records of opcode (u8), length (u64) and content, little-endian; a chunk holds records,
//! compressed or not. The index at the end is not used, so that the file of a recorder that was killed
//! is read as far as it is whole. Attachments and metadata are passed over.

use std::collections::BTreeMap;
use std::io::Read;

use crate::formats::compression::Compression;

pub const MAGIC: &[u8] = b"\x89MCAP0\r\n";

const SCHEMA: u8 = 3;
const CHANNEL: u8 = 4;
const MESSAGE: u8 = 5;
const CHUNK: u8 = 6;
const DATA_END: u8 = 15;

/// What a file says of one topic.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Channel {
    pub topic: String,
    /// The name of the message type: `sensor_msgs/msg/JointState`.
    pub schema: String,
    /// How messages are written: `cdr`, `ros1`.
    pub encoding: String,
}

pub struct Message<'a> {
    pub channel: &'a Channel,
    /// ns, when the recorder got the message.
    pub log_time: u64,
    pub data: &'a [u8],
}

/// What became of a file.
#[derive(Debug, Default)]
pub struct Outcome {
    pub channels: Vec<Channel>,
    /// Bytes before the first record that is not whole, for a file that ends before its data do.
    pub cut_at: Option<u64>,
}

/// Hands every message of a file of `length` bytes to `each`.
///
/// Fails when a record is damaged; a file that ends early is no failure but an `Outcome`.
pub fn read(
    source: impl Read,
    length: u64,
    each: &mut dyn FnMut(&Message) -> Result<(), String>,
) -> Result<Outcome, String> {
    let mut file = File { source, at: 0, length };
    let mut content = Vec::new();
    let mut reader = Reader { schemas: BTreeMap::new(), channels: BTreeMap::new(), each };
    let mut cut_at = None;
    if file.take(MAGIC.len() as u64, &mut content)? && content != MAGIC {
        return Err("the file does not begin as an MCAP file (version 0)".into());
    }
    loop {
        let start = file.at;
        let whole = file.take(9, &mut content)? && {
            let opcode = content[0];
            let length = Fields(&content[1..]).u64()?;
            if opcode == DATA_END {
                break;
            }
            let wanted = matches!(opcode, SCHEMA | CHANNEL | MESSAGE | CHUNK);
            let whole = if wanted { file.take(length, &mut content)? } else { file.skip(length)? };
            if whole && wanted {
                reader.record(opcode, &content).map_err(|e| format!("record at byte {start}: {e}"))?;
            }
            whole
        };
        if !whole {
            cut_at = Some(start);
            break;
        }
    }
    Ok(Outcome { channels: reader.channels.into_values().collect(), cut_at })
}

/// A file and how far it is read. Lengths are held against what is left, so none is believed.
struct File<R> {
    source: R,
    at: u64,
    length: u64,
}

impl<R: Read> File<R> {
    /// The next bytes; `false` when the file ends before.
    fn take(&mut self, count: u64, into: &mut Vec<u8>) -> Result<bool, String> {
        into.clear();
        if count > self.length - self.at {
            return Ok(false);
        }
        let read = (&mut self.source).take(count).read_to_end(into).map_err(|e| format!("cannot be read: {e}"))?;
        self.at += read as u64;
        Ok(read as u64 == count)
    }

    fn skip(&mut self, count: u64) -> Result<bool, String> {
        if count > self.length - self.at {
            return Ok(false);
        }
        let read = std::io::copy(&mut (&mut self.source).take(count), &mut std::io::sink());
        let read = read.map_err(|e| format!("cannot be read: {e}"))?;
        self.at += read;
        Ok(read == count)
    }
}

struct Reader<'a> {
    schemas: BTreeMap<u16, String>,
    channels: BTreeMap<u16, Channel>,
    each: &'a mut dyn FnMut(&Message) -> Result<(), String>,
}

impl Reader<'_> {
    fn record(&mut self, opcode: u8, content: &[u8]) -> Result<(), String> {
        let mut f = Fields(content);
        match opcode {
            SCHEMA => {
                let id = f.u16()?;
                self.schemas.insert(id, f.text()?);
            }
            CHANNEL => {
                let (id, schema) = (f.u16()?, f.u16()?);
                let (topic, encoding) = (f.text()?, f.text()?);
                let schema = self.schemas.get(&schema).cloned().unwrap_or_default();
                self.channels.insert(id, Channel { topic, schema, encoding });
            }
            MESSAGE => {
                let id = f.u16()?;
                let _sequence = f.u32()?;
                let log_time = f.u64()?;
                let _publish_time = f.u64()?;
                let channel = self.channels.get(&id).ok_or(format!("a message of channel {id}, which is not told"))?;
                (self.each)(&Message { channel, log_time, data: f.0 })
                    .map_err(|e| format!("message of {}: {e}", channel.topic))?;
            }
            CHUNK => self.chunk(f)?,
            _ => {}
        }
        Ok(())
    }

    fn chunk(&mut self, mut f: Fields) -> Result<(), String> {
        let (_start, _end) = (f.u64()?, f.u64()?);
        let size = usize::try_from(f.u64()?).unwrap_or(usize::MAX);
        let crc = f.u32()?;
        let compression = match f.text()?.as_str() {
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
        let packed = f.u64()?;
        let packed = f.bytes(usize::try_from(packed).unwrap_or(usize::MAX))?;
        let damaged = |e: String| format!("the chunk is damaged: {e}; `mcap recover` saves the others");
        let records = compression.unpack(packed, size).map_err(damaged)?;
        let mut found = flate2::Crc::new();
        found.update(&records);
        // Zero: the writer made none.
        if crc != 0 && crc != found.sum() {
            return Err(damaged(format!("its checksum is {:08x} instead of {crc:08x}", found.sum())));
        }
        let mut f = Fields(&records);
        while !f.0.is_empty() {
            let (opcode, length) = (f.u8()?, f.u64()?);
            let content = f.bytes(usize::try_from(length).unwrap_or(usize::MAX))?;
            if opcode != CHUNK {
                self.record(opcode, content)?;
            }
        }
        Ok(())
    }
}

/// Bytes taken from the front.
struct Fields<'a>(&'a [u8]);

impl<'a> Fields<'a> {
    fn bytes(&mut self, count: usize) -> Result<&'a [u8], String> {
        let (bytes, rest) = self.0.split_at_checked(count).ok_or_else(|| {
            format!("{count} bytes are claimed where {} are left: the record is damaged", self.0.len())
        })?;
        self.0 = rest;
        Ok(bytes)
    }

    fn number<const N: usize>(&mut self) -> Result<[u8; N], String> {
        self.bytes(N).map(|b| b.try_into().unwrap_or([0; N]))
    }

    fn u8(&mut self) -> Result<u8, String> {
        self.number().map(u8::from_le_bytes)
    }

    fn u16(&mut self) -> Result<u16, String> {
        self.number().map(u16::from_le_bytes)
    }

    fn u32(&mut self) -> Result<u32, String> {
        self.number().map(u32::from_le_bytes)
    }

    fn u64(&mut self) -> Result<u64, String> {
        self.number().map(u64::from_le_bytes)
    }

    fn text(&mut self) -> Result<String, String> {
        let length = self.u32()? as usize;
        self.bytes(length).map(|b| String::from_utf8_lossy(b).into_owned())
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
            MAGIC.to_vec(),
            record(SCHEMA, &[1, 0, 1, 0, 0, 0, b'T', 0, 0, 0, 0, 0, 0, 0, 0]),
            record(CHANNEL, &channel),
            record(9, b"an attachment"),
            record(MESSAGE, &message),
            record(DATA_END, &[0; 4]),
        ]
        .concat()
    }

    type Found = Vec<(Channel, u64, Vec<u8>)>;

    fn messages(bytes: &[u8]) -> (Found, Result<Outcome, String>) {
        let mut found = Vec::new();
        let outcome = read(bytes, bytes.len() as u64, &mut |m| {
            found.push((m.channel.clone(), m.log_time, m.data.to_vec()));
            Ok(())
        });
        (found, outcome)
    }

    #[test]
    fn a_message_with_its_channel() {
        let (found, outcome) = messages(&file());
        let channel = Channel { topic: "/a".into(), schema: "T".into(), encoding: "cdr".into() };
        assert_eq!(found, [(channel.clone(), 5, b"x".to_vec())]);
        let outcome = outcome.unwrap();
        assert_eq!((outcome.channels, outcome.cut_at), (vec![channel], None));
    }

    /// Cut anywhere before its end, a file says up to where it is whole, which is where a record ends.
    #[test]
    fn the_place_of_a_cut() {
        let whole = file();
        let ends: Vec<u64> = [8, 32, 62, 84, 116].to_vec();
        for cut in 8..whole.len() - 4 {
            let (found, outcome) = messages(&whole[..cut]);
            let at = outcome.unwrap().cut_at;
            let expected = *ends.iter().rfind(|&&end| end <= cut as u64).unwrap();
            // The head of the last record says that the data end; its content is not needed.
            assert_eq!(at, (cut < 125).then_some(expected), "{cut}");
            assert_eq!(found.len(), usize::from(cut >= 116), "{cut}");
        }
    }

    #[test]
    fn an_error_of_the_receiver_has_its_place() {
        let bytes = file();
        let refuse = &mut |_: &Message| Err("it is not liked".to_string());
        let message = read(&bytes[..], bytes.len() as u64, refuse).unwrap_err();
        assert_eq!(message, "record at byte 84: message of /a: it is not liked");
    }
}
