//! The options (request) of `rist calibrate`, and the registration of this wing (optional package).

use rist::request::Request;
use rist::wings::Wing;

use crate::corrections::CalibrationOptions;
use crate::pose_table::Touched;

/// The requests that this wing registers.
pub fn wing() -> Wing {
    Wing { requests: vec![("calibrate", CalibrateRequest::fields)], ..Wing::default() }
}

rist::words! {
    /// What a calibration fits besides the frames of the measurement.
    pub enum Calibrated {
        /// The zeros of the joints.
        Zeros = "zeros" "the zeros of the joints",
        /// Zeros and errors of the geometry.
        Geometry = "geometry" "zeros and errors of the geometry",
        /// Zeros and compliances of the joints.
        Stiffness = "stiffness" "zeros and compliances of the joints under gravity and load",
    }
}

rist::words! {
    /// How errors of the geometry are named.
    pub enum ErrorNames {
        /// By the letters of Khalil and Kleinfinger.
        Dh = "dh" "gamma, b, beta, alpha, d, theta and r of each link",
        /// By the frame of each joint in the description.
        Frames = "frames" "x, y, z, roll, pitch and yaw of the frame of each joint, as in a URDF",
    }
}

rist::words! {
    /// What an instrument measures at designed postures.
    pub enum Measured {
        /// Position and orientation.
        Pose = "pose" "position and orientation of the tool",
        /// The position of a point.
        Point = "point" "the position of one point, as by a laser tracker",
    }
}

rist::request! {
    /// Options for a kinematic calibration.
    pub struct CalibrateRequest {
        /// Errors to fit, in addition to the frames of base, tool and markers.
        what: Calibrated = Calibrated::Geometry, value_name("WHAT");
        /// Joints whose scale (gear ratio) is fitted too.
        gears: Vec<String> = Vec::new(), value_name("JOINTS");
        /// The measured link, at the end of the chain [default: the link with most joints before it].
        tip: Option<String> = None, value_name("LINK");
        /// What the tool touched at each posture, for a table without measurements.
        touched: Option<Touched> = None, value_name("WHAT");
        /// How the errors of the geometry are named [default: frames for a URDF, dh for other descriptions].
        names: Option<ErrorNames> = None, value_name("NAMES");
        /// Number of postures to choose if no table is given. The chosen postures determine the parameters best.
        design: Option<usize> = None, range(1..=300), value_name("POSTURES");
        /// What will be measured at the postures of [design].
        measured: Measured = Measured::Pose, value_name("WHAT");
        /// YAML with the columns of the table, and with corrections of its numbers.
        options: Option<CalibrationOptions> = None, value_name("FILE");
    }
}

rist::file_type!(CalibrationOptions, "options of a calibration", |file, text| {
    linear_model::yaml::read(text).map_err(|e| logs::Error::at(file, 0, e))
});
