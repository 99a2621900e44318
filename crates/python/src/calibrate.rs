//! The function `rist.calibrate`: errors of the geometry, zeros and compliances from measured poses.
//!
//! Input: a model and a table of measurements. Output: a dict with the calibration, a table of zeros, and a corrected URDF.
//! Without a table, the function chooses postures that should be measured.

use std::path::{Path, PathBuf};

use calibration::{CalibrateRequest, Calibrated, calibrate_model, calibrated_urdf, design, zeros_table};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::call::{Call, object};
use crate::error::for_python;
use crate::estimate::Estimate;
use crate::model::Model;
use crate::work::work;

/// Identifies errors of the geometry, zeros or compliances of a robot from measured poses, points or distances.
///
/// model: a Model or a path; read a URDF with angles="as-given". postures: the path of a table with one posture per row: joint
/// positions, and x y z with qx qy qz qw or roll pitch yaw, or points x1 y1 z1 x2 .., or a distance. estimate: for
/// what="stiffness", gives the torques that bend the joints.
///
/// Returns a dict with the content of the file of `rist calibrate --out`, and with zeros, the table of the zeros as CSV; urdf,
/// the URDF with calibrated origins, None if the model has another format or if scales are fitted; text, what the program
/// prints. Without postures, but with design: the postures to measure, and csv, their table.
///
/// >>> rist.calibrate("arm.urdf", "poses.csv")["verdict"]
/// >>> rist.calibrate("arm.urdf", design=20)["csv"]
///
/// Options:
/// - what: Errors to fit, in addition to the frames of base, tool and markers [default: 'geometry']
/// - gears: Joints whose scale (gear ratio) is fitted too
/// - tip: The measured link, at the end of the chain [default: the link with most joints before it]
/// - touched: What the tool touched at each posture, for a table without measurements
/// - names: How the errors of the geometry are named [default: frames for a URDF, dh for other descriptions]
/// - design: Number of postures to choose if no table is given. The chosen postures determine the parameters best
/// - measured: What will be measured at the postures of design= [default: 'pose']
/// - options: YAML with the columns of the table, and with corrections of its numbers
#[pyfunction]
#[pyo3(signature = (model, postures=None, estimate=None, **options), text_signature = "(model, postures=None, estimate=None, *, what='geometry', gears=None, tip=None, touched=None, names=None, design=None, measured='pose', options=None)")]
pub fn calibrate<'py>(
    py: Python<'py>,
    model: &Bound<'py, PyAny>,
    postures: Option<PathBuf>,
    estimate: Option<&Estimate>,
    options: Option<&Bound<'py, PyDict>>,
) -> PyResult<Bound<'py, PyDict>> {
    let request: CalibrateRequest = Call::new("calibrate", &[], options)?.request()?;
    let used = match estimate {
        Some(estimate) => Model::for_estimate(model, estimate)?,
        None => Model::of(model)?,
    };
    let (inner, estimate) = (&used.get().inner, estimate.map(|estimate| &estimate.inner));
    let Some(postures) = postures else {
        let designed = work(py, None, |_| {
            let missing =
                || rist::Error::new("give the postures that were measured, or the number to choose in [design]");
            let directory = inner.path.parent().unwrap_or(Path::new(""));
            design(&inner.robot, directory, &request, request.design.ok_or_else(missing)?)
        })?;
        let dict = object(py, &designed.to_json())?.cast_into::<PyDict>()?;
        dict.set_item("csv", designed.to_csv())?;
        dict.set_item("text", for_python(&designed.to_string()))?;
        return Ok(dict);
    };
    let (found, urdf) = work(py, None, |_| {
        let found = calibrate_model(inner, estimate, &postures, &request)?;
        // Only a URDF has the frames of joints as origins, and it has no compliances and no scales.
        let is_urdf = inner.path.extension().is_some_and(|ending| ending == "urdf");
        let urdf = (is_urdf && request.what != Calibrated::Stiffness && request.gears.is_empty()).then(|| {
            let text = rist::text_of(&inner.path)?;
            calibrated_urdf(&text, &inner.path.display().to_string(), &inner.robot, &found, found.level())
        });
        Ok((found, urdf.transpose()?))
    })?;
    let dict = object(py, &found.to_json())?.cast_into::<PyDict>()?;
    dict.set_item("zeros", zeros_table(&found, found.level()))?;
    dict.set_item("urdf", urdf)?;
    dict.set_item("text", for_python(&found.to_string()))?;
    Ok(dict)
}
