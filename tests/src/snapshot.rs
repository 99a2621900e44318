//! Compares texts with files in tests/data. A changed text appears in a review as a diff of the file.
//!
//! `SNAPSHOTS=write cargo test -p tests` writes the files.

use std::path::PathBuf;

/// Compares a text with the file `name` in tests/data. If `SNAPSHOTS=write` is set, the text is written to the file instead.
pub fn assert_snapshot(name: &str, text: &str) {
    let file: PathBuf = crate::workspace().join("tests/data").join(name);
    if std::env::var_os("SNAPSHOTS").is_some_and(|word| word == "write") {
        let folder = file.parent().expect("a file stands in a folder");
        std::fs::create_dir_all(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
        return std::fs::write(&file, text).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
    }
    let held = std::fs::read_to_string(&file).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
    if held == text {
        return;
    }
    let line = held.lines().zip(text.lines()).position(|(a, b)| a != b);
    let line = line.unwrap_or(held.lines().count().min(text.lines().count()));
    let of = |text: &str| text.lines().nth(line).unwrap_or("(the end)").to_string();
    panic!(
        "{}:{}: held: {}\n  found: {}\nSNAPSHOTS=write cargo test -p tests writes it anew",
        file.display(),
        line + 1,
        of(&held),
        of(text)
    );
}
