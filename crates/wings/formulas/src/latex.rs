//! Writes formulas as LaTeX: one `align*` per function, for `\input` into a document with amsmath.

use crate::print::{Grammar, comment, place};
use crate::shown::PrintedFunction;

const GRAMMAR: Grammar = Grammar {
    times: r" \, ",
    power: ["^{", "}"],
    quotient: [r"\frac{", "}{", "}"],
    quotient_brackets: false,
    root: [r"\sqrt{", "}"],
    sine: [r"\sin(", ")"],
    cosine: [r"\cos(", ")"],
    variable,
};

/// If a line has more than this number of characters, the equation continues on a new line before its next plus or minus sign.
const WIDTH: usize = 120;

/// The text of the LaTeX file with these functions.
pub(crate) fn file(head: &[String], functions: &[PrintedFunction]) -> String {
    let mut text = comment("%", head);
    for PrintedFunction { name, doc, listing } in functions {
        text += &format!("\n% {name}\n{}", comment("%", doc));
        let mut lines = Vec::new();
        for (name, term) in &listing.assignments {
            lines.push(equation(&variable(name), &GRAMMAR.parts(term)));
        }
        for output in &listing.outputs {
            for (row, column, term) in &output.entries {
                let name = format!("{}_{{{}}}", symbol(&output.name), place(output, *row, *column));
                lines.push(equation(&name, &GRAMMAR.parts(term)));
            }
        }
        if !lines.is_empty() {
            text += &format!("\\begin{{align*}}\n{}\n\\end{{align*}}\n", lines.join(" \\\\\n"));
        }
        for output in listing.outputs.iter().filter(|o| o.is_whole && o.entries.len() < o.rows * o.columns) {
            text += &format!("% All other entries of {} are 0.\n", output.name);
        }
    }
    text
}

/// The equation `left &= right`. A long equation is divided into several lines.
fn equation(left: &str, parts: &[String]) -> String {
    let (mut text, mut width) = (format!("{left} &= "), 0);
    for part in parts {
        if width > 0 && width + part.len() > WIDTH {
            text += " \\\\\n  &\\quad";
            width = 0;
        }
        text += part;
        width += part.len();
    }
    text
}

/// A name in LaTeX with its index: `\dot{q}_{2}`, `\omega_{3,x}`, `C_{23}`, `\mathit{ZZR}_{2}`.
pub(crate) fn variable(name: &str) -> String {
    let letters = name.find(|c: char| !c.is_ascii_alphabetic()).unwrap_or(name.len());
    let (letters, index) = name.split_at(letters);
    let index = index.trim_matches('_').replace('_', ",");
    let (symbol, mut index) = (symbol(letters), index);
    // Names that differ only in trailing underscores get different numbers of primes.
    index += &"'".repeat(name.len() - name.trim_end_matches('_').len());
    if index.is_empty() { symbol } else { format!("{symbol}_{{{index}}}") }
}

fn symbol(letters: &str) -> String {
    let greek = ["alpha", "gamma", "theta", "tau"];
    match letters {
        "w" => r"\omega".into(),
        "dw" => r"\dot{\omega}".into(),
        "dq" => r"\dot{q}".into(),
        "ddq" => r"\ddot{q}".into(),
        _ if greek.contains(&letters) => format!("\\{letters}"),
        _ if letters.len() == 1 => letters.into(),
        _ => format!("\\mathit{{{}}}", letters.replace('_', r"\_")),
    }
}
