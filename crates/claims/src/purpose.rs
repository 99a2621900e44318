//! Purposes of a user, such as gravity compensation. A purpose has a level of evidence, which follows from the claims
//! (statements with their evidence) about certain subjects. Each subject that a purpose needs is a [`Need`].

use crate::claim::Claim;
use crate::standing::EvidenceLevel;
use crate::subject::Subject;

/// A need of a purpose: the subject about which the purpose needs claims, and how these claims lower the level of evidence of
/// the purpose.
#[derive(Clone, Debug, PartialEq)]
pub struct Need {
    subject: Subject,
    kind: NeedKind,
}

/// How claims about a needed subject lower the level of evidence of a purpose. Levels from low to high: refused, open, assumed,
/// agreed, proven.
#[derive(Clone, Copy, Debug, PartialEq)]
enum NeedKind {
    /// The purpose is refused if a claim about the subject has a level below the level stored here. A subject without claims
    /// counts as open.
    AtLeast(EvidenceLevel),
    /// Of all claims about the subject, the claim with the lowest level counts. Without claims, the level of the purpose is not
    /// lowered.
    WhereTold,
    /// Only a contradicted claim about the subject counts: the purpose is then refused.
    Uncontradicted,
}

impl Need {
    /// The purpose needs a claim about `subject`. If each joint needs its own claim, the subject names the joints.
    pub fn new(subject: Subject) -> Need {
        Need { subject, kind: NeedKind::AtLeast(EvidenceLevel::Open) }
    }

    /// The purpose needs claims about `subject` of at least the level `standing`, because the user requires this level. If a
    /// claim has a lower level, the purpose is refused.
    pub fn at_least(subject: Subject, standing: EvidenceLevel) -> Need {
        Need { subject, kind: NeedKind::AtLeast(standing) }
    }

    /// All claims about `subject` count. Without claims about `subject`, the level of the purpose is not lowered.
    pub fn where_claimed(subject: Subject) -> Need {
        Need { subject, kind: NeedKind::WhereTold }
    }

    /// Only a contradicted claim about `subject` counts. An undecided claim about `subject` does not lower the level of the
    /// purpose.
    pub fn uncontradicted(subject: Subject) -> Need {
        Need { subject, kind: NeedKind::Uncontradicted }
    }

    /// Whether `claims` contains a claim about the subject and, if the subject names joints, a claim about each named joint.
    pub(crate) fn has_claims(&self, claims: &[Claim]) -> bool {
        let about = |name: &String| {
            let part = Subject::of(self.subject.topic, [name]);
            claims.iter().any(|claim| claim.subject().touches(&part))
        };
        claims.iter().any(|claim| claim.subject().touches(&self.subject)) && self.subject.of.iter().all(about)
    }

    /// Whether `claim` is about the subject of this need, and its level is so low that the purpose cannot have
    /// [`Trust::Yes`](crate::Trust::Yes).
    pub(crate) fn is_lowered_by(&self, claim: &Claim) -> bool {
        let standing = claim.standing();
        let is_low = match self.kind {
            NeedKind::AtLeast(least) => standing < least.max(EvidenceLevel::Agreed),
            NeedKind::WhereTold => standing < EvidenceLevel::Agreed,
            NeedKind::Uncontradicted => standing == EvidenceLevel::Refused,
        };
        is_low && claim.subject().touches(&self.subject)
    }

    /// The level of evidence of this need: the lowest level of the claims about the subject, according to the rule `kind`.
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

/// A purpose of the user with its needs. A purpose has at least one need, because a purpose without needs would always be
/// proven.
#[derive(Clone, Debug, PartialEq)]
pub struct Purpose {
    /// The printed name: `gravity compensation`.
    pub name: &'static str,
    pub(crate) needs: Vec<Need>,
}

impl Purpose {
    /// Makes a purpose with its first need.
    pub fn new(name: &'static str, need: Need) -> Purpose {
        Purpose { name, needs: vec![need] }
    }

    /// Adds a need to the purpose.
    pub fn and(mut self, need: Need) -> Purpose {
        self.needs.push(need);
        self
    }
}
