//! Finds which file of a crate imports which other file. Reports cycles of imports, and imports against the order of the files.
//!
//! An import is any path that leads into the same crate, outside of tests: in a `use` item or inline, from `crate::`, `super::`,
//! `self::` or a child module. Its target is the file that defines the name. If the path leads to a `lib.rs` or `mod.rs` that
//! only declares and re-exports, the re-export is followed to the defining file. Items and files under `#[cfg(test)]`, and the
//! contents of `quote!` (code of another crate), do not count.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use proc_macro2::{Delimiter, TokenStream, TokenTree};

use super::tokens::{tokens, without_tests};

/// The position of a module in its crate: the names of the modules from the root to it.
type Place = Vec<String>;

/// A path in one file that leads to another file. File names are relative to the folder `src`.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Import {
    pub from: String,
    pub to: String,
    pub path: String,
}

impl std::fmt::Display for Import {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} imports {}, which {} defines", self.from, self.path, self.to)
    }
}

struct Module {
    file: String,
    /// Whether the file only declares modules and re-exports names.
    is_front: bool,
    /// The `pub use` items of the module, each as (name, path); the name of a glob is `*`.
    exports: Vec<(String, Place)>,
    /// Every path that occurs in the module, except in its inline modules.
    paths: Vec<Place>,
    declared: Vec<String>,
}

/// The modules of a crate, without tests. `files`: path below `src` -> text.
fn modules(files: &BTreeMap<String, String>) -> BTreeMap<Place, Module> {
    let mut modules: BTreeMap<Place, Module> = BTreeMap::new();
    for (file, text) in files {
        let mut place: Place = file.trim_end_matches(".rs").split('/').map(String::from).collect();
        if matches!(place.last().map(String::as_str), Some("lib" | "main" | "mod")) {
            place.pop();
        }
        read(without_tests(tokens(text, file)), &place, file, &mut modules);
    }
    // A file that is declared only for tests is left out.
    let mut reached: BTreeSet<Place> = BTreeSet::new();
    let mut next = vec![Place::new()];
    while let Some(place) = next.pop() {
        if let Some(module) = modules.get(&place) {
            next.extend(module.declared.iter().map(|child| [place.clone(), vec![child.clone()]].concat()));
            reached.insert(place);
        }
    }
    modules.retain(|place, _| reached.contains(place));
    modules
}

fn imports(modules: &BTreeMap<Place, Module>) -> Vec<Import> {
    let mut found = BTreeSet::new();
    for (place, module) in modules.iter().filter(|(_, m)| !m.is_front) {
        for path in &module.paths {
            let Some(target) = absolute(modules, place, path) else { continue };
            for to in defining_files(modules, &target, &module.file) {
                if to != module.file {
                    found.insert(Import { from: module.file.clone(), to, path: path.join("::") });
                }
            }
        }
    }
    found.into_iter().collect()
}

/// Reads the tokens of a module and of its inline modules.
fn read(stream: TokenStream, place: &Place, file: &str, modules: &mut BTreeMap<Place, Module>) {
    let is_front = (file.ends_with("lib.rs") || file.ends_with("mod.rs")) && only_declares(stream.clone());
    let mut module =
        Module { file: file.into(), is_front, exports: Vec::new(), paths: Vec::new(), declared: Vec::new() };
    let mut inline = Vec::new();
    gather(stream, &mut module, &mut inline);
    modules.insert(place.clone(), module);
    for (name, body) in inline {
        read(body, &[place.clone(), vec![name]].concat(), file, modules);
    }
}

/// Whether the tokens contain only attributes, `mod name;` and `use ..;`.
fn only_declares(stream: TokenStream) -> bool {
    let mut rest = stream.into_iter().filter(|t| !matches!(t, TokenTree::Group(_))).map(|t| t.to_string());
    while let Some(word) = rest.next() {
        match word.as_str() {
            "#" | "!" | "pub" => {}
            "mod" | "use" => {
                rest.find(|word| word == ";");
            }
            _ => return false,
        }
    }
    true
}

/// Collects the paths in a token stream: each branch of the `use` items, and the paths in other code.
fn gather(stream: TokenStream, module: &mut Module, inline: &mut Vec<(String, TokenStream)>) {
    let tokens: Vec<TokenTree> = stream.into_iter().collect();
    let text: Vec<String> =
        tokens.iter().map(|t| if let TokenTree::Group(_) = t { String::new() } else { t.to_string() }).collect();
    let word = |k: usize| text.get(k).map_or("", String::as_str);
    let mut k = 0;
    while k < tokens.len() {
        match (&tokens[k], tokens.get(k + 1), tokens.get(k + 2)) {
            (TokenTree::Ident(i), Some(TokenTree::Group(g)), _) if i == "pub" && is_visibility(g) => k += 2,
            (TokenTree::Ident(i), _, _) if i == "use" && word(k + 1) != "<" => {
                let end = (k..tokens.len()).find(|&e| word(e) == ";").unwrap_or(tokens.len());
                let is_public = k > 0 && (word(k - 1) == "pub" || (k > 1 && word(k - 2) == "pub"));
                for (path, name) in branches(&tokens[k + 1..end]) {
                    if is_public {
                        module.exports.push((name, path.clone()));
                    }
                    module.paths.push(path);
                }
                k = end;
            }
            (TokenTree::Ident(i), Some(TokenTree::Ident(name)), Some(TokenTree::Group(g))) if i == "mod" => {
                module.declared.push(name.to_string());
                inline.push((name.to_string(), g.stream()));
                k += 3;
            }
            (TokenTree::Ident(i), Some(TokenTree::Ident(name)), _) if i == "mod" => {
                module.declared.push(name.to_string());
                k += 2;
            }
            (TokenTree::Ident(i), Some(TokenTree::Punct(_)), Some(TokenTree::Group(_)))
                if word(k + 1) == "!" && i.to_string().contains("quote") =>
            {
                k += 3;
            }
            (TokenTree::Ident(_), ..) => {
                let follows =
                    k > 0 && (matches!(word(k - 1), "." | "$") || (k > 1 && word(k - 1) == ":" && word(k - 2) == ":"));
                let mut path = vec![text[k].clone()];
                while word(k + 1) == ":" && word(k + 2) == ":" && matches!(tokens.get(k + 3), Some(TokenTree::Ident(_)))
                {
                    path.push(text[k + 3].clone());
                    k += 3;
                }
                if !follows && path.len() > 1 {
                    module.paths.push(path);
                }
                k += 1;
            }
            (TokenTree::Group(g), ..) => {
                gather(g.stream(), module, inline);
                k += 1;
            }
            _ => k += 1,
        }
    }
}

/// Whether a group is the `(crate)`, `(super)` or `(in ..)` after `pub`.
fn is_visibility(group: &proc_macro2::Group) -> bool {
    let first = group.stream().into_iter().next().map(|t| t.to_string()).unwrap_or_default();
    group.delimiter() == Delimiter::Parenthesis && matches!(first.as_str(), "crate" | "super" | "self" | "in")
}

/// The branches of a use tree such as `a::{b, c::d as e, f::*}`, each as (path, name that it gets).
fn branches(tree: &[TokenTree]) -> Vec<(Place, String)> {
    let mut path = Vec::new();
    let mut name = String::new();
    let mut rest = tree.iter();
    while let Some(token) = rest.next() {
        match token {
            TokenTree::Group(g) => {
                let inner: Vec<TokenTree> = g.stream().into_iter().collect();
                let trees = inner.split(|t| t.to_string() == ",").filter(|tree| !tree.is_empty());
                return trees
                    .flat_map(branches)
                    .map(|(tail, name)| {
                        // `a::{self}` means a.
                        let tail = if tail == ["self"] && !path.is_empty() { Vec::new() } else { tail };
                        ([path.clone(), tail].concat(), name)
                    })
                    .collect();
            }
            TokenTree::Ident(i) if i == "as" => {
                name = rest.next().map(|t| t.to_string()).unwrap_or_default();
                return vec![(path, name)];
            }
            TokenTree::Ident(i) => {
                name = i.to_string();
                path.push(name.clone());
            }
            TokenTree::Punct(p) if p.as_char() == '*' => name = "*".into(),
            _ => {}
        }
    }
    vec![(path, name)]
}

/// The path `path` from the root of the crate, if it occurs in the module `at`; `None` if it leads out of the crate or names a
/// local item.
fn absolute(modules: &BTreeMap<Place, Module>, at: &Place, path: &[String]) -> Option<Place> {
    let (first, rest) = path.split_first()?;
    match first.as_str() {
        "crate" => Some(rest.to_vec()),
        "self" => Some([at, rest].concat()),
        "super" => {
            let parent = at.split_last().map(|(_, parent)| parent.to_vec())?;
            if rest.first().is_some_and(|next| next == "super") {
                return absolute(modules, &parent, rest);
            }
            Some([&parent, rest].concat())
        }
        _ => {
            let child = [at.clone(), vec![first.clone()]].concat();
            modules.contains_key(&child).then(|| [at, path].concat())
        }
    }
}

/// The files that define the item to which a path from the root leads. If the path names a folder, these are all files of the
/// folder.
fn defining_files(modules: &BTreeMap<Place, Module>, path: &[String], user: &str) -> BTreeSet<String> {
    let depth = (0..=path.len()).rev().find(|&d| modules.contains_key(&path[..d])).unwrap_or(0);
    let (place, module) = (path[..depth].to_vec(), &modules[&path[..depth]]);
    let follow = |target: &Place| match absolute(modules, &place, target) {
        Some(target) => defining_files(modules, &target, user),
        None => BTreeSet::new(),
    };
    let Some(name) = path.get(depth) else {
        let below = modules.iter().filter(|(p, m)| p.starts_with(&place) && !m.is_front);
        return if module.is_front {
            below.map(|(_, m)| m.file.clone()).collect()
        } else {
            BTreeSet::from([module.file.clone()])
        };
    };
    if let Some((_, target)) = module.exports.iter().find(|(export, _)| export == name) {
        return follow(target);
    }
    if !module.is_front {
        return BTreeSet::from([module.file.clone()]);
    }
    let globs: BTreeSet<String> =
        module.exports.iter().filter(|(export, _)| export == "*").flat_map(|(_, target)| follow(target)).collect();
    assert!(!globs.is_empty(), "{user}: no file found that defines crate::{}", path.join("::"));
    globs
}

/// Messages about the imports of a crate: cycles of files, cycles of folders, and imports of files that are higher in `order`.
/// `order`: list of the folders and files of `src` from bottom to top.
pub(crate) fn faults(files: &BTreeMap<String, String>, order: &[&str]) -> Vec<String> {
    let modules = modules(files);
    let imports = imports(&modules);
    let files: BTreeSet<&String> = modules.values().map(|m| &m.file).collect();
    let mut faults = Vec::new();

    let mut folders: BTreeSet<String> = BTreeSet::new();
    for file in &files {
        folders.extend(file.match_indices('/').map(|(k, _)| file[..=k].to_string()));
    }
    let whole = |file: &str| Some(file.to_string());
    if let Some(circle) = circle(&imports, whole) {
        faults.push(format!("a circle of files:\n{circle}"));
    }
    for folder in std::iter::once(String::new()).chain(folders) {
        let child = |file: &str| {
            let inside = file.strip_prefix(&folder)?;
            Some(inside.split('/').next().unwrap_or(inside).to_string())
        };
        if let Some(circle) = circle(&imports, child) {
            faults.push(format!("a circle in the folder src/{folder}:\n{circle}"));
        }
    }

    let unit = |file: &str| file.split('/').next().unwrap_or(file).trim_end_matches(".rs").to_string();
    let rank = |file: &str| order.iter().position(|u| *u == unit(file));
    for import in &imports {
        if let (Some(from), Some(to)) = (rank(&import.from), rank(&import.to))
            && to > from
        {
            faults.push(format!("back up: {import}; the order from the bottom is {}", order.join(", ")));
        }
    }
    // `lib.rs` and `main.rs` need no place in the order unless they take part in an import.
    let fronts = ["lib.rs", "main.rs"].map(String::from);
    let is_node =
        |file: &&&String| !fronts.contains(file) || imports.iter().any(|i| i.from == ***file || i.to == ***file);
    let units: BTreeSet<String> = files.iter().filter(is_node).map(|file| unit(file)).collect();
    let listed: BTreeSet<String> = order.iter().map(|u| u.to_string()).collect();
    if units != listed {
        let (missing, stale): (Vec<_>, Vec<_>) =
            (units.difference(&listed).collect(), listed.difference(&units).collect());
        faults.push(format!("the order does not name {missing:?}, and names {stale:?}, which are not there"));
    }
    faults
}

/// The shortest cycle of imports among groups of files, one import per line; `None` if there is no cycle. `group`: the group of a
/// file.
fn circle(imports: &[Import], group: impl Fn(&str) -> Option<String>) -> Option<String> {
    let mut edges: BTreeMap<String, BTreeMap<String, &Import>> = BTreeMap::new();
    for import in imports {
        if let (Some(from), Some(to)) = (group(&import.from), group(&import.to))
            && from != to
        {
            edges.entry(from).or_default().entry(to).or_insert(import);
        }
    }
    let around = |start: &String| -> Option<Vec<&Import>> {
        let mut queue = VecDeque::from([(start, Vec::new())]);
        let mut seen = BTreeSet::new();
        while let Some((at, way)) = queue.pop_front() {
            for (to, import) in edges.get(at).into_iter().flatten() {
                let way = [way.clone(), vec![*import]].concat();
                if to == start {
                    return Some(way);
                }
                if seen.insert(to) {
                    queue.push_back((to, way));
                }
            }
        }
        None
    };
    let shortest = edges.keys().filter_map(around).min_by_key(Vec::len)?;
    Some(shortest.iter().map(|import| format!("  {import}")).collect::<Vec<_>>().join("\n"))
}

#[test]
fn a_circle_and_a_way_back_up_are_found() {
    let file = |name: &str, text: &str| (name.to_string(), text.to_string());
    let mut files = BTreeMap::from([
        file("lib.rs", "mod low; mod high; pub use high::{a::A, b}; #[cfg(test)] mod fixture;"),
        file("fixture.rs", "use crate::high::a::A; use crate::nowhere::Nothing;"),
        file("low.rs", "pub struct Low; #[cfg(test)] mod tests { use crate::high::a::A; }"),
        file("high/mod.rs", "pub mod a; pub mod b; pub use a::A as Renamed;"),
        file("high/a.rs", "use crate::low::Low; pub struct A(Low);"),
        file("high/b.rs", "pub fn b(x: super::Renamed) -> &'static str { \"crate::low::Low\" }"),
    ]);
    let order = ["low", "high"];
    assert_eq!(faults(&files, &order), Vec::<String>::new());
    let to = |files: &BTreeMap<String, String>| {
        imports(&modules(files)).iter().map(|i| format!("{} {}", i.from, i.to)).collect::<Vec<_>>()
    };
    assert_eq!(to(&files), ["high/a.rs low.rs", "high/b.rs high/a.rs"]);

    // In this file, the import is in the body of a function; it uses a name that the root of the crate re-exports.
    files.extend([file("low.rs", "pub struct Low; pub fn f() { let _ = crate::b; println!(\"{}\", crate::b::b()) }")]);
    let found = faults(&files, &order).join("\n");
    assert!(found.contains("a circle of files:\n  high/a.rs imports crate::low::Low, which low.rs defines"), "{found}");
    assert!(found.contains("back up: low.rs imports crate::b::b, which high/b.rs defines"), "{found}");
    // Here two folders import each other, but no files do.
    files.extend([
        file("low.rs", "pub struct Low;"),
        file("high/x/mod.rs", "pub mod one; pub mod two;"),
        file("high/x/one.rs", "use crate::high::y::three::Three;"),
        file("high/x/two.rs", "pub struct Two;"),
        file("high/y/mod.rs", "pub mod three; pub mod four;"),
        file("high/y/three.rs", "pub struct Three;"),
        file("high/y/four.rs", "use super::super::x::two::Two;"),
        file("high/mod.rs", "pub mod a; pub mod b; pub mod x; pub mod y; pub use a::A as Renamed;"),
    ]);
    let found = faults(&files, &order);
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(found[0].starts_with("a circle in the folder src/high/:"), "{found:?}");
}
