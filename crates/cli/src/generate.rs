//! `rist generate`: a robot's base regressor as source for a project of the user's own.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use expr::Module;

use crate::failure::{Failure, print, write_file};
use crate::model::ModelArguments;

/// Write a robot's base regressor as source that needs no other file
#[derive(Args)]
pub struct Arguments {
    #[command(flatten)]
    model: ModelArguments,

    /// Language to write
    #[arg(long, value_enum, default_value_t = Language::Rust)]
    language: Language,

    /// File to write [default: standard output]; C makes FILE.c and FILE.h beside it
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

#[derive(Clone, Copy, ValueEnum)]
enum Language {
    /// One file, no_std, generic over f64, f32 and your own numbers
    Rust,
    /// C99, a header and a source file that need math.h and no memory
    C,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let path = arguments.model.model.display().to_string();
    let robot = arguments.model.read()?;
    let module =
        modeling::regressor_module(&robot).map_err(|unclear| Failure::new(format_args!("{path}: {unclear}")))?;
    match (arguments.language, &arguments.out) {
        (Language::Rust, None) => return print(&codegen::rust_file(&module, &format!("rist generate {path}"))),
        (Language::Rust, Some(out)) => write_file(out, &codegen::rust_file(&module, &format!("rist generate {path}")))?,
        (Language::C, None) => {
            return Err(Failure::new("C makes a header and a source file: say where with `--out FILE.c`"));
        }
        (Language::C, Some(out)) => write_c(&module, &path, out)?,
    }
    for f in &module.functions {
        let (name, c) = (&f.function.name, f.function.bound().count());
        eprintln!("{name}: {} mul, {} add, {} sin_cos a call", c.mul, c.add, c.sin_cos);
    }
    Ok(())
}

fn write_c(module: &Module, model: &str, out: &Path) -> Result<(), Failure> {
    let (header, source) = (out.with_extension("h"), out.with_extension("c"));
    let name = header.file_name().unwrap_or_default().to_string_lossy();
    let files = codegen::c_files(module, &format!("rist generate {model} --language c"), &name);
    write_file(&header, &files.header)?;
    write_file(&source, &files.source)
}
