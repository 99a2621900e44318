//! Joint states of a ROS recording as a table: an MCAP file, a rosbag2 file in sqlite3, or the directory of a rosbag2.
//!
//! If a recording has several topics of joint states, it is refused until `log.mcap#/arm/joint_states` names one. The
//! parts of a directory are read in the order of their numbers, whatever their storage. A part packed as a whole
//! (`.db3.zstd`) is unpacked in memory.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use gate::budget::Budget;
use gate::source::{self, Source};

use crate::Error;
use crate::formats::compression::{Compression, MAX_UNPACKED_BYTES};
use crate::formats::content::{Content, MAGIC_BYTES};
use crate::formats::rosbag::joint_state::{Encoding, JointState};
use crate::formats::rosbag::joint_table::{JointTable, clipped};
#[cfg(feature = "mcap")]
use crate::formats::rosbag::mcap;
use crate::formats::rosbag::message::{Channel, Message, Outcome};
#[cfg(feature = "rosbag2-sqlite")]
use crate::formats::rosbag::sqlite;
use crate::table::{MAX_FILE_BYTES, Table};

/// The names of the message type with joint states.
const JOINT_STATE_TYPES: [&str; 2] = ["sensor_msgs/msg/JointState", "sensor_msgs/JointState"];

/// Reads the recording at a path, with `#topic` behind it or without; `None`: there is none.
pub(crate) fn read(path: &Path) -> Result<Option<Table>, Error> {
    let (place, topic) = address(path);
    let name = path.display().to_string();
    // Reading a pipe would consume it, so the first bytes are read from regular files only.
    let content = if place.is_file() { head(&place).unwrap_or(Content::Text) } else { Content::Text };
    if !place.is_dir() && !matches!(content, Content::Mcap | Content::Sqlite) {
        let message = "only a recording (MCAP, rosbag2) has topics; name the file alone";
        return if topic.is_some() { Err(Error::at(&name, 0, message)) } else { Ok(None) };
    }
    let mut recording = Recording { wanted: topic, ..Recording::within(Budget::of(0)) };
    for file in if place.is_dir() { files(&place)? } else { vec![place.clone()] } {
        recording.add(&file)?;
    }
    recording.table(&place.display().to_string(), &name).map(Some)
}

/// Reads the content of an MCAP or a sqlite3 file within a budget.
pub(crate) fn from_bytes(file: &str, bytes: &[u8], budget: &Budget) -> Result<Table, Error> {
    let mut recording = Recording { wanted: None, ..Recording::within(budget.clone()) };
    recording.add_bytes(file, bytes)?;
    recording.table(file, file)
}

/// The path and the topic behind it. A file that is called like the whole text takes precedence.
fn address(path: &Path) -> (PathBuf, Option<String>) {
    let split = path.to_str().filter(|_| !path.exists()).and_then(|p| p.rsplit_once('#'));
    match split {
        Some((place, topic)) if Path::new(place).exists() => (place.into(), Some(topic.into())),
        _ => (path.into(), None),
    }
}

fn head(path: &Path) -> Result<Content, Error> {
    let head = Source::open(path).and_then(|mut source| source.head(MAGIC_BYTES));
    Ok(Content::of(&head.map_err(|e| unreadable(path, &e))?))
}

fn unreadable(path: &Path, e: &std::io::Error) -> Error {
    Error::at(&path.display().to_string(), 0, format!("cannot be read: {e}"))
}

/// The recordings of a directory, by the number their names end with: _10 comes behind _9.
fn files(directory: &Path) -> Result<Vec<PathBuf>, Error> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(directory).map_err(|e| unreadable(directory, &e))? {
        let path = entry.map_err(|e| unreadable(directory, &e))?.path();
        if !path.is_file() {
            continue;
        }
        match head(&path)? {
            Content::Mcap | Content::Sqlite => found.push(path),
            // rosbag2 leaves an unpacked part beside the packed one.
            Content::Zstd if !path.with_extension("").exists() => found.push(path),
            content @ Content::Bag => {
                let why = content.refusal().unwrap_or_default();
                return Err(Error::at(&path.display().to_string(), 0, why));
            }
            _ => {}
        }
    }
    if found.is_empty() {
        let message = "no file of this directory is a recording; a log, or a rosbag2 with MCAP or sqlite3 files, is \
                       expected";
        return Err(Error::at(&directory.display().to_string(), 0, message));
    }
    let key = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let stem = name.split('.').next().unwrap_or_default();
        let letters = stem.trim_end_matches(|c: char| c.is_ascii_digit()).to_string();
        (letters.clone(), stem[letters.len()..].parse::<u64>().unwrap_or(0), name)
    };
    found.sort_by_key(key);
    Ok(found)
}

struct Recording {
    /// For the joint states.
    memory: Budget,
    /// For what is unpacked on the way to them.
    work: Budget,
    wanted: Option<String>,
    topics: BTreeMap<String, JointTable>,
    /// Every topic with its type.
    all: BTreeSet<(String, String)>,
    notes: Vec<String>,
}

/// Bytes of a number of a message: it and its row, in arrays that grow by doubling.
const CELL_BYTES: usize = 2 * (size_of::<f64>() + size_of::<u32>());

impl Recording {
    fn within(budget: Budget) -> Recording {
        let (topics, all, notes) = (BTreeMap::new(), BTreeSet::new(), Vec::new());
        Recording { memory: budget.clone(), work: budget, wanted: None, topics, all, notes }
    }

    /// A file of so many bytes follows.
    fn grow(&mut self, bytes: u64) {
        let bytes = usize::try_from(bytes).unwrap_or(usize::MAX);
        self.memory.grow(bytes);
        self.work.grow(bytes);
    }

    fn add(&mut self, path: &Path) -> Result<(), Error> {
        let file = path.display().to_string();
        match head(path)? {
            #[cfg(feature = "mcap")]
            Content::Mcap => {
                let source = Source::open(path).map_err(|e| unreadable(path, &e))?;
                let length = source.length().unwrap_or(u64::MAX);
                self.grow(source.length().unwrap_or(0));
                self.take(&file, |_, work, each| mcap::read(std::io::BufReader::new(source), length, work, each))
            }
            #[cfg(feature = "rosbag2-sqlite")]
            Content::Sqlite => {
                self.grow(std::fs::metadata(path).map_err(|e| unreadable(path, &e))?.len());
                self.take(&file, |wanted, work, each| sqlite::read(&sqlite::open(path)?, wanted, work, each))
            }
            Content::Zstd => {
                let packed = source::read(path, MAX_FILE_BYTES).map_err(|e| unreadable(path, &e))?;
                self.grow(packed.len() as u64);
                let unpacked = Compression::Zstd.unpack_within(&packed, MAX_UNPACKED_BYTES);
                self.add_bytes(&file, &unpacked.map_err(|e| Error::at(&file, 0, e))?)
            }
            other => Err(Error::at(&file, 0, other.refusal().unwrap_or("the file changes while it is read".into()))),
        }
    }

    fn add_bytes(&mut self, file: &str, bytes: &[u8]) -> Result<(), Error> {
        match Content::of(bytes) {
            #[cfg(feature = "mcap")]
            Content::Mcap => self.take(file, |_, work, each| mcap::read(bytes, bytes.len() as u64, work, each)),
            #[cfg(feature = "rosbag2-sqlite")]
            Content::Sqlite => {
                self.take(file, |wanted, work, each| sqlite::read(&sqlite::of_bytes(bytes)?, wanted, work, each))
            }
            other => Err(Error::at(file, 0, other.refusal().unwrap_or("this is no recording".into()))),
        }
    }

    /// Takes in what `read` hands over of a file, given which channels are wanted.
    fn take(
        &mut self,
        file: &str,
        read: impl FnOnce(
            &dyn Fn(&Channel) -> bool,
            &mut Budget,
            &mut dyn FnMut(&Message) -> Result<(), String>,
        ) -> Result<Outcome, String>,
    ) -> Result<(), Error> {
        let Recording { wanted, topics, memory, work, .. } = self;
        let meant = |channel: &Channel| {
            JOINT_STATE_TYPES.contains(&channel.schema.as_str()) && wanted.as_ref().is_none_or(|w| *w == channel.topic)
        };
        let mut each = |message: &Message| {
            let channel = message.channel;
            if !meant(channel) {
                return Ok(());
            }
            let encoding = Encoding::of(&channel.encoding)
                .ok_or_else(|| format!("it is written as `{}`; cdr and ros1 are read", channel.encoding))?;
            let state = JointState::decode(message.data, encoding)?;
            memory.draw(CELL_BYTES * JointTable::cells_of(&state))?;
            topics.entry(channel.topic.clone()).or_default().push(message.log_time, &state)
        };
        let outcome = read(&meant, work, &mut each).map_err(|e| Error::at(file, 0, e))?;
        self.all.extend(outcome.channels.into_iter().map(|c| (c.topic, c.schema)));
        self.notes.extend(outcome.cut.map(|cut| format!("{file} {cut}")));
        Ok(())
    }

    fn table(mut self, place: &str, file: &str) -> Result<Table, Error> {
        let notes = std::mem::take(&mut self.notes);
        let found = self.one_topic(place).map_err(|message| [vec![message], notes.clone()].concat().join("; "));
        found.and_then(|(name, topic)| topic.table(&name, file, notes)).map_err(|message| Error::at(file, 0, message))
    }

    /// The topic that is meant: the wanted one, or the only one.
    fn one_topic(&mut self, place: &str) -> Result<(String, JointTable), String> {
        if self.topics.len() > 1 {
            let topics = self
                .topics
                .iter()
                .map(|(name, topic)| format!("{name} ({} messages; {})", topic.messages(), topic.joints().join(" ")));
            let topics = clipped(topics.collect::<Vec<_>>().join(", "));
            let (n, first) = (self.topics.len(), self.topics.keys().next().map_or("", String::as_str));
            return Err(format!(
                "{n} topics carry joint states: {topics}; say which behind the name: '{place}#{first}'"
            ));
        }
        // The only topic must name joints.
        if let Some((name, topic)) = self.topics.pop_first() {
            return match topic.joints().is_empty() {
                true => Err(format!("no message of {name} names a joint; `name` of sensor_msgs/JointState is empty")),
                false => Ok((name, topic)),
            };
        }
        // Nothing was read: say why, from the nearest cause to the farthest.
        let meant = |topic: &str| self.wanted.as_ref().is_none_or(|w| w == topic);
        let silent =
            self.all.iter().find(|(topic, schema)| JOINT_STATE_TYPES.contains(&schema.as_str()) && meant(topic));
        if let Some((topic, _)) = silent {
            return Err(format!("no message is in the recording on the topic of joint states, {topic}"));
        }
        let what = match &self.wanted {
            Some(wanted) => format!("no topic `{wanted}` carries joint states"),
            None => format!("no topic carries {}", JOINT_STATE_TYPES[0]),
        };
        if self.all.is_empty() {
            return Err(format!("{what}; the recording has no topic at all"));
        }
        let others = self.all.iter().map(|(topic, schema)| format!("{topic} ({schema})"));
        Err(format!("{what}; the topics are: {}", clipped(others.collect::<Vec<_>>().join(", "))))
    }
}
