//! Computes Khalil-Kleinfinger frames for a tree of joints with arbitrary axes and origins.
//!
//! Frame j has its z along the axis of joint j. Its x axis, and the position of its origin on the joint axis, can be chosen. They
//! are chosen such that many parameters are zero: x lies along the common normal of the joint's axis and the axis of its main
//! child (the child with the longest chain). So the main child has gamma = b = 0; other children need gamma and b. Special cases:
//! - Parallel axes: the position of the normal is free, and r_j = 0 is chosen.
//! - Coincident axes: also theta_j = 0 is chosen.
//! - Nearly parallel axes: the origin stays at the joint of the file.
//! - A last link has theta_j = r_j = 0.
//! - A prismatic axis may be shifted: the axis of a last link passes through the origin of its antecedent.

use crate::angle_snap::{AngleSnapping, computed_angle, computed_length, exact};
use crate::inertial::Pose;
use crate::robot::ModifiedDh;
use crate::vector::{Vector3, cross, dot, minus, norm, plus_scaled, scaled, transposed, turned};

/// The placement of a joint in the frames of a file.
#[derive(Clone, Debug)]
pub(in crate::format) struct JointPlacement {
    /// Index of the antecedent, which is smaller than the index of this joint; `None` for the base.
    pub antecedent: Option<usize>,
    /// Pose of the joint frame at q = 0 in the joint frame of the antecedent.
    pub pose: Pose,
    /// Unit vector along the joint axis, in the joint frame.
    pub axis: Vector3,
    pub prismatic: bool,
}

/// The placement of a link's new frame.
#[derive(Clone, Debug)]
pub(in crate::format) struct Framed {
    pub geometry: ModifiedDh,
    /// Pose of the file's joint frame in the new link frame.
    pub file_frame: Pose,
}

/// Axes count as parallel if the sine of the angle between them is at most this value.
const PARALLEL_SINE: f64 = 1e-9;
/// Parallel axes count as coincident if their distance is at most this value, m.
const COINCIDENT_DISTANCE_M: f64 = 1e-11;
/// Directions count as perpendicular if the cosine of the angle between them is at most this value. Unit vectors that were
/// rotated along a whole robot chain have smaller rounding errors.
const PERPENDICULAR_COSINE: f64 = 1e-12;

/// If the angle between two axes (rad) is above [`PARALLEL_SINE`] and below this value, their common normal is far away. The
/// origins of the frames are then at the joints of the file, with non-zero gamma, b and r.
pub(in crate::format) const NEARLY_PARALLEL_RAD: f64 = 0.01;
/// Two axes are made parallel if the angle between them is smaller than this value, rad. An axis with five digits has an error
/// of this size. An axis with four digits or a calibrated axis is kept.
const TAKEN_AS_PARALLEL_RAD: f64 = 5e-5;
/// Two axes are made parallel, even if angles are kept as given, if the angle between them is smaller than this value, rad.
/// Their common normal would be 1e7 m away per metre between the axes, and a frame computed from it would have an error of 1e-9
/// m.
const LOST_TO_ROUNDING_RAD: f64 = 1e-7;

/// A joint axis that was rotated to be parallel to the axis of its antecedent.
pub(in crate::format) struct MadeParallel {
    pub link: usize,
    pub antecedent: usize,
    /// Angle by which the axis was rotated, rad.
    pub angle: f64,
}

/// Makes each axis exactly parallel to the axis of its antecedent (parent) if it is almost parallel. Returns the changed axes.
pub(in crate::format) fn make_parallel<'a>(
    links: impl IntoIterator<Item = &'a mut JointPlacement>,
    angles: AngleSnapping,
) -> Vec<MadeParallel> {
    let tolerance = if angles == AngleSnapping::Meant { TAKEN_AS_PARALLEL_RAD } else { LOST_TO_ROUNDING_RAD };
    let mut made = Vec::new();
    let mut axes: Vec<Vector3> = Vec::new();
    for (link, given) in links.into_iter().enumerate() {
        if let Some(antecedent) = given.antecedent {
            // The axis of the antecedent in the frame of this joint.
            let before = turned(&transposed(&given.pose.rotation), axes[antecedent]);
            let angle = norm(cross(before, given.axis));
            if angle > PARALLEL_SINE && angle < tolerance {
                given.axis = scaled(before, dot(before, given.axis).signum() / norm(before));
                made.push(MadeParallel { link, antecedent, angle });
            }
        }
        axes.push(given.axis);
    }
    made
}

/// The frames of all links, in the order of the links.
pub(in crate::format) fn frames(links: &[JointPlacement]) -> Vec<Framed> {
    let main = main_children(links);
    let mut framed: Vec<Framed> = Vec::with_capacity(links.len());
    for (j, link) in links.iter().enumerate() {
        let before = link.antecedent.map_or(Pose::IDENTITY, |i| framed[i].file_frame);
        // In the new frame of the antecedent (parent): the joint frame of j, the joint axis, and a point on the axis.
        let joint = before.compose(&link.pose);
        let axis = turned(&joint.rotation, link.axis);
        let point = if link.prismatic && main[j].is_none() { [0.0; 3] } else { joint.position };
        let normal = Normal::from_z(point, axis);
        let (theta, r) = match main[j] {
            None => (0.0, normal.nearby(point, axis)),
            Some(m) => {
                let child = joint.compose(&links[m].pose);
                let own = main[m].is_none() && links[m].prismatic;
                let child_axis = turned(&child.rotation, links[m].axis);
                towards(
                    &normal,
                    axis,
                    normal.nearby(point, axis),
                    if own { None } else { Some(child.position) },
                    child_axis,
                )
            }
        };
        let geometry = normal.placement(theta, r);
        let frame = geometry.pose(&[], 0.0, 0.0).inverse().compose(&joint);
        let position = frame.position.map(|x| computed_length(x).number(&[]));
        framed.push(Framed { geometry, file_frame: Pose { rotation: exact(&frame.rotation), position } });
    }
    framed
}

/// The main child of each link: the child with the longest chain of joints. If several chains are equally long, it is the first
/// of these children. `None` if a link has no child.
fn main_children(links: &[JointPlacement]) -> Vec<Option<usize>> {
    let mut chain = vec![1usize; links.len()];
    let mut main: Vec<Option<usize>> = vec![None; links.len()];
    for (j, link) in links.iter().enumerate().rev() {
        let Some(i) = link.antecedent else { continue };
        // The links are visited in reverse order, and `>=` replaces an equal chain. So the first of several longest chains is
        // chosen.
        if chain[j] + 1 >= chain[i] {
            chain[i] = chain[j] + 1;
            main[i] = Some(j);
        }
    }
    main
}

/// The common normal from the z axis of a frame to another axis, with its parameters gamma, b, alpha and d.
struct Normal {
    gamma: f64,
    b: f64,
    alpha: f64,
    d: f64,
    /// Unit vector along the common normal.
    direction: Vector3,
    /// Intersection of the normal with the other axis (foot).
    foot: Vector3,
    /// Whether the foot is far away because the axes are nearly parallel.
    far: bool,
}

impl Normal {
    /// The placement of a frame: along this common normal to the axis of the frame, then by theta about this axis and by r
    /// along this axis.
    fn placement(&self, theta: f64, r: f64) -> ModifiedDh {
        ModifiedDh {
            gamma: computed_angle(self.gamma),
            b: computed_length(self.b),
            alpha: computed_angle(self.alpha),
            d: computed_length(self.d),
            theta: computed_angle(theta),
            r: computed_length(r),
        }
    }

    fn from_z(point: Vector3, axis: Vector3) -> Normal {
        let [ax, ay, az] = axis;
        let sine = ax.hypot(ay);
        if sine < PARALLEL_SINE {
            let alpha = if az > 0.0 { 0.0 } else { std::f64::consts::PI };
            let distance = point[0].hypot(point[1]);
            let along = if distance < COINCIDENT_DISTANCE_M {
                [1.0, 0.0, 0.0]
            } else {
                scaled([point[0], point[1], 0.0], 1.0 / distance)
            };
            let (direction, gamma, d) = nearer(along, distance);
            return Normal { gamma, b: 0.0, alpha, d, direction, foot: scaled(direction, d), far: false };
        }
        let across = [-ay / sine, ax / sine, 0.0];
        let t = -(point[0] * ax + point[1] * ay) / (sine * sine);
        let distance = dot(point, across);
        // The sign of alpha follows from the chosen direction of the normal.
        let (direction, gamma, d) = nearer(across, distance);
        let alpha = (sine * dot(direction, across).signum()).atan2(az);
        let far = sine < NEARLY_PARALLEL_RAD;
        Normal { gamma, b: point[2] + t * az, alpha, d, direction, foot: plus_scaled(point, axis, t), far }
    }

    /// The parameter r of a frame whose origin is free on the axis: at the foot of the normal, or at `point` if the foot
    /// is far away.
    fn nearby(&self, point: Vector3, axis: Vector3) -> f64 {
        if self.far { dot(minus(point, self.foot), axis) } else { 0.0 }
    }
}

/// Chooses between a direction in the xy plane and its opposite: the one nearer to the x axis or, if both are equally near, the
/// one with a positive distance. Returns the chosen direction, its angle gamma from x, and the signed distance along it.
fn nearer(direction: Vector3, distance: f64) -> (Vector3, f64, f64) {
    let opposite = direction[0] < -PERPENDICULAR_COSINE
        || (direction[0].abs() <= PERPENDICULAR_COSINE && distance < -COINCIDENT_DISTANCE_M);
    let sign = if opposite { -1.0 } else { 1.0 };
    let direction = scaled(direction, sign);
    (direction, direction[1].atan2(direction[0]), sign * distance)
}

/// theta and r of a frame, such that its x axis lies on the common normal of its axis and the child's axis. `child_point`: a
/// point on the child's axis; `None` if the child's axis passes through the origin that is chosen. `nearby`: the value of r if
/// the origin can be anywhere on the axis.
fn towards(
    normal: &Normal,
    axis: Vector3,
    nearby: f64,
    child_point: Option<Vector3>,
    child_axis: Vector3,
) -> (f64, f64) {
    let across = cross(axis, child_axis);
    let sine = norm(across);
    let offset = child_point.map(|p| minus(p, normal.foot));
    // If the two axes are parallel, the position of the origin along them is free. If they coincide, the direction of x is free
    // too.
    let parallel = sine < if child_point.is_some() { NEARLY_PARALLEL_RAD } else { PARALLEL_SINE };
    let (direction, r) = match (parallel, offset) {
        (true, None) => return (0.0, nearby),
        (true, Some(offset)) => {
            let sideways = plus_scaled(offset, axis, -dot(offset, axis));
            if norm(sideways) < COINCIDENT_DISTANCE_M {
                return (0.0, nearby);
            }
            (scaled(sideways, 1.0 / norm(sideways)), nearby)
        }
        (false, None) => (scaled(across, 1.0 / sine), nearby),
        // r is the position along the axis of the foot of the common normal: the point where two lines are closest to each other.
        (false, Some(offset)) => (scaled(across, 1.0 / sine), dot(cross(offset, child_axis), across) / (sine * sine)),
    };
    // The direction of the normal is chosen such that |theta| is at most 90 degrees. At 90 degrees it points to the child.
    let along = dot(normal.direction, direction);
    let distance = offset.map_or(0.0, |o| dot(o, direction));
    let opposite =
        along < -PERPENDICULAR_COSINE || (along.abs() <= PERPENDICULAR_COSINE && distance < -COINCIDENT_DISTANCE_M);
    let direction = if opposite { scaled(direction, -1.0) } else { direction };
    (dot(cross(normal.direction, direction), axis).atan2(dot(normal.direction, direction)), r)
}

/// The parameters gamma, b, alpha, d, theta, r of a frame with this pose.
pub(in crate::format) fn placement(frame: &Pose) -> ModifiedDh {
    let [x, z] = [0, 2].map(|k| frame.rotation.map(|row| row[k]));
    let normal = Normal::from_z(frame.position, z);
    let theta = dot(cross(normal.direction, x), z).atan2(dot(normal.direction, x));
    normal.placement(theta, dot(minus(frame.position, normal.foot), z))
}
