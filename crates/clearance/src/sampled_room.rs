//! The room of two links: the distance that they exceed in a tenth of the sampled poses of the robot.
//!
//! If two links touch in nearly every pose, their joints hold them together or their geometry is too large. No motion can
//! separate them. Every other pair is apart in some poses, even if it touches at the zero pose, so its distance can be limited.

use claims::{LeftOut, LeftOutTopic};
use robot::Pose;

use crate::clearance::{Against, Clearance, Gap};
use crate::separation::{apart_along, separation};
use crate::solid::Core;
use robot::vector::{minus, norm};

/// Two bodies count as touching if their distance is less than this value, m.
const TOUCHING_DISTANCE_M: f64 = 1e-6;
/// A pair with a mesh counts as near if its distance is less than this value, m. The meshes of the two sides of a joint are
/// some tenths of a millimetre apart at every angle, and no motion can increase this distance.
const NEAR_MESH_DISTANCE_M: f64 = 5e-4;
/// Links that touch in at least this share of the poses count as always touching.
pub const ALWAYS_TOUCHING_SHARE: f64 = 0.99;
/// The room of a pair is the distance that it exceeds in this share of the poses.
pub(crate) const ROOMY_SHARE: f64 = 0.1;
/// If fewer than [`ROOMY_SHARE`] of the poses have a distance above zero, this share is used instead.
const LEAST_ROOMY_SHARE: f64 = 0.01;

/// The room of a pair of links, or the reason why the pair has none. Room: the distance that the pair exceeds in a tenth of the
/// sampled poses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum SampledRoom {
    /// The links touch in nearly every pose.
    AlwaysTouching,
    /// A link of the pair is a mesh, and in nearly every pose the distance is less than `NEAR_MESH_DISTANCE_M`.
    AlwaysNear,
    /// The room of the pair, m. Values above `enough`, the argument of `sampled_room`, are not exact.
    Room(f64),
}

/// A distance counts as constant if it varies by less than this value (m) over all poses. Computed distances of round surfaces
/// are not more accurate.
const CONSTANT_WITHIN_M: f64 = 5e-4;

/// The note that no margin is kept for some pairs. Each pair consists of the two sides of one joint and has a constant
/// distance. `poses`: number of sampled poses. `None` without pairs.
pub(crate) fn constant_distance(poses: usize, pairs: Vec<String>) -> Option<LeftOut> {
    let what = format!(
        "they are the sides of one joint, and {poses} poses change their distance by less than {} mm: they keep half of it, \
         with no margin",
        1e3 * CONSTANT_WITHIN_M
    );
    (!pairs.is_empty()).then(|| LeftOut::assumed(LeftOutTopic::Margin, pairs, what, "default"))
}

/// The texts of two assumptions: pairs that touch in nearly all poses, and pairs with a mesh that are near in nearly all poses.
pub(crate) fn always(poses: usize) -> [String; 2] {
    let (share, near) = (100.0 * ALWAYS_TOUCHING_SHARE, 1e3 * NEAR_MESH_DISTANCE_M);
    [
        format!("they touch in {share} % of {poses} poses, so that no motion parts them"),
        format!(
            "one is a mesh, and they are nearer than {near} mm in {share} % of {poses} poses; no motion has to part them"
        ),
    ]
}

impl Clearance {
    /// The room of a pair over `poses` (each with one pose per link), and whether its distance is constant. Room: the distance
    /// that the pair exceeds in a tenth of the poses. A room above `enough` is not exact.
    pub(crate) fn sampled_room(&self, gap: &Gap, poses: &[Vec<Pose>], enough: f64) -> (SampledRoom, bool) {
        let count = |share: f64| (share * poses.len() as f64).floor() as usize;
        let (mut rooms, mut ample) = (Vec::with_capacity(poses.len()), 0);
        let near = if self.is_of_mesh(gap) { NEAR_MESH_DISTANCE_M } else { TOUCHING_DISTANCE_M };
        for poses in poses {
            let room = self.room_up_to(gap, poses, enough);
            ample += usize::from(room >= enough);
            if ample > count(ROOMY_SHARE) {
                return (SampledRoom::Room(enough), false);
            }
            rooms.push(room);
        }
        rooms.sort_by(|a, b| b.total_cmp(a));
        let few = rooms.len() - rooms.len().min((ALWAYS_TOUCHING_SHARE * rooms.len() as f64).ceil() as usize);
        let beyond = |distance: f64| rooms.iter().take_while(|room| **room > distance).count();
        if beyond(TOUCHING_DISTANCE_M) <= few {
            return (SampledRoom::AlwaysTouching, false);
        }
        let free = beyond(near);
        if free <= few {
            return (SampledRoom::AlwaysNear, false);
        }
        let of = |share: f64| rooms.get(count(share)).copied().filter(|room| *room > near);
        // If fewer poses are apart than both shares require, the room is the smallest distance of the poses that are apart.
        let room = of(ROOMY_SHARE).or(of(LEAST_ROOMY_SHARE)).unwrap_or(rooms[free - 1]);
        let is_constant = rooms[0] < enough && rooms[0] - rooms[rooms.len() - 1] < CONSTANT_WITHIN_M;
        (SampledRoom::Room(room), is_constant)
    }

    /// Whether one of the two bodies of a pair is a mesh.
    fn is_of_mesh(&self, gap: &Gap) -> bool {
        let Against::Body(other) = gap.against else { return false };
        let is_mesh = |body: usize| self.bodies[body].shapes.iter().any(|s| matches!(s.solid.core, Core::Hull(_)));
        is_mesh(gap.body) || is_mesh(other)
    }

    /// The distance of a pair, m. If the true distance is above `enough`, the result is any value above `enough`.
    fn room_up_to(&self, gap: &Gap, poses: &[Pose], enough: f64) -> f64 {
        let Against::Body(other) = gap.against else { return f64::INFINITY };
        let (body, other) = (&self.bodies[gap.body], &self.bodies[other]);
        let mut least = f64::INFINITY;
        for &s in &gap.shapes {
            let shape = &body.shapes[s];
            let centre = self.centre(body, shape, poses);
            for opposite in &other.shapes {
                let towards = minus(centre, self.centre(other, opposite, poses));
                let between_balls = norm(towards) - shape.ball - opposite.ball;
                if between_balls >= enough {
                    least = least.min(between_balls);
                    continue;
                }
                let (a, b) = (self.standing(body, shape, poses), self.standing(other, opposite, poses));
                let along = apart_along(a, b, towards);
                least = least.min(if along >= enough { along } else { separation(a, b, towards).reached });
            }
        }
        least
    }
}

#[cfg(test)]
mod tests {
    use crate::clearance::Clearance;
    use crate::gaps::{ClearanceRules, Situation};

    #[test]
    fn sides_of_a_joint_are_a_pair_where_they_are_apart() {
        let folder = std::env::temp_dir().join(format!("rist-sides-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let corner = |k: usize| [0, 1, 2].map(|i| if k >> i & 1 == 1 { 0.1 } else { -0.1 });
        let vertices: String = (0..8).map(corner).map(|[x, y, z]| format!("v {x} {y} {z}\n")).collect();
        let faces = "f 1 2 4 3\nf 5 6 8 7\nf 1 2 6 5\nf 3 4 8 7\nf 1 3 7 5\nf 2 4 8 6\n";
        std::fs::write(folder.join("cube.obj"), vertices + faces).unwrap();
        let (cube, mesh) = (r#"<box size="0.2 0.2 0.2"/>"#, r#"<mesh filename="cube.obj"/>"#);
        for (upper, height, bound) in
            [(cube, 0.1003, Some(0.000_15)), (mesh, 0.1003, None), (mesh, 0.1008, Some(0.0004)), (cube, 0.1, None)]
        {
            let arm = format!(
                r#"<robot name="arm"><link name="post"><collision><geometry>{cube}</geometry></collision></link>
  <joint name="q1" type="revolute"><parent link="post"/><child link="upper"/><axis xyz="0 0 1"/>
    <limit lower="-3" upper="3" velocity="1" effort="1"/></joint>
  <link name="upper"><collision><origin xyz="0 0 {}"/><geometry>{upper}</geometry></collision></link></robot>"#,
                height + 0.1
            );
            let robot = robot::format::read_urdf(&arm, "arm.urdf").unwrap();
            let poses = (0..100).map(|k| vec![0.06 * f64::from(k) - 3.0]).collect();
            let situation = Situation { rest: vec![0.0], zero: vec![0.0], moves: vec![true], poses };
            let clearance = Clearance::new(&robot, &folder, &ClearanceRules::default(), &situation).unwrap();
            let found = clearance.gaps().iter().find(|gap| gap.is_own).map(|gap| gap.bound);
            let is_near = |(a, b): (f64, f64)| (a - b).abs() < 1e-9;
            assert!(found.is_some() == bound.is_some() && found.zip(bound).is_none_or(is_near), "{height}: {found:?}");
            let said: Vec<String> = clearance.left_out().iter().map(|out| format!("{:?}", out.why)).collect();
            let is_near_mesh =
                said.iter().any(|why| why.contains("one is a mesh, and they are nearer than 0.5 mm in 99 %"));
            let touches = said.iter().any(|why| why.contains("they touch in 99 % of 100 poses"));
            assert_eq!((is_near_mesh, touches), (upper == mesh && bound.is_none(), upper == cube && bound.is_none()));
        }
        std::fs::remove_dir_all(&folder).ok();
    }
}
