//! Khalil-Kleinfinger frames for a tree of joints given by arbitrary axes and origins.
//!
//! Frame j has its z along the axis of joint j. Its x and its origin on the axis are free and are chosen to make the
//! parameters sparse. Its x lies along the common normal of its axis and the axis of its main child (the child with the
//! longest chain), so that this child has gamma = b = 0. Other children use gamma and b. Where axes are parallel the normal
//! is free along them and r_j = 0 is chosen. Where they coincide theta_j = 0 as well. Where they are nearly parallel the
//! frame stays at the joint of the file. A last link has theta_j = r_j = 0. The line of a prismatic joint may pass
//! anywhere: the line of a last link passes through the origin of its antecedent.

use crate::angle_snap::{AngleSnapping, computed_angle, computed_length, exact};
use crate::inertial::Pose;
use crate::robot::ModifiedDh;
use crate::vector::{Vector3, cross, dot, minus, norm, plus_scaled, scaled, transposed, turned};

/// A joint and the link it moves, in the frames of a file.
#[derive(Clone, Debug)]
pub(in crate::format) struct JointPlacement {
    /// Index of the antecedent, which is smaller than the own index.
    pub antecedent: Option<usize>,
    /// The pose of the joint frame at q = 0 in the joint frame of the antecedent.
    pub pose: Pose,
    /// Unit vector of the axis in the joint frame.
    pub axis: Vector3,
    pub prismatic: bool,
}

/// A link in its new frame.
#[derive(Clone, Debug)]
pub(in crate::format) struct Framed {
    pub geometry: ModifiedDh,
    /// The pose of the file's joint frame in the link frame.
    pub file_frame: Pose,
}

/// Largest sine of the angle between axes that count as parallel.
const PARALLEL_SINE: f64 = 1e-9;
/// Largest distance of axes that count as one, m.
const COINCIDENT_DISTANCE_M: f64 = 1e-11;
/// Largest cosine of the angle between directions that count as perpendicular. It covers the rounding of unit vectors after
/// the rotations of a robot's chain.
const PERPENDICULAR_COSINE: f64 = 1e-12;

/// The common normal of axes between [`PARALLEL_SINE`] and this angle, rad, is far away. The frames then have their origins
/// at the joints of the file, with non-zero gamma, b and r.
pub(in crate::format) const NEARLY_PARALLEL_RAD: f64 = 0.01;
/// Axes with a smaller angle, rad, are made parallel: the error of an axis with five digits. An axis of four digits or a
/// calibrated axis is kept.
const TAKEN_AS_PARALLEL_RAD: f64 = 5e-5;
/// Axes with a smaller angle, rad, are made parallel where angles stay as given. The common normal would be 1e7 m away for
/// every metre between the axes, and a frame computed from it would lose 1e-9 m.
const LOST_TO_ROUNDING_RAD: f64 = 1e-7;

/// An axis that was turned to be parallel to the one before it.
pub(in crate::format) struct MadeParallel {
    pub link: usize,
    pub antecedent: usize,
    /// The angle by which it was turned, rad.
    pub angle: f64,
}

/// Makes axes that are almost parallel to the axis of their antecedent exactly parallel. Returns the changed axes.
pub(in crate::format) fn make_parallel<'a>(
    links: impl IntoIterator<Item = &'a mut JointPlacement>,
    angles: AngleSnapping,
) -> Vec<MadeParallel> {
    let tolerance = if angles == AngleSnapping::Meant { TAKEN_AS_PARALLEL_RAD } else { LOST_TO_ROUNDING_RAD };
    let mut made = Vec::new();
    let mut axes: Vec<Vector3> = Vec::new();
    for (link, given) in links.into_iter().enumerate() {
        if let Some(antecedent) = given.antecedent {
            // The axis of the antecedent, in this joint's frame.
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

/// The frames of all links, in their order.
pub(in crate::format) fn frames(links: &[JointPlacement]) -> Vec<Framed> {
    let main = main_children(links);
    let mut framed: Vec<Framed> = Vec::with_capacity(links.len());
    for (j, link) in links.iter().enumerate() {
        let before = link.antecedent.map_or(Pose::IDENTITY, |i| framed[i].file_frame);
        // The joint frame of j, its axis and a point of it, in the new frame of its antecedent.
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

/// The child of each link with the longest chain; of several the first one.
fn main_children(links: &[JointPlacement]) -> Vec<Option<usize>> {
    let mut chain = vec![1usize; links.len()];
    let mut main: Vec<Option<usize>> = vec![None; links.len()];
    for (j, link) in links.iter().enumerate().rev() {
        let Some(i) = link.antecedent else { continue };
        // In reverse order, so that the first child with the longest chain wins.
        if chain[j] + 1 >= chain[i] {
            chain[i] = chain[j] + 1;
            main[i] = Some(j);
        }
    }
    main
}

/// The common normal from the z axis of a frame to another axis.
struct Normal {
    gamma: f64,
    b: f64,
    alpha: f64,
    d: f64,
    /// Unit vector along the normal.
    direction: Vector3,
    /// The foot of the normal on the other axis.
    foot: Vector3,
    /// Whether the foot is far away, since the axes are nearly parallel.
    far: bool,
}

impl Normal {
    /// The placement along the normal, then by theta and r about and along the other axis.
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
        // With d = 0 the sign of the normal is the sign of alpha.
        let (direction, gamma, d) = nearer(across, distance);
        let alpha = (sine * dot(direction, across).signum()).atan2(az);
        let far = sine < NEARLY_PARALLEL_RAD;
        Normal { gamma, b: point[2] + t * az, alpha, d, direction, foot: plus_scaled(point, axis, t), far }
    }

    /// r of a frame with a free origin on the axis: at the foot of the normal, or at `point` where the foot is far away.
    fn nearby(&self, point: Vector3, axis: Vector3) -> f64 {
        if self.far { dot(minus(point, self.foot), axis) } else { 0.0 }
    }
}

/// Chooses between a direction in the xy plane and its opposite: the direction nearer to x; if both are equally near, the
/// direction with a positive distance. Returns it with its angle and the signed distance along it.
fn nearer(direction: Vector3, distance: f64) -> (Vector3, f64, f64) {
    let opposite = direction[0] < -PERPENDICULAR_COSINE
        || (direction[0].abs() <= PERPENDICULAR_COSINE && distance < -COINCIDENT_DISTANCE_M);
    let sign = if opposite { -1.0 } else { 1.0 };
    let direction = scaled(direction, sign);
    (direction, direction[1].atan2(direction[0]), sign * distance)
}

/// theta and r that bring the frame of an axis onto its common normal with the child's axis.
/// The child's line passes through `child_point`, or for `None` through the chosen origin. `nearby`: the r of a frame with
/// a free origin on the axis.
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
    // For parallel axes the origin along them is free, for coincident axes the direction too.
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
        // The foot of the common normal on the axis: the point of closest approach of two lines.
        (false, Some(offset)) => (scaled(across, 1.0 / sine), dot(cross(offset, child_axis), across) / (sine * sine)),
    };
    // Of the two senses of the normal: |theta| is at most 90 degrees, and at 90 degrees it points to the child.
    let along = dot(normal.direction, direction);
    let distance = offset.map_or(0.0, |o| dot(o, direction));
    let opposite =
        along < -PERPENDICULAR_COSINE || (along.abs() <= PERPENDICULAR_COSINE && distance < -COINCIDENT_DISTANCE_M);
    let direction = if opposite { scaled(direction, -1.0) } else { direction };
    (dot(cross(normal.direction, direction), axis).atan2(dot(normal.direction, direction)), r)
}

/// gamma, b, alpha, d, theta, r of a frame with this pose.
pub(in crate::format) fn placement(frame: &Pose) -> ModifiedDh {
    let [x, z] = [0, 2].map(|k| frame.rotation.map(|row| row[k]));
    let normal = Normal::from_z(frame.position, z);
    let theta = dot(cross(normal.direction, x), z).atan2(dot(normal.direction, x));
    normal.placement(theta, dot(minus(frame.position, normal.foot), z))
}
