//! Makes claims (statements with their evidence) on a fit: on its residual, its friction, and parameters that the data do not
//! determine.
//!
//! tau: measured torques; W: regressor; X: parameters. RIST-MH is the method for experiments of a plan (`spectrum::rist_mh`);
//! its chi^2 is the sum of the squared residuals, each divided by the variance of the measured noise.

use claims::{Claim, Remedy, Subject};
use linear_model::label::Label;
use linear_model::parameter::{FrictionParameter, ParameterId};

use crate::estimate::artefact::Estimate;
use crate::estimate::claims::claims_of_prediction::{Prediction, claims_of_prediction, overfitted};
use crate::estimate::digits::{percent, significant};
use crate::estimate::identified::{Identified, Status};
use crate::estimate::topics::{BODIES, FRICTION, LOG, PARAMETERS, RESIDUAL, agrees, cannot_tell, contradicted};

/// The model lacks an effect if chi^2 per degree of freedom exceeds this value. An exact model has 1.5 to 2.0 in simulation; 2
/// % of torque ripple gives 22, a delay of 1.5 ms gives 147, elastic joints (25 Hz) give 1190 (`tests/benches/misfit.rs`).
pub(crate) const LACKING_MODEL_CHI_SQUARE: f64 = 4.0;
/// Largest chi^2 per degree of freedom that noise alone gives. This value exceeds 1, because a controller reacts to the errors
/// of its encoder, and this reaction partly repeats in each period.
pub(crate) const NOISE_CHI_SQUARE: f64 = 2.0;

/// The residual lowers the trust if |tau - W X| / |tau| exceeds this value.
const LARGE_RELATIVE_RESIDUAL: f64 = 0.25;

/// Above this condition number (columns scaled), model errors dominate the weakest combination of parameters. Correct estimates
/// of the benchmark `random_situations` have condition numbers up to 2831.
const DECIDING_CONDITION_NUMBER: f64 = 3000.0;

/// Friction is significantly negative (it would drive the joint) if a parameter is below minus this many standard deviations.
const NEGATIVE_FRICTION_SIGMAS: f64 = 3.0;

/// Properties of the predicted torques that influence the claims on a fit.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct TorqueContext {
    /// Whether no motion at all could identify the parameters that the logs do not determine. Then torques depend only on sums
    /// of these parameters.
    pub opens_in_any_motion: bool,
    /// Whether errors of predicted torques were computed from the covariance. Such errors include the uncertainty of the
    /// weakest combination of parameters. So no claim is made on the condition number then.
    pub determines_torques: bool,
}

/// The claims on a fit, in this order: prediction, reasons of an earlier verdict, friction, residual, parameters. `total`:
/// relative error on the fitted or validated logs.
pub(crate) fn claims_of_fit(
    estimate: &Estimate,
    total: Option<f64>,
    prediction: &Prediction,
    beside: TorqueContext,
) -> Vec<Claim> {
    let mut claims = claims_of_prediction(estimate, prediction);
    claims.extend(estimate.refusal.iter().map(|why| earlier(why)));
    claims.extend(friction(estimate));
    let whole = Subject::whole;
    // Evidence against the whole fit: residual, checksum of the file, convergence.
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
    if let Some(said) = estimate.checksum.said() {
        claims.push(cannot_tell(whole(PARAMETERS), said, "the file as it was written, or a new identification"));
    }
    if estimate.settled == Some(false) {
        let why = "the method did not settle: the values still change from round to round";
        claims.push(cannot_tell(whole(RESIDUAL), why, "a richer motion"));
    }
    if let Some(total) = total.filter(|x| *x > LARGE_RELATIVE_RESIDUAL) {
        claims.push(cannot_tell(
            whole(RESIDUAL),
            format!("{} of the torques stay unexplained", percent(total)),
            "the cause: [:doctor] looks for it, [friction=auto] tries other laws",
        ));
    }
    // Evidence against the parameters: overfitted, not determined by the logs, determined by little motion only,
    // ill-conditioned.
    if let Some(why) = overfitted(estimate, prediction) {
        claims.push(cannot_tell(whole(PARAMETERS), why, "a longer and richer motion ([:plan])"));
    }
    claims.extend(undecided(estimate, beside));
    let is_deciding = |x: &f64| x.is_finite() && *x > DECIDING_CONDITION_NUMBER && !beside.determines_torques;
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

/// The claim that repeats a reason against the estimate. The reason is from an earlier verdict and was read from the file of the
/// estimate.
fn earlier(why: &str) -> Claim {
    let remedy = Remedy::new("identify", "identify again with what mends it");
    contradicted(Subject::whole(LOG), why.into(), remedy, "the file says no more")
}

/// Claims on parameters that the logs do not determine, and on parameters that are determined by little motion only.
fn undecided(estimate: &Estimate, beside: TorqueContext) -> Vec<Claim> {
    let mut claims = Vec::new();
    let moved = "a motion of the joints that the remarks name, or bodies to hold them ([consistent=true])";
    let open = named(estimate, Status::NotIdentifiable);
    if !open.is_empty() {
        claims.push(match beside.opens_in_any_motion {
            true => cannot_tell(
                Subject::whole(BODIES),
                format!("no motion separates {open}: only their sum acts on a torque"),
                "bodies to hold them ([consistent=true])",
            ),
            false => cannot_tell(Subject::whole(PARAMETERS), format!("the log does not identify {open}"), moved),
        });
    }
    let weak = named(estimate, Status::Weak);
    if !weak.is_empty() {
        claims.push(cannot_tell(Subject::whole(PARAMETERS), format!("little motion decides {weak}"), moved));
    }
    claims
}

/// Claims on significantly negative friction. A joint is examined only if all friction terms of the joint are viscous, Coulomb
/// or offset, because a single term of another friction law may be negative.
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
        is_brake && p.value.is_some_and(|value| value < -NEGATIVE_FRICTION_SIGMAS * p.sigma_or_infinity())
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

/// Whether a friction term is viscous, Coulomb or an offset. The term may apply to both directions of motion or to one
/// direction.
fn is_customary(term: FrictionParameter) -> bool {
    use FrictionParameter::*;
    matches!(term, Viscous | Coulomb | Offset | ViscousForward | CoulombForward | ViscousBackward | CoulombBackward)
}

/// The names of the parameters with this status: at most three names, then the number of the other parameters.
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
            let beside = TorqueContext { opens_in_any_motion: false, determines_torques: tells_torques };
            let claims = claims_of_fit(&estimate, None, &Prediction::default(), beside);
            assert_eq!(claims.iter().any(|claim| claim.subject().topic == PARAMETERS), !tells_torques);
        }
    }

    #[test]
    fn what_no_motion_tells_is_open_for_bodies_alone() {
        let open = Identified::unidentifiable("MX3".parse().unwrap(), linear_model::unit::Unit::FIRST_MOMENT, 1.0);
        let estimate = Estimate { parameters: vec![open], ..Estimate::default() };
        for in_any_motion in [false, true] {
            let beside = TorqueContext { opens_in_any_motion: in_any_motion, determines_torques: false };
            let claims = claims_of_fit(&estimate, None, &Prediction::default(), beside);
            let about = |topic| claims.iter().filter(|claim| claim.subject().topic == topic).count();
            assert_eq!((about(PARAMETERS), about(BODIES)), if in_any_motion { (0, 1) } else { (1, 0) });
        }
    }
}
