//! The verdict on an identification or a validation: for each use whether to trust it, why, and what to do next.
//!
//! Everything it says is a claim ([`crate::estimate::ledger`]); trust follows from the worst claim that a use needs
//! (`claims::worst`), and the answer over all uses is the lowest.

use std::fmt;

use claims::{Claim, Outcome, Purpose, Remedy, Standing, Subject, Topic, Trial, lowering, worst};

use crate::estimate::artefact::Estimate;
use crate::estimate::digits::percent;
use crate::estimate::identified::{INTERVAL, Identified, Status};
pub use crate::estimate::ledger::Prediction;
use crate::estimate::ledger::hypotheses::Tested;
use crate::estimate::ledger::purposes::{bodies_purpose, claim_of_torque, torque_purpose};
use crate::estimate::ledger::purposes::{standing, untold_torques, where_it_stands};
use crate::estimate::ledger::{Beside, claims_of_faults, claims_of_fit, claims_of_log, not_noise, units_of_logs};
use crate::estimate::passport::Passport;
use crate::estimate::topics::{
    BODIES, BODIES_TAKEN, COMMON_SCALE, DELAY_TAKEN, GRAVITY_TORQUE, LOG, MOUNT_TAKEN, OTHER_MOTION, ROTORS_TAKEN,
    TORQUE_AT_LIMITS, TORQUE_SEEN, at, contradicted,
};
use crate::estimate::torque_error::{TorqueError, Use};

pub use claims::Trust;

/// The verdict, the last lines of a report.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// The lowest answer of all uses of torques.
    pub trust: Trust,
    /// What was found, beside the error of the description.
    pub found: String,
    /// Why, the weightiest reason first.
    pub reasons: Vec<String>,
    /// What to do now.
    pub next: String,
    /// The answer for each use of torques, and for bodies where they were asked for.
    pub uses: Vec<UseVerdict>,
    /// All that was claimed.
    pub claims: Vec<Claim>,
}

/// Whether to trust an estimate for one use.
#[derive(Clone, Debug, PartialEq)]
pub struct UseVerdict {
    /// The use: `gravity compensation`.
    pub name: String,
    /// The answer.
    pub trust: Trust,
    /// How unsure the torque is by the covariance, relative; `None` where that is not known.
    pub error: Option<f64>,
    /// The joint whose torque is least sure, and how unsure that is.
    pub worst_joint: Option<(String, f64)>,
}

/// The consistent bodies beside the description.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BodiesEvidence {
    /// Why they are not to be used; `None` where the solver found them and they fit.
    pub refusal: Option<String>,
    /// Of each body that has a described mass: its name, the identified over the described mass, and the described mass, kg.
    pub masses: Vec<(String, f64, f64)>,
    /// Why the description is nearer to the log at rest; `None` where it is not.
    pub at_rest: Option<String>,
    /// The joints whose offset is taken for weight.
    pub weighed: Vec<String>,
}

/// What a verdict is made from.
#[derive(Clone, Copy, Debug)]
pub struct Evidence<'a> {
    /// The parameters, their statuses and conditioning.
    pub estimate: &'a Estimate,
    /// The passport of the logs that were fitted, or of those that are validated.
    pub passport: Option<&'a Passport>,
    /// |tau - W X| / |tau| of the description with fitted friction, on the logs that `total` is of.
    pub described: Option<f64>,
    /// The base parameters of the description.
    pub described_parameters: Option<&'a [f64]>,
    /// |tau - W X| / |tau| of the identified parameters, on the fitted logs or on those that are validated.
    pub total: Option<f64>,
    /// Whether `total` is of the logs that were fitted.
    pub is_of_fit: bool,
    /// Errors on motion that was not fitted.
    pub prediction: Prediction,
    /// The bodies, where only bodies that can exist were asked for.
    pub bodies: Option<&'a BodiesEvidence>,
    /// Whether what the logs leave open of the parameters is open in every motion.
    pub opens_in_any_motion: bool,
    /// What was mended without being asked for.
    pub mended: &'a [Claim],
    /// What unknowns more explain.
    pub faults: &'a [Tested],
}

/// All masses are off by one factor where their median ratio is beyond this and the others are near it.
const LARGE_MASS_FACTOR: f64 = 2.5;
/// Ratios of masses within this factor of their median are near it.
const COMMON_FACTOR_SPREAD: f64 = 1.6;

/// Identified over described mass beyond which a body is not to be written.
const BELIEVED_MASS_RATIOS: std::ops::RangeInclusive<f64> = 0.5..=2.0;

/// A change of this share of the robot's mass is none that matters.
const SMALL_MASS_SHARE: f64 = 0.02;

impl Verdict {
    /// Weighs the evidence.
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
        // A simulator moves as it likes: its bodies are worth no more than the torques.
        uses.iter_mut().skip(Use::ALL.len()).for_each(|bodies| bodies.trust = bodies.trust.min(trust));
        let lowered: Vec<&Claim> = claims
            .iter()
            .filter(|claim| purposes[..Use::ALL.len()].iter().any(|(p, _)| lowering(&claims, p).contains(claim)))
            .filter(|claim| trust != Trust::No || claim.standing() == Standing::Refused)
            .collect();
        let next =
            lowered.first().map_or_else(|| use_it(evidence, uses.get(Use::ALL.len())), |claim| what_mends(claim));
        let reasons: Vec<String> = match trust {
            Trust::Yes => favours(evidence).into_iter().chain(units_of_logs(&claims)).collect(),
            _ => lowered.iter().map(|claim| sentence(claim)).collect(),
        };
        // What the fit left says nothing of other logs.
        let of_fit = not_noise(evidence.estimate).filter(|_| evidence.is_of_fit);
        let beside = untold_apart(evidence.estimate).into_iter().chain(of_fit);
        let reasons = reasons.into_iter().chain(beside.filter(|_| trust != Trust::No)).collect();
        Verdict { trust, found: found(evidence), next, reasons, uses, claims }
    }
}

impl Verdict {
    /// What lowers the answer for a use, by its name; empty where nothing does.
    pub fn because(&self, name: &str) -> Vec<String> {
        let purposes = Use::ALL.map(torque_purpose).into_iter().chain([bodies_purpose()]);
        let mut of_it = purposes.filter(|purpose| purpose.name == name);
        of_it.next().map_or_else(Vec::new, |purpose| {
            let mut reasons: Vec<String> = lowering(&self.claims, &purpose).into_iter().map(sentence).collect();
            reasons.dedup();
            reasons
        })
    }

    /// Whether bodies may be written, by trust and reasons; the answer for all uses where no bodies were asked for.
    pub fn of_bodies(&self) -> (Trust, Vec<String>) {
        let trust = self.uses.get(Use::ALL.len()).map_or(self.trust, |bodies| bodies.trust.min(self.trust));
        let lowered = lowering(&self.claims, &bodies_purpose());
        let refused = lowered.into_iter().filter(|claim| claim.standing() == Standing::Refused);
        (trust, refused.map(sentence).collect())
    }
}

/// All claims, those of the log first.
fn claims(evidence: &Evidence) -> Vec<Claim> {
    let estimate = evidence.estimate;
    let faults = claims_of_faults(evidence.faults, &estimate.joints, &estimate.parameters);
    let of_log = evidence.passport.map(|passport| claims_of_log(passport, evidence.faults)).unwrap_or_default();
    let still = standing(&estimate.joints);
    let faults: Vec<Claim> = faults.into_iter().flat_map(|claim| where_it_stands(claim, &still)).collect();
    let coarse: Vec<Claim> = of_log.into_iter().filter_map(|claim| untold_yet(claim, &faults)).collect();
    let is_open = |claim: &Claim| claim.standing() == Standing::Open;
    let fine = faults.into_iter().filter_map(|c| if is_open(&c) { untold_yet(c, &coarse) } else { Some(c) });
    let fine: Vec<Claim> = fine.collect();
    let mut claims = [coarse, fine].concat();
    claims.extend(evidence.mended.iter().cloned());
    claims.extend(claims_of_bodies(evidence));
    let (opens_in_any_motion, tells_torques) = (evidence.opens_in_any_motion, !estimate.torque_errors.is_empty());
    let beside = Beside { opens_in_any_motion, tells_torques };
    claims.extend(claims_of_fit(estimate, evidence.total, &evidence.prediction, beside));
    match tells_torques {
        true => claims.extend(estimate.torque_errors.iter().map(|error| claim_of_torque(error, &estimate.joints))),
        false => claims.extend(untold_torques(estimate)),
    }
    let strength = |claim: &Claim| claim.standing();
    claims.sort_by_key(strength);
    claims
}

/// A claim for the joints of which the others tell nothing.
fn untold_yet(claim: Claim, others: &[Claim]) -> Option<Claim> {
    let subject = claim.subject();
    if claim.standing() == Standing::Refused || subject.of.is_empty() {
        return Some(claim);
    }
    let is_told = |name: &&String| {
        let one = Subject::of(subject.topic, [(*name).clone()]);
        others.iter().any(|c| matches!(c.outcome(), Outcome::Agrees { .. }) && c.subject().touches(&one))
    };
    let open: Vec<String> = subject.of.iter().filter(|name| !is_told(name)).cloned().collect();
    (!open.is_empty()).then(|| Claim::new(Subject::of(subject.topic, open), claim.outcome().clone()))
}

/// What speaks against the bodies.
fn claims_of_bodies(evidence: &Evidence) -> Vec<Claim> {
    let Some(bodies) = evidence.bodies else { return Vec::new() };
    let against = |topic: Topic, fault: String, advice: &str| {
        let remedy = Remedy::new("identify", advice);
        contradicted(Subject::whole(topic), fault, remedy, "it needs other data")
    };
    let refused = |fault: String, advice: &str| against(BODIES, fault, advice);
    let look = "look at the remarks; [rotor_inertia=actuated] takes rotors out of the bodies";
    let mut claims: Vec<Claim> = bodies.refusal.iter().map(|why| against(LOG, why.clone(), look)).collect();
    // A factor of all masses is a unit or a gain; one mass alone counts where it weighs something.
    let ratios: Vec<f64> = bodies.masses.iter().map(|(_, ratio, _)| *ratio).collect();
    let whole: f64 = bodies.masses.iter().map(|(_, _, mass)| mass).sum();
    let is_off = |&&(_, ratio, mass): &&(String, f64, f64)| {
        !BELIEVED_MASS_RATIOS.contains(&ratio) && (ratio - 1.0).abs() * mass > SMALL_MASS_SHARE * whole
    };
    if let Some(factor) = common_factor(&ratios) {
        let fault =
            format!("all masses are about {factor:.2} times those of the description: a unit or a gain is wrong");
        claims.push(against(COMMON_SCALE, fault, "look at the unit and the gains of the torques"));
    } else if let Some((name, ratio, _)) = bodies.masses.iter().find(is_off) {
        let fault = format!(
            "the mass of {name} comes out at {ratio:.2} times that of the description: these data do not tell it, or \
             inertia that no body has is put into it"
        );
        claims.push(refused(
            fault,
            "log the robot without load, or give the load its own log ([loaded]); [anyway] writes it",
        ));
    }
    claims.extend(bodies.at_rest.iter().map(|why| refused(why.clone(), "keep the description")));
    let what = "the force at rest is weight: an offset of the drive beside it does not show";
    let assumed = Outcome::Assumed { what: what.into(), by: "default".into() };
    claims.extend((!bodies.weighed.is_empty()).then(|| Claim::new(at(BODIES, &bodies.weighed), assumed)));
    // What was identified must predict better than what was known before.
    if let (Some(described), Some(held_out)) = (evidence.described, evidence.prediction.held_out)
        && described <= held_out
    {
        let fault = format!(
            "the description predicts these logs as well ({}) as what was identified does parts left out ({})",
            percent(described),
            percent(held_out)
        );
        claims.push(refused(fault, "keep the description, or log a longer and richer motion ([:plan])"));
    }
    claims
}

/// A claim that lowers trust, as a reason.
pub fn sentence(claim: &Claim) -> String {
    match claim.outcome() {
        Outcome::Contradicted { fault, trial, .. } => match trial {
            Trial::Tried { quantity, before, after } => {
                format!("{fault} ({quantity} {before}, with that undone {after})")
            }
            Trial::NotTried { .. } => fault.clone(),
        },
        Outcome::CannotTell { why, .. } | Outcome::NotLookedAt { why, .. } => why.clone(),
        _ => claim.to_string(),
    }
}

/// What to do about a claim that lowers trust.
pub fn what_mends(claim: &Claim) -> String {
    match claim.outcome() {
        Outcome::Contradicted { remedy, .. } => remedy.sentence.clone(),
        Outcome::CannotTell { would_tell, .. } | Outcome::NotLookedAt { would_tell, .. } => would_tell.clone(),
        _ => String::new(),
    }
}

/// The factor by which all masses are off, where there is one.
fn common_factor(ratios: &[f64]) -> Option<f64> {
    let mut sorted = ratios.to_vec();
    sorted.sort_by(f64::total_cmp);
    let middle = *sorted.get(sorted.len() / 2)?;
    let is_off = !(1.0 / LARGE_MASS_FACTOR..=LARGE_MASS_FACTOR).contains(&middle);
    let together = sorted.iter().all(|r| r / middle < COMMON_FACTOR_SPREAD && middle / r < COMMON_FACTOR_SPREAD);
    (sorted.len() >= 3 && is_off && together).then_some(middle)
}

/// The weakest combination that the noise hides.
fn untold_apart(estimate: &Estimate) -> Option<String> {
    let open = estimate.directions.iter().find(|d| d.open && d.strength > 0.0 && d.members.len() > 1);
    open.map(|direction| direction.sentence())
}

fn favours(evidence: &Evidence) -> Vec<String> {
    let (estimate, prediction) = (evidence.estimate, &evidence.prediction);
    let mut reasons = Vec::new();
    if let Some(error) = prediction.others.filter(|_| !prediction.others_repeat) {
        let what = match prediction.others_are_of_the_fit {
            true => "a log is predicted by parameters from the others",
            false => "logs that were not fitted are predicted",
        };
        reasons.push(format!("{what} with {}", percent(error)));
    } else if let Some(error) = prediction.held_out {
        let fitted = estimate.total.map_or(String::new(), |x| format!(", those fitted with {}", percent(x)));
        reasons
            .push(format!("parts left out, each a motion of its own, are predicted with {}{fitted}", percent(error)));
    }
    let unsure = |e: &TorqueError| format!("{} {}", e.of.name(), percent(e.relative));
    let errors: Vec<String> = estimate.torque_errors.iter().map(unsure).collect();
    if !errors.is_empty() {
        reasons.push(format!("torques are unsure by: {}", errors.join(", ")));
    }
    if let Some(chi) = estimate.chi_square_per_freedom {
        reasons.push(format!("chi^2 per freedom {chi:.1}"));
    }
    if let Some(condition) = estimate.condition_number.filter(|x| x.is_finite()) {
        reasons.push(format!("condition number {condition:.0}"));
    }
    reasons
}

fn found(evidence: &Evidence) -> String {
    let estimate = evidence.estimate;
    let described = evidence.described_parameters.unwrap_or_default();
    let is_told = |(c, p): (usize, &Identified)| {
        let from = |given: f64| p.value.is_some_and(|v| (v - given).abs() > INTERVAL * p.sigma_or_infinity());
        p.status == Status::Given || from(0.0) || described.get(c).is_some_and(|given| from(*given))
    };
    let known = estimate.parameters.iter().enumerate().filter(|p| is_told(*p)).count();
    let from = if described.is_empty() { "zero" } else { "zero or from the description" };
    let parameters = format!("{known} of {} parameters are told from {from}", estimate.parameters.len());
    match (evidence.described, evidence.total) {
        (Some(described), Some(total)) => format!(
            "{parameters}; your description predicts this log with {}, the identified parameters with {} (friction fitted \
             in both)",
            percent(described),
            percent(total)
        ),
        (None, Some(total)) => format!("{parameters}; they leave {} of the torques unexplained", percent(total)),
        (_, None) => parameters,
    }
}

/// What to do with an estimate whose torques every use may trust; `bodies`: the answer for them, where they were asked for.
fn use_it(evidence: &Evidence, bodies: Option<&UseVerdict>) -> String {
    let steps = match bodies.map(|bodies| bodies.trust) {
        _ if evidence.estimate.options.is_none() => "[:report] draws it, [:feedforward] tries it",
        Some(Trust::No) => "[:generate] for code",
        Some(_) => "[:write_urdf] or [:write_mjcf] for simulators, [:generate] for code",
        None => "[:generate] for code; [consistent] says whether a simulator may have its bodies",
    };
    format!("use it ({steps})")
}

/// Topics of which the table, the reasons and the remarks tell.
const TOLD_ELSEWHERE: [Topic; 8] =
    [GRAVITY_TORQUE, TORQUE_SEEN, TORQUE_AT_LIMITS, OTHER_MOTION, ROTORS_TAKEN, DELAY_TAKEN, MOUNT_TAKEN, BODIES_TAKEN];

/// What agrees and what cannot be told, a line each, and an empty line behind them.
fn write_claims<'a>(f: &mut fmt::Formatter<'_>, claims: impl IntoIterator<Item = &'a Claim>) -> fmt::Result {
    let lines: Vec<String> = claims.into_iter().filter(|claim| !claim.is_contradicted()).map(claim_line).collect();
    lines.iter().try_for_each(|line| writeln!(f, "{line}"))?;
    if lines.is_empty() { Ok(()) } else { writeln!(f) }
}

/// A claim in one line.
pub fn claim_line(claim: &Claim) -> String {
    let subject = claim.subject();
    match claim.outcome() {
        Outcome::Agrees { smallest } => format!("agrees: {subject}; {smallest} would have shown"),
        Outcome::CannotTell { why, .. } => format!("cannot tell: {subject}: {why}"),
        Outcome::NotLookedAt { why, .. } => format!("not looked at: {subject}: {why}"),
        Outcome::Proven { .. } | Outcome::Assumed { .. } | Outcome::Contradicted { .. } => claim.to_string(),
    }
}

/// A joint whose torque is less sure than this, relative to itself, is named.
const WORTH_NAMING: f64 = 0.02;

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{:<32} {:<9}  torque unsure by", "use", "trust")?;
        for one in &self.uses {
            let error = one.error.map_or("-".into(), percent);
            let worst = one.worst_joint.as_ref().filter(|(_, share)| *share > WORTH_NAMING);
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
        // Masses that differ among themselves, that are near the description, or too few of them.
        assert_eq!(common_factor(&[0.08, 0.5, 1.3]), None);
        assert_eq!(common_factor(&[1.2, 1.1, 1.3]), None);
        assert_eq!((common_factor(&[0.1, 0.1]), common_factor(&[])), (None, None));
    }
}
