//! Compressed blocks of MCAP and Parquet: the bytes a block stands for, given how many they are.
//!
//! The length comes from the file and is not believed: nothing is allocated by it beyond what the
//! compressed bytes can unfold to. Decoders only, all of Rust.

use std::io::Read;

/// How a block is compressed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Compression {
    None,
    Gzip,
    /// The raw format, without frames.
    Snappy,
    Zstd,
    Lz4Frame,
    Lz4Block,
}

/// One block unfolds to no more than this; writers make blocks of some megabytes.
const MAX_BYTES: usize = 1 << 30;

/// The largest ratios of the formats: a copy of 64 bytes takes 3, a run of 255 takes 1.
const SNAPPY_RATIO: usize = 64;
const LZ4_RATIO: usize = 256;

impl Compression {
    /// The `size` bytes that `packed` holds; another number of them is an error.
    pub fn unpack(self, packed: &[u8], size: usize) -> Result<Vec<u8>, String> {
        if size > MAX_BYTES {
            return Err(format!("a block claims to hold {size} bytes; at most {MAX_BYTES} are read"));
        }
        let limited = |ratio: usize| match packed.len().saturating_mul(ratio) < size {
            true => Err(format!("{} bytes cannot unfold to the {size} they claim", packed.len())),
            false => Ok(()),
        };
        let failed = |e: &dyn std::fmt::Display| format!("it cannot be unpacked: {e}");
        let out = match self {
            Compression::None => packed.to_vec(),
            Compression::Gzip => bounded(flate2::read::MultiGzDecoder::new(packed), size)?,
            Compression::Lz4Frame => bounded(lz4_flex::frame::FrameDecoder::new(packed), size)?,
            Compression::Zstd => {
                let decoder = ruzstd::decoding::StreamingDecoder::new(packed).map_err(|e| failed(&e))?;
                bounded(decoder, size)?
            }
            Compression::Lz4Block => {
                limited(LZ4_RATIO)?;
                lz4_flex::block::decompress(packed, size).map_err(|e| failed(&e))?
            }
            Compression::Snappy => {
                let claimed = snap::raw::decompress_len(packed).map_err(|e| failed(&e))?;
                if claimed != size {
                    return Err(format!("it claims {claimed} bytes inside and {size} outside"));
                }
                limited(SNAPPY_RATIO)?;
                snap::raw::Decoder::new().decompress_vec(packed).map_err(|e| failed(&e))?
            }
        };
        if out.len() != size {
            return Err(format!("it does not unpack to the {size} bytes it claims"));
        }
        Ok(out)
    }
}

/// At most one byte more than `size`: enough to see that there are too many.
fn bounded(reader: impl Read, size: usize) -> Result<Vec<u8>, String> {
    let mut out = Vec::new();
    let read = reader.take(size as u64 + 1).read_to_end(&mut out);
    read.map_err(|e| format!("it cannot be unpacked: {e}"))?;
    Ok(out)
}

#[cfg(test)]
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
        ]
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
