//! Detects changes of a file while it is read.
//!
//! A file that is read in several passes must stay the same. Its length and its time of modification are compared.

use std::path::Path;
use std::time::SystemTime;

use crate::Error;

/// Length and modification time of a file. They change if the file is written or replaced.
#[derive(Clone, PartialEq)]
pub(crate) struct FileState(u64, Option<SystemTime>);

impl FileState {
    pub(crate) fn of(path: &Path) -> Result<FileState, Error> {
        let metadata = std::fs::metadata(path);
        let metadata =
            metadata.map_err(|e| Error::at(&path.display().to_string(), 0, format!("cannot be read: {e}")))?;
        Ok(FileState(metadata.len(), metadata.modified().ok()))
    }

    /// The state of a regular file; `None` for a pipe, a folder, or a missing path.
    pub(crate) fn of_file(path: &Path) -> Option<FileState> {
        if path.is_file() { FileState::of(path).ok() } else { None }
    }
}

/// The error that a file changed while it was read.
pub(crate) fn changed(path: &Path) -> Error {
    Error::at(&path.display().to_string(), 0, "the file changes while it is read, or was replaced since; begin again")
}

/// Fails if a file changed after its state `before` was recorded. Without a recorded state, it never fails.
pub(crate) fn refuse_changed(path: &Path, before: Option<&FileState>) -> Result<(), Error> {
    if before.is_some() && FileState::of_file(path).as_ref() != before { Err(changed(path)) } else { Ok(()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_changes_while_it_is_read_is_refused() {
        let path = std::env::temp_dir().join(format!("rist-state-{}.csv", std::process::id()));
        let write = |text: &str| std::fs::write(&path, text).unwrap();
        write("t,q1\n0,1\n");
        let before = FileState::of_file(&path);
        assert!(before.is_some() && refuse_changed(&path, before.as_ref()).is_ok());
        for text in ["t,q1\n0,1\n1,2\n", "t,q1\n"] {
            write(text);
            let message = refuse_changed(&path, before.as_ref()).unwrap_err().to_string();
            assert!(message.contains("changes while it is read"), "{message}");
        }
        std::fs::remove_file(&path).unwrap();
        assert!(refuse_changed(&path, before.as_ref()).is_err());
        // A path that is not a regular file has no state.
        let none = FileState::of_file(&path);
        assert!(none.is_none() && refuse_changed(&path, none.as_ref()).is_ok());
    }
}
