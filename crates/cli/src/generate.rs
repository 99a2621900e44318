//! `rist generate`: writes functions of a robot as source code.
//!
//! If an estimate is given, its values become constants of the source. With
//! `--as`, the output is a package: a folder with programs that run on a robot (wing `packages`).

use std::path::{Path, PathBuf};

use clap::Args;
use rist::describe::source::Language;
use rist::replay::{ONE_LOG, monitor, reference_logs};
use rist::request::spelling::flags;
use rist::request::{GenerateRequest, Request, SourceLanguage};

use crate::artefact::{read_estimate, write_file};
use crate::failure::Failure;
use crate::flags::Flags;
use crate::model::ModelArguments;
use crate::terminal::{at_work, note, print, progress};

/// Write a robot's base regressor and other functions as self-contained source
#[derive(Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    model: ModelArguments,

    #[command(flatten)]
    request: Flags<GenerateRequest>,

    #[cfg(feature = "packages")]
    #[command(flatten)]
    package: Flags<::packages::PackageRequest>,

    /// File to write [default: standard output]. C has two files, FILE.c and FILE.h; a package is a folder
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let path = arguments.model.model.display().to_string();
    let (options, request) = (arguments.model.options()?, arguments.request.read()?);
    #[cfg(feature = "packages")]
    if let Some(package) = crate::packages::wanted(&arguments.package)? {
        return crate::packages::write(&arguments.model, &request, &package, arguments.out.as_deref());
    }
    let mut made_by = format!("rist generate {path}{}{}", flags(&options.given()), flags(&request.given()));
    // If an estimate is given, the values of the estimate become constants, and the model is read with the options of the
    // estimate.
    let (robot, values) = match &request.estimate {
        None if request.anyway => return Err(Failure::new("[anyway=true] is for an [estimate]: give one")),
        None if request.symbols.is_empty() => (arguments.model.read_with_values()?, None),
        None => (arguments.model.read()?, None),
        Some(file) => {
            let (estimate, model) = read_estimate(file, &arguments.model)?;
            let mut values = request.values(&model, file, &estimate)?;
            if request.has_monitor() {
                let reference = reference_logs(&model, file, &estimate, &request.reference)?;
                if reference.len() == 1 {
                    note(ONE_LOG);
                }
                values.monitor = Some(monitor(&model, (file, &estimate), &reference, &request)?);
            }
            // A note on the checksum of the estimate's file is also written at the head of the source, after the command line.
            if let Some(said) = estimate.checksum.note(file.display()) {
                note(format_args!("{said}"));
                made_by += &format!(" # {said}");
            }
            (model.robot, Some(values))
        }
    };
    let language = match (request.language, &arguments.out) {
        (SourceLanguage::Rust, _) => Language::Rust,
        (SourceLanguage::C, Some(out)) => {
            let header = with_extension(out, "h");
            Language::C { header: header.file_name().unwrap_or_default().to_string_lossy().into_owned() }
        }
        (SourceLanguage::C, None) => {
            return Err(Failure::new("C makes a header and a source file: say where with `[out=FILE.c]`"));
        }
    };
    let refused = |e| Failure::new(format_args!("{path}: {e}"));
    at_work(format_args!("generating the source of {path}"));
    let (functions, values_in_file) = (&request.functions, values.as_ref());
    let source =
        rist::generate(&robot, functions, &language, &made_by, values_in_file, &request.symbols, options.any_size)
            .map_err(refused)?;
    if let Some(left_out) = values.map(|v| v.left_out).filter(|names| !names.is_empty()) {
        note(format_args!("the constants X and F do not hold {}", left_out.join(", ")));
    }
    // Without an output file, the source is printed.
    let Some(out) = &arguments.out else { return print(&source.text) };
    match &source.header {
        Some(header) => {
            write_file(&with_extension(out, "h"), header)?;
            write_file(&with_extension(out, "c"), &source.text)?;
        }
        None => write_file(out, &source.text)?,
    }
    for (name, c) in &source.counts {
        progress(format_args!("{name}: {} mul, {} add, {} sin_cos a call", c.mul, c.add, c.sin_cos));
    }
    Ok(())
}

/// The path FILE.c or FILE.h for FILE, FILE.c or FILE.h. Another extension is kept as a part of the name.
fn with_extension(out: &Path, extension: &str) -> PathBuf {
    if out.extension().is_some_and(|found| found == "c" || found == "h") {
        return out.with_extension(extension);
    }
    let mut name = out.as_os_str().to_owned();
    name.push(".");
    name.push(extension);
    PathBuf::from(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_in_a_name_stays() {
        for (out, expected) in
            [("arm", "arm"), ("arm.c", "arm"), ("a/arm.h", "a/arm"), ("arm.v2", "arm.v2"), ("a.d/arm", "a.d/arm")]
        {
            let found = ["c", "h"].map(|extension| with_extension(Path::new(out), extension));
            assert_eq!(found, ["c", "h"].map(|extension| PathBuf::from(format!("{expected}.{extension}"))));
        }
    }
}
