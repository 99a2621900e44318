//! Unpacks compressed blocks of recordings, of Arrow and of Parquet, within a bound.
//!
//! A length that the file claims is not trusted: no more is allocated for it than the compressed bytes can unfold to.
//! Only decoders are used, all written in Rust.

use std::io::Read;

/// How a block is compressed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Compression {
    /// Not at all.
    None,
    /// As a zstd stream.
    Zstd,
    /// As an LZ4 frame.
    Lz4Frame,
    /// As gzip members.
    #[cfg(feature = "parquet")]
    Gzip,
    /// The raw format, without frames.
    #[cfg(feature = "parquet")]
    Snappy,
    /// As a Brotli stream.
    #[cfg(feature = "parquet")]
    Brotli,
    /// As one LZ4 block.
    #[cfg(feature = "parquet")]
    Lz4Block,
    /// What Parquet calls LZ4: raw blocks behind two lengths, frames in the oldest files.
    #[cfg(feature = "parquet")]
    Lz4Hadoop,
}

/// Largest size of an unpacked block. Writers make blocks of some megabytes.
pub(crate) const MAX_UNPACKED_BYTES: usize = 1 << 30;

/// Nor may a block unfold to more than this many times its bytes, plus `UNPACKING_ALLOWANCE_BYTES`. Measured numbers do
/// not compress so far.
const MAX_UNPACKING_RATIO: usize = 64;
/// Bytes that every block may unfold to beside that.
const UNPACKING_ALLOWANCE_BYTES: usize = 1 << 26;

/// The largest ratio of snappy: a copy of 64 bytes takes 3.
#[cfg(feature = "parquet")]
const MAX_SNAPPY_RATIO: usize = 64;
/// The largest ratio of LZ4: a run of 255 takes 1.
#[cfg(feature = "parquet")]
const MAX_LZ4_RATIO: usize = 256;

impl Compression {
    /// What `packed` holds, unpacked while it is read.
    pub fn reader<'a>(self, packed: &'a [u8]) -> Result<Box<dyn Read + 'a>, String> {
        Ok(match self {
            Compression::None => Box::new(packed),
            Compression::Zstd => {
                let decoder = ruzstd::decoding::StreamingDecoder::new(packed);
                Box::new(decoder.map_err(|e| format!("it cannot be unpacked: {e}"))?)
            }
            Compression::Lz4Frame => Box::new(lz4_flex::frame::FrameDecoder::new(packed)),
            #[cfg(feature = "parquet")]
            other => Box::new(std::io::Cursor::new(other.unpack_within(packed, MAX_UNPACKED_BYTES)?)),
        })
    }

    /// The `size` bytes that `packed` holds; another number of them is an error.
    pub fn unpack(self, packed: &[u8], size: usize) -> Result<Vec<u8>, String> {
        let out = self.unpack_within(packed, size)?;
        if out.len() != size {
            return Err(format!("it does not unpack to the {size} bytes it claims"));
        }
        Ok(out)
    }

    /// The bytes that `packed` holds; more than `most` of them are an error.
    pub fn unpack_within(self, packed: &[u8], most: usize) -> Result<Vec<u8>, String> {
        let most = most.min(most_of(packed));
        let failed = |e: &dyn std::fmt::Display| format!("it cannot be unpacked: {e}");
        let out = match self {
            Compression::None => packed.to_vec(),
            Compression::Zstd => {
                let decoder = ruzstd::decoding::StreamingDecoder::new(packed).map_err(|e| failed(&e))?;
                bounded(decoder, most)?
            }
            Compression::Lz4Frame => bounded(lz4_flex::frame::FrameDecoder::new(packed), most)?,
            #[cfg(feature = "parquet")]
            Compression::Gzip => bounded(flate2::read::MultiGzDecoder::new(packed), most)?,
            #[cfg(feature = "parquet")]
            Compression::Brotli => bounded(brotli_decompressor::Decompressor::new(packed, 4096), most)?,
            // The decoders of blocks take all memory at once, so the ratio of their format bounds it first.
            #[cfg(feature = "parquet")]
            Compression::Snappy => {
                let claimed = snap::raw::decompress_len(packed).map_err(|e| failed(&e))?;
                if claimed > most.min(packed.len().saturating_mul(MAX_SNAPPY_RATIO)) {
                    return Err(format!("{} bytes cannot unfold to the {claimed} they claim", packed.len()));
                }
                snap::raw::Decoder::new().decompress_vec(packed).map_err(|e| failed(&e))?
            }
            #[cfg(feature = "parquet")]
            Compression::Lz4Block => {
                let room = most.min(packed.len().saturating_mul(MAX_LZ4_RATIO));
                lz4_flex::block::decompress(packed, room).map_err(|e| failed(&e))?
            }
            #[cfg(feature = "parquet")]
            Compression::Lz4Hadoop if packed.starts_with(b"\x04\x22\x4d\x18") => {
                return Compression::Lz4Frame.unpack_within(packed, most);
            }
            #[cfg(feature = "parquet")]
            Compression::Lz4Hadoop => hadoop(packed, most)?,
        };
        if out.len() > most {
            return Err(format!("it unpacks to more than {most} bytes"));
        }
        Ok(out)
    }
}

/// The most that these bytes may unfold to.
fn most_of(packed: &[u8]) -> usize {
    packed.len().saturating_mul(MAX_UNPACKING_RATIO).saturating_add(UNPACKING_ALLOWANCE_BYTES)
}

/// Blocks behind two lengths of four bytes each, the highest first: unpacked and packed.
#[cfg(feature = "parquet")]
fn hadoop(mut packed: &[u8], most: usize) -> Result<Vec<u8>, String> {
    let mut out = Vec::new();
    while let Some((head, rest)) = packed.split_first_chunk::<8>() {
        let [size, length] = [0, 4].map(|at| u32::from_be_bytes([head[at], head[at + 1], head[at + 2], head[at + 3]]));
        let (block, rest) =
            rest.split_at_checked(length as usize).ok_or("it cannot be unpacked: a block is cut short")?;
        packed = rest;
        out.extend(Compression::Lz4Block.unpack_within(block, most.saturating_sub(out.len()).min(size as usize))?);
    }
    Ok(out)
}

/// At most one byte more than `most`: enough to see that there are too many.
fn bounded(reader: impl Read, most: usize) -> Result<Vec<u8>, String> {
    let mut out = Vec::new();
    let read = reader.take(most as u64 + 1).read_to_end(&mut out);
    read.map_err(|e| format!("it cannot be unpacked: {e}"))?;
    Ok(out)
}

#[cfg(all(test, feature = "parquet"))]
mod tests {
    use super::*;
    use std::io::Write;

    /// Every format with the block that its own encoder makes of the bytes.
    fn packed(bytes: &[u8]) -> Vec<(Compression, Vec<u8>)> {
        let mut gzip = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        gzip.write_all(bytes).unwrap();
        let mut lz4 = lz4_flex::frame::FrameEncoder::new(Vec::new());
        lz4.write_all(bytes).unwrap();
        let zstd = ruzstd::encoding::compress_to_vec(bytes, ruzstd::encoding::CompressionLevel::Fastest);
        vec![
            (Compression::None, bytes.to_vec()),
            (Compression::Gzip, gzip.finish().unwrap()),
            (Compression::Snappy, snap::raw::Encoder::new().compress_vec(bytes).unwrap()),
            (Compression::Zstd, zstd),
            (Compression::Lz4Frame, lz4.finish().unwrap()),
            (Compression::Lz4Block, lz4_flex::block::compress(bytes)),
            (Compression::Lz4Hadoop, hadoop_of(bytes)),
        ]
    }

    /// Two blocks, as Hadoop writes them.
    fn hadoop_of(bytes: &[u8]) -> Vec<u8> {
        let half = bytes.len() / 2;
        let block = |bytes: &[u8]| {
            let packed = lz4_flex::block::compress(bytes);
            [&(bytes.len() as u32).to_be_bytes()[..], &(packed.len() as u32).to_be_bytes(), &packed].concat()
        };
        [block(&bytes[..half]), block(&bytes[half..])].concat()
    }

    fn signal() -> Vec<u8> {
        (0..4000).flat_map(|i| (0.01 * f64::from(i / 7)).sin().to_le_bytes()).collect()
    }

    #[test]
    fn what_was_packed_comes_back() {
        let bytes = signal();
        for (format, block) in packed(&bytes) {
            assert!(format == Compression::None || block.len() < bytes.len(), "{format:?}");
            assert_eq!(format.unpack(&block, bytes.len()).unwrap(), bytes, "{format:?}");
        }
    }

    #[test]
    fn a_wrong_length_is_refused() {
        let bytes = signal();
        for (format, block) in packed(&bytes) {
            for size in [0, bytes.len() - 1, bytes.len() + 1, 1 << 29, usize::MAX] {
                assert!(format.unpack(&block, size).is_err(), "{format:?} {size}");
            }
        }
    }

    /// Cut off or changed, a block is read or refused, never a panic.
    #[test]
    fn damage_does_not_panic() {
        let bytes = signal();
        for (format, block) in packed(&bytes) {
            let mut refused = 0;
            for k in 0..2000 {
                let mut block = block.clone();
                let at = (k * 7919) % block.len();
                match k % 3 {
                    0 => block.truncate(at),
                    _ => block[at] ^= (1 + k * 31 % 255) as u8,
                }
                refused += usize::from(format.unpack(&block, bytes.len()).is_err());
            }
            assert!(refused > 600, "{format:?}: {refused}");
        }
    }
}
