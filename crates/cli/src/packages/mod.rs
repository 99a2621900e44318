//! `rist generate --as`, of the wing (optional package) `packages`: writes a folder that runs a model on a robot.
//!
//! The package takes the values of an estimate and the options with which its logs were identified (units, gains and signs of
//! the drives).

use std::fs::create_dir_all;
use std::path::{Path, PathBuf};

use packages::PackageRequest;
use rist::request::spelling::flags;
use rist::request::{GenerateRequest, Request};

use crate::artefact::{make_directory, read_estimate, write_file};
use crate::failure::Failure;
use crate::flags::Flags;
use crate::model::ModelArguments;
use crate::terminal::{at_work, note, print};

/// The package that the flags ask for: its request and the file of its options. `None`: no package.
pub(crate) fn wanted(flags: &Flags<PackageRequest>) -> Result<Option<(PackageRequest, PathBuf)>, Failure> {
    let request = flags.read()?;
    match (request.target, &request.options) {
        (Some(_), _) => Ok(Some((request, flags.file("options").to_path_buf()))),
        (None, Some(_)) => Err(Failure::new(
            "[options] say the units of the drives of a package: name its [target], or leave them out",
        )),
        (None, None) => Ok(None),
    }
}

/// Writes the package `wanted` into the folder `out`.
pub(crate) fn write(
    arguments: &ModelArguments,
    generate: &GenerateRequest,
    (request, options_file): &(PackageRequest, PathBuf),
    out: Option<&Path>,
) -> Result<(), Failure> {
    let fixed = |name: &&str| ["functions", "symbols", "language"].contains(name);
    if let Some(name) = generate.given().iter().map(|(name, _)| *name).find(fixed) {
        return Err(Failure::new(format_args!("[target] decides the [{name}] of a package: leave [{name}] out")));
    }
    let file = generate
        .estimate
        .as_deref()
        .ok_or_else(|| Failure::new("[target]: a package holds identified numbers: give the [estimate]"))?;
    let out = out.ok_or_else(|| Failure::new("[target] makes a folder: say where with `[out=FOLDER]`"))?;
    let (estimate, model) = read_estimate(file, arguments)?;
    let values = generate.values(&model, file, &estimate)?;
    let path = arguments.model.display();
    // The files of the package name the command that generates them, so that the user can repeat it. The options of the package
    // are named by their file, so only the target is written as a value.
    let target = request.given().into_iter().filter(|(name, _)| *name == "target").collect::<Vec<_>>();
    let mut made_by = format!(
        "rist generate {path}{}{}{}",
        flags(&arguments.options()?.given()),
        flags(&generate.given()),
        flags(&target)
    );
    if !options_file.as_os_str().is_empty() {
        made_by += &format!(" --options {}", options_file.display());
    }
    if let Some(said) = estimate.checksum.note(file.display()) {
        note(format_args!("{said}"));
        made_by += &format!(" # {said}");
    }
    at_work(format_args!("generating the package of {path}"));
    // The files are generated before the folder is made, so that an error leaves no empty folder.
    let files = packages::package(&model, &estimate, &values, request, &made_by)?;
    if !values.left_out.is_empty() {
        note(format_args!("the torques of the package do not hold {}", values.left_out.join(", ")));
    }
    make_directory(out)?;
    for file in &files {
        let path = out.join(&file.path);
        if let Some(folder) = path.parent() {
            create_dir_all(folder).map_err(|e| Failure::new(format_args!("{}: {e}", folder.display())))?;
        }
        write_file(&path, &file.text)?;
    }
    print(&format!("wrote {} files; begin with {}\n", files.len(), out.join("README.md").display()))
}
