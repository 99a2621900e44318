//! Writes formulas as Python functions that take SymPy symbols or numbers and return SymPy matrices.

use crate::listing::{ListedOutput, Term};
use crate::print::{Grammar, PLAIN, comment};
use crate::shown::PrintedFunction;

const GRAMMAR: Grammar = Grammar { power: ["**", ""], ..PLAIN };

/// The text of the Python file with these functions.
pub(crate) fn file(head: &[String], functions: &[PrintedFunction]) -> String {
    let mut text = comment("#", head);
    text += "\nfrom sympy import Matrix, cos, sin, sqrt, symbols\n";
    for PrintedFunction { name, doc, listing } in functions {
        let input = |(input, entries): &(String, Vec<String>)| format!("{input}={}", symbols(entries));
        let constant = |name: &String| format!("{name}=symbols(\"{name}\")");
        let arguments: Vec<String> =
            listing.inputs.iter().map(input).chain(listing.constants.iter().map(constant)).collect();
        text += &format!("\n\ndef {name}({}):\n", arguments.join(", "));
        let doc: Vec<String> = doc.iter().map(|line| line.replace('\\', r"\\").replace('"', "'")).collect();
        text += &format!("    \"\"\"{}\"\"\"\n", doc.join("\n    "));
        for (input, entries) in listing.inputs.iter().filter(|(_, entries)| !entries.is_empty()) {
            let comma = if entries.len() == 1 { "," } else { "" };
            text += &format!("    {}{comma} = {input}\n", entries.join(", "));
        }
        for (name, term) in &listing.assignments {
            text += &format!("    {name} = {}\n", GRAMMAR.text(term));
        }
        for output in &listing.outputs {
            text += &assignment(output);
        }
        let names: Vec<&str> = listing.outputs.iter().map(|o| o.name.as_str()).collect();
        text += &format!("    return {}\n", names.join(", "));
    }
    text
}

/// A tuple of symbols, as the default value of an argument.
fn symbols(entries: &[String]) -> String {
    if entries.is_empty() { "()".into() } else { format!("symbols(\"{}\", seq=True)", entries.join(" ")) }
}

fn assignment(output: &ListedOutput) -> String {
    let name = &output.name;
    match (&output.entries[..], output.is_whole) {
        ([(_, _, term)], false) => format!("    {name} = {}\n", GRAMMAR.text(term)),
        (entries, _) => {
            let mut text = format!("    {name} = Matrix.zeros({}, {})\n", output.rows, output.columns);
            let line = |(row, column, term): &(usize, usize, Term)| {
                format!("    {name}[{row}, {column}] = {}\n", GRAMMAR.text(term))
            };
            text.extend(entries.iter().map(line));
            text
        }
    }
}
