//! The rules for a robot's bodies, and the situation that determines its gaps.

use crate::body_errors::BodyErrors;
use crate::half_space::HalfSpace;

/// The rules for a robot's bodies.
#[derive(Clone, Debug)]
pub struct ClearanceRules {
    /// Whether distances between the robot's own links are checked.
    pub own_links: bool,
    /// Least distance of two links, m. `None`: the spacing, or half of the room of the pair where this is less.
    pub distance: Option<f64>,
    /// Pairs of links without a check of their distance, each with the reason.
    pub accepted: Vec<(String, String, String)>,
    /// The floor that no moving body goes below.
    pub floor: FloorRule,
    /// Half-spaces that bodies must stay in.
    pub half_spaces: Vec<HalfSpace>,
    /// Position errors of bodies.
    pub errors: BodyErrors,
    /// Distance that two links, or a link and an assumed floor, keep where they have room for it, m. `None`:
    /// [`crate::gaps::DEFAULT_DISTANCE_M`] for links, 0 to the floor.
    pub spacing: Option<f64>,
    /// Whether the plane of the base is a floor for a robot that stands on it, even if a body is below it at the zero pose.
    pub assumes_floor: bool,
    /// Whether the computation is cancelled.
    pub is_over: fn() -> bool,
}

/// The choice of the floor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FloorRule {
    /// The plane z = 0 of the base where no body is below it at rest, but not below the given height, m.
    OfBase(Option<f64>),
    /// No floor, by the user's rule.
    Nowhere,
    /// At this height, m.
    At(f64),
}

impl Default for ClearanceRules {
    fn default() -> ClearanceRules {
        ClearanceRules {
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

/// The rest pose and the moving coordinates, which determine the gaps.
#[derive(Clone, Debug)]
pub struct Situation {
    /// Rest position of each coordinate, rad (m): where it is locked, otherwise zero, or as near to zero as its limits allow.
    pub rest: Vec<f64>,
    /// The zero pose, or as near to it as the limits of the description allow.
    pub zero: Vec<f64>,
    /// Whether each coordinate moves.
    pub moves: Vec<bool>,
    /// Poses all over the limits of the description, which show the links that always touch.
    pub poses: Vec<Vec<f64>>,
}
