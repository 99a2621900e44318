//! The room that two links have over poses of the robot.
//!
//! Two links that touch in nearly every pose are held together by their joints, or are drawn larger than they are: no
//! motion parts them. All others can meet somewhere and be apart elsewhere, whether they touch at zero or not.

use robot::Pose;

use crate::clearance::{Against, Clearance, Gap};
use crate::separation::{apart_along, separation};
use robot::vector::{minus, norm};

/// Bodies nearer than this touch, m: the two sides of a joint are some tenths of a millimetre apart wherever it turns, and no motion
/// can be asked to keep that.
const TOUCHING_DISTANCE_M: f64 = 5e-4;
/// Share of the poses in which links touch that no motion parts.
pub const ALWAYS_TOUCHING_SHARE: f64 = 0.99;
/// The room is what this share of the poses exceeds.
const ROOMY_SHARE: f64 = 0.1;
/// What the room is where fewer poses than that leave any.
const LEAST_ROOMY_SHARE: f64 = 0.01;

/// What poses tell of a pair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum SampledRoom {
    /// The links touch in nearly every pose.
    AlwaysTouching,
    /// They have this room, m: no more than `enough`.
    Room(f64),
}

/// What is assumed of pairs that always touch, by so many poses.
pub(crate) fn always_touching(poses: usize) -> String {
    let (share, near) = (100.0 * ALWAYS_TOUCHING_SHARE, 1e3 * TOUCHING_DISTANCE_M);
    format!("they touch in {share} % of {poses} poses, or are nearer than {near} mm, so that no motion parts them")
}

impl Clearance {
    /// The room of a pair over `poses`, each of all links; rooms above `enough` are not told apart.
    pub(crate) fn sampled_room(&self, gap: &Gap, poses: &[Vec<Pose>], enough: f64) -> SampledRoom {
        let count = |share: f64| (share * poses.len() as f64).floor() as usize;
        let (mut rooms, mut ample, mut free) = (Vec::with_capacity(poses.len()), 0, 0);
        for poses in poses {
            let room = self.room_up_to(gap, poses, enough);
            ample += usize::from(room >= enough);
            free += usize::from(room > TOUCHING_DISTANCE_M);
            if ample > count(ROOMY_SHARE) {
                return SampledRoom::Room(enough);
            }
            rooms.push(room);
        }
        if free <= rooms.len() - rooms.len().min((ALWAYS_TOUCHING_SHARE * rooms.len() as f64).ceil() as usize) {
            return SampledRoom::AlwaysTouching;
        }
        rooms.sort_by(|a, b| b.total_cmp(a));
        let of = |share: f64| rooms.get(count(share)).copied().filter(|room| *room > TOUCHING_DISTANCE_M);
        // As many poses as leave any room, where it is less than the shares ask for.
        let least = rooms[..free].last().copied().unwrap_or(TOUCHING_DISTANCE_M);
        SampledRoom::Room(of(ROOMY_SHARE).or(of(LEAST_ROOMY_SHARE)).unwrap_or(least))
    }

    /// The distance of a pair, m; one above `enough` is told as some value above it.
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
    use std::path::Path;

    use crate::clearance::Clearance;
    use crate::gaps::{Rules, Situation};

    /// The sides of a joint that turns: some tenths of a millimetre apart they are assumed, farther apart they are a pair.
    #[test]
    fn sides_of_a_joint_are_a_pair_where_they_are_apart() {
        for (height, bound) in [(0.1003, None), (0.1008, Some(0.0004))] {
            let arm = format!(
                r#"<robot name="arm"><link name="post"><collision><geometry><box size="0.2 0.2 0.2"/></geometry></collision></link>
  <joint name="q1" type="revolute"><parent link="post"/><child link="upper"/><axis xyz="0 0 1"/>
    <limit lower="-3" upper="3" velocity="1" effort="1"/></joint>
  <link name="upper"><collision><origin xyz="0 0 {}"/><geometry><box size="0.2 0.2 0.2"/></geometry></collision></link></robot>"#,
                height + 0.1
            );
            let robot = robot::format::read_urdf(&arm, "arm.urdf").unwrap();
            let poses = (0..100).map(|k| vec![0.06 * f64::from(k) - 3.0]).collect();
            let situation = Situation { rest: vec![0.0], zero: vec![0.0], moves: vec![true], poses };
            let clearance = Clearance::new(&robot, Path::new("."), &Rules::default(), &situation).unwrap();
            let found = clearance.gaps().iter().find(|gap| gap.is_own).map(|gap| gap.bound);
            let is_near = |(a, b): (f64, f64)| (a - b).abs() < 1e-9;
            assert!(found.is_some() == bound.is_some() && found.zip(bound).is_none_or(is_near), "{height}: {found:?}");
            let said = clearance.left_out().iter().any(|out| out.of.iter().any(|pair| pair == "upper and post"));
            assert_eq!(said, bound.is_none());
        }
    }
}
