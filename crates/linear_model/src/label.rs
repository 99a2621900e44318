//! Labels in names of parameters. A name is the letters of the parameter, then a label: the number of a link or coordinate
//! (`FV3`), or `_` and a word (`FV_elbow`).

use std::fmt;
use std::str::FromStr;

/// The label in the name of a parameter: `3` in `FV3`, `_elbow` in `FV_elbow`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Label(String);

impl Label {
    /// The label of a coordinate: `3` for `q3`; for any other name, an underscore and the name.
    pub fn of_coordinate(name: &str) -> Label {
        match name.strip_prefix('q') {
            Some(digits) if !digits.is_empty() && digits.bytes().all(|b| b.is_ascii_digit()) => Label(digits.into()),
            _ => Label(format!("_{name}")),
        }
    }

    /// The label of a link: unchanged if it starts with a digit, else an underscore and the text.
    pub fn of_link(label: &str) -> Label {
        let is_number = label.starts_with(|c: char| c.is_ascii_digit());
        Label(if is_number { label.into() } else { format!("_{label}") })
    }
}

impl fmt::Display for Label {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl FromStr for Label {
    type Err = ();

    fn from_str(text: &str) -> Result<Label, ()> {
        let is_number = text.starts_with(|c: char| c.is_ascii_digit());
        let is_word = text.len() > 1 && text.starts_with('_');
        if is_number || is_word { Ok(Label(text.into())) } else { Err(()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels() {
        assert_eq!(Label::of_coordinate("q3").to_string(), "3");
        assert_eq!(Label::of_coordinate("elbow").to_string(), "_elbow");
        assert_eq!(Label::of_coordinate("q").to_string(), "_q");
        assert_eq!(Label::of_link("3").to_string(), "3");
        assert_eq!(Label::of_link("wrist_1").to_string(), "_wrist_1");
    }
}
