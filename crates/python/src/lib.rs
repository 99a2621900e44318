//! The Python package `rist`: the library `rist` with NumPy arrays as data and keyword arguments as options.
//!
//! This package only converts arguments and results. Functions are named like the program's commands, most options like its
//! flags, and classes like types of the library. Exception: `Model.regressor` is the regressor of the standard parameters here,
//! and `Model.base_regressor` is `Model::regressor` of the library. Long work runs without the interpreter lock (`work`). A
//! failure raises `rist.Error` with the message of the program.

mod arrays;
mod arrow;
mod artefact;
mod base_parameters;
#[cfg(feature = "calibration")]
mod calibrate;
mod call;
mod error;
mod estimate;
mod evaluate;
mod experiments;
#[cfg(feature = "fleet")]
mod fleet;
mod html;
mod identify;
mod logs;
mod model;
mod monitor;
mod motions;
mod program;
mod replay;
mod validation;
mod verdict;
mod work;
#[cfg(feature = "statics")]
mod wrench;

use pyo3::prelude::*;

/// From a robot description to an exact symbolic model, generated code, and inertial parameters identified from logs of the robot.
///
/// >>> estimate = rist.identify("arm.urdf", "log.csv")
/// >>> estimate.verdict, estimate["ZZR_elbow"]
/// >>> estimate.plot()
#[pymodule(name = "_rist")]
mod module {
    #[pymodule_export]
    use crate::base_parameters::{_base_parameters, BaseParameters};
    #[cfg(feature = "calibration")]
    #[pymodule_export]
    use crate::calibrate::calibrate;
    #[pymodule_export]
    use crate::error::{Error, TrustWarning};
    #[pymodule_export]
    use crate::estimate::{_estimate, Estimate};
    #[pymodule_export]
    use crate::experiments::{check, excite, plan, simulate};
    #[cfg(feature = "fleet")]
    #[pymodule_export]
    use crate::fleet::{_accumulator, Accumulator, Comparison, compare};
    #[pymodule_export]
    use crate::identify::{_log_check, LogCheck, doctor, identify};
    #[pymodule_export]
    use crate::model::{_model, Model};
    #[pymodule_export]
    use crate::monitor::Monitor;
    #[pymodule_export]
    use crate::motions::{ExcitingMotion, ExperimentPlan};
    #[pymodule_export]
    use crate::program::{_run_program, example};
    #[pymodule_export]
    use crate::replay::replay;
    #[pymodule_export]
    use crate::validation::{Validation, validate};
    #[pymodule_export]
    use crate::verdict::{_verdict, Verdict};
    #[cfg(feature = "statics")]
    #[pymodule_export]
    use crate::wrench::wrench;

    #[pymodule_init]
    fn init(_module: &pyo3::Bound<'_, pyo3::types::PyModule>) -> pyo3::PyResult<()> {
        cli::wings::register();
        Ok(())
    }

    #[pymodule_export]
    #[allow(non_upper_case_globals)]
    const __version__: &str = env!("CARGO_PKG_VERSION");
}
