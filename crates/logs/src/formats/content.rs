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
    /// Arrays of MATLAB, version 5.
    Mat,
    /// A file of Arrow IPC (Feather, version 2).
    Arrow,
    ArrowStream,
    Parquet,
    Mcap,
    Sqlite,
    /// What another program turns into one of the others.
    Foreign(&'static str),
}

use Content::*;

/// First bytes, the kind they mark, its name, the feature that reads it, and whether the feature is built in.
const FILE_KINDS: [(&[u8], Content, &str, &str, bool); 11] = [
    (b"\x1f\x8b", Gzip, "", "", true),
    (b"\x28\xb5\x2f\xfd", Zstd, "a zstd stream", "zstd", cfg!(feature = "zstd")),
    (b"PK\x03\x04", Numpy, "a .npz of NumPy", "npz", cfg!(feature = "npz")),
    (b"\x93NUMPY", Numpy, "an array of NumPy", "npz", cfg!(feature = "npz")),
    (b"MATLAB 5.0 MAT", Mat, "a .mat of version 5", "mat", cfg!(feature = "mat")),
    (b"ARROW1\0\0", Arrow, "an Arrow or Feather file", "arrow", cfg!(feature = "arrow")),
    (b"\xff\xff\xff\xff", ArrowStream, "an Arrow stream", "arrow", cfg!(feature = "arrow")),
    (b"PAR1", Parquet, "a Parquet file", "parquet", cfg!(feature = "parquet")),
    (b"PARE", Parquet, "a Parquet file", "parquet", cfg!(feature = "parquet")),
    (b"\x89MCAP0\r\n", Mcap, "an MCAP file", "mcap", cfg!(feature = "mcap")),
    (b"SQLite format 3\0", Sqlite, "a rosbag2 in sqlite3", "rosbag2-sqlite", cfg!(feature = "rosbag2-sqlite")),
];

/// First bytes of files that are not read, with what they are and the line that makes one that is.
const FOREIGN: [(&[u8], &str); 8] = [
    (b"#ROSBAG V", "a bag of ROS 1, which is not read; convert it: `mcap convert in.bag out.mcap`"),
    (
        b"FEA1",
        "a Feather file of version 1, which is not read; convert it: `python -c \"import pyarrow.feather as f; \
         f.write_feather(f.read_table('IN'), 'OUT')\"`",
    ),
    (
        b"MATLAB 7.3 MAT",
        "a .mat of version 7.3 (HDF5), which is not read; save it as version 7 in MATLAB: `save('OUT.mat', '-v7')`",
    ),
    (
        b"\x89HDF\r\n",
        "an HDF5 file, which is not read; write its arrays as .npz: `python -c \"import h5py, numpy; f = \
         h5py.File('IN'); numpy.savez('OUT.npz', **{k: f[k][:] for k in ('t', 'q', 'tau')})\"`",
    ),
    (
        b"TDSm",
        "a TDMS file of LabVIEW, which is not read; convert it: `python -c \"import nptdms; \
         nptdms.TdmsFile('IN').as_dataframe().to_csv('OUT.csv')\"`",
    ),
    (b"ULog\x01", "a ULog of PX4, which is not read; convert it: `ulog2csv IN.ulg`"),
    (
        b"\x80\x04\x95",
        "a pickle of Python, which may run what it likes and is not read; write its arrays: `numpy.savez('OUT.npz', t=t, \
         q=q, tau=tau)`",
    ),
    (b"\xd0\xcf\x11\xe0", "a workbook of old Excel, which is not read; save the sheet as CSV"),
];

/// For features that may be left out, the line that makes what is read without.
const CONVERTERS: [(&str, &str); 2] = [
    ("parquet", "python -c \"import polars; polars.read_parquet('IN').write_ipc('OUT.arrow')\""),
    ("rosbag2-sqlite", "mcap convert IN.db3 OUT.mcap"),
];

/// Number of first bytes that tell the kind of a file.
pub(crate) const MAGIC_BYTES: usize = 16;

impl Content {
    /// The kind of a file with these first bytes, [`MAGIC_BYTES`] of them or all.
    pub(crate) fn of(head: &[u8]) -> Content {
        let foreign = || FOREIGN.iter().find(|kind| head.starts_with(kind.0)).map(|kind| Foreign(kind.1));
        FILE_KINDS.iter().find(|kind| head.starts_with(kind.0)).map(|kind| kind.1).or_else(foreign).unwrap_or(Text)
    }

    /// Whether such a file has an index at its end, so that it is read by place.
    pub(crate) fn has_index(self) -> bool {
        matches!(self, Arrow | Parquet)
    }

    /// Why files of this kind are not read, and what to do; `None` where they are.
    pub(crate) fn refusal(self) -> Option<String> {
        if let Foreign(what) = self {
            return Some(format!("this is {what}"));
        }
        let (_, _, name, feature, _) = FILE_KINDS.iter().find(|kind| kind.1 == self && !kind.4)?;
        let converter =
            CONVERTERS.iter().find(|(of, _)| of == feature).map(|(_, line)| format!("; or convert it: `{line}`"));
        Some(format!("this is {name}: {}{}", left_out(feature), converter.unwrap_or_default()))
    }
}

/// That this program lacks a feature, and what brings it.
pub(crate) fn left_out(feature: &str) -> String {
    format!(
        "this program was built without the feature `{feature}`; the programs and wheels of a release have it, and \
         docs/how-to/install.md says how to build one"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_feature_left_out_is_named() {
        for (magic, content, _, feature, built) in FILE_KINDS {
            assert_eq!(Content::of(&[magic, b"and more"].concat()), content);
            let refusal = content.refusal();
            assert_eq!(refusal.is_some(), !built, "{feature}");
            assert!(refusal.is_none_or(|r| r.contains(&format!("without the feature `{feature}`"))));
        }
        for (magic, what) in FOREIGN {
            assert_eq!(Content::of(&[magic, b"and more"].concat()).refusal(), Some(format!("this is {what}")));
        }
        assert_eq!(Content::of(b"t,q1,tau1"), Text);
        assert_eq!(Text.refusal(), None);
    }
}
