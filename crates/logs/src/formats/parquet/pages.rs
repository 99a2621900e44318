//! Decompresses the pages of a column chunk within bounds, for the column readers of the crate `parquet`.
//!
//! The library gets a description of the chunk that says "not compressed", so it passes the pages on as they are, and they are
//! decompressed here. So all decoders are written in Rust, and no length in a page is trusted. The library itself would
//! allocate up to 4 GiB for the size that an lz4 or snappy page states, and a dictionary of the stated number of entries. The
//! library panics on some truncated pages: such pages are refused here, or converted to an encoding that the library checks.

use std::sync::Arc;

use bytes::Bytes;
use parquet::basic::Compression as Codec;
use parquet::basic::{Encoding, Type};
use parquet::column::page::{Page, PageMetadata, PageReader};
use parquet::errors::{ParquetError, Result};
use parquet::file::metadata::ColumnChunkMetaData;
use parquet::file::reader::Length;
use parquet::file::serialized_reader::SerializedPageReader;

use crate::formats::compression::{Compression, MAX_UNPACKED_BYTES};
use crate::formats::parquet::file_bytes::FileBytes;
use crate::formats::parquet::split_values::{joined, values_begin};

/// The decompressed pages of a chunk.
pub(crate) struct UnpackedPages {
    packed: SerializedPageReader<FileBytes>,
    codec: Compression,
    /// Largest size of a decompressed page, bytes.
    most: usize,
    /// Number of values of the chunk that are not read yet.
    left: u64,
    /// Smallest number of bytes of a value.
    width: usize,
    /// Whether every value has exactly `width` bytes.
    one_width: bool,
    /// Largest repetition level and largest definition level.
    levels: [i16; 2],
    /// Whether the chunk had a dictionary page.
    dictionary: bool,
}

impl UnpackedPages {
    /// Opens the pages of a chunk. `most`: largest size of a decompressed page, bytes.
    ///
    /// Fails if the chunk is outside the file, or if its compression cannot be read.
    pub(crate) fn of(
        file: &FileBytes,
        chunk: &ColumnChunkMetaData,
        rows: usize,
        most: usize,
    ) -> std::result::Result<UnpackedPages, String> {
        // If the chunk has a dictionary, the dictionary is at its start.
        let start = chunk.dictionary_page_offset().unwrap_or(chunk.data_page_offset());
        let end = start.checked_add(chunk.compressed_size()).filter(|&end| start >= 0 && end >= start);
        if end.is_none_or(|end| end.cast_unsigned() > file.len()) {
            return Err(format!("its data reach beyond the {} bytes of the file", file.len()));
        }
        let codec = match chunk.compression() {
            Codec::UNCOMPRESSED => Compression::None,
            Codec::SNAPPY => Compression::Snappy,
            Codec::GZIP(_) => Compression::Gzip,
            Codec::BROTLI(_) => Compression::Brotli,
            Codec::LZ4 => Compression::Lz4Hadoop,
            Codec::ZSTD(_) => Compression::Zstd,
            Codec::LZ4_RAW => Compression::Lz4Block,
            other => {
                return Err(format!(
                    "it is compressed with {other}; write it with snappy, zstd, gzip, brotli, lz4 or uncompressed"
                ));
            }
        };
        // The library must not decompress pages, because this type decompresses them.
        let plain = chunk.clone().into_builder().set_compression(Codec::UNCOMPRESSED).build();
        let packed = plain.and_then(|plain| SerializedPageReader::new(Arc::new(file.clone()), &plain, rows, None));
        // A BOOLEAN needs one bit. A BYTE_ARRAY needs at least four bytes for its length.
        let width = match chunk.column_type() {
            Type::BOOLEAN => 0,
            Type::INT32 | Type::FLOAT | Type::BYTE_ARRAY => 4,
            Type::INT64 | Type::DOUBLE => 8,
            Type::INT96 => 12,
            Type::FIXED_LEN_BYTE_ARRAY => usize::try_from(chunk.column_descr().type_length()).unwrap_or(0),
        };
        let left = chunk.num_values().try_into().unwrap_or(0);
        let one_width = !matches!(chunk.column_type(), Type::BOOLEAN | Type::BYTE_ARRAY);
        let levels = [chunk.column_descr().max_rep_level(), chunk.column_descr().max_def_level()];
        let packed = packed.map_err(|e| e.to_string())?;
        Ok(UnpackedPages { packed, codec, most, left, width, one_width, levels, dictionary: false })
    }

    fn unpack(&self, packed: &[u8]) -> Result<Bytes> {
        self.codec
            .unpack_within(packed, self.most.min(MAX_UNPACKED_BYTES))
            .map(Bytes::from)
            .map_err(ParquetError::General)
    }

    /// Counts the values of a data page. Fails if the page states more values than the chunk has left.
    fn count(&mut self, claimed: u32) -> Result<()> {
        let left = self.left;
        self.left = left.checked_sub(u64::from(claimed)).ok_or_else(|| {
            ParquetError::General(format!("a page claims {claimed} values where its column has {left} left"))
        })?;
        Ok(())
    }

    fn unpacked(&mut self, page: Page) -> Result<Page> {
        let general = |message: String| Err(ParquetError::General(message));
        if page.is_data_page() {
            self.count(page.num_values())?;
        }
        match page {
            // The library allocates the number of entries that a dictionary states, so a number that is too large is refused.
            Page::DictionaryPage { buf, num_values, encoding, is_sorted } => {
                let buf = self.unpack(&buf)?;
                if (num_values as usize).saturating_mul(self.width.max(1)) > buf.len() {
                    return general(format!("a dictionary claims {num_values} values in {} bytes", buf.len()));
                }
                self.dictionary = true;
                Ok(Page::DictionaryPage { buf, num_values, encoding, is_sorted })
            }
            // In pages of version 1, the levels are compressed together with the values.
            Page::DataPage { buf, num_values, encoding, def_level_encoding, rep_level_encoding, statistics } => {
                let buf = self.unpack(&buf)?;
                self.check_encoding(encoding)?;
                let written = [rep_level_encoding, def_level_encoding];
                let levels = [0, 1].map(|k| (self.levels[k], written[k]));
                let Some(values) = values_begin(&buf, num_values, levels) else {
                    return general("a page ends within its levels".into());
                };
                let (buf, encoding) = self.in_plain(buf, values, encoding)?;
                Ok(Page::DataPage { buf, num_values, encoding, def_level_encoding, rep_level_encoding, statistics })
            }
            Page::DataPageV2 {
                buf,
                num_values,
                encoding,
                num_nulls,
                num_rows,
                def_levels_byte_len,
                rep_levels_byte_len,
                is_compressed,
                statistics,
            } => {
                // In pages of version 2, the levels are not compressed.
                self.check_encoding(encoding)?;
                let levels = (def_levels_byte_len as usize).saturating_add(rep_levels_byte_len as usize);
                let Some((head, values)) = buf.split_at_checked(levels) else {
                    return general("a page ends within its levels".into());
                };
                let buf = match is_compressed && !values.is_empty() {
                    true => Bytes::from([head, &self.unpack(values)?].concat()),
                    false => buf,
                };
                let (buf, encoding) = self.in_plain(buf, levels, encoding)?;
                Ok(Page::DataPageV2 {
                    buf,
                    num_values,
                    encoding,
                    num_nulls,
                    num_rows,
                    def_levels_byte_len,
                    rep_levels_byte_len,
                    is_compressed: false,
                    statistics,
                })
            }
        }
    }
}

impl UnpackedPages {
    /// Converts a page from BYTE_STREAM_SPLIT to PLAIN; other pages are unchanged. `values`: position of the first value.
    fn in_plain(&self, page: Bytes, values: usize, encoding: Encoding) -> Result<(Bytes, Encoding)> {
        if encoding != Encoding::BYTE_STREAM_SPLIT || !self.one_width {
            return Ok((page, encoding));
        }
        let (head, split) = page.split_at(values.min(page.len()));
        let Some(plain) = joined(split, self.width) else {
            let (bytes, width) = (split.len(), self.width);
            return Err(ParquetError::General(format!("its {bytes} bytes are not whole values of {width}")));
        };
        Ok((Bytes::from([head, &plain].concat()), Encoding::PLAIN))
    }

    /// Refuses two kinds of encodings. Text encodings: the library would allocate the size that the file states, and logs do
    /// not need these encodings. Indices without a dictionary: the library would panic.
    fn check_encoding(&self, encoding: Encoding) -> Result<()> {
        let message = match encoding {
            Encoding::DELTA_LENGTH_BYTE_ARRAY | Encoding::DELTA_BYTE_ARRAY => {
                format!("its encoding, {encoding}, is one of texts, which is not read")
            }
            Encoding::PLAIN_DICTIONARY | Encoding::RLE_DICTIONARY if !self.dictionary => {
                "its values are places in a dictionary, which is missing".into()
            }
            _ => return Ok(()),
        };
        Err(ParquetError::General(message))
    }
}

impl Iterator for UnpackedPages {
    type Item = Result<Page>;

    fn next(&mut self) -> Option<Result<Page>> {
        self.get_next_page().transpose()
    }
}

impl PageReader for UnpackedPages {
    fn get_next_page(&mut self) -> Result<Option<Page>> {
        let page = self.packed.get_next_page()?;
        page.map(|page| self.unpacked(page)).transpose()
    }

    fn peek_next_page(&mut self) -> Result<Option<PageMetadata>> {
        self.packed.peek_next_page()
    }

    fn skip_next_page(&mut self) -> Result<()> {
        self.packed.skip_next_page()
    }
}
