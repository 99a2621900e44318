//! The functions of a source file, and how long they are.

/// Functions with a body, outside of tests: their names, and their lines. The source is as rustfmt leaves it.
pub fn functions(text: &str) -> Vec<(String, usize)> {
    let lines: Vec<&str> = text.lines().take_while(|l| *l != "#[cfg(test)]").collect();
    let mut found = Vec::new();
    for (i, line) in lines.iter().enumerate() {
        let code = line.trim_start();
        let mut words = code.split_whitespace().skip_while(|w| w.starts_with("pub") || ["const", "unsafe"].contains(w));
        if words.next() != Some("fn") {
            continue;
        }
        let name: String = words.next().unwrap_or_default().chars().take_while(|c| *c != '(' && *c != '<').collect();
        let indent = &line[..line.len() - code.len()];
        let end = |l: &&str| l.strip_prefix(indent).is_some_and(|l| l == "}" || l.starts_with(")") && l.ends_with(';'));
        let is_bare = code.ends_with(';') || code.ends_with('}');
        let length = if is_bare { 1 } else { 1 + lines[i..].iter().position(end).unwrap_or(lines.len() - i) };
        found.push((name, length));
    }
    found
}

#[test]
fn a_function_ends_where_its_brace_does() {
    let (short, long) =
        ("fn a() {\n}\n".to_string(), format!("    fn b(\n    ) {{\n{}    }}\n", "        x;\n".repeat(58)));
    assert_eq!(functions(&(short + &long)), [("a".to_string(), 2), ("b".to_string(), 61)]);
}
