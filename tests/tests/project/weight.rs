//! Tests that the number of source lines without tests ("product lines"), of the core and of the wings (optional crates), does
//! not exceed tests/data/product_lines.yaml.

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use tests::{sources_below, workspace};

/// Number of lines of a file before its unit tests that are neither blank nor comments.
fn product_lines(text: &str) -> usize {
    let product = text.split("\n#[cfg(test)]\nmod ").next().unwrap_or_default();
    product.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with("//")).count()
}

/// Number of product lines in all files below a folder. Files and folders of tests have special names and are left out.
fn lines_below(folder: &Path) -> usize {
    let is_product = |path: &PathBuf| {
        let inside = path.strip_prefix(folder).unwrap();
        let is_other = |part: &OsStr| ["tests", "benches", "examples"].iter().any(|other| part == *other);
        let name = path.file_name().unwrap().to_string_lossy();
        !inside.iter().any(is_other) && !name.ends_with("tests.rs") && !name.starts_with("test_")
    };
    let files = sources_below(folder).into_iter().filter(is_product);
    files.map(|path| product_lines(&std::fs::read_to_string(path).unwrap())).sum()
}

#[test]
fn core_and_wings_are_no_heavier_than_they_were() {
    let text = include_str!("../../data/product_lines.yaml");
    let held: BTreeMap<String, usize> = serde_yaml::from_str(text).unwrap();
    let wings = lines_below(&workspace().join("crates/wings"));
    let found = [("core", lines_below(&workspace().join("crates")) - wings), ("wings", wings)];
    for (name, lines) in found {
        let most = held[name];
        assert!(
            lines <= most,
            "{name} has {lines} product lines, {most} are held: take lines out, or say in tests/data/product_lines.yaml which \
             user pays for more"
        );
    }
}

#[test]
fn tests_and_comments_are_no_product() {
    assert_eq!(
        product_lines("//! Head.\n\nfn f() {\n    // Why.\n    1\n}\n\n#[cfg(test)]\nmod tests {\n    fn g() {}\n}\n"),
        3
    );
}
