//! Recognises normalised positions, which libraries of hobby arms log: positions in per cent of half the joint range, from
//! -100 to 100, or of the whole range, from 0 to 100.
//!
//! With l and u the limits of a joint, and x the position of the log,
//! ```text
//! q = (l + u) / 2 + x (u - l) / 200      from -100
//! q = l + x (u - l) / 100                from 0
//! ```
//! In the options of the transmission, this equation is a ratio, 200 / (u - l) or 100 / (u - l), and an offset. The ratio
//! would also change the torques. The logged torques are already joint torques, so `scales` cancel this change.

use identification::estimate::log_check::finding::{Fault, Finding};
use identification::estimate::log_check::{AS_WELL_RATIO, LogCheck};
use identification::estimate::options::Options;

use crate::describe::model::Model;
use crate::error::Error;

/// Largest range of a normalised position in a log, per cent, with an allowance for rounding.
const LARGEST_NORMALISED_RANGE: f64 = 200.5;
/// Largest range of a joint in SI units, rad (m). A larger range indicates another unit.
const LARGEST_RANGE_RAD_M: f64 = 12.6;

/// Options that convert normalised positions (`from` to 100, with `from` -100 or 0) into SI units. `None` if a joint has no
/// limits, or if ratios, offsets or scales are given.
fn options_of_shares(model: &Model, options: &Options, from: i32) -> Option<Options> {
    let limits: Option<Vec<(f64, f64)>> = model.robot.coordinates.iter().map(|c| c.limits.position).collect();
    let limits = limits.filter(|all| all.iter().all(|(low, high)| high > low && (high - low).is_finite()))?;
    let mut options = options.clone();
    let transmission = &mut options.transmission;
    if transmission.ratios.is_some() || transmission.offsets.is_some() || transmission.scales.is_some() {
        return None;
    }
    let ratios: Vec<f64> = limits.iter().map(|(low, high)| f64::from(100 - from) / (high - low)).collect();
    let zero = |(low, high): &(f64, f64)| if from == 0 { *low } else { 0.5 * (low + high) };
    transmission.offsets = Some(limits.iter().map(zero).collect());
    transmission.scales = Some(ratios.clone());
    transmission.ratios = Some(ratios);
    Some(options)
}

/// Replaces the findings of a log check by "positions are normalised", if this explains the log. `again`: checks the log with
/// other options.
///
/// Fails if a log cannot be read.
pub(super) fn look_for_shares(
    model: &Model,
    options: &Options,
    log_check: &mut LogCheck,
    again: impl Fn(&Options) -> Result<LogCheck, Error>,
) -> Result<(), Error> {
    let is_far = log_check.joints.iter().any(|joint| joint.range > LARGEST_RANGE_RAD_M);
    if !is_far || !log_check.is_gross() || log_check.joints.iter().any(|joint| joint.range > LARGEST_NORMALISED_RANGE) {
        return Ok(());
    }
    let mut best: Option<(i32, Options, LogCheck)> = None;
    for from in [-100, 0] {
        let Some(shares) = options_of_shares(model, options, from) else { return Ok(()) };
        let found = again(&shares)?;
        let is_better = best.as_ref().is_none_or(|(_, _, best)| found.unexplained() < best.unexplained());
        if is_better && !found.is_gross() {
            best = Some((from, shares, found));
        }
    }
    let Some((from, shares, found)) = best else { return Ok(()) };
    let left = [log_check.unexplained(), found.unexplained()];
    let others = log_check.findings.iter().filter_map(|f| f.tried).map(|tried| tried[1]).reduce(f64::min);
    if others.is_some_and(|other| other * AS_WELL_RATIO < left[1]) {
        return Ok(());
    }
    let remedy = shares.remedy_added_to(options).unwrap_or_default();
    let evidence = "so the limits of the description make radians and metres of them".into();
    let finding = Finding { tried: Some(left), ..Finding::of(Fault::Normalised(from), Vec::new(), evidence, remedy) };
    // Findings that are not gross (they allow an estimate) are in the new check again. Findings that other bodies also explain
    // are dropped, since they would need another check.
    let explanation = std::iter::once(finding).chain(found.findings).collect();
    match others.is_some_and(|other| other < AS_WELL_RATIO * left[1]) {
        true => log_check.put_before(explanation),
        false => {
            log_check.findings = explanation;
            log_check.explained.clear();
        }
    }
    Ok(())
}
