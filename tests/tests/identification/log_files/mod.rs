//! Functions for tests that write log files in foreign formats: ROS messages, MCAP and NumPy's npz. Parquet is in `parquet`.

pub(crate) mod parquet;

use std::io::Write;

#[derive(Clone, Default)]
pub(crate) struct State {
    pub stamp: (u32, u32),
    pub names: Vec<&'static str>,
    /// Position, velocity and effort, each in the order of `names`.
    pub arrays: [Vec<f64>; 3],
}

impl State {
    /// The message in ROS 2 serialisation (CDR): a header of four bytes, then numbers aligned to their size.
    pub(crate) fn cdr(&self, big_endian: bool) -> Vec<u8> {
        let mut body = Vec::new();
        let u32s = |body: &mut Vec<u8>, x: u32| {
            body.resize(body.len().next_multiple_of(4), 0);
            body.extend(if big_endian { x.to_be_bytes() } else { x.to_le_bytes() });
        };
        let text = |body: &mut Vec<u8>, x: &str| {
            u32s(body, x.len() as u32 + 1);
            body.extend(x.as_bytes());
            body.push(0);
        };
        u32s(&mut body, self.stamp.0);
        u32s(&mut body, self.stamp.1);
        text(&mut body, "base");
        u32s(&mut body, self.names.len() as u32);
        self.names.iter().for_each(|n| text(&mut body, n));
        for array in &self.arrays {
            u32s(&mut body, array.len() as u32);
            for x in array {
                body.resize(body.len().next_multiple_of(8), 0);
                body.extend(if big_endian { x.to_be_bytes() } else { x.to_le_bytes() });
            }
        }
        [vec![0, u8::from(!big_endian), 0, 0], body].concat()
    }

    /// The message in ROS 1 serialisation: a sequence number first, no alignment.
    pub(crate) fn ros1(&self) -> Vec<u8> {
        let u32s = |x: usize| (x as u32).to_le_bytes().to_vec();
        let text = |x: &str| [u32s(x.len()), x.as_bytes().to_vec()].concat();
        let mut out = [u32s(7), u32s(self.stamp.0 as usize), u32s(self.stamp.1 as usize), text("base")].concat();
        out.extend(u32s(self.names.len()));
        self.names.iter().for_each(|n| out.extend(text(n)));
        for array in &self.arrays {
            out.extend(u32s(array.len()));
            array.iter().for_each(|x| out.extend(x.to_le_bytes()));
        }
        out
    }
}

/// Writer of an MCAP file. Messages are grouped in chunks unless `chunked` is `None`.
pub(crate) struct Mcap {
    pub bytes: Vec<u8>,
    chunk: Vec<u8>,
    /// Compression of the chunks: "" (none), zstd or lz4. `None`: no chunks.
    chunked: Option<&'static str>,
    pub checked: bool,
}

fn text(x: &str) -> Vec<u8> {
    [&(x.len() as u32).to_le_bytes(), x.as_bytes()].concat()
}

fn record(opcode: u8, content: &[u8]) -> Vec<u8> {
    [&[opcode], &(content.len() as u64).to_le_bytes()[..], content].concat()
}

impl Mcap {
    pub(crate) fn new(chunked: Option<&'static str>) -> Mcap {
        let mut bytes = b"\x89MCAP0\r\n".to_vec();
        bytes.extend(record(1, &[text("ros2"), text("rist's tests")].concat()));
        Mcap { bytes, chunk: Vec::new(), chunked, checked: true }
    }

    /// A file with one channel, number 1, for messages of joint states.
    pub(crate) fn joint_states(chunked: Option<&'static str>, encoding: &str) -> Mcap {
        let mut file = Mcap::new(chunked);
        let ros1 = encoding == "ros1";
        let schema = if ros1 { "sensor_msgs/JointState" } else { "sensor_msgs/msg/JointState" };
        file.channel(1, "/joint_states", schema, encoding);
        file
    }

    pub(crate) fn put(&mut self, record: Vec<u8>) {
        if self.chunked.is_some() { &mut self.chunk } else { &mut self.bytes }.extend(record);
    }

    pub(crate) fn channel(&mut self, id: u16, topic: &str, schema: &str, encoding: &str) {
        let id = id.to_le_bytes();
        self.put(record(3, &[&id[..], &text(schema), &text("ros2msg"), &text("")].concat()));
        self.put(record(4, &[&id[..], &id, &text(topic), &text(encoding), &text("")].concat()));
    }

    pub(crate) fn message(&mut self, channel: u16, log_time: u64, data: &[u8]) {
        let time = log_time.to_le_bytes();
        self.put(record(5, &[&channel.to_le_bytes()[..], &[0; 4], &time, &time, data].concat()));
        if self.chunk.len() > 20_000 {
            self.close_chunk();
        }
    }

    pub(crate) fn close_chunk(&mut self) {
        let Some(compression) = self.chunked else { return };
        let packed = match compression {
            "zstd" => ruzstd::encoding::compress_to_vec(&self.chunk[..], ruzstd::encoding::CompressionLevel::Fastest),
            "lz4" => {
                let mut encoder = lz4_flex::frame::FrameEncoder::new(Vec::new());
                encoder.write_all(&self.chunk).unwrap();
                encoder.finish().unwrap()
            }
            _ => self.chunk.clone(),
        };
        let mut crc = flate2::Crc::new();
        crc.update(&self.chunk);
        let crc = if self.checked { crc.sum() } else { 0 };
        let size = self.chunk.len() as u64;
        self.bytes.extend(chunk(size, crc, compression, &packed));
        self.chunk.clear();
    }

    /// Ends the file and returns its bytes. The index at the end is empty, since no reader needs it.
    pub(crate) fn finish(mut self) -> Vec<u8> {
        if !self.chunk.is_empty() {
            self.close_chunk();
        }
        self.bytes.extend(record(15, &[0; 4]));
        self.bytes.extend(record(2, &[0; 20]));
        self.bytes.extend(b"\x89MCAP0\r\n");
        self.bytes
    }
}

/// A chunk record whose header states an uncompressed length of `size` bytes.
pub(crate) fn chunk(size: u64, crc: u32, compression: &str, packed: &[u8]) -> Vec<u8> {
    let head = [&[0; 16][..], &size.to_le_bytes(), &crc.to_le_bytes(), &text(compression)].concat();
    record(6, &[&head[..], &(packed.len() as u64).to_le_bytes(), packed].concat())
}

/// Writes the columns as arrays of doubles, as numpy.savez does.
pub(crate) fn npz(columns: &[(String, Vec<f64>)]) -> Vec<u8> {
    let (mut out, mut directory) = (Vec::new(), Vec::new());
    for (name, values) in columns {
        let head = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({},), }}\n", values.len());
        let mut content = b"\x93NUMPY\x01\x00".to_vec();
        content.extend((head.len() as u16).to_le_bytes());
        content.extend(head.as_bytes());
        values.iter().for_each(|x| content.extend(x.to_le_bytes()));
        let (name, offset) = (format!("{name}.npy"), out.len() as u32);
        let mut common = [0; 22];
        common[14..18].copy_from_slice(&(content.len() as u32).to_le_bytes());
        common[18..22].copy_from_slice(&(content.len() as u32).to_le_bytes());
        let lengths = [(name.len() as u16).to_le_bytes(), [0; 2]].concat();
        out.extend([b"PK\x03\x04", &common[..], &lengths, name.as_bytes(), &content].concat());
        let place = [&[0; 10][..], &offset.to_le_bytes(), name.as_bytes()].concat();
        directory.extend([b"PK\x01\x02\0\0", &common[..], &lengths, &place].concat());
    }
    let (start, count) = (out.len() as u32, (columns.len() as u16).to_le_bytes());
    out.extend(&directory);
    let sizes = [(directory.len() as u32).to_le_bytes(), start.to_le_bytes()].concat();
    out.extend([b"PK\x05\x06\0\0\0\0", &count[..], &count, &sizes, &[0; 2]].concat());
    out
}

/// Writes the columns as CSV text. The digits of each number are enough to restore it exactly.
pub(crate) fn csv(columns: &[(String, Vec<f64>)]) -> Vec<u8> {
    let names: Vec<&str> = columns.iter().map(|c| c.0.as_str()).collect();
    let mut out = names.join(",") + "\n";
    for r in 0..columns[0].1.len() {
        let row: Vec<String> = columns.iter().map(|c| format!("{:?}", c.1[r])).collect();
        out += &(row.join(",") + "\n");
    }
    out.into_bytes()
}
