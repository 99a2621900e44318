//! Reads the pages of the book (titles, anchors and links), and checks that the target of each link exists.
//!
//! The pages are those of docs/ and some pages of the root folder. An anchor is the name of a heading in a link.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Component, Path, PathBuf};

use crate::cargo::root;

/// The page whose table determines the order of the other pages.
const TABLE: &str = "docs/README.md";
/// The pages in the root folder. They form the last part of the book.
const ROOT_PAGES: [&str; 4] = ["ARCHITECTURE.md", "CONTRIBUTING.md", "SECURITY.md", "CHANGELOG.md"];

/// A page of the book. `name`: its path relative to the root.
pub(crate) struct Page {
    pub(crate) name: String,
    text: String,
}

/// All pages: README, the pages of docs/, and the other pages of the root.
pub(crate) fn pages() -> Result<Vec<Page>, String> {
    let mut names = vec!["README.md".to_string()];
    names.extend(ROOT_PAGES.map(String::from));
    for folder in ["docs", "docs/how-to", "docs/ur5", "docs/checkers"] {
        let entries = std::fs::read_dir(root().join(folder)).map_err(|e| format!("{folder}: {e}"))?;
        let found = entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
        names.extend(found.filter(|name| name.ends_with(".md")).map(|name| format!("{folder}/{name}")));
    }
    names.sort();
    let read = |name: String| match std::fs::read_to_string(root().join(&name)) {
        Ok(text) => Ok(Page { name, text }),
        Err(e) => Err(format!("{name}: {e}")),
    };
    names.into_iter().map(read).collect()
}

impl Page {
    /// The lines of the page outside of code blocks.
    fn prose(&self) -> impl Iterator<Item = &str> {
        let mut is_code = false;
        self.text.lines().filter(move |line| {
            let is_fence = line.trim_start().starts_with("```");
            is_code ^= is_fence;
            !is_code && !is_fence
        })
    }

    /// The first heading of the page. Fails if there is none.
    pub(crate) fn title(&self) -> Result<&str, String> {
        let title = self.prose().find_map(|line| line.strip_prefix("# "));
        title.ok_or(format!("{} has no heading", self.name))
    }

    /// The anchors of the headings, formed as GitHub and mdBook form them.
    fn anchors(&self) -> BTreeSet<String> {
        let headings = self.prose().filter(|line| line.starts_with('#'));
        let anchor = |line: &str| {
            let text = line.trim_start_matches('#').trim().to_lowercase();
            let kept = text.chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c));
            kept.map(|c| if c == ' ' { '-' } else { c }).collect()
        };
        headings.map(anchor).collect()
    }

    /// The links and pictures that refer to files of the repository: file, and anchor (empty if there is none).
    pub(crate) fn links(&self) -> Vec<(&str, &str)> {
        let of_line = |line: &'_ str| -> Vec<(usize, usize)> {
            let starts =
                line.match_indices("](").map(|(i, _)| i + 2).chain(line.match_indices("src=\"").map(|(i, _)| i + 5));
            starts.filter_map(|i| Some((i, i + line[i..].find([')', '"'])?))).collect()
        };
        let targets = self.prose().flat_map(|line| of_line(line).into_iter().map(move |(from, to)| &line[from..to]));
        let own = targets.filter(|target| !target.contains("://") && !target.is_empty());
        own.map(|target| target.split_once('#').unwrap_or((target, ""))).collect()
    }

    /// The files that the page links to, with paths relative to the root.
    pub(crate) fn targets(&self) -> impl Iterator<Item = PathBuf> {
        self.links().into_iter().filter(|(file, _)| !file.is_empty()).map(|(file, _)| self.resolved(file))
    }

    /// Converts the path of a link in this page to a path relative to the root.
    fn resolved(&self, file: &str) -> PathBuf {
        let folder = Path::new(&self.name).parent().unwrap_or(Path::new(""));
        let mut path = PathBuf::new();
        for part in folder.join(file).components() {
            match part {
                Component::ParentDir => {
                    path.pop();
                }
                Component::CurDir => {}
                other => path.push(other),
            }
        }
        path
    }
}

/// The parts of the book, each with its pages. First come the parts that the table in docs/README.md lists, then the pages in the
/// root folder.
pub(crate) fn chapters(pages: &[Page]) -> Result<Vec<(String, Vec<&Page>)>, String> {
    let table = pages.iter().find(|page| page.name == TABLE).ok_or(format!("there is no {TABLE}"))?;
    let by_name: BTreeMap<&str, &Page> = pages.iter().map(|page| (page.name.as_str(), page)).collect();
    let mut parts: Vec<(String, Vec<&Page>)> = Vec::new();
    for line in table.prose().filter(|line| line.starts_with("| ")).skip(1) {
        let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
        let [part, _, link] = cells.as_slice() else { return Err(format!("{TABLE}: three cells, not `{line}`")) };
        if !part.is_empty() {
            parts.push(((*part).to_string(), Vec::new()));
        }
        let target = link.split_once("](").and_then(|(_, rest)| rest.split_once(')')).map(|(target, _)| target);
        let Some(target) = target.filter(|target| target.ends_with(".md") && !target.starts_with("..")) else {
            continue;
        };
        let name = table.resolved(target).display().to_string();
        let page = by_name.get(name.as_str()).ok_or(format!("{TABLE}: there is no {name}"))?;
        parts.last_mut().ok_or(format!("{TABLE}: the first row has no part"))?.1.push(page);
    }
    let house = ROOT_PAGES.iter().filter_map(|name| by_name.get(name).copied()).collect();
    parts.push(("The house".into(), house));
    Ok(parts)
}

/// Messages about links without a target, and about pages that do not occur exactly once in the book.
pub(crate) fn faults(pages: &[Page]) -> Result<Vec<String>, String> {
    let mut faults = Vec::new();
    let anchors: BTreeMap<PathBuf, BTreeSet<String>> =
        pages.iter().map(|page| (PathBuf::from(&page.name), page.anchors())).collect();
    for page in pages {
        page.title()?;
        for (file, anchor) in page.links() {
            let target = if file.is_empty() { PathBuf::from(&page.name) } else { page.resolved(file) };
            if !root().join(&target).exists() {
                faults.push(format!("{}: there is no {file}", page.name));
            } else if !anchor.is_empty() && anchors.get(&target).is_some_and(|known| !known.contains(anchor)) {
                faults.push(format!("{}: {} has no heading #{anchor}", page.name, target.display()));
            }
        }
    }
    let chapters = chapters(pages)?;
    let placed: Vec<&str> =
        chapters.iter().flat_map(|(_, pages)| pages.iter().map(|page| page.name.as_str())).collect();
    for page in pages.iter().filter(|page| page.name != "README.md" && page.name != TABLE) {
        match placed.iter().filter(|name| **name == page.name).count() {
            1 => {}
            count => faults.push(format!("{}: {count} places in the table of {TABLE}; one is expected", page.name)),
        }
    }
    Ok(faults)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn page(name: &str, text: &str) -> Page {
        Page { name: name.into(), text: text.into() }
    }

    #[test]
    fn links_and_anchors_are_found() {
        let text = "# A page\n\n## Drive gains, and a load\n[x](../b.md#y) <img src=\"p.svg\"> [w](https://a.b)\n```\n[no](no.md)\n```\n";
        let page = page("docs/how-to/a.md", text);
        assert_eq!(page.links(), [("../b.md", "y"), ("p.svg", "")]);
        assert_eq!(page.title(), Ok("A page"));
        assert!(page.anchors().contains("drive-gains-and-a-load"));
        let targets: Vec<PathBuf> = page.targets().collect();
        assert_eq!(targets, [Path::new("docs/b.md"), Path::new("docs/how-to/p.svg")]);
    }

    #[test]
    fn what_leads_nowhere_is_said() {
        let table = page(TABLE, "# Book\n| | for | page |\n|---|---|---|\n| Concepts | why | [c](concepts.md) |\n");
        let pages = [table, page("docs/concepts.md", "# C\n[a](none.md) [b](#no)\n"), page("docs/lost.md", "# L\n")];
        let faults = faults(&pages).unwrap().join("\n");
        assert!(faults.contains("there is no none.md") && faults.contains("no heading #no"), "{faults}");
        assert!(faults.contains("docs/lost.md: 0 places"), "{faults}");
    }

    #[test]
    fn the_book_holds() {
        assert_eq!(faults(&pages().unwrap()).unwrap(), Vec::<String>::new());
    }
}
