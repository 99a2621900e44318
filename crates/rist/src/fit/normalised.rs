//! Recognises positions in another form than rad and m by the limits of the description: normalised positions, which libraries
//! of hobby arms log, and mm.
//!
//! With l and u the limits of a joint, and x a position of the log that is normalised from a to b,
//! ```text
//! q = l + (x - a) (u - l) / (b - a)      a, b: -100, 100; 0, 100; -1, 1; 0, 1 (often the gripper alone)
//! q = x / 1000                           mm
//! ```
//! In the options of the transmission, this equation is a ratio, (b - a) / (u - l) or 1000, and an offset. The ratio would also
//! change the torques. The logged torques are already joint torques, so `scales` cancel this change.

use identification::estimate::log_check::finding::{Fault, Finding};
use identification::estimate::log_check::{AS_WELL_RATIO, LogCheck};
use identification::estimate::options::Options;

use crate::describe::model::Model;
use crate::error::Error;

/// The forms that are tried: normalised positions from and to, and mm. If several forms explain a log, the first one is the
/// simplest: the positions then use most of its range.
const FORMS: [Fault; 5] = [
    Fault::Normalised(0, 1),
    Fault::Normalised(-1, 1),
    Fault::Normalised(0, 100),
    Fault::Normalised(-100, 100),
    Fault::Millimetres,
];
/// A position is beyond the limits if it exceeds them by this share of the range between them. Limits of descriptions are often
/// a little too narrow.
const BEYOND_SHARE: f64 = 0.2;
/// One joint at least must move over this share of its range in a form. With smaller motions, the torques are those of a joint at
/// rest, which no form contradicts.
const LEAST_USED_SHARE: f64 = 0.05;
/// A normalised position may exceed its form by this share of the range, for rounding.
const ROUNDING_SHARE: f64 = 0.0025;

/// How far a joint exceeds limits, as a share of the range between them.
fn excess((low, high): (f64, f64), (least, most): (f64, f64)) -> f64 {
    (low - least).max(most - high) / (high - low)
}

/// Ratio and offset that convert a form into SI units: q = x / ratio + offset. `None` if the log has positions outside of the
/// form.
fn conversion(form: Fault, limits: (f64, f64), positions: (f64, f64), is_prismatic: bool) -> Option<(f64, f64)> {
    let (ratio, offset) = match form {
        Fault::Normalised(from, to) => {
            let ratio = f64::from(to - from) / (limits.1 - limits.0);
            (ratio, limits.0 - f64::from(from) / ratio)
        }
        _ if !is_prismatic => return None,
        _ => (1e3, 0.0),
    };
    let allowed = if form == Fault::Millimetres { BEYOND_SHARE } else { ROUNDING_SHARE };
    let converted = (positions.0 / ratio + offset, positions.1 / ratio + offset);
    (excess(limits, converted) <= allowed).then_some((ratio, offset))
}

/// Options that convert the positions of these joints from a form into SI units. `None` if a joint has no limits or positions
/// outside of the form, or if ratios, offsets or scales are given.
fn converting(
    model: &Model,
    options: &Options,
    log_check: &LogCheck,
    (form, joints): (Fault, &[usize]),
) -> Option<Options> {
    let mut options = options.clone();
    let transmission = &mut options.transmission;
    if transmission.ratios.is_some() || transmission.offsets.is_some() || transmission.scales.is_some() {
        return None;
    }
    let n = log_check.joints.len();
    let (mut ratios, mut offsets) = (vec![1.0; n], vec![0.0; n]);
    let mut used = 0.0_f64;
    for &k in joints {
        let limits = limits_of(model, k)?;
        let is_prismatic = model.regressor().is_prismatic(k);
        (ratios[k], offsets[k]) = conversion(form, limits, log_check.joints[k].positions, is_prismatic)?;
        used = used.max(log_check.joints[k].range() / ratios[k] / (limits.1 - limits.0));
    }
    if used < LEAST_USED_SHARE {
        return None;
    }
    (transmission.offsets, transmission.scales, transmission.ratios) =
        (Some(offsets), Some(ratios.clone()), Some(ratios));
    Some(options)
}

/// The limits of a coordinate, if they are finite and in order.
fn limits_of(model: &Model, k: usize) -> Option<(f64, f64)> {
    model.robot.coordinates[k].limits.position.filter(|(low, high)| high > low && (high - low).is_finite())
}

/// A form of the positions of some joints, the options that convert it, and the log check with these options.
struct Tried {
    form: Fault,
    joints: Vec<usize>,
    options: Options,
    found: LogCheck,
    /// Whether mm explain the log as well, and their options.
    or_millimetres: Option<Options>,
}

/// The first form with which the description explains the log, without a gross finding, as well as with any other form; `None`
/// if there is no such form. All joints are tried first. The joints `beyond` their limits alone must explain the log clearly
/// better than all joints.
fn best_form(
    model: &Model,
    options: &Options,
    log_check: &LogCheck,
    beyond: &[usize],
    again: impl Fn(&Options) -> Result<LogCheck, Error>,
) -> Result<Option<Tried>, Error> {
    let n = log_check.joints.len();
    let mut best: Option<Tried> = None;
    for joints in [(0..n).collect(), beyond.to_vec()] {
        let mut tried = Vec::new();
        for form in FORMS {
            let Some(options) = converting(model, options, log_check, (form, &joints)) else { continue };
            let found = again(&options)?;
            if !found.is_gross() {
                tried.push(Tried { form, joints: joints.clone(), options, found, or_millimetres: None });
            }
        }
        let misfit = |tried: &Tried| tried.found.unexplained();
        let least = tried.iter().map(misfit).fold(f64::INFINITY, f64::min);
        let is_better = best.as_ref().is_none_or(|best| least < misfit(best) / AS_WELL_RATIO);
        tried.retain(|tried| misfit(tried) <= AS_WELL_RATIO * least);
        // mm are the last form.
        let or_millimetres = tried.pop_if(|last| last.form == Fault::Millimetres);
        let or_millimetres = match tried.first_mut() {
            Some(first) => {
                first.or_millimetres = or_millimetres.map(|other| other.options);
                None
            }
            None => or_millimetres,
        };
        let first = tried.into_iter().next().or(or_millimetres);
        best = if is_better { first.or(best) } else { best };
        if beyond.len() == n {
            break;
        }
    }
    Ok(best)
}

/// Replaces the findings of a log check by "positions are normalised" or "in mm", if positions are beyond the limits and this
/// explains the log. If the torques do not show the form, adds the finding that the positions are beyond the limits. `again`:
/// checks the log with other options.
///
/// Fails if a log cannot be read.
pub(super) fn look_for_shares(
    model: &Model,
    options: &Options,
    log_check: &mut LogCheck,
    again: impl Fn(&Options) -> Result<LogCheck, Error>,
) -> Result<(), Error> {
    let n = log_check.joints.len();
    let is_beyond = |k: &usize| {
        limits_of(model, *k).is_some_and(|limits| excess(limits, log_check.joints[*k].positions) > BEYOND_SHARE)
    };
    let beyond: Vec<usize> = (0..n).filter(is_beyond).collect();
    if beyond.is_empty() {
        return Ok(());
    }
    let best = best_form(model, options, log_check, &beyond, again)?;
    // Without a contradiction in the torques, a form must explain them clearly better.
    let needed = if log_check.is_gross() { f64::INFINITY } else { log_check.unexplained() / AS_WELL_RATIO };
    let Some(Tried { form, joints, options: shares, found, or_millimetres }) =
        best.filter(|t| t.found.unexplained() < needed)
    else {
        if !log_check.is_gross() {
            let found: Vec<Finding> = beyond.iter().map(|&k| beyond_limits(model, log_check, k)).collect();
            log_check.findings.extend(found);
        }
        return Ok(());
    };
    let left = [log_check.unexplained(), found.unexplained()];
    let others = log_check.findings.iter().filter_map(|f| f.tried).map(|tried| tried[1]).reduce(f64::min);
    if others.is_some_and(|other| other * AS_WELL_RATIO < left[1]) {
        return Ok(());
    }
    let remedy = shares.remedy_added_to(options).unwrap_or_default();
    let evidence = match form {
        Fault::Millimetres => "in m they would be far beyond the limits of the description".into(),
        _ => "so the limits of the description make radians and metres of them".into(),
    };
    let names = |joints: &[usize]| joints.iter().map(|&k| log_check.joints[k].coordinate.clone()).collect();
    let named = if joints.len() == n { Vec::new() } else { names(&joints) };
    let finding = Finding { tried: Some(left), ..Finding::of(form, named.clone(), evidence, remedy) };
    let other = or_millimetres.map(|other| {
        let remedy = other.remedy_added_to(options).unwrap_or_default();
        Finding { instead: 1, ..Finding::of(Fault::Millimetres, named, "the torques do not show which".into(), remedy) }
    });
    // Findings that are not gross (they allow an estimate) are in the new check again. Findings that other bodies also explain
    // are dropped, since they would need another check.
    let explanation = std::iter::once(finding).chain(found.findings).chain(other).collect();
    match others.is_some_and(|other| other < AS_WELL_RATIO * left[1]) {
        true => log_check.put_before(explanation),
        false => {
            log_check.findings = explanation;
            log_check.explained.clear();
        }
    }
    Ok(())
}

/// The finding that the positions of joint k are beyond the limits of the description, and the torques do not show why.
fn beyond_limits(model: &Model, log_check: &LogCheck, k: usize) -> Finding {
    let joint = &log_check.joints[k];
    let unit = if model.regressor().is_prismatic(k) { "m" } else { "rad" };
    let (low, high) = limits_of(model, k).unwrap_or_default();
    let evidence =
        format!("the description has limits of {low} and {high} {unit}; the torques do not show which is wrong");
    let remedy = format!(
        "correct the limits, or give the unit of this position in the header ({}_deg, _mm), or, if it is normalised, ratios, \
         offsets and scales of `transmission`",
        joint.coordinate
    );
    Finding::of(
        Fault::BeyondLimits(joint.positions.0, joint.positions.1),
        vec![joint.coordinate.clone()],
        evidence,
        remedy,
    )
}
