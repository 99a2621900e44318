//! Converts terms (expressions of variables and numbers, from `listing`) to text. The grammar of a language says how it writes
//! powers, quotients and parentheses.

use crate::listing::{ListedOutput, Term};

/// The notation of a language for expressions.
pub(crate) struct Grammar {
    pub times: &'static str,
    /// The texts before and after an exponent.
    pub power: [&'static str; 2],
    /// The texts before a numerator, between numerator and denominator, and after the denominator.
    pub quotient: [&'static str; 3],
    /// Whether a numerator or denominator that is a sum or a product needs parentheses.
    pub quotient_brackets: bool,
    pub root: [&'static str; 2],
    pub sine: [&'static str; 2],
    pub cosine: [&'static str; 2],
    pub variable: fn(&str) -> String,
}

/// The notation of most programming languages.
pub(super) const PLAIN: Grammar = Grammar {
    times: "*",
    power: ["^", ""],
    quotient: ["", "/", ""],
    quotient_brackets: true,
    root: ["sqrt(", ")"],
    sine: ["sin(", ")"],
    cosine: ["cos(", ")"],
    variable: str::to_string,
};

/// Writes lines as comments. `mark`: start of a comment line.
pub(super) fn comment(mark: &str, lines: &[String]) -> String {
    lines.iter().map(|line| format!("{mark} {line}").trim_end().to_string() + "\n").collect()
}

/// The index of an entry, counted from 1: `1,2` in a matrix, `1` in a column.
pub(super) fn place(output: &ListedOutput, row: usize, column: usize) -> String {
    if output.columns == 1 { format!("{}", row + 1) } else { format!("{},{}", row + 1, column + 1) }
}

/// The precedence of a term. A term with a lower precedence needs parentheses inside a term with a higher one.
#[derive(Clone, Copy, PartialEq, PartialOrd)]
enum Bond {
    Sum,
    Product,
    Single,
}

impl Grammar {
    /// The term as text.
    pub(super) fn text(&self, term: &Term) -> String {
        self.parts(term).concat()
    }

    /// The term as a list of texts: a sum is divided before each of its signs. A line may be broken between two texts.
    pub(super) fn parts(&self, term: &Term) -> Vec<String> {
        let Term::Sum(terms) = term else { return vec![self.bonded(term).0] };
        let part = |(k, (negative, term)): (usize, &(bool, Term))| {
            let text = self.within(term, Bond::Product);
            match (k, negative) {
                (0, false) => text,
                (0, true) => format!("-{text}"),
                (_, false) => format!(" + {text}"),
                (_, true) => format!(" - {text}"),
            }
        };
        terms.iter().enumerate().map(part).collect()
    }

    /// The term as text, in parentheses if its precedence is below `bond`.
    fn within(&self, term: &Term, bond: Bond) -> String {
        let (text, own) = self.bonded(term);
        if own >= bond { text } else { format!("({text})") }
    }

    fn bonded(&self, term: &Term) -> (String, Bond) {
        let of = |[before, behind]: [&str; 2], a: &Term| (format!("{before}{}{behind}", self.text(a)), Bond::Single);
        match term {
            Term::Number(x) => (x.to_string(), Bond::Single),
            Term::Variable(name) => ((self.variable)(name), Bond::Single),
            Term::Sum(_) => (self.text(term), Bond::Sum),
            Term::Product(factors) => {
                let factor = |(factor, power): &(Term, u32)| {
                    let text = self.within(factor, if *power > 1 { Bond::Single } else { Bond::Product });
                    if *power > 1 { format!("{text}{}{power}{}", self.power[0], self.power[1]) } else { text }
                };
                (factors.iter().map(factor).collect::<Vec<_>>().join(self.times), Bond::Product)
            }
            Term::Quotient(a, b) => {
                let bond = if self.quotient_brackets { Bond::Single } else { Bond::Sum };
                let [before, between, behind] = self.quotient;
                (format!("{before}{}{between}{}{behind}", self.within(a, bond), self.within(b, bond)), Bond::Product)
            }
            Term::Root(a) => of(self.root, a),
            Term::Sine(a) => of(self.sine, a),
            Term::Cosine(a) => of(self.cosine, a),
        }
    }
}
