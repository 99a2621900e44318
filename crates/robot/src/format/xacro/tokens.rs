//! Splits an expression into tokens.

/// The tokens of an expression. A token that is a quoted text starts with its quote; the closing quote is omitted.
pub(super) fn tokens(text: &str) -> Result<Vec<String>, String> {
    let chars: Vec<char> = text.chars().collect();
    let (mut found, mut at) = (Vec::new(), 0);
    while at < chars.len() {
        let c = chars[at];
        let start = at;
        if c.is_whitespace() {
            at += 1;
            continue;
        }
        if c.is_alphabetic() || c == '_' {
            while at < chars.len() && (chars[at].is_alphanumeric() || chars[at] == '_') {
                at += 1;
            }
        } else if c.is_ascii_digit() || c == '.' && chars.get(at + 1).is_some_and(char::is_ascii_digit) {
            while at < chars.len() {
                let is_sign = matches!(chars[at], '+' | '-') && matches!(chars[at - 1], 'e' | 'E') && at > start;
                if !(chars[at].is_ascii_alphanumeric() || chars[at] == '.' || is_sign) {
                    break;
                }
                at += 1;
            }
        } else if c == '\'' || c == '"' {
            at += 1;
            while at < chars.len() && chars[at] != c {
                at += 1;
            }
            if at == chars.len() {
                return Err(format!("a text in `{}` is not closed", text.trim()));
            }
            // The closing quote is not part of the token.
            found.push(chars[start..at].iter().collect());
            at += 1;
            continue;
        } else {
            let two: String = chars[at..chars.len().min(at + 2)].iter().collect();
            at += if ["**", "//", "==", "!=", "<=", ">="].contains(&two.as_str()) { 2 } else { 1 };
        }
        found.push(chars[start..at].iter().collect());
    }
    Ok(found)
}
