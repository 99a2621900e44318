//! Converts the certificate of a motion to claims, that is, statements with their evidence (`claims`): one for each certificate
//! row (limit with the result of its proof) and one for each omitted check.
//!
//! | claim | from |
//! |---|---|
//! | proven | a row that is proven |
//! | contradicted | a row that is violated |
//! | cannot tell | a row that is neither |
//! | assumed, not looked at | [`LeftOut`] |
//!
//! A motion is refused if a claim is contradicted or cannot be determined, or if a check that the user requested was not made.
//! The last line of `excite` and `check` lists the claims of all four kinds.

use std::fmt;

use claims::{
    Bound, Claim, EvidenceLevel, Figure, Need, Outcome, Purpose, Remedy, Subject, Topic, Trial, significant, worst,
};
use serde::{Deserialize, Serialize};

use crate::excitation::limits::LimitKind;
use crate::excitation::proof::{CertificateRow, LimitProof};
use claims::{LeftOut, LeftOutReason, LeftOutTopic};

const FLOOR: Topic = Topic("floor");
const LIMIT: Topic = Topic("limit");
const APPROACH: Topic = Topic("approach and return");
const MARGIN: Topic = Topic("margins");

/// The lowest point of the moving links, over all sampled instants of a motion.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LowestPoint {
    /// Height of the point: z in the base frame, m.
    pub z_m: f64,
    /// Name of the link that has the lowest point.
    pub link: String,
    /// Time after the start of the motion at which this point is reached, s.
    pub time_s: f64,
}

/// The certificate of a motion with the omitted checks.
#[derive(Clone, Copy)]
pub struct MotionClaims<'a> {
    /// The limits of the motion, each with the result of its proof.
    pub rows: &'a [CertificateRow],
    /// The checks of the motion that were not made.
    pub left_out: &'a [LeftOut],
    /// Height of the floor in the base frame, m. `None`: no floor.
    pub floor: Option<f64>,
    /// The lowest point of the moving links at the sampled instants. `None`: not computed.
    pub lowest: Option<&'a LowestPoint>,
}

/// Reason why the remedy of a violated limit, another motion, has not been tried; part of the claim's text.
const NOT_TRIED: &str = "a smaller motion is another motion";

impl MotionClaims<'_> {
    /// The claims of the motion: one per certificate row, then one per omitted check.
    pub fn claims(&self) -> Vec<Claim> {
        self.rows.iter().map(claim_of_row).chain(self.left_out.iter().map(claim_of_left_out)).collect()
    }

    /// The level of evidence for the whole motion: the lowest level of its claims. The omitted check of the path to the first
    /// pose does not count.
    pub fn standing(&self) -> EvidenceLevel {
        let rows = self.rows.iter().map(|row| Need::at_least(subject_of_row(row), EvidenceLevel::Assumed));
        let left_out = self.left_out.iter().filter(|out| out.matter != LeftOutTopic::Approach).map(|out| {
            let subject = subject_of_left_out(out);
            if out.is_asked { Need::at_least(subject, EvidenceLevel::Assumed) } else { Need::where_claimed(subject) }
        });
        let mut needs = rows.chain(left_out);
        let Some(first) = needs.next() else { return EvidenceLevel::Open };
        let purpose = needs.fold(Purpose::new("playing the motion", first), Purpose::and);
        worst(&self.claims(), &purpose)
    }

    /// Whether every certificate row is proven and all requested checks were made.
    pub fn is_kept(&self) -> bool {
        self.standing().exit_code() == 0
    }

    /// Sentences for the user: one per limit that is not proven, and one per requested check that was not made.
    pub fn faults(&self) -> Vec<String> {
        let rows = self.rows.iter().filter(|row| row.kept != LimitProof::Proven).map(ToString::to_string);
        let owed = self.left_out.iter().filter(|out| out.is_owed()).map(|out| claim_of_left_out(out).to_string());
        rows.chain(owed).collect()
    }

    /// Sentences for the user on assumptions and omitted checks, one for each.
    pub fn left_out_sentences(&self) -> Vec<String> {
        self.left_out.iter().map(|out| claim_of_left_out(out).to_string()).collect()
    }

    /// Assumptions and omitted checks as text, one line for each.
    pub fn left_out_text(&self) -> String {
        self.left_out_sentences().iter().map(|line| format!("{line}\n")).collect()
    }
}

/// The subject of a certificate row about the floor ends with these words.
const AT_THE_FLOOR: &str = " at the floor";

/// Whether the subject of a certificate row of kind `Region` is a link at the floor.
fn is_of_floor(subject: &str) -> bool {
    subject.ends_with(AT_THE_FLOOR)
}

/// The subject of a claim, without the words ` at the floor` if the topic already is the floor.
fn at(topic: Topic, subject: &str) -> &str {
    if topic == FLOOR { subject.strip_suffix(AT_THE_FLOOR).unwrap_or(subject) } else { subject }
}

fn topic_of(limit: LimitKind, subject: &str) -> Topic {
    match limit {
        LimitKind::Region if is_of_floor(subject) => FLOOR,
        limit => Topic(limit.word()),
    }
}

fn subject_of_row(row: &CertificateRow) -> Subject {
    let topic = topic_of(row.limit, &row.subject);
    Subject::of(topic, [at(topic, &row.subject)])
}

fn claim_of_row(row: &CertificateRow) -> Claim {
    let is_distance = matches!(row.limit, LimitKind::Distance | LimitKind::Region);
    let bound = Figure::new(row.nowhere_beyond, row.limit.unit_of(None));
    let outcome = match row.kept {
        LimitProof::Proven => Outcome::Proven {
            bound: if is_distance || row.bound < 0.0 { Bound::AtLeast(bound) } else { Bound::AtMost(bound) },
            derivation: row.how.clone(),
        },
        LimitProof::Violated => Outcome::Contradicted {
            fault: row.to_string(),
            remedy: Remedy::new("excite", "search a motion within these limits"),
            trial: Trial::NotTried { why: NOT_TRIED.into() },
        },
        LimitProof::Open => {
            Outcome::CannotTell { why: row.to_string(), would_tell: "a motion farther from this limit".into() }
        }
    };
    Claim::new(subject_of_row(row), outcome)
}

fn subject_of_left_out(out: &LeftOut) -> Subject {
    let topic = match out.matter {
        LeftOutTopic::Limit => LIMIT,
        LeftOutTopic::Effort => Topic(LimitKind::Effort.word()),
        LeftOutTopic::Power => Topic(LimitKind::Power.word()),
        LeftOutTopic::Distance => Topic(LimitKind::Distance.word()),
        LeftOutTopic::Floor => FLOOR,
        LeftOutTopic::Region => Topic(LimitKind::Region.word()),
        LeftOutTopic::Approach => APPROACH,
        LeftOutTopic::Margin => MARGIN,
    };
    Subject::of(topic, out.of.iter().map(|of| at(topic, of)))
}

fn claim_of_left_out(out: &LeftOut) -> Claim {
    let outcome = match out.why.clone() {
        LeftOutReason::Assumed { what, by } => Outcome::Assumed { what, by },
        LeftOutReason::NotLookedAt { why, would_tell } => Outcome::NotLookedAt { why, would_tell },
    };
    Claim::new(subject_of_left_out(out), outcome)
}

/// Greatest number of names that the last line of a report lists; of more names it gives only the number.
const MAX_LISTED_NAMES: usize = 2;

/// Lists the subjects of claims topic by topic, or counts them if there are many: `distance of 3`, `approach and return`.
fn counted<'a>(subjects: impl Iterator<Item = &'a Subject>) -> String {
    let mut topics: Vec<(&str, Vec<&str>)> = Vec::new();
    for subject in subjects {
        let topic = subject.topic.0;
        let place = topics.iter().position(|(known, _)| *known == topic).unwrap_or_else(|| {
            topics.push((topic, vec![]));
            topics.len() - 1
        });
        topics[place].1.extend(subject.of.iter().map(String::as_str));
    }
    let text = |(topic, of): &(&str, Vec<&str>)| match of.len() {
        0 => topic.to_string(),
        1..=MAX_LISTED_NAMES => format!("{topic} of {}", of.join(" and of ")),
        more => format!("{topic} of {more}"),
    };
    topics.iter().map(text).collect::<Vec<_>>().join(", ")
}

/// The last line of a report: the violated, unproven, proven, assumed and omitted claims of a motion, in this order.
impl fmt::Display for MotionClaims<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let claims = self.claims();
        let of = |is: &dyn Fn(&Outcome) -> bool| {
            let subjects: Vec<&Subject> = claims.iter().filter(|c| is(c.outcome())).map(Claim::subject).collect();
            (!subjects.is_empty()).then(|| counted(subjects.into_iter()))
        };
        let floor = match (self.floor, self.lowest) {
            (Some(floor), Some(low)) => {
                Some(format!("floor at z = {floor} m, lowest point {} m ({})", significant(low.z_m, 3), low.link))
            }
            (None, Some(low)) => Some(format!("no floor, lowest point {} m ({})", significant(low.z_m, 3), low.link)),
            (Some(floor), None) => Some(format!("floor at z = {floor} m")),
            (None, None) => None,
        };
        let parts = [
            of(&|o| matches!(o, Outcome::Contradicted { .. })).map(|what| format!("BROKEN: {what}")),
            of(&|o| matches!(o, Outcome::CannotTell { .. })).map(|what| format!("NOT PROVEN: {what}")),
            of(&|o| matches!(o, Outcome::Proven { .. })).map(|what| format!("proven, between samples too: {what}")),
            floor,
            of(&|o| matches!(o, Outcome::Assumed { .. })).map(|what| format!("assumed: {what}")),
            of(&|o| matches!(o, Outcome::NotLookedAt { .. })).map(|what| format!("NOT looked at: {what}")),
        ];
        f.write_str(&parts.into_iter().flatten().collect::<Vec<_>>().join("; "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(limit: LimitKind, subject: &str, kept: LimitProof) -> CertificateRow {
        CertificateRow {
            limit,
            subject: subject.into(),
            time_s: 1.0,
            value: 0.5,
            bound: 1.0,
            margin: 0.0,
            nowhere_beyond: 0.6,
            kept,
            how: "Taylor enclosures".into(),
        }
    }

    fn claims_of_motion<'a>(rows: &'a [CertificateRow], left_out: &'a [LeftOut]) -> MotionClaims<'a> {
        MotionClaims { rows, left_out, floor: None, lowest: None }
    }

    #[test]
    fn the_last_line_says_each_kind_where_it_is() {
        let row = |kept| row(LimitKind::Velocity, "q1", kept);
        let pair = || vec!["hand and post".to_string()];
        let assumed = LeftOut::assumed(LeftOutTopic::Distance, pair(), "a cover is soft", "the user");
        let unseen = LeftOut::not_looked_at(LeftOutTopic::Distance, pair(), "a mesh is missing", "a mesh");
        let owed = LeftOut { is_asked: true, ..unseen.clone() };
        let whole = [
            ("BROKEN", vec![row(LimitProof::Violated)], vec![], EvidenceLevel::Refused),
            ("NOT PROVEN", vec![row(LimitProof::Open)], vec![], EvidenceLevel::Refused),
            ("proven, between samples too", vec![row(LimitProof::Proven)], vec![], EvidenceLevel::Proven),
            ("assumed", vec![], vec![assumed], EvidenceLevel::Assumed),
            ("NOT looked at", vec![], vec![unseen], EvidenceLevel::Open),
            ("NOT looked at", vec![], vec![owed.clone()], EvidenceLevel::Refused),
        ];
        let words = ["BROKEN", "NOT PROVEN", "proven, between samples too", "assumed", "NOT looked at"];
        for (word, rows, left_out, standing) in &whole {
            let claims = claims_of_motion(rows, left_out);
            let text = claims.to_string();
            for other in words {
                assert_eq!(text.contains(&format!("{other}: ")), other == *word, "{other}: {text}");
            }
            assert_eq!(
                (claims.standing(), claims.is_kept()),
                (*standing, *standing != EvidenceLevel::Refused),
                "{text}"
            );
            assert_eq!(claims.faults().is_empty(), claims.is_kept(), "{text}");
        }
        // The omitted check of the approach to the first pose is reported, but does not change the level of evidence.
        let (rows, left_out) = ([row(LimitProof::Proven)], [LeftOut::approach()]);
        let alone = claims_of_motion(&rows, &left_out);
        assert_eq!(alone.standing(), EvidenceLevel::Proven);
        assert!(alone.to_string().ends_with("; NOT looked at: approach and return"), "{alone}");
        assert_eq!(claims_of_motion(&rows, &[owed]).standing(), EvidenceLevel::Refused);
        assert_eq!(claims_of_motion(&[], &[]).standing(), EvidenceLevel::Open);
    }

    #[test]
    fn names_are_told_where_they_are_few() {
        let pairs = |k: usize| (0..k).map(|i| row(LimitKind::Distance, &format!("l{i} and base"), LimitProof::Proven));
        let two: Vec<CertificateRow> =
            pairs(2).chain([row(LimitKind::Region, "l1 at the floor", LimitProof::Proven)]).collect();
        let text = claims_of_motion(&two, &[]).to_string();
        let expected = "proven, between samples too: distance of l0 and base and of l1 and base, floor of l1";
        assert_eq!(text, expected);
        let three: Vec<CertificateRow> = pairs(3).collect();
        assert_eq!(claims_of_motion(&three, &[]).to_string(), "proven, between samples too: distance of 3");
    }

    #[test]
    fn the_floor_is_told_with_the_lowest_point() {
        let rows = [row(LimitKind::Region, "hand at the floor", LimitProof::Proven)];
        let lowest = LowestPoint { z_m: 0.03456, link: "hand".into(), time_s: 2.0 };
        let with = MotionClaims { floor: Some(0.0), lowest: Some(&lowest), ..claims_of_motion(&rows, &[]) };
        assert!(with.to_string().contains("; floor at z = 0 m, lowest point 0.0346 m (hand)"), "{with}");
        let below = LowestPoint { z_m: -0.3, ..lowest.clone() };
        let without = MotionClaims { lowest: Some(&below), ..claims_of_motion(&rows, &[]) };
        assert!(without.to_string().contains("; no floor, lowest point -0.3 m (hand)"), "{without}");
        assert!(!claims_of_motion(&rows, &[]).to_string().contains("lowest"));
    }
}
