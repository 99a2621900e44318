//! Default distances that a motion keeps: to position limits, between links, and to the floor.
//!
//! The user can change these distances. A search tries them in steps: each step is one distance between bodies, with or without
//! an assumed floor at the plane of the base. A gap is a pair of bodies, or a body and a floor or wall, with a least allowed
//! distance.

use experiments::excitation::gap_proof::Gap;
use experiments::excitation::limits::{AskedLimits, CoordinateLimits, LimitKind};

use crate::describe::model::Model;
use crate::request::ExciteRequest;

/// Default distance of revolute joints to their position limits, rad. This distance exceeds usual errors of encoder zero and
/// tracking.
const DISTANCE_FROM_ENDS_RAD: f64 = 0.02;
/// The default distance to a position limit is at most this share of the joint's range, so that joints with a small range can
/// move.
const SHARE_OF_RANGE: f64 = 0.02;
/// Default distances between links and to the floor, m, in the order in which they are tried. The second distance is also
/// required by a check of motions from other sources.
const SPACINGS_M: [f64; 3] = [0.02, 0.01, 0.005];

/// The default distances between bodies in one step of a search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct KeptRoom {
    /// Whether the plane of the base is assumed to be the floor.
    pub(crate) assumes_floor: bool,
    /// Distance between links and to the assumed floor, m. If two bodies cannot be so far apart, at most half of their largest
    /// possible distance is required.
    pub(crate) spacing: Option<f64>,
}

impl KeptRoom {
    /// The default distances to try, in this order: first with an assumed floor, then without a floor.
    pub(crate) fn steps(request: &ExciteRequest) -> Vec<KeptRoom> {
        let space = request.space();
        let spacings = match space.spacing {
            Some(given) => vec![given],
            None => SPACINGS_M.to_vec(),
        };
        let step = |assumes_floor: bool| move |spacing: &f64| KeptRoom { assumes_floor, spacing: Some(*spacing) };
        let with_floor = spacings.iter().take(2).filter(|_| space.floor.is_none()).map(step(true));
        with_floor.chain(spacings.iter().map(step(false))).collect()
    }

    /// A note on the distances; `None` if no pair of bodies keeps a default distance.
    pub(crate) fn note(&self, request: &ExciteRequest, gaps: &[Gap]) -> Option<String> {
        let (space, spacing) = (request.space(), self.spacing?);
        let has = |limit: LimitKind| gaps.iter().any(|gap| gap.limit == limit);
        let between = (has(LimitKind::Distance) && space.distance.is_none()).then_some("each other");
        let to_floor = (has(LimitKind::Region) && space.floor.is_none()).then_some("the floor of the base");
        let whom: Vec<&str> = between.into_iter().chain(to_floor).collect();
        let lowered = match space.spacing.is_none() && spacing < SPACINGS_M[0] {
            true => format!("; no motion was found that keeps {} m", SPACINGS_M[0]),
            false => String::new(),
        };
        (!whom.is_empty()).then(|| {
            format!(
                "links keep {spacing} m to {}, or half of the room that they have{lowered} (space: {{spacing: {spacing}}} in \
                 [limits=FILE] says otherwise)",
                whom.join(" and ")
            )
        })
    }
}

/// Narrows the position limits of revolute joints by the default distance, if only the description gives limits and no margin
/// of joints is given. Returns a note on the narrowed limits.
pub(crate) fn keep_from_ends(
    model: &Model,
    request: &ExciteRequest,
    limits: &mut [CoordinateLimits],
) -> Option<String> {
    let file = request.limits.clone().unwrap_or_default();
    if file.margins.encoder_zero.is_some() || file.margins.tracking.is_some() || file.all.position.is_some() {
        return None;
    }
    let mut is_any = false;
    for (k, (limits, coordinate)) in limits.iter_mut().zip(&model.robot.coordinates).enumerate() {
        let is_described = AskedLimits::of_description(&coordinate.limits).position.is_some();
        let is_asked = file.of(&coordinate.name).position.is_some();
        if is_asked || !is_described || limits.locked.is_some() || model.regressor().is_prismatic(k) {
            continue;
        }
        let (low, high) = limits.position;
        let by = DISTANCE_FROM_ENDS_RAD.min(SHARE_OF_RANGE * (high - low));
        limits.position = (low + by, high - by);
        is_any = true;
    }
    is_any.then(|| {
        format!(
            "joints keep {DISTANCE_FROM_ENDS_RAD} rad, or {} % of their room, to the ends of their positions (margins: {{tracking: 0}} in \
             [limits=FILE] says otherwise)",
            100.0 * SHARE_OF_RANGE
        )
    })
}
