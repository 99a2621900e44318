//! Where the bodies of a robot may be: boxes, floors, walls, and the distance between its own links.
//!
//! Places are in the base frame, m. Not here: the bodies themselves, which only the description has.

use serde::{Deserialize, Serialize};

/// The least distance between own links where nothing else is asked, m.
pub const DISTANCE: f64 = 0.01;

/// Where bodies may be.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SpaceLimits {
    /// No moving link goes below this height: z of the base frame, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub floor: Option<f64>,
    /// Planes that links stay on one side of.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub walls: Vec<Wall>,
    /// Boxes that links stay in.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub boxes: Vec<SpaceBox>,
    /// Between links of the robot that are no neighbours, m.
    pub distance: f64,
    /// Whether distances between links of the robot are looked at.
    pub own_links: bool,
    /// Pairs of links whose distance is not looked at.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub ignored_pairs: Vec<(String, String)>,
}

impl Default for SpaceLimits {
    fn default() -> SpaceLimits {
        SpaceLimits {
            floor: None,
            walls: vec![],
            boxes: vec![],
            distance: DISTANCE,
            own_links: true,
            ignored_pairs: vec![],
        }
    }
}

/// A plane with a side that is allowed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Wall {
    /// On the plane, m.
    pub point: [f64; 3],
    /// Towards the side that is allowed; of any length.
    pub normal: [f64; 3],
    /// Links of the file that must keep to that side; none: all that move.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub links: Option<Vec<String>>,
}

/// A box along the axes of the base frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpaceBox {
    /// Least x, y, z, m.
    pub low: [f64; 3],
    /// Greatest x, y, z, m.
    pub high: [f64; 3],
    /// Links of the file that must stay in; none: all that move.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub links: Option<Vec<String>>,
}

impl SpaceLimits {
    /// Why no robot can keep them, if so.
    pub fn fault(&self) -> Option<String> {
        let (distance, floor) = (self.distance, self.floor.unwrap_or(0.0));
        if !(distance.is_finite() && distance >= 0.0) {
            return Some(format!("space: distance is {distance}; expected are metres, 0 or more"));
        }
        (!floor.is_finite()).then(|| format!("space: floor is {floor}; expected is a height in metres"))
    }
}
