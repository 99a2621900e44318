//! The options (request) of `rist wrench`, for a log of a force-torque sensor, and the registration of this wing (optional
//! package).

use rist::request::Request;
use rist::wings::Wing;

use crate::wrench_options::WrenchOptions;

/// The requests that this wing registers.
pub fn wing() -> Wing {
    Wing { requests: vec![("wrench", WrenchRequest::fields)], ..Wing::default() }
}

rist::request! {
    /// Options for reading a log of a force-torque sensor.
    pub struct WrenchRequest {
        /// YAML with the columns of the log, and with corrections of its numbers.
        options: Option<WrenchOptions> = None, value_name("FILE");
        /// Name of the link whose frame is the frame of the sensor. The file of the load contains this name.
        link: String = "tool0".into(), value_name("LINK");
    }
}

rist::file_type!(WrenchOptions, "options of a wrench", |file, text| {
    linear_model::yaml::read(text).map_err(|e| logs::Error::at(file, 0, e))
});
