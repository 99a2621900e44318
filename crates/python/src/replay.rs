//! The function `rist.replay`: runs observer, load and drift over a log.
//!
//! The observer computes the external torque of each joint; load and drift of friction follow from these torques.

use std::path::Path;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use rist::page::Origin;
use rist::replay::{ReplayedCycle, reference_logs};
use rist::request::ReplayRequest;
use rist::request::spelling::Audience;

use crate::arrays::array;
use crate::call::{Call, object};
use crate::error::{OrError, error, for_python};
use crate::estimate::Estimate;
use crate::logs::{logs, open};
use crate::model::Model;
use crate::work::work;

/// Finds contact, loads and drift of friction in a log, cycle by cycle, in the same way as on the robot.
///
/// model: the Model of the estimate, or its path. log: as for `identify`. The estimate should contain its covariance.
///
/// Returns a dict. contacts, loads, joints: lists of dicts. threshold: in standard deviations. series: a dict of arrays over
/// the cycles, with t (s), torque (external torque, N m), beyond (external torque without the torque of the load, N m), band
/// (the limit of beyond without contact), contact, mass (kg). page: HTML. text: what the program prints.
///
/// >>> rist.replay("arm.urdf", estimate, "log.csv")["contacts"]
///
/// Options:
/// - reference: Logs without contact, from which the noise of the observer is measured [default: the logs of the
///   estimate]
/// - alarms: Accepted number of false alarms per hour [default: 1.0]
/// - observer_gain: Gain of the observer of external torques, 1/s [default: 50.0]
/// - order: Filter of the observer of external torques [default: 'first']
/// - load_on: Link or frame that carries a load [default: the last link]
/// - largest_load: Largest possible mass of a load, kg [default: 10.0]
/// - wrench_on: Link or frame for the force and the moment of each contact: both are computed at the origin and
///   in the axes of this frame
/// - anyway: Use the estimate even if its verdict is no. Otherwise the estimate is refused [default: False]
#[pyfunction]
#[pyo3(signature = (model, estimate, log, **options), text_signature = "(model, estimate, log, *, reference=None, alarms=1.0, observer_gain=50.0, order='first', load_on=None, largest_load=10.0, wrench_on=None, anyway=False)")]
pub fn replay<'py>(
    py: Python<'py>,
    model: &Bound<'py, PyAny>,
    estimate: &Estimate,
    log: &Bound<'py, PyAny>,
    options: Option<&Bound<'py, PyDict>>,
) -> PyResult<Bound<'py, PyDict>> {
    let request: ReplayRequest = Call::new("replay", &[], options)?.request()?;
    let used = Model::for_estimate(model, estimate)?;
    let (model, estimate, given) = (&used.get().inner, &estimate.inner, logs(log)?);
    let file = Path::new("the estimate");
    model.check_estimate(file, estimate).or_error()?;
    if given.len() != 1 {
        return Err(error(format_args!("replay: one log is expected, and {} are given", given.len())));
    }
    // The log is read with the column names of the fit.
    let columns = estimate.options.as_ref().map(|options| options.columns.clone()).unwrap_or_default();
    let found = work(py, None, |_| {
        let logs = open(given, model, &columns)?;
        let reference = reference_logs(model, file, estimate, &request.reference)?;
        logs.iter()
            .map(|log| rist::replay(model, (file, estimate), log, &reference, &request))
            .collect::<Result<Vec<_>, _>>()
    })?;
    let Some(found) = found.first() else { return Err(error("replay: one log is expected")) };
    let dict = object(py, &found.to_json())?.cast_into::<PyDict>()?;
    // The series are arrays with one row per cycle. All arrays contain doubles, so contact is 0 or 1.
    let (rows, n) = (found.series.len(), found.coordinates.len());
    let series = PyDict::new(py);
    let each = |value: fn(&ReplayedCycle) -> f64| -> Vec<f64> { found.series.iter().map(value).collect() };
    let all =
        |values: fn(&ReplayedCycle) -> &[f64]| -> Vec<f64> { found.series.iter().flat_map(values).copied().collect() };
    series.set_item("t", array(py, &[rows], &each(|cycle| cycle.t))?)?;
    series.set_item("torque", array(py, &[rows, n], &all(|cycle| &cycle.torque))?)?;
    series.set_item("beyond", array(py, &[rows, n], &all(|cycle| &cycle.beyond))?)?;
    series.set_item("band", array(py, &[rows, n], &all(|cycle| &cycle.band))?)?;
    series.set_item("contact", array(py, &[rows], &each(|cycle| f64::from(u8::from(cycle.is_contact))))?)?;
    series.set_item("mass", array(py, &[rows], &each(|cycle| cycle.mass))?)?;
    dict.set_item("series", series)?;
    let origin = Origin { version: env!("CARGO_PKG_VERSION"), command: "rist.replay", ..Origin::default() };
    dict.set_item("page", found.page(origin, Audience::Python))?;
    dict.set_item("text", for_python(&found.to_string()))?;
    Ok(dict)
}
