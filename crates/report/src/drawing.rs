//! Data for drawing a robot on a page: its frames, the variables that move them, and the ranges of these variables.
//!
//! ```text
//! T_j = T_a(j) A_j Rz(x_j)  or  T_a(j) A_j Tz(x_j),   x_j = offset + sum of factor * variable
//! ```
//! A_j: transform from frame j to its antecedent a(j) at x_j = 0 [Khalil, Kleinfinger 1986]. The script `templates/drawing.js`
//! computes and draws the frames: its function `Drawing.of(element)` reads the data of this module as JSON, so that any page
//! can contain a moving robot. The script also closes loops whose equations are solved numerically.

use gate::shown::lines;
use robot::value::CoordinateId;
use robot::{JointKind, Link, LinkId, LoopFrame, ModifiedDh, Pose, Robot};
use serde::Serialize;

use crate::template::rendered;

/// Factor for rounding the numbers of a drawing to nine decimals (m, or without unit).
const DECIMALS: f64 = 1e9;
/// Largest length in a drawing, m. Next to a larger length, all other lengths would be invisible.
const LARGEST_LENGTH_M: f64 = 1e6;
/// Largest angle of a slider, rad. One turn is enough for a continuous joint.
const LARGEST_ANGLE_RAD: f64 = 2.0 * std::f64::consts::PI;

/// The data of a robot that the script draws.
#[derive(Clone, Debug, Serialize)]
pub struct Drawing {
    name: String,
    /// Unit vector opposite to gravity, in the base frame; the z axis if there is no gravity.
    up: [f64; 3],
    /// The variables of the robot: first the coordinates, then the passive coordinates.
    variables: Vec<Variable>,
    /// Number of the variables that are coordinates.
    coordinates: usize,
    /// The links, in the order of the description.
    links: Vec<Drawn>,
    /// For each loop, the two frames that coincide when the loop is closed.
    loops: Vec<[DrawnFrame; 2]>,
}

/// A variable of the robot: its name, its initial value, and the range of its slider.
#[derive(Clone, Debug, Serialize)]
struct Variable {
    name: String,
    /// Whether the variable is an angle, rad; otherwise it is a length, m.
    turns: bool,
    /// Initial value of the variable, rad (m).
    at: f64,
    from: f64,
    to: f64,
}

/// A frame of the drawing, and the variables that move it.
#[derive(Clone, Debug, Serialize)]
struct DrawnFrame {
    /// Index of the link that carries the frame; `None`: the base.
    on: Option<usize>,
    kind: &'static str,
    /// Constant transform A_j to the antecedent: a 3 x 4 matrix, row by row.
    place: [f64; 12],
    /// Two corners of the drawn path from the origin of the antecedent frame to the axis of this frame: the point after the
    /// shift b along z, and the point after the shift d along x. Coordinates in the antecedent frame, m.
    corners: [[f64; 3]; 2],
    /// The variables that move the frame: index and factor of each.
    terms: Vec<(usize, f64)>,
    offset: f64,
}

/// A link in the drawing.
#[derive(Clone, Debug, Serialize)]
struct Drawn {
    name: String,
    #[serde(flatten)]
    frame: DrawnFrame,
    /// Other frames of the file that are fixed to the link, at another origin: name, and origin in the link frame, m.
    fixed: Vec<(String, [f64; 3])>,
    /// Centre of mass in the link frame, m; `None` if the file gives no centre of mass.
    mass_centre: Option<[f64; 3]>,
}

impl Drawing {
    /// The drawing of a robot. `at`: values of the variables, rad (m), at which the numerically solved loops are closed;
    /// empty without such loops. `None` if a length of the geometry is too large.
    pub fn new(robot: &Robot, at: &[f64]) -> Option<Drawing> {
        let variables = (0..robot.n_variables()).map(|k| variable(robot, k, at.get(k).copied())).collect();
        let links: Vec<Drawn> = robot.links.iter().map(|link| drawn(robot, link)).collect();
        let loops: Vec<[DrawnFrame; 2]> =
            robot.loops.iter().map(|one| [&one.cut, &one.twin].map(|frame| of_loop(robot, frame))).collect();
        let frames = links.iter().map(|link| &link.frame).chain(loops.iter().flatten());
        let numbers = |f: &DrawnFrame| [&f.place[..], &f.corners.concat(), &[f.offset]].concat();
        let own = links.iter().flat_map(|l| l.fixed.iter().map(|(_, p)| *p).chain(l.mass_centre)).flatten();
        let is_drawn = frames.flat_map(numbers).chain(own).all(|x| x.abs() < LARGEST_LENGTH_M);
        let up = up(robot);
        is_drawn.then(|| Drawing {
            name: lines(&robot.name).into_owned(),
            up,
            variables,
            coordinates: robot.n_coordinates(),
            links,
            loops,
        })
    }

    /// The HTML content of a figure with class drawing, in which `templates/drawing.js` draws the robot.
    pub fn html(&self) -> String {
        #[derive(Serialize)]
        struct DrawingContext {
            json: String,
            links: usize,
        }
        let content = DrawingContext { json: self.to_json(), links: self.links.len() };
        rendered(include_str!("../templates/drawing.html"), content)
    }

    /// The drawing as JSON. It contains no `<`, so it can be inserted into a page.
    pub fn to_json(&self) -> String {
        // Serialising cannot fail, because all keys of maps are texts.
        serde_json::to_string(self).unwrap_or_default().replace('<', "\\u003c")
    }
}

fn up(robot: &Robot) -> [f64; 3] {
    let g = robot.gravity_number();
    let norm = robot::vector::norm(g);
    if norm > 0.0 && norm.is_finite() { g.map(|x| rounded(-x / norm)) } else { [0.0, 0.0, 1.0] }
}

/// Variable k with the range of its slider (a default if the file gives none). The initial value of the variable is zero if the
/// range contains zero, otherwise the middle of the range.
fn variable(robot: &Robot, k: usize, at: Option<f64>) -> Variable {
    let moved = |frame: &(JointKind, &[(CoordinateId, f64)])| frame.1.iter().any(|(c, _)| c.0 == k);
    let joints = robot.links.iter().map(|l| (l.joint.kind, &l.joint.variable.terms[..]));
    let cuts = robot.loops.iter().map(|one| (one.cut.kind, &one.cut.variable.terms[..]));
    let kind = joints.chain(cuts).find(moved).map_or(JointKind::Revolute, |found| found.0);
    let turns = kind != JointKind::Prismatic;
    let half = if turns { std::f64::consts::PI } else { slider_stroke(robot) };
    let given = robot.coordinates.get(k).and_then(|c| c.limits.position);
    let (from, to) = given.filter(|(a, b)| a.is_finite() && b.is_finite() && a < b).unwrap_or((-half, half));
    let farthest = if turns { LARGEST_ANGLE_RAD } else { LARGEST_LENGTH_M };
    let (from, to) = (from.clamp(-farthest, farthest), to.clamp(-farthest, farthest));
    let (from, to) = if from < to { (from, to) } else { (-half, half) };
    let middle = if from <= 0.0 && 0.0 <= to { 0.0 } else { 0.5 * (from + to) };
    let at = at.filter(|x| x.is_finite()).unwrap_or(middle);
    Variable {
        name: lines(robot.coordinate_name(CoordinateId(k))).into_owned(),
        turns,
        at: rounded(at),
        from: rounded(from.min(at)),
        to: rounded(to.max(at)),
    }
}

/// Default stroke of a prismatic joint without limits, m: half the sum of all lengths of the robot; 0.5 if the robot has no
/// lengths.
fn slider_stroke(robot: &Robot) -> f64 {
    let length = |g: &ModifiedDh| [&g.b, &g.d, &g.r].map(|x| x.number(&robot.symbols).abs()).iter().sum::<f64>();
    let all: f64 = robot.links.iter().map(|link| length(&link.geometry)).sum();
    if all > 0.0 && all < LARGEST_LENGTH_M { 0.5 * all } else { 0.5 }
}

fn frame(robot: &Robot, on: Option<LinkId>, g: &ModifiedDh, kind: JointKind, variable: &robot::Affine) -> DrawnFrame {
    let symbols = &robot.symbols;
    let Pose { rotation, position } = g.pose(symbols, 0.0, 0.0);
    let (sine, cosine) = robot::kinematics::sin_cos(&g.gamma, symbols);
    let [b, d] = [&g.b, &g.d].map(|x| x.number(symbols));
    let row = |r: usize| [rotation[r][0], rotation[r][1], rotation[r][2], position[r]];
    let rows = [row(0), row(1), row(2)];
    DrawnFrame {
        on: on.map(|id| id.0),
        kind: match kind {
            JointKind::Revolute => "revolute",
            JointKind::Prismatic => "prismatic",
            JointKind::Fixed => "fixed",
        },
        place: std::array::from_fn(|i| rounded(rows[i / 4][i % 4])),
        corners: [[0.0, 0.0, b], [cosine * d, sine * d, b]].map(|p| p.map(rounded)),
        terms: variable.terms.iter().map(|(k, factor)| (k.0, *factor)).collect(),
        offset: rounded(variable.offset.number(symbols)),
    }
}

fn of_loop(robot: &Robot, f: &LoopFrame) -> DrawnFrame {
    frame(robot, f.antecedent, &f.geometry, f.kind, &f.variable)
}

fn drawn(robot: &Robot, link: &Link) -> Drawn {
    let fixed = link.frames.iter().map(|(name, pose)| (lines(name).into_owned(), pose.position.map(rounded)));
    let centre = |x: &[f64; 10]| (x[9] > 0.0).then(|| [6, 7, 8].map(|i| rounded(x[i] / x[9])));
    Drawn {
        name: lines(&link.name).into_owned(),
        frame: frame(robot, link.antecedent, &link.geometry, link.joint.kind, &link.joint.variable),
        fixed: fixed.filter(|(_, p)| p.iter().any(|x| *x != 0.0)).collect(),
        mass_centre: link.inertial.as_ref().and_then(centre),
    }
}

/// Rounds to nine decimals; -0 becomes 0.
fn rounded(x: f64) -> f64 {
    (x * DECIMALS).round() / DECIMALS + 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Robot {
        robot::format::read_yaml(text, "two.yaml").unwrap()
    }

    const TWO: &str = "convention: khalil-kleinfinger\nname: <two>\nlinks:\n  - {link: 1, antecedent: base, theta: q1}\n  \
                       - {link: 2, antecedent: 1, alpha: pi/2, d: 0.5, b: 0.1, r: q2 + 0.2, joint: prismatic}\n";

    #[test]
    fn a_frame_is_where_the_robot_has_it() {
        let robot = read(TWO);
        let drawing = Drawing::new(&robot, &[]).unwrap();
        let link = &drawing.links[1].frame;
        let pose = &robot.link_poses(&[0.0, 0.0])[1];
        // The frame at x_2 = offset is shifted along its z axis, which is (0, -1, 0) in the frame of link 1.
        let at: Vec<f64> = (0..3).map(|r| link.place[4 * r + 3] + link.place[4 * r + 2] * link.offset).collect();
        assert!(at.iter().zip(pose.position).all(|(a, b)| (a - b).abs() < 1e-9), "{at:?} {pose:?}");
        assert_eq!(link.corners, [[0.0, 0.0, 0.1], [0.5, 0.0, 0.1]]);
        assert_eq!((link.terms.as_slice(), link.kind), (&[(1, 1.0)][..], "prismatic"));
        assert!(drawing.variables[0].turns && !drawing.variables[1].turns);
    }

    #[test]
    fn a_name_closes_no_script() {
        assert!(!Drawing::new(&read(TWO), &[]).unwrap().to_json().contains('<'));
    }

    #[test]
    fn what_has_no_size_is_not_drawn() {
        assert!(Drawing::new(&read(&TWO.replace("0.5", "1e14")), &[]).is_none());
    }
}
