//! Tests that a user of the crate `rist` can name every type in its public signatures by a path through `rist`.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use proc_macro2::{TokenStream, TokenTree};
use quote::ToTokens;
use syn::{Fields, ImplItem, Item, UseTree, Visibility};
use tests::workspace;

/// Crates of this repository whose types may occur in public signatures of `rist`.
const OURS: [&str; 12] = [
    "claims",
    "clearance",
    "codegen",
    "experiments",
    "expr",
    "identification",
    "linear_model",
    "logs",
    "modeling",
    "numerics",
    "report",
    "robot",
];

/// Collects the names that a `use` item imports, as a map: name in the file -> path of the item.
fn imports(tree: &UseTree, before: &[String], found: &mut BTreeMap<String, Vec<String>>) {
    let longer = |name: String| [before, &[name]].concat();
    match tree {
        UseTree::Path(path) => imports(&path.tree, &longer(path.ident.to_string()), found),
        UseTree::Name(name) if name.ident == "self" => {
            found.insert(before.last().cloned().unwrap_or_default(), before.to_vec());
        }
        UseTree::Name(name) => {
            found.insert(name.ident.to_string(), longer(name.ident.to_string()));
        }
        UseTree::Rename(name) => {
            found.insert(name.rename.to_string(), longer(name.ident.to_string()));
        }
        UseTree::Group(group) => group.items.iter().for_each(|tree| imports(tree, before, found)),
        UseTree::Glob(_) => {}
    }
}

fn is_public(visibility: &Visibility) -> bool {
    matches!(visibility, Visibility::Public(_))
}

fn public_fields(fields: &Fields) -> Vec<TokenStream> {
    fields.iter().filter(|field| is_public(&field.vis)).map(|field| field.ty.to_token_stream()).collect()
}

/// Tokens of an item that a user of the crate sees: types of public fields, and signatures.
fn seen(item: &Item) -> Vec<TokenStream> {
    match item {
        Item::Struct(item) if is_public(&item.vis) => public_fields(&item.fields),
        Item::Enum(item) if is_public(&item.vis) => item.variants.iter().map(|v| v.fields.to_token_stream()).collect(),
        Item::Fn(item) if is_public(&item.vis) => vec![item.sig.to_token_stream()],
        Item::Type(item) if is_public(&item.vis) => vec![item.ty.to_token_stream()],
        Item::Impl(item) if item.trait_.is_none() => {
            let functions = item.items.iter().filter_map(|item| match item {
                ImplItem::Fn(function) if is_public(&function.vis) => Some(function.sig.to_token_stream()),
                _ => None,
            });
            functions.collect()
        }
        // A request macro contains the types of its fields, and their defaults.
        Item::Macro(item) if item.mac.path.is_ident("request") => vec![item.mac.tokens.clone()],
        _ => Vec::new(),
    }
}

/// Collects the names among tokens, each with the path before it: `["clearance", "Mesh"]`.
fn named(tokens: TokenStream, found: &mut BTreeSet<Vec<String>>) {
    let mut path: Vec<String> = Vec::new();
    let mut colons = 0;
    for token in tokens {
        match token {
            TokenTree::Ident(name) => {
                if colons != 2 {
                    path.clear();
                }
                path.push(name.to_string());
                found.insert(path.clone());
                colons = 0;
            }
            TokenTree::Punct(mark) if mark.as_char() == ':' => colons += 1,
            TokenTree::Group(group) => {
                named(group.stream(), found);
                (path, colons) = (Vec::new(), 0);
            }
            _ => (path, colons) = (Vec::new(), 0),
        }
    }
}

#[test]
fn every_type_of_a_signature_can_be_named_through_rist() {
    let root = workspace().join("crates/rist/src");
    let mut paths = tests::files_below(&root);
    // The files of private modules are skipped. Their items are public only if a public module re-exports them.
    let declared = |path: &PathBuf| {
        let text = std::fs::read_to_string(path).unwrap();
        let module = |line: &str| {
            let name = line.strip_prefix("mod ").or(line.strip_prefix("pub(crate) mod "))?.strip_suffix(';')?;
            Some(path.with_file_name(name))
        };
        text.lines().filter_map(module).collect::<Vec<PathBuf>>()
    };
    let fronts = paths.iter().filter(|path| path.ends_with("lib.rs") || path.ends_with("mod.rs"));
    let private: Vec<PathBuf> = fronts.flat_map(declared).collect();
    assert!(private.len() > 5, "{private:?}");
    paths.retain(|path| !private.iter().any(|module| path.with_extension("").starts_with(module)));
    // `used`: types of other crates in the signatures -> files that use them. `passed`: types that `rist` re-exports.
    let (mut used, mut passed) = (BTreeMap::<String, BTreeSet<String>>::new(), BTreeSet::<String>::new());
    for path in &paths {
        let file = syn::parse_file(&std::fs::read_to_string(path).unwrap()).unwrap();
        let mut imported = BTreeMap::new();
        for item in &file.items {
            if let Item::Use(item) = item {
                imports(&item.tree, &[], &mut imported);
                if is_public(&item.vis) {
                    let mut own = BTreeMap::new();
                    imports(&item.tree, &[], &mut own);
                    passed.extend(
                        own.into_values().filter(|path| OURS.contains(&path[0].as_str())).map(|p| p.join("::")),
                    );
                }
            }
        }
        let mut names = BTreeSet::new();
        file.items.iter().flat_map(seen).for_each(|tokens| named(tokens, &mut names));
        for name in names {
            let full = match imported.get(&name[0]) {
                Some(path) => [&path[..], &name[1..]].concat(),
                None => name,
            };
            let is_type = full.last().is_some_and(|last| last.starts_with(char::is_uppercase));
            let kind = full.iter().position(|part| part.starts_with(char::is_uppercase));
            if is_type && full.len() > 1 && OURS.contains(&full[0].as_str()) {
                let full = full[..=kind.unwrap()].join("::");
                let file = path.strip_prefix(&root).unwrap().display().to_string();
                used.entry(full).or_default().insert(file);
            }
        }
    }
    assert!(used.len() > 40, "{} types are found", used.len());
    let ends = |path: &str| path.rsplit("::").next().unwrap_or_default().to_string();
    let passed: BTreeSet<String> =
        passed.iter().map(|path| format!("{}::..::{}", &path[..path.find(':').unwrap()], ends(path))).collect();
    let key = |path: &str| format!("{}::..::{}", &path[..path.find(':').unwrap()], ends(path));
    let missing: Vec<String> = used
        .iter()
        .filter(|(path, _)| !passed.contains(&key(path)))
        .map(|(path, files)| format!("{path} of {files:?}"))
        .collect();
    assert!(missing.is_empty(), "no key to:\n{}", missing.join("\n"));
}
