//! The task `gen`: writes the robots of models/ as Rust source to generated/src/robots/.
//!
//! All files are first stored in a map (path -> text), which is then written or compared. The folder contains only generated
//! files, so a file whose model no longer exists is removed.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use crate::cargo::root;

const FOLDER: &str = "generated/src/robots";

pub(crate) fn run(arguments: &[String]) -> Result<(), String> {
    let (flags, models): (Vec<&String>, Vec<&String>) = arguments.iter().partition(|a| a.starts_with('-'));
    if let Some(flag) = flags.iter().find(|f| **f != "--check") {
        return Err(format!("gen has no flag `{flag}`; it has --check"));
    }
    let check = !flags.is_empty();
    let rendered = render(&models)?;
    if check { compare(&rendered) } else { write(&rendered) }
}

/// The generated files of all models, as a map: path relative to the root -> text.
struct Rendered {
    files: BTreeMap<PathBuf, String>,
    /// The files that the user requested.
    asked: Vec<PathBuf>,
}

fn render(models: &[&String]) -> Result<Rendered, String> {
    let mut paths: Vec<PathBuf> = std::fs::read_dir(root().join("models"))
        .map_err(|e| format!("models/: {e}"))?
        .filter_map(|entry| entry.ok().map(|entry| entry.path()))
        .filter(|path| matches!(path.extension().and_then(|e| e.to_str()), Some("yaml" | "urdf" | "par")))
        .collect();
    paths.sort();
    // If the user requests a model outside of models/, this is an error, because the index of the robots would not contain it.
    let wanted: Vec<PathBuf> = models
        .iter()
        .map(|m| {
            let here = Path::new(m.as_str());
            let path = if here.exists() { here.to_path_buf() } else { root().join(here) };
            let path = path.canonicalize().map_err(|e| format!("{m}: {e}"))?;
            if paths.iter().any(|p| p.canonicalize().is_ok_and(|p| p == path)) {
                Ok(path)
            } else {
                Err(format!(
                    "{m} is not in models/: the generated package holds the models of this repository. For your own \
                     project run `rist generate {m} --out FILE`"
                ))
            }
        })
        .collect::<Result<_, String>>()?;

    // All models are derived, because the index of the crate `generated` lists them all. Only the requested models are written.
    let mut modules = Vec::new();
    let mut rendered = Rendered { files: BTreeMap::new(), asked: Vec::new() };
    for path in &paths {
        let robot = robot::format::read(path).map_err(|e| e.to_string())?;
        let model = path.strip_prefix(root()).unwrap_or(path).display();
        let module = modeling::module(&robot, &[]).map_err(|e| format!("{model}: {e}"))?;
        let text = codegen::rust_file(&module, &format!("cargo xtask gen {model}"));
        let target = Path::new(FOLDER).join(format!("{}.rs", module.name));
        if wanted.is_empty() || path.canonicalize().is_ok_and(|p| wanted.contains(&p)) {
            rendered.asked.push(target.clone());
        }
        if rendered.files.insert(target, text).is_some() {
            return Err(format!(
                "{model}: another model is also called `{}`; give one of them another name",
                robot.name
            ));
        }
        modules.push(module);
    }
    let index = Path::new(FOLDER).join("mod.rs");
    rendered.files.insert(index.clone(), codegen::index_file(&modules));
    rendered.asked.push(index);
    Ok(rendered)
}

/// The files in the folder of generated robots that do not belong to any model.
fn orphans(rendered: &Rendered) -> Result<Vec<PathBuf>, String> {
    let folder = root().join(FOLDER);
    let mut orphans: Vec<PathBuf> = match std::fs::read_dir(&folder) {
        Ok(entries) => entries
            .filter_map(|entry| entry.ok().map(|entry| Path::new(FOLDER).join(entry.file_name())))
            .filter(|path| !rendered.files.contains_key(path))
            .collect(),
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => Vec::new(),
        Err(e) => return Err(format!("{}: {e}", folder.display())),
    };
    orphans.sort();
    Ok(orphans)
}

fn write(rendered: &Rendered) -> Result<(), String> {
    let failed = |path: &Path, e: std::io::Error| format!("{}: {e}", path.display());
    let folder = root().join(FOLDER);
    std::fs::create_dir_all(&folder).map_err(|e| failed(&folder, e))?;
    for path in &rendered.asked {
        let (target, text) = (root().join(path), &rendered.files[path]);
        if std::fs::read_to_string(&target).is_ok_and(|old| old == *text) {
            println!("{}: as it was", path.display());
            continue;
        }
        std::fs::write(&target, text).map_err(|e| failed(&target, e))?;
        println!("{}: written", path.display());
    }
    for path in orphans(rendered)? {
        let target = root().join(&path);
        std::fs::remove_file(&target).map_err(|e| failed(&target, e))?;
        println!("{}: removed, no model makes it", path.display());
    }
    Ok(())
}

fn compare(rendered: &Rendered) -> Result<(), String> {
    for path in &rendered.asked {
        let new = &rendered.files[path];
        let old = std::fs::read_to_string(root().join(path)).unwrap_or_default();
        if old != *new {
            let line = old.lines().zip(new.lines()).take_while(|(a, b)| a == b).count();
            let show = |text: &str| text.lines().nth(line).unwrap_or("(the file ends)").to_string();
            return Err(format!(
                "{}:{}: not what the models give\n  found:    {}\n  expected: {}\nRun `cargo xtask gen` and commit what it writes.",
                path.display(),
                line + 1,
                show(&old),
                show(new)
            ));
        }
    }
    match orphans(rendered)?.first() {
        Some(path) => Err(format!("{}: no model makes this file\nRun `cargo xtask gen`.", path.display())),
        None => {
            println!("generated/ is what models/ gives: {} files", rendered.asked.len());
            Ok(())
        }
    }
}
