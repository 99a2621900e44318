//! Opens the files that a xacro may use: below its own folder, and below the folders of given packages.

use std::path::{Path, PathBuf};

use gate::source;

use crate::format::shown::shown;

/// Largest total size of all opened files, bytes.
const MAX_INCLUDED_BYTES: u64 = 16 << 20;

/// The folders in which files may be opened, and the number of bytes that may still be read.
pub(super) struct Files<'a> {
    folder: Option<&'a Path>,
    packages: &'a [(String, PathBuf)],
    left: u64,
}

impl<'a> Files<'a> {
    pub(super) fn new(folder: Option<&'a Path>, packages: &'a [(String, PathBuf)]) -> Files<'a> {
        Files { folder, packages, left: MAX_INCLUDED_BYTES }
    }

    /// The folder of a package. Fails if the user did not give it.
    pub(super) fn package(&self, name: &str) -> Result<String, String> {
        let found = self.packages.iter().find(|(known, _)| known == name);
        found.map(|(_, folder)| folder.display().to_string()).ok_or_else(|| {
            format!(
                "the package `{}` is not given, and none is looked for: [package={}=FOLDER]",
                shown(name),
                shown(name)
            )
        })
    }

    /// Reads a file: its text and its path. A relative path is relative to the folder of the file `from`.
    pub(super) fn text(&mut self, name: &str, from: &str) -> Result<(String, String), String> {
        let beside = Path::new(from).parent().unwrap_or(Path::new(""));
        let path = if Path::new(name).is_absolute() { PathBuf::from(name) } else { beside.join(name) };
        // The path may start with the folder of a package, which the user may give relative to the working directory.
        let path = if !path.exists() && Path::new(name).exists() { PathBuf::from(name) } else { path };
        let fail = |what: &str| format!("`{}`: {what}", shown(name));
        let full = path.canonicalize().map_err(|e| fail(&format!("the file cannot be read: {e}")))?;
        let is_below = |folder: &Path| {
            let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
            folder.canonicalize().is_ok_and(|folder| full.starts_with(folder))
        };
        if !self.folder.is_some_and(is_below) && !self.packages.iter().any(|(_, folder)| is_below(folder)) {
            let where_to = "it stands outside the folder of the description and of the given packages, where nothing is \
                            read: [package=NAME=FOLDER]";
            return Err(fail(where_to));
        }
        if let Some(why) = source::no_file(&full) {
            return Err(fail(&why));
        }
        let bytes = source::read(&full, self.left).map_err(|e| fail(&format!("the file cannot be read: {e}")))?;
        self.left -= bytes.len() as u64;
        let text =
            String::from_utf8(bytes).map_err(|_| fail("the text is not UTF-8: save the file in that encoding"))?;
        Ok((text, path.display().to_string()))
    }
}
