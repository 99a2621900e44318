//! Tests that the same signals in each log format give the same table, bit for bit, and the same estimate.

use std::path::PathBuf;

use identification::estimate::identify::identify;
use identification::estimate::options::Options;
use linear_model::regressor::Regressor;
use logs::{Log, LogSource, Table};
use tests::program::folder;
use tests::register_wings;

use crate::broken_logs::wheels;
use crate::log_files::parquet::{PLAIN, Pages, Values, doubles, file};
use crate::log_files::{Mcap, State, csv, npz};

const ROWS: usize = 700;
/// Time of the first row, ns since 1970. It is not a whole second.
const START: i64 = 1_760_000_000_123_456_789;
const STEP: i64 = 5_000_000;
const COLUMNS: [&str; 7] = ["time", "position_a", "position_b", "velocity_a", "velocity_b", "effort_a", "effort_b"];

/// Signals of two independent joints ("wheels") with 2 and 0.5 kg m^2. Their positions are sums of sines.
fn signals() -> Vec<(String, Vec<f64>)> {
    let t: Vec<f64> = (0..ROWS as i64).map(|r| (STEP * r) as f64 / 1e9).collect();
    let of = |f: &dyn Fn(f64) -> f64| t.iter().map(|&t| f(t)).collect::<Vec<f64>>();
    let (a, b) = (3.0, 5.0);
    let series = [
        t.clone(),
        of(&|t| (a * t).sin()),
        of(&|t| (b * t).cos()),
        of(&|t| a * (a * t).cos()),
        of(&|t| -b * (b * t).sin()),
        of(&|t| -2.0 * a * a * (a * t).sin()),
        of(&|t| -0.5 * b * b * (b * t).cos()),
    ];
    COLUMNS.iter().map(|c| c.to_string()).zip(series).collect()
}

/// Row r as a message of joint states. Odd rows name the joints in reverse order.
pub(crate) fn state(signals: &[(String, Vec<f64>)], r: usize) -> State {
    let stamp = START + STEP * r as i64;
    let order = if r % 2 == 1 { [1, 0] } else { [0, 1] };
    let arrays = [1, 3, 5].map(|k| order.map(|j| signals[k + j].1[r]).to_vec());
    let stamp = ((stamp / 1_000_000_000) as u32, (stamp % 1_000_000_000) as u32);
    State { stamp, names: order.map(|j| ["a", "b"][j]).to_vec(), arrays }
}

fn recording(
    signals: &[(String, Vec<f64>)],
    chunked: Option<&'static str>,
    encoding: &str,
    big_endian: bool,
) -> Vec<u8> {
    let mut file = Mcap::joint_states(chunked, encoding);
    for r in 0..ROWS {
        let state = state(signals, r);
        let data = if encoding == "ros1" { state.ros1() } else { state.cdr(big_endian) };
        file.message(1, START as u64 + 17, &data);
    }
    file.finish()
}

fn files(signals: &[(String, Vec<f64>)]) -> Vec<(String, Vec<u8>)> {
    let mut files = vec![("csv".to_string(), csv(signals)), ("npz".into(), npz(signals))];
    for chunked in [None, Some(""), Some("zstd"), Some("lz4")] {
        for (encoding, big_endian) in [("cdr", false), ("cdr", true), ("ros1", false)] {
            let name = format!("mcap {chunked:?} {encoding} {big_endian}");
            files.push((name, recording(signals, chunked, encoding, big_endian)));
        }
    }
    for codec in [0, 1, 2, 6, 7] {
        for (version, dictionary) in [(1, false), (1, true), (2, false), (2, true)] {
            let pages = Pages { codec, version, dictionary, rows_a_group: 300 };
            files.push((format!("{pages:?}"), file(&doubles(signals), pages)));
        }
    }
    let mut stamped = doubles(signals);
    stamped[0].1 = Values::Timestamp((0..ROWS as i64).map(|r| START + STEP * r).collect());
    files.push(("parquet, timestamps".into(), file(&stamped, PLAIN)));
    stamped[0].0 = "time_ns".into();
    files.push(("parquet, timestamps of a named unit".into(), file(&stamped, PLAIN)));
    files
}

fn assert_same(name: &str, found: &Table, expected: &Table) {
    assert_eq!((&found.header, &found.texts), (&expected.header, &expected.texts), "{name}");
    let bits = |t: &Table| t.columns.iter().map(|c| c.iter().map(|x| x.to_bits()).collect()).collect::<Vec<Vec<u64>>>();
    assert!(bits(found) == bits(expected), "{name}: other numbers");
}

/// Folder of logs from other programs; foreign_logs/README.md lists the programs.
pub(crate) fn foreign() -> PathBuf {
    tests::workspace().join("tests/tests/identification/foreign_logs")
}

#[test]
fn every_format_gives_the_same_table_and_estimate() {
    register_wings();
    let signals = signals();
    let expected = Table::from_bytes("log", &csv(&signals)).unwrap();
    assert_eq!((expected.header.as_slice(), expected.rows()), (&COLUMNS.map(String::from)[..], ROWS));
    assert!(expected.texts.iter().all(Option::is_none));
    let folder = folder("formats");
    // The file name has no extension, so the reader must recognise the format from the content.
    let path = folder.join("log");
    let wheels = wheels("a b");
    let mut estimates = Vec::new();
    let files = files(&signals);
    for (name, bytes) in &files {
        assert_same(name, &Table::from_bytes("log", bytes).unwrap(), &expected);
        std::fs::write(&path, bytes).unwrap();
        assert_same(name, &Table::read(&path).unwrap(), &expected);
        let (log, _) = Log::read(&path, wheels.coordinates(), &Default::default()).unwrap();
        let estimate = identify(&wheels, &log, &Options { friction: vec![], ..Options::default() }).unwrap();
        estimates.push(estimate.to_yaml().unwrap());
    }
    assert_eq!(files.len(), 2 + 12 + 20 + 2);
    assert!(estimates.iter().all(|e| *e == estimates[0]), "{}", estimates[0]);
    assert!(estimates[0].contains("ZZ1") && estimates[0].contains("ZZ2"), "{}", estimates[0]);
}

#[test]
fn files_of_other_programs() {
    register_wings();
    let folder = foreign();
    let read = |name: &str| Table::read(&folder.join(name)).unwrap();
    // The signals are powers of two times the row number, so every number is exact in every format.
    let rows: Vec<f64> = (0..64).map(f64::from).collect();
    let scaled = |x: f64| rows.iter().map(|r| r * x).collect::<Vec<f64>>();
    let time: Vec<f64> = (0..64).map(|r| f64::from(4 * r) / 1e3).collect();

    for name in ["ros2.mcap", "rosbags.db3.zstd"] {
        let table = read(name);
        assert_eq!(table.header, COLUMNS, "{name}");
        let expected = [time.clone(), scaled(0.5), scaled(-0.25), scaled(2.0), scaled(4.0), scaled(8.0), scaled(-16.0)];
        assert_eq!(table.columns, expected, "{name}");
        assert_eq!(table.notes, ["topic /joint_states; time from header.stamp"], "{name}");
    }

    let table = read("scipy.mat");
    assert_eq!(table.header, ["t", "q_1", "q_2", "dq_1", "dq_2", "tau_1", "tau_2"]);
    let expected = [time.clone(), scaled(0.5), scaled(-0.25), scaled(2.0), scaled(4.0), scaled(8.0), scaled(-16.0)];
    assert_eq!(table.columns, expected);

    for (name, nulls) in [("pyarrow.parquet", true), ("polars.parquet", false)] {
        let table = read(name);
        assert_eq!(table.header, ["time", "q_1", "q_2", "tau_1", "tau_2", "count", "mode"], "{name}");
        let expected = [time.clone(), scaled(0.5), scaled(-0.25), scaled(8.0), scaled(-16.0)];
        for (k, expected) in expected.iter().enumerate() {
            let same = |(r, (x, y)): (usize, (&f64, &f64))| if nulls && r == 5 && k > 2 { x.is_nan() } else { x == y };
            assert!(table.columns[k].iter().zip(expected).enumerate().all(same), "{name} {}", table.header[k]);
        }
        assert_eq!(table.columns[5], scaled(1.0), "{name}");
        assert_eq!(table.texts[6], Some((0, "text (BYTE_ARRAY)".into())), "{name}");
    }

    for name in ["pyarrow_lz4.feather", "pyarrow_zstd.arrows", "polars.arrow", "polars_lz4.arrow", "polars.arrows"] {
        let nulls = name.starts_with("pyarrow");
        let table = read(name);
        assert_eq!(table.header, ["time", "q_1", "q_2", "tau_1", "tau_2", "count", "mode"], "{name}");
        let expected = [time.clone(), scaled(0.5), scaled(-0.25), scaled(8.0), scaled(-16.0), scaled(1.0)];
        for (k, expected) in expected.iter().enumerate() {
            let is_null = |r: usize| nulls && r == 5 && matches!(k, 3 | 4);
            let same = |(r, (x, y)): (usize, (&f64, &f64))| if is_null(r) { x.is_nan() } else { x == y };
            assert!(table.columns[k].iter().zip(expected).enumerate().all(same), "{name} {}", table.header[k]);
        }
        let (texts, notes) = (&table.texts[6], table.notes.join(" "));
        assert!(texts.as_ref().is_some_and(|(_, text)| text == "text"), "{name}: {texts:?}");
        assert_eq!(notes.contains("`time_ns` holds times"), nulls, "{name}: {notes}");
        // Reading from memory, reading only the first rows, and reading zstd-compressed bytes give the same table.
        let bytes = std::fs::read(folder.join(name)).unwrap();
        assert_same(name, &Table::from_bytes(name, &bytes).unwrap(), &table);
        assert_same(name, &Table::glance(&folder.join(name), 7).unwrap(), &part(&table, 7));
        let packed = ruzstd::encoding::compress_to_vec(&bytes[..], ruzstd::encoding::CompressionLevel::Fastest);
        assert_same(name, &Table::from_bytes(name, &packed).unwrap(), &table);
    }
}

fn part(table: &Table, rows: usize) -> Table {
    let columns = table.columns.iter().map(|column| column.iter().take(rows).copied().collect()).collect();
    Table { columns, ..table.clone() }
}

#[test]
fn kinds_of_arrow_columns() {
    register_wings();
    let folder = foreign();
    let table = Table::read(&folder.join("pyarrow_types.arrow")).unwrap();
    let steps = |x: f64| (0..64).map(|r| f64::from(r) * x).collect::<Vec<f64>>();
    let numbers = [
        ("time", (0..64).map(|r| f64::from(4 * r) / 1e3).collect()),
        ("joint.more.effort", steps(-0.25)),
        ("half", steps(0.5)),
        ("price", steps(0.25)),
        ("small", steps(-1.0)),
        ("big", (0..64).map(|r| 2f64.powi(63) + 2048.0 * f64::from(r)).collect()),
        ("day", steps(86_400.0)),
        ("count", steps(1.0)),
    ];
    let column = |name: &str| {
        let place = table.header.iter().position(|h| h == name).unwrap_or_else(|| panic!("{name}: {:?}", table.header));
        (&table.columns[place], table.texts[place].as_ref().map(|(_, text)| text.as_str()))
    };
    for (name, expected) in numbers {
        assert_eq!(column(name), (&expected, None), "{name}");
    }
    let (position, expected) = (column("joint.position").0, steps(0.5));
    assert!(position.iter().zip(&expected).enumerate().all(|(r, (x, y))| if r == 7 { x.is_nan() } else { x == y }));
    for (name, what) in [
        ("word", "words of a dictionary"),
        ("view", "text"),
        ("pairs", "a map"),
        ("ragged", "lists of 1 and of 2 numbers"),
        ("flag", "booleans"),
        ("none", "nothing"),
    ] {
        let (numbers, text) = column(name);
        assert_eq!(text, Some(what), "{name}");
        assert!(numbers.len() == 64 && numbers.iter().all(|x| x.is_nan()), "{name}");
    }
}

#[test]
fn damaged_arrow_is_read_or_refused() {
    register_wings();
    let folder = foreign();
    let mut refused = 0;
    for name in ["pyarrow_lz4.feather", "pyarrow_zstd.arrows", "pyarrow_types.arrow", "polars.arrow"] {
        let whole = std::fs::read(folder.join(name)).unwrap();
        for at in 16..whole.len() - 8 {
            let message = Table::from_bytes(name, &whole[..at]).map(drop).err().map(|e| e.to_string());
            // A stream that ends right after a record batch counts as complete.
            let may_end = name.ends_with("arrows") && message.is_none();
            assert!(
                may_end || message.as_ref().is_some_and(|m| m.contains("cut short") || m.contains("no row")),
                "{name} {at}: {message:?}"
            );
            let mut damaged = whole.clone();
            damaged[at] ^= (1 + at * 31 % 255) as u8;
            refused += usize::from(Table::from_bytes(name, &damaged).is_err());
        }
    }
    // The format has no checksum, so the reader cannot detect a damaged number. So not all damaged files are refused.
    assert!(refused > 2000, "{refused}");
}

/// Parquet files of another program, with codecs, encodings and number types that the files written by these tests do not have.
#[test]
fn kinds_of_parquet_numbers_of_another_program() {
    let folder = foreign();
    let steps = |x: f64| (0..64).map(|r| f64::from(r) * x).collect::<Vec<f64>>();
    let time: Vec<f64> = (0..64).map(|r| f64::from(4 * r) / 1e3).collect();
    for codec in ["brotli", "gzip", "lz4", "zstd"] {
        let table = Table::read(&folder.join(format!("pyarrow_{codec}.parquet"))).unwrap();
        assert_eq!(table.header, ["time", "q_1", "q_2", "half", "price", "small", "day", "count"], "{codec}");
        let series = [time.clone(), steps(0.5), steps(-0.25), steps(0.5), steps(0.25), steps(-0.25), steps(86_400.0)];
        for (k, expected) in series.iter().chain([&steps(1.0)]).enumerate() {
            assert_eq!(table.columns[k], *expected, "{codec} {}", table.header[k]);
        }
        assert!(table.texts.iter().all(Option::is_none), "{codec}");
    }
}

/// Messages of one topic may differ: some lack a joint or the gripper, and the velocity is never measured.
#[test]
fn messages_may_differ() {
    let mut file = Mcap::joint_states(Some("zstd"), "cdr");
    for r in 0..60u32 {
        let x = f64::from(r);
        let (names, arrays) = match r % 3 {
            0 => (vec!["a", "grip"], [vec![x, 9.0], vec![], vec![-x, 0.0]]),
            1 => (vec!["a"], [vec![x], vec![f64::NAN], vec![-x]]),
            _ => (vec!["grip"], [vec![9.0], vec![], vec![]]),
        };
        // The time stamp is zero, so the reader takes the time of the recorder.
        file.message(1, 5_000_000_000 + 1_000_000 * u64::from(r), &State { stamp: (0, 0), names, arrays }.cdr(false));
    }
    let table = Table::from_bytes("log.mcap", &file.finish()).unwrap();
    assert_eq!(table.header, ["time", "position_a", "position_grip", "effort_a", "effort_grip"]);
    for r in 0..60 {
        let (x, here) = (r as f64, r % 3 != 2);
        assert_eq!(table.columns[0][r], x / 1e3);
        assert!(if here { table.columns[1][r] == x } else { table.columns[1][r].is_nan() }, "{r}");
        assert!(if here { table.columns[3][r] == -x } else { table.columns[3][r].is_nan() }, "{r}");
        assert_eq!(table.columns[4][r].is_nan(), r % 3 != 0, "{r}");
    }
    let clock = "topic /joint_states; time from the recorder's clock, for every header.stamp is zero";
    assert_eq!(table.notes, [clock, "no velocity of a, grip"]);
}

/// The files of a recording are joined in the order of their numbers, so _10 comes after _9. Other files in the folder are
/// ignored.
#[test]
fn a_directory_is_one_recording() {
    register_wings();
    let signals = signals();
    let folder = folder("rosbag2");
    std::fs::write(folder.join("metadata.yaml"), "rosbag2_bagfile_information: {}\n").unwrap();
    for part in 0..14 {
        let mut file = Mcap::joint_states(Some("lz4"), "cdr");
        for r in 50 * part..50 * (part + 1) {
            file.message(1, 0, &state(&signals, r).cdr(false));
        }
        std::fs::write(folder.join(format!("walk_{part}.mcap")), file.finish()).unwrap();
    }
    let table = Table::read(&folder).unwrap();
    assert_same("directory", &table, &Table::from_bytes("log", &csv(&signals)).unwrap());
}

/// An MCAP file that was not finished: the complete messages are read, and a note says that the file is cut short.
#[test]
fn a_recording_cut_short() {
    let signals = signals();
    let whole = recording(&signals, Some("zstd"), "cdr", false);
    let expected = Table::from_bytes("log", &csv(&signals)).unwrap();
    let mut lengths = Vec::new();
    for cut in [whole.len() - 20, whole.len() * 2 / 3, whole.len() / 2] {
        let table = Table::from_bytes("log.mcap", &whole[..cut]).unwrap();
        let n = table.rows();
        assert!(table.columns.iter().zip(&expected.columns).all(|(c, e)| *c == e[..n]), "{cut}");
        let told = table.notes.iter().any(|n| n.contains("log.mcap is cut short: whole up to byte"));
        assert_eq!(told, n < ROWS, "{:?}", table.notes);
        lengths.push(n);
    }
    assert!(lengths[0] == ROWS && ROWS > lengths[1] && lengths[1] > lengths[2] && lengths[2] > 0, "{lengths:?}");
}

#[test]
fn one_of_several_topics_by_its_name() {
    let folder = folder("topics");
    let path = folder.join("two.mcap");
    let mut file = Mcap::joint_states(None, "cdr");
    file.channel(2, "/left/joint_states", "sensor_msgs/msg/JointState", "cdr");
    for r in 0..60u32 {
        for channel in [1, 2] {
            let arrays = [vec![f64::from(channel)], vec![], vec![f64::from(r)]];
            let state = State { stamp: (1, 10_000_000 * r), names: vec!["a"], arrays };
            file.message(channel as u16, 0, &state.cdr(false));
        }
    }
    std::fs::write(&path, file.finish()).unwrap();
    for (topic, position) in [("/joint_states", 1.0), ("/left/joint_states", 2.0)] {
        let named = PathBuf::from(format!("{}#{topic}", path.display()));
        let table = Table::read(&named).unwrap();
        assert_eq!((table.rows(), table.columns[1][0]), (60, position));
        assert_eq!(table.file, named.display().to_string());
        let (log, columns) = LogSource::open(&named, &["a".into()], &Default::default()).unwrap();
        assert_eq!((log.name(), columns.notes.len()), (table.file, 2));
    }
}

/// Column types: doubles with nulls, single precision, integers, and text, whose numbers are NaN.
#[test]
fn kinds_of_parquet_columns() {
    let columns = [
        ("q".to_string(), Values::Double((0..50).map(|i| (i % 3 != 0).then_some(f64::from(i))).collect())),
        ("f".into(), Values::Float((0..50).map(|i| 0.1 * i as f32).collect())),
        ("n".into(), Values::Int64((0..50).map(|i| -(1 << 40) * i).collect())),
        ("mode".into(), Values::Text(50)),
    ];
    for (codec, version, dictionary) in [(0, 1, false), (1, 1, true), (6, 2, false), (7, 2, true)] {
        let pages = Pages { codec, version, dictionary, rows_a_group: 20 };
        let table = Table::from_bytes("log", &file(&columns[..3], pages)).unwrap();
        for r in 0..50 {
            let (q, x) = (table.columns[0][r], r as f64);
            assert!(if r % 3 == 0 { q.is_nan() } else { q == x }, "{pages:?} {r} {q}");
            assert_eq!(table.columns[1][r], f64::from(0.1 * r as f32), "{pages:?}");
            assert_eq!(table.columns[2][r], -((1i64 << 40) as f64) * x, "{pages:?}");
        }
    }
    let table = Table::from_bytes("log", &file(&columns, PLAIN)).unwrap();
    assert!(table.texts[3].is_some() && table.columns[3].len() == 50 && table.columns[3].iter().all(|x| x.is_nan()));
}
