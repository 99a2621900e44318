//! Computes the constants of a generated monitor (observer, contact and load in C): noise, thresholds and gains. A replay has
//! the same constants. But a replay uses all parameters of the estimate, and a generated file leaves out couplings.
//!
//! Input: a model, an estimate and logs without contact. Output: the numbers that `rist generate` writes into the C file.

use std::path::Path;

use codegen::Monitor;
use identification::estimate::artefact::Estimate;
use logs::LogSource;
use online::Order;

use crate::describe::model::Model;
use crate::error::Error;
use crate::replay::cycles::CycleModel;
use crate::replay::directions::DIRECTIONS;
use crate::replay::friction_in_c::friction_columns;
use crate::replay::inputs::{HOLD_S, covariance, last_link};
use crate::replay::load_noise::load_start;
use crate::replay::noise::SCALE_MEMORY_S;
use crate::replay::noise::{Noise, SETTLING_TIME_CONSTANTS};
use crate::replay::run::{LARGEST_MISFIT, LOAD_DECISION_S, MISFIT_MEMORY_S};
use crate::request::GenerateRequest;

/// The name of the link that carries the load, and the constants of the monitor. `reference`: logs without contact.
///
/// Fails for an estimate of experiments, if a log cannot be read, and if there is no such link.
pub fn monitor(
    model: &Model,
    (file, estimate): (&Path, &Estimate),
    reference: &[LogSource],
    request: &GenerateRequest,
) -> Result<(String, Monitor), Error> {
    model.check_estimate(file, estimate)?;
    let (gain, link) = (request.observer_gain, request.load_on.clone().unwrap_or_else(|| last_link(model)));
    let mut cycles = CycleModel::new(model, estimate, &link, gain)?;
    // The noise is measured with the same parameters as in the generated file. So the thresholds contain the error that the
    // missing couplings cause.
    cycles.leave_out_couplings();
    let covariance = covariance(&cycles.linear, estimate);
    let noise = Noise::measure(&mut cycles, reference, covariance.as_ref(), (Order::First(gain), gain), HOLD_S)?;
    let bands = noise.bands.iter().zip(&cycles.slow).zip(&noise.changes);
    let n = cycles.n();
    let parameters = model.regressor().parameters().len();
    let mut friction_base = cycles.load_base().to_vec();
    friction_base.resize(parameters, 0.0);
    let friction = friction_columns(&cycles.linear, cycles.x());
    // Rows of the factor G of the covariance: base parameters first, then the friction columns. Without a covariance, G is zero.
    let row = |place: usize| noise.factor.get(place).map_or(vec![0.0; DIRECTIONS], |row| row.to_vec());
    let factor = (0..parameters + friction.len()).map(row).collect();
    let monitor = Monitor {
        joints: n,
        parameters,
        load_function: String::new(),
        gain,
        rate: request.rate,
        load_factors: noise.load_factors(1.0 / request.rate),
        threshold: noise.peaks.threshold(request.alarms),
        significant: noise.peaks.significant(),
        hold: HOLD_S,
        bands: bands
            .map(|((band, slow), change)| [band.noise, band.low_speed, band.dry, band.speed, *slow, *change])
            .collect(),
        friction,
        friction_base,
        factor,
        directions: DIRECTIONS,
        efforts: cycles.efforts().to_vec(),
        load_start: load_start(request.largest_load),
        decision: [LOAD_DECISION_S, SETTLING_TIME_CONSTANTS / gain, MISFIT_MEMORY_S, LARGEST_MISFIT],
        scale_memory: SCALE_MEMORY_S,
    };
    Ok((link, monitor))
}
