//! Every path of docs/notation.md leads to what it names.

use std::path::{Path, PathBuf};

use tests::workspace;

/// The file of a module, by the folders that lead to it from the `src` of its crate.
fn file_of(source: &Path, modules: &[&str]) -> Option<PathBuf> {
    let folder = modules.iter().fold(source.to_path_buf(), |path, module| path.join(module));
    let files = match modules {
        [] => vec![source.join("lib.rs")],
        _ => vec![folder.with_extension("rs"), folder.join("mod.rs")],
    };
    files.into_iter().find(|file| file.is_file())
}

/// Whether `name` is public in a file, or handed on by it.
fn is_public(text: &str, name: &str) -> bool {
    let defines = ["struct", "enum", "trait", "type", "fn", "const", "mod"];
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    let named = |line: &str| line.split(|c| !is_word(c)).any(|word| word == name);
    let is_item =
        |line: &str| line.strip_prefix("pub ").is_some_and(|rest| defines.iter().any(|d| rest.starts_with(d)));
    // A list of names to hand on may go over several lines.
    let handed_on = text.split("pub use ").skip(1).filter_map(|rest| rest.split(';').next());
    text.lines().any(|line| is_item(line) && named(line)) || handed_on.into_iter().any(named)
}

/// `identification::rows::observation::Observation`: crate, modules, name.
fn leads(path: &str) -> bool {
    let parts: Vec<&str> = path.split("::").collect();
    let [package, modules @ .., name] = parts.as_slice() else { return false };
    let sources = ["crates", "crates/wings"].map(|folder| workspace().join(folder).join(package).join("src"));
    let file = sources.iter().find_map(|source| file_of(source, modules));
    file.is_some_and(|file| is_public(&std::fs::read_to_string(file).unwrap(), name))
}

#[test]
fn paths_lead_to_what_they_name() {
    let page = std::fs::read_to_string(workspace().join("docs/notation.md")).unwrap();
    let paths: Vec<&str> = page.split('`').skip(1).step_by(2).filter(|word| word.contains("::")).collect();
    assert!(paths.len() > 50, "{} paths", paths.len());
    let faults: Vec<&&str> = paths.iter().filter(|path| !leads(path)).collect();
    assert!(faults.is_empty(), "docs/notation.md: no public item at {faults:?}");
}
