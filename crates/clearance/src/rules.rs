//! The rules for the distances that the bodies of a robot must keep, and the sampled poses from which the list of these distances
//! is determined.

use crate::body_errors::BodyErrors;
use crate::half_space::HalfSpace;

/// The rules for the distances that the bodies of a robot must keep.
#[derive(Clone, Debug)]
pub struct ClearanceRules {
    /// Whether the distances between the links of the robot are checked.
    pub own_links: bool,
    /// Least distance between two links, m. `None`: the smaller of `spacing` and half of the room of the pair. Room: the
    /// distance that the pair exceeds in a tenth of the sampled poses.
    pub distance: Option<f64>,
    /// Pairs of links that are not checked, each with the reason: (link, link, reason).
    pub accepted: Vec<(String, String, String)>,
    /// The floor: no moving body may go below it.
    pub floor: FloorRule,
    /// Half-spaces in which bodies must stay.
    pub half_spaces: Vec<HalfSpace>,
    /// Position errors of bodies and joints, by which the least distances are increased.
    pub errors: BodyErrors,
    /// Default of the least distance between two links, and between a link and an assumed floor, m. Pairs with little room keep
    /// less (see `distance`). `None`: [`crate::gaps::DEFAULT_DISTANCE_M`] for links, 0 for the floor.
    pub spacing: Option<f64>,
    /// For a robot that stands on the plane of its base: whether this plane is a floor even if a body is below it at the zero
    /// pose.
    pub assumes_floor: bool,
    /// Returns true if the computation is to be cancelled.
    pub is_over: fn() -> bool,
}

/// The rule that determines the floor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FloorRule {
    /// The plane z = 0 of the base is a floor if no moving body is below it at the zero pose. A height (m) may be given: then
    /// the floor is the higher of this height and the plane, or the height alone if a body is below the plane.
    OfBase(Option<f64>),
    /// No floor, because the user requests none.
    Nowhere,
    /// A floor at this height, m.
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

/// The poses and the moving coordinates from which the distances (gaps) that a robot must keep are determined.
#[derive(Clone, Debug)]
pub struct Situation {
    /// Rest position of each coordinate, rad (m). A locked coordinate: its locked position. Any other coordinate: zero, or the
    /// position within its limits that is nearest to zero.
    pub rest: Vec<f64>,
    /// The zero pose, rad (m): each coordinate at zero, or at the position within its limits that is nearest to zero.
    pub zero: Vec<f64>,
    /// For each coordinate, whether it moves (is not locked).
    pub moves: Vec<bool>,
    /// Poses distributed over the whole joint limits, rad (m), one position per coordinate. They are used to find links that
    /// always touch.
    pub poses: Vec<Vec<f64>>,
}
