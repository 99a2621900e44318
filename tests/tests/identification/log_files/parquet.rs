//! Writer of Parquet files with flat columns for tests, without a Parquet library.

use std::io::Write;

/// Values of one column; `None` is a null.
#[derive(Clone)]
pub(crate) enum Values {
    Double(Vec<Option<f64>>),
    Float(Vec<f32>),
    Int64(Vec<i64>),
    /// Nanoseconds since 1970.
    Timestamp(Vec<i64>),
    Text(usize),
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct Pages {
    /// Number of the compression codec in Parquet: 0 none, 1 snappy, 2 gzip, 6 zstd, 7 lz4_raw.
    pub codec: u8,
    /// Version of the data pages: 1 or 2.
    pub version: u8,
    pub dictionary: bool,
    pub rows_a_group: usize,
}

pub(crate) const PLAIN: Pages = Pages { codec: 0, version: 1, dictionary: false, rows_a_group: 1000 };

pub(crate) fn doubles(columns: &[(String, Vec<f64>)]) -> Vec<(String, Values)> {
    let some = |x: &Vec<f64>| Values::Double(x.iter().map(|x| Some(*x)).collect());
    columns.iter().map(|(name, values)| (name.clone(), some(values))).collect()
}

pub(crate) fn file(columns: &[(String, Values)], pages: Pages) -> Vec<u8> {
    let rows = columns[0].1.len();
    let mut out = b"PAR1".to_vec();
    let mut groups = Vec::new();
    for start in (0..rows).step_by(pages.rows_a_group) {
        let range = start..rows.min(start + pages.rows_a_group);
        let chunks: Vec<Vec<u8>> = columns.iter().map(|(_, values)| chunk(&mut out, values, &range, pages)).collect();
        let group = Fields::new().structs(1, &chunks).long(2, 0).long(3, range.len() as i64);
        groups.push(group.end());
    }
    let mut schema = vec![Fields::new().text(4, "schema").int(5, columns.len() as i64).end()];
    for (name, values) in columns {
        let fields = Fields::new().int(1, values.kind()).int(3, i64::from(values.optional())).text(4, name);
        let nanoseconds = Fields::new().structure(3, vec![0]).end();
        let timestamp = Fields::new().structure(8, Fields::new().bool(1, true).structure(2, nanoseconds).end()).end();
        let fields = if matches!(values, Values::Timestamp(_)) { fields.structure(10, timestamp) } else { fields };
        schema.push(fields.end());
    }
    let footer = Fields::new().int(1, 2).structs(2, &schema).long(3, rows as i64).structs(4, &groups).end();
    out.extend(&footer);
    out.extend((footer.len() as u32).to_le_bytes());
    out.extend(b"PAR1");
    out
}

impl Values {
    fn len(&self) -> usize {
        match self {
            Values::Double(x) => x.len(),
            Values::Float(x) => x.len(),
            Values::Int64(x) | Values::Timestamp(x) => x.len(),
            Values::Text(n) => *n,
        }
    }

    fn kind(&self) -> i64 {
        match self {
            Values::Double(_) => 5,
            Values::Float(_) => 4,
            Values::Int64(_) | Values::Timestamp(_) => 2,
            Values::Text(_) => 6,
        }
    }

    fn optional(&self) -> bool {
        matches!(self, Values::Double(_))
    }

    fn bytes(&self, range: &std::ops::Range<usize>) -> Vec<Option<Vec<u8>>> {
        let range = range.clone();
        match self {
            Values::Double(x) => x[range].iter().map(|x| x.map(|x| x.to_le_bytes().to_vec())).collect(),
            Values::Float(x) => x[range].iter().map(|x| Some(x.to_le_bytes().to_vec())).collect(),
            Values::Int64(x) | Values::Timestamp(x) => {
                x[range].iter().map(|x| Some(x.to_le_bytes().to_vec())).collect()
            }
            Values::Text(_) => range.map(|_| Some(b"\x01\0\0\0x".to_vec())).collect(),
        }
    }
}

/// Writes the pages of a column to `out` and returns its ColumnChunk structure.
fn chunk(out: &mut Vec<u8>, values: &Values, range: &std::ops::Range<usize>, pages: Pages) -> Vec<u8> {
    let cells = values.bytes(range);
    let present: Vec<&Vec<u8>> = cells.iter().flatten().collect();
    let start = out.len();
    let mut distinct = present.clone();
    distinct.sort();
    distinct.dedup();
    let width = usize::BITS - (distinct.len().max(2) - 1).leading_zeros();
    let body = if pages.dictionary {
        let page = distinct.iter().copied().flatten().copied().collect::<Vec<u8>>();
        let head = Fields::new().int(1, distinct.len() as i64).int(2, 0).end();
        put_page(out, 2, (7, head), &[], &page, pages.codec);
        let places = present.iter().map(|v| distinct.binary_search(v).unwrap() as u64);
        [vec![width as u8], groups_of_eight(places, width)].concat()
    } else {
        present.iter().copied().flatten().copied().collect()
    };
    let data = out.len();
    let mut levels = Vec::new();
    if values.optional() {
        // Definition levels tell which cells are not null. The cells before the first null are one run, the others are bit-packed
        // in groups of eight.
        let run = cells.iter().take_while(|c| c.is_some()).count();
        levels.extend(varint((run as u64) << 1));
        levels.push(1);
        levels.extend(groups_of_eight(cells[run..].iter().map(|c| u64::from(c.is_some())), 1));
    }
    let encoding = if pages.dictionary { 8 } else { 0 };
    if pages.version == 1 {
        let head = Fields::new().int(1, cells.len() as i64).int(2, encoding).int(3, 3).int(4, 3).end();
        let length = if values.optional() { (levels.len() as u32).to_le_bytes().to_vec() } else { vec![] };
        put_page(out, 0, (5, head), &[], &[length, levels, body].concat(), pages.codec);
    } else {
        let nulls = cells.iter().filter(|c| c.is_none()).count();
        let head = Fields::new().int(1, cells.len() as i64).int(2, nulls as i64).int(3, cells.len() as i64);
        let head = head.int(4, encoding).int(5, levels.len() as i64).int(6, 0).end();
        put_page(out, 3, (8, head), &levels, &body, pages.codec);
    }
    // The encodings and the path in the schema are never read, but the format requires them.
    let metadata = Fields::new()
        .int(1, values.kind())
        .head(2, 9, &[0x15, 0])
        .head(3, 9, &[0x18, 1, b'x'])
        .int(4, i64::from(pages.codec))
        .long(5, cells.len() as i64);
    let metadata = metadata.long(6, 0).long(7, (out.len() - start) as i64).long(9, data as i64);
    let metadata = if pages.dictionary { metadata.long(11, start as i64) } else { metadata };
    Fields::new().long(2, 0).structure(3, metadata.end()).end()
}

fn put_page(out: &mut Vec<u8>, kind: i64, head: (i16, Vec<u8>), levels: &[u8], body: &[u8], codec: u8) {
    let packed = pack(codec, body);
    let (size, length) = ((levels.len() + body.len()) as i64, (levels.len() + packed.len()) as i64);
    out.extend(Fields::new().int(1, kind).int(2, size).int(3, length).structure(head.0, head.1).end());
    out.extend([levels, &packed].concat());
}

fn pack(codec: u8, body: &[u8]) -> Vec<u8> {
    match codec {
        1 => snap::raw::Encoder::new().compress_vec(body).unwrap(),
        2 => {
            let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
            encoder.write_all(body).unwrap();
            encoder.finish().unwrap()
        }
        6 => ruzstd::encoding::compress_to_vec(body, ruzstd::encoding::CompressionLevel::Fastest),
        7 => lz4_flex::block::compress(body),
        _ => body.to_vec(),
    }
}

/// One bit-packed run of values with `width` bits each, padded to groups of eight.
fn groups_of_eight(values: impl ExactSizeIterator<Item = u64>, width: u32) -> Vec<u8> {
    let groups = values.len().div_ceil(8);
    let mut out = varint((groups as u64) << 1 | 1);
    let mut bits = vec![false; groups * 8 * width as usize];
    for (i, value) in values.enumerate() {
        (0..width).for_each(|k| bits[i * width as usize + k as usize] = value >> k & 1 == 1);
    }
    out.extend(bits.chunks(8).map(|c| c.iter().rev().fold(0, |n, &b| n << 1 | u8::from(b))));
    out
}

fn varint(mut n: u64) -> Vec<u8> {
    let mut out = Vec::new();
    while n > 127 {
        out.push(n as u8 | 128);
        n >>= 7;
    }
    out.push(n as u8);
    out
}

/// A struct in Thrift's compact protocol. Fields must be added in rising order of their ids.
struct Fields {
    bytes: Vec<u8>,
    last: i16,
}

impl Fields {
    fn new() -> Fields {
        Fields { bytes: Vec::new(), last: 0 }
    }

    fn head(mut self, id: i16, kind: u8, content: &[u8]) -> Fields {
        self.bytes.push(((id - self.last) as u8) << 4 | kind);
        self.bytes.extend(content);
        self.last = id;
        self
    }

    fn int(self, id: i16, value: i64) -> Fields {
        self.head(id, 5, &varint((value << 1 ^ value >> 63) as u64))
    }

    fn long(self, id: i16, value: i64) -> Fields {
        self.head(id, 6, &varint((value << 1 ^ value >> 63) as u64))
    }

    fn bool(self, id: i16, value: bool) -> Fields {
        self.head(id, if value { 1 } else { 2 }, &[])
    }

    fn text(self, id: i16, text: &str) -> Fields {
        self.head(id, 8, &[varint(text.len() as u64), text.as_bytes().to_vec()].concat())
    }

    fn structure(self, id: i16, content: Vec<u8>) -> Fields {
        self.head(id, 12, &content)
    }

    fn structs(self, id: i16, elements: &[Vec<u8>]) -> Fields {
        let head = if elements.len() < 15 {
            vec![(elements.len() as u8) << 4 | 12]
        } else {
            [vec![0xfc], varint(elements.len() as u64)].concat()
        };
        self.head(id, 9, &[head, elements.concat()].concat())
    }

    fn end(mut self) -> Vec<u8> {
        self.bytes.push(0);
        self.bytes
    }
}
