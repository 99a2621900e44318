//! The log check: tests whether a log belongs to the robot of the description, before any fit.
//!
//! The torque of each joint j is regressed on its nominal torque, and on columns that no description contains (rotor, viscous
//! and Coulomb friction, offset):
//! ```text
//! tau_j = s_j (Y(q, dq, ddq) X)_j + a ddq_j + b dq_j + c direction_j + d
//! ```
//! Y: regressor; X: nominal base parameters. The slope s_j is near 1 if log and description belong to one robot and have the same
//! units. b and c are positive, because friction dissipates. If a slope is not near 1, common faults are tried: each is undone in
//! the log. The fault is found if the description then predicts the torques (`search`). Without inertials in the description
//! there are no slopes, and the log check lists what it cannot determine.
//!
//! The log check does not estimate parameters. Nominal inertials are wrong by tens of per cent, so a slope of 0.6 in a wrist
//! is no fault of a log.

mod absolute;
mod change;
mod columns;
mod delay;
mod diagnosis;
pub mod finding;
mod free_bodies;
pub mod friction;
mod load;
mod order;
mod power;
mod regression;
mod report;
mod samples;
mod search;
mod signals;
mod trial;
mod trials;
pub mod visited;

use logs::{Error, Suspect};

pub use crate::estimate::log_check::change::Change;
use crate::estimate::log_check::change::{Description, MIN_SAMPLES_PER_JOINT, column, used};
pub(crate) use crate::estimate::log_check::finding::COMMON_FACTORS;
use crate::estimate::log_check::friction::own_friction;
use crate::estimate::log_check::order::hidden_exchanges;
pub use crate::estimate::log_check::power::MisplacedJoint;
use crate::estimate::log_check::power::{carries_none, turned, zero_power};
use crate::estimate::log_check::regression::Partial;
pub(crate) use crate::estimate::log_check::regression::{Basis, COUNTED_SLOPE_SHARE, square};
pub use crate::estimate::log_check::report::{ExplainedMistake, JointCheck, LogCheck, Measured};
pub(crate) use crate::estimate::log_check::samples::LIKELY_SIZES as LIKELY_ACCELERATION_SIZES;
use crate::estimate::log_check::visited::VisitedStates;
use linear_model::regressor::Regressor;

use crate::estimate::log_check::samples::Samples;
pub use crate::estimate::log_check::trial::AS_WELL_RATIO;
use crate::estimate::log_check::trial::tried;
use crate::estimate::log_check::trials::Trials;
use crate::signals::records::Records;

/// A velocity column is in time if it lags behind the derivative of the position by less than this time, s.
pub const TIMELY_S: f64 = 1e-3;

/// Least number of samples from which slopes are computed (if the log has so many).
const MIN_TRIED_SAMPLES: usize = 400;
/// Least number of samples on which many changes of the log are tried (if the log has so many).
const FEW_TRIED_SAMPLES: usize = 150;

/// Checks a log before any fit. `suspects`: suspect columns of the log; `described`: nominal base parameters, `None` if the
/// description has no inertials.
///
/// If the log has gross faults (faults that make estimates unusable), these faults are undone and the log is checked again.
///
/// Fails when a record cannot be read.
pub fn log_check<R: Records + ?Sized>(
    regressor: &dyn Regressor,
    records: &R,
    suspects: &[Suspect],
    described: Option<&[f64]>,
) -> Result<LogCheck, Error> {
    let samples = Samples::of(records, regressor.coordinates().len())?;
    let look = |samples: &Samples| look_at(regressor, samples, suspects, described);
    Ok(tried(look(&samples), |changes| look(&samples.changed(changes, regressor))))
}

/// Checks samples once, without trying the remedies of the findings.
fn look_at(regressor: &dyn Regressor, samples: &Samples, suspects: &[Suspect], described: Option<&[f64]>) -> LogCheck {
    let n = regressor.coordinates().len();
    // Slopes (measured / nominal torque) are computed from many samples.
    let rows = samples.every(samples.kept.len() / MIN_TRIED_SAMPLES);
    let description = described.map(|parameters| Description { regressor, parameters });
    let slopes = description.as_ref().map(|d| Trials::new(d, &samples.kept, &rows).partials(&[]));
    // The detection limit of a zero offset needs trials with ten angles per joint. So this limit is computed from fewer
    // samples.
    let few = samples.every(samples.kept.len() / FEW_TRIED_SAMPLES);
    let few = description.as_ref().map(|d| Trials::new(d, &samples.kept, &few));
    let rough = few.as_ref().map(|trials| trials.partials(&[]));
    let power = |j: usize| {
        let (trials, rough) = (few.as_ref()?, rough.as_ref()?);
        if regressor.is_prismatic(j) || carries_none(regressor, j) { None } else { zero_power(trials, rough, j) }
    };
    let angles = (0..n).filter(|&j| !regressor.is_prismatic(j));
    let turned = few.as_ref().and_then(|trials| turned(trials, angles));
    let hidden = few.as_ref().zip(rough.as_ref()).map(|(trials, rough)| hidden_exchanges(trials, rough));
    let hidden_exchanges = hidden.unwrap_or_default();
    let is_short = samples.are_few();
    let mut log_check =
        LogCheck { is_short, visited: VisitedStates::of(samples), turned, hidden_exchanges, ..LogCheck::default() };
    for (j, coordinate) in regressor.coordinates().iter().enumerate() {
        let partial = slopes.as_ref().map(|s| s[j]).filter(|p| p.yy > 0.0);
        log_check.joints.push(JointCheck {
            coordinate: coordinate.clone(),
            slope: partial.map(|p| p.slope()),
            share: partial.map(|p| p.share()),
            explained: partial.and_then(|p| explained(samples, &rows, j, &p)),
            friction: own_friction(regressor, &samples.kept, &rows, j),
            positions: samples.range[j],
            velocity_lag: samples.velocity_lag(j),
            velocity_lag_deviation: samples.velocity_lag_deviation(j),
            acceleration: samples.acceleration(j),
            wrong_acceleration: samples.is_acceleration_wrong(j),
            zero_power: power(j),
        });
    }
    // The findings follow from the numbers of all joints.
    let look =
        diagnosis::DiagnosisInput { samples, rows: &rows, suspects, regressor, description: description.as_ref() };
    look.diagnose(slopes.as_deref(), &mut log_check);
    log_check
}

/// The share of the variance of the torque of joint j that the description and the joint's own columns (rotor, friction,
/// offset) explain together. `None` if the torque is constant or there are too few samples.
fn explained(samples: &Samples, rows: &[usize], j: usize, partial: &Partial) -> Option<f64> {
    let places = used(&samples.kept, rows, j);
    let chosen: Vec<usize> = places.iter().map(|&i| rows[i]).collect();
    let mean = Basis::of(vec![vec![1.0; chosen.len()]]);
    let variance = square(&mean.without(column(&samples.kept.tau, samples.kept.n, j, &chosen)));
    (variance > 0.0 && chosen.len() >= MIN_SAMPLES_PER_JOINT)
        .then(|| 1.0 - partial.yy * (1.0 - partial.share()) / variance)
}
