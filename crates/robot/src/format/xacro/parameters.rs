//! Parses the parameters of a xacro macro.

use crate::format::shown::shown;

/// A parameter of a macro. The name of a block parameter (it gets XML elements) starts with one or two stars, as in the file.
#[derive(Clone, Debug)]
pub(super) struct Parameter {
    pub name: String,
    /// Whether the default is `^`: if the name of the parameter has a value at the caller, the parameter gets this value.
    pub forwards: bool,
    pub default: Option<String>,
}

/// Parses a parameter list such as `a b:=1 c:=^ d:=^|2 *block **blocks`. A default may be quoted.
pub(super) fn parameters(text: &str) -> Result<Vec<Parameter>, String> {
    let (mut found, mut rest) = (Vec::new(), text.trim_start());
    while !rest.is_empty() {
        let end = rest.find(|c: char| c.is_whitespace() || c == '=').unwrap_or(rest.len());
        let name = rest[..end].trim_end_matches(':').to_string();
        let is_name = |name: &str| !name.is_empty() && name.chars().all(|c| c.is_alphanumeric() || "_-.".contains(c));
        if !is_name(name.trim_start_matches('*')) {
            return Err(format!("`params`: `{}` is no name of a parameter", shown(&name)));
        }
        rest = &rest[end..];
        let mut parameter = Parameter { name, forwards: false, default: None };
        if let Some(behind) = rest.strip_prefix('=') {
            rest = behind;
            if let Some(behind) = rest.strip_prefix('^') {
                (parameter.forwards, rest) = (true, behind.strip_prefix('|').unwrap_or(behind));
            }
            let quote = rest.chars().next().filter(|c| matches!(c, '\'' | '"'));
            let (default, behind) = match quote {
                Some(quote) => rest[1..].split_once(quote).ok_or("`params`: a default is not closed")?,
                // A default may contain blanks inside `${}`: `${a b}`.
                None => rest.split_at(end_of_default(rest)),
            };
            let is_there = quote.is_some() || !default.is_empty();
            parameter.default = is_there.then(|| default.to_string());
            rest = behind;
        }
        found.push(parameter);
        rest = rest.trim_start();
    }
    Ok(found)
}

fn end_of_default(text: &str) -> usize {
    let mut open = 0;
    for (at, c) in text.char_indices() {
        match c {
            '{' | '(' => open += 1,
            '}' | ')' => open -= 1,
            c if c.is_whitespace() && open <= 0 => return at,
            _ => {}
        }
    }
    text.len()
}
