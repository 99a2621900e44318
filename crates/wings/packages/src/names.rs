//! Writes names and numbers of a robot in the languages of a package.
//!
//! Names of users may contain characters that have a meaning in these languages, so they are escaped or converted.

use std::fmt::Write;

/// A text as a string of JSON, which is also a string of YAML, Python and C++. Hidden characters are escaped.
pub(crate) fn quoted(text: &str) -> String {
    // In C++, a universal character name may not be a control character. `line` has already escaped these.
    serde_json::to_string(&gate::shown::line(text)).expect("a text is JSON")
}

/// A text for an element of XML.
pub(crate) fn xml(text: &str) -> String {
    let text = gate::shown::line(text);
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// A text inside a comment of C or CMake, or in a docstring of Python: one line that does not end the comment.
pub(crate) fn comment(text: &str) -> String {
    gate::shown::line(text).replace("*/", "* /").replace("\"\"\"", "'''").replace('\\', "/").replace('`', "'")
}

/// The name of a package of ROS 2: small letters, digits and single underscores, a letter first.
pub(crate) fn ros_package(prefix: &str) -> String {
    let words = prefix.split(|c: char| !c.is_ascii_alphanumeric()).filter(|word| !word.is_empty());
    let name = words.map(str::to_ascii_lowercase).collect::<Vec<_>>().join("_");
    match name.starts_with(|c: char| c.is_ascii_lowercase()) {
        true => format!("{name}_rist"),
        false => format!("robot_{name}_rist").replace("__", "_"),
    }
}

/// Numbers with commas between them. `before`: text before each number, such as a cast.
pub(crate) fn numbers(all: &[f64], before: &str) -> String {
    all.iter().map(|x| format!("{before}{x:?}")).collect::<Vec<_>>().join(", ")
}

/// Replaces each `@NAME@` of a template by its text, in one pass. If a text itself contains such a name, this name is not
/// replaced.
pub(crate) fn filled(template: &str, values: &[(&str, String)]) -> String {
    let mut parts = template.split('@');
    let mut text = parts.next().unwrap_or_default().to_string();
    let mut is_open = true;
    for part in parts {
        match values.iter().find(|(name, _)| is_open && *name == part) {
            Some((_, value)) => {
                text += value;
                is_open = false;
            }
            None => {
                let at = if is_open { "@" } else { "" };
                let _ = write!(text, "{at}{part}");
                is_open = true;
            }
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_template_is_filled_once() {
        let values = [("A", "@B@".to_string()), ("B", "b".to_string())];
        assert_eq!(filled("x @A@@B@ y@z @C@ @A@", &values), "x @B@b y@z @C@ @B@");
    }

    #[test]
    fn names_that_a_language_cannot_hold() {
        assert_eq!(ros_package("UR5__e"), "ur5_e_rist");
        assert_eq!(ros_package("2r"), "robot_2r_rist");
        assert_eq!(ros_package("_"), "robot_rist");
        assert_eq!(xml("a<b> & \"c\"\n"), "a&lt;b&gt; &amp; &quot;c&quot;\\n");
        assert_eq!(comment("a */ \"\"\" \u{1b}"), "a * / ''' /u{1b}");
        assert_eq!(quoted("j\"1\\"), r#""j\"1\\""#);
    }
}
