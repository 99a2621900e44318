//! Reads rosbag2 in sqlite3: complete, truncated and damaged files, and files of a recorder that was killed.

#![cfg(feature = "rosbag2-sqlite")]

use std::path::{Path, PathBuf};

use logs::Table;
use rusqlite::Connection;

const ROWS: i64 = 1200;
/// Time of the first message, ns. It is not a whole number of seconds.
const START: i64 = 1_760_000_000_123_456_789;
const STEP: i64 = 5_000_000;

/// Message r with the joints a and b. Every second message has them in the order b, a.
fn joint_state(r: i64) -> Vec<u8> {
    let mut body = Vec::new();
    let u32s = |body: &mut Vec<u8>, x: u32| {
        body.resize(body.len().next_multiple_of(4), 0);
        body.extend(x.to_le_bytes());
    };
    let text = |body: &mut Vec<u8>, x: &str| {
        u32s(body, x.len() as u32 + 1);
        body.extend(x.as_bytes());
        body.push(0);
    };
    let stamp = START + STEP * r;
    u32s(&mut body, (stamp / 1_000_000_000) as u32);
    u32s(&mut body, (stamp % 1_000_000_000) as u32);
    text(&mut body, "base");
    let order = if r % 2 == 1 { [1, 0] } else { [0, 1] };
    u32s(&mut body, 2);
    order.iter().for_each(|&j| text(&mut body, ["a", "b"][j]));
    for quantity in 0..3 {
        u32s(&mut body, 2);
        for j in order {
            body.resize(body.len().next_multiple_of(8), 0);
            body.extend(value(quantity, j, r).to_le_bytes());
        }
    }
    [vec![0, 1, 0, 0], body].concat()
}

fn value(quantity: usize, joint: usize, r: i64) -> f64 {
    ((1 + quantity) as f64 * r as f64).sin() + joint as f64
}

const TABLES: &str = "
    CREATE TABLE schema(schema_version INTEGER PRIMARY KEY, ros_distro TEXT NOT NULL);
    CREATE TABLE metadata(id INTEGER PRIMARY KEY, metadata_version INTEGER NOT NULL, metadata TEXT NOT NULL);
    CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL,
        serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL, type_description_hash TEXT NOT NULL);
    CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL,
        data BLOB NOT NULL);
    CREATE INDEX timestamp_idx ON messages (timestamp ASC);
    INSERT INTO topics VALUES(1, '/tf', 'tf2_msgs/msg/TFMessage', 'cdr', '', '');
    INSERT INTO topics VALUES(2, '/joint_states', 'sensor_msgs/msg/JointState', 'cdr', '', '');";

/// Reads a file as a table.
fn read(file: &Path) -> Result<Table, logs::Error> {
    rist::wings::register(vec![foreign::wing()]);
    Table::read(file)
}

/// Reads a file in memory as a table.
fn from_bytes(bytes: &[u8]) -> Result<Table, logs::Error> {
    rist::wings::register(vec![foreign::wing()]);
    Table::from_bytes("log", bytes)
}

/// Inserts the messages of these rows. Before each of them, it inserts a message of another topic. `packed`: compressed messages.
fn record(database: &Connection, rows: std::ops::Range<i64>, packed: bool) {
    let mut insert = database.prepare("INSERT INTO messages(topic_id, timestamp, data) VALUES(?, ?, ?)").unwrap();
    for r in rows {
        insert.execute((1, START + STEP * r, vec![7u8; 30])).unwrap();
        let mut data = joint_state(r);
        if packed {
            data = ruzstd::encoding::compress_to_vec(&data[..], ruzstd::encoding::CompressionLevel::Fastest);
        }
        insert.execute((2, START + STEP * r, data)).unwrap();
    }
}

fn write(path: &Path, rows: std::ops::Range<i64>, packed: bool) {
    let database = Connection::open(path).unwrap();
    database.execute_batch(TABLES).unwrap();
    database.execute_batch("BEGIN").unwrap();
    record(&database, rows, packed);
    database.execute_batch("COMMIT").unwrap();
}

fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("rist-rosbag2-{name}-{}", std::process::id()));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

fn assert_rows(table: &Table, rows: usize) {
    let header =
        ["time", "position_a", "position_b", "velocity_a", "velocity_b", "effort_a", "effort_b"].map(String::from);
    assert_eq!((&table.header[..], table.rows()), (&header[..], rows));
    for r in 0..rows {
        assert_eq!(table.columns[0][r], (STEP * r as i64) as f64 / 1e9);
        for (quantity, joint) in [(0, 0), (0, 1), (1, 0), (1, 1), (2, 0), (2, 1)] {
            assert_eq!(table.columns[1 + 2 * quantity + joint][r], value(quantity, joint, r as i64));
        }
    }
}

/// Messages of some hundred bytes that decompress to 16 MiB each. The file is refused, because the bytes that may be decompressed
/// are limited in proportion to its size.
#[test]
fn messages_that_unfold_without_end_are_refused() {
    let folder = folder("unfolds");
    let file = folder.join("bomb_0.db3");
    let database = Connection::open(&file).unwrap();
    database.execute_batch(TABLES).unwrap();
    let mut message = joint_state(0);
    message.resize(16 << 20, 0);
    let level = ruzstd::encoding::CompressionLevel::Fastest;
    let packed = ruzstd::encoding::compress_to_vec(&message[..], level);
    for r in 0..20 {
        database
            .execute("INSERT INTO messages(topic_id, timestamp, data) VALUES(2, ?, ?)", (START + STEP * r, &packed))
            .unwrap();
    }
    drop(database);
    let refused = read(&file).unwrap_err().to_string();
    assert!(refused.contains("64 times the file"), "{refused}");
    std::fs::remove_dir_all(folder).unwrap();
}

/// A file, a folder with parts, a compressed part, compressed messages, and bytes in memory all give the same table.
#[test]
fn a_bag_is_a_table() {
    let folder = folder("whole");
    let file = folder.join("walk_0.db3");
    write(&file, 0..ROWS, false);
    let table = read(&file).unwrap();
    assert_eq!(table.notes, ["topic /joint_states; time from header.stamp"]);
    assert_rows(&table, ROWS as usize);
    let bytes = std::fs::read(&file).unwrap();
    assert_rows(&from_bytes(&bytes).unwrap(), ROWS as usize);
    let named = PathBuf::from(format!("{}#/joint_states", file.display()));
    assert_rows(&read(&named).unwrap(), ROWS as usize);

    let parts = folder.join("parts");
    std::fs::create_dir(&parts).unwrap();
    std::fs::write(parts.join("metadata.yaml"), "rosbag2_bagfile_information: {storage_identifier: sqlite3}\n")
        .unwrap();
    for part in 0..12 {
        write(&parts.join(format!("walk_{part}.db3")), 100 * part..100 * (part + 1), part % 3 == 1);
    }
    // This part is compressed as a whole file (`compression_mode: FILE`).
    let packed = parts.join("walk_11.db3");
    let bytes = std::fs::read(&packed).unwrap();
    let zstd = ruzstd::encoding::compress_to_vec(&bytes[..], ruzstd::encoding::CompressionLevel::Fastest);
    std::fs::write(parts.join("walk_11.db3.zstd"), zstd).unwrap();
    assert_rows(&read(&parts).unwrap(), ROWS as usize);
    std::fs::remove_file(packed).unwrap();
    assert_rows(&read(&parts).unwrap(), ROWS as usize);
    std::fs::remove_dir_all(&folder).unwrap();
}

/// A file that is truncated after its schema gives the rows before the cut, and a note.
#[test]
fn a_file_cut_short_is_read_up_to_the_cut() {
    let folder = folder("cut");
    let file = folder.join("walk_0.db3");
    write(&file, 0..ROWS, false);
    let whole = std::fs::read(&file).unwrap();
    let mut before = ROWS as usize + 1;
    for tenths in [9, 7, 5, 3] {
        let bytes = &whole[..whole.len() * tenths / 10 + 1234];
        std::fs::write(&file, bytes).unwrap();
        for table in [read(&file).unwrap(), from_bytes(bytes).unwrap()] {
            let rows = table.rows();
            assert_rows(&table, rows);
            assert!(rows > 0 && rows <= before, "{tenths}: {rows} of {before}");
            let told = table.notes.iter().any(|n| n.contains("is cut short or damaged: the "));
            assert_eq!(told, rows < ROWS as usize, "{tenths}: {rows} {:?}", table.notes);
            before = rows;
        }
    }
    assert!(before < ROWS as usize / 2, "{before}");
    std::fs::remove_dir_all(&folder).unwrap();
}

/// If a byte is changed, the file is read, read with a note, or refused; reading never panics.
#[test]
fn damage_does_not_panic() {
    let folder = folder("damaged");
    let file = folder.join("walk_0.db3");
    write(&file, 0..60, false);
    let whole = std::fs::read(&file).unwrap();
    let (mut refused, mut told) = (0, 0);
    for at in (0..whole.len()).step_by(97) {
        for change in [0xff, 0x00, whole[at] ^ 1] {
            let mut bytes = whole.clone();
            bytes[at] = change;
            match from_bytes(&bytes) {
                Ok(table) => told += usize::from(table.notes.len() > 1),
                Err(_) => refused += 1,
            }
        }
        let _ = from_bytes(&whole[..at]);
    }
    assert!(refused > 5 && told > 0, "{refused} {told}");
    std::fs::remove_dir_all(&folder).unwrap();
}

/// If a recorder is killed, its committed rows are in a write-ahead log. The log is read and not changed.
#[test]
fn what_a_killed_recorder_left_in_its_write_ahead_log() {
    let folder = folder("wal");
    let (file, copy) = (folder.join("live.db3"), folder.join("bag").join("walk_0.db3"));
    let database = Connection::open(&file).unwrap();
    database.execute_batch("PRAGMA journal_mode=WAL; PRAGMA wal_autocheckpoint=0;").unwrap();
    database.execute_batch(TABLES).unwrap();
    record(&database, 0..100, false);
    database.execute_batch("PRAGMA wal_checkpoint(TRUNCATE)").unwrap();
    record(&database, 100..200, false);
    std::fs::create_dir(folder.join("bag")).unwrap();
    std::fs::copy(&file, &copy).unwrap();
    let log = copy.with_file_name("walk_0.db3-wal");
    std::fs::copy(folder.join("live.db3-wal"), &log).unwrap();
    drop(database);
    let (bytes, logged) = (std::fs::read(&copy).unwrap(), std::fs::read(&log).unwrap());
    assert!(!logged.is_empty());
    assert_rows(&read(&folder.join("bag")).unwrap(), 200);
    // No file was changed, and no file was added to the folder.
    assert_eq!((std::fs::read(&copy).unwrap(), std::fs::read(&log).unwrap()), (bytes, logged.clone()));
    assert_eq!(std::fs::read_dir(folder.join("bag")).unwrap().count(), 2);
    // If the log is truncated within a transaction, only the transactions before it are read.
    std::fs::write(&log, &logged[..logged.len() * 2 / 3]).unwrap();
    let table = read(&copy).unwrap();
    assert!(table.rows() > 100 && table.rows() < 200, "{}", table.rows());
    std::fs::remove_file(&log).unwrap();
    assert_rows(&read(&copy).unwrap(), 100);
    std::fs::remove_dir_all(&folder).unwrap();
}

/// If a recorder is killed while it changes the file itself, the error message says what to do.
#[test]
fn a_change_half_written_is_told() {
    let folder = folder("journal");
    let (file, copy) = (folder.join("live.db3"), folder.join("walk_0.db3"));
    write(&file, 0..300, false);
    let database = Connection::open(&file).unwrap();
    // With a small cache, SQLite writes changed pages to the file before the commit.
    database.execute_batch("PRAGMA cache_size=4; BEGIN; UPDATE messages SET timestamp = timestamp + 1").unwrap();
    std::fs::copy(&file, &copy).unwrap();
    std::fs::copy(folder.join("live.db3-journal"), folder.join("walk_0.db3-journal")).unwrap();
    drop(database);
    let message = read(&copy).unwrap_err().to_string();
    assert!(message.contains("killed in the middle of writing"), "{message}");
    std::fs::remove_dir_all(&folder).unwrap();
}

/// A database from an unknown source cannot execute code.
#[test]
fn tables_that_are_none_are_refused() {
    let folder = folder("strangers");
    let file = folder.join("odd.db3");
    for (schema, expected) in [
        ("CREATE TABLE t(x)", "this SQLite file has no table `topics` of a rosbag2"),
        (
            "CREATE TABLE topics(id, name, type, serialization_format);
             CREATE VIEW messages AS WITH RECURSIVE n(id) AS (SELECT 1 UNION ALL SELECT id + 1 FROM n)
                 SELECT id, 1 AS topic_id, id AS timestamp, x'00' AS data FROM n",
            "has no table `messages`",
        ),
        (
            "CREATE TABLE topics(id, name, type, serialization_format);
             CREATE TABLE messages(id, topic_id, timestamp, data AS (zeroblob(1000000000)))",
            "has no table `messages`",
        ),
        (
            "CREATE TABLE topics(id, name, type, serialization_format);
             CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id, timestamp, data)",
            "the recording has no topic at all",
        ),
    ] {
        let _ = std::fs::remove_file(&file);
        Connection::open(&file).unwrap().execute_batch(schema).unwrap();
        let message = read(&file).unwrap_err().to_string();
        assert!(message.contains(expected), "{message}");
    }
    std::fs::remove_dir_all(&folder).unwrap();
}
