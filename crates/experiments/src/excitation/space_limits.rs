//! Where the bodies of a robot may be: boxes, floors, walls, and the distance between its own links.
//!
//! Places are in the base frame, m. Not here: the bodies themselves, which only the description has.

use serde::{Deserialize, Serialize};

/// The least distance between own links where nothing else is asked, m.
pub(crate) const DEFAULT_LEAST_DISTANCE_M: f64 = 0.01;

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
    /// Least distance between links of the robot that are no neighbours, m.
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
            distance: DEFAULT_LEAST_DISTANCE_M,
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
    /// The limits of both: all walls and boxes, the higher floor, the greater distance, and only pairs that both leave
    /// out.
    pub fn with(&self, other: &SpaceLimits) -> SpaceLimits {
        let walls = self.walls.iter().chain(other.walls.iter().filter(|wall| !self.walls.contains(wall)));
        let boxes = self.boxes.iter().chain(other.boxes.iter().filter(|cell| !self.boxes.contains(cell)));
        let (own_links, distance, ignored_pairs) = match (self.own_links, other.own_links) {
            (true, true) => {
                let is_ignored = |(a, b): &&(String, String)| {
                    other.ignored_pairs.iter().any(|(c, d)| (a, b) == (c, d) || (a, b) == (d, c))
                };
                let both = self.ignored_pairs.iter().filter(is_ignored).cloned().collect();
                (true, self.distance.max(other.distance), both)
            }
            (false, true) => (true, other.distance, other.ignored_pairs.clone()),
            (own, false) => (own, self.distance, self.ignored_pairs.clone()),
        };
        SpaceLimits {
            floor: self.floor.into_iter().chain(other.floor).reduce(f64::max),
            walls: walls.cloned().collect(),
            boxes: boxes.cloned().collect(),
            distance,
            own_links,
            ignored_pairs,
        }
    }

    /// Why no robot can keep them, if so.
    pub fn fault(&self) -> Option<String> {
        let (distance, floor) = (self.distance, self.floor.unwrap_or(0.0));
        if !(distance.is_finite() && distance >= 0.0) {
            return Some(format!("space: distance is {distance}; expected are metres, 0 or more"));
        }
        (!floor.is_finite()).then(|| format!("space: floor is {floor}; expected is a height in metres"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_rooms_hold() {
        let pair = |a: &str, b: &str| (a.to_string(), b.to_string());
        let a = SpaceLimits {
            floor: Some(0.1),
            distance: 0.02,
            ignored_pairs: vec![pair("hand", "base"), pair("hand", "arm")],
            ..SpaceLimits::default()
        };
        let wall = Wall { point: [1.0, 0.0, 0.0], normal: [-1.0, 0.0, 0.0], links: None };
        let b = SpaceLimits {
            floor: Some(0.0),
            walls: vec![wall.clone()],
            ignored_pairs: vec![pair("base", "hand")],
            ..SpaceLimits::default()
        };
        for (one, other) in [(&a, &b), (&b, &a)] {
            let both = one.with(other);
            assert_eq!((both.floor, both.distance, both.walls.len()), (Some(0.1), 0.02, 1));
            assert_eq!(both.ignored_pairs.len(), 1);
            assert_eq!(both.with(other), both);
        }
        let blind = SpaceLimits { own_links: false, ..SpaceLimits::default() };
        assert!(blind.with(&a).own_links && blind.with(&a).ignored_pairs == a.ignored_pairs && a.with(&blind) == a);
    }
}
