//! What a fit tells beside its parameters, as claims: the fault that explains most, and what the others would have shown.

use claims::{Claim, Figure, Outcome, Remedy, Subject, Trial};

use crate::estimate::digits::percent;
use crate::estimate::hypothesis::{CLAIMED, Counts};
use crate::estimate::identified::Identified;
use crate::estimate::ledger::hypotheses::{Hypothesis, Tested};
use crate::estimate::residuals::JointResidual;
use crate::estimate::topics::{DRIFT, LOG, MOUNT, RESIDUAL, ROTOR, at, cannot_tell, contradicted as wrong};

/// A fault that explains less of the torque than this leaves torques sure enough for any use, even where it is five times as
/// large elsewhere: a fifth of `torque_error::SURE_TORQUE`.
const SMALL_FAULT_SHARE: f64 = 0.01;
/// Nor is one small that explains more than this of the torque of its own joint, however little that joint needs.
const LARGE_JOINT_SHARE: f64 = 0.2;

/// The claims of tested hypotheses; `joints`: one per coordinate, `parameters`: those that they were tested beside.
pub(crate) fn claims_of_faults(tested: &[Tested], joints: &[JointResidual], parameters: &[Identified]) -> Vec<Claim> {
    let mut found: Vec<(f64, &Tested)> = tested.iter().filter_map(|t| Some((t.gain()?, t))).collect();
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    // A size that a step from none cannot reach is no size: a cause within its range counts, where one explains as much.
    let least = found.first().map_or(1.0, |(gain, _)| *gain);
    let within = found.iter().find(|(gain, t)| is_within_range(t) && *gain <= BEYOND_RANGE_GAIN_RATIO * least);
    let strongest = within.or(found.first()).map(|(_, t)| *t);
    let mut claims: Vec<Claim> = match strongest {
        Some(one) if !is_within_range(one) => vec![unidentified(&found, joints)],
        _ => strongest.and_then(|t| contradicted(t, joints)).into_iter().collect(),
    };
    // What else is tested is part of the deviations alone.
    for topic in CLAIMED {
        let of_kind: Vec<&Tested> = tested.iter().filter(|t| t.of.kind().topic == topic).collect();
        let (told, untold): (Vec<&Tested>, Vec<&Tested>) =
            of_kind.into_iter().partition(|t| t.power < t.of.kind().useless);
        let is_free = |t: &&&Tested| strongest.is_none() || (!t.is_found() && Some(**t) != strongest);
        let told: Vec<&Tested> = told.into_iter().filter(|t| is_free(&t)).collect();
        claims.extend(agree(&told, joints));
        claims.extend(untold.iter().filter_map(|t| hidden_rotor(t, joints, parameters)));
        let untold = untold.into_iter().filter(|_| topic != ROTOR);
        let names: Vec<&String> = untold.filter_map(|t| Some(&joints[t.of.joint()?].coordinate)).collect();
        if !names.is_empty() {
            let (why, would_tell) = match topic == DRIFT {
                true => ("what the fit leaves is larger", "a longer log"),
                false => ("other bodies explain it as well", "the description, as far as its bodies are right"),
            };
            claims.push(cannot_tell(at(topic, names), why, would_tell));
        }
    }
    claims
}

/// A fault within its range explains as much as one beyond it, where its error on parts left out is at most so many times that.
const BEYOND_RANGE_GAIN_RATIO: f64 = 1.25;
/// Causes that are named where none is identified.
const MOST_CANDIDATES: usize = 3;

/// Whether a size is one that a single linear step from none reaches.
fn is_within_range(tested: &Tested) -> bool {
    tested.value.abs() < tested.of.kind().useless
}

/// That something is wrong where the strongest cause is beyond the range of its step, with what was tried.
fn unidentified(found: &[(f64, &Tested)], joints: &[JointResidual]) -> Claim {
    let named: Vec<String> = found
        .iter()
        .take(MOST_CANDIDATES)
        .map(|(gain, t)| format!("{} (error on parts left out {:.2} times that without it)", topic_of(t, joints), gain))
        .collect();
    let at = found.first().and_then(|(_, t)| t.of.joint()).map(|k| joints[k].coordinate.clone());
    let whose = at.as_ref().map_or("this log".into(), |name| name.clone());
    let why = format!("something is wrong at {whose}; its cause is not identified; tried: {}", named.join(", "));
    let remedy = Remedy::new("doctor", "look at it by [:doctor], and log a motion in which this joint alone moves");
    wrong(Subject::of(LOG, at), why, remedy, "no cause within its range explains it")
}

/// What a cause is about: `scale of q5`.
fn topic_of(tested: &Tested, joints: &[JointResidual]) -> String {
    subject(&tested.of, joints).to_string()
}

/// That a rotor cannot be told from parameters that explain it as well.
fn hidden_rotor(tested: &Tested, joints: &[JointResidual], parameters: &[Identified]) -> Option<Claim> {
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

/// One claim for those of equal power, the least power first.
fn agree(tested: &[&Tested], joints: &[JointResidual]) -> Vec<Claim> {
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

/// One digit, rounded up: a power is no measurement.
fn shown(figure: Figure) -> Figure {
    let digit = 10f64.powf(figure.value.abs().log10().floor());
    let value = (figure.value / digit - 1e-9).ceil() * digit;
    Figure { value: format!("{value:.1e}").parse().unwrap_or(value), ..figure }
}

/// What a fault is and how large, with its deviation.
pub(super) fn statement(tested: &Tested, joints: &[JointResidual]) -> String {
    let Tested { of, value, deviation, .. } = tested;
    let names: Vec<&str> = of.joints().iter().map(|k| joints[*k].coordinate.as_str()).collect();
    of.statement(&format!("{} +- {}", of.figure(*value, joints), of.figure(*deviation, joints)), &names)
}

/// A fault with the errors on parts left out without it and with it.
fn fault_and_trial(fault: &str, held_out: Option<(f64, f64)>) -> String {
    held_out.map_or(fault.into(), |(without, with)| {
        format!(
            "{fault} (error on parts left out, joints alike, {}, with that undone {})",
            percent(without),
            percent(with)
        )
    })
}

/// Whether a fault leaves torques as they are, but for less than a use asks for. A zero or a mount never does: positions are as
/// wrong as they say, whatever torque that costs in this log.
fn is_small(tested: &Tested) -> bool {
    let is_small_at_joint = tested.explained_at_joint() <= LARGE_JOINT_SHARE;
    tested.of.kind().counts != Counts::AsPosition && is_small_at_joint && tested.explained() < SMALL_FAULT_SHARE
}

/// The fault, what mends it, and what parts left out say of it; `None` of those that no claim names.
fn contradicted(tested: &Tested, joints: &[JointResidual]) -> Option<Claim> {
    let Tested { of, value, held_out, .. } = tested;
    let remedy = of.remedy(*value, joints)?;
    // Tried means: parts of the record were left out and predicted without the fault and with it.
    let trial = match held_out {
        Some((without, with)) => Trial::Tried {
            quantity: "error on parts left out, joints alike,".into(),
            before: Figure::new(100.0 * without, "%"),
            after: Figure::new(100.0 * with, "%"),
        },
        None => Trial::NotTried { why: "it is too small".into() },
    };
    let fault = statement(tested, joints);
    // A drive that warms up is no wrong log: it is part of what the fit leaves.
    if of.kind().counts == Counts::AsResidual {
        return Some(cannot_tell(Subject { topic: RESIDUAL, ..subject(of, joints) }, fault, remedy));
    }
    // Nor is a log wrong of which a fault explains less than torques may be off: the fault is named and counts.
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
    use crate::estimate::identified::Deviations;
    use crate::estimate::ledger::purposes::torque_purpose;
    use crate::estimate::residuals::{Residuals, Squares};
    use crate::estimate::torque_error::Use;
    use crate::test_arm::Pendulum;
    use claims::{Standing, worst};
    use linear_model::unit::Unit;

    fn claims(tested: Tested) -> Vec<Claim> {
        let joints = Residuals::new(&Pendulum::new(), vec![Squares::default()]).joints;
        let deviations = Deviations { sigma: 0.1, white: Some(0.1), weak: false };
        let parameter = Identified::new("ZZR1".parse().unwrap(), Unit::INERTIA, 1.0, deviations);
        claims_of_faults(&[tested], &joints, &[parameter])
    }

    fn tested(of: Hypothesis, value: f64, power: f64, within: Vec<usize>) -> Tested {
        let held_out = Some((0.1, 0.08));
        Tested { of, value, deviation: 0.01, power, held_out, torque_share: 1.0, effect: vec![0.1], within }
    }

    /// Whether a use of torques is lowered by the claims, beside another motion that is predicted.
    fn lowers(mut claims: Vec<Claim>) -> bool {
        let other = Subject::whole(crate::estimate::topics::OTHER_MOTION);
        claims.push(Claim::new(other, Outcome::Agrees { smallest: Figure::new(1.0, "%") }));
        worst(&claims, &torque_purpose(Use::Gravity)) < Standing::Agreed
    }

    #[test]
    fn a_drift_that_is_there_lowers_and_one_that_may_be_does_not() {
        let found = claims(tested(Hypothesis::Drift(0), 0.2, 0.1, Vec::new()));
        assert!(found[0].to_string().contains("grows by 20 %"), "{}", found[0]);
        assert!(found[0].standing() == Standing::Open && lowers(found));
        for power in [f64::INFINITY, 0.1] {
            let none = claims(tested(Hypothesis::Drift(0), 0.0, power, Vec::new()));
            assert!(none.len() == 1 && !none[0].to_string().contains("grows"), "{none:?}");
            assert!(!lowers(none));
        }
    }

    /// What would have shown is said by its size, the least first.
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

    /// A spring that explains a hundredth of the torque and more is a contradiction, and so is one that explains a fifth of that
    /// of its joint; one that explains less is named, and lowers the answer to with care. A zero is a contradiction always.
    #[test]
    fn a_fault_that_explains_little_is_no_contradiction() {
        // sqrt(0.1^2 - 0.08^2) = 0.06, sqrt(0.01^2 - 0.008^2) = 0.006
        let (much, little) = (Some((0.1, 0.08)), Some((0.01, 0.008)));
        let (spring, zero) = (Hypothesis::Spring(0), Hypothesis::Zero(0));
        let (refused, open) = (Standing::Refused, Standing::Open);
        for (of, held_out, torque_share, standing) in [
            (&spring, much, 1.0, refused),
            (&spring, little, 0.029, refused),
            (&spring, little, 0.031, open),
            (&zero, little, 1.0, refused),
        ] {
            let found = claims(Tested { held_out, torque_share, ..tested(*of, 0.5, 0.1, Vec::new()) });
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
