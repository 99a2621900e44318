//! Makes the verdict on an identification or a validation: the trust for each use, the reasons, and the next step.
//!
//! All evidence is collected as claims, that is, statements with their evidence ([`crate::estimate::claims`]). Bodies: the
//! inertial parameters of the links, one of the results that can be used. The trust for a use follows from the worst of the
//! claims that the use needs (`claims::worst`). The overall trust is the lowest trust for all uses of torques.

use std::fmt;

use claims::{Claim, EvidenceLevel, Outcome, Purpose, Remedy, Subject, Topic, Trial, lowering, worst};

use crate::estimate::artefact::Estimate;
pub use crate::estimate::claims::Prediction;
use crate::estimate::claims::hypotheses::HypothesisTest;
use crate::estimate::claims::purposes::{bodies_purpose, claim_of_torque, torque_purpose};
use crate::estimate::claims::purposes::{standing, undetermined_torques, where_it_stands};
use crate::estimate::claims::{
    TorqueContext, claims_of_faults, claims_of_fit, claims_of_log, not_noise, units_of_logs,
};
use crate::estimate::digits::percent;
use crate::estimate::identified::{INTERVAL, Identified, Status};
use crate::estimate::log_check::LogCheck;
use crate::estimate::topics::{
    BODIES, BODIES_TAKEN, COMMON_SCALE, DEAD_CURRENT_TAKEN, DELAY_TAKEN, GRAVITY_TORQUE, LOG, MOUNT_TAKEN,
    OTHER_MOTION, ROTORS_TAKEN, TORQUE_AT_LIMITS, TORQUE_SEEN, at, contradicted,
};
use crate::estimate::torque_error::{TorqueError, Use};

pub use claims::Trust;

/// The verdict on an estimate or a validation. The verdict is printed at the end of a report.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// The lowest trust for all uses of torques (gravity compensation, feedforward).
    pub trust: Trust,
    /// A sentence on the number of significant parameters, and on the residual with identified and with nominal parameters.
    pub found: String,
    /// The reasons for the trust, the most important first.
    pub reasons: Vec<String>,
    /// The next step for the user, in words.
    pub next: String,
    /// The trust for each use of torques; then for bodies, if bodies were requested.
    pub uses: Vec<UseVerdict>,
    /// All claims, the weakest level of evidence first.
    pub claims: Vec<Claim>,
}

/// The trust in an estimate for one use.
#[derive(Clone, Debug, PartialEq)]
pub struct UseVerdict {
    /// Name of the use, e.g. `gravity compensation`.
    pub name: String,
    /// The trust: yes, with care, or no.
    pub trust: Trust,
    /// Relative error of the torques in this use, from the covariance of the parameters; `None` if unknown or infinite.
    pub error: Option<f64>,
    /// The joint with the largest relative error of its torque, and this error; `None` if unknown.
    pub worst_joint: Option<(String, f64)>,
}

/// Comparison of physically consistent bodies with the robot description.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BodiesEvidence {
    /// Reason not to use the bodies; `None` if the solver converged and the bodies fit the data.
    pub refusal: Option<String>,
    /// For each body with a nominal mass: (name, identified / nominal mass, nominal mass in kg).
    pub masses: Vec<(String, f64, f64)>,
    /// A sentence that the description predicts the torques at rest better than the bodies do; `None` if this is not the case.
    pub at_rest: Option<String>,
    /// Names of joints whose whole force at rest is counted as the weight of the bodies, because an offset of the drive is not
    /// separable from this weight.
    pub weighed: Vec<String>,
}

/// The evidence from which a verdict follows.
#[derive(Clone, Copy, Debug)]
pub struct Evidence<'a> {
    /// The estimate: parameters with their statuses, residuals, condition number.
    pub estimate: &'a Estimate,
    /// The check of the fitted (or of the validated) logs before the fit; `None` if no check was made.
    pub log_check: Option<&'a LogCheck>,
    /// Relative error |tau - W X| / |tau| of the nominal parameters with fitted friction, on the logs of `total`; `None` if
    /// the description has no inertials.
    pub described: Option<f64>,
    /// The nominal base parameters; `None` if the description has no inertials.
    pub nominal_parameters: Option<&'a [f64]>,
    /// Relative error |tau - W X| / |tau| of the identified parameters, on the fitted or on the validated logs.
    pub total: Option<f64>,
    /// Whether `total` belongs to the fitted logs (true) or to other, validated logs (false).
    pub is_of_fit: bool,
    /// Errors of prediction on motion that was not fitted.
    pub prediction: Prediction,
    /// Evidence on physically consistent bodies; `None` if not requested.
    pub bodies: Option<&'a BodiesEvidence>,
    /// Whether no motion at all could identify the parameters that the logs do not determine.
    pub opens_in_any_motion: bool,
    /// Claims on corrections that were made by default.
    pub mended: &'a [Claim],
    /// Results of the tested hypotheses (faults, rotors), each fitted as one additional unknown.
    pub faults: &'a [HypothesisTest],
}

/// All masses are wrong by a common factor if the median ratio (identified / nominal mass) is above this value or below the
/// inverse of this value, and if all ratios are near the median.
const LARGE_MASS_FACTOR: f64 = 2.5;
/// A mass ratio is near the median if the two differ by less than this factor.
const COMMON_FACTOR_TOLERANCE: f64 = 1.6;
/// Least number of masses to detect a common factor.
const LEAST_MASSES: usize = 3;

/// Plausible range of the ratio (identified / nominal mass) of a body. If the ratio of one body is outside, all bodies are
/// refused.
const PLAUSIBLE_MASS_RATIOS: std::ops::RangeInclusive<f64> = 0.5..=2.0;

/// If the mass of a body changes by at most this share of the mass of the robot, the change is ignored.
const SMALL_MASS_SHARE: f64 = 0.02;

impl Verdict {
    /// Derives the verdict from the evidence.
    pub fn of(evidence: &Evidence) -> Verdict {
        let claims = claims(evidence);
        let torque = Use::ALL.into_iter().map(|of| (torque_purpose(of), Some(of)));
        let purposes: Vec<(Purpose, Option<Use>)> =
            torque.chain(evidence.bodies.map(|_| (bodies_purpose(), None))).collect();
        let one = |(purpose, of): &(Purpose, Option<Use>)| {
            let error = evidence.estimate.torque_errors.iter().find(|e| Some(e.of) == *of);
            UseVerdict {
                name: purpose.name.into(),
                trust: worst(&claims, purpose).trust(),
                error: error.map(|e| e.relative).filter(|error| error.is_finite()),
                worst_joint: error.and_then(|e| e.worst()).map(|(name, share)| (name.into(), share)),
            }
        };
        let mut uses: Vec<UseVerdict> = purposes.iter().map(one).collect();
        let trust = uses.iter().take(Use::ALL.len()).map(|u| u.trust).min().unwrap_or(Trust::WithCare);
        // A simulator may make any motion, so the trust for bodies is not above the trust for torques.
        uses.iter_mut().skip(Use::ALL.len()).for_each(|bodies| bodies.trust = bodies.trust.min(trust));
        let lowered: Vec<&Claim> = claims
            .iter()
            .filter(|claim| purposes[..Use::ALL.len()].iter().any(|(p, _)| lowering(&claims, p).contains(claim)))
            .filter(|claim| trust != Trust::No || claim.standing() == EvidenceLevel::Refused)
            .collect();
        let next =
            lowered.first().map_or_else(|| use_it(evidence, uses.get(Use::ALL.len())), |claim| what_mends(claim));
        let reasons: Vec<String> = match trust {
            Trust::Yes => favours(evidence).into_iter().chain(units_of_logs(&claims)).collect(),
            _ => lowered.iter().map(|claim| sentence(claim)).collect(),
        };
        // The residual of the fit says nothing about other logs. So this residual is not a reason in the verdict on a
        // validation of other logs.
        let of_fit = not_noise(evidence.estimate).filter(|_| evidence.is_of_fit);
        let beside = inseparable_parameters(evidence.estimate).into_iter().chain(of_fit);
        let reasons = reasons.into_iter().chain(beside.filter(|_| trust != Trust::No)).collect();
        Verdict { trust, found: found(evidence), next, reasons, uses, claims }
    }
}

impl Verdict {
    /// The reasons that lower the trust for the use called `name`; empty if no reason lowers the trust.
    pub fn because(&self, name: &str) -> Vec<String> {
        let purposes = Use::ALL.map(torque_purpose).into_iter().chain([bodies_purpose()]);
        let mut of_it = purposes.filter(|purpose| purpose.name == name);
        of_it.next().map_or_else(Vec::new, |purpose| {
            let mut reasons: Vec<String> = lowering(&self.claims, &purpose).into_iter().map(sentence).collect();
            reasons.dedup();
            reasons
        })
    }

    /// The trust in the identified bodies, and the reasons to refuse the bodies. If no bodies were requested, the trust is the
    /// overall trust.
    pub fn of_bodies(&self) -> (Trust, Vec<String>) {
        let trust = self.uses.get(Use::ALL.len()).map_or(self.trust, |bodies| bodies.trust.min(self.trust));
        let lowered = lowering(&self.claims, &bodies_purpose());
        let refused = lowered.into_iter().filter(|claim| claim.standing() == EvidenceLevel::Refused);
        (trust, refused.map(sentence).collect())
    }
}

/// Collects all claims from the evidence, the weakest level of evidence first.
fn claims(evidence: &Evidence) -> Vec<Claim> {
    let estimate = evidence.estimate;
    let faults = claims_of_faults(evidence.faults, &estimate.joints, &estimate.parameters);
    let of_log = evidence.log_check.map(|log_check| claims_of_log(log_check, evidence.faults)).unwrap_or_default();
    let still = standing(&estimate.joints);
    let faults: Vec<Claim> = faults.into_iter().flat_map(|claim| where_it_stands(claim, &still)).collect();
    let coarse: Vec<Claim> = of_log.into_iter().filter_map(|claim| not_yet_identified(claim, &faults)).collect();
    let is_open = |claim: &Claim| claim.standing() == EvidenceLevel::Open;
    let fine = faults.into_iter().filter_map(|c| if is_open(&c) { not_yet_identified(c, &coarse) } else { Some(c) });
    let fine: Vec<Claim> = fine.collect();
    let mut claims = [coarse, fine].concat();
    claims.extend(evidence.mended.iter().cloned());
    claims.extend(claims_of_bodies(evidence));
    let (opens_in_any_motion, tells_torques) = (evidence.opens_in_any_motion, !estimate.torque_errors.is_empty());
    let beside = TorqueContext { opens_in_any_motion, determines_torques: tells_torques };
    claims.extend(claims_of_fit(estimate, evidence.total, &evidence.prediction, beside));
    match tells_torques {
        true => claims.extend(estimate.torque_errors.iter().map(|error| claim_of_torque(error, &estimate.joints))),
        false => claims.extend(undetermined_torques(estimate)),
    }
    let strength = |claim: &Claim| claim.standing();
    claims.sort_by_key(strength);
    claims
}

/// Removes from a claim the joints for which another claim states agreement on the same topic; `None` if no joint remains.
fn not_yet_identified(claim: Claim, others: &[Claim]) -> Option<Claim> {
    let subject = claim.subject();
    if claim.standing() == EvidenceLevel::Refused || subject.of.is_empty() {
        return Some(claim);
    }
    let agrees = |name: &&String| {
        let one = Subject::of(subject.topic, [(*name).clone()]);
        others.iter().any(|c| matches!(c.outcome(), Outcome::Agrees { .. }) && c.subject().touches(&one))
    };
    let open: Vec<String> = subject.of.iter().filter(|name| !agrees(name)).cloned().collect();
    (!open.is_empty()).then(|| Claim::new(Subject::of(subject.topic, open), claim.outcome().clone()))
}

/// The claims on the identified bodies. Most of these claims are reasons to refuse the bodies.
fn claims_of_bodies(evidence: &Evidence) -> Vec<Claim> {
    let Some(bodies) = evidence.bodies else { return Vec::new() };
    let against = |topic: Topic, fault: String, advice: &str| {
        let remedy = Remedy::new("identify", advice);
        contradicted(Subject::whole(topic), fault, remedy, "it needs other data")
    };
    let refused = |fault: String, advice: &str| against(BODIES, fault, advice);
    let look = "look at the remarks; [rotor_inertia=actuated] takes rotors out of the bodies";
    let mut claims: Vec<Claim> = bodies.refusal.iter().map(|why| against(LOG, why.clone(), look)).collect();
    // A common factor of all masses is an error of a unit or a gain. Without a common factor, an implausible mass of a single
    // body counts as a fault, unless the change of this mass is small.
    let ratios: Vec<f64> = bodies.masses.iter().map(|(_, ratio, _)| *ratio).collect();
    let whole: f64 = bodies.masses.iter().map(|(_, _, mass)| mass).sum();
    let is_off = |&&(_, ratio, mass): &&(String, f64, f64)| {
        !PLAUSIBLE_MASS_RATIOS.contains(&ratio) && (ratio - 1.0).abs() * mass > SMALL_MASS_SHARE * whole
    };
    if let Some(factor) = common_factor(&ratios) {
        let fault =
            format!("all masses are about {factor:.2} times those of the description: a unit or a gain is wrong");
        claims.push(against(COMMON_SCALE, fault, "look at the unit and the gains of the torques"));
    } else if let Some((name, ratio, _)) = bodies.masses.iter().find(is_off) {
        let fault = format!(
            "the mass of {name} comes out at {ratio:.2} times that of the description: these data do not identify it, or it absorbs inertia that no body has"
        );
        claims.push(refused(
            fault,
            "log the robot without load, or give the load its own log ([loaded]); [anyway] writes it",
        ));
    }
    claims.extend(bodies.at_rest.iter().map(|why| refused(why.clone(), "keep the description")));
    let what = "the force at rest is weight: an additional offset of the drive does not show";
    let assumed = Outcome::Assumed { what: what.into(), by: "default".into() };
    claims.extend((!bodies.weighed.is_empty()).then(|| Claim::new(at(BODIES, &bodies.weighed), assumed)));
    // The bodies are refused if the nominal parameters predict at least as well as the identified parameters.
    if let (Some(described), Some(held_out)) = (evidence.described, evidence.prediction.held_out)
        && described <= held_out
    {
        let fault = format!(
            "the nominal parameters predict these logs as well ({}) as the identified ones predict held-out parts ({})",
            percent(described),
            percent(held_out)
        );
        claims.push(refused(fault, "keep the description, or log a longer and richer motion ([:plan])"));
    }
    claims
}

/// A sentence with the reason for which the claim lowers the trust.
pub fn sentence(claim: &Claim) -> String {
    match claim.outcome() {
        Outcome::Contradicted { fault, trial, .. } => match trial {
            Trial::Tried { quantity, before, after } => {
                format!("{fault} ({quantity} {before}; corrected: {after})")
            }
            Trial::NotTried { .. } => fault.clone(),
        },
        Outcome::CannotTell { why, .. } | Outcome::NotLookedAt { why, .. } => why.clone(),
        _ => claim.to_string(),
    }
}

/// The remedy for a claim that lowers the trust, in words; empty if the claim has no remedy.
pub fn what_mends(claim: &Claim) -> String {
    match claim.outcome() {
        Outcome::Contradicted { remedy, .. } => remedy.sentence.clone(),
        Outcome::CannotTell { would_tell, .. } | Outcome::NotLookedAt { would_tell, .. } => would_tell.clone(),
        _ => String::new(),
    }
}

/// The common factor between all identified and nominal masses; `None` if there is no common factor. `ratios`: identified /
/// nominal mass of each body.
fn common_factor(ratios: &[f64]) -> Option<f64> {
    let mut sorted = ratios.to_vec();
    sorted.sort_by(f64::total_cmp);
    let middle = *sorted.get(sorted.len() / 2)?;
    let is_off = !(1.0 / LARGE_MASS_FACTOR..=LARGE_MASS_FACTOR).contains(&middle);
    let together = sorted.iter().all(|r| r / middle < COMMON_FACTOR_TOLERANCE && middle / r < COMMON_FACTOR_TOLERANCE);
    (sorted.len() >= LEAST_MASSES && is_off && together).then_some(middle)
}

/// A sentence on the weakest direction (combination of parameters) that the data do not determine; `None` if the data determine
/// all directions.
fn inseparable_parameters(estimate: &Estimate) -> Option<String> {
    let open = estimate.directions.iter().find(|d| d.open && d.strength > 0.0 && d.members.len() > 1);
    open.map(|direction| direction.sentence())
}

/// Reasons for the trust "yes": errors of predictions, errors of torques, chi^2, condition number.
fn favours(evidence: &Evidence) -> Vec<String> {
    let (estimate, prediction) = (evidence.estimate, &evidence.prediction);
    let mut reasons = Vec::new();
    if let Some(error) = prediction.others.filter(|_| !prediction.others_repeat) {
        let what = match prediction.others_are_of_the_fit {
            true => "relative residual of each log, predicted by parameters from the others",
            false => "relative residual of logs that were not fitted",
        };
        reasons.push(format!("{what}: {}", percent(error)));
    } else if let Some(error) = prediction.held_out {
        let fitted = estimate.total.map_or(String::new(), |x| format!(", of the fitted parts {}", percent(x)));
        reasons
            .push(format!("relative residual of held-out parts, each a motion of its own: {}{fitted}", percent(error)));
    }
    let unsure = |e: &TorqueError| format!("{} {}", e.of.name(), percent(e.relative));
    let errors: Vec<String> = estimate.torque_errors.iter().map(unsure).collect();
    if !errors.is_empty() {
        reasons.push(format!("torque uncertainty: {}", errors.join(", ")));
    }
    if let Some(chi) = estimate.chi_square_per_freedom {
        reasons.push(format!("chi^2 per freedom {chi:.1}"));
    }
    if let Some(condition) = estimate.condition_number.filter(|x| x.is_finite()) {
        reasons.push(format!("condition number {condition:.0}"));
    }
    reasons
}

/// A sentence on the number of significant parameters and on the residuals.
fn found(evidence: &Evidence) -> String {
    let estimate = evidence.estimate;
    let described = evidence.nominal_parameters.unwrap_or_default();
    let is_significant = |(c, p): (usize, &Identified)| {
        let from = |given: f64| p.value.is_some_and(|v| (v - given).abs() > INTERVAL * p.sigma_or_infinity());
        p.status == Status::Given || from(0.0) || described.get(c).is_some_and(|given| from(*given))
    };
    let known = estimate.parameters.iter().enumerate().filter(|p| is_significant(*p)).count();
    let from = if described.is_empty() { "zero" } else { "zero or the nominal value" };
    let parameters =
        format!("{known} of {} parameters are significant: their interval excludes {from}", estimate.parameters.len());
    match (evidence.described, evidence.total) {
        (Some(described), Some(total)) => format!(
            "{parameters}; relative residual of this log: {} with the nominal parameters, {} with the identified ones (friction fitted in both)",
            percent(described),
            percent(total)
        ),
        (None, Some(total)) => format!("{parameters}; the relative residual is {}", percent(total)),
        (_, None) => parameters,
    }
}

/// The next step with an estimate that is trusted for every use of torques, in words. `bodies`: verdict on the bodies; `None`
/// if not requested.
fn use_it(evidence: &Evidence, bodies: Option<&UseVerdict>) -> String {
    let steps = match bodies.map(|bodies| bodies.trust) {
        _ if evidence.estimate.options.is_none() => "[:report] draws it, [:feedforward] tries it",
        Some(Trust::No) => "[:generate] for code",
        Some(_) => "[:write_urdf] or [:write_mjcf] for simulators, [:generate] for code",
        None => "[:generate] for code; [consistent] for bodies that a simulator takes",
    };
    format!("use it ({steps})")
}

/// Topics whose claims are not listed in the report, because the table, the reasons or the remarks of the report contain them.
const TOLD_ELSEWHERE: [Topic; 9] = [
    GRAVITY_TORQUE,
    TORQUE_SEEN,
    TORQUE_AT_LIMITS,
    OTHER_MOTION,
    ROTORS_TAKEN,
    DELAY_TAKEN,
    DEAD_CURRENT_TAKEN,
    MOUNT_TAKEN,
    BODIES_TAKEN,
];

/// Writes the claims that are not contradicted, one per line, then an empty line. Contradicted claims are listed with the reasons
/// of the verdict.
fn write_claims<'a>(f: &mut fmt::Formatter<'_>, claims: impl IntoIterator<Item = &'a Claim>) -> fmt::Result {
    let lines: Vec<String> = claims.into_iter().filter(|claim| !claim.is_contradicted()).map(claim_line).collect();
    lines.iter().try_for_each(|line| writeln!(f, "{line}"))?;
    if lines.is_empty() { Ok(()) } else { writeln!(f) }
}

/// Writes a claim in one line.
pub fn claim_line(claim: &Claim) -> String {
    let subject = claim.subject();
    match claim.outcome() {
        Outcome::Agrees { smallest } => format!("agrees: {subject}; {smallest} would have shown"),
        Outcome::CannotTell { why, .. } => format!("cannot tell: {subject}: {why}"),
        Outcome::NotLookedAt { why, .. } => format!("not looked at: {subject}: {why}"),
        Outcome::Proven { .. } | Outcome::Assumed { .. } | Outcome::Contradicted { .. } => claim.to_string(),
    }
}

/// The table of uses names the worst joint if the relative error of its torque exceeds this value.
const NAMED_JOINT_ERROR: f64 = 0.02;

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{:<32} {:<9}  torque uncertainty", "use", "trust")?;
        for one in &self.uses {
            let error = one.error.map_or("-".into(), percent);
            let worst = one.worst_joint.as_ref().filter(|(_, share)| *share > NAMED_JOINT_ERROR);
            let worst = worst.map_or(String::new(), |(name, share)| format!(" ({name} {})", percent(*share)));
            writeln!(f, "{:<32} {:<9}  {error}{worst}", one.name, one.trust.word())?;
        }
        writeln!(f)?;
        write_claims(f, self.claims.iter().filter(|claim| !TOLD_ELSEWHERE.contains(&claim.subject().topic)))?;
        writeln!(f, "found: {}", self.found)?;
        writeln!(f, "trust: {}", self.trust.word())?;
        self.reasons.iter().try_for_each(|reason| writeln!(f, "  - {reason}"))?;
        writeln!(f, "next: {}", self.next)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_factor_in_all_masses_is_a_unit() {
        let factor = common_factor(&[980.0, 1013.0, 1100.0, 904.0]).unwrap_or(0.0);
        assert!((factor - 1013.0).abs() < 1e-9, "{factor}");
        // Three cases without a common factor: different ratios, ratios near 1, and too few ratios.
        assert_eq!(common_factor(&[0.08, 0.5, 1.3]), None);
        assert_eq!(common_factor(&[1.2, 1.1, 1.3]), None);
        assert_eq!((common_factor(&[0.1, 0.1]), common_factor(&[])), (None, None));
    }
}
