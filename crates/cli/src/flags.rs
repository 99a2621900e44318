//! Generates the flags of a request from its table of fields, and reads the request from the given flags.
//!
//! A request is a struct with all options of a command (crate `rist`, `request!`); each field is one option, and becomes one
//! flag of the command line.

use std::marker::PhantomData;
use std::ops::Deref;
use std::path::Path;

use clap::builder::{PossibleValue, PossibleValuesParser};
use clap::parser::ValueSource;
use clap::{Arg, ArgAction, ArgMatches, Args, Command, FromArgMatches};
use rist::request::spelling::{Audience, spelled};
use rist::request::{Field, Flag, Request, number};
use serde_json::Value;

use crate::failure::Failure;

/// The flags that the user gave, each with its texts.
pub(crate) struct FlagValues(Vec<(Field, Vec<String>)>);

impl FlagValues {
    /// The flags among `fields` that are in the command line.
    pub(crate) fn of(fields: Vec<Field>, matches: &ArgMatches) -> FlagValues {
        let is_given = |field: &Field| matches.value_source(field.name) == Some(ValueSource::CommandLine);
        let texts = |field: &Field| match field.shape.flag {
            Flag::Switch => Vec::new(),
            _ => matches.get_many::<String>(field.name).into_iter().flatten().cloned().collect(),
        };
        let fields = fields.into_iter().filter(is_given);
        FlagValues(fields.map(|field| (field.clone(), texts(&field))).collect())
    }

    /// Reads the request `R` from the given flags. Files named by flags are read.
    pub(crate) fn read<R: Request>(&self) -> Result<R, Failure> {
        let (mut request, own) = (R::default(), R::fields());
        for (field, texts) in self.0.iter().filter(|(field, _)| own.iter().any(|own| own.name == field.name)) {
            request.set_texts(field.name, texts)?;
        }
        Ok(request)
    }

    /// The names of the given flags.
    pub(crate) fn names(&self) -> impl Iterator<Item = &'static str> {
        self.0.iter().map(|(field, _)| field.name)
    }

    /// The path given by the flag `name`; an empty path if the flag is not given.
    pub(crate) fn file(&self, name: &str) -> &Path {
        let given = self.0.iter().find(|(field, _)| field.name == name);
        given.and_then(|(_, texts)| texts.last()).map_or(Path::new(""), Path::new)
    }

    /// Paths of files whose content is part of the request.
    pub(crate) fn files(&self) -> impl Iterator<Item = &Path> {
        let files = self.0.iter().filter(|(field, _)| field.shape.is_file);
        files.flat_map(|(_, texts)| texts.iter().map(Path::new))
    }
}

/// The given flags of one request.
pub(crate) struct Flags<R>(FlagValues, PhantomData<R>);

impl<R: Request> Flags<R> {
    /// Reads the request. Files named by flags are read.
    pub(crate) fn read(&self) -> Result<R, Failure> {
        self.0.read()
    }
}

impl<R> Deref for Flags<R> {
    type Target = FlagValues;

    fn deref(&self) -> &FlagValues {
        &self.0
    }
}

impl<R: Request> Args for Flags<R> {
    fn augment_args(command: Command) -> Command {
        command.args(R::fields().iter().map(flag))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl<R: Request> FromArgMatches for Flags<R> {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Flags<R>, clap::Error> {
        Ok(Flags(FlagValues::of(R::fields(), matches), PhantomData))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Flags::from_arg_matches(matches)?;
        Ok(())
    }
}

/// Makes the command-line flag of a field.
pub(crate) fn flag(field: &Field) -> Arg {
    let name = if field.value_name.is_empty() { field.name.to_uppercase() } else { field.value_name.into() };
    let mut flag = Arg::new(field.name).long(field.flag_name()).help(spelled(&field.doc, Audience::Program));
    if let Some(letter) = field.short {
        flag = flag.short(letter);
    }
    if !field.heading.is_empty() {
        flag = flag.help_heading(field.heading);
    }
    // The value that follows the flag: none, a text, a number, a list, or one text per repetition of the flag.
    flag = match field.shape.flag {
        Flag::Switch => return flag.action(ArgAction::SetTrue),
        Flag::One => flag,
        Flag::Number => flag.allow_negative_numbers(true),
        Flag::Numbers => flag.allow_hyphen_values(true),
        Flag::List => flag.action(ArgAction::Append).value_delimiter(','),
        Flag::Repeated => flag.action(ArgAction::Append),
    };
    // For words and numbers, clap prints the default. Other defaults are in the help text.
    flag = match &field.default {
        Value::Number(x) => flag.default_value(number(x.as_f64().unwrap_or(f64::NAN))),
        Value::String(word) if !field.shape.words.is_empty() => flag.default_value(word.clone()),
        _ => flag,
    };
    if !field.shape.words.is_empty() {
        let words = field.shape.words.iter().map(|(word, help)| match help.is_empty() {
            true => PossibleValue::new(word),
            false => PossibleValue::new(word).help(help),
        });
        return flag.value_name(name).value_parser(PossibleValuesParser::new(words));
    }
    let check = field.shape.check;
    flag.value_name(name).value_parser(move |text: &str| check(text).map(|()| text.to_string()))
}
