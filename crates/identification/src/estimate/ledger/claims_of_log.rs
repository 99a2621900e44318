//! What a log and a description have to do with each other, as claims.
//!
//! Each finding of the passport contradicts, or leaves open, what it is about. Without one, sign, scale and zero agree at
//! the joints where a mistake would have been found, with the least mistake that would; at the others they cannot be told.

use claims::{Claim, Figure, Outcome, Remedy, Subject, Topic, Trial};

use crate::estimate::digits::significant;
use crate::estimate::ledger::hypotheses::{Hypothesis, Tested};
use crate::estimate::ledger::topics::{COMMON_SCALE, DELAY, LOG, MOUNT, SIGN, ZERO};
use crate::estimate::ledger::topics::{at, cannot_tell};
use crate::estimate::passport::Passport;
use crate::estimate::passport::finding::{Fault, Finding, NOMINAL_INERTIAL_SLOPES};
use crate::estimate::passport::{COMMON_FACTORS, COUNTED_SLOPE_SHARE, JointPassport};

/// What a fit with free parameters says of the findings of a description.
#[derive(Clone, Copy, Debug)]
pub struct FreeFit<'a> {
    /// Error on parts left out.
    pub error: f64,
    /// What unknowns more explain.
    pub faults: &'a [Tested],
}

/// Error of a fit with free parameters up to which it explains a log.
const EXPLAINED_ERROR: f64 = 0.02;

/// The claims of a passport, contradictions first. With a fit, an offset or a sign of a joint that the fit does not need is
/// no contradiction: other bodies explain the log as well.
pub fn claims_of_log(passport: &Passport, fit: Option<FreeFit>) -> Vec<Claim> {
    let of = |found: &Finding| {
        let is_needed = fit.is_none_or(|fit| is_needed(found, passport, fit));
        if is_needed { finding(found) } else { explained_otherwise(found) }
    };
    let mut claims: Vec<Claim> = passport.findings.iter().map(of).collect();
    claims.extend(passport.untold.iter().map(|why| cannot_tell(Subject::whole(COMMON_SCALE), why, "inertials")));
    if claims.iter().any(Claim::is_contradicted) {
        return claims;
    }
    claims.extend([signs(passport), common_scale(passport), zeros(passport)].concat());
    claims
}

/// The names of the joints of which something holds, and of the others.
fn split(passport: &Passport, holds: impl Fn(&JointPassport) -> bool) -> [Vec<String>; 2] {
    let (told, untold): (Vec<_>, Vec<_>) = passport.joints.iter().partition(|j| holds(j));
    [told, untold].map(|joints: Vec<&JointPassport>| joints.into_iter().map(|j| j.coordinate.clone()).collect())
}

fn agrees(topic: Topic, names: &[String], smallest: Figure) -> Option<Claim> {
    (!names.is_empty()).then(|| Claim::new(at(topic, names), Outcome::Agrees { smallest }))
}

fn untold(topic: Topic, names: &[String], why: &str, would_tell: &str) -> Option<Claim> {
    (!names.is_empty()).then(|| cannot_tell(at(topic, names), why, would_tell))
}

fn counts(joint: &JointPassport) -> bool {
    joint.share.is_some_and(|share| share > COUNTED_SLOPE_SHARE)
}

/// Friction that brakes, and torques that follow the description, have the right sign.
fn signs(passport: &Passport) -> Vec<Claim> {
    let brakes = |j: &JointPassport| j.friction.is_some_and(|f| f.brakes > f.deviation);
    let [told, open] = split(passport, |j| brakes(j) || counts(j));
    let why = "friction and description say too little of the torque";
    let open = untold(SIGN, &open, why, "a faster motion of these joints").filter(|_| passport.has_description());
    agrees(SIGN, &told, Figure::new(-1.0, "times the torque")).into_iter().chain(open).collect()
}

/// The torques beside those of the description, of all joints alike.
fn common_scale(passport: &Passport) -> Vec<Claim> {
    let [told, open] = split(passport, counts);
    if told.is_empty() {
        let why = "the description explains less than half of the torque";
        return untold(COMMON_SCALE, &open, why, "a known load")
            .filter(|_| passport.has_description())
            .into_iter()
            .collect();
    }
    let mut slopes: Vec<f64> = passport.joints.iter().filter(|j| counts(j)).filter_map(|j| j.slope).collect();
    slopes.sort_by(f64::total_cmp);
    let is_near = slopes.get(slopes.len() / 2).is_none_or(|middle| COMMON_FACTORS.contains(middle));
    if is_near {
        let largest = if told.len() > 1 { COMMON_FACTORS.end } else { NOMINAL_INERTIAL_SLOPES.end };
        return agrees(COMMON_SCALE, &told, Figure::new(largest, "times the torque")).into_iter().collect();
    }
    let texts: Vec<String> = slopes.iter().map(|s| significant(*s)).collect();
    let why = format!("the torques are {} times those of the description, joint by joint", texts.join(", "));
    vec![cannot_tell(at(LOG, &told), why, "a known load, or masses that are weighed")]
}

/// The least offsets that would have been found, joints of one offset together.
fn zeros(passport: &Passport) -> Vec<Claim> {
    let mut zeros: Vec<(f64, Vec<String>)> = Vec::new();
    for joint in &passport.joints {
        let Some(angle) = joint.zero_power else { continue };
        match zeros.iter_mut().find(|(of, _)| *of == angle) {
            Some((_, names)) => names.push(joint.coordinate.clone()),
            None => zeros.push((angle, vec![joint.coordinate.clone()])),
        }
    }
    zeros.sort_by(|a, b| a.0.total_cmp(&b.0));
    let told =
        zeros.iter().filter_map(|(angle, names)| agrees(ZERO, names, Figure::new(angle.to_degrees().round(), "deg")));
    let [_, open] = split(passport, |j| j.zero_power.is_some());
    let (why, would_tell) = ("these joints carry too little gravity", "a heavier load, or the encoder's own reference");
    told.chain(untold(ZERO, &open, why, would_tell).filter(|_| passport.has_description())).collect()
}

/// Whether a log cannot be explained without what was found.
fn is_needed(finding: &Finding, passport: &Passport, fit: FreeFit) -> bool {
    let is_explained = fit.error <= EXPLAINED_ERROR && !fit.faults.is_empty();
    if matches!(finding.fault, Fault::SwappedJoints | Fault::SwappedMotions | Fault::SwappedTorques) {
        return !is_explained;
    }
    let [name] = finding.joints.as_slice() else { return true };
    let Some(k) = passport.joints.iter().position(|j| j.coordinate == *name) else { return true };
    if !is_explained {
        return true;
    }
    let is_found = |of: &dyn Fn(&Hypothesis) -> bool| fit.faults.iter().any(|t| of(&t.of) && t.is_found());
    match finding.fault {
        Fault::Zero(_) => is_found(&|h| *h == Hypothesis::Zero(k)),
        // Torques of the wrong sign make friction drive.
        Fault::TorqueSign => !passport.joints[k].friction.is_some_and(|f| f.brakes > f.deviation),
        Fault::Reversed => false,
        _ => true,
    }
}

fn explained_otherwise(finding: &Finding) -> Claim {
    let topic = if matches!(finding.fault, Fault::Zero(_)) { ZERO } else { SIGN };
    let why = format!("{}, or other bodies than the description's: {}", finding.statement(), finding.evidence);
    cannot_tell(Subject::of(topic, finding.joints.iter().cloned()), why, "the encoder's own reference, or a known load")
}

/// The claim of one finding.
fn finding(finding: &Finding) -> Claim {
    let topic = match finding.fault {
        Fault::TorqueUnit(_) | Fault::NoTorque | Fault::Gains(_) | Fault::Factor(_) => COMMON_SCALE,
        Fault::TorqueSigns | Fault::TorqueSign | Fault::MotionSign | Fault::Reversed | Fault::FrictionSign => SIGN,
        Fault::Zero(_) => ZERO,
        Fault::Delay(_) => DELAY,
        Fault::GravityCompensated => MOUNT,
        _ => LOG,
    };
    // What does not forbid an estimate counts against it all the same.
    let topic = if finding.fault.is_gross() || topic == DELAY { topic } else { LOG };
    let subject = Subject::of(topic, finding.joints.iter().cloned());
    if !finding.fault.is_gross() {
        let why = format!("{}: {}", finding.statement(), finding.evidence);
        return cannot_tell(subject, why, &finding.remedy);
    }
    let remedy = Remedy::new("identify", &finding.remedy);
    let trial = Trial::NotTried { why: finding.evidence.clone() };
    Claim::new(subject, Outcome::Contradicted { fault: finding.statement(), remedy, trial })
}
