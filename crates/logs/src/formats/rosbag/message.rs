//! The parts that every kind of recording has: messages of channels.

/// A topic as a recording describes it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Channel {
    pub topic: String,
    /// The name of the message type: `sensor_msgs/msg/JointState`.
    pub schema: String,
    /// How messages are written: `cdr`, `ros1`.
    pub encoding: String,
    /// How their type is defined and the definition, where the recording carries it.
    pub definition: Option<(String, String)>,
}

pub(crate) struct Message<'a> {
    pub channel: &'a Channel,
    /// ns, when the recorder got the message.
    pub log_time: i64,
    pub data: &'a [u8],
}

/// Receiver of the messages of a recording. Its error ends the reading.
pub(crate) type Receiver<'a> = dyn FnMut(&Message) -> Result<(), String> + 'a;

/// The result of reading a file.
#[derive(Debug, Default)]
pub(crate) struct Outcome {
    pub channels: Vec<Channel>,
    /// Up to where the file was read, if not to its end.
    pub cut: Option<String>,
}
