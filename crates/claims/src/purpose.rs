//! Purposes of a user, and the subjects that each purpose needs.

use crate::claim::Claim;
use crate::standing::EvidenceLevel;
use crate::subject::Subject;

/// A subject that a purpose needs, and the level of evidence that it needs.
#[derive(Clone, Debug, PartialEq)]
pub struct Need {
    subject: Subject,
    kind: NeedKind,
}

/// When a need lowers the level of evidence of its purpose.
#[derive(Clone, Copy, Debug, PartialEq)]
enum NeedKind {
    /// Where the claims about it are below this level, the purpose is refused; without claims, it is open.
    AtLeast(EvidenceLevel),
    /// Where any claim about it has a low level.
    WhereTold,
    /// Where it is contradicted.
    Uncontradicted,
}

impl Need {
    /// A subject that needs a claim. Where each joint needs a claim, the subject names the joints.
    pub fn new(subject: Subject) -> Need {
        Need { subject, kind: NeedKind::AtLeast(EvidenceLevel::Open) }
    }

    /// A subject that needs this level of evidence, since the user asked for it: below it, the purpose is refused.
    pub fn at_least(subject: Subject, standing: EvidenceLevel) -> Need {
        Need { subject, kind: NeedKind::AtLeast(standing) }
    }

    /// A subject whose claims all count, and which lowers nothing where it has no claims.
    pub fn where_claimed(subject: Subject) -> Need {
        Need { subject, kind: NeedKind::WhereTold }
    }

    /// A subject that must not be contradicted, and which lowers nothing where it is undecided.
    pub fn uncontradicted(subject: Subject) -> Need {
        Need { subject, kind: NeedKind::Uncontradicted }
    }

    /// Whether it has a claim, and every joint that it names has one.
    pub(crate) fn has_claims(&self, claims: &[Claim]) -> bool {
        let about = |name: &String| {
            let part = Subject::of(self.subject.topic, [name]);
            claims.iter().any(|claim| claim.subject().touches(&part))
        };
        claims.iter().any(|claim| claim.subject().touches(&self.subject)) && self.subject.of.iter().all(about)
    }

    /// Whether a claim prevents the answer yes.
    pub(crate) fn is_lowered_by(&self, claim: &Claim) -> bool {
        let standing = claim.standing();
        let is_low = match self.kind {
            NeedKind::AtLeast(least) => standing < least.max(EvidenceLevel::Agreed),
            NeedKind::WhereTold => standing < EvidenceLevel::Agreed,
            NeedKind::Uncontradicted => standing == EvidenceLevel::Refused,
        };
        is_low && claim.subject().touches(&self.subject)
    }

    /// The lowest level of evidence among the claims about the subject.
    pub(crate) fn standing(&self, claims: &[Claim]) -> EvidenceLevel {
        let about = claims.iter().filter(|claim| claim.subject().touches(&self.subject));
        let lowest = about.map(|claim| claim.standing()).min();
        match self.kind {
            NeedKind::AtLeast(least) => {
                let unclaimed = (!self.has_claims(claims)).then_some(EvidenceLevel::Open);
                let lowest = lowest.into_iter().chain(unclaimed).min();
                lowest.filter(|standing| *standing >= least).unwrap_or(EvidenceLevel::Refused)
            }
            NeedKind::WhereTold => lowest.unwrap_or(EvidenceLevel::Proven),
            NeedKind::Uncontradicted if lowest == Some(EvidenceLevel::Refused) => EvidenceLevel::Refused,
            NeedKind::Uncontradicted => EvidenceLevel::Proven,
        }
    }
}

/// A purpose and its needs: at least one, since a purpose without needs would always be proven.
#[derive(Clone, Debug, PartialEq)]
pub struct Purpose {
    /// The printed name: `gravity compensation`.
    pub name: &'static str,
    pub(crate) needs: Vec<Need>,
}

impl Purpose {
    /// A purpose with the first of its needs.
    pub fn new(name: &'static str, need: Need) -> Purpose {
        Purpose { name, needs: vec![need] }
    }

    /// Adds a need.
    pub fn and(mut self, need: Need) -> Purpose {
        self.needs.push(need);
        self
    }
}
