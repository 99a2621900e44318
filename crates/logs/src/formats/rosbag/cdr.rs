//! Reads numbers and texts of a message in CDR (ROS 2) or in the encoding of ROS 1.
//!
//! CDR aligns every number to its size, counted after the first four bytes, which contain the byte order. Its strings end with a
//! zero byte. ROS 1 has no alignment and no zero byte, and is little-endian. Memory for a stated length is allocated only if the
//! message has this number of bytes.

/// The encoding of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Encoding {
    Cdr,
    Ros1,
}

impl Encoding {
    pub(crate) fn of(name: &str) -> Option<Encoding> {
        match name {
            "cdr" => Some(Encoding::Cdr),
            "ros1" => Some(Encoding::Ros1),
            _ => None,
        }
    }
}

/// A position in the bytes of a message.
pub(crate) struct Cursor<'a> {
    data: &'a [u8],
    at: usize,
    pub(crate) aligned: bool,
    big_endian: bool,
    /// The type of the message, for errors.
    kind: &'a str,
}

impl<'a> Cursor<'a> {
    /// The start of a message, after the bytes with the byte order. `kind`: type of the message, for errors.
    pub(crate) fn new(data: &'a [u8], encoding: Encoding, kind: &'a str) -> Result<Cursor<'a>, String> {
        let mut cursor = Cursor { data, at: 0, aligned: encoding == Encoding::Cdr, big_endian: false, kind };
        if encoding == Encoding::Cdr {
            match data.get(..4) {
                Some([0, 0, ..]) => cursor.big_endian = true,
                Some([0, 1, ..]) => {}
                Some([a, b, ..]) => {
                    return Err(format!("its encapsulation is {a:02x}{b:02x}; plain CDR, 0000 or 0001, is read"));
                }
                _ => return Err(cursor.short(4)),
            }
            cursor.data = &data[4..];
        }
        Ok(cursor)
    }

    /// The start of bytes that are little-endian and not aligned.
    pub(crate) fn plain(data: &'a [u8], kind: &'a str) -> Cursor<'a> {
        Cursor { data, at: 0, aligned: false, big_endian: false, kind }
    }

    fn short(&self, count: usize) -> String {
        let left = self.data.len().saturating_sub(self.at);
        format!("{count} bytes are claimed at byte {} where {left} are left: no {}", self.at, self.kind)
    }

    /// Number of remaining bytes.
    pub(crate) fn left(&self) -> usize {
        self.data.len().saturating_sub(self.at)
    }

    pub(crate) fn bytes(&mut self, count: usize) -> Result<&'a [u8], String> {
        let end = self.at.checked_add(count);
        let bytes = end.and_then(|end| self.data.get(self.at..end)).ok_or_else(|| self.short(count))?;
        self.at += count;
        Ok(bytes)
    }

    pub(crate) fn align(&mut self, size: usize) {
        if self.aligned {
            self.at = self.at.next_multiple_of(size);
        }
    }

    /// Reads the bytes of a number, and returns them in little-endian order.
    pub(crate) fn number<const N: usize>(&mut self) -> Result<[u8; N], String> {
        self.align(N);
        let mut bytes: [u8; N] = self.bytes(N)?.try_into().unwrap_or([0; N]);
        if self.big_endian {
            bytes.reverse();
        }
        Ok(bytes)
    }

    pub(crate) fn u32(&mut self) -> Result<u32, String> {
        self.number().map(u32::from_le_bytes)
    }

    pub(crate) fn text(&mut self) -> Result<&'a str, String> {
        let length = self.u32()? as usize;
        let bytes = self.bytes(length)?;
        let bytes = if self.aligned { bytes.strip_suffix(&[0]).unwrap_or(bytes) } else { bytes };
        std::str::from_utf8(bytes).map_err(|_| format!("the text before byte {} is no UTF-8", self.at))
    }

    pub(crate) fn doubles(&mut self) -> Result<Vec<f64>, String> {
        let count = self.u32()? as usize;
        if count == 0 {
            return Ok(Vec::new()); // without elements nothing is aligned to them
        }
        self.align(8);
        let bytes = self.bytes(count.saturating_mul(8))?;
        let number = if self.big_endian { f64::from_be_bytes } else { f64::from_le_bytes };
        Ok(bytes.as_chunks::<8>().0.iter().map(|b| number(*b)).collect())
    }
}
