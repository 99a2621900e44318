//! Decompresses streams. The number of decompressed bytes is limited by the [`Budget`] of the compressed bytes read so far.
//!
//! The budget grows while the stream is read, because the length of a pipe is not known in advance.

use std::io::{self, Read};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::budget::Budget;

/// A counter of the compressed bytes that were read. All clones share one count.
#[derive(Clone, Debug, Default)]
pub struct PackedBytes(Arc<AtomicUsize>);

impl PackedBytes {
    /// The memory budget for the compressed bytes read so far.
    pub fn budget(&self) -> Budget {
        Budget::of(self.0.load(Ordering::Relaxed))
    }
}

/// A reader that counts the bytes that are read from `source`.
pub struct Counted<R> {
    source: R,
    count: PackedBytes,
}

impl<R: Read> Read for Counted<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let count = self.source.read(out)?;
        self.count.0.fetch_add(count, Ordering::Relaxed);
        Ok(count)
    }
}

/// A decompressed stream. Reading fails if the decompressed bytes exceed the memory budget of the compressed bytes read so far.
pub struct Unfolding<D> {
    decoder: D,
    packed: PackedBytes,
    unfolded: usize,
    copies: usize,
}

impl<D> Unfolding<D> {
    /// Makes the decompressed stream of the compressed stream `source`. `decoder`: makes the decoder. Fails if `decoder` fails.
    pub fn new<R: Read, E>(source: R, decoder: impl FnOnce(Counted<R>) -> Result<D, E>) -> Result<Unfolding<D>, E> {
        let packed = PackedBytes::default();
        let decoder = decoder(Counted { source, count: packed.clone() })?;
        Ok(Unfolding { decoder, packed, unfolded: 0, copies: 1 })
    }

    /// This stream with another factor: each decompressed byte counts as `copies` bytes of memory, because its reader stores that
    /// number of copies.
    pub fn held(self, copies: usize) -> Unfolding<D> {
        Unfolding { copies, ..self }
    }

    /// Puts `bytes` back at the front of the stream, so that they are read again.
    pub fn put_back(self, bytes: Vec<u8>) -> Unfolding<io::Chain<io::Cursor<Vec<u8>>, D>>
    where
        D: Read,
    {
        let unfolded = self.unfolded.saturating_sub(bytes.len());
        let decoder = io::Cursor::new(bytes).chain(self.decoder);
        Unfolding { decoder, packed: self.packed, unfolded, copies: self.copies }
    }

    /// The number of compressed bytes that were read, as a shared count.
    pub fn packed(&self) -> PackedBytes {
        self.packed.clone()
    }
}

impl<D: Read> Read for Unfolding<D> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let count = self.decoder.read(out)?;
        self.unfolded = self.unfolded.saturating_add(count);
        self.packed.budget().draw(self.unfolded.saturating_mul(self.copies)).map_err(io::Error::other)?;
        Ok(count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A decoder that returns a thousand zeros for each compressed byte.
    struct Thousandfold<R>(R);

    impl<R: Read> Read for Thousandfold<R> {
        fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
            let most = out.len().min(1000);
            let count = self.0.read(&mut [0])? * most;
            out[..count].fill(0);
            Ok(count)
        }
    }

    #[test]
    fn what_unfolds_without_end_is_refused() {
        let mut out = Vec::new();
        let of = |source: Counted<Box<dyn Read>>| Ok::<_, io::Error>(Thousandfold(source));
        let short = Unfolding::new(Box::new(&[0u8; 100][..]) as Box<dyn Read>, of).unwrap().read_to_end(&mut out);
        assert!(short.is_ok() && out.len() <= 100_000);
        let mut endless = Unfolding::new(Box::new(io::repeat(0)) as Box<dyn Read>, of).unwrap();
        let refused = io::copy(&mut endless, &mut io::sink()).unwrap_err();
        assert!(refused.to_string().contains("64 times the file"), "{refused}");
    }
}
