//! Tests of the messages in the libraries. They contain no command-line flag. Names of request fields are in brackets, and are
//! spelled as flags by the program and as arguments by the Python package.

use std::path::PathBuf;

use proc_macro2::{Delimiter, TokenStream, TokenTree};
use rist::request::all_fields;
use rist::request::spelling::{Audience, spelled};
use tests::snapshot::assert_snapshot;
use tests::{register_wings, sources_below, workspace};

/// Packages that serve only one kind of user. Their messages may contain flags.
const SURFACES: [&str; 2] = ["cli", "python"];

/// Collects the string literals, apart from attributes (doc comments) and tests.
fn texts(tokens: TokenStream, found: &mut Vec<String>) {
    let mut before: Vec<String> = Vec::new();
    for token in tokens {
        match &token {
            TokenTree::Group(group) => {
                let is_attribute = group.delimiter() == Delimiter::Bracket
                    && (before.ends_with(&["#".into()]) || before.ends_with(&["#".into(), "!".into()]));
                let is_test = before.ends_with(&["mod".into(), "tests".into()]);
                if !is_attribute && !is_test {
                    texts(group.stream(), found);
                }
            }
            TokenTree::Literal(literal) => {
                let text = literal.to_string();
                if text.starts_with('"') || text.starts_with('r') {
                    // A literal that continues on the next line counts as one text.
                    let lines: Vec<&str> = text.split("\\\n").collect();
                    let joined =
                        lines.iter().enumerate().map(|(i, line)| if i == 0 { line } else { line.trim_start() });
                    found.push(joined.collect::<String>().trim_matches('"').to_string());
                }
            }
            _ => {}
        }
        before.push(token.to_string());
    }
}

/// The texts of the libraries without duplicates, in the order of the files.
fn library_texts() -> Vec<(PathBuf, String)> {
    let mut all = Vec::new();
    let folders = ["crates", "crates/wings"].map(|folder| std::fs::read_dir(workspace().join(folder)).unwrap());
    for package in folders.into_iter().flatten().map(|entry| entry.unwrap().path()).filter(|p| p.join("src").is_dir()) {
        let name = package.file_name().unwrap().to_string_lossy().into_owned();
        if SURFACES.contains(&name.as_str()) {
            continue;
        }
        for file in sources_below(&package.join("src")) {
            let mut found = Vec::new();
            texts(std::fs::read_to_string(&file).unwrap().parse().unwrap(), &mut found);
            let place = file.strip_prefix(workspace()).unwrap().to_path_buf();
            all.extend(found.into_iter().map(|text| (place.clone(), text)));
        }
    }
    all.sort();
    all.dedup();
    all
}

#[test]
fn no_text_of_a_library_has_a_flag_in_it() {
    let all = library_texts();
    assert!(all.len() > 2000, "{} texts", all.len());
    let has_flag = |text: &str| {
        text.match_indices("--").any(|(at, _)| text[at + 2..].starts_with(|c: char| c.is_ascii_lowercase()))
    };
    let flags: Vec<_> = all.iter().filter(|(_, text)| has_flag(text)).collect();
    assert!(flags.is_empty(), "write the field in brackets: [rate], [delay=auto]: {flags:#?}");
    let is_step = |behind: &str| behind.starts_with(|c: char| c.is_ascii_lowercase());
    let is_unknown = |text: &str| spelled(text, Audience::Python).split("[:").skip(1).any(is_step);
    let steps: Vec<_> = all.iter().filter(|(file, text)| !file.ends_with("spelling.rs") && is_unknown(text)).collect();
    assert!(steps.is_empty(), "no such step: {steps:#?}");
    // Python functions that a text recommends must exist.
    let stub = std::fs::read_to_string(workspace().join("crates/python/python/rist/__init__.pyi")).unwrap();
    let inside = |text: &str| text.split("[:").skip(1).filter_map(|t| Some(t.split_once(']')?.0.to_string())).collect();
    let advised: Vec<String> = all.iter().flat_map(|(_, text)| -> Vec<String> { inside(text) }).collect();
    assert!(advised.len() > 10, "{advised:?}");
    for step in advised {
        let call = spelled(&format!("[:{step}]"), Audience::Python);
        let Some(name) = call.strip_prefix("rist.").and_then(|call| call.split('(').next()) else { continue };
        let is_there = [format!("\ndef {name}("), format!("\nclass {name}")].iter().any(|line| stub.contains(line));
        assert!(is_there, "[:{step}] is {call}, which the package lacks");
    }
    register_wings();
    for field in all_fields() {
        assert!(!has_flag(&field.doc), "{}: {}", field.name, field.doc);
    }
}

#[test]
fn fields_in_texts_are_spelled_as_they_were() {
    register_wings();
    let named = |text: &str| spelled(text, Audience::Program) != text;
    let mut table = String::new();
    for (_, text) in library_texts().iter().filter(|(file, text)| named(text) && !file.ends_with("spelling.rs")) {
        table += &format!("{text}\n  {}\n  {}\n\n", spelled(text, Audience::Program), spelled(text, Audience::Python));
    }
    assert!(table.matches("\n\n").count() > 40, "{table}");
    assert_snapshot("refusals/spelled.txt", &table);
}
