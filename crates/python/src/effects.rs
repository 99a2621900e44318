//! `ripple`, `elastic` and `play` of `rist.identify`: effects that RIST-MH estimates besides the parameters.

use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyString};
use rist::request::harmonic_request::{HarmonicRequest, Whose};

use crate::error::error;
use crate::keywords::Keywords;

const RIPPLE: &str = "periods a turn of all joints, or of some, {'q2': 12} or {'q2': [6, 12]},";
const JOINTS: &str = "True for all joints, or a list of coordinates";

/// The effects that are asked for. Band and delay keep their defaults.
pub fn joint_effects(given: &Keywords<'_>) -> PyResult<HarmonicRequest> {
    Ok(HarmonicRequest {
        ripple: ripple(given)?,
        elastic: joints(given, "elastic")?,
        play: joints(given, "play")?,
        ..HarmonicRequest::default()
    })
}

/// Refuses effects where the method has no columns for them.
pub fn refuse_effects(asked: &HarmonicRequest) -> PyResult<()> {
    match asked.has_joint_effects() {
        true => Err(error("identify: ripple, elastic and play are for method='rist-mh'")),
        false => Ok(()),
    }
}

fn ripple(given: &Keywords<'_>) -> PyResult<Vec<(Whose, f64)>> {
    let Some(value) = given.any("ripple") else { return Ok(Vec::new()) };
    let wrong = || given.wrong("ripple", RIPPLE);
    let Ok(by_joint) = value.cast::<PyDict>() else {
        let periods = periods(value).ok_or_else(wrong)?;
        return Ok(periods.into_iter().map(|k| (Whose::All, k)).collect());
    };
    let mut found = Vec::new();
    for (name, value) in by_joint {
        let name: String = name.extract().map_err(|_| wrong())?;
        found.extend(periods(&value).ok_or_else(wrong)?.into_iter().map(|k| (Whose::Coordinate(name.clone()), k)));
    }
    Ok(found)
}

/// A number, or a list of numbers. True is refused, although Python treats it as a number.
fn periods(value: &Bound<'_, PyAny>) -> Option<Vec<f64>> {
    if value.is_instance_of::<PyBool>() {
        return None;
    }
    value.extract::<f64>().map(|k| vec![k]).or_else(|_| value.extract()).ok()
}

fn joints(given: &Keywords<'_>, name: &str) -> PyResult<Vec<Whose>> {
    let Some(value) = given.any(name) else { return Ok(Vec::new()) };
    if let Ok(all) = value.cast::<PyBool>() {
        return Ok(if all.is_true() { vec![Whose::All] } else { Vec::new() });
    }
    // A text is one name, not a list of its letters.
    let names = match value.cast::<PyString>() {
        Ok(one) => vec![one.to_string()],
        Err(_) => value.extract::<Vec<String>>().map_err(|_| given.wrong(name, JOINTS))?,
    };
    Ok(names.into_iter().map(Whose::Coordinate).collect())
}
