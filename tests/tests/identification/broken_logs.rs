//! Broken logs: each is refused with the expected message, and no reader panics.

use std::path::Path;

use identification::estimate::identify::identify;
use identification::estimate::options::Options;
use identification::signals::signal_options::Signal;
use linear_model::parameter::BaseParameter;
use linear_model::regressor::Regressor;
use logs::{Log, Table};
use tests::program::folder;

use crate::log_files::parquet::{self, PLAIN, Pages, Values};
use crate::log_files::{Mcap, State, chunk};

/// A robot of wheels that do not influence each other: tau_j = ZZ_j ddq_j.
pub(crate) struct Wheels {
    coordinates: Vec<String>,
    parameters: Vec<BaseParameter>,
}

impl Regressor for Wheels {
    fn coordinates(&self) -> &[String] {
        &self.coordinates
    }

    fn parameters(&self) -> &[BaseParameter] {
        &self.parameters
    }

    fn fill(&self, _: &[f64], _: &[f64], ddq: &[f64], y: &mut [f64]) {
        let n = ddq.len();
        y.fill(0.0);
        (0..n).for_each(|j| y[j * n + j] = ddq[j]);
    }
}

pub(crate) fn wheels(names: &str) -> Wheels {
    let coordinates: Vec<String> = names.split_whitespace().map(Into::into).collect();
    let parameters =
        (0..coordinates.len()).map(|k| BaseParameter::turning(&format!("ZZ{}", k + 1), k).unwrap()).collect();
    Wheels { coordinates, parameters }
}

fn expanded(text: &str) -> String {
    let mut out = String::new();
    for line in text.lines() {
        match line.strip_prefix('@').and_then(|l| l.split_once(' ')) {
            Some((n, row)) => {
                (0..n.parse().unwrap())
                    .for_each(|i: usize| out += &format!("{}\n", row.replace("{i}", &format!("{i:02}"))));
            }
            None => out += &format!("{line}\n"),
        }
    }
    out
}

fn message(wheels: &Wheels, path: &Path) -> String {
    let signal = Signal { cutoff: Some(40.0), ..Signal::default() };
    let options = Options { signal, ..Options::default() };
    let outcome =
        Log::read(path, wheels.coordinates(), &options.columns).and_then(|(log, _)| identify(wheels, &log, &options));
    match outcome {
        Ok(estimate) => format!("no error, but {estimate}"),
        Err(error) => error.to_string(),
    }
}

#[test]
fn every_broken_log_has_its_message() {
    let data = include_str!("broken_logs.txt");
    let folder = folder("broken-logs");
    let path = folder.join("broken.csv");
    let mut tried = 0;
    for entry in data.split("\n=== ").skip(1) {
        let (head, text) = entry.split_once('\n').unwrap_or((entry, ""));
        let (coordinates, expected) = head.split_once(" | ").unwrap();
        std::fs::write(&path, expanded(text)).unwrap();
        let found = message(&wheels(coordinates), &path);
        assert!(found.contains(expected), "expected: {expected}\nfound: {found}");
        tried += 1;
    }
    assert!(tried >= 20, "{tried}");
}

/// A joint state message of joint `a` in row r. A quantity that is not measured has an empty array.
fn state(r: u32, measured: [bool; 3]) -> State {
    let x = (0.05 * f64::from(r)).sin();
    let arrays = measured.map(|m| if m { vec![x] } else { vec![] });
    State { stamp: (r / 100, r % 100 * 10_000_000 + 1), names: vec!["a"], arrays }
}

const ALL: [bool; 3] = [true; 3];

fn recording(chunked: Option<&'static str>, rows: u32, measured: [bool; 3]) -> Mcap {
    let mut file = Mcap::joint_states(chunked, "cdr");
    (0..rows).for_each(|r| file.message(1, 0, &state(r, measured).cdr(false)));
    file
}

fn one_message(data: &[u8]) -> Vec<u8> {
    let mut file = Mcap::joint_states(None, "cdr");
    file.message(1, 0, data);
    file.finish()
}

/// A recording with one chunk that states a decompressed size of `size` bytes.
fn one_chunk(size: u64, crc: u32, compression: &str, packed: &[u8]) -> Vec<u8> {
    let mut file = Mcap::new(None);
    file.put(chunk(size, crc, compression, packed));
    file.finish()
}

fn parquet(change: impl Fn(usize) -> Option<Values>, pages: Pages) -> Vec<u8> {
    let column = |k: usize| {
        let x = |r: u32| if k == 0 { 0.01 * f64::from(r) } else { (0.05 * f64::from(r) + k as f64).sin() };
        change(k).unwrap_or_else(|| Values::Double((0..80).map(|r| Some(x(r))).collect()))
    };
    let names = ["t", "q1", "tau1"];
    let columns: Vec<(String, Values)> = (0..3).map(|k| (names[k].to_string(), column(k))).collect();
    parquet::file(&columns, pages)
}

fn replaced(mut bytes: Vec<u8>, old: &[u8], new: &[u8]) -> Vec<u8> {
    let at = bytes.windows(old.len()).position(|w| w == old).unwrap();
    bytes[at..at + new.len()].copy_from_slice(new);
    bytes
}

#[expect(clippy::too_many_lines, reason = "one table")]
fn broken_containers() -> Vec<(Vec<u8>, &'static str)> {
    let no_joint_states = || {
        let mut file = Mcap::new(Some("lz4"));
        file.channel(1, "/tf", "tf2_msgs/msg/TFMessage", "cdr");
        file.channel(2, "/scan", "sensor_msgs/msg/LaserScan", "cdr");
        file.message(1, 0, b"1234");
        file
    };
    let ambiguous = || {
        let mut file = recording(None, 60, ALL);
        file.channel(2, "/left/joint_states", "sensor_msgs/msg/JointState", "cdr");
        (0..40).for_each(|r| file.message(2, 0, &state(r, ALL).cdr(false)));
        file.finish()
    };
    let encoded = |encoding| {
        let mut file = Mcap::joint_states(None, encoding);
        file.message(1, 0, b"{}");
        file.finish()
    };
    let twice = State { names: vec!["a", "a"], arrays: [vec![1.0, 2.0], vec![], vec![]], ..State::default() };
    let nameless = State { arrays: [vec![1.0], vec![], vec![]], ..State::default() };
    let many_names = [&[0, 1, 0, 0][..], &[0; 12], &[0xff, 0xff, 0xff, 0x7f]].concat();
    let many_numbers = [&[0, 1, 0, 0][..], &[0; 16], &[0xff, 0xff, 0xff, 0xff]].concat();
    let compressed = recording(Some("zstd"), 60, ALL).finish();
    let plain = recording(Some(""), 60, ALL).finish();
    let middle = plain.len() / 2;
    let (snappy, lzo) = (Pages { codec: 1, ..PLAIN }, Pages { codec: 3, ..PLAIN });
    let whole = parquet(|_| None, snappy);
    let mut long_index = whole.clone();
    let end = long_index.len();
    long_index[end - 8..end - 4].copy_from_slice(&u32::MAX.to_le_bytes());
    let text = |k: usize, other: usize| (k == other).then_some(Values::Text(80));
    vec![
        // Broken MCAP recordings, each with the expected error message.
        (
            no_joint_states().finish(),
            "no topic carries sensor_msgs/msg/JointState; the topics are: /scan (sensor_msgs/msg/LaserScan), /tf (tf2_msgs/msg/TFMessage)",
        ),
        (Mcap::new(None).finish(), "no topic carries sensor_msgs/msg/JointState; the recording has no topic at all"),
        (
            Mcap::joint_states(None, "cdr").finish(),
            "no message is in the recording on the topic of joint states, /joint_states",
        ),
        (
            ambiguous(),
            "2 topics carry joint states: /joint_states (60 messages; a), /left/joint_states (40 messages; a); say which behind the name: '",
        ),
        (ambiguous(), "broken.csv#/joint_states'"),
        (encoded("json"), "message of /joint_states: it is written as `json`; cdr and ros1 are read"),
        (
            recording(None, 80, [true, true, false]).finish(),
            "no columns hold the joint torques or motor currents (looked for tau1.., effort_<joint>, i1.., actual_current_0.., also with units); other names go into [options.columns], as `[:columns]` proposes them; of position servos without either, the commanded positions: [options.columns.goal]; the columns are: time, position_a, velocity_a",
        ),
        (recording(Some("lz4"), 20, ALL).finish(), "20 usable rows of 20"),
        (one_message(&twice.cdr(false)), "it names joint `a` twice"),
        (one_message(&nameless.cdr(false)), "no message of /joint_states names a joint"),
        (one_message(&many_names), "0 are left: no sensor_msgs/JointState"),
        (one_message(&many_numbers), "34359738360 bytes are claimed at byte 24 where 0 are left"),
        (one_message(b"\0\x03\0\0"), "its encapsulation is 0003; plain CDR, 0000 or 0001, is read"),
        (one_message(b"\0\x01"), "4 bytes are claimed at byte 0 where 2 are left"),
        (
            one_chunk(u64::MAX, 0, "zstd", b"\x28\xb5\x2f\xfd"),
            "the chunk is damaged: it unfolds to more than 67118336 bytes",
        ),
        (one_chunk(100, 0, "zstd", b"no zstd"), "the chunk is damaged: it cannot be unpacked"),
        (one_chunk(100, 0, "lz4", b"no lz4"), "the chunk is damaged: it does not unpack to the 100 bytes it claims"),
        (
            one_chunk(100, 0, "bz2", b""),
            "a chunk is compressed with `bz2`; zstd, lz4 and none are read: recompress the file with `mcap compress`",
        ),
        (
            one_chunk(9, 0, "", &[5, 255, 255, 255, 255, 255, 255, 255, 255]),
            "the chunk is damaged: it ends within a record; `mcap recover` saves the others",
        ),
        (one_chunk(18, 0, "", &[0; 18]), "the chunk is damaged: it holds records of the opcode 0"),
        (one_chunk(9, 1, "", &[9, 0, 0, 0, 0, 0, 0, 0, 0]), "instead of 00000001; `mcap recover` saves the others"),
        (
            [&plain[..middle], &[plain[middle] ^ 1], &plain[middle + 1..]].concat(),
            "record at byte 41: the chunk is damaged: its checksum is",
        ),
        (compressed[..300].to_vec(), "the recording has no topic at all; "),
        (compressed[..300].to_vec(), "is cut short: whole up to byte 41 of 300"),
        (replaced(recording(None, 60, ALL).finish(), b"\x01\0\0\0\0\0", b"\x07"), "a message of undeclared channel 7"),
        (b"SQLite format 3\0 and so on".to_vec(), "this is no rosbag2 in sqlite3 that can be read: "),
        (
            b"#ROSBAG V2.0\n\0\0\0\0".to_vec(),
            "this is a bag of ROS 1, which is not read; convert it: `mcap convert in.bag out.mcap`",
        ),
        (b"\x28\xb5\x2f\xfd\0\0\0\0".to_vec(), "the compressed stream cannot be unpacked"),
        (b"\x89MCAP1\r\n\0\0".to_vec(), "this is a binary file"),
        // Broken Parquet files, each with the expected error message.
        (whole[..whole.len() / 2].to_vec(), "does not end with PAR1: it is cut short, or its writer was never closed"),
        (long_index, "the index claims 4294967295 bytes of a file of"),
        (b"PARE and more PARE".to_vec(), "the file is encrypted"),
        (parquet(|k| text(k, 1), PLAIN), "column `q1`: `text (BYTE_ARRAY)` is not a number"),
        (parquet(|_| Some(Values::Text(80)), PLAIN), "no column holds numbers; the columns are: t, q1, tau1"),
        (
            parquet(|_| None, lzo),
            "column `t`: it is compressed with LZO; write it with snappy, zstd, gzip, brotli, lz4 or uncompressed",
        ),
        (parquet(|_| Some(Values::Double(vec![])), PLAIN), "the file has no row; the columns are: t, q1, tau1"),
        (parquet(|k| (k == 2).then(|| Values::Double(vec![None; 80])), snappy), "column `tau1` holds no number at all"),
        (b"PAR1\x15\x02\x19\xfc\xff\xff\xff\xff\x0f\x09\0\0\0PAR1".to_vec(), "the metadata claim 4294967295 elements"),
    ]
}

#[test]
fn every_broken_container_has_its_message() {
    tests::register_wings();
    let folder = folder("broken-containers");
    let path = folder.join("broken.csv");
    let wheels = wheels("a");
    let mut faults = Vec::new();
    for (bytes, expected) in broken_containers() {
        std::fs::write(&path, bytes).unwrap();
        let found = message(&wheels, &path);
        if !found.contains(expected) {
            faults.push(format!("expected: {expected}\nfound: {found}"));
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    // The files that were damaged for this test can be read before the damage.
    for whole in [recording(Some("zstd"), 80, ALL).finish(), parquet(|_| None, PLAIN)] {
        std::fs::write(&path, whole).unwrap();
        assert!(message(&wheels, &path).starts_with("no error"));
    }
    for (named, expected) in [
        ("broken.csv#/joint_states", "only a recording (MCAP, rosbag2) has topics; name the file alone"),
        ("", "no file of this directory is a recording; a log, or a rosbag2 with MCAP or sqlite3 files, is expected"),
        ("nothing.mcap#/joint_states", "there is no such file"),
    ] {
        let found = message(&wheels, &folder.join(named));
        assert!(found.contains(expected), "expected: {expected}\nfound: {found}");
    }
    std::fs::write(&path, recording(None, 80, ALL).finish()).unwrap();
    let found = message(&wheels, &folder.join("broken.csv#/arm"));
    assert!(found.contains("no topic `/arm` carries joint states; the topics are: /joint_states"), "{found}");
}

#[test]
fn mutilated_containers_do_not_panic() {
    let mut wholes: Vec<Vec<u8>> = [None, Some(""), Some("zstd"), Some("lz4")]
        .map(|chunked| {
            let mut file = recording(chunked, 60, ALL);
            file.checked = false; // a checksum would keep the damage from what is behind it
            file.finish()
        })
        .into();
    for codec in [0, 1, 2, 6, 7] {
        for (version, dictionary) in [(1, false), (1, true), (2, false), (2, true)] {
            wholes.push(parquet(|_| None, Pages { codec, version, dictionary, rows_a_group: 50 }));
        }
    }
    for other in ["pyarrow.parquet", "polars.parquet", "pyarrow_brotli.parquet", "pyarrow_lz4.parquet"] {
        wholes.push(std::fs::read(crate::log_formats::foreign().join(other)).unwrap());
    }
    let row = |i: usize| format!("{{\"t\": {}, \"q\": [{i}, 2.5e-1], \"s\": {{\"tau\": -{i}}}}}", 0.01 * i as f64);
    let rows: Vec<String> = (0..60).map(row).collect();
    wholes.extend([rows.join("\n"), format!("[{}]", rows.join(",\n"))].map(String::into_bytes));
    for whole in wholes {
        assert!(Table::from_bytes("log", &whole).is_ok());
        let mut refused = 0;
        for k in 0..3000 {
            let mut bytes = whole.clone();
            let at = (k * 7919) % bytes.len();
            match k % 4 {
                0 => bytes.truncate(at),
                1 => bytes[at] = 0xff,
                2 => bytes[at] ^= 1 << (k / 4 % 8),
                _ => bytes[at] = (k * 31 % 256) as u8,
            }
            refused += usize::from(Table::from_bytes("log", &bytes).is_err());
        }
        assert!(refused > 300, "{refused}");
    }
}

#[test]
fn mutilated_logs_do_not_panic() {
    let row = |i: usize| format!("{},{},{}\n", 0.01 * i as f64, (0.05 * i as f64).sin(), (0.05 * i as f64).cos());
    let whole: String = std::iter::once("t,q1,tau1\n".to_string()).chain((0..80).map(row)).collect();
    let wheels = wheels("a");
    let folder = folder("mutilated-logs");
    let path = folder.join("log.csv");
    for k in 0..120 {
        let mut bytes = whole.clone().into_bytes();
        let at = (k * 7919) % bytes.len();
        if k % 2 == 0 {
            bytes.truncate(at);
        } else {
            bytes[at] = (k * 31 % 256) as u8;
        }
        std::fs::write(&path, bytes).unwrap();
        let _ = message(&wheels, &path);
    }
}
