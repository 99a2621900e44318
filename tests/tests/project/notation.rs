//! Tests of docs/notation.md: every path on the page names an existing item, and the page contains the words of public types and
//! headings. Also tests that words which were replaced by standard terms are not used.

use std::path::{Path, PathBuf};

use tests::workspace;

/// The file of a module; `None` if there is no such file. `modules`: names of the modules from the `src` folder of its crate down
/// to it.
fn file_of(source: &Path, modules: &[&str]) -> Option<PathBuf> {
    let folder = modules.iter().fold(source.to_path_buf(), |path, module| path.join(module));
    let files = match modules {
        [] => vec![source.join("lib.rs")],
        _ => vec![folder.with_extension("rs"), folder.join("mod.rs")],
    };
    files.into_iter().find(|file| file.is_file())
}

/// Whether a file defines or re-exports the public item `name`.
fn is_public(text: &str, name: &str) -> bool {
    let defines = ["struct", "enum", "trait", "type", "fn", "const", "mod"];
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    let named = |line: &str| line.split(|c| !is_word(c)).any(|word| word == name);
    let is_item =
        |line: &str| line.strip_prefix("pub ").is_some_and(|rest| defines.iter().any(|d| rest.starts_with(d)));
    // A list after `pub use` may have several lines.
    let handed_on = text.split("pub use ").skip(1).filter_map(|rest| rest.split(';').next());
    text.lines().any(|line| is_item(line) && named(line)) || handed_on.into_iter().any(named)
}

/// Whether a path such as `identification::rows::observation::Observation` (crate, modules, name) names a public item.
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

/// Words of a camel-case name in lower case: `LogCheck` gives `log` and `check`.
fn words(name: &str) -> Vec<String> {
    let mut found: Vec<String> = Vec::new();
    for c in name.chars().filter(|c| c.is_ascii_alphabetic()) {
        match found.last_mut() {
            Some(word) if c.is_lowercase() => word.push(c),
            _ => found.push(c.to_lowercase().to_string()),
        }
    }
    found
}

/// Whether a word is on the page docs/notation.md, in singular or plural.
fn stands(page: &[String], word: &str) -> bool {
    let single = word.strip_suffix("es").into_iter().chain(word.strip_suffix('s'));
    page.iter().any(|one| one == word || one.strip_suffix('s') == Some(word) || single.clone().any(|w| one == w))
}

fn page_words() -> Vec<String> {
    let page = std::fs::read_to_string(workspace().join("docs/notation.md")).unwrap().to_lowercase();
    page.split(|c: char| !c.is_alphabetic()).map(str::to_string).collect()
}

/// (path, text) of the tracked files below these folders with one of these endings.
fn files(folders: &[&str], endings: &[&str]) -> Vec<(String, String)> {
    let listed = std::process::Command::new("git").arg("ls-files").args(folders).current_dir(workspace()).output();
    let listed = String::from_utf8(listed.expect("git lists files").stdout).unwrap();
    let wanted = listed.lines().filter(|file| endings.iter().any(|ending| file.ends_with(ending)));
    let read = |file: &str| Some((file.to_string(), std::fs::read_to_string(workspace().join(file)).ok()?));
    wanted.filter_map(read).collect()
}

#[test]
fn words_of_public_types_stand_in_the_notation() {
    let page = page_words();
    let items = ["pub struct ", "pub enum ", "pub trait ", "pub type ", "pub union "];
    let mut missing = Vec::new();
    let mut names = 0;
    for (file, text) in files(&["crates"], &[".rs"]).iter().filter(|(file, _)| !file.contains("/tests/")) {
        for line in text.lines() {
            let Some(rest) = items.iter().find_map(|item| line.strip_prefix(item)) else { continue };
            let name = rest.split(|c: char| !c.is_alphanumeric()).next().unwrap();
            names += 1;
            let unknown = words(name).into_iter().filter(|word| word.len() > 1 && !stands(&page, word));
            missing.extend(unknown.map(|word| format!("{file}: {name}: {word}")));
        }
    }
    assert!(names > 400, "{names}");
    assert!(missing.is_empty(), "not in docs/notation.md: {missing:#?}");
}

/// The text of an HTML template without its elements and its blocks `{{ .. }}`, `{% .. %}`.
fn without_markup(text: &str) -> String {
    let mut plain = String::new();
    let mut closing = None;
    for c in text.chars() {
        match (closing, c) {
            (None, '<') => closing = Some('>'),
            (None, '{') => closing = Some('}'),
            (None, _) => plain.push(c),
            (Some(end), _) if end == c => closing = None,
            _ => {}
        }
    }
    plain
}

#[test]
fn words_of_headings_stand_in_the_notation() {
    let page = page_words();
    let mut missing = Vec::new();
    let mut headings = 0;
    for (file, text) in files(&["crates/report/templates"], &[".html"]) {
        for tag in ["h2", "h3", "th", "dt"] {
            let end = format!("</{tag}>");
            for part in text.split(&format!("<{tag}")).skip(1).filter_map(|part| part.split(&end).next()) {
                let shown = part.split_once('>').map_or("", |(_, shown)| shown);
                let plain = without_markup(shown);
                headings += 1;
                let words = plain.split(|c: char| !c.is_ascii_alphabetic()).map(str::to_lowercase);
                let unknown = words.filter(|word| word.len() > 3 && !stands(&page, word));
                missing.extend(unknown.map(|word| format!("{file}: {}: {word}", plain.trim())));
            }
        }
    }
    assert!(headings > 40, "{headings}");
    assert!(missing.is_empty(), "not in docs/notation.md: {missing:#?}");
}

/// Words that were replaced by a standard term must not occur in code, pages or messages.
#[test]
fn former_words_are_gone() {
    let former: std::collections::BTreeMap<String, String> =
        serde_yaml::from_str(include_str!("../../data/former_words.yaml")).unwrap();
    let mut found = Vec::new();
    let all = files(
        &["crates", "docs", "xtask", "README.md", "ARCHITECTURE.md", "CONTRIBUTING.md"],
        &[".rs", ".md", ".html", ".js", ".css", ".py", ".pyi"],
    );
    assert!(all.len() > 700, "{}", all.len());
    for (file, text) in &all {
        for (k, line) in text.lines().enumerate().filter(|(_, line)| !line.contains("is called")) {
            // The Python package keeps two former names, with a deprecation warning.
            let is_kept = |word: &str| file.starts_with("crates/python") && matches!(word, "Passport" | "untold");
            let said = former.iter().filter(|(word, _)| line.contains(word.as_str()) && !is_kept(word));
            found.extend(said.map(|(word, term)| format!("{file}:{}: `{word}` is {term}", k + 1)));
        }
    }
    assert!(found.is_empty(), "{found:#?}");
}

#[test]
fn words_of_names_are_found() {
    assert_eq!(words("LogCheck"), ["log", "check"]);
    assert_eq!(without_markup("a <b class=\"{{ x }}\">c</b>{% if d %}e").trim(), "a ce");
    let page = ["angle".to_string(), "zeros".to_string()];
    assert!(stands(&page, "angles") && stands(&page, "zero") && !stands(&page, "passport"));
}
