//! Reads attributes as numbers, choices and flags.

use super::defaults::View;
use crate::error::Error;
use crate::format::expression::LARGEST_NUMBER;
use crate::format::shown::shown;

impl View<'_> {
    /// The numbers of an attribute. Fails if there are fewer than `least` or more than `most` numbers; `None` if the attribute
    /// is absent.
    pub(super) fn numbers(&self, name: &str, least: usize, most: usize) -> Result<Option<Vec<f64>>, Error> {
        let Some(text) = self.get(name) else { return Ok(None) };
        let refuse = |what: String| Err(self.element.error(format!("`{name}` of {} {what}", self.element.called())));
        let mut numbers = Vec::new();
        for word in text.split_whitespace() {
            match word.parse::<f64>() {
                Ok(x) if x.abs() <= LARGEST_NUMBER => numbers.push(x),
                _ => return refuse(format!("holds `{}`, which is no number of a robot", shown(word))),
            }
        }
        if numbers.len() < least || numbers.len() > most {
            let wanted = match (least, most) {
                (1, 1) => "one number".to_string(),
                (least, most) if least == most => format!("{least} numbers"),
                _ => format!("{least} to {most} numbers"),
            };
            return refuse(format!("is `{}`; expected: {wanted}", shown(text)));
        }
        Ok(Some(numbers))
    }

    /// The N numbers of an attribute; `None` if it is absent.
    pub(super) fn vector<const N: usize>(&self, name: &str) -> Result<Option<[f64; N]>, Error> {
        Ok(self.numbers(name, N, N)?.and_then(|numbers| numbers.try_into().ok()))
    }

    /// The number of an attribute; `None` if it is absent.
    pub(super) fn number(&self, name: &str) -> Result<Option<f64>, Error> {
        Ok(self.vector(name)?.map(|[x]| x))
    }

    /// The index of the attribute's word in `words`; `None` if it is absent.
    pub(super) fn choice(&self, name: &str, words: &[&str]) -> Result<Option<usize>, Error> {
        let Some(text) = self.get(name) else { return Ok(None) };
        match words.iter().position(|word| *word == text.trim()) {
            Some(k) => Ok(Some(k)),
            None => {
                let called = self.element.called();
                let message = format!("`{name}` of {called} is `{}`; expected: {}", shown(text), words.join(", "));
                Err(self.element.error(message))
            }
        }
    }

    /// Whether an attribute is `true`; `None` if it is `auto` or absent.
    pub(super) fn flag(&self, name: &str) -> Result<Option<bool>, Error> {
        let which = self.choice(name, &["false", "true", "auto"])?;
        Ok(which.filter(|&k| k < 2).map(|k| k == 1))
    }
}
