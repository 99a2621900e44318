//! Writes the output files of a command completely or not at all, and never overwrites its inputs.
//!
//! An input is a file that the user named, or a file to which a named file refers: an included file, a mesh, a part of a data
//! set ([`gate::opened`]). The content is written into a new file with a random name in the same folder. Then this file is
//! renamed to the final name (atomic replacement), or removed if writing fails. A killed writer leaves its new file behind; the
//! next writer removes it. A symbolic link is followed and stays a link, even if its target does not exist yet. A read-only
//! file is not replaced. A path that is no regular file (a terminal, a pipe, /dev/null) is written to and not replaced.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::hash::{BuildHasher, Hasher, RandomState};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use gate::opened;

use crate::error::Error;

/// Fails if the output is one of the inputs (even under another path), or if the directory of the output does not exist.
pub fn check_output(out: &Path, inputs: &[&Path]) -> Result<(), Error> {
    if out.as_os_str() == "-" {
        return Err(Error::new("-: the name of a file is expected; without it a text goes to standard output"));
    }
    let brought = inputs.iter().flat_map(|input| opened::of(input));
    let inputs: Vec<PathBuf> = inputs.iter().map(|input| input.to_path_buf()).chain(brought).collect();
    if let Some(input) = inputs.iter().find(|input| is_same(out, input)) {
        return Err(Error::new(format_args!(
            "{}: an input ({}), which is not written over",
            out.display(),
            input.display()
        )));
    }
    if out.is_dir() {
        return Err(Error::new(format_args!("{}: a directory, and the name of a file is expected", out.display())));
    }
    match directory_of(out) {
        directory if directory.is_dir() => Ok(()),
        directory => {
            let (out, directory) = (out.display(), directory.display());
            Err(Error::new(format_args!("{out}: there is no directory {directory}; make it, or write elsewhere")))
        }
    }
}

/// Writes a file completely or not at all. Fails if [`check_output`] fails.
pub fn write_file(out: &Path, content: impl AsRef<[u8]>, inputs: &[&Path]) -> Result<(), Error> {
    check_output(out, inputs)?;
    write(out, content.as_ref()).map_err(|e| Error::new(format_args!("{}: {e}", out.display())))
}

fn write(out: &Path, content: &[u8]) -> io::Result<()> {
    let place = match fs::metadata(out) {
        Ok(found) if !found.is_file() => return OpenOptions::new().write(true).open(out)?.write_all(content),
        // A read-only file is refused, although the permissions of the folder would allow a replacement.
        Ok(found) if found.permissions().readonly() => {
            let message = "the file is read-only; make it writable, or write elsewhere";
            return Err(io::Error::new(io::ErrorKind::PermissionDenied, message));
        }
        Ok(_) => fs::canonicalize(out)?,
        Err(_) => end_of_links(out)?,
    };
    clear_remains(directory_of(&place));
    // The new file stays locked until it is renamed to its final name.
    let (neighbour, file) = new_neighbour(&place)?;
    let written = fill(&file, &place, content).and_then(|()| fs::rename(&neighbour, &place));
    if written.is_err() {
        // If the removal fails too, only the error of writing is reported.
        let _ = fs::remove_file(&neighbour);
    }
    written
}

fn fill(mut file: &File, place: &Path, content: &[u8]) -> io::Result<()> {
    if let Ok(found) = fs::metadata(place) {
        file.set_permissions(found.permissions())?;
    }
    file.write_all(content)?;
    file.sync_all()
}

/// The target of a chain of links. It need not exist.
fn end_of_links(out: &Path) -> io::Result<PathBuf> {
    let mut place = out.to_path_buf();
    for _ in 0..LARGEST_LINK_DEPTH {
        match fs::read_link(&place) {
            Ok(target) => place = directory_of(&place).join(target),
            Err(_) => return Ok(place),
        }
    }
    Err(io::Error::other("its links lead in a circle"))
}

/// Largest number of links that are followed; Linux has the same limit.
const LARGEST_LINK_DEPTH: usize = 40;

/// Extension of files that are being written.
const PART_EXTENSION: &str = ".rist-part";

/// Removes files that killed writers left in a folder. The file of a running writer is locked, so this file stays. On a system
/// without locks, nothing is removed.
fn clear_remains(folder: &Path) {
    let is_remains = |path: &PathBuf| {
        let name = path.file_name().and_then(|name| name.to_str()).and_then(|name| name.strip_suffix(PART_EXTENSION));
        let random = name.filter(|name| name.starts_with('.')).and_then(|name| name.rsplit_once('.'));
        random.is_some_and(|(_, r)| r.len() == 16 && r.bytes().all(|b| b.is_ascii_hexdigit()))
    };
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    for path in entries.map(|entry| entry.path()).filter(is_remains) {
        if let Ok(file) = OpenOptions::new().write(true).open(&path)
            && file.try_lock().is_ok()
        {
            // If the permission to remove a file is missing, the file stays.
            let _ = fs::remove_file(&path);
        }
    }
}

/// Creates and locks a new file next to `place`. An existing file is never opened, and a link is never followed.
fn new_neighbour(place: &Path) -> io::Result<(PathBuf, File)> {
    let name = place.file_name().ok_or_else(|| io::Error::other("this is no name of a file"))?.to_string_lossy();
    for _ in 0..MOST_TRIES {
        // Each new hasher has random keys, so the hash of nothing is a random number.
        let random = RandomState::new().build_hasher().finish();
        let neighbour = place.with_file_name(format!(".{name}.{random:016x}{PART_EXTENSION}"));
        match OpenOptions::new().write(true).create_new(true).open(&neighbour) {
            // Before this writer locked the file, another writer may have removed it. Then another name is tried.
            Ok(file) if !matches!(file.try_lock(), Err(TryLockError::WouldBlock)) && neighbour.exists() => {
                return Ok((neighbour, file));
            }
            Err(e) if e.kind() != io::ErrorKind::AlreadyExists => return Err(e),
            _ => {}
        }
    }
    Err(io::Error::other("no free name in its folder"))
}

/// Largest number of names that are tried for a new file.
const MOST_TRIES: usize = 8;

pub(crate) fn directory_of(path: &Path) -> &Path {
    path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Fails if a log is given twice, because such a log would count twice.
pub fn check_given_once<'a>(logs: impl IntoIterator<Item = &'a Path>) -> Result<(), Error> {
    let mut read: Vec<&Path> = Vec::new();
    for log in logs {
        if read.iter().any(|other| is_same(log, other)) {
            return Err(Error::new(format_args!("{}: given twice; a log counts once, in one role", log.display())));
        }
        read.push(log);
    }
    Ok(())
}

/// Whether two paths lead to the same file. Hard links and symbolic links are followed, and the file need not exist yet.
pub fn is_same(a: &Path, b: &Path) -> bool {
    let place = |path: &Path| {
        let name = path.file_name()?;
        fs::canonicalize(path).or_else(|_| fs::canonicalize(directory_of(path)).map(|p| p.join(name))).ok()
    };
    if a == b || place(a).is_some_and(|a| Some(a) == place(b)) {
        return true;
    }
    #[cfg(unix)]
    if let (Ok(a), Ok(b)) = (fs::metadata(a), fs::metadata(b)) {
        use std::os::unix::fs::MetadataExt;
        return (a.dev(), a.ino()) == (b.dev(), b.ino());
    }
    false
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    fn folder(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("rist-output-{}-{name}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        folder
    }

    #[test]
    fn no_input_is_written_over() {
        let here = folder("inputs");
        let (input, hard, soft) = (here.join("a.yaml"), here.join("hard.yaml"), here.join("soft.yaml"));
        fs::write(&input, "a").unwrap();
        fs::hard_link(&input, &hard).unwrap();
        std::os::unix::fs::symlink(&input, &soft).unwrap();
        let around = here.join("../").join(here.file_name().unwrap()).join("a.yaml");
        for out in [&input, &hard, &soft, &around] {
            assert!(write_file(out, "b", &[&input]).is_err(), "{}", out.display());
        }
        assert_eq!(fs::read_to_string(&input).unwrap(), "a");
        let (new, other) = (here.join("new"), here.join("other"));
        assert!(is_same(&new, &here.join("./new")) && !is_same(&new, &other));
        fs::remove_dir_all(here).unwrap();
    }

    #[test]
    fn links_and_neighbours_stay_and_nothing_is_left_behind() {
        let here = folder("links");
        let (target, link, part) = (here.join("target"), here.join("link"), here.join("link.part"));
        fs::write(&target, "old").unwrap();
        fs::write(&part, "mine").unwrap();
        std::os::unix::fs::symlink(&target, &link).unwrap();
        assert!(write_file(&link, "new", &[]).is_ok());
        assert_eq!(
            (fs::read_to_string(&target).unwrap(), fs::read_to_string(&part).unwrap()),
            ("new".into(), "mine".into())
        );
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert!(write_file(&here.join("no/such/x"), "x", &[]).is_err() && write_file(&here, "x", &[]).is_err());
        assert!(write_file(Path::new("/dev/null"), "x", &[]).is_ok());
        assert!(!fs::metadata("/dev/null").unwrap().is_file());
        assert_eq!(fs::read_dir(&here).unwrap().count(), 3);
        let (new, dangling) = (here.join("new"), here.join("dangling"));
        std::os::unix::fs::symlink("new", &dangling).unwrap();
        assert!(write_file(&dangling, "x", &[]).is_ok());
        assert!(fs::symlink_metadata(&dangling).unwrap().is_symlink());
        assert_eq!(fs::read_to_string(&new).unwrap(), "x");
        let circle = here.join("circle");
        std::os::unix::fs::symlink("circle", &circle).unwrap();
        assert!(write_file(&circle, "x", &[]).is_err());
        fs::remove_dir_all(here).unwrap();
    }

    #[test]
    fn a_read_only_file_stays() {
        let here = folder("mode");
        let out = here.join("a.yaml");
        fs::write(&out, "old").unwrap();
        let mut mode = fs::metadata(&out).unwrap().permissions();
        mode.set_readonly(true);
        fs::set_permissions(&out, mode).unwrap();
        let message = write_file(&out, "new", &[]).unwrap_err().to_string();
        assert!(message.contains("read-only"), "{message}");
        assert_eq!(fs::read_to_string(&out).unwrap(), "old");
        fs::remove_dir_all(here).unwrap();
    }

    /// A file to which an input refers is protected only in commands that read this input.
    #[test]
    fn what_an_input_brings_along_is_not_written_over() {
        let here = folder("brought");
        let (arm, part, hard, soft) = (here.join("arm"), here.join("part"), here.join("hard"), here.join("soft"));
        fs::write(&part, "a").unwrap();
        fs::hard_link(&part, &hard).unwrap();
        std::os::unix::fs::symlink(&part, &soft).unwrap();
        opened::with(&arm, || opened::note(&part));
        for out in [&part, &hard, &soft] {
            let message = write_file(out, "b", &[&arm]).unwrap_err().to_string();
            assert!(message.contains("part), which is not written over"), "{message}");
        }
        assert_eq!(fs::read_to_string(&part).unwrap(), "a");
        write_file(&part, "b", &[&here.join("other")]).unwrap();
        fs::remove_dir_all(here).unwrap();
    }

    /// The next writer in a folder removes the hidden file of a killed writer. Files of running writers and of the user stay.
    #[test]
    fn remains_of_killed_writers_go() {
        let here = folder("remains");
        let (dead, living) = (".b.yaml.0123456789abcdef.rist-part", ".a.yaml.fedcba9876543210.rist-part");
        let mine = [".a.yaml.mine.rist-part", "a.0123456789abcdef.rist-part", ".a.yaml.0123456789abcdef.part"];
        for name in mine.iter().chain([&dead]) {
            File::create(here.join(name)).unwrap();
        }
        let held = File::create(here.join(living)).unwrap();
        held.lock().unwrap();
        write_file(&here.join("a.yaml"), "new", &[]).unwrap();
        let exists = |name: &str| here.join(name).exists();
        assert!(!exists(dead) && exists(living) && mine.iter().all(|name| exists(name)));
        assert_eq!(fs::read_dir(&here).unwrap().count(), 5);
        fs::remove_dir_all(here).unwrap();
    }

    /// A writer does not remove the temporary file of another running writer.
    #[test]
    fn writers_beside_each_other_all_write() {
        let here = folder("beside");
        std::thread::scope(|scope| {
            for k in 0..8 {
                let here = &here;
                scope.spawn(move || (0..50).for_each(|_| write_file(&here.join(k.to_string()), "x", &[]).unwrap()));
            }
        });
        assert_eq!(fs::read_dir(&here).unwrap().count(), 8);
        fs::remove_dir_all(here).unwrap();
    }
}
