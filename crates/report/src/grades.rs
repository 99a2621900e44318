//! Tables that show the trust in an estimate, by purpose and by joint, with the claims behind each grade.
//!
//! A claim is one statement on the log or the estimate with its evidence (agrees, contradicted, not determined). The grade of a
//! cell is the level of trust or the level of evidence, shown as a colour.

use claims::{Claim, EvidenceLevel, Outcome, Topic};
use identification::estimate::artefact::Estimate;
use identification::estimate::verdict::{Trust, Verdict, claim_line};
use serde::Serialize;

use crate::number::percent;

/// Two tables: the trust by purpose, and the claims by joint.
#[derive(Serialize)]
pub(crate) struct Grades {
    purposes: Vec<PurposeRow>,
    /// Topics of the claims on joints, which are the column heads of the table by joint.
    topics: Vec<&'static str>,
    joints: Vec<JointRow>,
}

#[derive(Serialize)]
struct PurposeRow {
    name: String,
    word: &'static str,
    class: &'static str,
    unsure: String,
    because: Vec<String>,
}

#[derive(Serialize)]
struct JointRow {
    name: String,
    held_out: String,
    cells: Vec<Cell>,
}

/// A table cell: the claim on one topic of one joint.
#[derive(Serialize)]
struct Cell {
    class: &'static str,
    word: String,
    /// The claim as a sentence.
    claim: String,
}

/// The CSS class that colours an answer on trust.
pub(crate) fn class(trust: Trust) -> &'static str {
    match trust {
        Trust::Yes => "yes",
        Trust::WithCare => "care",
        Trust::No => "no",
    }
}

/// The tables for a verdict; `None` if the verdict has no claims on joints.
pub(crate) fn grades(verdict: &Verdict, estimate: Option<&Estimate>) -> Option<Grades> {
    let purpose = |of: &identification::estimate::verdict::UseVerdict| PurposeRow {
        name: of.name.clone(),
        word: of.trust.word(),
        class: class(of.trust),
        unsure: match (&of.error, &of.worst_joint) {
            (Some(error), Some((joint, worst))) => format!("{}, {joint} {}", percent(*error), percent(*worst)),
            (Some(error), None) => percent(*error),
            (None, _) => "-".into(),
        },
        because: verdict.because(&of.name),
    };
    let joints = estimate.map(|e| e.joints.as_slice()).unwrap_or_default();
    let is_of_joints = |claim: &&Claim| joints.iter().any(|joint| claim.subject().of.contains(&joint.coordinate));
    // Topics of the claims on joints, in the order of the claims, each once.
    let mut topics: Vec<Topic> = Vec::new();
    for claim in verdict.claims.iter().filter(is_of_joints) {
        let topic = claim.subject().topic;
        if !topics.contains(&topic) {
            topics.push(topic);
        }
    }
    if topics.is_empty() || joints.is_empty() {
        return None;
    }
    // One row per joint: its error on held-out data, and one cell per topic.
    let row = |joint: &identification::estimate::residuals::JointResidual| JointRow {
        name: joint.coordinate.clone(),
        held_out: joint.held_out.map_or("-".into(), percent),
        cells: topics.iter().map(|topic| cell(&verdict.claims, *topic, &joint.coordinate)).collect(),
    };
    Some(Grades {
        purposes: verdict.uses.iter().map(purpose).collect(),
        topics: topics.iter().map(|topic| topic.0).collect(),
        joints: joints.iter().map(row).collect(),
    })
}

/// The cell for one topic of one joint. If there are several claims, the cell shows the claim with the lowest level of
/// evidence.
fn cell(claims: &[Claim], topic: Topic, joint: &String) -> Cell {
    let about = |claim: &&Claim| claim.subject().topic == topic && claim.subject().of.contains(joint);
    let Some(claim) = claims.iter().filter(about).min_by_key(|claim| claim.standing()) else {
        return Cell { class: "", word: "-".into(), claim: "nothing is claimed".into() };
    };
    let (class, word) = match (claim.standing(), claim.outcome()) {
        (_, Outcome::Agrees { smallest }) => ("yes", format!("{smallest} would show")),
        (EvidenceLevel::Refused, _) => ("no", "contradicted".into()),
        (EvidenceLevel::Proven, _) => ("yes", "proven".into()),
        (EvidenceLevel::Assumed, _) => ("care", "assumed".into()),
        _ => ("open", "cannot tell".into()),
    };
    Cell { class, word, claim: claim_line(claim) }
}
