//! The function `rist.wrench`: identifies the load on a force-torque sensor.
//!
//! Input: a log with forces, torques and poses of the sensor. Output: a dict with the parameters of the load, the offsets of
//! the sensor, and a verdict.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use statics::WrenchRequest;

use crate::call::{Call, object};
use crate::error::{error, for_python};
use crate::logs::logs;
use crate::work::work;

/// Identifies the load on a force-torque sensor from a log: forces and torques in the axes of the sensor, and poses of the
/// sensor in a frame at rest whose z axis points up.
///
/// log: a path (CSV, .npz, Arrow, Parquet, MCAP, a rosbag2 directory), a dict of arrays, or a table with __arrow_c_stream__
/// (pandas, polars, pyarrow). Columns are found by their names: fx fy fz tx ty tz, x y z, qx qy qz qw or roll pitch yaw.
/// Without a clock, each row is a posture at rest. options: a path to YAML, its text, or its content as a dict.
///
/// Returns a dict. parameters: in the frame of the sensor, about its origin. body: mass, centre of mass, and inertia about the
/// centre of mass; None if the log does not determine a body that can exist, or if trust is "no". offsets: of the sensor.
/// is_reaction: whether the sensor gives the force of the load on the sensor. residuals: N and N m. rows, left_out. verdict:
/// with trust, reasons, next and claims. text: what the program prints.
///
/// >>> rist.wrench("log.csv")["body"]
///
/// Options:
/// - options: YAML with the columns of the log, and with corrections of its numbers
/// - link: Name of the link whose frame is the frame of the sensor. The file of the load contains this name
///   [default: 'tool0']
#[pyfunction]
#[pyo3(signature = (log, **options), text_signature = "(log, *, options=None, link='tool0')")]
pub fn wrench<'py>(
    py: Python<'py>,
    log: &Bound<'py, PyAny>,
    options: Option<&Bound<'py, PyDict>>,
) -> PyResult<Bound<'py, PyDict>> {
    let request: WrenchRequest = Call::new("wrench", &[], options)?.request()?;
    let mut given = logs(log)?;
    let Some(log) = given.pop().filter(|_| given.is_empty()) else {
        return Err(error("wrench: one log is expected"));
    };
    let (options, link) = (request.options.unwrap_or_default(), request.link);
    let found = work(py, None, |_| statics::identify_wrench(&log.wrenches(&options)?, &link))?;
    let dict = object(py, &found.to_json())?.cast_into::<PyDict>()?;
    dict.set_item("text", for_python(&found.to_string()))?;
    Ok(dict)
}
