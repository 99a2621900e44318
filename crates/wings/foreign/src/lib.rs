//! Wing (optional package) for foreign files: reads and writes files of other programs.
//!
//! Reads logs in Arrow IPC, in MATLAB's .mat, in workbooks of Excel, in other shapes of text and, with the feature
//! `rosbag2-sqlite`, in SQLite bags; reads the vertices of Collada meshes; reads links, joints and inertials of an SDF; writes a
//! robot as SYMORO's .par.
//!
//! Interfaces of the core for this wing: `logs::reading` makes a table of columns, decompresses within bounds, and receives
//! messages of a recording. `robot::mesh` calls the reader that is registered for an extension. `robot::format::RobotDescription` makes
//! a robot of joints and bodies. `robot::format::written` makes names that a format allows.

#![warn(missing_docs)]

mod arrow;
mod collada;
mod mat;
mod par;
mod sdf;
#[cfg(feature = "rosbag2-sqlite")]
mod sqlite;
mod text;
mod workbook;

use logs::reading::{LogFormat, LogReader};
use rist::DescriptionFormat;
use rist::wings::{DescriptionReader, DescriptionWriter, Wing};
use robot::mesh::MeshFormat;

pub use par::write_par;
pub use sdf::read as read_sdf;

/// The readers and writers that this wing registers.
pub fn wing() -> Wing {
    Wing {
        log_formats: [
            LogFormat { name: "Arrow", magic: arrow::messages::FILE_MAGIC, reader: arrow::FILE },
            LogFormat { name: "Arrow", magic: b"\xff\xff\xff\xff", reader: arrow::STREAM },
            LogFormat { name: ".mat", magic: b"MATLAB 5.0 MAT", reader: LogReader::Whole(mat::read) },
            LogFormat { name: "Excel (.xlsx)", magic: workbook::MEMBER, reader: LogReader::Whole(workbook::read) },
            #[cfg(feature = "rosbag2-sqlite")]
            LogFormat {
                name: "rosbag2 files in sqlite3",
                magic: b"SQLite format 3\0",
                reader: LogReader::Recording { of_file: sqlite::read_file, of_bytes: sqlite::read_bytes },
            },
        ]
        .into_iter()
        .chain(text::SHAPES)
        .collect(),
        mesh_formats: vec![MeshFormat { extension: "dae", vertices: Ok(collada::vertices) }],
        description_readers: vec![DescriptionReader { extension: "sdf", read: Ok(sdf::read) }],
        writers: vec![DescriptionWriter { format: DescriptionFormat::Par, write: Ok(write_par) }],
        ..Wing::default()
    }
}
