//! Adds the distances (gaps) between the bodies of a robot and its surroundings: the floor, walls, and the sides of boxes.

use crate::bodies::{BodyShape, FileLink};
use crate::clearance::{Against, Clearance, Gap, GapRange, PLACE_ROUNDING_M};
use crate::gaps::{ClearanceRules, DEFAULT_SHARE_OF_ROOM, FloorRule, RESERVE_M, Situation};
use crate::half_space::HalfSpace;
use crate::sampled_room::ROOMY_SHARE;
use crate::shown_length::shown_length;
use claims::{LeftOut, LeftOutTopic};

/// Threshold, m: a gap (distance to a half-space) counts as constant if it cannot shrink by more than this while each moving
/// coordinate stays within 1 rad (m) of the rest position.
const CONSTANT_GAP_CHANGE: f64 = 1e-9;
/// Allowance for the rounding of the height of the lowest point, m.
const FLOOR_ROUNDING_M: f64 = 1e-6;
/// A robot stands on the plane of its base if its base mesh is below this plane by at most this length, m. Meshes are not more
/// accurate.
const STANDING_TOLERANCE_M: f64 = 5e-3;
/// The name of the floor; names of gaps (distances to a half-space) end with it.
const FLOOR: &str = "the floor";

impl Clearance {
    /// Adds the half-space above the floor. If there is no floor, adds the reason to the list of requirements that are not
    /// checked.
    pub(crate) fn add_floor(&mut self, rules: &ClearanceRules, situation: &Situation) -> Result<(), String> {
        self.floor = match rules.floor {
            FloorRule::At(height) => Some(height),
            FloorRule::Nowhere => {
                let what = "nothing stands below the robot (floor: none)";
                self.left_out.push(LeftOut::assumed(LeftOutTopic::Floor, vec![], what, "the user"));
                None
            }
            FloorRule::OfBase(_) if rules.assumes_floor && self.stands_on_its_plane() => Some(0.0),
            FloorRule::OfBase(least) => match self.floor_of_base(situation) {
                Ok(base) => Some(least.map_or(base, |least| least.max(base))),
                Err(why) if least.is_none() => {
                    let remedy = "the height of the floor in the limits file";
                    self.left_out.push(LeftOut::not_looked_at(LeftOutTopic::Floor, vec![], why, remedy));
                    None
                }
                Err(_) => least,
            },
        };
        if let Some(height) = self.floor {
            let plane = HalfSpace::beyond(FLOOR.into(), [0.0, 0.0, height], [0.0, 0.0, 1.0])?;
            self.half_spaces.insert(0, plane);
        }
        Ok(())
    }

    /// The height of the base plane, 0 m, if no moving body is below this plane at the zero pose. Otherwise the reason why the
    /// plane is not a floor.
    fn floor_of_base(&self, situation: &Situation) -> Result<f64, String> {
        let has_geometry = self.bodies.iter().any(|b| b.link.is_some() && b.has_geometry && !b.shapes.is_empty());
        match (has_geometry, self.lowest(&situation.zero)) {
            (true, Some((lowest, _))) if lowest >= -FLOOR_ROUNDING_M => Ok(0.0),
            (true, Some((lowest, body))) => Err(format!(
                "{body} is {} m below the plane of the base at the zero pose, so that this is no floor",
                shown_length(-lowest)
            )),
            _ => Err("the description has no collision geometry, so that nothing says who could meet one".into()),
        }
    }

    /// Least distance between a body and an assumed floor, m: the smaller of `spacing` and half of the room. Room: the distance
    /// that the body exceeds in a tenth of the sampled poses. 0 for other gaps.
    fn spacing_to_floor(&self, gap: &Gap, situation: &Situation, rules: &ClearanceRules) -> f64 {
        let is_floor = gap.subject.ends_with(FLOOR);
        let (true, FloorRule::OfBase(_), Some(spacing)) = (is_floor, rules.floor, rules.spacing) else { return 0.0 };
        let room = |q: &Vec<f64>| self.apart(gap, &self.tree.poses(q), None).reached;
        let mut rooms: Vec<f64> = situation.poses.iter().map(room).collect();
        rooms.sort_by(|a, b| b.total_cmp(a));
        let room = rooms.get((ROOMY_SHARE * rooms.len() as f64) as usize).copied().unwrap_or(0.0);
        spacing.min(DEFAULT_SHARE_OF_ROOM * room.max(0.0))
    }

    /// Whether the robot stands on the plane z = 0: the fixed base has a body, and no point of it is below this plane by more
    /// than 5 mm.
    fn stands_on_its_plane(&self) -> bool {
        let base = self.bodies.iter().filter(|b| b.link.is_none());
        let height =
            |(body, shape): (&FileLink, &BodyShape)| self.standing(body, shape, &[]).least_along([0.0, 0.0, 1.0]);
        let all = base.flat_map(|body| body.shapes.iter().map(move |shape| (body, shape)));
        all.map(height).reduce(f64::min).is_some_and(|lowest| lowest >= -STANDING_TOLERANCE_M)
    }

    /// The distance of a gap at the rest position, and its lower bound while every moving coordinate changes by at most 1 rad
    /// (m).
    fn near_rest(&self, gap: &Gap, situation: &Situation) -> GapRange {
        let unit: Vec<f64> = situation.moves.iter().map(|m| f64::from(u8::from(*m))).collect();
        self.apart(gap, &self.tree.poses(&situation.rest), Some(&unit))
    }

    /// Adds the distances (gaps) between a half-space and the bodies that must stay in it. A body gets no gap if no joint can
    /// change its distance to the plane of the half-space.
    pub(crate) fn add_wall(
        &mut self,
        wall: usize,
        situation: &Situation,
        rules: &ClearanceRules,
    ) -> Result<(), String> {
        let HalfSpace { name, links, .. } = self.half_spaces[wall].clone();
        let topic = if name == FLOOR { LeftOutTopic::Floor } else { LeftOutTopic::Region };
        let mut points = Vec::new();
        let mut beyond: Option<(String, f64)> = None;
        // Each body gets one gap (distance to the half-space), with all its shapes that must stay in the half-space.
        for at in 0..self.bodies.len() {
            let body = &self.bodies[at];
            // A rule may name a body, the moving link that carries the body, or, for a body of points, one of its frames.
            let is_meant = |shape: usize| match &links {
                None => true,
                Some(links) => {
                    let frame = body.frames.get(shape).unwrap_or(&body.name);
                    links.iter().any(|l| *l == body.name || *l == body.carrier || l == frame)
                }
            };
            let is_any_meant = (0..body.shapes.len().max(1)).any(is_meant);
            if body.link.is_none() || !is_any_meant {
                continue;
            }
            let shapes: Vec<usize> = (0..body.shapes.len()).filter(|&s| is_meant(s)).collect();
            // Meshes that cannot be read and links without a shape are listed as not checked.
            if !body.missing.is_empty() {
                let whose = if shapes.is_empty() { "" } else { "unread parts of " };
                let (of, why) = (vec![format!("{whose}{} at {name}", body.name)], body.missing.join("; "));
                self.left_out.push(LeftOut::not_looked_at(topic, of, why, "a mesh that can be read"));
            } else if !body.has_geometry {
                points.push(body.name.clone());
            }
            let body = &self.bodies[at];
            if shapes.is_empty() {
                continue;
            }
            let gap = Gap {
                subject: format!("{} at {name}", body.name),
                is_own: false,
                bound: 0.0,
                margin: 0.0,
                reserve: RESERVE_M,
                carriers: [body.carrier.clone(), body.carrier.clone()],
                body: at,
                shapes,
                against: Against::HalfSpace(wall),
                joints: self.between(body.link, None),
                is_constant: false,
            };
            // A gap that no free joint changes is not added: its constant distance is either sufficient or an error.
            let now = self.near_rest(&gap, situation);
            if now.reached - now.at_least > CONSTANT_GAP_CHANGE + PLACE_ROUNDING_M {
                let bound = self.spacing_to_floor(&gap, situation, rules);
                self.gaps.push(Gap { bound, ..gap });
            } else if now.reached < beyond.as_ref().map_or(0.0, |(_, reached)| *reached) {
                beyond = Some((body.name.clone(), now.reached));
            }
        }
        // A body that is beyond the half-space in all poses is an error. Links without shape are recorded as an assumption.
        if let Some((body, reached)) = beyond {
            return Err(self.always_beyond(&body, reached, &name));
        }
        if !points.is_empty() {
            let of = points.iter().map(|link| format!("{link} at {name}")).collect();
            let what = "the origins of their frames stand for links without collision geometry";
            self.left_out.push(LeftOut::assumed(topic, of, what, "default"));
        }
        Ok(())
    }

    /// The error text for a body that is beyond a half-space in all poses, with a suggested remedy.
    fn always_beyond(&self, body: &str, reached: f64, name: &str) -> String {
        let far = shown_length(-reached);
        let remedy = match self.floor.filter(|_| name == FLOOR) {
            // Rounding can put a body below a floor that it only touches. So the suggested floor is lowered to a multiple of 1
            // mm.
            Some(height) => format!("space: {{floor: {}}} is below it", (1e3 * (height + reached) - 0.5).floor() / 1e3),
            None => format!("name the links that must stay in (links: [..]), or move {name} by more than that"),
        };
        format!("{body} is {far} m beyond {name}, and no joint that is not locked moves it away: {remedy}")
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::gaps::tests::{ARM, clearance, clearance_of};

    #[test]
    fn the_base_has_a_floor() {
        let of = |floor: FloorRule| clearance(&ClearanceRules { floor, ..ClearanceRules::default() }).unwrap();
        let below = of(FloorRule::OfBase(None));
        let out = below.left_out().iter().find(|out| out.matter == LeftOutTopic::Floor).unwrap();
        assert_eq!(below.floor(), None);
        let claims::LeftOutReason::NotLookedAt { why, .. } = &out.why else { panic!("{out:?}") };
        assert_eq!(why, "upper is 0.0500 m below the plane of the base at the zero pose, so that this is no floor");
        assert_eq!(of(FloorRule::OfBase(Some(-0.15))).floor(), Some(-0.15));
        let nowhere = of(FloorRule::Nowhere);
        assert!(nowhere.floor().is_none() && nowhere.gaps().iter().all(|g| g.is_own));
        let lifted = ARM.replace("<child link=\"upper\"/>", "<child link=\"upper\"/><origin xyz=\"0 0 0.2\"/>");
        let lifted = clearance_of(&lifted, &ClearanceRules::default()).unwrap();
        assert_eq!(lifted.floor(), Some(0.0));
        assert_eq!(lifted.gaps().last().unwrap().subject, "hand at the floor");
        let (lowest, whose) = lifted.lowest(&[0.0, 0.0, 1.0]).unwrap();
        // The hand, 0.2 m long and 0.02 m thick, points down at an angle of 1 rad.
        let expected = 0.2 - 0.2 * 1.0_f64.sin() - 0.01 * 1.0_f64.cos();
        assert!(whose == "hand" && (lowest - expected).abs() < 1e-12, "{lowest} {expected} {whose}");
    }

    #[test]
    fn a_hair_below_the_floor_is_told_in_figures() {
        let turning = r#"<robot name="arm"><link name="post"/><link name="upper"/>
  <joint name="q1" type="revolute"><parent link="post"/><child link="upper"/><axis xyz="0 0 1"/>
    <limit lower="-3" upper="3" velocity="1" effort="1"/></joint></robot>"#;
        let robot = robot::format::read_urdf(turning, "arm.urdf").unwrap();
        let (rest, poses) = (vec![0.0], vec![vec![0.5]; 10]);
        let situation = Situation { rest: rest.clone(), zero: rest, moves: vec![true], poses };
        for (floor, said) in
            [(1e-46, "upper is 1.0e-46 m beyond the floor"), (0.02, "upper is 0.0200 m beyond the floor")]
        {
            let rules = ClearanceRules { floor: FloorRule::At(floor), ..ClearanceRules::default() };
            let refused = Clearance::new(&robot, Path::new("."), &rules, &situation).map(|_| ()).unwrap_err();
            assert!(refused.starts_with(said), "{refused}");
        }
    }
}
