//! Reads the messages of a rosbag2 in sqlite3 (.db3), in the order of recording.
//!
//! The tables are `topics(id, name, type, serialization_format)` and `messages(id, topic_id, timestamp, data)`, as
//! rosbag2_storage_sqlite3 writes them. The file is opened only for reading, and no other file is written. If a recorder was
//! stopped before its write-ahead log (a second file with the newest rows) was merged into the file, this log is read too. A
//! truncated or damaged file is read up to the first missing page.
//!
//! Files may come from untrusted sources. Therefore views, triggers and functions in the schema are disabled, a table with
//! computed columns is refused, and messages longer than [`MAX_MESSAGE_BYTES`] are refused.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::io::Read;
use std::path::{Path, PathBuf};

use gate::budget::Budget;
use rusqlite::config::DbConfig;
use rusqlite::ffi::SQLITE_READONLY_ROLLBACK;
use rusqlite::limits::Limit;
use rusqlite::{Connection, OpenFlags};

use logs::reading::Compression;
use logs::reading::{Channel, Message, ReadOutcome, Receiver, WantedChannels};

/// Largest size of one message, bytes. A message with 500 joints has 30 000 bytes.
const MAX_MESSAGE_BYTES: i32 = 1 << 24;

/// The first bytes of a zstd stream.
const ZSTD_MAGIC: &[u8] = b"\x28\xb5\x2f\xfd";

/// SQLite file access without locks. Nothing is written, so files in a read-only folder can be opened too.
const LOCKLESS_FILE_SYSTEM: &str = if cfg!(windows) { "win32-none" } else { "unix-none" };

/// Opens a database file. No other program may write to it at the same time.
fn open(path: &Path) -> Result<Connection, String> {
    let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX;
    let opened = if ["-wal", "-journal"].iter().any(|end| journal_path(path, end).exists()) {
        Connection::open_with_flags_and_vfs(path, flags, LOCKLESS_FILE_SYSTEM)
    } else {
        // For a file in write-ahead mode, SQLite would create an empty log file next to it, even for reading. The flag
        // `immutable` prevents this.
        let uri = immutable(path);
        Connection::open_with_flags_and_vfs(uri, flags | OpenFlags::SQLITE_OPEN_URI, LOCKLESS_FILE_SYSTEM)
    };
    opened.map_err(|e| refused(&e))
}

/// The path of a companion file of SQLite (`-wal`, `-journal`). If `path` is a symbolic link, the companion is next to its
/// target.
fn journal_path(path: &Path, end: &str) -> PathBuf {
    let mut name = path.canonicalize().unwrap_or_else(|_| path.to_owned()).into_os_string();
    name.push(end);
    name.into()
}

/// A URI that tells SQLite that the file does not change. <https://www.sqlite.org/uri.html>
fn immutable(path: &Path) -> OsString {
    // An absolute path of Windows begins with a letter and a colon. A URI for such a path begins with three slashes.
    let drive = if path.as_os_str().as_encoded_bytes().get(1) == Some(&b':') { "///" } else { "" };
    let mut uri = format!("file:{drive}");
    for &byte in path.as_os_str().as_encoded_bytes() {
        match byte {
            b'/' | b':' | b'.' | b'-' | b'_' => uri.push(char::from(byte)),
            b'\\' if cfg!(windows) => uri.push('/'),
            byte if byte.is_ascii_alphanumeric() => uri.push(char::from(byte)),
            byte => uri += &format!("%{byte:02X}"),
        }
    }
    (uri + "?immutable=1").into()
}

/// Opens a database whose content is in memory.
fn of_bytes(bytes: &[u8]) -> Result<Connection, String> {
    // A database in memory has no write-ahead log. So the bytes that give the mode of the file (18 and 19) are set to 1, the mode
    // without such a log.
    let (head, rest) = bytes.split_at(bytes.len().min(20));
    let head: Vec<u8> = head.iter().enumerate().map(|(at, b)| if at < 18 { *b } else { 1 }).collect();
    let mut database = Connection::open_in_memory().map_err(|e| refused(&e))?;
    let image = database.deserialize_read_exact("main", head.as_slice().chain(rest), bytes.len(), true);
    image.map_err(|e| refused(&e))?;
    Ok(database)
}

fn refused(e: &rusqlite::Error) -> String {
    let half_written = e.sqlite_error().is_some_and(|e| e.extended_code == SQLITE_READONLY_ROLLBACK);
    if half_written {
        return "its recorder was killed in the middle of writing: the file ending in -journal beside it takes that back; \
                on a copy of both, run `sqlite3 FILE .tables` once"
            .into();
    }
    format!("this is no rosbag2 in sqlite3 that can be read: {e}; `sqlite3 FILE .recover` may save what is in it")
}

/// Reads the messages of a file on disk; see [`read`].
pub(crate) fn read_file(
    path: &Path,
    wanted: &WantedChannels,
    work: &mut Budget,
    each: &mut Receiver,
) -> Result<ReadOutcome, String> {
    read(&open(path)?, wanted, work, each)
}

/// Reads the messages of a file in memory; see [`read`].
pub(crate) fn read_bytes(
    bytes: &[u8],
    wanted: &WantedChannels,
    work: &mut Budget,
    each: &mut Receiver,
) -> Result<ReadOutcome, String> {
    read(&of_bytes(bytes)?, wanted, work, each)
}

/// Passes the messages of the `wanted` channels to `each`. Decompressed bytes are taken from the budget `work`.
///
/// Fails if the tables of a rosbag2 are missing. If messages are damaged, it does not fail, but [`ReadOutcome`] reports the
/// damage.
fn read(
    database: &Connection,
    wanted: &WantedChannels,
    work: &mut Budget,
    each: &mut Receiver,
) -> Result<ReadOutcome, String> {
    guard(database).map_err(|e| refused(&e))?;
    for table in ["topics", "messages"] {
        // Views, virtual tables and computed columns would execute code from the file, so they are refused.
        if !is_plain(database, table).map_err(|e| refused(&e))? {
            return Err(format!("this SQLite file has no table `{table}` of a rosbag2"));
        }
    }
    let channels = channels(database).map_err(|e| refused(&e))?;
    let asked: Vec<String> = channels.iter().filter(|(_, c)| wanted(c)).map(|(id, _)| id.to_string()).collect();
    // All rows are selected, also rows of other topics. If a page of the file is missing, SQLite returns empty rows. Such rows
    // are found only if all rows are selected.
    let query = format!(
        "SELECT rowid, topic_id, timestamp, CASE WHEN topic_id IN ({}) THEN data END FROM messages NOT INDEXED ORDER BY \
         rowid",
        asked.join(",")
    );
    let mut outcome = ReadOutcome { channels: channels.values().cloned().collect(), cut: None };
    let mut statement = database.prepare(&query).map_err(|e| refused(&e))?;
    let mut rows = statement.query([]).map_err(|e| refused(&e))?;
    let (mut count, mut last) = (0u64, i64::MIN);
    let damage = loop {
        let row = match rows.next() {
            Ok(Some(row)) => row,
            Ok(None) => return Ok(outcome),
            Err(e) => break e.to_string(),
        };
        let head = || -> rusqlite::Result<(i64, i64, i64)> { Ok((row.get(0)?, row.get(1)?, row.get(2)?)) };
        let (id, topic, log_time) = match head() {
            Ok(head) if head.0 > last => head,
            Ok((id, ..)) => break format!("row {id} behind row {last}"),
            Err(e) => break e.to_string(),
        };
        last = id;
        let Some(channel) = channels.get(&topic).filter(|channel| wanted(channel)) else { continue };
        let data = match row.get_ref(3).and_then(|data| Ok(data.as_blob()?)) {
            Ok(data) => data,
            Err(e) => break e.to_string(),
        };
        let at = |e: String| format!("message {id} of {}: {e}", channel.topic);
        // A single message may be compressed. An uncompressed message is never mistaken for a compressed one, because CDR (the
        // format of messages) begins with 00 00 or 00 01.
        let unpacked;
        let data = if data.starts_with(ZSTD_MAGIC) {
            unpacked = Compression::Zstd.unpack_within(data, MAX_MESSAGE_BYTES as usize).map_err(at)?;
            work.draw(unpacked.len()).map_err(at)?;
            &unpacked
        } else {
            data
        };
        each(&Message { channel, log_time, data }).map_err(at)?;
        count += 1;
    };
    let read = format!("the {count} messages of joint states before the damage are read");
    outcome.cut = Some(format!("is cut short or damaged: {read}; SQLite says: {damage}"));
    Ok(outcome)
}

/// Disables features of SQLite that are dangerous for a file from an unknown source, or that would write to it.
fn guard(database: &Connection) -> rusqlite::Result<()> {
    for (option, on) in [
        (DbConfig::SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, true),
        (DbConfig::SQLITE_DBCONFIG_TRUSTED_SCHEMA, false),
        (DbConfig::SQLITE_DBCONFIG_ENABLE_VIEW, false),
        (DbConfig::SQLITE_DBCONFIG_ENABLE_TRIGGER, false),
        // Without this option, SQLite refuses the whole file if it has fewer pages than its header states.
        (DbConfig::SQLITE_DBCONFIG_WRITABLE_SCHEMA, true),
    ] {
        database.set_db_config(option, on)?;
    }
    database.set_limit(Limit::SQLITE_LIMIT_LENGTH, MAX_MESSAGE_BYTES)?;
    // The index of a write-ahead log is kept in memory instead of a file.
    database.pragma_update(None, "locking_mode", "EXCLUSIVE")
}

fn channels(database: &Connection) -> rusqlite::Result<BTreeMap<i64, Channel>> {
    let definitions = definitions(database).unwrap_or_default();
    let mut statement = database.prepare("SELECT id, name, type, serialization_format FROM topics LIMIT 10000")?;
    let channel = |row: &rusqlite::Row| {
        let schema: String = row.get(2)?;
        let definition = definitions.get(&schema).cloned();
        Ok((row.get(0)?, Channel { topic: row.get(1)?, schema, encoding: row.get(3)?, definition }))
    };
    statement.query_map([], channel)?.collect()
}

/// The definitions of message types, which newer recorders store: for each type, its encoding and its definition.
fn definitions(database: &Connection) -> rusqlite::Result<BTreeMap<String, (String, String)>> {
    if !is_plain(database, "message_definitions")? {
        return Ok(BTreeMap::new());
    }
    let query = "SELECT topic_type, encoding, encoded_message_definition FROM message_definitions LIMIT 10000";
    let mut statement = database.prepare(query)?;
    statement.query_map([], |row| Ok((row.get(0)?, (row.get(1)?, row.get(2)?))))?.collect()
}

/// Whether a table with this name exists and has no computed columns.
fn is_plain(database: &Connection, table: &str) -> rusqlite::Result<bool> {
    let plain = "SELECT count(*) FROM sqlite_schema WHERE name = ?1 AND type = 'table' AND rootpage > 0";
    let computed = "SELECT count(*) FROM pragma_table_xinfo(?1) WHERE hidden > 0";
    let count = |query: &str| database.query_row(query, [table], |row| row.get::<_, i64>(0));
    Ok(count(plain)? == 1 && count(computed)? == 0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A bag in write-ahead mode with one topic. `name`: file name, which may have special characters.
    fn recorder(folder: &Path, name: &str) -> (Connection, PathBuf) {
        let path = folder.join(name);
        let recorder = Connection::open(&path).unwrap();
        recorder
            .execute_batch(
                "PRAGMA journal_mode = WAL;
                 CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT);
                 CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB);
                 INSERT INTO topics VALUES (1, '/joint_states', 'T', 'cdr');",
            )
            .unwrap();
        (recorder, path)
    }

    /// Creates an empty temporary folder.
    fn folder(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("rist-bag-{name}-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(&folder).unwrap();
        folder
    }

    fn files(folder: &Path) -> Vec<String> {
        let mut names: Vec<String> =
            folder.read_dir().unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    fn topics(path: &Path) -> usize {
        let database = open(path).unwrap();
        read(&database, &|_| true, &mut Budget::of(1 << 20), &mut |_| Ok(())).unwrap().channels.len()
    }

    #[test]
    fn nothing_stays_beside_a_file_that_is_read() {
        let folder = folder("plain");
        for name in ["bag.db3", "a?b#c %20 é.db3"] {
            let (recorder, path) = recorder(&folder, name);
            drop(recorder);
            let before = files(&folder);
            assert_eq!(topics(&path), 1);
            assert_eq!(files(&folder), before);
        }
    }

    #[test]
    fn a_write_ahead_log_left_behind_is_read() {
        let (live, killed) = (folder("live"), folder("killed"));
        let (_recorder, path) = recorder(&live, "bag.db3");
        // The recorder is still open, so its log is not merged into the file. A copy of both files is what a killed recorder
        // would leave.
        for name in ["bag.db3", "bag.db3-wal"] {
            std::fs::copy(live.join(name), killed.join(name)).unwrap();
        }
        assert!(path.with_file_name("bag.db3-wal").metadata().unwrap().len() > 0);
        assert_eq!(topics(&killed.join("bag.db3")), 1);
        assert_eq!(files(&killed), ["bag.db3", "bag.db3-wal"]);
    }
}
