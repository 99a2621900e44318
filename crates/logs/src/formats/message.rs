//! The parts that every kind of recording has: messages of channels.

/// A topic as a recording describes it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Channel {
    /// Its name.
    pub topic: String,
    /// The name of the message type: `sensor_msgs/msg/JointState`.
    pub schema: String,
    /// How messages are written: `cdr`, `ros1`.
    pub encoding: String,
    /// How their type is defined and the definition, where the recording carries it.
    pub definition: Option<(String, String)>,
}

/// A message of a channel.
pub struct Message<'a> {
    /// Where it was published.
    pub channel: &'a Channel,
    /// ns, when the recorder got the message.
    pub log_time: i64,
    /// Its bytes, encoded as the channel says.
    pub data: &'a [u8],
}

/// Receiver of the messages of a recording. Its error ends the reading.
pub type Receiver<'a> = dyn FnMut(&Message) -> Result<(), String> + 'a;

/// The result of reading a file.
#[derive(Debug, Default)]
pub struct Outcome {
    /// The channels of the file.
    pub channels: Vec<Channel>,
    /// Up to where the file was read, if not to its end.
    pub cut: Option<String>,
}
