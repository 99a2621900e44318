//! The ten inertial parameters under a change of frame, and the parts a file lumps into a link.

/// Placement of a frame b in a frame a: `R_ab` orientation (rows), `p_ab` position, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    pub rotation: [[f64; 3]; 3],
    pub position: [f64; 3],
}

impl Pose {
    pub const IDENTITY: Pose =
        Pose { rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], position: [0.0; 3] };
}

/// A rigid part of a link, as its file describes it.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// The part's name in the file (a URDF link).
    pub name: String,
    /// Its inertial frame (origin at the centre of mass) in the link frame.
    pub pose: Pose,
    /// kg.
    pub mass: f64,
    /// Inertia about the centre of mass, in the inertial frame, kg m^2: xx xy xz yy yz zz.
    pub inertia: [f64; 6],
}
