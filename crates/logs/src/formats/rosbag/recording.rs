//! Joint states of a ROS recording as a table: an MCAP file, or the directory of a rosbag2.
//!
//! A message is a row: `time`, then `position_<joint>`, `velocity_<joint>` and `effort_<joint>` of
//! every joint that was ever named. Messages may name other joints or order them otherwise; what a
//! message does not hold is NaN. Time counts from the first message (s): nanoseconds since 1970 have more
//! digits than a number keeps.
//!
//! Several topics of joint states are refused; `log.mcap#/arm/joint_states` says which one is meant.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{BufReader, Read};
use std::path::{Path, PathBuf};

use crate::Error;
use crate::formats::rosbag::joint_state::{Encoding, JointState};
use crate::formats::rosbag::mcap;
use crate::formats::rosbag::mcap::Message;
use crate::table::Table;

const TYPES: [&str; 2] = ["sensor_msgs/msg/JointState", "sensor_msgs/JointState"];
const QUANTITIES: [&str; 3] = ["position", "velocity", "effort"];

/// More joints than this are not one robot.
const MAX_JOINTS: usize = 500;

/// Reads the recording at a path, with `#topic` behind it or without; `None`: there is none.
pub fn read(path: &Path) -> Option<Result<Table, Error>> {
    let (place, topic) = address(path);
    let recording = || -> Result<Option<Table>, Error> {
        let name = path.display().to_string();
        // What is read from a pipe is gone: only files are looked into.
        let is_recording = place.is_file() && matches!(head(&place), Ok(head) if head.starts_with(mcap::MAGIC));
        if !place.is_dir() && !is_recording {
            let message = "only a recording (MCAP) has topics; name the file alone";
            return if topic.is_some() { Err(Error::at(&name, 0, message)) } else { Ok(None) };
        }
        let mut recording = Recording { wanted: topic.clone(), ..Recording::default() };
        for file in if place.is_dir() { files(&place)? } else { vec![place.clone()] } {
            let shown = file.display().to_string();
            let failed = |e: std::io::Error| Error::at(&shown, 0, format!("cannot be read: {e}"));
            let source = std::fs::File::open(&file).map_err(failed)?;
            let length = source.metadata().map_err(failed)?.len();
            recording.add(&shown, BufReader::new(source), length)?;
        }
        recording.table(&place.display().to_string(), &name).map(Some)
    };
    recording().transpose()
}

/// Reads the content of an MCAP file.
pub fn from_bytes(file: &str, bytes: &[u8]) -> Result<Table, Error> {
    let mut recording = Recording::default();
    recording.add(file, bytes, bytes.len() as u64)?;
    recording.table(file, file)
}

/// Why a recording of another kind is not read, and how to make one that is.
pub fn refusal(bytes: &[u8]) -> Option<&'static str> {
    if bytes.starts_with(b"SQLite format 3\0") {
        return Some(
            "this is a rosbag2 in sqlite3, which is not read; convert its directory to MCAP: `ros2 bag convert -i DIR \
             -o out.yaml` with `output_bags: [{uri: new, storage_id: mcap, all_topics: true}]` in out.yaml",
        );
    }
    if bytes.starts_with(b"#ROSBAG V") {
        return Some("this is a bag of ROS 1, which is not read; convert it: `mcap convert in.bag out.mcap`");
    }
    bytes.starts_with(b"\x28\xb5\x2f\xfd").then_some("this is a zstd stream; unpack it first: `zstd -d FILE`")
}

/// The path and the topic behind it; a file of the whole name goes first.
fn address(path: &Path) -> (PathBuf, Option<String>) {
    let split = path.to_str().filter(|_| !path.exists()).and_then(|p| p.rsplit_once('#'));
    match split {
        Some((place, topic)) if Path::new(place).exists() => (place.into(), Some(topic.into())),
        _ => (path.into(), None),
    }
}

fn head(path: &Path) -> std::io::Result<Vec<u8>> {
    let mut head = Vec::new();
    std::fs::File::open(path)?.take(16).read_to_end(&mut head)?;
    Ok(head)
}

/// The MCAP files of a directory, by the number their names end with: _10 comes behind _9.
fn files(directory: &Path) -> Result<Vec<PathBuf>, Error> {
    let failed = |e: std::io::Error| Error::at(&directory.display().to_string(), 0, format!("cannot be read: {e}"));
    let mut found = Vec::new();
    for entry in std::fs::read_dir(directory).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        if !path.is_file() {
            continue;
        }
        let head = head(&path).map_err(failed)?;
        if head.starts_with(mcap::MAGIC) {
            found.push(path);
        } else if let Some(why) = refusal(&head) {
            return Err(Error::at(&path.display().to_string(), 0, why));
        }
    }
    if found.is_empty() {
        let message = "no file of this directory is a recording; a log, or a rosbag2 with MCAP files, is expected";
        return Err(Error::at(&directory.display().to_string(), 0, message));
    }
    let key = |path: &PathBuf| {
        let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let name = stem.trim_end_matches(|c: char| c.is_ascii_digit()).to_string();
        let number = stem[name.len()..].parse::<u64>().unwrap_or(0);
        (name, number, stem)
    };
    found.sort_by_key(key);
    Ok(found)
}

#[derive(Default)]
struct Recording {
    wanted: Option<String>,
    topics: BTreeMap<String, Topic>,
    /// Every topic with its type.
    all: BTreeSet<(String, String)>,
    notes: Vec<String>,
}

/// The messages of one topic.
#[derive(Default)]
struct Topic {
    /// ns, of the header and of the recorder.
    stamps: Vec<i64>,
    log_times: Vec<u64>,
    /// In the order of their first naming.
    joints: Vec<String>,
    places: BTreeMap<String, usize>,
    /// For every joint the series of the three quantities, as long as it was last seen.
    series: Vec<[Vec<f64>; 3]>,
    uneven: usize,
}

impl Recording {
    fn add(&mut self, file: &str, source: impl Read, length: u64) -> Result<(), Error> {
        let Recording { wanted, topics, .. } = self;
        let mut each = |message: &Message| {
            let channel = message.channel;
            if !TYPES.contains(&channel.schema.as_str()) || wanted.as_ref().is_some_and(|w| *w != channel.topic) {
                return Ok(());
            }
            let encoding = Encoding::of(&channel.encoding)
                .ok_or_else(|| format!("it is written as `{}`; cdr and ros1 are read", channel.encoding))?;
            let state = JointState::decode(message.data, encoding)?;
            topics.entry(channel.topic.clone()).or_default().push(message.log_time, &state)
        };
        let outcome = mcap::read(source, length, &mut each).map_err(|e| Error::at(file, 0, e))?;
        self.all.extend(outcome.channels.into_iter().map(|c| (c.topic, c.schema)));
        if let Some(at) = outcome.cut_at {
            self.notes
                .push(format!("{file} is cut short: whole up to byte {at} of {length}; what is behind is not read"));
        }
        Ok(())
    }

    fn table(mut self, place: &str, file: &str) -> Result<Table, Error> {
        match self.one_topic(place) {
            Ok((name, topic)) => Ok(topic.table(&name, file, self.notes)),
            Err(message) => Err(Error::at(file, 0, [vec![message], self.notes].concat().join("; "))),
        }
    }

    /// The topic that is meant: the wanted one, or the only one.
    fn one_topic(&mut self, place: &str) -> Result<(String, Topic), String> {
        if self.topics.len() > 1 {
            let topics = self
                .topics
                .iter()
                .map(|(name, topic)| format!("{name} ({} messages; {})", topic.stamps.len(), topic.joints.join(" ")));
            let topics = clipped(topics.collect::<Vec<_>>().join(", "));
            let (n, first) = (self.topics.len(), self.topics.keys().next().map_or("", String::as_str));
            return Err(format!(
                "{n} topics carry joint states: {topics}; say which behind the name: '{place}#{first}'"
            ));
        }
        if let Some((name, topic)) = self.topics.pop_first() {
            return match topic.joints.is_empty() {
                true => Err(format!("no message of {name} names a joint; `name` of sensor_msgs/JointState is empty")),
                false => Ok((name, topic)),
            };
        }
        let meant = |topic: &str| self.wanted.as_ref().is_none_or(|w| w == topic);
        let silent = self.all.iter().find(|(topic, schema)| TYPES.contains(&schema.as_str()) && meant(topic));
        if let Some((topic, _)) = silent {
            return Err(format!("no message is in the recording on the topic of joint states, {topic}"));
        }
        let what = match &self.wanted {
            Some(wanted) => format!("no topic `{wanted}` carries joint states"),
            None => format!("no topic carries {}", TYPES[0]),
        };
        if self.all.is_empty() {
            return Err(format!("{what}; the recording has no topic at all"));
        }
        let others = self.all.iter().map(|(topic, schema)| format!("{topic} ({schema})"));
        Err(format!("{what}; the topics are: {}", clipped(others.collect::<Vec<_>>().join(", "))))
    }
}

impl Topic {
    fn push(&mut self, log_time: u64, state: &JointState) -> Result<(), String> {
        let row = self.stamps.len();
        self.stamps.push(state.stamp);
        self.log_times.push(log_time);
        let arrays = [&state.position, &state.velocity, &state.effort];
        self.uneven += usize::from(arrays.iter().any(|a| !a.is_empty() && a.len() != state.names.len()));
        let mut seen = BTreeSet::new();
        for (k, name) in state.names.iter().enumerate() {
            if !seen.insert(*name) {
                return Err(format!("it names joint `{name}` twice"));
            }
            let joint = match self.places.get(*name) {
                Some(joint) => *joint,
                None => self.new_joint(name)?,
            };
            for (series, array) in self.series[joint].iter_mut().zip(arrays) {
                if array.len() == state.names.len() {
                    series.resize(row, f64::NAN);
                    series.push(array[k]);
                }
            }
        }
        Ok(())
    }

    fn new_joint(&mut self, name: &str) -> Result<usize, String> {
        let joint = self.joints.len();
        if joint == MAX_JOINTS {
            return Err(format!("it names joint {}; at most {MAX_JOINTS} are expected", joint + 1));
        }
        self.joints.push(name.into());
        self.places.insert(name.into(), joint);
        self.series.push(Default::default());
        Ok(joint)
    }

    fn table(mut self, name: &str, file: &str, notes: Vec<String>) -> Table {
        let rows = self.stamps.len();
        let stamped = self.stamps.iter().any(|&s| s != 0);
        // The difference is taken in whole numbers and divided once: the nearest number to its decimals.
        let log_times = self.log_times.iter().map(|&t| i128::from(t));
        let times: Vec<i128> =
            if stamped { self.stamps.iter().map(|&t| i128::from(t)).collect() } else { log_times.collect() };
        // A driver's first messages may be without a stamp.
        let first = times.iter().copied().find(|&t| t != 0).unwrap_or(0);
        let time: Vec<f64> = times.iter().map(|t| (t - first) as f64 / 1e9).collect();
        let clock = if stamped { "header.stamp" } else { "the recorder's clock, for every header.stamp is zero" };
        let mut table = Table { file: file.into(), notes, ..Table::default() };
        table.notes.insert(0, format!("topic {name}; time from {clock}"));
        table.header.push("time".into());
        table.columns.push(time);
        for (k, quantity) in QUANTITIES.iter().enumerate() {
            let mut without = Vec::new();
            for (joint, series) in self.joints.iter().zip(&mut self.series) {
                let mut series = std::mem::take(&mut series[k]);
                // Controllers fill what they do not measure with NaN.
                if series.iter().all(|x| x.is_nan()) {
                    without.push(joint.as_str());
                    continue;
                }
                series.resize(rows, f64::NAN);
                table.header.push(format!("{quantity}_{joint}"));
                table.columns.push(series);
            }
            if !without.is_empty() {
                table.notes.push(format!("no {quantity} of {}", clipped(without.join(", "))));
            }
        }
        if self.uneven > 0 {
            let message = "messages with an array that is neither empty nor as long as `name`: it is not used";
            table.notes.push(format!("{} {message}", self.uneven));
        }
        table.texts = vec![None; table.header.len()];
        table
    }
}

fn clipped(text: String) -> String {
    if text.chars().count() <= 600 { text } else { text.chars().take(600).chain(" ..".chars()).collect() }
}
