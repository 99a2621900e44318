//! Decompresses blocks of recordings, of Arrow files and of Parquet files, with a bound for the size.
//!
//! The size that a file states is not trusted: the memory is bounded by the compressed size. All decoders are written in Rust.

use std::io::Read;

/// The compression format of a block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Compression {
    /// No compression.
    None,
    /// A zstd stream.
    Zstd,
    /// An LZ4 frame.
    Lz4Frame,
    /// Gzip members.
    #[cfg(feature = "parquet")]
    Gzip,
    /// The raw format of Snappy, without frames.
    #[cfg(feature = "parquet")]
    Snappy,
    /// A Brotli stream.
    #[cfg(feature = "parquet")]
    Brotli,
    /// One LZ4 block.
    #[cfg(feature = "parquet")]
    Lz4Block,
    /// The LZ4 format of Parquet: raw blocks, each after two lengths; the oldest files contain LZ4 frames.
    #[cfg(feature = "parquet")]
    Lz4Hadoop,
}

/// Largest size of a decompressed block, bytes. Usual blocks have some megabytes.
pub(crate) const MAX_UNPACKED_BYTES: usize = 1 << 30;

/// Largest accepted ratio of decompressed to compressed size. `UNPACKING_ALLOWANCE_BYTES` is added to the resulting bound.
/// Measured signals have smaller ratios.
const MAX_UNPACKING_RATIO: usize = 64;
/// Number of bytes that is added to the bound of every block.
const UNPACKING_ALLOWANCE_BYTES: usize = 1 << 26;

/// Largest possible ratio of Snappy: 3 bytes can copy 64 bytes.
#[cfg(feature = "parquet")]
const MAX_SNAPPY_RATIO: usize = 64;
/// Largest possible ratio of LZ4: one byte can describe a run of 255 bytes.
#[cfg(feature = "parquet")]
const MAX_LZ4_RATIO: usize = 256;
/// Size of the input buffer of the Brotli decoder, bytes.
#[cfg(feature = "parquet")]
const BROTLI_BUFFER_BYTES: usize = 4096;

impl Compression {
    /// A reader that decompresses `packed`.
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

    /// Decompresses `packed`. Fails if the result has not exactly `size` bytes.
    pub fn unpack(self, packed: &[u8], size: usize) -> Result<Vec<u8>, String> {
        let out = self.unpack_within(packed, size)?;
        if out.len() != size {
            return Err(format!("it does not unpack to the {size} bytes it claims"));
        }
        Ok(out)
    }

    /// Decompresses `packed`. Fails if the result has more than `most` bytes.
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
            Compression::Brotli => bounded(brotli_decompressor::Decompressor::new(packed, BROTLI_BUFFER_BYTES), most)?,
            // These decoders allocate the whole output at once, so the size is first bounded by the largest ratio of the format.
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

/// Largest accepted size of the decompressed bytes, from the compressed size.
fn most_of(packed: &[u8]) -> usize {
    packed.len().saturating_mul(MAX_UNPACKING_RATIO).saturating_add(UNPACKING_ALLOWANCE_BYTES)
}

/// Decompresses blocks after two big-endian lengths of four bytes each: decompressed length, then compressed length.
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

/// Reads at most one byte more than `most`, which is enough to detect that the data is too long.
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

    /// For every format, a block that was compressed by the encoder of this format.
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

    /// Two LZ4 blocks in the format of Parquet (Hadoop), each after its two lengths.
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

    /// A truncated or changed block is read or refused, but the decoder never panics.
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
