//! Tests of rules for the repository: dependencies of packages, length of files, white space.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use crate::source::orders::{ORDERS, WITHOUT_ORDER};
use crate::source::{imports, tokens};
use serde_json::Value as Json;
use tests::program::done;
use tests::{files_below, sources_below, text_of, workspace};

/// For each package: the packages of this workspace that it depends on (also as build or test dependency).
fn dependencies() -> BTreeMap<String, BTreeSet<String>> {
    dependencies_of(|_| true)
}

/// For each package: the packages of this workspace among the dependencies that `is_meant` selects from the metadata.
fn dependencies_of(is_meant: impl Fn(&Json) -> bool) -> BTreeMap<String, BTreeSet<String>> {
    let cargo = std::env::var("CARGO").unwrap_or("cargo".into());
    let out = done(&workspace(), &cargo, "metadata --no-deps --offline --format-version 1").out;
    let metadata: Json = serde_json::from_str(&out).unwrap();
    let packages = metadata["packages"].as_array().unwrap();
    let name = |v: &Json| v["name"].as_str().unwrap().to_string();
    let ours: BTreeSet<String> = packages.iter().map(name).collect();
    let of = |p: &Json| {
        let meant = p["dependencies"].as_array().unwrap().iter().filter(|d| is_meant(d));
        meant.map(name).filter(|d| ours.contains(d)).collect()
    };
    packages.iter().map(|p| (name(p), of(p))).collect()
}

#[test]
fn packages_know_whom_architecture_lets_them_know() {
    let text = text_of("ARCHITECTURE.md");
    let table: BTreeMap<String, String> = text
        .lines()
        .skip_while(|line| !line.starts_with("| package | knows |"))
        .skip(2)
        .take_while(|line| line.starts_with('|'))
        .map(|line| {
            let cells: Vec<String> = line.split('|').map(|cell| cell.replace('`', "").trim().to_string()).collect();
            (cells[1].clone(), cells[2].clone())
        })
        .collect();
    let found = dependencies();
    assert_eq!(table.keys().collect::<Vec<_>>(), found.keys().collect::<Vec<_>>(), "a row for each package");
    for (package, knows) in &found {
        let list = |names: &str| names.split(", ").map(String::from).collect::<BTreeSet<String>>();
        let allowed: BTreeSet<String> = match table[package].as_str() {
            "nothing" => BTreeSet::new(),
            "all" => found.keys().cloned().collect(),
            text => match text.strip_prefix("all but ") {
                Some(names) => found.keys().filter(|k| !list(names).contains(*k)).cloned().collect(),
                None => list(text),
            },
        };
        assert!(allowed.iter().all(|name| found.contains_key(name)), "{package}: {allowed:?}");
        assert!(knows.is_subset(&allowed), "{package} knows {knows:?}, ARCHITECTURE.md allows {allowed:?}");
    }
}

#[test]
fn what_repairs_generated_builds_without_it() {
    let found = dependencies();
    for package in ["xtask", "codegen", "modeling", "claims", "expr", "robot"] {
        let mut reached: BTreeSet<&String> = BTreeSet::new();
        let mut next: Vec<&String> = vec![found.get_key_value(package).unwrap().0];
        while let Some(name) = next.pop() {
            if reached.insert(name) {
                next.extend(&found[name]);
            }
        }
        assert!(!reached.contains(&"generated".to_string()), "{package} reaches generated: {reached:?}");
    }
}

/// Packages outside the workspace (Python, fuzz) must use the same versions of shared crates as the workspace.
#[test]
fn locks_outside_the_workspace_are_in_step() {
    let locked = |file: &str| -> BTreeMap<String, BTreeSet<String>> {
        let text = text_of(file);
        let mut found: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
        for package in text.split("[[package]]").skip(1) {
            let value = |key: &str| package.lines().find_map(|l| l.strip_prefix(key)?.strip_prefix(" = ")).unwrap();
            found.entry(value("name").into()).or_default().insert(value("version").into());
        }
        found
    };
    let ours = locked("Cargo.lock");
    for file in ["crates/python/Cargo.lock", "fuzz/Cargo.lock"] {
        let theirs = locked(file);
        let shared: Vec<_> = theirs.iter().filter_map(|(name, v)| Some((name, v, ours.get(name)?))).collect();
        assert!(shared.len() > 50, "{file}: {} packages of the workspace", shared.len());
        let apart = shared.iter().find(|(_, theirs, ours)| !theirs.is_subset(ours));
        assert!(apart.is_none(), "{file}: {apart:?}; copy Cargo.lock over it, and run `cargo metadata` beside it");
    }
}

/// The locks of the packages outside the workspace list what the packages of the workspace need. Otherwise `--locked` fails there.
#[test]
fn locks_outside_the_workspace_have_new_dependencies() {
    // Outside the workspace, a lock lists neither dependencies of tests nor optional ones that are not used.
    let ours = dependencies_of(|d| d["kind"].is_null() && d["optional"] == false);
    for file in ["crates/python/Cargo.lock", "fuzz/Cargo.lock"] {
        let text = text_of(file);
        let mut compared = 0;
        for package in text.split("[[package]]").skip(1) {
            let quoted = |line: &str| line.split('"').nth(1).unwrap_or_default().to_string();
            let name = package.lines().find(|line| line.starts_with("name = ")).map(quoted).unwrap_or_default();
            let Some(needs) = ours.get(&name) else { continue };
            let listed: BTreeSet<String> = package.lines().filter(|line| line.starts_with(" \"")).map(quoted).collect();
            let missing: Vec<&String> = needs.difference(&listed).collect();
            assert!(missing.is_empty(), "{file}: {name} lacks {missing:?}; run `cargo metadata` beside it");
            compared += 1;
        }
        assert!(compared > 10, "{file}: {compared} packages");
    }
}

/// Text files of the repository, without build output.
fn files() -> Vec<PathBuf> {
    let kinds = ["rs", "md", "toml", "yaml", "yml", "urdf", "par", "bib"];
    let is_text = |path: &PathBuf| path.extension().is_some_and(|e| kinds.iter().any(|kind| e == *kind));
    files_below(&workspace()).into_iter().filter(is_text).collect()
}

fn relative(path: &Path) -> String {
    path.strip_prefix(workspace()).unwrap().to_string_lossy().replace('\\', "/")
}

#[test]
fn a_file_over_four_hundred_lines_says_why() {
    let reasons: BTreeMap<String, String> = serde_yaml::from_str(include_str!("../../data/long_files.yaml")).unwrap();
    let mut long = BTreeSet::new();
    for path in files() {
        let name = relative(&path);
        if !name.ends_with(".rs") || name.starts_with("generated/src/robots/") {
            continue;
        }
        let n = std::fs::read_to_string(&path).unwrap().lines().count();
        if n > 400 {
            let why = "one algorithm per file: divide it, or give the reason in tests/data/long_files.yaml";
            assert!(reasons.get(&name).is_some_and(|r| !r.is_empty()), "{name} has {n} lines; {why}");
            long.insert(name);
        }
    }
    let stale: Vec<&String> = reasons.keys().filter(|name| !long.contains(*name)).collect();
    assert!(stale.is_empty(), "no longer long: {stale:?}; take them out of tests/data/long_files.yaml");
}

#[test]
fn lines_end_where_they_end() {
    let files = files();
    assert!(files.len() > 100, "{} files", files.len());
    for path in files {
        // Some files in testdata/ are malformed intentionally, so they are not checked.
        if relative(&path).contains("/testdata/") {
            continue;
        }
        let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        for (k, line) in text.lines().enumerate() {
            assert!(line == line.trim_end(), "{}:{}: space at the end of the line", relative(&path), k + 1);
            assert!(!line.contains('\r'), "{}:{}: a carriage return", relative(&path), k + 1);
        }
        assert!(text.is_empty() || text.ends_with('\n'), "{}: the last line does not end", relative(&path));
    }
}

#[test]
fn dead_code_is_allowed_nowhere() {
    for path in sources_below(&workspace()) {
        let name = relative(&path);
        let text = std::fs::read_to_string(path).unwrap();
        let allows = tokens::allows(tokens::tokens(&text, &name), "dead_code");
        assert!(!allows, "{name}: allow(dead_code)");
    }
}

/// Each of these pages must name all files that contain `unsafe`, in one paragraph or one list item.
#[test]
fn pages_name_the_files_with_unsafe() {
    let with_unsafe = |path: &&PathBuf| {
        let text = std::fs::read_to_string(path).unwrap();
        tokens::says(tokens::tokens(&text, &relative(path)), "unsafe")
    };
    let found: BTreeSet<String> =
        sources_below(&workspace()).iter().filter(with_unsafe).map(|path| relative(path)).collect();
    for page in ["SECURITY.md", "ARCHITECTURE.md"] {
        let text = text_of(page);
        let (_, list) = text.split_once("`unsafe` stands in").unwrap_or_else(|| panic!("{page} says where it stands"));
        let list = list.split("\n\n").next().and_then(|list| list.split("\n- ").next()).unwrap_or_default();
        let named = list.split('`').filter(|word| word.ends_with(".rs")).map(String::from).collect();
        assert_eq!(found, named, "{page}: the files that hold `unsafe`, and those that it names");
    }
}

/// Files of users may be opened only by the crate `gate`, which handles size limits, pipes, and files that change while they are
/// read. An exception is SQLite, which opens its file itself.
#[test]
fn no_crate_opens_a_file_to_read_beside_the_gate() {
    let ways = ["fs::read(", "read_to_string(", "File::open(", "stdin()", ".read(true)", "from_path("];
    let mut beside = Vec::new();
    for path in sources_below(&workspace()) {
        let name = relative(&path);
        if !name.starts_with("crates/") || !name.contains("/src/") || name.starts_with("crates/gate/") {
            continue;
        }
        let text = std::fs::read_to_string(path).unwrap();
        // Unit tests are at the end of a file, and may read the files that they wrote.
        let product = text.split("\n#[cfg(test)]\nmod ").next().unwrap().split("\n#[cfg(all(test").next().unwrap();
        let code = product.lines().enumerate().filter(|(_, line)| !line.trim_start().starts_with("//"));
        let found = code.filter(|(_, line)| ways.iter().any(|way| line.contains(way)));
        beside.extend(found.map(|(k, line)| format!("{name}:{}: {}", k + 1, line.trim())));
    }
    assert!(beside.is_empty(), "gate::source reads files: {beside:#?}");
}

#[test]
fn files_import_neither_in_circles_nor_back_up() {
    let mut places: BTreeSet<String> = BTreeSet::new();
    for path in files().iter().map(|p| relative(p)).filter(|p| p.ends_with(".rs")) {
        places.extend(path.split_once("/src/").map(|(package, _)| package.to_string()));
    }
    let named = ORDERS.iter().map(|o| o.0).chain(WITHOUT_ORDER.iter().map(|w| w.0)).map(String::from).collect();
    assert_eq!(places, named, "each package has its order in source/orders.rs, or a reason why it has none");
    let mut faults = Vec::new();
    for (package, order) in ORDERS {
        let source = format!("{package}/src/");
        let inside = |path: &PathBuf| {
            let name = relative(path).strip_prefix(&source)?.to_string();
            let text = std::fs::read_to_string(path).ok()?;
            name.ends_with(".rs").then_some((name, text))
        };
        let sources: BTreeMap<String, String> = files().iter().filter_map(inside).collect();
        faults.extend(imports::faults(&sources, order).into_iter().map(|fault| format!("{package}: {fault}")));
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}
