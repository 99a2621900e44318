//! What every kind of recording holds: messages of channels.

/// What a recording says of one topic.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Channel {
    pub topic: String,
    /// The name of the message type: `sensor_msgs/msg/JointState`.
    pub schema: String,
    /// How messages are written: `cdr`, `ros1`.
    pub encoding: String,
}

pub struct Message<'a> {
    pub channel: &'a Channel,
    /// ns, when the recorder got the message.
    pub log_time: i64,
    pub data: &'a [u8],
}

/// What takes the messages of a recording; what it refuses ends the reading.
pub type Receiver<'a> = dyn FnMut(&Message) -> Result<(), String> + 'a;

/// What became of a file.
#[derive(Debug, Default)]
pub struct Outcome {
    pub channels: Vec<Channel>,
    /// How far the file is read, where that is not its end.
    pub cut: Option<String>,
}
