//! Records the files that were opened, so that no output overwrites one of them.
//!
//! [`Source::open`](crate::source::Source::open) records every file with its input. The input of a file is the description or
//! the log that is being read when the file is opened ([`with`]). A program with one task asks for all recorded files; a
//! long-lived process asks only for the files of some inputs. A [`glance`](crate::source::glance) does not record a file.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// The full path of each opened file, with the full paths of its inputs.
static OPENED: Mutex<BTreeMap<PathBuf, BTreeSet<PathBuf>>> = Mutex::new(BTreeMap::new());

thread_local! {
    /// The inputs that this thread is reading. If the reading of one input starts the reading of another input, the outer input
    /// comes first.
    static READ_NOW: RefCell<Vec<PathBuf>> = const { RefCell::new(Vec::new()) };
}

/// Runs `work` and returns its result. Files that this thread opens meanwhile belong to `input`, the path of a description or a
/// log.
pub fn with<T>(input: &Path, work: impl FnOnce() -> T) -> T {
    READ_NOW.with_borrow_mut(|now| now.push(full(input)));
    let outcome = work();
    READ_NOW.with_borrow_mut(Vec::pop);
    outcome
}

/// Records a file that is opened, or that a description names. The file belongs to all inputs (descriptions, logs) that this
/// thread is reading.
pub fn note(path: &Path) {
    READ_NOW.with_borrow(|now| opened().entry(full(path)).or_default().extend(now.iter().cloned()));
}

/// The full paths of all recorded files.
pub fn all() -> Vec<PathBuf> {
    opened().keys().cloned().collect()
}

/// The full paths of the files that belong to `input`.
pub fn of(input: &Path) -> Vec<PathBuf> {
    let input = full(input);
    opened().iter().filter(|(_, inputs)| inputs.contains(&input)).map(|(file, _)| file.clone()).collect()
}

fn full(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| path.to_path_buf())
}

fn opened() -> MutexGuard<'static, BTreeMap<PathBuf, BTreeSet<PathBuf>>> {
    // The lock is used even after a panic of another thread, because a panic cannot leave an incomplete entry.
    OPENED.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::{Source, glance};

    #[test]
    fn a_file_belongs_to_what_is_read() {
        let here = std::env::temp_dir().join(format!("rist-opened-{}", std::process::id()));
        std::fs::create_dir_all(&here).unwrap();
        let here = here.canonicalize().unwrap();
        let [arm, part, other, seen] = ["arm", "part", "other", "seen"].map(|name| here.join(name));
        [&arm, &part, &other, &seen].iter().for_each(|path| std::fs::write(path, "x").unwrap());
        with(&here.join("./arm"), || {
            with(&part, || drop(Source::open(&part).unwrap()));
            glance(&seen, 1).unwrap();
            std::thread::scope(|scope| drop(scope.spawn(|| Source::open(&other).unwrap()).join()));
        });
        assert_eq!((of(&arm), of(&other)), (vec![part.clone()], Vec::new()));
        assert!(all().contains(&part) && all().contains(&other) && !all().contains(&seen));
        std::fs::remove_dir_all(here).unwrap();
    }
}
