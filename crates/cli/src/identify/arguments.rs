//! Arguments of `rist identify`: the flags of all methods. A method accepts only flags of its own request.
//!
//! A request is a struct with the options of a method (crate `rist`); each field is one flag. The same flag may belong to
//! several requests.

use std::path::{Path, PathBuf};

use clap::{ArgMatches, Args, Command, FromArgMatches};
use rist::request::spelling::{Audience, spelled};
use rist::request::{Field, Method, MethodRequest, Request, WordChoice};

use crate::failure::Failure;
use crate::flags::{FlagValues, flag};
use crate::model::ModelArguments;

/// Identify a robot's base parameters and friction from logs
///
/// A log contains the time t and, for every coordinate, positions, torques or currents, and velocities if they were
/// measured. Columns are found by their names (q1 or q_<coordinate>, dq.., tau.., i..).
#[derive(Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    pub model: ModelArguments,

    #[arg(
        required = true,
        value_name = "LOG",
        help = format!("The logs, fitted together: {}", rist::format_names().join(", ")),
        long_help = format!(
            "The logs, fitted together: {}, plain or in gzip or zstd\n\nlog.mcap#/topic names one of several topics of a \
             recording. With --plan: the directory with one log per experiment: e01.csv, ..",
            rist::format_names().join(", ")
        )
    )]
    pub logs: Vec<PathBuf>,

    #[command(flatten)]
    pub asked: MethodAndFlags,

    /// Write the estimate as YAML
    #[arg(long, value_name = "FILE", help_heading = "Outputs")]
    pub out: Option<PathBuf>,
}

/// The method, and the flags that were given.
pub(crate) struct MethodAndFlags {
    /// The method of identification.
    pub method: Method,
    /// All given flags. Each request reads its own flags.
    pub given: FlagValues,
}

/// The different help texts of a field, each with the methods that have it.
type MethodTexts = Vec<(String, Vec<&'static str>)>;

/// The flags of all methods, each once. The help of a flag is the text of the first method that has this flag; different texts of
/// other methods are appended.
fn fields() -> Vec<(Field, String)> {
    let mut documented: Vec<(Field, MethodTexts)> = Vec::new();
    for method in Method::all() {
        for field in method.fields().into_iter().chain(method.files()) {
            let at = documented.iter().position(|(known, _)| known.name == field.name);
            let at = at.unwrap_or_else(|| {
                documented.push((field.clone(), Vec::new()));
                documented.len() - 1
            });
            let docs = &mut documented[at].1;
            match docs.iter_mut().find(|(doc, _)| *doc == field.doc) {
                Some((_, methods)) => methods.push(method.word()),
                None => docs.push((field.doc, vec![method.word()])),
            }
        }
    }
    let whole = |(field, docs): (Field, MethodTexts)| {
        let first = docs.first().map_or(String::new(), |(doc, _)| doc.clone());
        let others = docs.iter().skip(1).map(|(doc, methods)| format!("; {}: {doc}", methods.join(", ")));
        let mut field = field;
        field.doc = first.clone() + &others.collect::<String>();
        (field, first)
    };
    let of_method = MethodRequest::fields().into_iter().map(|field| (field.clone(), field.doc));
    of_method.chain(documented.into_iter().map(whole)).collect()
}

impl Args for MethodAndFlags {
    fn augment_args(command: Command) -> Command {
        let for_program = |doc: &str| spelled(doc, Audience::Program);
        let one =
            |(field, first): &(Field, String)| flag(field).help(for_program(first)).long_help(for_program(&field.doc));
        command.args(fields().iter().map(one))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for MethodAndFlags {
    fn from_arg_matches(matches: &ArgMatches) -> Result<MethodAndFlags, clap::Error> {
        let word = matches.get_one::<String>("method").map_or("", String::as_str);
        let method = Method::of_word(word).unwrap_or(MethodRequest::default().method);
        Ok(MethodAndFlags {
            method,
            given: FlagValues::of(fields().into_iter().map(|(field, _)| field).collect(), matches),
        })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = MethodAndFlags::from_arg_matches(matches)?;
        Ok(())
    }
}

impl MethodAndFlags {
    /// Fails if a flag is given that this method does not have. The error names the methods that have this flag.
    pub(crate) fn check(&self) -> Result<(), Failure> {
        let refused = self.given.names().filter(|name| *name != "method").filter_map(|name| self.method.refusal(name));
        let refused: Vec<String> = refused.map(|e| e.to_string()).collect();
        if refused.is_empty() { Ok(()) } else { Err(Failure::new(refused.join("\n"))) }
    }

    /// The path of the plan whose experiments were logged. Fails if no plan is given.
    pub(crate) fn plan(&self) -> Result<&Path, Failure> {
        match self.given.file("plan") {
            none if none.as_os_str().is_empty() => {
                let method = self.method.word();
                Err(Failure::new(format_args!("[method={method}] needs the plan behind the logs: [plan=plan.yaml]")))
            }
            plan => Ok(plan),
        }
    }
}
