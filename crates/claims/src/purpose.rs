//! What somebody wants to do, and what must be told for it.

use crate::claim::Claim;
use crate::standing::Standing;
use crate::subject::Subject;

/// A subject that a purpose needs, and how high it must stand.
#[derive(Clone, Debug, PartialEq)]
pub struct Need {
    subject: Subject,
    kind: Kind,
}

/// When a need lowers the standing of its purpose.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    /// Where it is not told as high as this, the purpose is refused; untold, it is open.
    AtLeast(Standing),
    /// Where anything told about it stands low.
    WhereTold,
    /// Where it is contradicted.
    Uncontradicted,
}

impl Need {
    /// A subject that must be told. Where each joint must be told, it names the joints.
    pub fn new(subject: Subject) -> Need {
        Need { subject, kind: Kind::AtLeast(Standing::Open) }
    }

    /// A subject that must stand as high as this, since the user asked for it: where it is lower, the purpose is refused.
    pub fn at_least(subject: Subject, standing: Standing) -> Need {
        Need { subject, kind: Kind::AtLeast(standing) }
    }

    /// A subject of which everything counts that is said, and that lowers nothing where nobody says anything.
    pub fn where_told(subject: Subject) -> Need {
        Need { subject, kind: Kind::WhereTold }
    }

    /// A subject that must not be contradicted, and that lowers nothing where it cannot be told.
    pub fn uncontradicted(subject: Subject) -> Need {
        Need { subject, kind: Kind::Uncontradicted }
    }

    /// Whether every joint that it names has a claim, and it has one at all.
    pub(crate) fn is_told(&self, claims: &[Claim]) -> bool {
        let about = |name: &String| {
            let part = Subject::of(self.subject.topic, [name]);
            claims.iter().any(|claim| claim.subject().touches(&part))
        };
        claims.iter().any(|claim| claim.subject().touches(&self.subject)) && self.subject.of.iter().all(about)
    }

    /// Whether a claim keeps it from a yes.
    pub(crate) fn is_lowered_by(&self, claim: &Claim) -> bool {
        let standing = claim.standing();
        let is_low = match self.kind {
            Kind::AtLeast(least) => standing < least.max(Standing::Agreed),
            Kind::WhereTold => standing < Standing::Agreed,
            Kind::Uncontradicted => standing == Standing::Refused,
        };
        is_low && claim.subject().touches(&self.subject)
    }

    /// The lowest standing among the claims about it.
    pub(crate) fn standing(&self, claims: &[Claim]) -> Standing {
        let about = claims.iter().filter(|claim| claim.subject().touches(&self.subject));
        let lowest = about.map(|claim| claim.standing()).min();
        match self.kind {
            Kind::AtLeast(least) => {
                let untold = (!self.is_told(claims)).then_some(Standing::Open);
                let lowest = lowest.into_iter().chain(untold).min();
                lowest.filter(|standing| *standing >= least).unwrap_or(Standing::Refused)
            }
            Kind::WhereTold => lowest.unwrap_or(Standing::Proven),
            Kind::Uncontradicted if lowest == Some(Standing::Refused) => Standing::Refused,
            Kind::Uncontradicted => Standing::Proven,
        }
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
