//! Channels and messages, as all formats of recordings have them.
//!
//! A recording (of ROS) is a file with messages of several channels. A channel has one topic and one message type.

/// A channel of a recording: its topic and its message type.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Channel {
    /// Name of the topic.
    pub topic: String,
    /// Name of the message type, for example `sensor_msgs/msg/JointState`.
    pub schema: String,
    /// Encoding of the messages, for example `cdr` or `ros1`.
    pub encoding: String,
    /// The definition of the message type: its language and its text. `None` if the recording does not contain it.
    pub definition: Option<(String, String)>,
}

/// A message of a channel.
pub struct Message<'a> {
    /// The channel of the message.
    pub channel: &'a Channel,
    /// Time at which the recorder received the message, ns.
    pub log_time: i64,
    /// The bytes of the message, in the encoding of the channel.
    pub data: &'a [u8],
}

/// A function that receives the messages of a recording. If it returns an error, reading stops.
pub type Receiver<'a> = dyn FnMut(&Message) -> Result<(), String> + 'a;

/// The result of reading a recording.
#[derive(Debug, Default)]
pub struct ReadOutcome {
    /// The channels of the file.
    pub channels: Vec<Channel>,
    /// If the file is incomplete: the position up to which it was read. `None` if it was read to its end.
    pub cut: Option<String>,
}
