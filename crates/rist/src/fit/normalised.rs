//! Positions that are shares of the range of each joint, -100 to 100, as libraries of hobby arms log them.
//!
//! With l and u the limits of a joint, and x the position of the log,
//! ```text
//! q = (l + u) / 2 + x (u - l) / 200
//! ```
//! which is a ratio 200 / (u - l) with an offset; the torque is that of the joint, so the ratio is taken out of it again.

use identification::estimate::options::Options;
use identification::estimate::passport::finding::{Fault, Finding};
use identification::estimate::passport::{AS_WELL_RATIO, Passport};

use crate::describe::model::Model;
use crate::error::Error;

/// Widest motion of a normalised joint, with a rounding.
const WIDEST: f64 = 200.5;
/// No joint turns or slides so far, rad (m): what does is in another unit.
const FAR: f64 = 12.6;

/// The options under which positions are shares of the ranges; `None` where some joint has no limits, or ratios are known.
fn options_of_shares(model: &Model, options: &Options) -> Option<Options> {
    let limits: Option<Vec<(f64, f64)>> = model.robot.coordinates.iter().map(|c| c.limits.position).collect();
    let limits = limits.filter(|all| all.iter().all(|(low, high)| high > low && (high - low).is_finite()))?;
    let mut options = options.clone();
    let transmission = &mut options.transmission;
    if transmission.ratios.is_some() || transmission.offsets.is_some() || transmission.scales.is_some() {
        return None;
    }
    let ratios: Vec<f64> = limits.iter().map(|(low, high)| 200.0 / (high - low)).collect();
    transmission.offsets = Some(limits.iter().map(|(low, high)| 0.5 * (low + high)).collect());
    transmission.scales = Some(ratios.clone());
    transmission.ratios = Some(ratios);
    Some(options)
}

/// Puts normalised positions in the place of what was found, where the log is mended by them. `again` looks at the log with
/// other options.
///
/// Fails where a log cannot be read.
pub(super) fn look_for_shares(
    model: &Model,
    options: &Options,
    passport: &mut Passport,
    again: impl FnOnce(&Options) -> Result<Passport, Error>,
) -> Result<(), Error> {
    let is_far = passport.joints.iter().any(|joint| joint.range > FAR);
    if !is_far || !passport.is_gross() || passport.joints.iter().any(|joint| joint.range > WIDEST) {
        return Ok(());
    }
    let Some(shares) = options_of_shares(model, options) else { return Ok(()) };
    let found = again(&shares)?;
    if found.is_gross() {
        return Ok(());
    }
    let left = [passport.unexplained(), found.unexplained()];
    let others = passport.findings.iter().filter_map(|f| f.tried).map(|tried| tried[1]).reduce(f64::min);
    if others.is_some_and(|other| other * AS_WELL_RATIO < left[1]) {
        return Ok(());
    }
    let remedy = shares.remedy_beside(options).unwrap_or_default();
    let evidence = "so the limits of the description make radians and metres of them".into();
    let finding = Finding { tried: Some(left), ..Finding::of(Fault::Normalised, Vec::new(), evidence, remedy) };
    // What does not forbid an estimate is found with these positions too; what bodies explain shows once they are read so.
    let explanation = std::iter::once(finding).chain(found.findings).collect();
    match others.is_some_and(|other| other < AS_WELL_RATIO * left[1]) {
        true => passport.put_before(explanation),
        false => {
            passport.findings = explanation;
            passport.explained.clear();
        }
    }
    Ok(())
}
