//! Writes the files of a step: whole or not at all, and never over its inputs.
//!
//! A text goes into a new file of a random name beside its place and is then moved there. If that fails, the new file
//! is removed; what a killed writer left, the next one removes. A link is followed, so that it stays a link, also where
//! it leads to no file yet. A file that is read-only is not replaced. A path that is no regular file (a terminal, a pipe,
//! /dev/null) is written to and not replaced.

use std::fs::{self, File, OpenOptions};
use std::hash::{BuildHasher, Hasher, RandomState};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use crate::error::Error;

/// Refuses an output that is an input, by whatever name, and one whose directory is not there.
pub fn check_output(out: &Path, inputs: &[&Path]) -> Result<(), Error> {
    if out.as_os_str() == "-" {
        return Err(Error::new("-: the name of a file is expected; without it a text goes to standard output"));
    }
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

/// Writes a whole file or nothing; refuses what `check_output` refuses.
pub fn write_file(out: &Path, content: impl AsRef<[u8]>, inputs: &[&Path]) -> Result<(), Error> {
    check_output(out, inputs)?;
    write(out, content.as_ref()).map_err(|e| Error::new(format_args!("{}: {e}", out.display())))
}

fn write(out: &Path, content: &[u8]) -> io::Result<()> {
    let place = match fs::metadata(out) {
        Ok(found) if !found.is_file() => return OpenOptions::new().write(true).open(out)?.write_all(content),
        // Its folder would let it be replaced, which is not what its mode says.
        Ok(found) if found.permissions().readonly() => {
            let message = "the file is read-only; make it writable, or write elsewhere";
            return Err(io::Error::new(io::ErrorKind::PermissionDenied, message));
        }
        Ok(_) => fs::canonicalize(out)?,
        Err(_) => end_of_links(out)?,
    };
    clear_remains(&place);
    let (neighbour, file) = new_neighbour(&place)?;
    // Others see by the lock that its writer lives. Where files cannot be locked, remains stay.
    let _ = file.try_lock();
    let written = fill(file, &place, content).and_then(|()| fs::rename(&neighbour, &place));
    if written.is_err() {
        // The error of writing is reported. That the new file could not be removed either is not worth another message.
        let _ = fs::remove_file(&neighbour);
    }
    written
}

fn fill(mut file: File, place: &Path, content: &[u8]) -> io::Result<()> {
    if let Ok(found) = fs::metadata(place) {
        file.set_permissions(found.permissions())?;
    }
    file.write_all(content)?;
    file.sync_all()
}

/// Where a link leads that leads to no file yet.
fn end_of_links(out: &Path) -> io::Result<PathBuf> {
    let mut place = out.to_path_buf();
    for _ in 0..MAX_LINKS {
        match fs::read_link(&place) {
            Ok(target) => place = directory_of(&place).join(target),
            Err(_) => return Ok(place),
        }
    }
    Err(io::Error::other("its links lead in a circle"))
}

/// The number of links that Linux follows.
const MAX_LINKS: usize = 40;

/// What a killed writer of this file left behind is younger than its lock.
const YOUNG: Duration = Duration::from_secs(60);

/// Removes what killed writers of this file left behind. A writer that lives holds a lock.
fn clear_remains(place: &Path) {
    let Some(name) = place.file_name().map(|name| format!(".{}.", name.to_string_lossy())) else { return };
    let is_remains = |path: &PathBuf| {
        let middle = path.file_name().and_then(|found| found.to_str()).and_then(|found| {
            let random = found.strip_prefix(&name)?.strip_suffix(".part")?;
            Some(random.len() == 16 && random.bytes().all(|b| b.is_ascii_hexdigit()))
        });
        let age = fs::metadata(path).and_then(|found| found.modified()).ok().and_then(|at| at.elapsed().ok());
        middle == Some(true) && age.is_some_and(|age| age > YOUNG)
    };
    let entries = fs::read_dir(directory_of(place)).into_iter().flatten().flatten();
    for path in entries.map(|entry| entry.path()).filter(is_remains) {
        if OpenOptions::new().write(true).open(&path).is_ok_and(|file| file.try_lock().is_ok()) {
            // Who may not remove it leaves it.
            let _ = fs::remove_file(&path);
        }
    }
}

/// Creates a file that was not there before, so that no other file is opened and no link followed.
fn new_neighbour(place: &Path) -> io::Result<(PathBuf, File)> {
    let name = place.file_name().ok_or_else(|| io::Error::other("this is no name of a file"))?.to_string_lossy();
    let mut tries = 0;
    loop {
        // Every hasher has new random keys.
        let random = RandomState::new().build_hasher().finish();
        let neighbour = place.with_file_name(format!(".{name}.{random:016x}.part"));
        match OpenOptions::new().write(true).create_new(true).open(&neighbour) {
            Ok(file) => return Ok((neighbour, file)),
            Err(e) if e.kind() == io::ErrorKind::AlreadyExists && tries < 8 => tries += 1,
            Err(e) => return Err(e),
        }
    }
}

fn directory_of(out: &Path) -> &Path {
    out.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Whether two paths lead to one file. It sees through hard and symbolic links, and compares files that do not exist
/// yet.
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

    /// A writer that is killed leaves a hidden file, which the next one takes away; one that lives keeps its own.
    #[test]
    fn remains_of_killed_writers_go() {
        let here = folder("remains");
        let long_ago = std::time::SystemTime::now() - 2 * YOUNG;
        let remains = |name: &str| {
            let file = File::create(here.join(name)).unwrap();
            file.set_modified(long_ago).unwrap();
            file
        };
        let (dead, living) = (".a.yaml.0123456789abcdef.part", ".a.yaml.fedcba9876543210.part");
        let (other, mine) = (".b.yaml.0123456789abcdef.part", ".a.yaml.mine.part");
        for name in [dead, other, mine] {
            drop(remains(name));
        }
        let held = remains(living);
        held.lock().unwrap();
        write_file(&here.join("a.yaml"), "new", &[]).unwrap();
        let exists = |name: &str| here.join(name).exists();
        assert!(!exists(dead) && exists(living) && exists(other) && exists(mine));
        fs::remove_dir_all(here).unwrap();
    }
}
