//! What is asked of a robot's bodies, and the situation by which its gaps are chosen.

use crate::body_errors::BodyErrors;
use crate::half_space::HalfSpace;

/// What is asked of a robot.
#[derive(Clone, Debug)]
pub struct Rules {
    /// Whether distances between the robot's own links are looked at.
    pub own_links: bool,
    /// Least distance of two links, m. `None`: the spacing, or half of the room that the two have where that is less.
    pub distance: Option<f64>,
    /// Pairs of links whose distance is not looked at, each with the reason.
    pub accepted: Vec<(String, String, String)>,
    /// Where no moving body goes below.
    pub floor: FloorRule,
    /// Where bodies must stay.
    pub half_spaces: Vec<HalfSpace>,
    /// How far bodies may be from where the joints put them.
    pub errors: BodyErrors,
    /// Distance that two links, and a link and a floor that nobody asked for, keep where they have room for it, m. `None`:
    /// [`crate::gaps::DEFAULT_DISTANCE_M`], and nothing to the floor.
    pub spacing: Option<f64>,
    /// Whether the plane of the base is a floor for a robot that stands on it, though at the zero pose a body is below.
    pub assumes_floor: bool,
    /// Whether whoever waits for the gaps has given up.
    pub is_over: fn() -> bool,
}

/// Which floor there is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FloorRule {
    /// The plane z = 0 of the base where no body is below it at rest, but no lower than the height that is given.
    OfBase(Option<f64>),
    /// None, as the user says.
    Nowhere,
    /// At this height, m.
    At(f64),
}

impl Default for Rules {
    fn default() -> Rules {
        Rules {
            own_links: true,
            distance: None,
            accepted: vec![],
            floor: FloorRule::OfBase(None),
            half_spaces: vec![],
            errors: BodyErrors::default(),
            spacing: None,
            assumes_floor: false,
            is_over: || false,
        }
    }
}

/// The rest pose and the moving coordinates, by which gaps are chosen.
#[derive(Clone, Debug)]
pub struct Situation {
    /// Where each coordinate rests, rad (m): where it is locked, or else zero, or as near to it as its limits allow.
    pub rest: Vec<f64>,
    /// Zero, or as near to it as the limits of the description allow.
    pub zero: Vec<f64>,
    /// Whether each coordinate moves.
    pub moves: Vec<bool>,
    /// Poses all over the limits of the description, by which it is told who always touches.
    pub poses: Vec<Vec<f64>>,
}
