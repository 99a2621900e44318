//! Options for a table of postures: the columns, and corrections of their numbers.
//!
//! A correction repairs a mistake in a table, for example degrees instead of radians; the search for mistakes proposes
//! corrections.

use std::fmt;

use logs::ColumnNames;
use serde::{Deserialize, Serialize};

/// The content of the options file for a table of postures.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CalibrationOptions {
    /// Headers of the joints, if they cannot be found by their names.
    pub joints: ColumnNames,
    /// Headers of the measurements, if they cannot be found by their names.
    pub columns: MeasurementColumns,
    /// Corrections that are applied to the numbers.
    pub corrections: TableCorrections,
    /// Centre of mass of the loads in the frame of the measured link, m.
    pub load_position: [f64; 3],
}

/// Headers of the measurements. `None`: the columns are searched by their names.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MeasurementColumns {
    /// Headers of the position x, y, z, for each measured point. A component that is not measured has an empty name.
    pub points: Option<Vec<[String; 3]>>,
    /// Headers of the orientation: x, y, z, w of a quaternion, or roll, pitch, yaw, or a rotation vector.
    pub orientation: Option<Vec<String>>,
    /// Header of the distance.
    pub distance: Option<String>,
    /// Header of the mass of the load of each posture, kg.
    pub load: Option<String>,
}

/// Corrections of the numbers of a table of postures. Display prints the YAML that requests them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TableCorrections {
    /// Whether the positions of revolute joints are in degrees.
    pub joint_degrees: bool,
    /// Whether measured lengths are in mm.
    pub millimetres: bool,
    /// Whether roll, pitch and yaw, or the rotation vector, are in degrees.
    pub degrees: bool,
    /// Whether three angles are a rotation vector instead of roll, pitch and yaw, or the reverse.
    pub other_angles: bool,
    /// Whether the order of a quaternion is w, x, y, z.
    pub scalar_first: bool,
    /// Whether the measured poses are inverted: poses of the base in the frame of the tool. This is the case if a camera on the
    /// hand measures a fixed tag.
    pub inverted_poses: bool,
    /// Joints whose positions have the wrong sign.
    pub reversed: Vec<String>,
    /// Pairs of joints whose columns are exchanged.
    pub swapped: Vec<[String; 2]>,
}

impl TableCorrections {
    /// Whether nothing is corrected.
    pub fn is_empty(&self) -> bool {
        *self == TableCorrections::default()
    }
}

impl fmt::Display for TableCorrections {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let words = [
            ("joint_degrees", self.joint_degrees),
            ("millimetres", self.millimetres),
            ("degrees", self.degrees),
            ("other_angles", self.other_angles),
            ("scalar_first", self.scalar_first),
            ("inverted_poses", self.inverted_poses),
        ];
        let mut parts: Vec<String> =
            words.into_iter().filter(|(_, is)| *is).map(|(word, _)| format!("{word}: true")).collect();
        if !self.reversed.is_empty() {
            parts.push(format!("reversed: [{}]", self.reversed.join(", ")));
        }
        if !self.swapped.is_empty() {
            let pairs: Vec<String> = self.swapped.iter().map(|[a, b]| format!("[{a}, {b}]")).collect();
            parts.push(format!("swapped: [{}]", pairs.join(", ")));
        }
        write!(f, "corrections: {{{}}}", parts.join(", "))
    }
}
