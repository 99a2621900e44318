//! Tests that every citation has an entry in docs/references.bib, and that every entry is cited.
//!
//! Citations are in comments of Rust files and in pages of documentation, outside of backticks. The form is
//! `[Gautier, Khalil 1990]`, `[Golub, Van Loan 2013, 5.5; van der Sluis 1969, on scaling]`. In running text, a
//! surname directly before a year is a citation too. The key of an entry is its surnames, letters only, and the year.
//! Running text may say `Name et al. 2019` for a data set.
//! Generated files and the field `source` of a model are not checked, since they are read outside this repository.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use tests::{files_below, workspace};

/// A citation in a text.
#[derive(Debug, PartialEq)]
enum Citation {
    /// A citation in brackets. The text is the key of the entry in the bibliography.
    Key(String),
    /// A citation in running text: the last surname, and the year.
    LastNameAndYear(String, String),
    /// Text in brackets with a name before a year, which does not have the form of a citation.
    Malformed(String),
}

/// Key of an entry in the bibliography: the letters of its surnames, then the year.
fn key(surnames: &str, year: &str) -> String {
    surnames.chars().filter(|c| c.is_alphabetic()).chain(year.chars()).collect()
}

fn is_year(word: &str) -> bool {
    word.len() == 4
        && word.chars().all(|c| c.is_ascii_digit())
        && ["18", "19", "20"].iter().any(|c| word.starts_with(c))
}

/// All pairs (surname or `al.`, year) in which the year directly follows the word; `2019-01` and `2019/01` are not years.
fn names_before_years(text: &str) -> Vec<(&str, &str)> {
    let words: Vec<&str> = text.split_whitespace().collect();
    let is_name = |w: &str| w == "al." || w.starts_with(char::is_uppercase) && w.ends_with(char::is_lowercase);
    let year = |w: &str| w.trim_end_matches([',', '.', ';', ':', ')', '?', '!', '"']).to_string();
    let found = words.windows(2).filter(|w| is_name(w[0].trim_start_matches(['(', '"'])) && is_year(&year(w[1])));
    found.map(|w| (w[0].trim_start_matches(['(', '"']), &w[1][..4])).collect()
}

/// Parses one work of a citation in brackets: surnames, a blank, the year, and optionally a comma and the place in the work.
fn work(text: &str) -> Citation {
    let found = text.match_indices(' ').find(|(at, _)| text.get(at + 1..at + 5).is_some_and(is_year));
    let parsed = found.and_then(|(at, _)| {
        let (surnames, year, place) = (&text[..at], &text[at + 1..at + 5], &text[at + 5..]);
        let is_surname = |s: &str| !s.is_empty() && s.chars().all(|c| c.is_alphabetic() || " -'".contains(c));
        let ends = place.is_empty() || place.strip_prefix(", ").is_some_and(|p| !p.trim().is_empty());
        (ends && surnames.split(", ").all(is_surname)).then(|| Citation::Key(key(surnames, year)))
    });
    parsed.unwrap_or_else(|| Citation::Malformed(text.to_string()))
}

fn citations(text: &str) -> Vec<Citation> {
    let mut found = Vec::new();
    let outside = |text: &str, found: &mut Vec<Citation>| {
        let named = names_before_years(text).into_iter().filter(|(name, _)| *name != "al.");
        found.extend(named.map(|(name, year)| Citation::LastNameAndYear(name.to_string(), year.to_string())));
    };
    let mut rest = text;
    while let Some(open) = rest.find('[') {
        outside(&rest[..open], &mut found);
        rest = &rest[open + 1..];
        let Some(close) = rest.find(['[', ']']) else { break };
        let inside = &rest[..close];
        if rest[close..].starts_with(']') && !names_before_years(inside).is_empty() {
            found.extend(inside.split("; ").map(work));
            rest = &rest[close + 1..];
        }
    }
    outside(rest, &mut found);
    found
}

/// The text without the parts between backticks; `None` if a backtick has no partner.
fn without_code(text: &str) -> Option<String> {
    let parts: Vec<&str> = text.split('`').collect();
    (parts.len() % 2 == 1).then(|| parts.iter().step_by(2).copied().collect::<Vec<_>>().join(" "))
}

/// The comments of a Rust file, one text per block of lines; a Markdown page is one text.
fn prose(path: &Path) -> Vec<String> {
    let text = std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    if path.extension().is_some_and(|e| e == "md") {
        return vec![text];
    }
    let mut runs = vec![String::new()];
    for line in text.lines().map(str::trim_start) {
        match line.strip_prefix("//") {
            Some(comment) => {
                let run = runs.last_mut().expect("there is always a run");
                *run += comment.trim_start_matches(['/', '!']);
                run.push(' ');
            }
            None if runs.last().is_some_and(|r| !r.is_empty()) => runs.push(String::new()),
            None => {}
        }
    }
    runs
}

/// The Rust and Markdown files of the repository that may contain citations.
fn cited_in() -> Vec<std::path::PathBuf> {
    let robots = workspace().join("generated/src/robots");
    let may_cite = |path: &Path| path.extension().is_some_and(|e| e == "rs" || e == "md") && !path.starts_with(&robots);
    files_below(&workspace()).into_iter().filter(|path| may_cite(path)).collect()
}

/// Entries of a .bib file: key -> (field name -> value, with the entry type as field `kind`).
fn entries(text: &str) -> BTreeMap<String, BTreeMap<String, String>> {
    let mut found = BTreeMap::new();
    for entry in text.split("\n@").skip(1) {
        let (kind, rest) = entry.split_once('{').expect("an entry opens a brace");
        let (key, fields) = rest.split_once(',').expect("an entry begins with its key");
        let mut of: BTreeMap<String, String> = [("kind".to_string(), kind.to_string())].into();
        for field in fields.split("},\n") {
            if let Some((name, value)) = field.split_once(" = {") {
                of.insert(name.trim().to_string(), value.split_whitespace().collect::<Vec<_>>().join(" "));
            }
        }
        assert!(found.insert(key.to_string(), of).is_none(), "two entries {key}");
    }
    found
}

/// Surnames in the field `author`, without initials.
fn surnames(author: &str) -> Vec<String> {
    let one = |name: &str| name.split(' ').filter(|w| !w.ends_with('.')).collect::<Vec<_>>().join(" ");
    author.split(" and ").map(one).collect()
}

fn bibliography() -> BTreeMap<String, BTreeMap<String, String>> {
    let path = workspace().join("docs/references.bib");
    entries(&std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display())))
}

#[test]
fn every_citation_has_an_entry_and_every_entry_is_cited() {
    let entries = bibliography();
    let mut by_last_name: BTreeMap<(String, String), BTreeSet<String>> = BTreeMap::new();
    for (key, fields) in &entries {
        let last = surnames(&fields["author"]).pop().unwrap_or_default();
        let last = last.split(' ').next_back().unwrap_or_default().to_string();
        by_last_name.entry((last, fields["year"].clone())).or_default().insert(key.clone());
    }
    let mut cited: BTreeSet<String> = BTreeSet::new();
    let mut faults = Vec::new();
    for path in cited_in() {
        let place = path.strip_prefix(workspace()).unwrap().display().to_string();
        let mut found = Vec::new();
        for text in prose(&path) {
            match without_code(&text) {
                Some(text) => found.extend(citations(&text)),
                None => faults.push(format!("{place}: a backtick without its partner in: {}", text.trim())),
            }
        }
        for citation in found {
            match citation {
                Citation::Malformed(text) => faults
                    .push(format!("{place}: [{text}] is not of the form [Surname, Surname 1990, place; Surname 1991]")),
                Citation::Key(key) if entries.contains_key(&key) => drop(cited.insert(key)),
                Citation::Key(key) => faults.push(format!("{place}: docs/references.bib has no entry {key}")),
                Citation::LastNameAndYear(name, year) => match by_last_name.get(&(name.clone(), year.clone())) {
                    Some(keys) => cited.extend(keys.iter().cloned()),
                    None => faults.push(format!("{place}: docs/references.bib has no work of {name} {year}")),
                },
            }
        }
    }
    let idle: Vec<&String> = entries.keys().filter(|key| !cited.contains(*key)).collect();
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    assert!(idle.is_empty(), "nothing cites {idle:?}; take them out of docs/references.bib");
}

#[test]
fn an_entry_is_complete_and_under_its_key() {
    let entries = bibliography();
    assert!(entries.len() > 30, "{} entries", entries.len());
    for (name, fields) in &entries {
        let needs: &[&str] = match fields["kind"].as_str() {
            "article" => &["journal", "volume", "pages"],
            "inproceedings" => &["booktitle", "pages"],
            "book" => &["publisher"],
            "misc" => &["url"],
            kind => panic!("{name}: a kind `{kind}`; there are article, inproceedings, book and misc"),
        };
        for field in ["author", "title", "year"].iter().chain(needs) {
            assert!(fields.get(*field).is_some_and(|v| !v.is_empty()), "{name} has no {field}");
        }
        let found = ["doi", "url", "isbn", "note"].iter().any(|f| fields.contains_key(*f));
        assert!(found, "{name}: a doi, an isbn or a url, or a note that says what could not be checked");
        assert_eq!(*name, key(&surnames(&fields["author"]).concat(), &fields["year"]), "the key of {name}");
    }
}

#[test]
fn citations_are_found_in_their_form_only() {
    let key = |k: &str| Citation::Key(k.to_string());
    let one = "as in [Golub, Van Loan 2013, 5.5; van der Sluis 1969, on scaling], not in y[i] or [a link](x.md)";
    assert_eq!(citations(one), [key("GolubVanLoan2013"), key("vanderSluis1969")]);
    let last = |n: &str, y: &str| Citation::LastNameAndYear(n.to_string(), y.to_string());
    assert_eq!(citations("after Cody and Waite 1980, measured on 2026-11-21 in ICRA 1995"), [last("Waite", "1980")]);
    assert_eq!(citations("[see Huber 1981 there]"), [Citation::Malformed("see Huber 1981 there".to_string())]);
    assert_eq!(citations("x[0] [Gautier et al. 1997]"), [Citation::Malformed("Gautier et al. 1997".to_string())]);
    assert_eq!(without_code("as `[Huber 1981]` in [Huber 1981]").as_deref(), Some("as   in [Huber 1981]"));
    assert_eq!(without_code("one `code"), None);
    let bib = "% head\n\n@book{Huber1981,\n  author = {P. J. Huber},\n  title = {Robust\n    statistics},\n}\n";
    assert_eq!(entries(bib)["Huber1981"]["title"], "Robust statistics");
    assert_eq!(surnames("J.-J. E. Slotine and S. Van Huffel"), ["Slotine", "Van Huffel"]);
}
