//! What a log and a description have to do with each other, as claims.
//!
//! Each finding of the passport contradicts, or leaves open, what it is about. Without one, sign, scale and zero agree at
//! the joints where a mistake would have been found, with the least mistake that would; at the others they cannot be told.

use claims::{Claim, Figure, Outcome, Remedy, Standing, Subject, Topic, Trial};
use numerics::student;

use crate::estimate::digits::{percent, significant};
use crate::estimate::ledger::claims_of_columns::claims_of_columns;
use crate::estimate::ledger::hypotheses::{Hypothesis, Tested};
use crate::estimate::ledger::purposes::where_it_stands;
use crate::estimate::passport::Passport;
use crate::estimate::passport::finding::{Fault, Finding, NOMINAL_INERTIAL_SLOPES};
use crate::estimate::passport::{COMMON_FACTORS, COUNTED_SLOPE_SHARE, Explained, JointPassport, Turned};
use crate::estimate::topics::{COMMON_SCALE, DELAY, LOAD, LOG, MOUNT, SCALE, SIGN, ZERO};
use crate::estimate::topics::{at, cannot_tell, contradicted};

/// The claims of a passport, contradictions first. `faults`: what unknowns more explain beside a fit, where there is one.
pub fn claims_of_log(passport: &Passport, faults: &[Tested]) -> Vec<Claim> {
    let mut claims: Vec<Claim> = passport.findings.iter().map(finding).collect();
    claims.extend(passport.explained.iter().map(explained_otherwise));
    claims.extend(passport.load.iter().map(|load| {
        let what = format!("{}, which {} ({})", load.statement(), load.remedy, load.evidence);
        Claim::new(Subject::of(LOAD, load.joints.iter().cloned()), Outcome::Assumed { what, by: "default".into() })
    }));
    claims.extend(passport.untold.iter().map(|why| cannot_tell(Subject::whole(COMMON_SCALE), why, "inertials")));
    if claims.iter().any(Claim::is_contradicted) {
        return claims;
    }
    // A fit that would have seen the offset, and saw none, says that the bodies are others.
    let is_seen = |t: &Turned| faults.iter().any(|f| f.of == Hypothesis::Zero(t.joint) && f.power < t.angle.abs());
    let turned = passport.turned.as_ref().filter(|t| !is_seen(t));
    claims.extend([signs(passport), common_scale(passport), zeros(passport, turned)].concat());
    claims.extend(claims_of_columns(passport));
    claims.extend(turned.map(|turned| turned_zero(turned, &passport.joints[turned.joint].coordinate)));
    let stands = |j: &&JointPassport| j.range < STANDING_RANGE;
    let still: Vec<&str> = passport.joints.iter().filter(stands).map(|j| j.coordinate.as_str()).collect();
    claims.into_iter().flat_map(|claim| where_it_stands(claim, &still)).collect()
}

/// The mean position of a joint that stands still, rad (m), is the same in every record but for rounding.
const STANDING_RANGE: f64 = 1e-9;

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

/// Those of these joints of which no mistake is open that other bodies explain as well.
fn unexplained(passport: &Passport, mut names: Vec<String>) -> Vec<String> {
    names.retain(|name| !passport.explained.iter().any(|e| e.finding.joints.contains(name)));
    names
}

fn counts(joint: &JointPassport) -> bool {
    joint.share.is_some_and(|share| share > COUNTED_SLOPE_SHARE)
}

/// Friction that brakes, and torques that follow the description, have the right sign.
fn signs(passport: &Passport) -> Vec<Claim> {
    let brakes = |j: &JointPassport| j.friction.is_some_and(|f| f.brakes > f.deviation);
    let follows = |j: &JointPassport| counts(j) && j.slope.is_some_and(|slope| slope > 0.0);
    let [told, open] = split(passport, |j| brakes(j) || follows(j));
    let [told, open] = [told, open].map(|names| unexplained(passport, names));
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
    let power = common_power(&slopes);
    let middle = slopes.get(slopes.len() / 2).copied().unwrap_or(1.0);
    if middle < power && middle * power > 1.0 {
        return agrees(COMMON_SCALE, &told, Figure::new(power, "times the torque")).into_iter().collect();
    }
    let texts: Vec<String> = slopes.iter().map(|s| significant(*s)).collect();
    let why = format!("the torques are {} times those of the description, joint by joint", texts.join(", "));
    vec![cannot_tell(at(LOG, &told), why, "a known load, or masses that are weighed")]
}

/// The least factor of all torques that would have shown; `None` where none would.
pub fn common_factor_shown(passport: &Passport) -> Option<f64> {
    common_scale(passport).iter().find_map(|claim| match claim.outcome() {
        Outcome::Agrees { smallest } => Some(smallest.value),
        _ => None,
    })
}

/// Common factors below this are errors of nominal masses.
const SMALLEST_COMMON_FACTOR: f64 = 1.05;
/// How often joints whose slopes scatter about 1 have a mean this far from it.
const COMMON_FACTOR_CHANCE: f64 = 0.01;

/// Joints carry the same bodies, so wrong masses move their slopes together: the common error of a description is up to so
/// many times the deviation of its slopes. Of 63 good estimates of the bench `random_situations` none is accused with
/// five; by t alone four were.
const SHARED_ERROR_RATIO: f64 = 5.0;

/// The least factor of all torques that would have been found: with m slopes s_k whose logarithms have the deviation d,
/// `exp(d max(t / sqrt m, SHARED_ERROR_RATIO))`, t of m - 1 degrees of freedom. Where a description is near, so are its
/// slopes to each other.
fn common_power(slopes: &[f64]) -> f64 {
    let widest = if slopes.len() > 1 { COMMON_FACTORS.end } else { NOMINAL_INERTIAL_SLOPES.end };
    // Two joints may carry one body, whose mass moves both slopes alike.
    if slopes.len() < 3 || slopes.iter().any(|s| *s <= 0.0) {
        return widest;
    }
    let m = slopes.len() as f64;
    let mean = slopes.iter().map(|s| s.ln()).sum::<f64>() / m;
    let square = slopes.iter().map(|s| (s.ln() - mean).powi(2)).sum::<f64>() / (m - 1.0);
    let independent = student::reach(COMMON_FACTOR_CHANCE, m - 1.0) / m.sqrt();
    let reached = independent.max(SHARED_ERROR_RATIO) * square.sqrt();
    reached.exp().clamp(SMALLEST_COMMON_FACTOR, widest)
}

/// In which units an answer is, where a factor of all torques that counts would not have shown, or any factor at a joint: one whose torque
/// neither the description nor the other joints tell.
pub(crate) fn units_of_logs(claims: &[Claim]) -> Option<String> {
    let claim = claims.iter().find(|claim| claim.subject().topic == COMMON_SCALE)?;
    let hidden = match claim.outcome() {
        Outcome::Agrees { smallest: s } if s.value > SMALLEST_COMMON_FACTOR => {
            format!("below {} ", claims::significant(s.value, 3))
        }
        Outcome::CannotTell { .. } | Outcome::NotLookedAt { .. } => String::new(),
        _ => return None,
    };
    let told = |name: &&String| !matches!(claim.outcome(), Outcome::Agrees { .. }) || claim.subject().of.contains(name);
    let is_open = |claim: &&Claim| claim.subject().topic == SCALE && claim.standing() == Standing::Open;
    let untold: Vec<&str> = claims
        .iter()
        .filter(is_open)
        .flat_map(|claim| &claim.subject().of)
        .filter(|name| !told(name))
        .map(String::as_str)
        .collect();
    let any =
        if untold.is_empty() { String::new() } else { format!("; at {} no factor would have", untold.join(", ")) };
    Some(format!(
        "in the units of the torques as logged: a factor {hidden}that all of them share would not have shown{any}"
    ))
}

/// The least offsets that would have been found, joints of one offset together.
fn zeros(passport: &Passport, turned: Option<&Turned>) -> Vec<Claim> {
    let mut zeros: Vec<(f64, Vec<String>)> = Vec::new();
    let is_turned = |k: usize| turned.is_some_and(|t| t.joint == k);
    let open_already = |name: &String| unexplained(passport, vec![name.clone()]).is_empty();
    for (_, joint) in passport.joints.iter().enumerate().filter(|(k, j)| !is_turned(*k) && !open_already(&j.coordinate))
    {
        let Some(angle) = shown_zero(joint) else { continue };
        match zeros.iter_mut().find(|(of, _)| *of == angle) {
            Some((_, names)) => names.push(joint.coordinate.clone()),
            None => zeros.push((angle, vec![joint.coordinate.clone()])),
        }
    }
    zeros.sort_by(|a, b| a.0.total_cmp(&b.0));
    let told =
        zeros.iter().filter_map(|(angle, names)| agrees(ZERO, names, Figure::new(angle.to_degrees().round(), "deg")));
    let open = unexplained(passport, split(passport, |j| shown_zero(j).is_some())[1].clone());
    let why = "an offset below 45 deg changes too little of the torques, or bodies behind the joint explain it as well";
    let would_tell = "a heavier load, or the encoder's own reference";
    told.chain(untold(ZERO, &open, why, would_tell).filter(|_| passport.has_description())).collect()
}

/// The least offset of a joint that would have been found, rad; `None` where it is so large that it tells nobody anything.
fn shown_zero(joint: &JointPassport) -> Option<f64> {
    joint.zero_power.filter(|angle| *angle < Hypothesis::Zero(0).kind().useless)
}

/// The description asks for another zero, and other bodies explain the log as well.
fn turned_zero(turned: &Turned, name: &String) -> Claim {
    let Turned { angle, errors: (before, after), .. } = turned;
    let why = format!(
        "the description predicts the torques with {} where the zero of {name} is moved by {} deg, with {} as it is: that zero \
         is off, or the bodies behind it lie otherwise",
        percent(*after),
        significant(angle.to_degrees()),
        percent(*before)
    );
    cannot_tell(at(LOG, [name]), why, "the encoder's own reference, or bodies that are known")
}

/// A mistake that free bodies explain as well. It counts against the log where the description asks for it.
fn explained_otherwise(explained: &Explained) -> Claim {
    let Explained { finding, is_likely } = explained;
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

/// The claim of one finding.
fn finding(finding: &Finding) -> Claim {
    let topic = match finding.fault {
        Fault::TorqueUnit(_) | Fault::NoTorque | Fault::Gains(_) | Fault::Factor(_) => COMMON_SCALE,
        Fault::TorqueSigns | Fault::FrictionSign => SIGN,
        Fault::Of(hypothesis, _) => hypothesis.kind().topic,
        Fault::Mount(_) => MOUNT,
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
    let fault = format!("{}{}", if finding.instead > 0 { "or else " } else { "" }, finding.statement());
    let Some([before, after]) = finding.tried else {
        return contradicted(subject, fault, remedy, &finding.evidence);
    };
    let share = |x: f64| Figure::new(100.0 * x, "%");
    let of = if matches!(finding.fault, Fault::ChangedLoad { .. }) { "a fit" } else { "the description" };
    let quantity = format!("share of the squared torques that {of} leaves, joints alike,");
    let trial = Trial::Tried { quantity, before: share(before), after: share(after) };
    Claim::new(subject, Outcome::Contradicted { fault, remedy, trial })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_zero_that_only_a_large_turn_shows_is_open() {
        let joint = |degrees: f64| JointPassport {
            coordinate: format!("by {degrees}"),
            slope: Some(1.0),
            zero_power: Some(degrees.to_radians()),
            ..JointPassport::default()
        };
        let passport = Passport { joints: vec![joint(30.0), joint(60.0)], ..Passport::default() };
        let claims = zeros(&passport, None);
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
        // d = 0.0158.
        let scattered = [-0.02f64, -0.01, 0.0, 0.01, 0.02].map(f64::exp);
        assert!((common_power(&scattered) - 1.0823).abs() < 1e-3, "{}", common_power(&scattered));
        assert_eq!(common_power(&[1.0, -1.0, 1.1]), COMMON_FACTORS.end);
    }
}
