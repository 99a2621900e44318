//! Determines drive gains, the torque per unit of current of each drive: some gains are known, and the others are estimated.
//!
//! Logs with currents or position errors (goal minus position of a servo) need gains. If no gain is known, all torques have an
//! unknown common scale.

use std::fmt::Write as _;

use identification::estimate::drive_gains::estimate_drive_gains;
use identification::estimate::identified::Identified;
use identification::estimate::identify::with_deviations;
use identification::estimate::options::Options;
use identification::estimators::drive_gains::likelihood::{DriveGains, Gain};
use logs::{Effort, LogSource};

use crate::describe::model::Model;
use crate::error::Error;
use identification::estimate::artefact::Estimate;

/// Writes the known gains into the options, and estimates the other gains. `None` if all gains are known.
pub(crate) fn drive_gains(
    model: &Model,
    logs: &[LogSource],
    given: &[(String, Gain)],
    options: &mut Options,
) -> Result<Option<DriveGains>, Error> {
    // No gain is estimated if the logs hold torques, if the options give the gains, or if all gains are given.
    let effort = efforts(logs)?;
    if effort == Effort::Torque {
        return match given.first() {
            Some((name, _)) => Err(Error::new(format_args!("[gain={name}]: the logs hold torques, not currents"))),
            None => Ok(None),
        };
    }
    if given.is_empty() && options.transmission.drive_gains.is_some() {
        return Ok(None);
    }
    let coordinates = model.regressor().coordinates();
    let known = known_gains(model, given)?;
    let all: Option<Vec<f64>> = known.iter().map(|g| if let Gain::Known(g) = g { Some(*g) } else { None }).collect();
    if all.is_some() {
        options.transmission.drive_gains = all;
        return Ok(None);
    }
    // If no gain is known, the scale of all torques is undetermined, so the parameters are not identifiable.
    if known.iter().all(|g| *g == Gain::Free) {
        if effort == Effort::PositionError {
            options.transmission.drive_gains = Some(vec![1.0; coordinates.len()]);
            return Ok(None);
        }
        return Err(Error::new(format_args!(
            "the logs hold motor currents: give the torque per unit of current of every drive, or of one at least (the \
             others are then estimated): [gain={}=11.5]",
            coordinates.first().map_or("q1", String::as_str)
        )));
    }
    // Fails if an estimated gain is not significant, because all parameters scale with the gains.
    let found = estimate_drive_gains(model.regressor(), logs, options, &known)?;
    // An estimated gain has to be positive, unless a negative gain is expected.
    let sign = |k: usize| if matches!(known[k], Gain::Known(g) | Gain::Expected(g, _) if g < 0.0) { -1.0 } else { 1.0 };
    let is_insignificant =
        |k: &usize| !found.gain_determined[*k] || 2.0 * found.gain_deviation[*k] >= sign(*k) * found.gain[*k];
    let open: Vec<String> = (0..coordinates.len()).filter(is_insignificant).map(|k| coordinates[k].clone()).collect();
    if !open.is_empty() {
        return Err(Error::verdict(format_args!(
            "the logs do not identify the drive gains of {} (zero is within two sigma): give them, or their expected value with its sigma, as [gain={}=11+-2]",
            open.join(", "),
            open[0]
        )));
    }
    if found.steps.is_none() {
        return Err(Error::verdict("the drive gains did not converge: give more of them, or what is expected of them"));
    }
    options.transmission.drive_gains = Some(found.gain.clone());
    Ok(Some(found))
}

/// Whether the logs hold position errors of servos and no gain is known. Torques are then unscaled position errors.
///
/// Fails if a gain names an unknown coordinate.
pub(crate) fn is_own_scale(
    model: &Model,
    logs: &[LogSource],
    given: &[(String, Gain)],
    options: &Options,
) -> Result<bool, Error> {
    let are_errors = logs.iter().any(|log| log.effort_is() == Effort::PositionError);
    let is_free = |gains: Vec<Gain>| gains.iter().all(|g| *g == Gain::Free);
    Ok(are_errors && options.transmission.drive_gains.is_none() && is_free(known_gains(model, given)?))
}

/// Remark on all results with unscaled torques.
pub(crate) const OWN_SCALE: &str = "torques are in the servo's own scale: parameters are up to the gain of each joint, \
     which counts as 1 N m/rad (1 N/m where it slides)";

/// The kind of effort signal in the logs that need drive gains (motor currents or position errors); torque if no log needs them.
/// Logs of torques may be mixed with either kind.
///
/// Fails if some logs hold currents and others position errors: one gain of a joint cannot convert both signals into torques.
fn efforts(logs: &[LogSource]) -> Result<Effort, Error> {
    let mut with_gains = logs.iter().filter(|log| log.effort_is().needs_gains());
    let Some(first) = with_gains.next() else { return Ok(Effort::Torque) };
    match with_gains.find(|log| log.effort_is() != first.effort_is()) {
        Some(other) => Err(Error::new(format_args!(
            "{} holds {}, and {} {}: give logs of one kind",
            first.name(),
            first.effort_is().words(),
            other.name(),
            other.effort_is().words()
        ))),
        None => Ok(first.effort_is()),
    }
}

/// The gains of the request, or else the gains of the description, one per coordinate.
fn known_gains(model: &Model, given: &[(String, Gain)]) -> Result<Vec<Gain>, Error> {
    let described = model.drive_gains();
    let mut known: Vec<Gain> = described.iter().map(|g| g.map_or(Gain::Free, Gain::Known)).collect();
    for (coordinate, gain) in given {
        known[known_coordinate(model, coordinate)?] = *gain;
    }
    Ok(known)
}

fn known_coordinate(model: &Model, name: &str) -> Result<usize, Error> {
    model.coordinate(name).map_err(|e| Error::new(format_args!("[gain={name}]: {e}")))
}

/// A sentence on the drive gains that an estimate is based on.
pub(crate) fn gain_remark(model: &Model, logs: &[LogSource], given: &[(String, Gain)], found: &DriveGains) -> String {
    let known = known_gains(model, given).unwrap_or_default();
    let mut text = match logs.iter().map(LogSource::effort_is).find(|effort| effort.needs_gains()) {
        Some(Effort::PositionError) => "gains of the servos, N m/rad:".to_string(),
        _ => "drive gains, N m/A:".to_string(),
    };
    let coordinates = model.regressor().coordinates();
    for (((coordinate, gain), sigma), known) in
        coordinates.iter().zip(&found.gain).zip(&found.gain_deviation).zip(&known)
    {
        // Writing to a String cannot fail.
        let _ = match known {
            Gain::Known(_) => write!(text, " {coordinate} {gain:.4} (given)"),
            Gain::Expected(..) | Gain::Free => write!(text, " {coordinate} {gain:.4} +- {sigma:.4}"),
        };
    }
    text + "; all results rest on those that were given"
}

/// Adds the uncertainty of the gains to the standard deviations and the covariance of an estimate, because the parameters
/// depend on the gains.
pub(crate) fn inflate_sigma(estimate: &mut Estimate, gains: &DriveGains) {
    // If friction terms were added after the gains were estimated, the numbers of parameters differ. The estimate then keeps
    // its standard deviations unchanged.
    if gains.deviation.len() != estimate.parameters.len() {
        return;
    }
    for (parameter, &deviation) in estimate.parameters.iter_mut().zip(&gains.deviation) {
        *parameter = parameter.clone().widened(deviation);
    }
    if !estimate.covariance.is_empty() {
        let found = |(c, parameter): (usize, &Identified)| parameter.sigma.unwrap_or(estimate.covariance[c][c].sqrt());
        let sigma: Vec<f64> = estimate.parameters.iter().enumerate().map(found).collect();
        estimate.covariance = with_deviations(&gains.covariance, &sigma);
    }
}
