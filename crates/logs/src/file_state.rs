//! Whether a file that is read more than once is still the same.

use std::path::Path;
use std::time::SystemTime;

use crate::Error;

/// Length and time of modification, which change when a file is written or replaced.
#[derive(PartialEq)]
pub(crate) struct FileState(u64, Option<SystemTime>);

impl FileState {
    pub(crate) fn of(path: &Path) -> Result<FileState, Error> {
        let metadata = std::fs::metadata(path);
        let metadata =
            metadata.map_err(|e| Error::at(&path.display().to_string(), 0, format!("cannot be read: {e}")))?;
        Ok(FileState(metadata.len(), metadata.modified().ok()))
    }
}
