//! `rist inspect`: shows base parameters, regrouping rules, operation counts and the evidence for the rank.
//!
//! The number of base parameters is the rank of the regressor. Evidence for the rank: the gap between the columns that are kept
//! and the columns that are dropped, and an exact computation of the rank.

use std::io::IsTerminal;

use clap::Args;
use rist::request::{InspectRequest, SheetFormat};

use crate::failure::Failure;
use crate::flags::Flags;
use crate::model::ModelArguments;
use crate::terminal::{at_work, is_json, print};

/// Text width for a pipe or a file, characters.
const PIPE_COLUMNS: usize = 80;
/// Largest text width, characters. Longer lines are hard to read.
const LARGEST_WIDTH: usize = 120;

/// Show a robot's base parameters, regrouping rules, operation counts and rank evidence
///
/// For each base parameter: its meaning, its regrouping rule, and its value if the description has inertial parameters.
#[derive(Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    model: ModelArguments,

    #[command(flatten)]
    request: Flags<InspectRequest>,
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let request = arguments.request.read()?;
    let robot = arguments.model.read()?;
    let path = &arguments.model.model;
    at_work(format_args!("deriving {}", path.display()));
    let found = rist::inspect(robot, path, &arguments.model.options()?, &request)?;
    print(&match if is_json() { SheetFormat::Json } else { request.format } {
        SheetFormat::Text => found.text(width()),
        SheetFormat::Markdown => found.markdown(),
        SheetFormat::Latex => found.latex(),
        SheetFormat::Html => found.html(),
        SheetFormat::Json => format!("{:#}\n", found.to_json()),
    })
}

/// Text width for standard output, characters.
fn width() -> usize {
    let out = std::io::stdout();
    let found = out.is_terminal().then(|| terminal_size::terminal_size_of(&out)).flatten();
    found.map_or(PIPE_COLUMNS, |(width, _)| usize::from(width.0).clamp(PIPE_COLUMNS / 2, LARGEST_WIDTH))
}
