//! Tests that links, files and code items named in the documentation pages exist.

use std::path::{Path, PathBuf};

use tests::{text_of as text, workspace};

/// Paths of the Markdown pages, relative to the root of the repository.
fn pages() -> Vec<String> {
    let mut found = Vec::new();
    for folder in ["", "docs", "docs/how-to", ".github/ISSUE_TEMPLATE"] {
        let entries = std::fs::read_dir(workspace().join(folder)).unwrap_or_else(|e| panic!("{folder}: {e}"));
        let names = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).filter(|n| n.ends_with(".md"));
        found.extend(names.map(|name| Path::new(folder).join(name).display().to_string()));
    }
    found.sort();
    assert!(found.len() > 10, "{found:?}");
    found
}

/// The targets of `[text](target)`, without anchors and web addresses.
fn links(text: &str) -> Vec<&str> {
    let targets = text.split("](").skip(1).filter_map(|rest| Some(rest.split_once(')')?.0));
    let files = targets.filter_map(|target| target.split('#').next());
    files.filter(|file| !file.is_empty() && !file.contains("://")).collect()
}

/// The words of a page that name a file or folder of the repository. Words that contain a placeholder are omitted.
fn files_named(text: &str) -> Vec<&str> {
    let ends = |c: char| c.is_whitespace() || "`()|,;:'\"".contains(c);
    let words = text.split(ends).map(|word| word.trim_end_matches('.'));
    let roots = ["crates/", "docs/", "models/", "tests/", "xtask/", "generated/"];
    let named = |word: &&str| {
        let stands_in = word.contains("NAME") || word.contains(['*', '<', '{', '[']);
        roots.iter().any(|root| word.starts_with(root) && word.len() > root.len()) && !stands_in
    };
    words.filter(named).collect()
}

/// Code items named in a page: `crate::module::Item`.
fn items_named(text: &str) -> Vec<&str> {
    let crates = ["expr", "robot", "modeling", "codegen", "logs", "identification", "rist"];
    let code = text.split('`').skip(1).step_by(2).filter(|word| !word.contains(char::is_whitespace));
    code.filter(|word| word.split_once("::").is_some_and(|(first, _)| crates.contains(&first))).collect()
}

/// Whether the last name of the path `item` occurs as a word in the source of its module.
fn is_there(item: &str) -> bool {
    let parts: Vec<&str> = item.split("::").collect();
    let (Some(name), [first, modules @ ..]) = (parts.last(), &parts[..parts.len() - 1]) else { return false };
    let module: PathBuf = ["crates", first, "src"].iter().chain(modules).collect();
    let candidates = [module.with_extension("rs"), module.join("mod.rs"), module.join("lib.rs")];
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    candidates.iter().filter_map(|file| std::fs::read_to_string(workspace().join(file)).ok()).any(|source| {
        let public = source.lines().filter(|line| !line.trim_start().starts_with("//"));
        public.flat_map(|line| line.split(|c| !is_word(c))).any(|word| word == *name)
    })
}

#[test]
fn links_lead_somewhere() {
    for page in pages() {
        let folder = workspace().join(&page).parent().unwrap().to_path_buf();
        for link in links(&text(&page)) {
            assert!(folder.join(link).exists(), "{page}: there is no {link}");
        }
    }
}

#[test]
fn files_that_a_page_names_are_there() {
    let mut count = 0;
    for page in pages() {
        for file in files_named(&text(&page)) {
            assert!(workspace().join(file).exists(), "{page}: there is no {file}");
            count += 1;
        }
    }
    assert!(count > 40, "{count} files");
}

#[test]
fn items_that_a_page_names_are_there() {
    let mut count = 0;
    for page in pages() {
        for item in items_named(&text(&page)).into_iter().filter(|item| !item.contains("NAME")) {
            assert!(is_there(item), "{page}: there is no {item}");
            count += 1;
        }
    }
    assert!(count > 60, "{count} items");
}

/// The keys of a YAML file: the public fields of a struct, or the entries of a list of strings, after the line `head` in a source
/// file.
fn keys(file: &str, head: &str) -> Vec<String> {
    let source =
        std::fs::read_to_string(workspace().join("crates").join(file)).unwrap_or_else(|e| panic!("{file}: {e}"));
    let (_, body) = source.split_once(head).unwrap_or_else(|| panic!("{file} has no `{head}`"));
    let body = body.lines().skip(1).take_while(|line| !line.starts_with(['}', ']']));
    let key = |line: &str| match line.strip_prefix("    pub ") {
        Some(field) => field.split_once(':').map(|(name, _)| name.to_string()),
        None => line.trim().strip_prefix('"').and_then(|line| Some(line.strip_suffix("\",")?.to_string())),
    };
    let lines: Vec<&str> = body.collect();
    let is_in_file = |k: &usize| *k == 0 || lines[k - 1].trim() != "#[serde(skip)]";
    (0..lines.len()).filter(is_in_file).filter_map(|k| key(lines[k])).collect()
}

#[test]
fn every_key_of_a_file_stands_in_the_reference() {
    let page = text("docs/files.md");
    let identification = "identification/src/";
    let kinds = [
        ("Description", "robot/src/format/yaml/read.rs", "const ROOT_KEYS"),
        ("Description", "robot/src/format/yaml/link.rs", "const LINK_KEYS"),
        ("Options", &format!("{identification}estimate/options.rs"), "pub struct Options"),
        ("Options", "logs/src/columns/names.rs", "pub struct ColumnNames"),
        ("Options", &format!("{identification}signals/transmission.rs"), "pub struct Transmission"),
        ("Options", &format!("{identification}signals/signal_options.rs"), "pub struct Signal"),
        ("Load", "linear_model/src/known_load.rs", "pub struct KnownLoad"),
        ("Load", "linear_model/src/known_load.rs", "pub struct Inertia"),
        ("Limits", "experiments/src/excitation/limits.rs", "pub struct AskedLimits"),
        ("Limits", "experiments/src/excitation/limits.rs", "pub struct LimitsFile"),
        ("Limits", "experiments/src/excitation/space_limits.rs", "pub struct SpaceLimits"),
        ("Motion", "experiments/src/excitation/artefact.rs", "pub struct ExcitingMotion"),
        ("Plan", "experiments/src/plan/experiment_plan.rs", "pub struct ExperimentPlan"),
        ("Estimate", &format!("{identification}estimate/artefact.rs"), "pub struct Estimate"),
        ("Estimate", &format!("{identification}estimate/identified.rs"), "pub struct Identified"),
        ("Estimate", "linear_model/src/description_options.rs", "pub struct DescriptionOptions"),
        ("Validation", &format!("{identification}estimate/validation.rs"), "pub struct Validation"),
    ];
    for (section, file, head) in kinds {
        let (_, part) = page.split_once(&format!("\n## {section}\n")).unwrap_or_else(|| panic!("no section {section}"));
        let part = part.split("\n## ").next().unwrap();
        let keys = keys(file, head);
        assert!(keys.len() > 1, "{head} of {file}: {keys:?}");
        for key in keys {
            // Two fields of the struct have other names in the file.
            let written = match key.as_str() {
                "id" => "name",
                "relative_sigma" => "relative_sigma_percent",
                other => other,
            };
            assert!(part.contains(&format!("`{written}`")), "docs/files.md, {section}: `{written}` is missing");
        }
    }
}

#[test]
fn what_is_named_is_found() {
    assert_eq!(links("a [b](c.md#d), [e](#f), [g](https://h.i/j) and [k](../l)"), ["c.md", "../l"]);
    assert_eq!(
        files_named("in `crates/expr/src/`, tests/tests/NAME.rs and docs/a.md."),
        ["crates/expr/src/", "docs/a.md"]
    );
    assert_eq!(items_named("`robot::Robot`, `std::fs` and `cargo test`"), ["robot::Robot"]);
    assert!(is_there("robot::Robot") && !is_there("robot::Rabbit") && !is_there("robot::format::none::Robot"));
}
