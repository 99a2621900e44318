//! Writes formulas as a function for MATLAB or Octave. Its arguments may be numbers, or symbols of the Symbolic Math Toolbox.

use crate::print::{PLAIN, comment};
use crate::shown::PrintedFunction;

/// The text of a MATLAB file. Other files can call only its first function, by the name of the file.
pub(crate) fn file(head: &[String], functions: &[PrintedFunction]) -> String {
    let mut text = String::new();
    for PrintedFunction { name, doc, listing } in functions {
        let outputs: Vec<&str> = listing.outputs.iter().map(|o| o.name.as_str()).collect();
        let inputs = listing.inputs.iter().map(|(name, _)| name);
        let arguments: Vec<&str> = inputs.chain(&listing.constants).map(String::as_str).collect();
        text += &format!("function [{}] = {name}({})\n", outputs.join(", "), arguments.join(", "));
        text += &comment("%", doc);
        if functions[0].name == *name {
            text += &format!("%\n% Save as {name}.m\n{}", comment("%", head));
        }
        for (input, entries) in &listing.inputs {
            for (k, entry) in entries.iter().enumerate() {
                text += &format!("{entry} = {input}({});\n", k + 1);
            }
        }
        for (name, term) in &listing.assignments {
            text += &format!("{name} = {};\n", PLAIN.text(term));
        }
        for output in &listing.outputs {
            let name = &output.name;
            if let ([(_, _, term)], false) = (&output.entries[..], output.is_whole) {
                text += &format!("{name} = {};\n", PLAIN.text(term));
                continue;
            }
            // The entries are computed first, and the matrix is built of them in one statement. MATLAB cannot assign a symbol to
            // an entry of a numeric matrix.
            let entry = |row: usize, column: usize| format!("{name}_{}_{}", row + 1, column + 1);
            for (row, column, term) in &output.entries {
                text += &format!("{} = {};\n", entry(*row, *column), PLAIN.text(term));
            }
            let listed = |row: usize, column: usize| output.entries.iter().any(|(r, c, _)| (*r, *c) == (row, column));
            let cell = |row: usize, column: usize| if listed(row, column) { entry(row, column) } else { "0".into() };
            let line = |row: usize| (0..output.columns).map(|c| cell(row, c)).collect::<Vec<_>>().join(", ");
            text += &format!("{name} = [{}];\n", (0..output.rows).map(line).collect::<Vec<_>>().join("; "));
        }
        text += "end\n\n";
    }
    text.pop();
    text
}
