//! What somebody wants to do, and what must be told for it.

use crate::claim::Claim;
use crate::standing::Standing;
use crate::subject::Subject;

/// A subject that a purpose needs, and how high it must stand.
#[derive(Clone, Debug, PartialEq)]
pub struct Need {
    subject: Subject,
    at_least: Standing,
}

impl Need {
    /// A subject that must not be contradicted. Where each joint must be told, it names the joints.
    pub fn new(subject: Subject) -> Need {
        Need { subject, at_least: Standing::Open }
    }

    /// A subject that must stand as high as this, since the user asked for it: where it is lower, the purpose is refused.
    pub fn at_least(subject: Subject, standing: Standing) -> Need {
        Need { subject, at_least: standing }
    }

    /// Whether every joint that it names has a claim, and it has one at all.
    pub(crate) fn is_told(&self, claims: &[Claim]) -> bool {
        let about = |name: &String| {
            let part = Subject::of(self.subject.topic, [name]);
            claims.iter().any(|claim| claim.subject().touches(&part))
        };
        claims.iter().any(|claim| claim.subject().touches(&self.subject)) && self.subject.of.iter().all(about)
    }

    /// The lowest standing among the claims about it, and open where it is not told.
    pub(crate) fn standing(&self, claims: &[Claim]) -> Standing {
        let about = claims.iter().filter(|claim| claim.subject().touches(&self.subject));
        let untold = (!self.is_told(claims)).then_some(Standing::Open);
        let lowest = about.map(|claim| Standing::of(claim.outcome())).chain(untold).min();
        lowest.filter(|standing| *standing >= self.at_least).unwrap_or(Standing::Refused)
    }
}

/// What is wanted, by name, and what it needs: at least one subject, since what needs nothing would always be proven.
#[derive(Clone, Debug, PartialEq)]
pub struct Purpose {
    /// As printed: `gravity compensation`.
    pub name: &'static str,
    pub(crate) needs: Vec<Need>,
}

impl Purpose {
    /// A purpose with the first of its needs.
    pub fn new(name: &'static str, need: Need) -> Purpose {
        Purpose { name, needs: vec![need] }
    }

    /// The same with one need more.
    pub fn and(mut self, need: Need) -> Purpose {
        self.needs.push(need);
        self
    }
}
