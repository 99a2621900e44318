//! Thrift's compact protocol, as far as Parquet writes its metadata with it: fields by number.

/// Deeper nesting than Parquet's.
const MAX_DEPTH: usize = 16;

/// A value without the names of its fields.
#[derive(Clone, Debug, PartialEq)]
pub enum Thrift<'a> {
    Bool(bool),
    Integer(i64),
    Double,
    Bytes(&'a [u8]),
    List(Vec<Thrift<'a>>),
    Struct(Vec<(i16, Thrift<'a>)>),
}

impl<'a> Thrift<'a> {
    /// The struct at the front of the bytes, and how many bytes it takes.
    pub fn read(bytes: &'a [u8]) -> Result<(Thrift<'a>, usize), String> {
        let mut reader = Reader { bytes, at: 0 };
        let value = reader.value(12, MAX_DEPTH)?;
        Ok((value, reader.at))
    }

    pub fn field(&self, id: i16) -> Option<&Thrift<'a>> {
        match self {
            Thrift::Struct(fields) => fields.iter().find(|f| f.0 == id).map(|f| &f.1),
            _ => None,
        }
    }

    pub fn integer(&self, id: i16) -> Option<i64> {
        match self.field(id) {
            Some(Thrift::Integer(i)) => Some(*i),
            _ => None,
        }
    }

    /// A number that counts or places something.
    pub fn size(&self, id: i16) -> Option<usize> {
        self.integer(id).and_then(|i| usize::try_from(i).ok())
    }

    pub fn bool(&self, id: i16) -> Option<bool> {
        match self.field(id) {
            Some(Thrift::Bool(b)) => Some(*b),
            _ => None,
        }
    }

    pub fn text(&self, id: i16) -> Option<String> {
        match self.field(id) {
            Some(Thrift::Bytes(b)) => Some(String::from_utf8_lossy(b).into_owned()),
            _ => None,
        }
    }

    /// The elements of a list; none where there is no list.
    pub fn list(&self, id: i16) -> &[Thrift<'a>] {
        match self.field(id) {
            Some(Thrift::List(list)) => list,
            _ => &[],
        }
    }
}

struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Reader<'a> {
    fn take(&mut self, count: usize) -> Result<&'a [u8], String> {
        let end = self.at.checked_add(count);
        let bytes = end.and_then(|end| self.bytes.get(self.at..end)).ok_or("the metadata end too early")?;
        self.at += count;
        Ok(bytes)
    }

    fn byte(&mut self) -> Result<u8, String> {
        self.take(1).map(|b| b[0])
    }

    fn unsigned(&mut self) -> Result<u64, String> {
        let (value, length) = varint(&self.bytes[self.at..]).ok_or("a number of the metadata is damaged")?;
        self.at += length;
        Ok(value)
    }

    fn integer(&mut self) -> Result<i64, String> {
        self.unsigned().map(zigzag)
    }

    /// As many elements as are claimed, which can be no more than bytes are left.
    fn elements(&mut self, count: u64, kind: u8, depth: usize) -> Result<Vec<Thrift<'a>>, String> {
        if count > (self.bytes.len() - self.at) as u64 {
            return Err(format!("the metadata claim {count} elements where {} bytes are left", self.bytes.len()));
        }
        (0..count)
            .map(|_| match kind {
                // Inside lists a truth takes a byte of its own.
                1 | 2 => self.byte().map(|b| Thrift::Bool(b == 1)),
                _ => self.value(kind, depth),
            })
            .collect()
    }

    fn value(&mut self, kind: u8, depth: usize) -> Result<Thrift<'a>, String> {
        let depth = depth.checked_sub(1).ok_or("the metadata are nested too deeply")?;
        Ok(match kind {
            1 | 2 => Thrift::Bool(kind == 1),
            3 => Thrift::Integer(i64::from(self.byte()? as i8)),
            4..=6 => Thrift::Integer(self.integer()?),
            7 => self.take(8).map(|_| Thrift::Double)?,
            8 => {
                let length = self.unsigned()?;
                Thrift::Bytes(self.take(usize::try_from(length).unwrap_or(usize::MAX))?)
            }
            9 | 10 => {
                let head = self.byte()?;
                let count = if head >> 4 == 15 { self.unsigned()? } else { u64::from(head >> 4) };
                Thrift::List(self.elements(count, head & 15, depth)?)
            }
            12 => {
                let (mut fields, mut id) = (Vec::new(), 0i16);
                loop {
                    let head = self.byte()?;
                    if head == 0 {
                        break;
                    }
                    id = match head >> 4 {
                        0 => self.integer()? as i16,
                        step => id.wrapping_add(i16::from(step)),
                    };
                    fields.push((id, self.value(head & 15, depth)?));
                }
                Thrift::Struct(fields)
            }
            other => return Err(format!("the metadata hold a field of kind {other}")),
        })
    }
}

/// Seven bits a byte, the lowest first; the value and how many bytes it takes.
pub fn varint(bytes: &[u8]) -> Option<(u64, usize)> {
    let mut value = 0;
    for (k, byte) in bytes.iter().take(10).enumerate() {
        value |= u64::from(byte & 0x7f) << (7 * k);
        if byte & 0x80 == 0 {
            return Some((value, k + 1));
        }
    }
    None
}

/// 0, -1, 1, -2, .. for 0, 1, 2, 3, ..
pub fn zigzag(n: u64) -> i64 {
    (n >> 1) as i64 ^ -((n & 1) as i64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_by_number() {
        // {1: 150, 2: true, 20: "ab", 21: [-1, 1], 22: {}}
        let bytes = [0x15, 0xac, 0x02, 0x11, 0x08, 40, 2, b'a', b'b', 0x19, 0x25, 1, 2, 0x1c, 0, 0, 99];
        let (value, length) = Thrift::read(&bytes).unwrap();
        assert_eq!(length, bytes.len() - 1);
        assert_eq!((value.integer(1), value.bool(2), value.text(20).as_deref()), (Some(150), Some(true), Some("ab")));
        assert_eq!(value.list(21), [Thrift::Integer(-1), Thrift::Integer(1)]);
        assert_eq!(value.field(22), Some(&Thrift::Struct(vec![])));
        assert_eq!(value.integer(3), None);
        for cut in 0..length {
            assert!(Thrift::read(&bytes[..cut]).is_err(), "{cut}");
        }
    }

    #[test]
    fn claims_and_depth_are_bounded() {
        assert!(
            Thrift::read(&[0x19, 0xf5, 0xff, 0xff, 0xff, 0xff, 0x0f, 0]).unwrap_err().contains("4294967295 elements")
        );
        assert!(Thrift::read(&[0x1c; 1000]).unwrap_err().contains("nested too deeply"));
    }

    #[test]
    fn whole_numbers() {
        assert_eq!([0, 1, 2, 3, u64::MAX].map(zigzag), [0, -1, 1, -2, i64::MIN]);
        assert_eq!(varint(&[0xff; 9]), None);
        let most = [0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 1];
        assert_eq!(varint(&most), Some((u64::MAX, 10)));
    }
}
