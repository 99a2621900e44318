//! Subjects of claims.

use std::fmt;

use serde::Serialize;

/// A topic of a check, as a noun that fits before "of q2": `zero`, `delay`, `distance`. The crate with the check defines it
/// once.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Topic(pub &'static str);

/// A topic at joints or links.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Subject {
    /// The topic.
    pub topic: Topic,
    /// Joints or links by name; empty: the whole.
    pub of: Vec<String>,
}

impl Subject {
    /// The whole of a topic.
    pub fn whole(topic: Topic) -> Subject {
        Subject { topic, of: Vec::new() }
    }

    /// A topic at joints or links.
    pub fn of<S: Into<String>>(topic: Topic, names: impl IntoIterator<Item = S>) -> Subject {
        Subject { topic, of: names.into_iter().map(Into::into).collect() }
    }

    /// Whether both are about the same topic and have a joint or link in common.
    pub fn touches(&self, other: &Subject) -> bool {
        let is_whole = self.of.is_empty() || other.of.is_empty();
        self.topic == other.topic && (is_whole || self.of.iter().any(|name| other.of.contains(name)))
    }
}

impl fmt::Display for Subject {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let of = if self.of.is_empty() { "" } else { " of " };
        write!(f, "{}{of}{}", self.topic.0, self.of.join(", "))
    }
}
