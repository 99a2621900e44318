//! Subjects of claims: the topic of a check, and the joints or links that the check concerns.

use std::fmt;

use serde::Serialize;

/// The topic of a check, as a noun that fits before "of q2": `zero`, `delay`, `distance`. Each topic is a constant in the crate
/// that has the check.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Topic(pub &'static str);

/// The subject of a claim: a topic at certain joints or links, or at the whole robot.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Subject {
    /// The topic of the check.
    pub topic: Topic,
    /// Names of the joints or links. Empty: the whole robot.
    pub of: Vec<String>,
}

impl Subject {
    /// The subject of a topic at the whole robot.
    pub fn whole(topic: Topic) -> Subject {
        Subject { topic, of: Vec::new() }
    }

    /// The subject of a topic at the joints or links `names`.
    pub fn of<S: Into<String>>(topic: Topic, names: impl IntoIterator<Item = S>) -> Subject {
        Subject { topic, of: names.into_iter().map(Into::into).collect() }
    }

    /// Whether both subjects have the same topic and a common joint or link. A subject of the whole robot has all joints and
    /// links.
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
