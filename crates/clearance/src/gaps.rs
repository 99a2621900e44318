//! Makes the list of distances (gaps) that a robot must keep, from the user's rules and from the robot's shape.
//!
//! Every two links that joints move relative to each other have a gap, also neighbours. Exceptions: links that touch in nearly
//! every pose ([`crate::sampled_room`]), pairs that a rule accepts, and links of unknown shape. The meshes of two links with
//! little clearance are cut into convex pieces (crowded.rs). The floor is at the requested height, or else in the plane of the
//! base if no moving body is below this plane at the zero pose.

use std::path::Path;

use robot::{JointKind, Pose, Robot};

use crate::bodies::{FileLink, bodies};
use crate::clearance::{Against, Clearance, Gap};
use crate::crowded::Crowded;
use crate::kinematic_tree::KinematicTree;
pub use crate::rules::{ClearanceRules, FloorRule, Situation};
use crate::sampled_room::{SampledRoom, always, constant_distance};
use claims::{LeftOut, LeftOutTopic};

/// Least distance between two links of the robot if none is requested, m.
pub const DEFAULT_DISTANCE_M: f64 = 0.01;
/// If no distance is requested, the least distance of a pair is at most this share of its room. Room: the distance that the pair
/// exceeds in a tenth of the sampled poses (see `sampled_room`).
pub(crate) const DEFAULT_SHARE_OF_ROOM: f64 = 0.5;
/// Reserve, m: additional distance above the bound of a gap. A search for motions keeps it if there is enough room.
pub(crate) const RESERVE_M: f64 = 0.004;
/// With less room, the reserve is this share of the difference between room and bound.
const RESERVE_SHARE: f64 = 0.25;
/// Smallest reserve (additional distance that a search keeps) of a gap, m.
const LEAST_RESERVE_M: f64 = 1e-7;

impl Clearance {
    /// All distances (gaps) that the rules require. `directory`: folder of the robot description, in which meshes are searched.
    ///
    /// Fails if a rule names an unknown link, or if a body is beyond a half-space and no joint moves it.
    pub fn new(
        robot: &Robot,
        directory: &Path,
        rules: &ClearanceRules,
        situation: &Situation,
    ) -> Result<Clearance, String> {
        let Some(tree) = KinematicTree::new(robot) else { return Ok(Clearance::of_numeric_joints(rules)) };
        let (bodies, half_spaces) = (bodies(robot, directory), rules.half_spaces.clone());
        let given_ranges = Clearance::ranges(situation.moves.len(), &situation.poses);
        let mut clearance = Clearance {
            tree,
            bodies,
            half_spaces,
            gaps: vec![],
            rates: vec![],
            given_ranges,
            floor: None,
            left_out: vec![],
            cut_bodies: vec![],
        };
        // A rule about an unknown link or pair is an error, because it would have no effect.
        clearance.check_names(rules)?;
        clearance.check_accepted(rules)?;
        match rules.own_links {
            true => {
                clearance.leave_out_unknown_links();
                let sampled: Vec<Vec<Pose>> = situation.poses.iter().map(|q| clearance.tree.poses(q)).collect();
                // Pairs with little clearance now have cut meshes, so all pairs are added again.
                let others = clearance.left_out.len();
                let crowded = clearance.add_pairs(rules, situation, &sampled);
                if clearance.cut_meshes_of(robot, directory, &crowded, &sampled) {
                    clearance.gaps.clear();
                    clearance.left_out.truncate(others);
                    clearance.add_pairs(rules, situation, &sampled);
                }
            }
            false => clearance.left_out.push(LeftOut::assumed(
                LeftOutTopic::Distance,
                vec![],
                "the robot's own links do not meet (own_links: false)",
                "the user",
            )),
        }
        clearance.add_floor(rules, situation)?;
        for wall in 0..clearance.half_spaces.len() {
            clearance.add_wall(wall, situation, rules)?;
        }
        // The largest rates of change need the complete list of gaps, and the margins need these rates.
        match (rules.is_over)() {
            true => Err("interrupted before the bodies were looked at".into()),
            false => Ok(clearance.with_rates(&rules.errors)),
        }
    }

    /// A clearance without gaps, for a robot with joint positions that are solved numerically (closed loops). No bound of the
    /// motion of such joints is known.
    fn of_numeric_joints(rules: &ClearanceRules) -> Clearance {
        let asked = [
            (LeftOutTopic::Distance, rules.own_links),
            (LeftOutTopic::Floor, rules.floor != FloorRule::Nowhere),
            (LeftOutTopic::Region, !rules.half_spaces.is_empty()),
        ];
        let why = "joints of a loop are found numerically, so that nothing bounds how far links move";
        let out = |(topic, _): &(LeftOutTopic, bool)| {
            LeftOut::not_looked_at(*topic, vec![], why, "a description without that loop")
        };
        let left_out = asked.iter().filter(|(_, is_asked)| *is_asked).map(out).collect();
        let tree = KinematicTree::none();
        let (bodies, half_spaces) = (vec![], vec![]);
        let (gaps, rates, given_ranges) = (vec![], vec![], vec![]);
        Clearance { tree, bodies, half_spaces, gaps, rates, given_ranges, floor: None, left_out, cut_bodies: vec![] }
    }

    /// Adds a gap for every two bodies with shapes that move relative to each other. Returns the crowded pairs: those with little
    /// clearance.
    fn add_pairs(&mut self, rules: &ClearanceRules, situation: &Situation, sampled: &[Vec<Pose>]) -> Vec<Crowded> {
        let (mut touching, mut near, mut constant, mut crowded) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for a in 0..self.bodies.len() {
            for b in 0..a {
                if (rules.is_over)() {
                    return crowded;
                }
                let (body, other) = (&self.bodies[a], &self.bodies[b]);
                let is_known = |b: &FileLink| b.has_geometry && b.missing.is_empty();
                if !is_known(body) || !is_known(other) {
                    continue;
                }
                // If no free joint moves two bodies relative to each other, their distance is constant and is not checked.
                let joints = self.between(body.link, other.link);
                if !joints.iter().flatten().any(|&j| self.turns(j, &situation.moves)) {
                    continue;
                }
                let subject = format!("{} and {}", body.name, other.name);
                let is_named = |(x, y, _): &&(String, String, String)| {
                    (body.name == *x && other.name == *y) || (body.name == *y && other.name == *x)
                };
                if let Some((_, _, reason)) = rules.accepted.iter().find(is_named) {
                    self.left_out.push(LeftOut::assumed(LeftOutTopic::Distance, vec![subject], reason, "the user"));
                    continue;
                }
                let gap = Gap {
                    subject,
                    is_own: true,
                    bound: 0.0,
                    margin: 0.0,
                    reserve: RESERVE_M,
                    carriers: [body.carrier.clone(), other.carrier.clone()],
                    body: a,
                    shapes: (0..body.shapes.len()).collect(),
                    against: Against::Body(b),
                    joints,
                    is_constant: false,
                };
                // A room above `enough` need not be known exactly, because the bound is the same for all such rooms.
                let enough = enough_room(rules);
                let (found, is_constant) = self.sampled_room(&gap, sampled, enough);
                // The distance between the bodies on the two sides of one joint is equal at every angle, so no motion can
                // increase it.
                let is_constant = is_constant && gap.joints.iter().flatten().count() == 1;
                crowded.extend(Crowded::of(&gap, found, enough));
                match found {
                    SampledRoom::AlwaysTouching => touching.push(gap.subject),
                    SampledRoom::AlwaysNear => near.push(gap.subject),
                    SampledRoom::Room(room) => {
                        let bound = bound_of(room, is_constant, rules);
                        let reserve = (RESERVE_SHARE * (room - bound)).clamp(LEAST_RESERVE_M, RESERVE_M);
                        if is_constant && (rules.errors.is_any() || rules.distance.is_some_and(|asked| asked > bound)) {
                            constant.push(gap.subject.clone());
                        }
                        self.gaps.push(Gap { bound, reserve, is_constant, ..gap });
                    }
                }
            }
        }
        let assumed = [touching, near].into_iter().zip(always(sampled.len())).filter(|(pairs, _)| !pairs.is_empty());
        self.left_out
            .extend(assumed.map(|(pairs, what)| LeftOut::assumed(LeftOutTopic::Distance, pairs, what, "default")));
        self.left_out.extend(constant_distance(sampled.len(), constant));
        crowded
    }

    /// Whether a coordinate that moves changes the position of a joint. `moves`: for each coordinate, whether it moves.
    fn turns(&self, joint: usize, moves: &[bool]) -> bool {
        self.tree.kind(joint) != JointKind::Fixed && self.tree.terms(joint).iter().any(|(k, m)| *m != 0.0 && moves[*k])
    }
}

/// The least distance that a pair must keep, m. `room`: the distance that the pair exceeds in a tenth of the sampled poses, m.
/// The least distance is at most a share of the room in two cases: no distance is requested, or the distance of the pair is
/// constant.
fn bound_of(room: f64, is_constant: bool, rules: &ClearanceRules) -> f64 {
    let share = DEFAULT_SHARE_OF_ROOM * room;
    match rules.distance {
        Some(distance) if is_constant => distance.min(share),
        asked => asked.unwrap_or(rules.spacing.unwrap_or(DEFAULT_DISTANCE_M).min(share)),
    }
}

/// Room of a pair (m) above which its exact value does not change the least distance of the pair. Room: the distance that the
/// pair exceeds in a tenth of the sampled poses.
fn enough_room(rules: &ClearanceRules) -> f64 {
    match rules.distance {
        Some(distance) => distance + RESERVE_M / RESERVE_SHARE,
        None => rules.spacing.unwrap_or(DEFAULT_DISTANCE_M) / DEFAULT_SHARE_OF_ROOM,
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::half_space::HalfSpace;
    use crate::nearby::InstantCache;

    /// An arm on a post: two links of radius 5 cm that turn about z, 1 m and 0.8 m long, and a hand that turns about y.
    pub(crate) const ARM: &str = r#"<robot name="arm">
  <link name="post"><collision><origin xyz="0 0 0"/><geometry><sphere radius="0.1"/></geometry></collision></link>
  <joint name="q1" type="revolute"><parent link="post"/><child link="upper"/><axis xyz="0 0 1"/>
    <limit lower="-3" upper="3" velocity="1" effort="1"/></joint>
  <link name="upper"><collision><origin xyz="0.5 0 0" rpy="0 1.5707963267948966 0"/><geometry><capsule radius="0.05" length="1"/></geometry></collision></link>
  <joint name="q2" type="revolute"><parent link="upper"/><child link="fore"/><origin xyz="1 0 0"/><axis xyz="0 0 1"/>
    <limit lower="-3" upper="3" velocity="1" effort="1"/></joint>
  <link name="fore"><collision><origin xyz="0.4 0 0" rpy="0 1.5707963267948966 0"/><geometry><capsule radius="0.05" length="0.8"/></geometry></collision></link>
  <joint name="q3" type="revolute"><parent link="fore"/><child link="hand"/><origin xyz="0.8 0 0"/><axis xyz="0 1 0"/>
    <limit lower="-3" upper="3" velocity="1" effort="1"/></joint>
  <link name="hand"><collision><origin xyz="0.1 0 0"/><geometry><box size="0.2 0.1 0.02"/></geometry></collision></link>
</robot>"#;

    pub(crate) fn clearance(rules: &ClearanceRules) -> Result<Clearance, String> {
        clearance_of(ARM, rules)
    }

    pub(crate) fn clearance_of(text: &str, rules: &ClearanceRules) -> Result<Clearance, String> {
        let robot = robot::format::read_urdf(text, "arm.urdf").unwrap();
        Clearance::new(&robot, Path::new("."), rules, &situation())
    }

    /// A test situation with 1000 poses spread over the joint limits.
    pub(crate) fn situation() -> Situation {
        let angle = |k: usize, step: f64| 3.0 * (2.0 * (k as f64 * step).fract() - 1.0);
        let poses = (0..1000).map(|k| vec![angle(k, 0.618), angle(k, 0.414), angle(k, 0.732)]).collect();
        Situation { rest: vec![0.0; 3], zero: vec![0.0; 3], moves: vec![true; 3], poses }
    }

    /// Rules with a least distance between links and a floor.
    fn rules(distance: f64) -> ClearanceRules {
        ClearanceRules { distance: Some(distance), floor: FloorRule::At(-0.15), ..ClearanceRules::default() }
    }

    #[test]
    fn gaps_of_an_arm_are_those_of_geometry() {
        let clearance = clearance(&rules(0.02)).unwrap();
        let subjects: Vec<&str> = clearance.gaps().iter().map(|g| g.subject.as_str()).collect();
        // All joints turn about z except the joint of the hand, so only the hand can come nearer to the floor.
        assert_eq!(subjects, ["fore and post", "hand and post", "hand and upper", "hand at the floor"]);
        let joined = ["upper and post", "fore and upper", "hand and fore"].map(String::from).to_vec();
        let what = "they touch in 99 % of 1000 poses, so that no motion parts them";
        assert_eq!(clearance.left_out(), [LeftOut::assumed(LeftOutTopic::Distance, joined, what, "default")]);
        assert_eq!(clearance.floor(), Some(-0.15));
        let rooms = clearance.rooms(&[0.3, 0.0, 0.0], &[0.0; 3], &[0, 1, 2, 3]);
        let expected = [1.0 - 0.1 - 0.05, 1.8 - 0.1, 0.8 - 0.05, 0.15 - 0.01];
        for (room, expected) in rooms.iter().zip(expected) {
            // A search for the nearest points is accurate to 1e-8 m.
            assert!((room.reached - expected).abs() < 1e-7 && (room.at_least - expected).abs() < 1e-7, "{room:?}");
        }
        // The arm is folded back, and the hand lies on the post.
        let rooms = clearance.rooms(&[0.0, std::f64::consts::PI, 0.0], &[0.0; 3], &[0, 1]);
        assert!((rooms[0].reached - (0.2 - 0.15)).abs() < 1e-7 && rooms[1].reached < 0.0, "{rooms:?}");
    }

    #[test]
    fn what_is_proved_holds_nearby() {
        let clearance = clearance(&rules(0.02)).unwrap();
        let all: Vec<usize> = (0..clearance.gaps().len()).collect();
        for (k, spread) in [0.3, 0.1, 0.01].into_iter().enumerate() {
            for c in 0..40 {
                let wave = |m: f64| (m * f64::from(c) + k as f64).sin();
                let q = [2.0 * wave(1.1), 3.0 * wave(2.3), 2.0 * wave(0.7)];
                let proved = clearance.rooms(&q, &[spread; 3], &all);
                for d in 0..20 {
                    let wave = |m: f64| spread * (m * f64::from(d)).sin();
                    let near = [q[0] + wave(1.7), q[1] + wave(2.9), q[2] + wave(0.3)];
                    for (proved, there) in proved.iter().zip(clearance.rooms(&near, &[0.0; 3], &all)) {
                        assert!(there.reached >= proved.at_least, "{proved:?} {there:?}");
                    }
                }
                // A point is at most 2.1 m from each joint that moves it, and three joints move: 3 * 2.1 m = 6.3 m.
                assert!(proved.iter().all(|r| r.reached - r.at_least < 6.3 * spread + 1e-6), "{proved:?}");
            }
        }
    }

    #[test]
    fn slopes_are_those_of_differences() {
        let clearance = clearance(&rules(0.02)).unwrap();
        let at = |q: [f64; 3]| {
            let mut found = vec![];
            clearance.near(&q, 0.5, &mut InstantCache::default(), &mut |g, room, slope| {
                found.push((g, room, slope.to_vec()))
            });
            found
        };
        let mut seen = 0;
        for c in 0..20 {
            let wave = |m: f64| (m * f64::from(c)).sin();
            let q = [wave(1.1), 2.5 + 0.3 * wave(2.3), wave(0.7)];
            for (g, room, slope) in at(q).into_iter().filter(|f| f.1 > -0.02) {
                seen += 1;
                for k in 0..3 {
                    let moved = |h: f64| {
                        let mut q = q;
                        q[k] += h;
                        at(q).into_iter().find(|f| f.0 == g).unwrap().1
                    };
                    let difference = (moved(1e-5) - moved(-1e-5)) / 2e-5;
                    // The nearest point of a box can jump from corner to corner. At such a jump, `slope` equals one of the two
                    // one-sided slopes.
                    let one_sided = [(moved(1e-5) - room) / 1e-5, (room - moved(-1e-5)) / 1e-5];
                    let off = one_sided.into_iter().chain([difference]).map(|d| (slope[k] - d).abs());
                    // Distances have an error of 1e-9 m. Divided by the step of 1e-5, this gives an error of 1e-4 in the slope.
                    assert!(off.fold(f64::INFINITY, f64::min) < 1e-3, "{g} {k}: {} {difference}", slope[k]);
                }
            }
        }
        assert!(seen > 20, "{seen}");
    }

    #[test]
    fn links_that_touch_at_zero_are_looked_at() {
        // If the arm is stretched out, the knob of the hand meets the forearm. If the arm is bent, the knob does not.
        let text = ARM.replace(
            "</robot>",
            r#"<joint name="fix" type="fixed"><parent link="hand"/><child link="knob"/><origin xyz="-0.1 0 0"/></joint>
  <link name="knob"><collision><geometry><sphere radius="0.052"/></geometry></collision></link></robot>"#,
        );
        let text = text.replace("<origin xyz=\"0.8 0 0\"/><axis", "<origin xyz=\"0.95 0 0\"/><axis");
        let found = clearance_of(&text, &ClearanceRules::default()).unwrap();
        let knob = found.gaps().iter().find(|g| g.subject == "knob and fore").unwrap();
        assert_eq!((knob.bound, knob.carriers.as_slice()), (DEFAULT_DISTANCE_M, &["hand".into(), "fore".into()][..]));
        assert!(found.rooms(&[0.0; 3], &[0.0; 3], &[place(&found, "knob and fore")])[0].reached < 0.0);
        // The post and a collar on the upper arm are always 6 mm apart, so the bound is half of this distance.
        let text = ARM.replace("<sphere radius=\"0.1\"/>", "<sphere radius=\"0.044\"/>");
        let text = text.replace("<origin xyz=\"0.5 0 0\" rpy", "<origin xyz=\"0.6 0 0\" rpy");
        let tight = clearance_of(&text, &ClearanceRules::default()).unwrap();
        let upper = &tight.gaps()[place(&tight, "upper and post")];
        assert!((upper.bound - 0.003).abs() < 1e-6 && (upper.reserve - 0.00075).abs() < 1e-6, "{upper:?}");
    }

    fn place(clearance: &Clearance, subject: &str) -> usize {
        clearance.gaps().iter().position(|g| g.subject == subject).unwrap()
    }

    #[test]
    fn what_cannot_be_is_said() {
        let accepting = |a: &str, b: &str| ClearanceRules {
            accepted: vec![(a.into(), b.into(), "a cover is soft".into())],
            floor: FloorRule::Nowhere,
            ..rules(0.0)
        };
        let unknown = clearance(&accepting("fore", "elbow")).err().unwrap();
        assert_eq!(unknown, "there is no link `elbow`; there are post, upper, fore, hand");
        let accepted = clearance(&accepting("post", "fore")).unwrap();
        let signed =
            LeftOut::assumed(LeftOutTopic::Distance, vec!["fore and post".into()], "a cover is soft", "the user");
        assert!(accepted.left_out().contains(&signed), "{:?}", accepted.left_out());
        assert_eq!(accepted.gaps().len(), 2);
        let high = ClearanceRules { floor: FloorRule::At(0.1), ..ClearanceRules::default() };
        let error = clearance(&high).err().unwrap();
        assert!(error.starts_with("upper is 0.1500 m beyond the floor, and no joint"), "{error}");
        let wall = HalfSpace::beyond("the wall".into(), [0.0, 0.0, 0.1], [0.0, 0.0, 1.0]).unwrap();
        let hand = HalfSpace { links: Some(vec!["hand".into()]), ..wall };
        let rules = ClearanceRules {
            own_links: false,
            floor: FloorRule::Nowhere,
            half_spaces: vec![hand],
            ..ClearanceRules::default()
        };
        assert_eq!(clearance(&rules).unwrap().gaps().len(), 1);
    }

    #[test]
    fn a_missing_mesh_is_said() {
        let text = ARM.replace("<box size=\"0.2 0.1 0.02\"/>", "<mesh filename=\"package://arm/hand.stl\"/>");
        let clearance = clearance_of(&text, &rules(0.02)).unwrap();
        assert!(clearance.gaps().iter().all(|g| !g.subject.contains("hand")));
        let of_hand = [(LeftOutTopic::Distance, "hand"), (LeftOutTopic::Floor, "hand at the floor")];
        for (matter, subject) in of_hand {
            let is_it = |out: &&LeftOut| out.matter == matter && out.of == [subject];
            let out = clearance.left_out().iter().find(is_it).unwrap();
            let claims::LeftOutReason::NotLookedAt { why, .. } = &out.why else { panic!("{out:?}") };
            assert!(why.starts_with("mesh package://arm/hand.stl: there is no"), "{why}");
        }
    }
}
