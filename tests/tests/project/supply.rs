//! Tests of the third-party crates in the lock files. Each crate with a known weakness may be used by only one other crate, and
//! each exception in deny.toml states its reason.

use std::collections::{BTreeMap, BTreeSet};

use tests::{has, sources_below, text_of as text, workspace};

/// Crates with a known weakness: (name, the only crate that may depend on it). deny.toml has the reasons.
const ALONE: [(&str, &str); 2] = [("quick-xml", "urdf-rs"), ("RustyXML", "urdf-rs")];

/// Versions without the weakness, in the form in which a lock file writes them if it contains several versions of a crate.
/// RUSTSEC-2026-0194 and 0195 are fixed in 0.41.
const PATCHED: [&str; 1] = ["quick-xml 0.42.0"];

/// For each crate in a lock file: its direct dependencies of all kinds.
fn locked(file: &str) -> BTreeMap<String, BTreeSet<String>> {
    let text = text(file);
    let quoted = |line: &str| {
        let whole = line.split('"').nth(1).unwrap_or_default();
        let is_patched = PATCHED.contains(&whole);
        if is_patched { whole } else { whole.split(' ').next().unwrap_or_default() }.to_string()
    };
    let of = |package: &str| {
        let name = package.lines().find(|line| line.starts_with("name = ")).map(quoted).unwrap_or_default();
        let dependencies = package.lines().skip_while(|line| !line.starts_with("dependencies = ")).skip(1);
        (name, dependencies.take_while(|line| *line != "]").map(quoted).collect())
    };
    text.split("[[package]]").skip(1).map(of).collect()
}

/// urdf-rs uses quick-xml only for writing, and rist writes nothing with urdf-rs. urdf-rs uses RustyXML for reading, but only
/// reads text that rist has checked before.
#[test]
fn weak_crates_are_reached_by_one_crate_alone() {
    for file in ["Cargo.lock", "crates/python/Cargo.lock", "fuzz/Cargo.lock"] {
        let locked = locked(file);
        assert!(locked.len() > 100, "{file}: {}", locked.len());
        for (weak, alone) in ALONE {
            let users: Vec<&String> =
                locked.iter().filter(|(_, needs)| needs.contains(weak)).map(|(name, _)| name).collect();
            assert_eq!(users, [alone], "{file}: whoever needs {weak}");
        }
    }
}

/// No source file of this repository names these crates, or calls a function of urdf-rs that writes.
#[test]
fn nothing_of_ours_names_weak_crates_or_writes_with_urdf_rs() {
    let folders = ["crates", "xtask", "tests", "fuzz"].into_iter();
    let files: Vec<_> = folders.flat_map(|folder| sources_below(&workspace().join(folder))).collect();
    assert!(files.len() > 400, "{}", files.len());
    for place in files.iter().filter(|place| !place.ends_with("tests/tests/project/supply.rs")) {
        let text = std::fs::read_to_string(place).unwrap();
        for word in ["quick_xml::", "RustyXML", "xml::Element", "urdf_rs::write", "write_to_string"] {
            assert!(!text.contains(word), "{}: `{word}`; why not: deny.toml", place.display());
        }
    }
}

#[test]
fn each_exception_has_its_reason() {
    let deny = text("deny.toml");
    let ignored: Vec<&str> = deny.lines().filter(|line| line.contains("RUSTSEC-")).collect();
    assert!(!ignored.is_empty());
    for line in ignored {
        let reason = line.split("reason = \"").nth(1).unwrap_or_default();
        assert!(reason.len() > 20, "no reason: {line}");
        assert!(ALONE.iter().any(|(weak, _)| reason.starts_with(weak)), "of which crate: {line}");
    }
    for (weak, alone) in ALONE {
        assert!(deny.contains(weak) && deny.contains(alone), "deny.toml does not say why {weak} is there");
    }
}

/// The licences BSD, Unicode and Zlib require that their text accompanies a binary. For each linked crate under such a licence,
/// THIRD_PARTY_NOTICES must contain it.
#[test]
fn notices_hold_what_asks_for_its_notice() {
    let notices = text("THIRD_PARTY_NOTICES");
    for (name, holder) in [
        ("snap", "Copyright 2011, The Snappy-Rust Authors"),
        ("brotli-decompressor", "Dropbox"),
        ("alloc-stdlib", "Dropbox"),
    ] {
        assert!(notices.contains(&format!("\n{name} ")), "{name}");
        assert!(notices.contains(holder), "{holder}");
    }
    has(&notices, &["Redistributions in binary form must reproduce the above copyright", "UNICODE LICENSE V3"]);
    let lock = locked("Cargo.lock");
    let listed = notices.split("\n\n").find(|part| part.contains("\nsnap ")).unwrap_or_default();
    for line in listed.lines() {
        let name = line.split(' ').next().unwrap_or_default();
        assert!(
            lock.contains_key(name) || locked("crates/python/Cargo.lock").contains_key(name),
            "{name} is not locked"
        );
    }
}
