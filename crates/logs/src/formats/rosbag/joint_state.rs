//! Decodes one message sensor_msgs/JointState, in CDR (ROS 2) or in the encoding of ROS 1.
//!
//! Fields: stamp (s, ns), frame_id, name[], position[], velocity[], effort[]; in rad, rad/s, N m (m, m/s, N). In ROS 1, a
//! sequence number precedes them.

use crate::formats::rosbag::cdr::{Cursor, Encoding};

/// The arrays of a message. An array is empty if its quantity is not measured.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct JointState<'a> {
    /// Time in the header, ns; zero if the driver sets none.
    pub stamp: i64,
    pub names: Vec<&'a str>,
    pub position: Vec<f64>,
    pub velocity: Vec<f64>,
    pub effort: Vec<f64>,
}

impl JointState<'_> {
    pub(crate) fn decode(data: &[u8], encoding: Encoding) -> Result<JointState<'_>, String> {
        let mut cursor = Cursor::new(data, encoding, "sensor_msgs/JointState")?;
        if encoding == Encoding::Ros1 {
            cursor.u32()?; // the sequence number
        }
        let (seconds, nanoseconds) = (cursor.u32()?, cursor.u32()?);
        // ROS 2 counts seconds as int32, ROS 1 as uint32.
        let seconds = if cursor.aligned { i64::from(seconds as i32) } else { i64::from(seconds) };
        let stamp = seconds * 1_000_000_000 + i64::from(nanoseconds);
        let _frame = cursor.text()?;
        let mut names = Vec::new();
        for _ in 0..cursor.u32()? {
            names.push(cursor.text()?);
        }
        let (position, velocity, effort) = (cursor.doubles()?, cursor.doubles()?, cursor.doubles()?);
        Ok(JointState { stamp, names, position, velocity, effort })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A message: stamp 1 s 2 ns, frame "b", name ["a"], position [1.0], velocity [], effort [2.0].
    const CDR: &[u8] = &[
        0, 1, 0, 0, // little-endian
        1, 0, 0, 0, 2, 0, 0, 0, //
        2, 0, 0, 0, b'b', 0, 0, 0, // to byte 16, with two bytes of alignment
        1, 0, 0, 0, 2, 0, 0, 0, b'a', 0, 0, 0, // to byte 28
        1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xf0, 0x3f, // aligned to 32 without a gap
        0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0x40,
    ];

    fn expected() -> JointState<'static> {
        JointState { stamp: 1_000_000_002, names: vec!["a"], position: vec![1.0], velocity: vec![], effort: vec![2.0] }
    }

    #[test]
    fn a_gap_before_numbers_is_an_alignment() {
        // A frame name of four letters moves the numbers by four bytes, and the alignment moves them by four more.
        let longer = [&CDR[..12], &[5, 0, 0, 0, b'b', b'a', b's', b'e', 0, 0, 0, 0], &CDR[20..36], &[0; 4], &CDR[36..]];
        assert_eq!(JointState::decode(&longer.concat(), Encoding::Cdr).unwrap(), expected());
    }

    #[test]
    fn seconds_before_1970() {
        let mut early = CDR.to_vec();
        early[4..8].copy_from_slice(&(-1i32).to_le_bytes());
        assert_eq!(JointState::decode(&early, Encoding::Cdr).unwrap().stamp, -999_999_998);
    }

    #[test]
    fn no_length_is_believed() {
        for cut in 0..CDR.len() {
            assert!(JointState::decode(&CDR[..cut], Encoding::Cdr).is_err(), "{cut}");
        }
        for at in [12, 20, 24, 32, 44, 48] {
            let mut hostile = CDR.to_vec();
            hostile[at..at + 4].fill(0xff);
            let message = JointState::decode(&hostile, Encoding::Cdr).unwrap_err();
            assert!(message.contains("no sensor_msgs/JointState"), "{at}: {message}");
        }
    }
}
