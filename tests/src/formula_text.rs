//! Evaluates the assignments of a printed formula file, in plain text, MATLAB or LaTeX.
//!
//! So the test can compare the printed formulas with the functions of the library, as numbers.

use std::collections::HashMap;

/// The values of all names to which the lines of a file assign an expression. `symbols`: values of the symbols that occur in the
/// expressions.
///
/// Each line is `name = expression`, or `name &= expression` in LaTeX.
pub fn evaluated<'a>(lines: impl Iterator<Item = &'a str>, symbols: HashMap<String, f64>) -> HashMap<String, f64> {
    let mut values = symbols;
    for line in lines {
        let (name, expression) = line.split_once('=').unwrap_or_else(|| panic!("no assignment: {line}"));
        let name = name.trim_end_matches('&').trim();
        let mut reader = Reader { text: expression.trim().trim_end_matches(';'), values: &values };
        let value = reader.sum();
        assert!(reader.text.is_empty(), "`{}` is left of {line}", reader.text);
        let old = values.insert(name.to_string(), value);
        assert!(old.is_none(), "{name} is assigned twice");
    }
    values
}

/// The assignments of a file, without comments. Assignments over several lines are joined.
pub fn assignments(file: &str) -> Vec<String> {
    let joined = file.replace(" \\\\\n  &\\quad", " ").replace(" \\\\\n", "\n");
    let is_one = |line: &&str| !line.is_empty() && !line.starts_with(['#', '%', '\\']) || line.contains("&=");
    joined.lines().filter(is_one).map(str::to_string).collect()
}

struct Reader<'a> {
    text: &'a str,
    values: &'a HashMap<String, f64>,
}

impl Reader<'_> {
    /// Skips blanks, and consumes `token` if the text continues with it. Returns whether it does.
    fn takes(&mut self, token: &str) -> bool {
        self.text = self.text.trim_start();
        match self.text.strip_prefix(token) {
            Some(rest) => {
                self.text = rest;
                true
            }
            None => false,
        }
    }

    fn must(&mut self, token: &str) {
        assert!(self.takes(token), "`{token}` is missing before `{}`", self.text);
    }

    fn sum(&mut self) -> f64 {
        let mut sum = if self.takes("-") { -self.product() } else { self.product() };
        loop {
            if self.takes("+") {
                sum += self.product();
            } else if self.takes("-") {
                sum -= self.product();
            } else {
                return sum;
            }
        }
    }

    fn product(&mut self) -> f64 {
        let mut product = self.power();
        loop {
            if self.takes("*") || self.takes("\\,") {
                product *= self.power();
            } else if self.takes("/") {
                product /= self.power();
            } else {
                return product;
            }
        }
    }

    fn power(&mut self) -> f64 {
        let base = self.single();
        if self.takes("^{") {
            let exponent = self.sum();
            self.must("}");
            return base.powf(exponent);
        }
        if self.takes("^") { base.powf(self.single()) } else { base }
    }

    fn single(&mut self) -> f64 {
        for (before, behind, function) in [
            ("\\sin(", ")", f64::sin as fn(f64) -> f64),
            ("sin(", ")", f64::sin),
            ("\\cos(", ")", f64::cos),
            ("cos(", ")", f64::cos),
            ("\\sqrt{", "}", f64::sqrt),
            ("sqrt(", ")", f64::sqrt),
            ("(", ")", |x| x),
        ] {
            if self.takes(before) {
                let inner = self.sum();
                self.must(behind);
                return function(inner);
            }
        }
        if self.takes("\\frac{") {
            let a = self.sum();
            self.must("}{");
            let b = self.sum();
            self.must("}");
            return a / b;
        }
        let end = self.end_of_word();
        let (word, rest) = self.text.split_at(end);
        self.text = rest;
        word.parse().ok().or_else(|| self.values.get(word).copied()).unwrap_or_else(|| panic!("`{word}` has no value"))
    }

    /// The position after a number or a name, which has letters, digits, `_`, `.`, a leading backslash, and groups in braces.
    fn end_of_word(&self) -> usize {
        let (mut depth, mut end) = (0, 0);
        for (at, c) in self.text.char_indices() {
            let goes_on =
                depth > 0 || c.is_ascii_alphanumeric() || matches!(c, '_' | '.' | '{') || (c == '\\' && at == 0);
            if !goes_on {
                break;
            }
            depth += i32::from(c == '{') - i32::from(c == '}');
            end = at + c.len_utf8();
        }
        end
    }
}
