//! `rist generate`: a robot's functions as source for a project of the user's own.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use rist::request::Request;
use rist::request::spelling::flags;
use rist::source::{IdentifiedValues, Language};
use rist::verdict::Trust;

use crate::artefact::read_estimate;
use crate::failure::Failure;
use crate::model::ModelArguments;
use crate::terminal::{at_work, note, print, progress};
use rist::output::write_file;

/// Write a robot's base regressor, and other functions of it, as source that needs no other file
#[derive(Args)]
pub struct Arguments {
    #[command(flatten)]
    model: ModelArguments,

    #[arg(long, value_delimiter = ',', value_name = "NAMES", help = functions_help())]
    functions: Vec<String>,

    /// An estimate of this model: its numbers stand in the file as the constants X and F
    #[arg(long, value_name = "ESTIMATE")]
    estimate: Option<PathBuf>,

    /// Take the numbers even of an estimate whose verdict is no
    #[arg(long, requires = "estimate")]
    anyway: bool,

    /// Language to write
    #[arg(long, value_enum, default_value_t = LanguageWord::Rust)]
    language: LanguageWord,

    /// File to write [default: standard output]; C makes FILE.c and FILE.h
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

#[derive(Clone, Copy, ValueEnum)]
enum LanguageWord {
    /// One file, no_std, generic over f64, f32 and numbers of your own
    Rust,
    /// C99: a header and a source file that need math.h
    C,
}

fn functions_help() -> String {
    format!("Functions beside base-regressor: {}", rist::source::function_names())
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let path = arguments.model.model.display().to_string();
    let options = arguments.model.options()?;
    let mut made_by = format!("rist generate {path}{}", flags(&options.given()));
    let (robot, values) = match &arguments.estimate {
        None => (arguments.model.read_with_values()?, None),
        Some(file) => {
            let (estimate, model) = read_estimate(file, &arguments.model)?;
            let verdict = rist::verdict::estimate_verdict(&estimate);
            if verdict.trust == Trust::No && !arguments.anyway {
                let (file, reasons) = (file.display(), verdict.reasons.join("; "));
                let message = format!("{file}: not to be trusted: {reasons}; nothing is written (--anyway writes it)");
                return Err(Failure::verdict(message));
            }
            made_by += &format!(" --estimate {}", file.display());
            let refused = |e| Failure::new(format_args!("{}: {e}", file.display()));
            let values = IdentifiedValues::of(&model, &estimate).map_err(refused)?;
            (model.robot, Some(values))
        }
    };
    if !arguments.functions.is_empty() {
        made_by += &format!(" --functions {}", arguments.functions.join(","));
    }
    let language = match (arguments.language, &arguments.out) {
        (LanguageWord::Rust, _) => Language::Rust,
        (LanguageWord::C, Some(out)) => {
            made_by += " --language c";
            let header = out.with_extension("h");
            Language::C { header: header.file_name().unwrap_or_default().to_string_lossy().into_owned() }
        }
        (LanguageWord::C, None) => {
            return Err(Failure::new("C makes a header and a source file: say where with `--out FILE.c`"));
        }
    };
    let refused = |e| Failure::new(format_args!("{path}: {e}"));
    at_work(format_args!("generating the source of {path}"));
    let (functions, values_in_file) = (&arguments.functions, values.as_ref());
    let source =
        rist::generate(&robot, functions, &language, &made_by, values_in_file, options.any_size).map_err(refused)?;
    if let Some(left_out) = values.map(|v| v.left_out).filter(|names| !names.is_empty()) {
        note(format_args!("the constants X and F do not hold {}", left_out.join(", ")));
    }
    let Some(out) = &arguments.out else { return print(&source.text) };
    let read: Vec<&Path> =
        [&arguments.model.model].into_iter().chain(&arguments.estimate).map(PathBuf::as_path).collect();
    match &source.header {
        Some(header) => {
            write_file(&out.with_extension("h"), header, &read)?;
            write_file(&out.with_extension("c"), &source.text, &read)?;
        }
        None => write_file(out, &source.text, &read)?,
    }
    for (name, c) in &source.counts {
        progress(format_args!("{name}: {} mul, {} add, {} sin_cos a call", c.mul, c.add, c.sin_cos));
    }
    Ok(())
}
