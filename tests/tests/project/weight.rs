//! How many product lines core and wings have: the numbers of tests/data/product_lines.yaml may fall.

use std::collections::BTreeMap;
use std::path::Path;

use tests::workspace;

/// Lines of a file that are neither blank nor comments, before its tests.
fn product_lines(text: &str) -> usize {
    let product = text.split("\n#[cfg(test)]\nmod ").next().unwrap_or_default();
    product.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with("//")).count()
}

/// Product lines below a folder. Tests stand in folders and files of their own name.
fn lines_below(folder: &Path) -> usize {
    let mut sum = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if path.is_dir() && !["tests", "benches", "examples", "target"].contains(&name.as_str()) {
            sum += lines_below(&path);
        } else if name.ends_with(".rs") && !name.ends_with("tests.rs") && !name.starts_with("test_") {
            sum += product_lines(&std::fs::read_to_string(&path).unwrap());
        }
    }
    sum
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
