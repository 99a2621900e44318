//! The gaps that a robot must keep, by rules and by its own shape.
//!
//! Two bodies have no gap where they are neighbours, touch at rest, are moved against each other by no joint, or have
//! an unknown shape. The notes name the neighbours, the touching pairs and the unknown shapes.

use std::path::Path;

use robot::{JointKind, Pose, Robot};

use crate::bodies::{Body, Shape, bodies};
use crate::clearance::{Against, Clearance, Gap, PLACE_ROUNDING_M};
use crate::half_space::HalfSpace;
use crate::kinematic_tree::KinematicTree;

/// What is asked of a robot.
#[derive(Clone, Debug, Default)]
pub struct Rules {
    /// Least distance between links that are no neighbours, m. `None`: such distances are not looked at.
    pub distance: Option<f64>,
    /// Pairs of links whose distance is not looked at.
    pub ignored_pairs: Vec<(String, String)>,
    /// Where bodies must stay.
    pub half_spaces: Vec<HalfSpace>,
}

/// The rest pose and the moving coordinates, by which gaps are chosen.
#[derive(Clone, Debug)]
pub struct Situation {
    /// Where each coordinate rests, rad (m).
    pub rest: Vec<f64>,
    /// Whether each coordinate moves.
    pub moves: Vec<bool>,
}

/// Bodies nearer than this at rest touch, m.
const TOUCHING_DISTANCE_M: f64 = 1e-6;
/// Change of a gap, m a rad (m), below which the gap counts as constant.
const CONSTANT_GAP_CHANGE: f64 = 1e-9;

impl Clearance {
    /// The gaps that the rules ask for; `directory`: that of the description, from which meshes are found.
    ///
    /// Fails where a rule names a link that is not there, and where a body is beyond a half-space and no joint moves
    /// it. Gaps that are not looked at are in the notes.
    pub fn new(robot: &Robot, directory: &Path, rules: &Rules, situation: &Situation) -> Result<Clearance, String> {
        let asked = rules.distance.is_some() || !rules.half_spaces.is_empty();
        let tree = KinematicTree::new(robot).ok_or("joints are found numerically: distances are not looked at")?;
        let bodies = if asked { bodies(robot, directory) } else { vec![] };
        let half_spaces = rules.half_spaces.clone();
        let mut clearance = Clearance { tree, bodies, half_spaces, gaps: vec![], notes: vec![] };
        clearance.check_names(rules)?;
        clearance.say_what_is_missing(rules);
        let poses = clearance.tree.poses(&situation.rest);
        if let Some(bound) = rules.distance {
            clearance.add_pairs(robot, bound, &rules.ignored_pairs, situation, &poses);
        }
        for wall in 0..clearance.half_spaces.len() {
            clearance.add_wall(wall, situation, &poses)?;
        }
        Ok(clearance)
    }

    fn check_names(&self, rules: &Rules) -> Result<(), String> {
        let known = |name: &str| self.bodies.iter().any(|b| b.name == name || b.shapes.iter().any(|s| s.link == name));
        let pairs = rules.ignored_pairs.iter().flat_map(|(a, b)| [a, b]);
        let walls = rules.half_spaces.iter().filter_map(|h| h.links.as_ref()).flatten();
        match pairs.chain(walls).find(|name| !self.bodies.is_empty() && !known(name)) {
            None => Ok(()),
            Some(name) => {
                let names: Vec<&str> = self.bodies.iter().map(|b| b.name.as_str()).collect();
                Err(format!("there is no link `{name}`; there are {}", names.join(", ")))
            }
        }
    }

    fn say_what_is_missing(&mut self, rules: &Rules) {
        let missing = self.bodies.iter().filter(|b| !b.missing.is_empty());
        let say = |b: &Body| format!("distances of {} are not looked at: {}", b.name, b.missing.join("; "));
        self.notes.extend(missing.map(say));
        let bare: Vec<&str> =
            self.bodies.iter().filter(|b| b.link.is_some() && !b.has_geometry).map(|b| b.name.as_str()).collect();
        let moving = self.bodies.iter().filter(|b| b.link.is_some()).count();
        let bare_text = if bare.len() == moving { "the links".into() } else { bare.join(", ") };
        if rules.distance.is_some() && !bare.is_empty() {
            self.notes
                .push(format!("distances between own links: no collision geometry of {bare_text}, not looked at"));
        }
        if !rules.half_spaces.is_empty() && !bare.is_empty() {
            let text = format!(
                "boxes, floors and walls: no collision geometry of {bare_text}: the origins of the frames stand for it"
            );
            self.notes.push(text);
        }
    }

    /// Every two bodies with a shape that move against each other and are no neighbours.
    fn add_pairs(
        &mut self,
        robot: &Robot,
        bound: f64,
        ignored: &[(String, String)],
        situation: &Situation,
        poses: &[Pose],
    ) {
        let (mut neighbours, mut touching, mut left_out) = (Vec::new(), Vec::new(), Vec::new());
        for a in 0..self.bodies.len() {
            for b in 0..a {
                let (body, other) = (&self.bodies[a], &self.bodies[b]);
                let is_known = |b: &Body| b.has_geometry && b.missing.is_empty();
                if !is_known(body) || !is_known(other) {
                    continue;
                }
                let joints = self.between(body.link, other.link);
                if !joints.iter().flatten().any(|&j| self.turns(j, &situation.moves)) {
                    continue;
                }
                let subject = format!("{} and {}", body.name, other.name);
                let has = |body: &Body, name: &str| body.name == name || body.shapes.iter().any(|s| s.link == name);
                let is_named =
                    |(x, y): &(String, String)| (has(body, x) && has(other, y)) || (has(body, y) && has(other, x));
                if ignored.iter().any(is_named) {
                    left_out.push(subject);
                    continue;
                }
                if self.are_neighbours(robot, a, b) {
                    neighbours.push(subject);
                    continue;
                }
                let shapes = (0..body.shapes.len()).collect();
                let gap = Gap { subject, is_own: true, bound, body: a, shapes, against: Against::Body(b), joints };
                if self.apart(&gap, poses, None).reached < TOUCHING_DISTANCE_M {
                    touching.push(gap.subject);
                } else {
                    self.gaps.push(gap);
                }
            }
        }
        for (why, pairs) in
            [("neighbours", neighbours), ("touch at rest", touching), ("left out by the limits file", left_out)]
        {
            if !pairs.is_empty() {
                self.notes.push(format!("distances not looked at, {why}: {}", pairs.join("; ")));
            }
        }
    }

    /// Whether no other body is on the way from one link to the other, or a loop joins them.
    fn are_neighbours(&self, robot: &Robot, a: usize, b: usize) -> bool {
        let link = |body: usize| self.bodies[body].link;
        let has_geometry = |link: Option<usize>| self.bodies.iter().any(|body| body.link == link && body.has_geometry);
        let next_inward = |from: usize| {
            let above = self.tree.inward(link(from)).into_iter().skip(1).map(Some).chain([None]);
            { above }.find(|l| has_geometry(*l))
        };
        let is_above = |from: usize, to: usize| link(from).is_some() && next_inward(from) == Some(link(to));
        let cut = |one: &robot::Loop| [&one.cut, &one.twin].map(|frame| frame.antecedent.map(|l| l.0));
        let joined = robot.loops.iter().map(cut).any(|ends| ends == [link(a), link(b)] || ends == [link(b), link(a)]);
        is_above(a, b) || is_above(b, a) || joined
    }

    /// Adds the gaps between a half-space and the bodies that must stay in it and that move towards it or away.
    fn add_wall(&mut self, wall: usize, situation: &Situation, poses: &[Pose]) -> Result<(), String> {
        let HalfSpace { name, links, .. } = self.half_spaces[wall].clone();
        for (at, body) in self.bodies.iter().enumerate().filter(|(_, b)| b.link.is_some()) {
            let is_meant = |shape: &Shape| match &links {
                None => true,
                Some(links) => links.iter().any(|l| *l == body.name || *l == shape.link),
            };
            let shapes: Vec<usize> = (0..body.shapes.len()).filter(|&s| is_meant(&body.shapes[s])).collect();
            if shapes.is_empty() || !body.missing.is_empty() {
                continue;
            }
            let gap = Gap {
                subject: format!("{} at {name}", body.name),
                is_own: false,
                bound: 0.0,
                body: at,
                shapes,
                against: Against::HalfSpace(wall),
                joints: self.between(body.link, None),
            };
            let unit: Vec<f64> = situation.moves.iter().map(|m| f64::from(u8::from(*m))).collect();
            let now = self.apart(&gap, poses, Some(&unit));
            if now.reached - now.at_least > CONSTANT_GAP_CHANGE + PLACE_ROUNDING_M {
                self.gaps.push(gap);
            } else if now.reached < 0.0 {
                return Err(format!(
                    "{} is {:.4} m beyond {name}, and no joint that is not locked moves it away: name the links that must \
                     stay in (links: [..]), or move {name}",
                    body.name, -now.reached
                ));
            }
        }
        Ok(())
    }

    /// Whether any coordinate that moves turns (slides) a joint.
    fn turns(&self, joint: usize, moves: &[bool]) -> bool {
        self.tree.kind(joint) != JointKind::Fixed && self.tree.terms(joint).iter().any(|(k, m)| *m != 0.0 && moves[*k])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two links in a plane that turn about z, of one metre each, round by 5 cm, on a post.
    const ARM: &str = r#"<robot name="arm">
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

    fn clearance(rules: &Rules) -> Result<Clearance, String> {
        let robot = robot::format::read_urdf(ARM, "arm.urdf").unwrap();
        let situation = Situation { rest: vec![0.0; 3], moves: vec![true; 3] };
        Clearance::new(&robot, Path::new("."), rules, &situation)
    }

    fn floor() -> HalfSpace {
        HalfSpace::beyond("the floor".into(), [0.0, 0.0, -0.15], [0.0, 0.0, 1.0]).unwrap()
    }

    #[test]
    fn gaps_of_an_arm_are_those_of_geometry() {
        let rules = Rules { distance: Some(0.02), half_spaces: vec![floor()], ..Rules::default() };
        let clearance = clearance(&rules).unwrap();
        let subjects: Vec<&str> = clearance.gaps().iter().map(|g| g.subject.as_str()).collect();
        // Turning about z, only the hand comes nearer to the floor.
        assert_eq!(subjects, ["fore and post", "hand and post", "hand and upper", "hand at the floor"]);
        let note = "distances not looked at, neighbours: upper and post; fore and upper; hand and fore";
        assert_eq!(clearance.notes(), [note]);
        let rooms = clearance.rooms(&[0.3, 0.0, 0.0], &[0.0; 3], &[0, 1, 2, 3]);
        let expected = [1.0 - 0.1 - 0.05, 1.8 - 0.1, 0.8 - 0.05, 0.15 - 0.01];
        for (room, expected) in rooms.iter().zip(expected) {
            // A search for the nearest points ends within 1e-8 of them.
            assert!((room.reached - expected).abs() < 1e-7 && (room.at_least - expected).abs() < 1e-7, "{room:?}");
        }
        // Folded back: the hand lies on the post.
        let rooms = clearance.rooms(&[0.0, std::f64::consts::PI, 0.0], &[0.0; 3], &[0, 1]);
        assert!((rooms[0].reached - (0.2 - 0.15)).abs() < 1e-7 && rooms[1].reached < 0.0, "{rooms:?}");
    }

    /// Near a configuration no gap is below what was proved for it, and the proof closes as the neighbourhood does.
    #[test]
    fn what_is_proved_holds_nearby() {
        let rules = Rules { distance: Some(0.02), half_spaces: vec![floor()], ..Rules::default() };
        let clearance = clearance(&rules).unwrap();
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
                // No joint is farther than 2.1 m from any point it moves, and three of them move.
                assert!(proved.iter().all(|r| r.reached - r.at_least < 6.3 * spread + 1e-6), "{proved:?}");
            }
        }
    }

    #[test]
    fn slopes_are_those_of_differences() {
        let rules = Rules { distance: Some(0.02), half_spaces: vec![floor()], ..Rules::default() };
        let clearance = clearance(&rules).unwrap();
        let at = |q: [f64; 3]| {
            let mut found = vec![];
            clearance.near(&q, 0.5, &mut |g, room, slope| found.push((g, room, slope.to_vec())));
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
                    // The nearest point of a box jumps from corner to corner: there the slope is one of the two sides.
                    let one_sided = [(moved(1e-5) - room) / 1e-5, (room - moved(-1e-5)) / 1e-5];
                    let off = one_sided.into_iter().chain([difference]).map(|d| (slope[k] - d).abs());
                    // Distances are found within 1e-9: over 1e-5 that is 1e-4.
                    assert!(off.fold(f64::INFINITY, f64::min) < 1e-3, "{g} {k}: {} {difference}", slope[k]);
                }
            }
        }
        assert!(seen > 20, "{seen}");
    }

    #[test]
    fn what_cannot_be_is_said() {
        let unknown =
            Rules { ignored_pairs: vec![("fore".into(), "elbow".into())], distance: Some(0.0), ..Rules::default() };
        assert_eq!(clearance(&unknown).err().unwrap(), "there is no link `elbow`; there are post, upper, fore, hand");
        let ignored =
            Rules { ignored_pairs: vec![("post".into(), "fore".into())], distance: Some(0.0), ..Rules::default() };
        let ignored = clearance(&ignored).unwrap();
        assert!(ignored.notes().iter().any(|n| n.ends_with("left out by the limits file: fore and post")));
        assert_eq!(ignored.gaps().len(), 2);
        let high = HalfSpace::beyond("the floor".into(), [0.0, 0.0, 0.1], [0.0, 0.0, 1.0]).unwrap();
        let error = clearance(&Rules { half_spaces: vec![high.clone()], ..Rules::default() }).err().unwrap();
        assert!(error.starts_with("upper is 0.1500 m beyond the floor, and no joint"), "{error}");
        let hand = HalfSpace { links: Some(vec!["hand".into()]), ..high };
        assert_eq!(clearance(&Rules { half_spaces: vec![hand], ..Rules::default() }).unwrap().gaps().len(), 1);
    }

    /// A mesh that is not there leaves its link out, with its path.
    #[test]
    fn a_missing_mesh_is_said() {
        let text = ARM.replace("<box size=\"0.2 0.1 0.02\"/>", "<mesh filename=\"package://arm/hand.stl\"/>");
        let robot = robot::format::read_urdf(&text, "arm.urdf").unwrap();
        let situation = Situation { rest: vec![0.0; 3], moves: vec![true; 3] };
        let rules = Rules { distance: Some(0.02), half_spaces: vec![floor()], ..Rules::default() };
        let clearance = Clearance::new(&robot, Path::new("."), &rules, &situation).unwrap();
        assert!(clearance.gaps().iter().all(|g| !g.subject.contains("hand")));
        assert!(
            clearance.notes()[0]
                .starts_with("distances of hand are not looked at: hand: mesh package://arm/hand.stl: there is no"),
            "{:?}",
            clearance.notes()
        );
    }
}
