//! The common elements of all kinds of recordings: channels and their messages.

/// A topic of a recording.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Channel {
    /// Name of the topic.
    pub topic: String,
    /// The name of the message type: `sensor_msgs/msg/JointState`.
    pub schema: String,
    /// The encoding of the messages: `cdr`, `ros1`.
    pub encoding: String,
    /// The language of the type's definition and the definition, where the recording has it.
    pub definition: Option<(String, String)>,
}

/// A message of a channel.
pub struct Message<'a> {
    /// The channel of the message.
    pub channel: &'a Channel,
    /// Time at which the recorder received the message, ns.
    pub log_time: i64,
    /// Its bytes, in the encoding of the channel.
    pub data: &'a [u8],
}

/// Receiver of the messages of a recording. Its error ends the reading.
pub type Receiver<'a> = dyn FnMut(&Message) -> Result<(), String> + 'a;

/// The result of reading a file.
#[derive(Debug, Default)]
pub struct ReadOutcome {
    /// The channels of the file.
    pub channels: Vec<Channel>,
    /// The position up to which the file was read, if not to its end.
    pub cut: Option<String>,
}
