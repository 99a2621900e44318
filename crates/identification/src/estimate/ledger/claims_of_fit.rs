//! What a fit leaves open, as claims.

use claims::{Claim, Remedy, Subject};
use linear_model::label::Label;
use linear_model::parameter::{FrictionParameter, ParameterId};

use crate::estimate::artefact::Estimate;
use crate::estimate::digits::{percent, significant};
use crate::estimate::identified::{Identified, Status};
use crate::estimate::ledger::claims_of_prediction::{Prediction, claims_of_prediction, overfitted};
use crate::estimate::topics::{BODIES, FRICTION, LOG, PARAMETERS, RESIDUAL, agrees, cannot_tell, contradicted};

/// Chi^2 per degree of freedom above which the model lacks something. Simulations whose model is right have 1.5 to 2.0,
/// because what a controller does on its encoder repeats in part from period to period. A ripple of 2 % gives 22, joints
/// that bend at 25 Hz give 1190, and torques that are 1.5 ms late give 147 (`tests/benches/misfit.rs`).
pub(crate) const LACKING_MODEL_CHI_SQUARE: f64 = 4.0;
/// Up to this noise explains all.
pub(crate) const NOISE_CHI_SQUARE: f64 = 2.0;

/// Share of the torque that may stay unexplained.
const LARGE_RESIDUAL: f64 = 0.25;

/// Scaled condition number above which errors of the model decide the weakest direction. Estimates of the bench
/// `random_situations` that are right have up to 2831.
const DECIDING_CONDITION_NUMBER: f64 = 3000.0;

/// Friction that is negative by so many deviations drives.
const DRIVING_SIGMAS: f64 = 3.0;

/// What is known of the torques beside the fit.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Beside {
    /// Whether what the log leaves open is open in every motion, so that no torque shows it.
    pub opens_in_any_motion: bool,
    /// Whether the covariance says how unsure torques are: then that says what the weakest direction does to them.
    pub tells_torques: bool,
}

/// The claims of a fit, contradictions first. `total`: the error on the logs that are looked at.
pub(crate) fn claims_of_fit(
    estimate: &Estimate,
    total: Option<f64>,
    prediction: &Prediction,
    beside: Beside,
) -> Vec<Claim> {
    let mut claims = claims_of_prediction(estimate, prediction);
    claims.extend(estimate.refusal.iter().map(|why| earlier(why)));
    claims.extend(friction(estimate));
    let whole = Subject::whole;
    // What speaks against the fit as a whole: its residual, its file, its iteration.
    if let Some(chi) = estimate.chi_square_per_freedom {
        claims.push(match chi > LACKING_MODEL_CHI_SQUARE {
            true => cannot_tell(
                whole(RESIDUAL),
                format!(
                    "the model lacks something: chi^2 per freedom is {chi:.1}, where noise alone gives up to \
                     {NOISE_CHI_SQUARE}"
                ),
                "the effect that the remarks name, as an unknown",
            ),
            false => agrees(whole(RESIDUAL), LACKING_MODEL_CHI_SQUARE, "chi^2 per freedom"),
        });
    }
    claims.extend(
        estimate.doubts.iter().map(|why| cannot_tell(whole(RESIDUAL), why, "a model that has it, or a log without it")),
    );
    if let Some(said) = estimate.seal.said() {
        claims.push(cannot_tell(whole(PARAMETERS), said, "the file as it was written, or a new identification"));
    }
    if estimate.settled == Some(false) {
        let why = "the method did not settle: the values still change from round to round";
        claims.push(cannot_tell(whole(RESIDUAL), why, "a richer motion"));
    }
    if let Some(total) = total.filter(|x| *x > LARGE_RESIDUAL) {
        claims.push(cannot_tell(
            whole(RESIDUAL),
            format!("{} of the torques stay unexplained", percent(total)),
            "the cause: [:doctor] looks for it, [friction=auto] tries other laws",
        ));
    }
    // Which parameters the record does not decide, or decides by little motion.
    if let Some(why) = overfitted(estimate, prediction) {
        claims.push(cannot_tell(whole(PARAMETERS), why, "a longer and richer motion ([:plan])"));
    }
    claims.extend(undecided(estimate, beside));
    let is_deciding = |x: &f64| x.is_finite() && *x > DECIDING_CONDITION_NUMBER && !beside.tells_torques;
    if let Some(condition) = estimate.condition_number.filter(is_deciding) {
        let why = format!("the condition number is {condition:.0}");
        claims.push(cannot_tell(
            whole(PARAMETERS),
            why,
            "a motion that excites the weakest direction ([:excite] [after])",
        ));
    }
    claims
}

/// What was found against the estimate earlier still holds.
fn earlier(why: &str) -> Claim {
    let remedy = Remedy::new("identify", "identify again with what mends it");
    contradicted(Subject::whole(LOG), why.into(), remedy, "the file says no more")
}

/// What the log leaves open or hardly decides.
fn undecided(estimate: &Estimate, beside: Beside) -> Vec<Claim> {
    let mut claims = Vec::new();
    let moved = "a motion of the joints that the remarks name, or bodies to hold them ([consistent=true])";
    let open = named(estimate, Status::NotIdentifiable);
    if !open.is_empty() {
        claims.push(match beside.opens_in_any_motion {
            true => cannot_tell(
                Subject::whole(BODIES),
                format!("no motion tells {open} apart: only their sum shows in a torque"),
                "bodies to hold them ([consistent=true])",
            ),
            false => cannot_tell(Subject::whole(PARAMETERS), format!("the log leaves open {open}"), moved),
        });
    }
    let weak = named(estimate, Status::Weak);
    if !weak.is_empty() {
        claims.push(cannot_tell(Subject::whole(PARAMETERS), format!("little motion decides {weak}"), moved));
    }
    claims
}

/// Friction that drives, of joints with no term beyond the customary ones: beside another law each part may be negative.
fn friction(estimate: &Estimate) -> Vec<Claim> {
    let has_no_other = |joint: &Label| {
        let others = estimate.parameters.iter().filter_map(|p| match &p.id {
            ParameterId::Friction(term, label) if label == joint => Some(*term),
            _ => None,
        });
        others.into_iter().all(is_customary)
    };
    let drives = |p: &&Identified| {
        let is_brake =
            matches!(&p.id, ParameterId::Friction(friction, joint) if friction.brakes() && has_no_other(joint));
        is_brake && p.value.is_some_and(|value| value < -DRIVING_SIGMAS * p.sigma_or_infinity())
    };
    let claim = |p: &Identified| {
        let ParameterId::Friction(_, label) = &p.id else { unreachable!("only friction is looked at") };
        let subject = Subject::of(FRICTION, [label.to_string()]);
        let (value, sigma) = (p.value.unwrap_or(0.0), p.sigma_or_infinity());
        cannot_tell(
            subject,
            format!("{} is {} +- {}, and friction cannot drive", p.id, significant(value), significant(sigma)),
            "the sign, the unit and the saturation of that joint's torque, or another law of friction ([friction=auto])",
        )
    };
    estimate.parameters.iter().filter(drives).map(claim).collect()
}

/// Whether it is viscous or Coulomb friction or an offset, of both directions or of one.
fn is_customary(term: FrictionParameter) -> bool {
    use FrictionParameter::*;
    matches!(term, Viscous | Coulomb | Offset | ViscousForward | CoulombForward | ViscousBackward | CoulombBackward)
}

/// The parameters of a status, at most three by name.
fn named(estimate: &Estimate, status: Status) -> String {
    let all: Vec<String> =
        estimate.parameters.iter().filter(|p| p.status == status).map(|p| p.id.to_string()).collect();
    match all.len() {
        0..=3 => all.join(", "),
        n => format!("{} and {} more", all[..3].join(", "), n - 3),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_condition_number_counts_where_no_covariance_does() {
        let estimate = Estimate { condition_number: Some(1e4), ..Estimate::default() };
        for tells_torques in [false, true] {
            let beside = Beside { opens_in_any_motion: false, tells_torques };
            let claims = claims_of_fit(&estimate, None, &Prediction::default(), beside);
            assert_eq!(claims.iter().any(|claim| claim.subject().topic == PARAMETERS), !tells_torques);
        }
    }

    #[test]
    fn what_no_motion_tells_is_open_for_bodies_alone() {
        let open = Identified::unidentifiable("MX3".parse().unwrap(), linear_model::unit::Unit::FIRST_MOMENT, 1.0);
        let estimate = Estimate { parameters: vec![open], ..Estimate::default() };
        for in_any_motion in [false, true] {
            let beside = Beside { opens_in_any_motion: in_any_motion, tells_torques: false };
            let claims = claims_of_fit(&estimate, None, &Prediction::default(), beside);
            let about = |topic| claims.iter().filter(|claim| claim.subject().topic == topic).count();
            assert_eq!((about(PARAMETERS), about(BODIES)), if in_any_motion { (0, 1) } else { (1, 0) });
        }
    }
}
