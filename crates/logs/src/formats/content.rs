//! The kind of a file by its first bytes, and the feature of this package that reads it.

/// The kind of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Content {
    /// Delimited text, or nothing that is known.
    Text,
    /// A gzip stream of text.
    Gzip,
    /// A zstd stream of any of the others.
    Zstd,
    Numpy,
    Parquet,
    Mcap,
    Sqlite,
    /// A bag of ROS 1.
    Bag,
}

use Content::*;

/// First bytes, the kind they mark, its name, the feature that reads it, and whether the feature is built in.
const FILE_KINDS: [(&[u8], Content, &str, &str, bool); 9] = [
    (b"\x1f\x8b", Gzip, "", "", true),
    (b"\x28\xb5\x2f\xfd", Zstd, "a zstd stream", "zstd", cfg!(feature = "zstd")),
    (b"PK\x03\x04", Numpy, "a .npz of NumPy", "npz", cfg!(feature = "npz")),
    (b"\x93NUMPY", Numpy, "an array of NumPy", "npz", cfg!(feature = "npz")),
    (b"PAR1", Parquet, "a Parquet file", "parquet", cfg!(feature = "parquet")),
    (b"PARE", Parquet, "a Parquet file", "parquet", cfg!(feature = "parquet")),
    (b"\x89MCAP0\r\n", Mcap, "an MCAP file", "mcap", cfg!(feature = "mcap")),
    (b"SQLite format 3\0", Sqlite, "a rosbag2 in sqlite3", "rosbag2-sqlite", cfg!(feature = "rosbag2-sqlite")),
    (b"#ROSBAG V", Bag, "", "", true),
];

/// Number of first bytes that tell the kind of a file.
pub(crate) const MAGIC_BYTES: usize = 16;

impl Content {
    /// The kind of a file with these first bytes, [`MAGIC_BYTES`] of them or all.
    pub(crate) fn of(head: &[u8]) -> Content {
        FILE_KINDS.iter().find(|kind| head.starts_with(kind.0)).map_or(Text, |kind| kind.1)
    }

    /// Why files of this kind are not read, and what to do; `None` where they are.
    pub(crate) fn refusal(self) -> Option<String> {
        if self == Bag {
            return Some(
                "this is a bag of ROS 1, which is not read; convert it: `mcap convert in.bag out.mcap`".into(),
            );
        }
        FILE_KINDS.iter().find(|kind| kind.1 == self && !kind.4).map(|(_, _, name, feature, _)| {
            format!(
                "this is {name}, and this program was built without what reads it; build it with the feature \
                 `{feature}` of the package `logs`"
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// With a feature off its files are refused by the feature's name; with it on they are not.
    #[test]
    fn a_feature_left_out_is_named() {
        for (magic, content, _, feature, built) in FILE_KINDS {
            assert_eq!(Content::of(&[magic, b"and more"].concat()), content);
            let refusal = content.refusal();
            assert_eq!(refusal.is_some(), !built || content == Bag, "{feature}");
            assert!(refusal.is_none_or(|r| r.contains(&format!("`{feature}` of the package")) || content == Bag));
        }
        assert_eq!(Content::of(b"t,q1,tau1"), Text);
        assert_eq!(Text.refusal(), None);
    }
}
