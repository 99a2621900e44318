//! Opens the files that a xacro may use. They must be below the folder of the xacro or below the folders of packages.
//!
//! A package that is not given is searched in the same way as a mesh: the folders above the description are tried, the nearest
//! first. Either such a folder itself or a folder in it must have the name of the package. The folder counts only if it
//! contains a `package.xml`, because files of other folders must not be read.

use std::path::{Path, PathBuf};

use gate::source;

use crate::format::shown::shown;

/// Largest total size of all opened files, bytes.
const MAX_INCLUDED_BYTES: u64 = 16 << 20;

/// The folders in which files may be opened, and the number of bytes that may still be read.
pub(super) struct Files<'a> {
    folder: Option<&'a Path>,
    packages: Vec<(String, PathBuf)>,
    left: u64,
}

impl<'a> Files<'a> {
    pub(super) fn new(folder: Option<&'a Path>, packages: &[(String, PathBuf)]) -> Files<'a> {
        Files { folder, packages: packages.to_vec(), left: MAX_INCLUDED_BYTES }
    }

    /// The folder of a package. Fails if the user did not give the package and it is not in a folder above the description
    /// either.
    pub(super) fn package(&mut self, name: &str) -> Result<String, String> {
        if !self.packages.iter().any(|(known, _)| known == name)
            && let Some(folder) = self.package_above(name)
        {
            self.packages.push((name.into(), folder));
        }
        let found = self.packages.iter().find(|(known, _)| known == name);
        found.map(|(_, folder)| folder.display().to_string()).ok_or_else(|| {
            format!(
                "the package `{}` is not given, and no folder of this name with a package.xml is above the file: \
                 [package={}=FOLDER]",
                shown(name),
                shown(name)
            )
        })
    }

    fn package_above(&self, name: &str) -> Option<PathBuf> {
        // A name with a separator or `..` is no name of a package.
        if Path::new(name).file_name().is_none_or(|last| last != name) {
            return None;
        }
        let folder = self.folder?;
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        let full = std::path::absolute(folder).ok()?;
        let candidates = full.ancestors().flat_map(|above| {
            let own = above.file_name().is_some_and(|last| last == name).then(|| above.to_path_buf());
            own.into_iter().chain([above.join(name)])
        });
        candidates.into_iter().find(|folder| folder.join("package.xml").is_file())
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
