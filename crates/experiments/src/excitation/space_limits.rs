//! Limits of the bodies of a robot in space: boxes, floors, walls, and distances between the robot's own links.
//!
//! Positions are in the base frame, m. The limits in a motion's file can only make its check stricter; only the user can exclude
//! something from a check. Not here: the bodies themselves, which come from the description.

use serde::{Deserialize, Serialize};

/// Limits of the robot's bodies in space, as a limits file or a motion's file gives them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SpaceLimits {
    /// Lowest allowed height of moving links: z in the base frame (m) or `none` (no floor). Not given: the plane z = 0 of the
    /// base, if no moving link is below it at the zero pose.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub floor: Option<Floor>,
    /// Planes that bound the space of the links on one side.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub walls: Vec<Wall>,
    /// Boxes that links must stay in.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub boxes: Vec<SpaceBox>,
    /// Least allowed distance between links of the robot, m. Not given: the smaller of `spacing` and half of the distance that
    /// the pair exceeds in a tenth of the sampled poses.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub distance: Option<f64>,
    /// Default for `distance` and for the distance to the plane of the base, if these are not given, m. A pair with little room
    /// keeps less (see `distance`). Not given: a search keeps 0.02 if a motion can; a check requires 0.01 between links and 0 to
    /// the plane.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spacing: Option<f64>,
    /// Whether distances between the robot's own links are checked.
    pub own_links: bool,
    /// Pairs of links that may touch and are not checked, each with the reason: `[LINK, LINK, REASON]`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub accept: Vec<Vec<String>>,
    /// Pairs of links that motion files of an earlier version excluded from the check. In a limits file, such pairs are an
    /// error.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub ignored_pairs: Vec<(String, String)>,
}

/// The floor of a space limit: a height, or the word `none`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Floor {
    /// A floor at this height in the base frame, m.
    At(f64),
    /// `none`: there is no floor.
    Word(FloorWord),
}

/// The word that a file gives instead of a floor's height.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FloorWord {
    /// `none`: no floor.
    None,
}

impl Floor {
    /// A floor limit that says explicitly that there is no floor.
    pub const NOWHERE: Floor = Floor::Word(FloorWord::None);

    /// Height of the floor in the base frame, m; `None` if there is no floor.
    pub fn height(self) -> Option<f64> {
        match self {
            Floor::At(height) => Some(height),
            Floor::Word(FloorWord::None) => None,
        }
    }
}

impl Default for SpaceLimits {
    fn default() -> SpaceLimits {
        SpaceLimits {
            floor: None,
            walls: vec![],
            boxes: vec![],
            distance: None,
            spacing: None,
            own_links: true,
            accept: vec![],
            ignored_pairs: vec![],
        }
    }
}

/// A plane in the base frame; links must stay on its allowed side.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Wall {
    /// A point on the plane, base frame, m.
    pub point: [f64; 3],
    /// Normal vector of the plane towards the allowed side, of any length.
    pub normal: [f64; 3],
    /// Names of the links that must stay on the allowed side. `None`: all moving links.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub links: Option<Vec<String>>,
}

/// A box along the axes of the base frame, in which links must stay.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpaceBox {
    /// Corner with the least x, y, z, m.
    pub low: [f64; 3],
    /// Corner with the greatest x, y, z, m.
    pub high: [f64; 3],
    /// Names of the links that must stay in the box. `None`: all moving links.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub links: Option<Vec<String>>,
}

impl SpaceLimits {
    /// The space limits for the check of a motion: the limits of the user, tightened by `self`, the limits in the motion's file.
    /// The motion's file cannot exclude anything from the check.
    pub fn held_to(&self, user: &SpaceLimits) -> SpaceLimits {
        let walls = user.walls.iter().chain(self.walls.iter().filter(|wall| !user.walls.contains(wall)));
        let boxes = user.boxes.iter().chain(self.boxes.iter().filter(|cell| !user.boxes.contains(cell)));
        let own = self.floor.and_then(Floor::height);
        let floor = match (user.floor, own) {
            (Some(Floor::At(asked)), Some(own)) => Some(Floor::At(asked.max(own))),
            (asked, _) => asked,
        };
        SpaceLimits {
            floor,
            walls: walls.cloned().collect(),
            boxes: boxes.cloned().collect(),
            distance: self.distance.into_iter().chain(user.distance).reduce(f64::max),
            spacing: self.spacing.into_iter().chain(user.spacing).reduce(f64::max),
            ..user.clone()
        }
    }

    /// The pairs of links that may touch, as (link, link, reason).
    pub fn accepted(&self) -> Vec<(String, String, String)> {
        let triple = |pair: &Vec<String>| match &pair[..] {
            [a, b, reason] => Some((a.clone(), b.clone(), reason.clone())),
            _ => None,
        };
        self.accept.iter().filter_map(triple).collect()
    }

    /// The reason why these space limits are invalid; `None` if they are valid.
    pub fn fault(&self) -> Option<String> {
        let lengths = [("distance", self.distance), ("spacing", self.spacing)];
        let mut given = lengths.into_iter().filter_map(|(key, x)| Some((key, x?)));
        if let Some((key, x)) = given.find(|(_, x)| !(x.is_finite() && *x >= 0.0)) {
            return Some(format!("space: {key} is {x}; expected are metres, 0 or more"));
        }
        if let Some(floor) = self.floor.and_then(Floor::height).filter(|x| !x.is_finite()) {
            return Some(format!("space: floor is {floor}; expected is a height in metres, or none"));
        }
        if let Some((a, b)) = self.ignored_pairs.first() {
            return Some(format!(
                "space: ignored_pairs has no reasons; sign each pair by its links' own names: accept: [[{a}, {b}, why they may \
                 meet]]"
            ));
        }
        let is_signed = |pair: &&Vec<String>| pair.len() == 3 && pair.iter().all(|word| !word.trim().is_empty());
        let unsigned = self.accept.iter().find(|pair| !is_signed(pair))?;
        Some(format!(
            "space: accept has [{}]; expected are two links and the reason: [LINK, LINK, why they may meet]",
            unsigned.join(", ")
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use linear_model::yaml;

    fn read(text: &str) -> SpaceLimits {
        yaml::read(text).unwrap()
    }

    #[test]
    fn a_file_tightens_and_leaves_nothing_out() {
        let user = read("{floor: 0.1, accept: [[hand, base, soft]], walls: [{point: [1, 0, 0], normal: [-1, 0, 0]}]}");
        let own = read(
            "{floor: 0.2, distance: 0.02, own_links: false, ignored_pairs: [[hand, arm]], walls: [{point: \
                        [1, 0, 0], normal: [-1, 0, 0]}]}",
        );
        let held = own.held_to(&user);
        assert_eq!((held.floor, held.distance, held.walls.len()), (Some(Floor::At(0.2)), Some(0.02), 1));
        assert!(held.own_links && held.ignored_pairs.is_empty() && held.accept == user.accept);
        assert_eq!(read("floor: 0.1").held_to(&read("floor: 0.3")).floor, Some(Floor::At(0.3)));
        assert_eq!(read("floor: 0.1").held_to(&read("floor: none")).floor, Some(Floor::NOWHERE));
        assert_eq!(read("floor: none").held_to(&SpaceLimits::default()), SpaceLimits::default());
    }

    #[test]
    fn a_pair_is_signed_with_a_reason() {
        assert_eq!(read("accept: [[hand, base, the cover is soft]]").fault(), None);
        for text in ["accept: [[hand, base]]", "accept: [[hand, base, \" \"]]", "accept: [[hand]]"] {
            let (fault, end) = (read(text).fault().unwrap(), ": [LINK, LINK, why they may meet]");
            assert!(fault.ends_with(&format!("expected are two links and the reason{end}")), "{fault}");
        }
        let fault = read("ignored_pairs: [[hand, base]]").fault().unwrap();
        assert!(fault.contains("accept: [[hand, base, why they may meet]]"), "{fault}");
        assert_eq!(read("floor: none").fault(), None);
        let nowhere = SpaceLimits { floor: Some(Floor::At(f64::NAN)), ..SpaceLimits::default() };
        assert!(nowhere.fault().unwrap().contains("floor is NaN"));
        assert!(read("distance: -1.0").fault().unwrap().contains("distance is -1;"));
    }
}
