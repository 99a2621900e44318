//! Provides the bytes of a Parquet file: from memory, or from a file on disk.
//!
//! A file on disk is read in pieces, so that the memory does not depend on its size.

use std::io::{self, Read};
use std::sync::Arc;

use bytes::Bytes;
use gate::source::RandomAccessFile;
use parquet::errors::{ParquetError, Result};
use parquet::file::reader::{ChunkReader, Length};

/// Number of bytes that are read at once for the head of a page. A head is usually shorter.
const PAGE_HEAD_BYTES: usize = 256;

/// The source of the bytes of a file.
#[derive(Clone)]
pub(crate) enum FileBytes {
    /// The whole file in memory.
    Held(Bytes),
    /// A file on disk.
    Pieces(Arc<RandomAccessFile>),
}

impl FileBytes {
    /// At most `count` bytes, starting at `place`. There are fewer bytes at the end of the file.
    pub(crate) fn piece(&self, place: u64, count: usize) -> io::Result<Bytes> {
        match self {
            FileBytes::Held(bytes) => {
                let start = usize::try_from(place).unwrap_or(usize::MAX).min(bytes.len());
                Ok(bytes.slice(start..start.saturating_add(count).min(bytes.len())))
            }
            FileBytes::Pieces(pieces) => pieces.read(place, count).map(Bytes::from),
        }
    }

    /// Fails if the file changed while it was read, so that its bytes may belong to two versions.
    pub(crate) fn unchanged(&self) -> io::Result<()> {
        match self {
            FileBytes::Held(_) => Ok(()),
            FileBytes::Pieces(pieces) => pieces.unchanged(),
        }
    }
}

impl Length for FileBytes {
    fn len(&self) -> u64 {
        match self {
            FileBytes::Held(bytes) => bytes.len() as u64,
            FileBytes::Pieces(pieces) => pieces.length(),
        }
    }
}

impl ChunkReader for FileBytes {
    type T = BytesFrom;

    fn get_read(&self, start: u64) -> Result<BytesFrom> {
        Ok(BytesFrom { bytes: self.clone(), place: start, piece: Bytes::new() })
    }

    fn get_bytes(&self, start: u64, length: usize) -> Result<Bytes> {
        let piece = self.piece(start, length)?;
        if piece.len() < length {
            let message = format!("{length} bytes are claimed at {start} of a file of {}", self.len());
            return Err(ParquetError::General(message));
        }
        Ok(piece)
    }
}

/// Reads the bytes that start at a position.
pub(crate) struct BytesFrom {
    bytes: FileBytes,
    place: u64,
    piece: Bytes,
}

impl Read for BytesFrom {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        if self.piece.is_empty() {
            self.piece = self.bytes.piece(self.place, PAGE_HEAD_BYTES)?;
            self.place += self.piece.len() as u64;
        }
        let count = out.len().min(self.piece.len());
        out[..count].copy_from_slice(&self.piece.split_to(count));
        Ok(count)
    }
}
