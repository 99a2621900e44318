//! Writes THIRD_PARTY_NOTICES: the crates in the program and in the Python package, each with its licence and the texts that must
//! accompany a binary. With `--check`, it only compares. `cargo xtask notices` calls it.
//!
//! Crates of macros and build scripts are not listed, because no binary contains them. If a crate can be used under MIT, the MIT
//! text is used. A text that several crates share is written once. On any machine, the list is made for Linux on x86-64.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::{Command, ExitCode};

use serde_json::Value;
use tests::workspace;

const FILE: &str = "THIRD_PARTY_NOTICES";
const PLATFORM: &str = "x86_64-unknown-linux-gnu";

/// The binaries with linked crates: for each, the manifest next to its lock file, and the package.
const BINARIES: [[&str; 2]; 2] = [["Cargo.toml", "cli"], ["crates/python/Cargo.toml", "python"]];

const HEAD: &str = "\
THIRD-PARTY NOTICES

The program rist and the package rist for Python hold the crates below, each under its own licence.
`cargo xtask notices` writes this file from the packages that Cargo.lock names; `rist notices` prints it.
SQLite, which libsqlite3-sys holds, is in the public domain.
";

/// Files whose name starts with one of these words contain a licence or a notice.
const NOTICE_FILES: [&str; 6] = ["LICENSE", "LICENCE", "COPYING", "NOTICE", "UNLICENSE", "COPYRIGHT"];

#[derive(Clone, PartialEq, Eq, PartialOrd, Ord)]
struct Linked {
    name: String,
    version: String,
    licence: String,
    folder: String,
    repository: String,
    authors: Vec<String>,
}

fn main() -> ExitCode {
    let is_check = match std::env::args().nth(1).as_deref() {
        None => false,
        Some("--check") => true,
        Some(other) => return failed(&format!("`{other}` is no argument; expected: none, or --check")),
    };
    let text = match notices() {
        Ok(text) => text,
        Err(message) => return failed(&message),
    };
    let place = workspace().join(FILE);
    let found = std::fs::read_to_string(&place).unwrap_or_default();
    match is_check {
        true if found == text => ExitCode::SUCCESS,
        true => failed(&format!("{FILE} is not what Cargo.lock brings in; `cargo xtask notices` writes it")),
        false => match std::fs::write(&place, text) {
            Ok(()) => ExitCode::SUCCESS,
            Err(e) => failed(&format!("{}: {e}", place.display())),
        },
    }
}

fn failed(message: &str) -> ExitCode {
    eprintln!("{message}");
    ExitCode::FAILURE
}

fn notices() -> Result<String, String> {
    let mut crates = BTreeSet::new();
    for [manifest, package] in BINARIES {
        crates.extend(linked(&workspace().join(manifest), package)?);
    }
    let mut by_text: BTreeMap<String, Vec<String>> = BTreeMap::new();
    let (mut out, mut without) = (HEAD.to_string(), String::new());
    out += "\nCrates and their licences\n\n";
    for one in &crates {
        out += &format!("{} {}: {}\n", one.name, one.version, one.licence);
        // If a crate has no licence text, the text of another crate from the same repository is used.
        let kin = crates.iter().filter(|kin| kin.repository == one.repository && kin.licence == one.licence);
        let texts = std::iter::once(one).chain(kin).map(texts).find(|texts| !texts.is_empty()).unwrap_or_default();
        if texts.is_empty() {
            let authors = if one.authors.is_empty() { "its authors".into() } else { one.authors.join(", ") };
            without +=
                &format!("{} {}: {}; copyright {authors}; {}\n", one.name, one.version, one.licence, one.repository);
        }
        for text in texts {
            by_text.entry(text).or_default().push(format!("{} {}", one.name, one.version));
        }
    }
    out += "\nCrates whose packages hold no text of their licence\n\n";
    out += &without;
    let mut texts: Vec<(Vec<String>, String)> = by_text.into_iter().map(|(text, names)| (names, text)).collect();
    texts.sort();
    for (names, text) in texts {
        out += &format!("\n{}\n{}\n\n{text}\n", "=".repeat(80), names.join(", "));
    }
    Ok(out)
}

/// The crates of other authors that are linked into a package.
fn linked(manifest: &Path, package: &str) -> Result<BTreeSet<Linked>, String> {
    let cargo = std::env::var_os("CARGO").unwrap_or("cargo".into());
    let mut metadata = Command::new(cargo);
    metadata.args(["metadata", "--locked", "--format-version", "1", "--filter-platform", PLATFORM, "--manifest-path"]);
    let out = metadata.arg(manifest).output().map_err(|e| format!("cargo metadata: {e}"))?;
    if !out.status.success() {
        let said = String::from_utf8_lossy(&out.stderr).into_owned();
        return Err(format!("cargo metadata of {}: {said}", manifest.display()));
    }
    let metadata: Value = serde_json::from_slice(&out.stdout).map_err(|e| e.to_string())?;
    let list = |value: &Value| value.as_array().cloned().unwrap_or_default();
    let text = |value: &Value| value.as_str().unwrap_or_default().to_string();
    let packages: BTreeMap<String, Value> =
        list(&metadata["packages"]).into_iter().map(|p| (text(&p["id"]), p)).collect();
    let nodes: BTreeMap<String, Value> =
        list(&metadata["resolve"]["nodes"]).into_iter().map(|n| (text(&n["id"]), n)).collect();
    let root = packages.iter().find(|(_, p)| p["source"].is_null() && p["name"] == package);
    let root = root.ok_or_else(|| format!("{} has no package {package}", manifest.display()))?;
    let (mut seen, mut left, mut found) = (BTreeSet::new(), vec![root.0.clone()], BTreeSet::new());
    while let Some(id) = left.pop() {
        let package = &packages[&id];
        let is_macro = list(&package["targets"]).iter().any(|t| list(&t["kind"]).iter().any(|k| k == "proc-macro"));
        if is_macro || !seen.insert(id.clone()) {
            continue;
        }
        if !package["source"].is_null() {
            let folder = Path::new(package["manifest_path"].as_str().unwrap_or_default()).parent();
            found.insert(Linked {
                name: text(&package["name"]),
                version: text(&package["version"]),
                licence: text(&package["license"]),
                folder: folder.map(|folder| folder.display().to_string()).unwrap_or_default(),
                repository: text(&package["repository"]),
                authors: list(&package["authors"]).iter().map(text).collect(),
            });
        }
        let normal = |dependency: &Value| list(&dependency["dep_kinds"]).iter().any(|kind| kind["kind"].is_null());
        left.extend(list(&nodes[&id]["deps"]).iter().filter(|d| normal(d)).map(|d| text(&d["pkg"])));
    }
    Ok(found)
}

/// The licence texts that must accompany a binary with this crate.
fn texts(one: &Linked) -> Vec<String> {
    let entries = std::fs::read_dir(&one.folder).into_iter().flatten().flatten();
    let mut names: Vec<String> = entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    names.retain(|name| NOTICE_FILES.iter().any(|first| name.to_uppercase().starts_with(first)));
    names.sort();
    let is_choice = one.licence.contains(" OR ") || one.licence.contains('/');
    let is_mit = |name: &String| name.to_uppercase().contains("MIT");
    if is_choice && one.licence.contains("MIT") && !one.licence.contains("AND") && names.iter().any(is_mit) {
        names.retain(|name| is_mit(name) || name.to_uppercase().starts_with("NOTICE"));
    }
    let read = |name: &String| std::fs::read_to_string(Path::new(&one.folder).join(name)).ok();
    let plain = |text: String| text.lines().map(str::trim_end).collect::<Vec<_>>().join("\n").trim().to_string();
    names.iter().filter_map(read).map(plain).filter(|text| !text.is_empty()).collect()
}
