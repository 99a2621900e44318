//! Makes claims (statements with their evidence) on whether a log agrees with the robot description. Slope: measured divided by
//! nominal torque of a joint. Bodies: the inertial parameters of the links.
//!
//! A finding of the log check becomes a claim with the outcome "contradicted" or "cannot tell". Without a contradiction, there
//! are claims for each joint that its sign, scale and zero agree with the description. Each such claim states the smallest error
//! that would have been detected. If no error would have been detected, the outcome is "cannot tell".

use claims::{Claim, EvidenceLevel, Figure, Outcome, Remedy, Subject, Topic, Trial};
use numerics::student;

use crate::estimate::claims::claims_of_columns::claims_of_columns;
use crate::estimate::claims::hypotheses::{Hypothesis, HypothesisTest};
use crate::estimate::claims::purposes::where_it_stands;
use crate::estimate::digits::{percent, significant};
use crate::estimate::log_check::LogCheck;
use crate::estimate::log_check::finding::{Fault, Finding, NOMINAL_INERTIAL_SLOPES};
use crate::estimate::log_check::{COMMON_FACTORS, COUNTED_SLOPE_SHARE, ExplainedMistake, JointCheck, MisplacedJoint};
use crate::estimate::topics::{COMMON_SCALE, DELAY, LOAD, LOG, MOUNT, RESIDUAL, SCALE, SIGN, ZERO};
use crate::estimate::topics::{at, cannot_tell, contradicted};

/// The claims from a log check. If there is a contradiction, no agreement is claimed. `faults`: tested hypotheses of a fit;
/// empty without a fit.
pub fn claims_of_log(log_check: &LogCheck, faults: &[HypothesisTest]) -> Vec<Claim> {
    let mut claims: Vec<Claim> = log_check.findings.iter().map(finding).collect();
    claims.extend(log_check.explained.iter().map(explained_otherwise));
    claims.extend(log_check.load.iter().map(|load| {
        let what = format!("{}, which {} ({})", load.statement(), load.remedy, load.evidence);
        Claim::new(Subject::of(LOAD, load.joints.iter().cloned()), Outcome::Assumed { what, by: "default".into() })
    }));
    claims.extend(log_check.not_checked.iter().map(|why| cannot_tell(Subject::whole(COMMON_SCALE), why, "inertials")));
    if claims.iter().any(Claim::is_contradicted) {
        return claims;
    }
    let contacts = log_check.contacts.iter();
    claims.extend(contacts.map(|why| cannot_tell(Subject::whole(RESIDUAL), why, "a log without contact")));
    // `turned`: a zero offset with which the description predicts the torques better. If the fit would have detected this
    // offset but did not find it, the zero is right and the real bodies differ from the nominal bodies.
    let is_seen =
        |t: &MisplacedJoint| faults.iter().any(|f| f.of == Hypothesis::Zero(t.joint) && f.power < t.angle.abs());
    let turned = log_check.turned.as_ref().filter(|t| !is_seen(t));
    claims.extend([signs(log_check), common_scale(log_check), zeros(log_check, turned)].concat());
    claims.extend(claims_of_columns(log_check));
    claims.extend(turned.map(|turned| turned_zero(turned, &log_check.joints[turned.joint].coordinate)));
    let stands = |j: &&JointCheck| j.range() < STANDSTILL_RANGE;
    let still: Vec<&str> = log_check.joints.iter().filter(stands).map(|j| j.coordinate.as_str()).collect();
    claims.into_iter().flat_map(|claim| where_it_stands(claim, &still)).collect()
}

/// A joint stands still if its range of positions, rad (m), is below this value. Rounding errors alone can cause such a range.
const STANDSTILL_RANGE: f64 = 1e-9;

/// Splits the joints by the condition `holds`: names of the joints for which the condition is true, then names of the other
/// joints.
fn split(log_check: &LogCheck, holds: impl Fn(&JointCheck) -> bool) -> [Vec<String>; 2] {
    let (agreeing, unknown): (Vec<_>, Vec<_>) = log_check.joints.iter().partition(|j| holds(j));
    [agreeing, unknown].map(|joints: Vec<&JointCheck>| joints.into_iter().map(|j| j.coordinate.clone()).collect())
}

fn agrees(topic: Topic, names: &[String], smallest: Figure) -> Option<Claim> {
    (!names.is_empty()).then(|| Claim::new(at(topic, names), Outcome::Agrees { smallest }))
}

fn undetermined_joints(topic: Topic, names: &[String], why: &str, would_tell: &str) -> Option<Claim> {
    (!names.is_empty()).then(|| cannot_tell(at(topic, names), why, would_tell))
}

/// Removes from `names` each joint with a possible error of sign or zero that other bodies would explain equally well.
fn unexplained(log_check: &LogCheck, mut names: Vec<String>) -> Vec<String> {
    names.retain(|name| !log_check.explained.iter().any(|e| e.finding.joints.contains(name)));
    names
}

fn counts(joint: &JointCheck) -> bool {
    joint.share.is_some_and(|share| share > COUNTED_SLOPE_SHARE)
}

/// Claims on the sign of the torque of each joint. The sign is right if friction dissipates, or if the regression slope of
/// measured on nominal torque is positive.
fn signs(log_check: &LogCheck) -> Vec<Claim> {
    let brakes = |j: &JointCheck| j.friction.is_some_and(|f| f.brakes > f.deviation);
    let follows = |j: &JointCheck| counts(j) && j.slope.is_some_and(|slope| slope > 0.0);
    let [agreeing, open] = split(log_check, |j| brakes(j) || follows(j));
    let [agreeing, open] = [agreeing, open].map(|names| unexplained(log_check, names));
    let why = "friction and description say too little of the torque";
    let open = undetermined_joints(SIGN, &open, why, "a faster motion of these joints")
        .filter(|_| log_check.has_description());
    agrees(SIGN, &agreeing, Figure::new(-1.0, "times the torque")).into_iter().chain(open).collect()
}

/// The claim on a common factor of the torques of all joints: measured / nominal torque.
fn common_scale(log_check: &LogCheck) -> Vec<Claim> {
    let [agreeing, open] = split(log_check, counts);
    if agreeing.is_empty() {
        let why = "the description explains less than half of the torque";
        return undetermined_joints(COMMON_SCALE, &open, why, "a known load")
            .filter(|_| log_check.has_description())
            .into_iter()
            .collect();
    }
    let mut slopes: Vec<f64> = log_check.joints.iter().filter(|j| counts(j)).filter_map(|j| j.slope).collect();
    slopes.sort_by(f64::total_cmp);
    let power = common_power(&slopes);
    let middle = slopes.get(slopes.len() / 2).copied().unwrap_or(1.0);
    if middle < power && middle * power > 1.0 {
        return agrees(COMMON_SCALE, &agreeing, Figure::new(power, "times the torque")).into_iter().collect();
    }
    let texts: Vec<String> = slopes.iter().map(|s| significant(*s)).collect();
    let why = format!("the torques are {} times those of the description, joint by joint", texts.join(", "));
    vec![cannot_tell(at(LOG, &agreeing), why, "a known load, or masses that are weighed")]
}

/// The smallest common factor of all torques that would have been detected; `None` if no factor would have been detected.
pub fn common_factor_shown(log_check: &LogCheck) -> Option<f64> {
    common_scale(log_check).iter().find_map(|claim| match claim.outcome() {
        Outcome::Agrees { smallest } => Some(smallest.value),
        _ => None,
    })
}

/// Common factors of all torques below this value are not reported, because errors of nominal masses explain them.
const SMALLEST_COMMON_FACTOR: f64 = 1.05;
/// Significance level of a common factor: the probability that the mean of slopes with the true mean 1 is this far from 1 by
/// chance.
const COMMON_FACTOR_CHANCE: f64 = 0.01;

/// Assumed common error of the slopes of all joints, as a multiple of the standard deviation of their logarithms. Joints carry
/// the same bodies, so a wrong nominal mass changes several slopes alike. With 5, none of 63 good estimates of the benchmark
/// `random_situations` is rejected; with Student's t alone, four were.
const SHARED_ERROR_RATIO: f64 = 5.0;
/// Least number of slopes for a standard deviation. Two slopes are too few: both joints may carry the same body, whose mass
/// changes both slopes.
const LEAST_SLOPES: usize = 3;

/// The smallest common factor of all torques that would be detected. `slopes`: measured / nominal torque of each joint. With m
/// slopes and the standard deviation d of their logarithms, this factor is `exp(d max(t / sqrt m, SHARED_ERROR_RATIO))`; t:
/// Student's t for m - 1 degrees of freedom.
fn common_power(slopes: &[f64]) -> f64 {
    let widest = if slopes.len() > 1 { COMMON_FACTORS.end } else { NOMINAL_INERTIAL_SLOPES.end };
    if slopes.len() < LEAST_SLOPES || slopes.iter().any(|s| *s <= 0.0) {
        return widest;
    }
    let m = slopes.len() as f64;
    let mean = slopes.iter().map(|s| s.ln()).sum::<f64>() / m;
    let square = slopes.iter().map(|s| (s.ln() - mean).powi(2)).sum::<f64>() / (m - 1.0);
    let independent = student::two_sided_quantile(COMMON_FACTOR_CHANCE, m - 1.0) / m.sqrt();
    let reached = independent.max(SHARED_ERROR_RATIO) * square.sqrt();
    reached.exp().clamp(SMALLEST_COMMON_FACTOR, widest)
}

/// A sentence on the unit of the estimate: it states the largest common factor of all torques that may be undetected, and the
/// joints at which no factor at all would have been detected. `None` if the detection limit is small.
pub(crate) fn units_of_logs(claims: &[Claim]) -> Option<String> {
    let claim = claims.iter().find(|claim| claim.subject().topic == COMMON_SCALE)?;
    let hidden = match claim.outcome() {
        Outcome::Agrees { smallest: s } if s.value > SMALLEST_COMMON_FACTOR => {
            format!("below {} ", claims::significant(s.value, 3))
        }
        Outcome::CannotTell { .. } | Outcome::NotLookedAt { .. } => String::new(),
        _ => return None,
    };
    let agreeing =
        |name: &&String| !matches!(claim.outcome(), Outcome::Agrees { .. }) || claim.subject().of.contains(name);
    let is_open = |claim: &&Claim| claim.subject().topic == SCALE && claim.standing() == EvidenceLevel::Open;
    let unknown: Vec<&str> = claims
        .iter()
        .filter(is_open)
        .flat_map(|claim| &claim.subject().of)
        .filter(|name| !agreeing(name))
        .map(String::as_str)
        .collect();
    let any =
        if unknown.is_empty() { String::new() } else { format!("; at {} no factor would have", unknown.join(", ")) };
    Some(format!(
        "in the units of the torques as logged: a factor {hidden}that all of them share would not have shown{any}"
    ))
}

/// Claims on the zero of each joint position, with the smallest offset that would have been detected. Joints with equal
/// limits share one claim.
fn zeros(log_check: &LogCheck, turned: Option<&MisplacedJoint>) -> Vec<Claim> {
    let mut zeros: Vec<(f64, Vec<String>)> = Vec::new();
    let is_turned = |k: usize| turned.is_some_and(|t| t.joint == k);
    let open_already = |name: &String| unexplained(log_check, vec![name.clone()]).is_empty();
    for (_, joint) in
        log_check.joints.iter().enumerate().filter(|(k, j)| !is_turned(*k) && !open_already(&j.coordinate))
    {
        let Some(angle) = shown_zero(joint) else { continue };
        match zeros.iter_mut().find(|(of, _)| *of == angle) {
            Some((_, names)) => names.push(joint.coordinate.clone()),
            None => zeros.push((angle, vec![joint.coordinate.clone()])),
        }
    }
    zeros.sort_by(|a, b| a.0.total_cmp(&b.0));
    let agreeing =
        zeros.iter().filter_map(|(angle, names)| agrees(ZERO, names, Figure::new(angle.to_degrees().round(), "deg")));
    let open = unexplained(log_check, split(log_check, |j| shown_zero(j).is_some())[1].clone());
    let why = "an offset below 45 deg changes too little of the torques, or bodies behind the joint explain it as well";
    let would_tell = "a heavier load, or the encoder's own reference";
    agreeing.chain(undetermined_joints(ZERO, &open, why, would_tell).filter(|_| log_check.has_description())).collect()
}

/// The smallest zero offset of a joint that would have been detected, rad; `None` if this offset is too large for a useful
/// claim.
fn shown_zero(joint: &JointCheck) -> Option<f64> {
    joint.zero_power.filter(|angle| *angle < Hypothesis::Zero(0).kind().useless)
}

/// The claim that the description fits better with another zero of a joint. Other bodies explain the log equally well, so the
/// log does not determine which explanation is right.
fn turned_zero(turned: &MisplacedJoint, name: &String) -> Claim {
    let MisplacedJoint { angle, errors: (before, after), .. } = turned;
    let why = format!(
        "the description predicts the torques with {} where the zero of {name} is moved by {} deg, with {} as it is: that zero \
         is off, or the bodies behind it lie otherwise",
        percent(*after),
        significant(angle.to_degrees()),
        percent(*before)
    );
    cannot_tell(at(LOG, [name]), why, "the encoder's own reference, or bodies that are known")
}

/// The claim on a possible error of sign or zero that other bodies explain equally well. If the error is likely, the topic is
/// the log; then the claim lowers the trust.
fn explained_otherwise(explained: &ExplainedMistake) -> Claim {
    let ExplainedMistake { finding, is_likely } = explained;
    let topic = match finding.fault {
        _ if *is_likely => LOG,
        Fault::Of(Hypothesis::Zero(_), _) => ZERO,
        _ => SIGN,
    };
    let why = format!("{}, or other bodies than the description's: {}", finding.statement(), finding.evidence);
    let would_tell =
        format!("the encoder's own reference, or bodies that are known; where it is so: {}", finding.remedy);
    cannot_tell(Subject::of(topic, finding.joints.iter().cloned()), why, would_tell)
}

/// The claim that follows from one finding of the log check.
fn finding(finding: &Finding) -> Claim {
    let topic = match finding.fault {
        Fault::TorqueUnit(_) | Fault::NoTorque | Fault::Gains(_) | Fault::Factor(_) => COMMON_SCALE,
        Fault::TorqueSigns | Fault::FrictionSign => SIGN,
        Fault::Of(hypothesis, _) => hypothesis.kind().topic,
        Fault::Mount(_) => MOUNT,
        _ => LOG,
    };
    // A finding that is not severe (`is_gross`) allows an estimate, but lowers the trust in the log.
    let topic = if finding.fault.is_gross() || topic == DELAY { topic } else { LOG };
    let subject = Subject::of(topic, finding.joints.iter().cloned());
    if !finding.fault.is_gross() {
        let why = format!("{}: {}", finding.statement(), finding.evidence);
        return cannot_tell(subject, why, &finding.remedy);
    }
    let remedy = Remedy::new("identify", &finding.remedy);
    let fault = format!("{}{}", if finding.instead > 0 { "or else " } else { "" }, finding.statement());
    let Some([before, after]) = finding.tried else {
        return contradicted(subject, fault, remedy, &finding.evidence);
    };
    let share = |x: f64| Figure::new(100.0 * x, "%");
    let of = if matches!(finding.fault, Fault::ChangedLoad { .. }) { "a fit" } else { "the description" };
    let quantity = format!("squared residual of {of} over the squared torques, joints alike,");
    let trial = Trial::Tried { quantity, before: share(before), after: share(after) };
    Claim::new(subject, Outcome::Contradicted { fault, remedy, trial })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_zero_that_only_a_large_turn_shows_is_open() {
        let joint = |degrees: f64| JointCheck {
            coordinate: format!("by {degrees}"),
            slope: Some(1.0),
            zero_power: Some(degrees.to_radians()),
            ..JointCheck::default()
        };
        let log_check = LogCheck { joints: vec![joint(30.0), joint(60.0)], ..LogCheck::default() };
        let claims = zeros(&log_check, None);
        let of = |claim: &Claim| claim.subject().of.clone();
        assert!(matches!(claims[0].outcome(), Outcome::Agrees { smallest } if smallest.value == 30.0), "{claims:?}");
        assert!(matches!(claims[1].outcome(), Outcome::CannotTell { .. }) && claims.len() == 2, "{claims:?}");
        assert_eq!(claims.iter().map(of).collect::<Vec<_>>(), [["by 30"], ["by 60"]]);
    }

    #[test]
    fn a_joint_whose_factor_nothing_tells_is_named_beside_the_units() {
        let names = |names: &[&str]| names.iter().map(|name| name.to_string()).collect::<Vec<_>>();
        let all = agrees(COMMON_SCALE, &names(&["j1", "j2"]), Figure::new(1.4, "times the torque")).unwrap();
        let open =
            |of: &[&str]| cannot_tell(Subject::of(SCALE, names(of)), "other bodies explain it as well", "a load");
        let said = |of: &[&str]| units_of_logs(&[all.clone(), open(of)]).unwrap();
        let both = said(&["j2", "j3"]);
        assert!(both.ends_with("would not have shown; at j3 no factor would have"), "{both}");
        assert!(said(&["j2"]).ends_with("would not have shown"));
    }

    #[test]
    fn the_factor_that_would_be_found_follows_the_scatter() {
        assert_eq!(common_power(&[1.25]), NOMINAL_INERTIAL_SLOPES.end);
        assert_eq!(common_power(&[1.25, 1.25]), COMMON_FACTORS.end);
        assert_eq!(common_power(&[1.25, 1.25, 1.251]), SMALLEST_COMMON_FACTOR);
        // The standard deviation of the logarithms is d = 0.0158.
        let scattered = [-0.02f64, -0.01, 0.0, 0.01, 0.02].map(f64::exp);
        assert!((common_power(&scattered) - 1.0823).abs() < 1e-3, "{}", common_power(&scattered));
        assert_eq!(common_power(&[1.0, -1.0, 1.1]), COMMON_FACTORS.end);
    }
}
