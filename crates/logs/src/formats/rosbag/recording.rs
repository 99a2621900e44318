//! Reads the messages of a ROS recording as a table: an MCAP file, the folder of a rosbag2, or a format of another package.
//!
//! Joint states are read if there are any. Messages of another type become columns with the paths of their fields, by the
//! definition in the recording. If several topics are possible, the user must name one: `log.mcap#/arm/joint_states`. The parts
//! in a folder are read in the order of their numbers, and may have different formats. A part that is compressed as a whole
//! (`.db3.zstd`) is decompressed in memory.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use gate::budget::Budget;
use gate::source::{self, Source};

use crate::Error;
use crate::formats::compression::{Compression, MAX_UNPACKED_BYTES};
use crate::formats::content::{FileFormat, MAGIC_BYTES};
use crate::formats::message::{Channel, Message, ReadOutcome};
use crate::formats::registered::LogReader;
use crate::formats::rosbag::cdr::Encoding;
use crate::formats::rosbag::joint_state::JointState;
use crate::formats::rosbag::joint_table::{CELL_BYTES, JointTable, clipped};
use crate::formats::rosbag::mcap;
use crate::formats::rosbag::message_table::MessageTable;
use crate::formats::rosbag::schema::Schema;
use crate::table::{MAX_FILE_BYTES, Table};

/// The names of the message type for joint states, in ROS 2 and ROS 1.
const JOINT_STATE_TYPES: [&str; 2] = ["sensor_msgs/msg/JointState", "sensor_msgs/JointState"];

/// Reads the recording at a path, with or without `#topic` at its end. `None` if the path is no recording.
pub(crate) fn read(path: &Path) -> Result<Option<Table>, Error> {
    let (place, topic) = address(path);
    let name = path.display().to_string();
    // Reading from a pipe would consume its data, so the first bytes are read only from regular files.
    let content = if place.is_file() { head(&place).unwrap_or(FileFormat::Text) } else { FileFormat::Text };
    if !place.is_dir() && !content.is_recording() {
        let message = "only a recording (MCAP, rosbag2) has topics; name the file alone";
        return if topic.is_some() { Err(Error::at(&name, 0, message)) } else { Ok(None) };
    }
    let files = if place.is_dir() { files(&place)? } else { vec![place.clone()] };
    let mut recording = Recording { wanted: topic, ..Recording::within(Budget::of(0)) };
    files.iter().try_for_each(|file| recording.add(file))?;
    if let Some(general) = recording.general().map_err(|e| Error::at(&name, 0, e))? {
        let mut again = Recording { general: Some(general), ..Recording::within(Budget::of(0)) };
        files.iter().try_for_each(|file| again.add(file))?;
        recording = again;
    }
    recording.table(&place.display().to_string(), &name).map(Some)
}

/// Reads a recording from memory. The memory of the results is bounded by `budget`.
pub(crate) fn from_bytes(file: &str, bytes: &[u8], budget: &Budget) -> Result<Table, Error> {
    let mut recording = Recording { wanted: None, ..Recording::within(budget.clone()) };
    recording.add_bytes(file, bytes)?;
    if let Some(general) = recording.general().map_err(|e| Error::at(file, 0, e))? {
        recording = Recording { general: Some(general), ..Recording::within(budget.clone()) };
        recording.add_bytes(file, bytes)?;
    }
    recording.table(file, file)
}

/// A topic with messages of any type, which are decoded by their definition.
struct General {
    topic: String,
    kind: String,
    messages: MessageTable,
}

/// Message types without signals, which occur in every ROS recording.
const NO_SIGNALS: [&str; 4] = ["rcl_interfaces/", "tf2_msgs/", "std_msgs/String", "rosgraph_msgs/"];

/// Splits a path into the path of the file and the topic after `#`. If a file has the whole text as its name, there is no topic.
fn address(path: &Path) -> (PathBuf, Option<String>) {
    let split = path.to_str().filter(|_| !path.exists()).and_then(|p| p.rsplit_once('#'));
    match split {
        Some((place, topic)) if Path::new(place).exists() => (place.into(), Some(topic.into())),
        _ => (path.into(), None),
    }
}

fn head(path: &Path) -> Result<FileFormat, Error> {
    let head = Source::open(path).and_then(|mut source| source.head(MAGIC_BYTES));
    Ok(FileFormat::of(&head.map_err(|e| unreadable(path, &e))?))
}

fn unreadable(path: &Path, e: &std::io::Error) -> Error {
    Error::at(&path.display().to_string(), 0, format!("cannot be read: {e}"))
}

/// The recordings in a folder, sorted by the number at the end of their names: _10 comes after _9.
fn files(directory: &Path) -> Result<Vec<PathBuf>, Error> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(directory).map_err(|e| unreadable(directory, &e))? {
        let path = entry.map_err(|e| unreadable(directory, &e))?.path();
        if !path.is_file() {
            continue;
        }
        // The first bytes are read without registering the file as an input.
        let head = source::glance(&path, MAGIC_BYTES);
        match FileFormat::of(&head.ok_or_else(|| unreadable(&path, &std::io::ErrorKind::Other.into()))?) {
            content if content.is_recording() => found.push(path),
            // If a decompressed part is next to the compressed part, as rosbag2 leaves it, only the decompressed part is read.
            FileFormat::Zstd if !path.with_extension("").exists() => found.push(path),
            content @ FileFormat::Foreign(_) => {
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
    /// Memory budget of the joint states.
    memory: Budget,
    /// Memory budget of decompressed bytes that are not kept.
    work: Budget,
    wanted: Option<String>,
    topics: BTreeMap<String, JointTable>,
    /// All topics with their message types.
    all: BTreeSet<(String, String)>,
    /// Message definitions of the topics without joint states.
    definitions: BTreeMap<String, (String, String)>,
    /// The topic that is read instead of joint states; `None` for joint states.
    general: Option<General>,
    notes: Vec<String>,
}

impl Recording {
    fn within(budget: Budget) -> Recording {
        Recording {
            memory: budget.clone(),
            work: budget,
            wanted: None,
            topics: BTreeMap::new(),
            all: BTreeSet::new(),
            definitions: BTreeMap::new(),
            general: None,
            notes: Vec::new(),
        }
    }

    /// Adds the bytes of a file to the memory budgets.
    fn grow(&mut self, bytes: u64) {
        let bytes = usize::try_from(bytes).unwrap_or(usize::MAX);
        self.memory.grow(bytes);
        self.work.grow(bytes);
    }

    fn add(&mut self, path: &Path) -> Result<(), Error> {
        let file = path.display().to_string();
        match head(path)? {
            FileFormat::Mcap => {
                let source = Source::open(path).map_err(|e| unreadable(path, &e))?;
                let length = source.length().unwrap_or(u64::MAX);
                self.grow(source.length().unwrap_or(0));
                self.take(&file, |_, work, each| mcap::read(std::io::BufReader::new(source), length, work, each))
            }
            FileFormat::Zstd => {
                let packed = source::read(path, MAX_FILE_BYTES).map_err(|e| unreadable(path, &e))?;
                self.grow(packed.len() as u64);
                let unpacked = Compression::Zstd.unpack_within(&packed, MAX_UNPACKED_BYTES);
                self.add_bytes(&file, &unpacked.map_err(|e| Error::at(&file, 0, e))?)
            }
            other => {
                let Some(LogReader::Recording { of_file, .. }) = other.reader() else {
                    let why = other.refusal().unwrap_or("the file changes while it is read".into());
                    return Err(Error::at(&file, 0, why));
                };
                self.grow(std::fs::metadata(path).map_err(|e| unreadable(path, &e))?.len());
                self.take(&file, |wanted, work, each| of_file(path, wanted, work, each))
            }
        }
    }

    fn add_bytes(&mut self, file: &str, bytes: &[u8]) -> Result<(), Error> {
        match FileFormat::of(bytes) {
            FileFormat::Mcap => self.take(file, |_, work, each| mcap::read(bytes, bytes.len() as u64, work, each)),
            other => match other.reader() {
                Some(LogReader::Recording { of_bytes, .. }) => {
                    self.take(file, |wanted, work, each| of_bytes(bytes, wanted, work, each))
                }
                _ => Err(Error::at(file, 0, other.refusal().unwrap_or("this is no recording".into()))),
            },
        }
    }

    /// Adds the messages of a file. `read`: reads the file; its arguments are a function that selects the channels, the memory
    /// budget, and the receiver of the messages.
    fn take(
        &mut self,
        file: &str,
        read: impl FnOnce(
            &dyn Fn(&Channel) -> bool,
            &mut Budget,
            &mut dyn FnMut(&Message) -> Result<(), String>,
        ) -> Result<ReadOutcome, String>,
    ) -> Result<(), Error> {
        let Recording { wanted, topics, memory, work, general, .. } = self;
        let taken = general.as_ref().map(|general| general.topic.clone());
        // If no general topic is chosen, the joint states are read: of the wanted topic, or of all topics.
        let meant = |channel: &Channel| match &taken {
            Some(topic) => *topic == channel.topic,
            None => {
                let is_wanted = wanted.as_ref().is_none_or(|w| *w == channel.topic);
                JOINT_STATE_TYPES.contains(&channel.schema.as_str()) && is_wanted
            }
        };
        // A message of the general topic is decoded by its definition.
        let mut each = |message: &Message| {
            let channel = message.channel;
            if !meant(channel) {
                return Ok(());
            }
            let encoding = Encoding::of(&channel.encoding)
                .ok_or_else(|| format!("it is written as `{}`; cdr and ros1 are read", channel.encoding))?;
            if let Some(general) = general {
                return general.messages.push(message.log_time, message.data, encoding, memory);
            }
            let state = JointState::decode(message.data, encoding)?;
            memory.draw(CELL_BYTES * JointTable::cells_of(&state))?;
            topics.entry(channel.topic.clone()).or_default().push(message.log_time, &state)
        };
        // All topics are stored, because the error message lists them if none can be read.
        let outcome = read(&meant, work, &mut each).map_err(|e| Error::at(file, 0, e))?;
        for Channel { topic, schema, definition, .. } in outcome.channels {
            let is_defined = |text: &str| !text.trim().is_empty() && !JOINT_STATE_TYPES.contains(&schema.as_str());
            if let Some(definition) = definition.filter(|(_, text)| is_defined(text)) {
                self.definitions.insert(topic.clone(), definition);
            }
            self.all.insert((topic, schema));
        }
        self.notes.extend(outcome.cut.map(|cut| format!("{file} {cut}")));
        Ok(())
    }

    /// The topic that is read by its definition, if no joint states are wanted. `None` if there are joint states, or if there is
    /// no such topic.
    ///
    /// Fails if the definition cannot be read.
    fn general(&self) -> Result<Option<General>, String> {
        let carries_states = |(topic, schema): &&(String, String)| {
            JOINT_STATE_TYPES.contains(&schema.as_str()) && self.wanted.as_ref().is_none_or(|w| w == topic)
        };
        if self.all.iter().any(|topic| carries_states(&topic)) {
            return Ok(None);
        }
        let may_be_meant = |(topic, schema): &&(String, String)| match &self.wanted {
            Some(wanted) => wanted == topic,
            None => !NO_SIGNALS.iter().any(|start| schema.replace("/msg/", "/").starts_with(start)),
        };
        let mut candidates =
            self.all.iter().filter(may_be_meant).filter_map(|t| Some((t, self.definitions.get(&t.0)?)));
        let (Some(((topic, kind), (encoding, text))), None) = (candidates.next(), candidates.next()) else {
            return Ok(None);
        };
        if encoding != "ros2msg" && encoding != "ros1msg" {
            return Err(format!(
                "the messages of {topic} are defined as `{encoding}`; ros2msg and ros1msg are read, and sensor_msgs/JointState"
            ));
        }
        let schema = Schema::of(kind, text).map_err(|e| format!("topic {topic}: {e}"))?;
        let (topic, kind) = (topic.clone(), kind.clone());
        Ok(Some(General { topic, kind, messages: MessageTable::new(schema) }))
    }

    fn table(mut self, place: &str, file: &str) -> Result<Table, Error> {
        let notes = std::mem::take(&mut self.notes);
        if let Some(General { topic, kind, messages }) = self.general {
            return messages.table(&topic, &kind, file, notes);
        }
        let found = self.one_topic(place).map_err(|message| [vec![message], notes.clone()].concat().join("; "));
        found.and_then(|(name, topic)| topic.table(&name, file, notes)).map_err(|message| Error::at(file, 0, message))
    }

    /// The topic that the user wants, or the only topic with joint states.
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
        // The only topic must name its joints.
        if let Some((name, topic)) = self.topics.pop_first() {
            return match topic.joints().is_empty() {
                true => Err(format!("no message of {name} names a joint; `name` of sensor_msgs/JointState is empty")),
                false => Ok((name, topic)),
            };
        }
        // No message was read. The error message gives the most probable reason.
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
        let others = clipped(others.collect::<Vec<_>>().join(", "));
        let remedy = match self.definitions.keys().next() {
            Some(first) => format!("; name one behind the file: '{place}#{first}'"),
            None => String::new(),
        };
        Err(format!("{what}; the topics are: {others}{remedy}"))
    }
}
