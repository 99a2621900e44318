//! Makes claims (statements with their evidence) on tested faults of a log. In: the test result of each possible fault
//! (`hypotheses`). Out: a claim on the fault that explains most of the residual, and claims with the detection limits of the
//! other faults. The detection limit is the smallest size of a fault that would have been found.

use claims::{Claim, Figure, Outcome, Remedy, Subject, Trial};

use crate::estimate::claims::hypotheses::{Hypothesis, HypothesisTest};
use crate::estimate::digits::percent;
use crate::estimate::hypothesis::{CLAIMED, Counts};
use crate::estimate::identified::Identified;
use crate::estimate::residuals::JointResidual;
use crate::estimate::topics::{DRIFT, LOG, MOUNT, RESIDUAL, ROTOR, at, cannot_tell, contradicted as wrong};

/// A fault is small if it explains less than this share of the torque. In another motion, the same fault may explain a share of
/// the torque that is five times as large. So this limit is a fifth of `torque_error::SURE_TORQUE`, the accepted relative
/// torque error.
const SMALL_FAULT_SHARE: f64 = 0.01;
/// A fault is not small if it explains more than this share of the torque of its own joint.
const LARGE_JOINT_SHARE: f64 = 0.2;

/// The claims on tested faults. `joints`: residuals of the fit, one per coordinate; `parameters`: the parameters of the fit.
pub(crate) fn claims_of_faults(
    tested: &[HypothesisTest],
    joints: &[JointResidual],
    parameters: &[Identified],
) -> Vec<Claim> {
    let mut found: Vec<(f64, &HypothesisTest)> = tested.iter().filter_map(|t| Some((t.gain()?, t))).collect();
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    // The size of a fault is fitted with a linear model, so the size is reliable only within the range where this model is
    // accurate (the linear range of the fault). A fault within this range is preferred if it explains nearly as much of the
    // residual as the strongest fault.
    let least = found.first().map_or(1.0, |(gain, _)| *gain);
    let within = found.iter().find(|(gain, t)| is_within_range(t) && *gain <= BEYOND_RANGE_GAIN_RATIO * least);
    let strongest = within.or(found.first()).map(|(_, t)| *t);
    let mut claims: Vec<Claim> = match strongest {
        Some(one) if !is_within_range(one) => vec![unidentified(&found, joints)],
        _ => strongest.and_then(|t| contradicted(t, joints)).into_iter().collect(),
    };
    // Only the topics in `CLAIMED` have claims. Hypotheses on other topics only inflate standard deviations.
    for topic in CLAIMED {
        let of_kind: Vec<&HypothesisTest> = tested.iter().filter(|t| t.of.kind().topic == topic).collect();
        let (detectable, undetectable): (Vec<&HypothesisTest>, Vec<&HypothesisTest>) =
            of_kind.into_iter().partition(|t| t.power < t.of.kind().useless);
        let is_free = |t: &&&HypothesisTest| strongest.is_none() || (!t.is_found() && Some(**t) != strongest);
        let detectable: Vec<&HypothesisTest> = detectable.into_iter().filter(|t| is_free(&t)).collect();
        claims.extend(agree(&detectable, joints));
        claims.extend(undetectable.iter().filter_map(|t| hidden_rotor(t, joints, parameters)));
        let undetectable = undetectable.into_iter().filter(|_| topic != ROTOR);
        let names: Vec<&String> = undetectable.filter_map(|t| Some(&joints[t.of.joint()?].coordinate)).collect();
        if !names.is_empty() {
            let (why, would_tell) = match topic == DRIFT {
                true => ("the residual is larger", "a longer log"),
                false => ("other bodies explain it as well", "the description, as far as its bodies are right"),
            };
            claims.push(cannot_tell(at(topic, names), why, would_tell));
        }
    }
    claims
}

/// A fault within its linear range is preferred if its gain is at most the gain of the strongest fault times this factor. Gain:
/// error of cross-validation with the fault as an unknown, divided by the error without the fault; the strongest fault has the
/// smallest gain.
const BEYOND_RANGE_GAIN_RATIO: f64 = 1.25;
/// Largest number of possible causes that are listed in the claim that the cause is not identified.
const MOST_NAMED_CAUSES: usize = 3;
/// Relative tolerance of rounding up, so that 2.0000000001 becomes 2 and not 3.
const ROUNDING_TOLERANCE: f64 = 1e-9;

/// Whether the fitted size of a fault is within the range in which one linear step is accurate.
fn is_within_range(tested: &HypothesisTest) -> bool {
    tested.value.abs() < tested.of.kind().useless
}

/// The claim that there is a fault with an unknown cause, because the fitted size of the strongest cause is beyond the range of
/// the linear model. The claim lists the causes that were tested.
fn unidentified(found: &[(f64, &HypothesisTest)], joints: &[JointResidual]) -> Claim {
    let named: Vec<String> = found
        .iter()
        .take(MOST_NAMED_CAUSES)
        .map(|(gain, t)| format!("{} (held-out error {:.2} times the error without it)", topic_of(t, joints), gain))
        .collect();
    let at = found.first().and_then(|(_, t)| t.of.joint()).map(|k| joints[k].coordinate.clone());
    let whose = at.as_ref().map_or("this log".into(), |name| name.clone());
    let why = format!("something is wrong at {whose}; its cause is not identified; tried: {}", named.join(", "));
    let remedy = Remedy::new("doctor", "look at it by [:doctor], and log a motion in which this joint alone moves");
    wrong(Subject::of(LOG, at), why, remedy, "no cause within its range explains it")
}

/// The topic and the joint of a fault in words, e.g. `scale of q5`.
fn topic_of(tested: &HypothesisTest, joints: &[JointResidual]) -> String {
    subject(&tested.of, joints).to_string()
}

/// The claim that a rotor inertia is not separable from other parameters, because the columns are linearly dependent. `None` if
/// the hypothesis is not such a rotor inertia.
fn hidden_rotor(tested: &HypothesisTest, joints: &[JointResidual], parameters: &[Identified]) -> Option<Claim> {
    let Hypothesis::Rotor(k) = tested.of else { return None };
    let names: Vec<String> = tested.within.iter().filter_map(|&c| Some(parameters.get(c)?.id.to_string())).collect();
    let why = format!("where there is one, it is part of {}", names.join(", "));
    let claim = cannot_tell(at(ROTOR, [&joints[k].coordinate]), why, "the data sheet of the motor");
    (!names.is_empty()).then_some(claim)
}

fn subject(of: &Hypothesis, joints: &[JointResidual]) -> Subject {
    match *of {
        Hypothesis::Mount(axis) => Subject::of(MOUNT, [["x", "y", "z"][axis]]),
        _ => at(of.kind().topic, of.joint().map(|k| &joints[k].coordinate)),
    }
}

/// Claims that no fault was found. Each claim states the size of the smallest detectable fault, and the claims are sorted by
/// this size. Hypotheses with equal detection limits share one claim.
fn agree(tested: &[&HypothesisTest], joints: &[JointResidual]) -> Vec<Claim> {
    let mut groups: Vec<(Figure, Subject)> = Vec::new();
    for one in tested {
        let (figure, subject) = (shown(one.of.figure(one.power, joints)), subject(&one.of, joints));
        match groups.iter_mut().find(|(of, _)| *of == figure) {
            Some((_, all)) => all.of.extend(subject.of),
            None => groups.push((figure, subject)),
        }
    }
    groups.sort_by(|a, b| a.0.value.total_cmp(&b.0.value));
    groups.into_iter().map(|(smallest, subject)| Claim::new(subject, Outcome::Agrees { smallest })).collect()
}

/// Rounds a detection limit up to one significant digit.
fn shown(figure: Figure) -> Figure {
    let digit = 10f64.powf(figure.value.abs().log10().floor());
    let value = (figure.value / digit - ROUNDING_TOLERANCE).ceil() * digit;
    Figure { value: format!("{value:.1e}").parse().unwrap_or(value), ..figure }
}

/// A sentence with a fault, its size and the standard deviation of the size.
pub(super) fn statement(tested: &HypothesisTest, joints: &[JointResidual]) -> String {
    let HypothesisTest { of, value, deviation, .. } = tested;
    let names: Vec<&str> = of.joints().iter().map(|k| joints[*k].coordinate.as_str()).collect();
    of.statement(&format!("{} +- {}", of.figure(*value, joints), of.figure(*deviation, joints)), &names)
}

/// A sentence with a fault and two errors of cross-validation: without the fault, and with the fault as an additional unknown.
fn fault_and_trial(fault: &str, held_out: Option<(f64, f64)>) -> String {
    held_out.map_or(fault.into(), |(without, with)| {
        format!("{fault} (held-out error, joints alike, {}; corrected: {})", percent(without), percent(with))
    })
}

/// Whether the torque of a fault is so small that every use tolerates the fault. A zero offset or a tilted mount is never
/// small, because the positions are wrong even if the torque error is small.
fn is_small(tested: &HypothesisTest) -> bool {
    let is_small_at_joint = tested.explained_at_joint() <= LARGE_JOINT_SHARE;
    tested.of.kind().counts != Counts::AsPosition && is_small_at_joint && tested.explained() < SMALL_FAULT_SHARE
}

/// The claim on a found fault, with its remedy and the errors of cross-validation; `None` if there is no remedy for this
/// kind.
fn contradicted(tested: &HypothesisTest, joints: &[JointResidual]) -> Option<Claim> {
    let HypothesisTest { of, value, held_out, .. } = tested;
    let remedy = of.remedy(*value, joints)?;
    // `Tried` contains the errors of cross-validation without the fault, and with the fault as an additional unknown.
    let trial = match held_out {
        Some((without, with)) => Trial::Tried {
            quantity: "held-out error, joints alike,".into(),
            before: Figure::new(100.0 * without, "%"),
            after: Figure::new(100.0 * with, "%"),
        },
        None => Trial::NotTried { why: "it is too small".into() },
    };
    let fault = statement(tested, joints);
    // A change of the torque constant with temperature (drift) does not make the log wrong. So the claim is on the residual, not
    // on the log.
    if of.kind().counts == Counts::AsResidual {
        return Some(cannot_tell(Subject { topic: RESIDUAL, ..subject(of, joints) }, fault, remedy));
    }
    // A small fault does not make the log wrong, but the fault is named and lowers the trust.
    if is_small(tested) {
        return Some(cannot_tell(
            Subject { topic: LOG, ..subject(of, joints) },
            fault_and_trial(&fault, *held_out),
            remedy,
        ));
    }
    let remedy = Remedy::new("identify", remedy);
    Some(Claim::new(subject(of, joints), Outcome::Contradicted { fault, remedy, trial }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::claims::purposes::torque_purpose;
    use crate::estimate::identified::Deviations;
    use crate::estimate::residuals::{Residuals, Squares};
    use crate::estimate::torque_error::Use;
    use crate::test_arm::Pendulum;
    use claims::{EvidenceLevel, worst};
    use linear_model::unit::Unit;

    fn claims(tested: HypothesisTest) -> Vec<Claim> {
        let joints = Residuals::new(&Pendulum::new(), vec![Squares::default()]).joints;
        let deviations = Deviations { sigma: 0.1, white: Some(0.1), weak: false };
        let parameter = Identified::new("ZZR1".parse().unwrap(), Unit::INERTIA, 1.0, deviations);
        claims_of_faults(&[tested], &joints, &[parameter])
    }

    fn tested(of: Hypothesis, value: f64, power: f64, within: Vec<usize>) -> HypothesisTest {
        let held_out = Some((0.1, 0.08));
        HypothesisTest { of, value, deviation: 0.01, power, held_out, torque_share: 1.0, effect: vec![0.1], within }
    }

    /// Whether these claims lower the trust for gravity compensation, if another motion is predicted well.
    fn lowers(mut claims: Vec<Claim>) -> bool {
        let other = Subject::whole(crate::estimate::topics::OTHER_MOTION);
        claims.push(Claim::new(other, Outcome::Agrees { smallest: Figure::new(1.0, "%") }));
        worst(&claims, &torque_purpose(Use::Gravity)) < EvidenceLevel::Agreed
    }

    #[test]
    fn a_drift_that_is_there_lowers_and_one_that_may_be_does_not() {
        let found = claims(tested(Hypothesis::Drift(0), 0.2, 0.1, Vec::new()));
        assert!(found[0].to_string().contains("grows by 20 %"), "{}", found[0]);
        assert!(found[0].standing() == EvidenceLevel::Open && lowers(found));
        for power in [f64::INFINITY, 0.1] {
            let none = claims(tested(Hypothesis::Drift(0), 0.0, power, Vec::new()));
            assert!(none.len() == 1 && !none[0].to_string().contains("grows"), "{none:?}");
            assert!(!lowers(none));
        }
    }

    /// Claims are sorted by detection limit, the smallest first.
    #[test]
    fn the_least_power_comes_first() {
        let joints = Residuals::new(&Pendulum::new(), vec![Squares::default()]).joints;
        let [large, small] = [0.4, 0.1].map(|power| tested(Hypothesis::Drift(0), 0.0, power, Vec::new()));
        let said = agree(&[&large, &small], &joints);
        let power = |claim: &Claim| match claim.outcome() {
            Outcome::Agrees { smallest } => smallest.value,
            other => panic!("{other:?}"),
        };
        assert!(said.len() == 2 && power(&said[0]) < power(&said[1]), "{said:?}");
    }

    /// A spring is a contradiction if it explains more than a hundredth of the torque, or a fifth of the torque of the joint
    /// with the spring. A smaller spring lowers the trust to "with care". A zero offset is always a contradiction.
    #[test]
    fn a_fault_that_explains_little_is_no_contradiction() {
        // Explained share of the torque: sqrt(e^2 - f^2). e: error of cross-validation without the fault; f: error with the
        // fault. Here the shares are 0.06 and 0.006.
        let (much, little) = (Some((0.1, 0.08)), Some((0.01, 0.008)));
        let (spring, zero) = (Hypothesis::Spring(0), Hypothesis::Zero(0));
        let (refused, open) = (EvidenceLevel::Refused, EvidenceLevel::Open);
        for (of, held_out, torque_share, standing) in [
            (&spring, much, 1.0, refused),
            (&spring, little, 0.029, refused),
            (&spring, little, 0.031, open),
            (&zero, little, 1.0, refused),
        ] {
            let found = claims(HypothesisTest { held_out, torque_share, ..tested(*of, 0.5, 0.1, Vec::new()) });
            assert!(found[0].standing() == standing, "{}", found[0]);
            assert!(lowers(found));
        }
    }

    #[test]
    fn a_size_beyond_its_step_is_not_printed() {
        let beyond = tested(Hypothesis::Scale(0), -1.28, 0.1, Vec::new());
        let spring = tested(Hypothesis::Spring(0), 3.0, 0.1, Vec::new());
        let joints = Residuals::new(&Pendulum::new(), vec![Squares::default()]).joints;
        let alone = claims_of_faults(std::slice::from_ref(&beyond), &joints, &[]);
        assert!(alone[0].to_string().contains("its cause is not identified"), "{}", alone[0]);
        assert!(alone.iter().all(|claim| !claim.to_string().contains("128")), "{alone:?}");
        let both = claims_of_faults(&[beyond, spring], &joints, &[]);
        assert!(both[0].to_string().contains("a spring of 3"), "{}", both[0]);
        assert!(both.iter().all(|claim| !claim.to_string().contains("not identified")), "{both:?}");
    }

    #[test]
    fn a_hidden_rotor_is_part_of_a_parameter() {
        let hidden = claims(tested(Hypothesis::Rotor(0), 0.0, f64::INFINITY, vec![0]));
        assert!(hidden[0].to_string().contains("it is part of ZZR1"), "{}", hidden[0]);
        assert!(!lowers(hidden));
    }
}
