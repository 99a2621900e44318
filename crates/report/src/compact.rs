//! Minifies a JavaScript file for a page: removes comments, indentation and unnecessary spaces.
//!
//! Names and most line breaks are kept, so that an error in a browser can be located in `templates/`. Strings, templates and
//! regular expressions are unchanged, because spaces in them can be part of the page. A script must not contain an empty
//! statement before a brace (`while (x);}`).

/// Returns the minified script.
pub fn compact(script: &str) -> String {
    let mut reader = ScriptReader { rest: script, out: String::with_capacity(script.len()), open: Vec::new() };
    while let Some(c) = reader.rest.chars().next() {
        match c {
            '"' | '\'' => reader.copy_until(c),
            '`' => reader.copy_template(),
            '/' if reader.rest.starts_with("//") => {
                reader.rest = reader.rest.find('\n').map_or("", |end| &reader.rest[end..]);
            }
            '/' if reader.begins_an_operand() => reader.copy_expression(),
            c if c.is_whitespace() => reader.blank(),
            '}' if reader.open.last() == Some(&0) => {
                reader.open.pop();
                reader.copy_template();
            }
            c => {
                if c == '}' && reader.out.ends_with(';') {
                    reader.out.pop();
                }
                if let Some(depth) = reader.open.last_mut() {
                    *depth = (*depth + usize::from(c == '{')).saturating_sub(usize::from(c == '}'));
                }
                reader.copy(c.len_utf8());
            }
        }
    }
    reader.out
}

struct ScriptReader<'a> {
    rest: &'a str,
    out: String,
    /// One entry per open `${` of a template: the number of braces that are open inside this `${`.
    open: Vec<usize>,
}

/// A line break after one of these characters is removed, because the statement continues on the next line. The next constant
/// lists the characters before which a line break is removed.
const GOES_ON_BEHIND: &str = "{(,[;\n=>&|?:.+-";
const GOES_ON_BEFORE: &str = ")].,?:&|=";

impl ScriptReader<'_> {
    fn copy(&mut self, bytes: usize) {
        let (copied, rest) = self.rest.split_at(bytes.min(self.rest.len()));
        self.out.push_str(copied);
        self.rest = rest;
    }

    /// Number of bytes before the first unescaped character that `is_end` accepts. The search starts at the second character.
    fn length(&self, mut is_end: impl FnMut(&str) -> bool) -> usize {
        let mut escaped = false;
        for (i, c) in self.rest.char_indices().skip(1) {
            if !escaped && is_end(&self.rest[i..]) {
                return i;
            }
            escaped = c == '\\' && !escaped;
        }
        self.rest.len()
    }

    fn copy_until(&mut self, quote: char) {
        let length = self.length(|rest| rest.starts_with(quote));
        self.copy(length + 1);
    }

    /// Copies a part of a template: from a backtick, or from the end of a `${}`, to the next `${` or to the end of the
    /// template.
    fn copy_template(&mut self) {
        let length = self.length(|rest| rest.starts_with('`') || rest.starts_with("${"));
        if self.rest[length..].starts_with("${") {
            self.open.push(0);
            self.copy(1);
        }
        self.copy(length + 1);
    }

    fn copy_expression(&mut self) {
        let mut is_class = false;
        let length = self.length(|rest| {
            is_class = rest.starts_with('[') || is_class && !rest.starts_with(']');
            rest.starts_with('/') && !is_class
        });
        self.copy(length + 1);
    }

    /// Whether a slash at this position starts a regular expression. Otherwise the slash is a division.
    fn begins_an_operand(&self) -> bool {
        self.out.chars().next_back().is_none_or(|c| "(,=:[!&|?{};\n".contains(c))
    }

    fn blank(&mut self) {
        let rest = self.rest.trim_start();
        let is_line = self.rest[..self.rest.len() - rest.len()].contains('\n');
        let before = self.out.chars().next_back().unwrap_or('\n');
        let after = rest.chars().next().unwrap_or('\n');
        let is_word = |c: char| c.is_alphanumeric() || c == '_' || c == '$';
        let goes_on = || GOES_ON_BEHIND.contains(before) || GOES_ON_BEFORE.contains(after);
        if is_line && !goes_on() {
            self.out.push('\n');
        } else if is_word(before) && is_word(after) || before == after && "+-".contains(before) {
            self.out.push(' ');
        }
        self.rest = rest;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_script_does_stays() {
        let same = [
            ("const a = 1;\n  // that is one\n  const b = a + +a;\n", "const a=1;const b=a+ +a;"),
            ("if (a) {\n  b();\n}\nc();\n", "if(a){b()}\nc();"),
            (
                "x = 'a  b' + \"// no\" + `c  ${ d + { e: `f  ${ g }` }.e }  h`;",
                "x='a  b'+\"// no\"+`c  ${d+{e:`f  ${g}`}.e}  h`;",
            ),
            ("y = z.replace(/[/ \"] /g, 1) / 2;", "y=z.replace(/[/ \"] /g,1)/2;"),
            ("return x\n  .map(f);", "return x.map(f);"),
            ("s = '\\'  ';", "s='\\'  ';"),
        ];
        for (script, expected) in same {
            assert_eq!(compact(script).trim_end(), expected);
        }
    }
}
