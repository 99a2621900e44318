//! Decompresses gzip and zstd streams while they are read.
//!
//! The number of decompressed bytes is limited by the number of compressed bytes that were read.

use std::io::{BufReader, Read};

use gate::unfolding::Unfolding;

use crate::Error;
use crate::formats::content::FileFormat;

/// A source whose content is decompressed while it is read.
pub(crate) type Unpacked<'a> = Unfolding<Box<dyn Read + Send + 'a>>;

/// A gzip or zstd stream, decompressed while it is read.
pub(crate) fn unpacked<'a>(
    file: &str,
    format: FileFormat,
    source: impl Read + Send + 'a,
) -> Result<Unpacked<'a>, Error> {
    let unpacked = Unfolding::new(source, |source| -> Result<Box<dyn Read + Send + 'a>, _> {
        let source = BufReader::new(source);
        Ok(match format {
            FileFormat::Zstd => Box::new(ruzstd::decoding::StreamingDecoder::new(source)?),
            _ => Box::new(flate2::read::MultiGzDecoder::new(source)),
        })
    });
    unpacked.map_err(|e: ruzstd::decoding::errors::FrameDecoderError| {
        Error::at(file, 0, format!("the compressed stream is damaged or cut short: {e}"))
    })
}
