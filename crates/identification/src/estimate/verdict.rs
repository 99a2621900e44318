//! The verdict on an identification or a validation, in three sentences.
//!
//! They say what was found, whether to trust it and why, and what to do next.
//!
//! The answer is no where a number says so by itself. Such a number is a gross finding of the passport, an error of
//! half of the torques or more where nothing was fitted, bodies that fit far worse than free parameters, or masses that
//! are all off by one factor. The answer is with care where a number is doubtful, and yes otherwise.

use std::fmt;

use crate::estimate::artefact::Estimate;
use crate::estimate::autocorrelation::NOISE_MEMORY_PERIODS;
use crate::estimate::identified::Status;
use crate::estimate::passport::Passport;
use crate::estimate::passport::significant;

/// Whether to use what was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Trust {
    /// Nothing speaks against it.
    Yes,
    /// A number is doubtful.
    WithCare,
    /// A number says no.
    No,
}

impl Trust {
    /// The answer in words.
    pub fn word(self) -> &'static str {
        match self {
            Trust::Yes => "yes",
            Trust::WithCare => "with care",
            Trust::No => "no",
        }
    }
}

/// The verdict, the last three lines of a report.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// The answer.
    pub trust: Trust,
    /// What was found, beside the error of the description.
    pub found: String,
    /// Why, the weightiest reason first.
    pub reasons: Vec<String>,
    /// What to do now.
    pub next: String,
}

/// The consistent bodies beside the description.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BodiesEvidence {
    /// Why they are not to be used; `None` where the solver found them and they fit.
    pub refusal: Option<String>,
    /// Identified over described mass of each body that has one.
    pub mass_ratios: Vec<f64>,
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
    /// The same for the identified parameters, on the fitted logs or on those that are validated.
    pub total: f64,
    /// The error on parts of the fitted logs, each predicted from the others.
    pub held_out: Option<f64>,
    /// The error on logs that were not fitted.
    pub predicted: Option<f64>,
    /// The bodies, where only bodies that can exist were asked for.
    pub bodies: Option<&'a BodiesEvidence>,
}

/// Chi^2 per degree of freedom above which the model lacks something. Simulations whose model is right have 0.3 to 0.7,
/// because the scatter between periods holds the chatter of the controller too. A ripple of 2 % gives 2.8, joints that
/// bend at 25 Hz give 950, and torques that are 1.5 ms late give 32 (`tests/tests/identification/misfit.rs`).
pub const LACKING_MODEL_CHI_SQUARE: f64 = 2.0;

/// Error on data that were not fitted above which parameters predict nothing.
const USELESS_PREDICTION_ERROR: f64 = 0.5;
/// Error on data that were not fitted above which parameters predict poorly. Measured robots reach 0.13.
const POOR_PREDICTION_ERROR: f64 = 0.25;

/// Held-out error over in-sample error above which the fit holds for its own log only.
const OVERFITTED_ERROR_RATIO: f64 = 2.0;
/// Held-out errors below this are small enough whatever that ratio.
const SMALL_HELD_OUT_ERROR: f64 = 0.02;

/// All masses are off by one factor where their median ratio is beyond this and the others are near it.
const LARGE_MASS_FACTOR: f64 = 2.5;
/// Ratios of masses within this factor of their median are near it.
const COMMON_FACTOR_SPREAD: f64 = 1.6;

/// Scaled condition number above which errors of the model decide the weakest direction.
const DECIDING_CONDITION_NUMBER: f64 = 1000.0;

impl Verdict {
    /// Weighs the evidence.
    pub fn of(evidence: &Evidence) -> Verdict {
        let no = against(evidence);
        let care = doubts(evidence);
        let (trust, reasons) = match (no.is_empty(), care.is_empty()) {
            (false, _) => (Trust::No, no),
            (true, false) => (Trust::WithCare, care),
            (true, true) => (Trust::Yes, favours(evidence)),
        };
        let reasons = match trust {
            Trust::No => reasons,
            _ => {
                reasons.into_iter().chain(untold_apart(evidence.estimate)).chain(not_noise(evidence.estimate)).collect()
            }
        };
        Verdict { trust, found: found(evidence), next: next(evidence, trust), reasons }
    }
}

/// Reasons that forbid the use of the estimate.
fn against(evidence: &Evidence) -> Vec<String> {
    let gross = evidence.passport.into_iter().flat_map(|p| &p.findings).filter(|f| f.fault.is_gross());
    let mut reasons: Vec<String> = gross.map(|f| f.statement()).collect();
    // What was found against the estimate earlier still holds.
    let earlier: Vec<String> = evidence.estimate.refusal.iter().filter(|r| !reasons.contains(r)).cloned().collect();
    reasons.extend(earlier);
    let errors =
        [("logs that were not fitted are", evidence.predicted), ("parts of the log left out are", evidence.held_out)];
    for (what, error) in errors {
        if let Some(error) = error.filter(|e| *e >= USELESS_PREDICTION_ERROR) {
            reasons.push(format!("{what} predicted with an error of {}", percent(error)));
        }
    }
    let Some(bodies) = evidence.bodies else { return reasons };
    reasons.extend(bodies.refusal.clone());
    if let Some(factor) = common_factor(&bodies.mass_ratios) {
        reasons.push(format!(
            "all masses are about {factor:.2} times those of the description: a unit or a gain is wrong"
        ));
    }
    reasons
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

fn doubts(evidence: &Evidence) -> Vec<String> {
    let estimate = evidence.estimate;
    let mut reasons: Vec<String> =
        evidence.passport.into_iter().flat_map(|p| &p.findings).map(|f| f.statement()).collect();
    if let Some(chi) = estimate.chi_square_per_freedom.filter(|chi| *chi > LACKING_MODEL_CHI_SQUARE) {
        reasons.push(format!(
            "the model lacks something: chi^2 per freedom is {chi:.1}, where noise alone gives less than 1"
        ));
    }
    if estimate.settled == Some(false) {
        reasons.push("the method did not settle: the values still change from round to round".into());
    }
    let held_out = evidence.predicted.or(evidence.held_out);
    if let Some(error) = held_out.filter(|e| *e > POOR_PREDICTION_ERROR) {
        reasons.push(format!("data that were not fitted are predicted with an error of {}", percent(error)));
    } else if let Some(error) = held_out
        .filter(|e| *e > SMALL_HELD_OUT_ERROR && estimate.total > 0.0 && *e > OVERFITTED_ERROR_RATIO * estimate.total)
    {
        reasons.push(format!(
            "data that were not fitted are predicted with {}, those that were with {}: the log is too short or too poor \
             for so many parameters",
            percent(error),
            percent(estimate.total)
        ));
    } else if evidence.total > POOR_PREDICTION_ERROR {
        reasons.push(format!("{} of the torques stay unexplained", percent(evidence.total)));
    }
    let open = named(estimate, Status::NotIdentifiable);
    if !open.is_empty() {
        reasons.push(format!("the log leaves open {open}"));
    }
    let weak = named(estimate, Status::Weak);
    if !weak.is_empty() {
        reasons.push(format!("little motion decides {weak}"));
    }
    if estimate.condition_number.is_finite() && estimate.condition_number > DECIDING_CONDITION_NUMBER {
        reasons.push(format!("the condition number is {:.0}", estimate.condition_number));
    }
    reasons
}

/// A residual whose memory is more than this many times that of noise is worth a sentence.
const LONG_MEMORY_RATIO: f64 = 2.0;

/// What the autocorrelation of the residual says, for the joint with the longest memory.
fn not_noise(estimate: &Estimate) -> Option<String> {
    let times = |memory: f64| memory * estimate.cutoff / NOISE_MEMORY_PERIODS;
    let known = estimate.joints.iter().filter_map(|joint| Some((joint, joint.memory?)));
    let (joint, memory) = known.max_by(|a, b| a.1.total_cmp(&b.1)).filter(|_| estimate.cutoff > 0.0)?;
    let name = &joint.coordinate;
    Some(match times(memory) > LONG_MEMORY_RATIO {
        true => format!(
            "what is left at {name} is not noise alone: it stays alike for {} s, {:.0} times as long as noise does, so friction or \
             flexibility is missing",
            significant(memory),
            times(memory)
        ),
        false => "what is left looks like noise".into(),
    })
}

/// The weakest combination that the noise hides.
fn untold_apart(estimate: &Estimate) -> Option<String> {
    let open = estimate.directions.iter().find(|d| d.open && d.strength > 0.0 && d.members.len() > 1);
    open.map(|direction| direction.sentence())
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

fn favours(evidence: &Evidence) -> Vec<String> {
    let estimate = evidence.estimate;
    let mut reasons = Vec::new();
    if let Some(error) = evidence.predicted {
        reasons.push(format!("logs that were not fitted are predicted with {}", percent(error)));
    } else if let Some(error) = evidence.held_out {
        let of = percent(estimate.total);
        reasons.push(format!("parts left out are predicted with {}, those fitted with {of}", percent(error)));
    } else {
        reasons.push(format!(
            "{} are left of what was fitted, and nothing else was predicted yet",
            percent(estimate.total)
        ));
    }
    if let Some(chi) = estimate.chi_square_per_freedom {
        reasons.push(format!("chi^2 per freedom {chi:.1}"));
    }
    if estimate.condition_number.is_finite() && estimate.condition_number > 0.0 {
        reasons.push(format!("condition number {:.0}", estimate.condition_number));
    }
    match evidence.passport {
        Some(passport) if passport.untold.is_empty() => {
            reasons.push("log and description agree in signs, units, zeros and columns".into());
        }
        Some(passport) => reasons.push(passport.untold.join("; ")),
        None => {}
    }
    reasons
}

fn found(evidence: &Evidence) -> String {
    let estimate = evidence.estimate;
    let known = estimate.parameters.iter().filter(|p| p.value.is_some()).count();
    let parameters = format!("{known} of {} parameters", estimate.parameters.len());
    match evidence.described {
        Some(described) => format!(
            "{parameters}; your description predicts this log with {}, the identified parameters with {} (friction fitted \
             in both)",
            percent(described),
            percent(evidence.total)
        ),
        None if evidence.total > 0.0 => {
            format!("{parameters}; they leave {} of the torques unexplained", percent(evidence.total))
        }
        None => parameters,
    }
}

fn next(evidence: &Evidence, trust: Trust) -> String {
    let finding = evidence.passport.and_then(|p| p.findings.first());
    if let Some(finding) = finding {
        return finding.remedy.clone();
    }
    let is_open = |status: Status| matches!(status, Status::NotIdentifiable | Status::Weak);
    let open = evidence.estimate.parameters.iter().any(|p| is_open(p.status));
    match trust {
        Trust::No => {
            "rist doctor says what the log and the description have to do with each other; [delay=auto] looks for late \
             torques"
                .into()
        }
        Trust::WithCare if open => {
            "move the joints that the remarks name, or hold the rest by bodies ([consistent=true])".into()
        }
        Trust::WithCare => "log a longer and richer motion (rist plan), or try [friction=auto]".into(),
        Trust::Yes if evidence.predicted.is_none() => {
            "predict a log that was not fitted: rist validate MODEL ESTIMATE LOG".into()
        }
        Trust::Yes if evidence.estimate.options.is_none() => {
            "use it (rist report draws it, rist simulate [feedforward] tries it)".into()
        }
        Trust::Yes => {
            "use it (rist identify [write_urdf] or [write_mjcf] for simulators, rist generate [estimate] for code)"
                .into()
        }
    }
}

/// `0.53 %`, with digits that count.
fn percent(x: f64) -> String {
    let x = 100.0 * x;
    if x >= 10.0 { format!("{x:.1} %") } else { format!("{x:.2} %") }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "found: {}", self.found)?;
        writeln!(f, "trust: {}: {}", self.trust.word(), self.reasons.join("; "))?;
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

    #[test]
    fn digits_that_count() {
        assert_eq!((percent(0.00532), percent(0.145)), ("0.53 %".into(), "14.5 %".into()));
    }
}
