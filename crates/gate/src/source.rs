//! Reads the bytes of a file or of a pipe, up to a maximum.
//!
//! A regular file is read to the length that it had when it was opened. Bytes that a recorder appends later are not read. If
//! the file was overwritten during the read, the last read fails, because the bytes are a mixture of two versions. A file
//! counts as overwritten in three cases: it has become shorter; it has the same length and another modification time; or it has
//! become longer and its first or last `COMPARED_BYTES`, which are read again, differ. A file with an index at its end is read
//! in blocks; the same check is made after the last block. A pipe has no length, so a pipe is read to its end, up to the
//! maximum of its reader.

use std::fs::{File, Metadata};
use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::SystemTime;

use crate::opened;

/// If a file has become longer during the read, this number of bytes at each end is read again and compared.
const COMPARED_BYTES: usize = 1 << 12;

/// An opened file or pipe.
pub struct Source {
    from: From,
}

enum From {
    File(RegularFile),
    Pipe(Box<dyn Read + Send>),
}

struct RegularFile {
    file: File,
    length: u64,
    modified: Option<SystemTime>,
    taken: u64,
    first: Vec<u8>,
    last: Vec<u8>,
}

impl Source {
    /// Opens a file, a pipe or a device, and records it as an input ([`opened`]).
    pub fn open(path: &Path) -> io::Result<Source> {
        opened::note(path);
        Source::unnoted(path)
    }

    fn unnoted(path: &Path) -> io::Result<Source> {
        let file = File::open(path)?;
        let found = file.metadata()?;
        if !found.is_file() {
            return Ok(Source::of(file));
        }
        let (length, modified) = (found.len(), found.modified().ok());
        let (first, last) = (Vec::new(), Vec::new());
        Ok(Source { from: From::File(RegularFile { file, length, modified, taken: 0, first, last }) })
    }

    /// Standard input.
    pub fn standard_input() -> Source {
        Source::of(io::stdin())
    }

    /// A source that reads from a stream without a path.
    pub fn of(pipe: impl Read + Send + 'static) -> Source {
        Source { from: From::Pipe(Box::new(pipe)) }
    }

    /// The length of a regular file when it was opened, bytes. `None` for a pipe or a device.
    pub fn length(&self) -> Option<u64> {
        match &self.from {
            From::File(file) => Some(file.length),
            From::Pipe(_) => None,
        }
    }

    /// Converts the source into a file for reads at any offset. A pipe is returned unchanged in the inner `Err`, because its
    /// bytes can only be read once and in order.
    pub fn pieces(self) -> io::Result<Result<RandomAccessFile, Source>> {
        match self.from {
            From::File(file) => RandomAccessFile::of(file).map(Ok),
            From::Pipe(_) => Ok(Err(self)),
        }
    }

    /// Reads all bytes.
    ///
    /// Fails with [`io::ErrorKind::FileTooLarge`] if there are more than `cap` bytes. Fails if reading fails.
    pub fn whole(mut self, cap: u64) -> io::Result<Vec<u8>> {
        let too_large = || io::Error::new(io::ErrorKind::FileTooLarge, format!("it has more than {cap} bytes"));
        if self.length().is_some_and(|length| length > cap) {
            return Err(too_large());
        }
        let mut bytes = Vec::new();
        (&mut self).take(cap.saturating_add(1)).read_to_end(&mut bytes)?;
        if bytes.len() as u64 > cap { Err(too_large()) } else { Ok(bytes) }
    }

    /// Reads the next bytes, at most `most`.
    pub fn head(&mut self, most: usize) -> io::Result<Vec<u8>> {
        let mut bytes = Vec::new();
        self.take(most as u64).read_to_end(&mut bytes)?;
        Ok(bytes)
    }
}

/// A regular file that is read at any offset.
pub struct RandomAccessFile {
    length: u64,
    file: Mutex<RegularFile>,
}

impl RandomAccessFile {
    fn of(mut file: RegularFile) -> io::Result<RandomAccessFile> {
        let compared = usize::try_from(file.length).unwrap_or(usize::MAX).min(COMPARED_BYTES);
        file.first = file.again(0, compared)?;
        file.last = file.again(file.length - compared as u64, compared)?;
        file.taken = file.length;
        Ok(RandomAccessFile { length: file.length, file: Mutex::new(file) })
    }

    /// The length of the file when it was opened, bytes.
    pub fn length(&self) -> u64 {
        self.length
    }

    /// Reads `count` bytes from the offset `place`, or fewer if the file ends there.
    pub fn read(&self, place: u64, count: usize) -> io::Result<Vec<u8>> {
        let left = self.length.saturating_sub(place);
        self.locked().again(place, usize::try_from(left).unwrap_or(usize::MAX).min(count))
    }

    /// Fails if the file was overwritten during the reads, so that the blocks may belong to two versions of it.
    pub fn unchanged(&self) -> io::Result<()> {
        self.locked().unchanged()
    }

    fn locked(&self) -> MutexGuard<'_, RegularFile> {
        // The lock is used even if another thread panicked while it held the lock. The file position that this thread left does
        // not matter, because every read first sets its own position.
        self.file.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Reads all bytes of the file or pipe at `path`. Fails if there are more than `cap` bytes, like [`Source::whole`].
pub fn read(path: &Path, cap: u64) -> io::Result<Vec<u8>> {
    Source::open(path)?.whole(cap)
}

/// Reads the first `most` bytes of a system file without a stated length, such as a file in /proc.
pub fn system_file_head(path: &Path, most: usize) -> io::Result<Vec<u8>> {
    Source::of(File::open(path)?).head(most)
}

/// Reads the first `most` bytes of a regular file without recording it as an input. `None` if the file is not a regular file:
/// bytes of a pipe that are read here would be missing for the later reader.
pub fn glance(path: &Path, most: usize) -> Option<Vec<u8>> {
    // Opening a pipe without a writer would block for ever.
    if !std::fs::metadata(path).is_ok_and(|found| found.is_file()) {
        return None;
    }
    Source::unnoted(path).ok()?.head(most).ok()
}

/// The reason why `path` is not a regular file, as a clause. `None` if it is a regular file.
pub fn no_file(path: &Path) -> Option<String> {
    let found = std::fs::metadata(path).ok().map(|found| found.file_type());
    let what = match found {
        None => return Some(format!("there is no {}", path.display())),
        Some(kind) if kind.is_file() => return None,
        Some(kind) if kind.is_dir() => "a directory",
        #[cfg(unix)]
        Some(kind) if std::os::unix::fs::FileTypeExt::is_fifo(&kind) => "a named pipe",
        Some(_) => "a device",
    };
    Some(format!("{} is {what}, and a file is expected", path.display()))
}

impl Read for Source {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        match &mut self.from {
            From::File(file) => file.read(out),
            From::Pipe(pipe) => pipe.read(out),
        }
    }
}

impl RegularFile {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let most = usize::try_from(self.length - self.taken).unwrap_or(usize::MAX).min(out.len());
        if out.is_empty() {
            return Ok(0);
        }
        let count = if most == 0 { 0 } else { self.file.read(&mut out[..most])? };
        if count == 0 {
            self.unchanged()?;
            return Ok(0);
        }
        self.taken += count as u64;
        let read = &out[..count];
        let missing = COMPARED_BYTES.saturating_sub(self.first.len());
        self.first.extend(&read[..missing.min(count)]);
        if count >= COMPARED_BYTES {
            self.last.clear();
        }
        self.last.extend(&read[count.saturating_sub(COMPARED_BYTES)..]);
        let surplus = self.last.len().saturating_sub(COMPARED_BYTES);
        self.last.drain(..surplus);
        Ok(count)
    }

    /// Fails if the file was overwritten during the read, so that the bytes may belong to two versions of it.
    fn unchanged(&mut self) -> io::Result<()> {
        let found = self.file.metadata()?;
        let is_same = self.taken == self.length
            && found.len() >= self.length
            && (found.modified().ok() == self.modified || self.has_grown(&found)?);
        if is_same {
            return Ok(());
        }
        Err(io::Error::other("the file was written over while it was read; read it again when it is whole"))
    }

    fn has_grown(&mut self, found: &Metadata) -> io::Result<bool> {
        if found.len() == self.length {
            return Ok(false);
        }
        let place = self.length - self.last.len() as u64;
        Ok(self.again(0, self.first.len())? == self.first && self.again(place, self.last.len())? == self.last)
    }

    fn again(&mut self, place: u64, count: usize) -> io::Result<Vec<u8>> {
        self.file.seek(SeekFrom::Start(place))?;
        let mut bytes = Vec::with_capacity(count);
        (&self.file).take(count as u64).read_to_end(&mut bytes)?;
        // A sequential read that continues after this comparison must start at the end of the file.
        self.file.seek(SeekFrom::Start(self.length))?;
        Ok(bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs::{OpenOptions, write};
    use std::io::Write;
    use std::path::PathBuf;
    use std::time::Duration;

    fn place(name: &str) -> PathBuf {
        std::env::temp_dir().join(format!("rist-source-{}-{name}", std::process::id()))
    }

    /// Opens a file of 10 000 bytes, reads half of it, runs `change`, and reads the other half.
    fn meanwhile(name: &str, change: impl FnOnce(&Path)) -> io::Result<Vec<u8>> {
        let path = place(name);
        write(&path, [b'a'; 10_000]).unwrap();
        let long_ago = SystemTime::now() - Duration::from_secs(100);
        OpenOptions::new().write(true).open(&path).unwrap().set_modified(long_ago).unwrap();
        let mut source = Source::open(&path).unwrap();
        let mut bytes = vec![0; 5000];
        source.read_exact(&mut bytes).unwrap();
        change(&path);
        let end = source.read_to_end(&mut bytes);
        std::fs::remove_file(&path).unwrap();
        end.map(|_| bytes)
    }

    #[test]
    fn a_file_that_grows_is_read_to_its_length_at_opening() {
        assert_eq!(meanwhile("still", |_| ()).unwrap(), [b'a'; 10_000]);
        let grown = meanwhile("grown", |path| {
            OpenOptions::new().append(true).open(path).unwrap().write_all(b"more").unwrap();
        });
        assert_eq!(grown.unwrap(), [b'a'; 10_000]);
    }

    #[test]
    fn a_file_that_is_written_over_is_refused() {
        for (name, length) in [("shorter", 7000), ("same", 10_000), ("longer", 20_000)] {
            let message = meanwhile(name, |path| write(path, vec![b'b'; length]).unwrap()).unwrap_err().to_string();
            assert!(message.contains("written over while it was read"), "{name}: {message}");
        }
    }

    #[test]
    fn pieces_are_those_of_one_version() {
        let path = place("pieces");
        let bytes: Vec<u8> = (0..100_000u32).map(|i| (i / 256) as u8).collect();
        let open = || {
            write(&path, &bytes).unwrap();
            let long_ago = SystemTime::now() - Duration::from_secs(100);
            OpenOptions::new().write(true).open(&path).unwrap().set_modified(long_ago).unwrap();
            Source::open(&path).unwrap().pieces().unwrap().unwrap_or_else(|_| panic!("it is a file"))
        };
        let pieces = open();
        assert_eq!(pieces.read(50_000, 7).unwrap(), bytes[50_000..50_007]);
        assert_eq!(pieces.read(99_998, usize::MAX).unwrap(), bytes[99_998..]);
        assert_eq!((pieces.read(200_000, 7).unwrap().len(), pieces.length()), (0, 100_000));
        assert!(pieces.unchanged().is_ok());
        OpenOptions::new().append(true).open(&path).unwrap().write_all(b"more").unwrap();
        assert!(pieces.unchanged().is_ok() && pieces.read(99_999, 9).unwrap() == bytes[99_999..]);
        for length in [70_000, 100_000, 200_000] {
            let pieces = open();
            write(&path, vec![b'b'; length]).unwrap();
            assert!(pieces.unchanged().unwrap_err().to_string().contains("written over"), "{length}");
        }
        std::fs::remove_file(&path).unwrap();
        assert!(Source::of(io::repeat(0)).pieces().unwrap().is_err());
    }

    #[test]
    fn a_cap_is_kept_by_files_and_by_what_has_no_end() {
        let path = place("cap");
        write(&path, [0; 100]).unwrap();
        assert_eq!(read(&path, 100).unwrap().len(), 100);
        assert_eq!(read(&path, 99).unwrap_err().kind(), io::ErrorKind::FileTooLarge);
        assert_eq!(glance(&path, 7).unwrap().len(), 7);
        std::fs::remove_file(&path).unwrap();
        assert_eq!(Source::of(io::repeat(0)).whole(1000).unwrap_err().kind(), io::ErrorKind::FileTooLarge);
        #[cfg(unix)]
        assert!(glance(Path::new("/dev/zero"), 7).is_none());
        assert_eq!(no_file(Path::new("/dev/zero")).unwrap(), "/dev/zero is a device, and a file is expected");
        assert_eq!(no_file(Path::new("/no/such")).unwrap(), "there is no /no/such");
    }
}
