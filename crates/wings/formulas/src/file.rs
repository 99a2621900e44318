//! Functions as formulas for people and for computer algebra systems: one file per language.
//!
//! All languages print the same [`listing`]: assignments to named variables, or each entry expanded ([`expand`]). A language is a
//! grammar ([`print`]) and the frame of its file.

use expr::Function;

use crate::expand::{self, TooLong};
use crate::listing::{Listing, OutputEntry};
use crate::shown::PrintedFunction;
use crate::{latex, matlab, sympy, text};

/// The language of formulas.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FormulaLanguage {
    /// Lines `w3_z = w2_z + dq3`.
    Text,
    /// `align*` environments.
    Latex,
    /// Python functions of SymPy's expressions.
    Sympy,
    /// A function of MATLAB or Octave.
    Matlab,
}

/// A function with its description.
pub struct Formulas {
    /// Lines that describe the function.
    pub doc: Vec<String>,
    /// The function, with the named constants that stay symbols.
    pub function: Function,
    /// The one entry to print; `None` for all.
    pub place: Option<OutputEntry>,
    /// Whether each entry is expanded to a sum of products.
    pub is_expanded: bool,
}

/// The file of these functions; `doc` are the lines of its head, `made_by` is the command that writes the file again.
///
/// Fails where an expansion has too many terms or has quotients in it.
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

/// The names, in the language, of each entry of each input of a function, in the order of the inputs, then of the symbols that
/// stay: everything that a user of the file assigns a value to.
pub fn printed_symbols(function: &Function, language: FormulaLanguage) -> Vec<String> {
    let listing = Listing::of(function, None);
    let print: fn(&str) -> String = match language {
        FormulaLanguage::Latex => latex::variable,
        _ => str::to_string,
    };
    let inputs = listing.inputs.into_iter().flat_map(|(_, entries)| entries);
    inputs.chain(listing.constants).map(|name| print(&name)).collect()
}
