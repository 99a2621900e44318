//! Writes formulas as plain text with one assignment per line. All other lines start with `#`.

use crate::print::{PLAIN, comment, place};
use crate::shown::PrintedFunction;

/// The text of the file with these functions.
pub(crate) fn file(head: &[String], functions: &[PrintedFunction]) -> String {
    let mut text = comment("#", head);
    for PrintedFunction { name, doc, listing } in functions {
        text += &format!("\n# {name}\n{}", comment("#", doc));
        for (input, entries) in &listing.inputs {
            text += &format!("# {input}: {}\n", entries.join(" "));
        }
        for (name, term) in &listing.assignments {
            text += &format!("{name} = {}\n", PLAIN.text(term));
        }
        for output in &listing.outputs {
            for (row, column, term) in &output.entries {
                text += &format!("{}[{}] = {}\n", output.name, place(output, *row, *column), PLAIN.text(term));
            }
            let zeros = output.rows * output.columns - output.entries.len();
            if output.is_whole && zeros > 0 {
                text += &format!("# The {zeros} other entries of {} are 0.\n", output.name);
            }
        }
    }
    text
}
