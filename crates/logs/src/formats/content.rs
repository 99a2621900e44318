//! Determines the format of a file by its first bytes, and gives the messages for formats that cannot be read.
//!
//! Formats are built in, registered by other packages (`registered`), or foreign: recognised, but not readable. For a foreign
//! format, the message contains a command that converts the file.

use crate::formats::json;
use crate::formats::registered::{self, LogReader};

/// The format of a file, determined by its first bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FileFormat {
    /// Delimited text, or an unknown format.
    Text,
    /// A gzip stream of text.
    Gzip,
    /// A zstd stream that contains any other format.
    Zstd,
    Numpy,
    Json,
    Parquet,
    Mcap,
    /// A format that another package reads: its index in the list of registered formats.
    Registered(usize),
    /// A format that cannot be read here: the message with a command that converts it.
    Foreign(&'static str),
}

use FileFormat::*;

/// The first bytes of each format.
const FILE_KINDS: [(&[u8], FileFormat); 7] = [
    (b"\x1f\x8b", Gzip),
    (b"\x28\xb5\x2f\xfd", Zstd),
    (b"PK\x03\x04", Numpy),
    (b"\x93NUMPY", Numpy),
    (b"PAR1", Parquet),
    (b"PARE", Parquet),
    (b"\x89MCAP0\r\n", Mcap),
];

/// The command that writes all arrays of an HDF5 file as a .npz.
macro_rules! from_hdf5 {
    () => {
        "`python -c \"import h5py, numpy; d = {}; h5py.File('IN').visititems(lambda k, x: d.update({k.replace('/', '_'): \
         x[()].squeeze()}) if getattr(x, 'dtype', None) is not None and x.dtype.kind in 'fiu' else None); \
         numpy.savez('OUT.npz', **d)\"`"
    };
}

/// First bytes of files that are not read, with their description and a command that converts them.
const FOREIGN_FORMATS: [(&[u8], &str); 15] = [
    (b"#ROSBAG V", "a bag of ROS 1, which is not read; convert it: `mcap convert in.bag out.mcap`"),
    (
        b"FEA1",
        "a Feather file of version 1, which is not read; convert it: `python -c \"import pyarrow.feather as f; \
         f.write_feather(f.read_table('IN'), 'OUT')\"`",
    ),
    (
        b"MATLAB 7.3 MAT",
        concat!(
            "a .mat of version 7.3 (HDF5), which is not read; save it as version 7 in MATLAB, `save('OUT.mat', '-v7')`, or write \
             its arrays as .npz: ",
            from_hdf5!()
        ),
    ),
    (b"\x89HDF\r\n", concat!("an HDF5 file, which is not read; write its arrays as .npz: ", from_hdf5!())),
    (
        b"TDSm",
        "a TDMS file of LabVIEW, which is not read; convert it: `python -c \"import nptdms; \
         nptdms.TdmsFile('IN').as_dataframe().to_csv('OUT.csv')\"`",
    ),
    (b"ULog\x01", "a ULog of PX4, which is not read; convert it: `ulog2csv IN.ulg`"),
    (b"\x80\x02", PICKLE),
    (b"\x80\x03", PICKLE),
    (b"\x80\x04\x95", PICKLE),
    (b"\x80\x05\x95", PICKLE),
    (b"}q\0", PICKLE),
    (b"]q\0", PICKLE),
    (b"(dp0\n", PICKLE),
    (b"(lp0\n", PICKLE),
    (b"\xd0\xcf\x11\xe0", "a workbook of old Excel, which is not read; save the sheet as CSV"),
];

/// A pickle of a dictionary of arrays, or of a list of dictionaries.
const PICKLE: &str = "a pickle of Python, which may run any code and is not read; if you trust it, write its arrays: `python -c \
    \"import pickle, numpy; d = pickle.load(open('IN', 'rb')); d = d if isinstance(d, dict) else {k: [r[k] for r in d] for k \
    in d[0]}; numpy.savez('OUT.npz', **d)\"`";

/// The message where the feature that reads and writes Parquet is off.
pub(crate) const NO_PARQUET: &str = "this program was built without the feature `parquet`; the programs and wheels of a \
    release have it, and docs/how-to/install.md says how to build one";

/// A command that converts a Parquet file to an Arrow file.
const FROM_PARQUET: &str = "python -c \"import polars; polars.read_parquet('IN').write_ipc('OUT.arrow')\"";

/// Number of first bytes that determine the format.
pub(crate) const MAGIC_BYTES: usize = 16;

impl FileFormat {
    /// Whether the content is another format, compressed.
    pub(crate) fn is_compressed(self) -> bool {
        matches!(self, Gzip | Zstd)
    }

    /// The kind of a file with these first bytes, [`MAGIC_BYTES`] of them or the whole file.
    pub(crate) fn of(head: &[u8]) -> FileFormat {
        let core = FILE_KINDS.iter().find(|kind| head.starts_with(kind.0)).map(|kind| kind.1);
        let json = || json::HEADS.iter().any(|begin| head.starts_with(begin)).then_some(Json);
        let registered = || registered::of_head(head).map(Registered);
        let foreign = || FOREIGN_FORMATS.iter().find(|kind| head.starts_with(kind.0)).map(|kind| Foreign(kind.1));
        core.or_else(json).or_else(registered).or_else(foreign).unwrap_or(Text)
    }

    /// The registered reader for this format; `None` if there is none.
    pub(crate) fn reader(self) -> Option<LogReader> {
        match self {
            Registered(place) => Some(registered::reader(place)),
            _ => None,
        }
    }

    /// Whether files of this format have an index at their end, so that they must be read by position.
    pub(crate) fn has_index(self) -> bool {
        self == Parquet || matches!(self.reader(), Some(LogReader::Indexed { .. }))
    }

    /// Whether files of this format contain messages (recordings).
    pub(crate) fn is_recording(self) -> bool {
        let holds_messages =
            |reader| matches!(reader, LogReader::Recording { .. } | LogReader::Absent { is_recording: true, .. });
        self == Mcap || self.reader().is_some_and(holds_messages)
    }

    /// The message why files of this format cannot be read, with a remedy; `None` if they can be read.
    pub(crate) fn refusal(self) -> Option<String> {
        match (self, self.reader()) {
            (Foreign(what), _) | (_, Some(LogReader::Absent { what, .. })) => Some(format!("this is {what}")),
            (Parquet, _) if !cfg!(feature = "parquet") => {
                // The command makes an Arrow file, so the command is shown only if this program can read Arrow.
                let line = registered::format_names().contains(&"Arrow").then_some(FROM_PARQUET);
                let remedy = line.map_or(String::new(), |line| format!("; or convert it: `{line}`"));
                Some(format!("this is a Parquet file: {NO_PARQUET}{remedy}"))
            }
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// If a folder contains a part of a recording in a format without a reader, the folder is refused. Other files do not matter.
    #[test]
    fn formats_that_are_absent_say_what_they_are() {
        let absent = |magic: &'static [u8], what: &'static str, is_recording: bool| registered::LogFormat {
            name: "",
            magic,
            reader: LogReader::Absent { what, is_recording },
        };
        registered::register(vec![absent(b"BAG-OF-TESTS", "a bag", true), absent(b"SHEET-OF-TESTS", "a sheet", false)]);
        for (magic, what, is_recording) in
            [(&b"BAG-OF-TESTS"[..], "a bag", true), (b"SHEET-OF-TESTS", "a sheet", false)]
        {
            let content = FileFormat::of(magic);
            assert_eq!((content.refusal(), content.is_recording()), (Some(format!("this is {what}")), is_recording));
        }
        assert!(Mcap.is_recording() && !Text.is_recording());
    }

    /// A file that cannot be read is refused with a message that names its format.
    #[test]
    fn files_that_are_not_read_say_what_they_are() {
        for (magic, content) in FILE_KINDS {
            assert_eq!(FileFormat::of(&[magic, b"and more"].concat()), content);
            assert_eq!(content.refusal().is_some(), content == Parquet && !cfg!(feature = "parquet"));
        }
        for (magic, what) in FOREIGN_FORMATS {
            assert_eq!(FileFormat::of(&[magic, b"and more"].concat()).refusal(), Some(format!("this is {what}")));
        }
        assert_eq!(FileFormat::of(b"t,q1,tau1"), Text);
        assert_eq!(Text.refusal(), None);
    }
}
