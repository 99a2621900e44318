//! Example files that are built into the program: a UR5 description, two logs and measured poses, from docs/ur5.

use std::path::{Path, PathBuf};

use gate::source::glance;

use crate::error::Error;
use crate::output::{check_output, write_file};

/// Name and content of each file: a description, a log to identify from, a log to validate with, and measured poses to calibrate
/// the geometry with.
pub const FILES: [(&str, &str); 4] = [
    ("ur5.urdf", include_str!("../../../models/ur5.urdf")),
    ("log.csv", include_str!("../../../docs/ur5/log.csv")),
    ("other.csv", include_str!("../../../docs/ur5/other.csv")),
    ("poses.csv", include_str!("../../../docs/ur5/poses.csv")),
];

/// Writes the example files into `directory` and returns the paths of the files. The directory is created if necessary.
///
/// Fails if a file of the same name exists with another content.
pub fn write_example(directory: &Path) -> Result<Vec<PathBuf>, Error> {
    let failed = |e| Error::new(format_args!("{}: {e}", directory.display()));
    std::fs::create_dir_all(directory).map_err(failed)?;
    let paths: Vec<PathBuf> = FILES.iter().map(|(name, _)| directory.join(name)).collect();
    for (path, (_, text)) in paths.iter().zip(FILES) {
        let is_there = std::fs::symlink_metadata(path).is_ok();
        if is_there && glance(path, text.len() + 1).as_deref() != Some(text.as_bytes()) {
            return Err(Error::new(format_args!("{}: another file of this name, which is kept", path.display())));
        }
        check_output(path, &[])?;
    }
    for (path, (_, text)) in paths.iter().zip(FILES) {
        write_file(path, text, &[])?;
    }
    Ok(paths)
}
