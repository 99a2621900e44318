//! Writes functions as formulas, for readers and for computer algebra systems: one file in one language.
//!
//! All languages print the same [`listing`], which has assignments to named variables, or each entry expanded ([`expand`]). Each
//! language has its own grammar ([`print`]), and its own head and end of the file.

use expr::Function;

use crate::expand::{self, TooLong};
use crate::listing::{Listing, OutputEntry};
use crate::shown::PrintedFunction;
use crate::{latex, matlab, sympy, text};

/// The language of a formula file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FormulaLanguage {
    /// Plain text with lines such as `w3_z = w2_z + dq3`.
    Text,
    /// LaTeX: `align*` environments.
    Latex,
    /// Python functions with expressions of SymPy.
    Sympy,
    /// A function for MATLAB or Octave.
    Matlab,
}

/// A function to print, with its description and its form.
pub struct Formulas {
    /// Lines that describe the function.
    pub doc: Vec<String>,
    /// The function. Named constants stay symbols in it.
    pub function: Function,
    /// The only entry to print; `None`: all entries.
    pub place: Option<OutputEntry>,
    /// Whether each entry is expanded to a sum of products.
    pub is_expanded: bool,
}

/// The text of a file with these functions. `doc`: lines for the head of the file. `made_by`: the command that generates the
/// file.
///
/// Fails if an expansion has too many terms or contains quotients.
pub fn formula_file(
    doc: &[String],
    functions: &[Formulas],
    language: FormulaLanguage,
    made_by: &str,
) -> Result<String, TooLong> {
    let mut head = vec![format!("Made by `{made_by}`.")];
    head.extend(doc.iter().cloned());
    let head: Vec<String> = head.iter().map(|line| codegen::steps::in_line(line).trim_end().to_string()).collect();
    let mut shown = Vec::new();
    for f in functions {
        let listing = match f.is_expanded {
            true => expand::expanded(&f.function, f.place)?,
            false => Listing::of(&f.function, f.place),
        };
        shown.push(PrintedFunction { name: &f.function.name, doc: &f.doc, listing });
    }
    Ok(match language {
        FormulaLanguage::Text => text::file(&head, &shown),
        FormulaLanguage::Latex => latex::file(&head, &shown),
        FormulaLanguage::Sympy => sympy::file(&head, &shown),
        FormulaLanguage::Matlab => matlab::file(&head, &shown),
    })
}

/// The names, in this language, of all symbols to which a user must assign values: first the entries of each input of the
/// function, in the order of the inputs, then the named constants.
pub fn printed_symbols(function: &Function, language: FormulaLanguage) -> Vec<String> {
    let listing = Listing::of(function, None);
    let print: fn(&str) -> String = match language {
        FormulaLanguage::Latex => latex::variable,
        _ => str::to_string,
    };
    let inputs = listing.inputs.into_iter().flat_map(|(_, entries)| entries);
    inputs.chain(listing.constants).map(|name| print(&name)).collect()
}
