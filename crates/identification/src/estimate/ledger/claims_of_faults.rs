//! The faults that a fit tells by itself, as claims: the one that explains most, and what the others would have shown.

use claims::{Claim, Figure, Outcome, Remedy, Subject, Topic, Trial};

use crate::estimate::digits::significant;
use crate::estimate::ledger::hypotheses::{Hypothesis, Tested};
use crate::estimate::ledger::topics::{MOUNT, SCALE, SPRING, ZERO};
use crate::estimate::ledger::topics::{at, cannot_tell};
use crate::estimate::residuals::JointResidual;
use linear_model::unit::Unit;

/// Powers beyond these tell nobody anything: 45 degrees, and half of a torque.
const USELESS_ANGLE_RAD: f64 = std::f64::consts::FRAC_PI_4;
const USELESS_SCALE: f64 = 0.5;

/// The claims of tested hypotheses; `joints`: one per coordinate.
pub(crate) fn claims_of_faults(tested: &[Tested], joints: &[JointResidual]) -> Vec<Claim> {
    let found = tested.iter().filter_map(|t| Some((t.gain()?, t)));
    let strongest = found.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, t)| t);
    let mut claims: Vec<Claim> = strongest.map(|t| contradicted(t, joints)).into_iter().collect();
    let kinds: [fn(&Hypothesis) -> bool; 4] = [
        |h| matches!(h, Hypothesis::Mount(_)),
        |h| matches!(h, Hypothesis::Zero(_)),
        |h| matches!(h, Hypothesis::Scale(_)),
        |h| matches!(h, Hypothesis::Spring(_)),
    ];
    for is_kind in kinds {
        let of_kind: Vec<&Tested> = tested.iter().filter(|t| is_kind(&t.of)).collect();
        let (told, untold): (Vec<&Tested>, Vec<&Tested>) = of_kind.into_iter().partition(|t| is_useful(t));
        let is_free = |t: &&&Tested| strongest.is_none() || (!t.is_found() && Some(**t) != strongest);
        let told: Vec<&Tested> = told.into_iter().filter(|t| is_free(&t)).collect();
        claims.extend(agree(&told, joints));
        let names: Vec<&String> = untold.iter().filter_map(|t| Some(&joints[t.of.joint()?].coordinate)).collect();
        if let (Some(first), false) = (untold.first(), names.is_empty()) {
            let why = "other bodies explain it as well";
            claims.push(cannot_tell(
                at(topic(&first.of), names),
                why,
                "the description, as far as its bodies are right",
            ));
        }
    }
    claims
}

fn topic(of: &Hypothesis) -> Topic {
    match of {
        Hypothesis::Zero(_) => ZERO,
        Hypothesis::Scale(_) => SCALE,
        Hypothesis::Spring(_) => SPRING,
        Hypothesis::Mount(_) => MOUNT,
    }
}

fn is_useful(tested: &Tested) -> bool {
    match tested.of {
        Hypothesis::Zero(_) | Hypothesis::Mount(_) => tested.power < USELESS_ANGLE_RAD,
        Hypothesis::Scale(_) => tested.power < USELESS_SCALE,
        Hypothesis::Spring(_) => tested.power.is_finite(),
    }
}

fn subject(of: &Hypothesis, joints: &[JointResidual]) -> Subject {
    match *of {
        Hypothesis::Mount(axis) => Subject::of(MOUNT, [if axis == 0 { "x" } else { "y" }]),
        Hypothesis::Zero(k) | Hypothesis::Scale(k) | Hypothesis::Spring(k) => at(topic(of), [&joints[k].coordinate]),
    }
}

fn figure(of: &Hypothesis, x: f64, joints: &[JointResidual]) -> Figure {
    match *of {
        Hypothesis::Zero(_) | Hypothesis::Mount(_) => Figure::new(x.to_degrees(), "deg"),
        Hypothesis::Scale(_) => Figure::new(100.0 * x, "%"),
        Hypothesis::Spring(k) => Figure::new(x, if joints[k].unit == Unit::TORQUE { "N m/rad" } else { "N/m" }),
    }
}

/// One claim for those of equal power, the least power first.
fn agree(tested: &[&Tested], joints: &[JointResidual]) -> Vec<Claim> {
    let mut groups: Vec<(Figure, Subject)> = Vec::new();
    for one in tested {
        let (figure, subject) = (shown(figure(&one.of, one.power, joints)), subject(&one.of, joints));
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
    let size = |x: f64| figure(of, x, joints).to_string();
    let off = format!("{} +- {}", size(*value), size(*deviation));
    let at = |k: usize| &joints[k].coordinate;
    match *of {
        Hypothesis::Zero(k) => format!("the zero of {} is off by {off}", at(k)),
        Hypothesis::Scale(k) => format!("the torque of {} is off by {off} beside those of the other joints", at(k)),
        Hypothesis::Spring(k) => format!("a spring of {off} acts on {}", at(k)),
        Hypothesis::Mount(axis) => format!("gravity is tilted by {off} about {} of the base", ["x", "y"][axis]),
    }
}

fn contradicted(tested: &Tested, joints: &[JointResidual]) -> Claim {
    let Tested { of, value, held_out, .. } = tested;
    let at = |k: usize| &joints[k].coordinate;
    let remedy = match *of {
        Hypothesis::Zero(k) => {
            format!("in the file of [options]: transmission: {{offsets: [..]}}, {} for {}", significant(*value), at(k))
        }
        Hypothesis::Scale(k) => format!("look at the gain, the gear ratio or the unit of {}", at(k)),
        Hypothesis::Spring(k) => {
            format!(
                "no model of ours has a spring at a joint: take its torque, {} q, out of {}",
                significant(*value),
                at(k)
            )
        }
        Hypothesis::Mount(_) => "give the description the direction of gravity that the mount has".into(),
    };
    // Tried means: parts of the record were left out and predicted without the fault and with it.
    let trial = match held_out {
        Some((without, with)) => Trial::Tried {
            quantity: "error on parts left out".into(),
            before: Figure::new(100.0 * without, "%"),
            after: Figure::new(100.0 * with, "%"),
        },
        None => Trial::NotTried { why: "it is too small".into() },
    };
    let fault = statement(tested, joints);
    Claim::new(subject(of, joints), Outcome::Contradicted { fault, remedy: Remedy::new("identify", remedy), trial })
}
