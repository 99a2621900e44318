//! The robots of the random situations: random geometries, or models of models/ with changed bodies.
//!
//! A machine is a true robot: a chain of bodies, friction, and the description that the user has. The description may have
//! wrong bodies or none. Sizes are rms torques.

use std::f64::consts::{FRAC_PI_2, PI};

use robot::{JointKind, Robot};

use super::chain::{
    Body, Chain, GRAVITY, Joint, Matrix, UNIT, Vector, about, plus, product, times, transposed, turned,
};
use super::draw::Draw;

/// Files of models/ whose robots are trees in which each joint has its own coordinate.
const SHIPPED: [&str; 9] = [
    "ur5.urdf",
    "ur5.yaml",
    "panda.yaml",
    "kuka_lwr.yaml",
    "puma560.yaml",
    "scara.yaml",
    "stanford.yaml",
    "tx40.yaml",
    "planar2r_vertical.yaml",
];

const X: Vector = [1.0, 0.0, 0.0];
const Z: Vector = [0.0, 0.0, 1.0];

/// The friction of a joint: viscous and Coulomb friction and an offset, as in a fit with default options.
#[derive(Clone, Copy, Debug)]
pub struct Friction {
    /// Viscous friction, N m s/rad (N s/m). `coulomb`: Coulomb friction, N m (N). `offset`: N m (N).
    pub viscous: f64,
    pub coulomb: f64,
    pub offset: f64,
}

/// A machine with its true parameters, and the nominal parameters of its description.
pub struct Machine {
    pub name: String,
    pub chain: Chain,
    pub friction: Vec<Friction>,
    /// Rms torque of each joint, N m (N).
    pub size: Vec<f64>,
    /// The bodies in the description; `None`: it has no inertial parameters.
    pub described: Option<Vec<Body>>,
    /// How the description differs from the machine, in words.
    pub description: &'static str,
}

/// A machine for a situation: a shipped model or a random one.
pub fn machine(draw: &mut Draw) -> Machine {
    let (name, chain) = match draw.chance(0.5) {
        true => shipped(SHIPPED[draw.below(SHIPPED.len())], draw),
        false => random(draw),
    };
    machine_of(name, chain, draw)
}

pub fn scara(draw: &mut Draw) -> Machine {
    let (name, chain) = shipped("scara.yaml", draw);
    machine_of(name, chain, draw)
}

/// A gantry: three prismatic joints at right angles, the last one vertical, and a wrist with zero to two revolute joints.
pub fn gantry(draw: &mut Draw) -> Machine {
    let mut mass = draw.log(3.0, 20.0);
    let wrist = draw.below(3);
    let turns = [about([0.0, 1.0, 0.0], FRAC_PI_2), about(X, -FRAC_PI_2), about(X, FRAC_PI_2)];
    let joint = |k: usize| {
        let slides = k < 3;
        let length = if slides { draw.uniform(0.1, 0.4) } else { draw.uniform(0.05, 0.2) };
        mass *= draw.uniform(0.4, 0.9);
        let rotation = if slides { turns[k] } else { about(X, FRAC_PI_2 * draw.below(4) as f64) };
        let (range, speed) = if slides { (0.5, 0.8) } else { (2.0, 2.5) };
        let body = body(draw, mass, length);
        let parent = k.checked_sub(1);
        Joint {
            parent,
            rotation,
            origin: times(Z, length),
            axis: Z,
            slides,
            body,
            rotor: 0.0,
            range,
            speed,
            effort: 0.0,
        }
    };
    let chain = Chain { joints: (0..3 + wrist).map(joint).collect(), gravity: GRAVITY };
    machine_of(format!("gantry_{}", 3 + wrist), chain, draw)
}

/// Two arms. The second is the mirror image of the first in the plane y = 0. Their bodies differ by some per cent, because of
/// cables and screws.
///
/// M = diag(1, -1, 1). A rotation R becomes M R M, a position p becomes M p, and an inertia I becomes M I M.
pub fn mirrored_arms(draw: &mut Draw) -> Machine {
    const MIRROR: Matrix = [X, [0.0, -1.0, 0.0], Z];
    let across = |m: &Matrix| product(&product(&MIRROR, m), &MIRROR);
    let (_, mut chain) = random(draw);
    chain.joints.truncate(4);
    let n = chain.joints.len();
    chain.joints[0].origin[1] += 0.2;
    let image = |joint: &Joint| {
        let differ = 1.0 + draw.uniform(-0.05, 0.05);
        let body = &joint.body;
        let inertia = across(&body.inertia).map(|row| times(row, differ));
        let body = Body { mass: body.mass * differ, centre: turned(&MIRROR, body.centre), inertia };
        let (parent, rotation) = (joint.parent.map(|i| i + n), across(&joint.rotation));
        Joint { parent, rotation, origin: turned(&MIRROR, joint.origin), body, ..joint.clone() }
    };
    let images: Vec<Joint> = chain.joints.iter().map(image).collect();
    chain.joints.extend(images);
    machine_of(format!("two_arms_{n}"), chain, draw)
}

/// A machine with this geometry. Its rotors, friction, effort limits and description are random.
fn machine_of(name: String, mut chain: Chain, draw: &mut Draw) -> Machine {
    let geared = draw.chance(0.6);
    let n = chain.len();
    let pose: Vec<f64> = chain.joints.iter().map(|j| 0.5 * j.range).collect();
    let own = chain.own_inertia(&pose);
    for (joint, own) in chain.joints.iter_mut().zip(own) {
        joint.rotor = if geared && draw.chance(0.8) { draw.log(0.1, 2.0) * (own + 1e-3) } else { 0.0 };
    }
    let size = torque_size(&chain, draw);
    let friction = (0..n).map(|k| friction(draw, size[k], chain.joints[k].speed)).collect();
    for (joint, size) in chain.joints.iter_mut().zip(&size) {
        joint.effort = 4.0 * size;
    }
    let bodies: Vec<Body> = chain.joints.iter().map(|j| j.body).collect();
    let (description, described) = match draw.below(10) {
        0..=3 => ("exact", Some(bodies)),
        4..=7 => ("15 % off", Some(bodies.iter().map(|b| off(b, draw)).collect())),
        _ => ("no bodies", None),
    };
    Machine { name, chain, friction, size, described, description }
}

fn friction(draw: &mut Draw, size: f64, speed: f64) -> Friction {
    Friction {
        viscous: draw.uniform(0.02, 0.15) * size / speed,
        coulomb: draw.uniform(0.02, 0.15) * size,
        offset: draw.uniform(-0.03, 0.03) * size,
    }
}

/// The body with a random error of up to 15 % in mass, moments of inertia and centre of mass. It remains physically possible.
fn off(body: &Body, draw: &mut Draw) -> Body {
    let (mass, moments) = (1.0 + draw.uniform(-0.15, 0.15), 1.0 + draw.uniform(-0.15, 0.15));
    let inertia = body.inertia.map(|row| times(row, mass * moments));
    Body { mass: body.mass * mass, centre: body.centre.map(|c| c * (1.0 + draw.uniform(-0.15, 0.15))), inertia }
}

/// Rms torque of each joint at random states (80 % of the position range, half of the speed limit), N m (N). At least 1/50 of the
/// largest rms torque.
fn torque_size(chain: &Chain, draw: &mut Draw) -> Vec<f64> {
    const STATES: usize = 100;
    let n = chain.len();
    let mut square = vec![0.0; n];
    for _ in 0..STATES {
        let q: Vec<f64> = chain.joints.iter().map(|j| j.range * draw.uniform(-0.8, 0.8)).collect();
        let dq: Vec<f64> = chain.joints.iter().map(|j| j.speed * draw.uniform(-0.5, 0.5)).collect();
        let ddq: Vec<f64> = chain.joints.iter().map(|j| 2.0 * j.speed * draw.uniform(-0.5, 0.5)).collect();
        let tau = chain.torque(&q, &dq, &ddq);
        for k in 0..n {
            square[k] += (tau[k] + chain.joints[k].rotor * ddq[k]).powi(2) / STATES as f64;
        }
    }
    let largest = square.iter().copied().fold(0.0, f64::max).sqrt();
    square.iter().map(|s| s.sqrt().max(0.02 * largest)).collect()
}

/// The body of a link with this length: a box somewhere along the link.
fn body(draw: &mut Draw, mass: f64, length: f64) -> Body {
    let sides = [0, 1, 2].map(|_| draw.uniform(0.3, 1.0) * (0.06 + 0.6 * length));
    let squares = sides.map(|s| mass * s * s / 12.0);
    let box_of =
        [[squares[1] + squares[2], 0.0, 0.0], [0.0, squares[0] + squares[2], 0.0], [0.0, 0.0, squares[0] + squares[1]]];
    let tilt = product(&about(X, draw.uniform(-0.5, 0.5)), &about(Z, draw.uniform(-0.5, 0.5)));
    let inertia = product(&product(&tilt, &box_of), &transposed(&tilt));
    Body { mass, centre: [0, 1, 2].map(|_| draw.uniform(-0.5, 0.5) * (0.04 + length)), inertia }
}

fn random(draw: &mut Draw) -> (String, Chain) {
    let n = 2 + draw.below(6);
    let mut mass = draw.log(1.0, 20.0);
    let mut joints = Vec::new();
    for k in 0..n {
        let length = draw.uniform(0.05, 0.4);
        let along = [X, Z, [0.0, 1.0, 0.0]][draw.below(3)];
        let mut rotation = UNIT;
        for axis in [X, Z] {
            let oblique = if draw.chance(0.1) { draw.uniform(-0.6, 0.6) } else { 0.0 };
            rotation = product(&rotation, &about(axis, FRAC_PI_2 * draw.below(4) as f64 + oblique));
        }
        let slides = draw.chance(0.15);
        joints.push(Joint {
            parent: k.checked_sub(1),
            rotation,
            origin: times(along, length),
            axis: Z,
            slides,
            body: body(draw, mass, length),
            rotor: 0.0,
            range: if slides { draw.uniform(0.2, 0.6) } else { draw.uniform(1.2, 3.0) },
            speed: if slides { draw.uniform(0.4, 1.2) } else { draw.uniform(1.2, 4.0) },
            effort: 0.0,
        });
        mass *= draw.uniform(0.4, 0.9);
    }
    (format!("random_{n}"), Chain { joints, gravity: GRAVITY })
}

fn shipped(file: &str, draw: &mut Draw) -> (String, Chain) {
    let mut chain = chain_of(&crate::model(file));
    let mut mass = draw.log(3.0, 15.0);
    for joint in &mut chain.joints {
        let length = joint.origin.iter().map(|x| x * x).sum::<f64>().sqrt().min(0.5);
        // The body of the model is changed. If the model has no body, or only a point mass, a random body is used.
        let is_body = joint.body.mass > 0.0 && (0..3).all(|i| joint.body.inertia[i][i] > 1e-6);
        joint.body = match is_body {
            true => {
                let moved = off(&joint.body, draw);
                let shift = [0, 1, 2].map(|_| draw.uniform(-0.02, 0.02));
                Body { centre: plus(moved.centre, shift), ..moved }
            }
            false => body(draw, mass, length),
        };
        mass *= draw.uniform(0.4, 0.9);
        joint.range = if joint.slides { draw.uniform(0.2, 0.6) } else { draw.uniform(1.5, 3.0) };
        joint.speed = if joint.slides { draw.uniform(0.4, 1.2) } else { draw.uniform(1.2, 4.0) };
    }
    (file.replace('.', "_"), chain)
}

/// The geometry and the bodies of a description in which each joint has its own coordinate.
///
/// [Khalil, Kleinfinger 1986]: Rz(gamma) Tz(b) Rx(alpha) Tx(d) is before the joint; Rz(theta) Tz(r) moves with the joint.
pub fn chain_of(robot: &Robot) -> Chain {
    let joint = |link: &robot::Link| {
        let number = |v: &robot::Value| v.number(&robot.symbols);
        let g = &link.geometry;
        let slides = link.joint.kind == JointKind::Prismatic;
        let offset = number(&link.joint.variable.offset);
        let (angle, length) = if slides { (0.0, offset) } else { (offset, 0.0) };
        let gamma = about(Z, number(&g.gamma));
        let twisted = product(&gamma, &about(X, number(&g.alpha)));
        let lever = plus(times(X, number(&g.d)), times(Z, number(&g.r) + length));
        let rotation = product(&twisted, &about(Z, number(&g.theta) + angle));
        let origin = plus(times(Z, number(&g.b)), turned(&twisted, lever));
        let body = link.inertial.map_or(Body { mass: 0.0, centre: [0.0; 3], inertia: [[0.0; 3]; 3] }, body_of);
        let parent = link.antecedent.map(|i| i.0);
        let (range, speed) = (PI, 1.0);
        Joint { parent, rotation, origin, axis: Z, slides, body, rotor: 0.0, range, speed, effort: 0.0 }
    };
    let gravity = robot.gravity_number();
    let gravity = if gravity == [0.0; 3] { GRAVITY } else { gravity };
    let mut chain = Chain { joints: robot.links.iter().map(joint).collect(), gravity };
    stand_upright(&mut chain);
    chain
}

/// Rotates the base such that gravity is along -z, as in a URDF.
fn stand_upright(chain: &mut Chain) {
    let g = times(chain.gravity, 1.0 / chain.gravity.iter().map(|x| x * x).sum::<f64>().sqrt());
    let down = [0.0, 0.0, -1.0];
    let axis = super::chain::cross(g, down);
    let sine = axis.iter().map(|x| x * x).sum::<f64>().sqrt();
    let turn: Matrix = match sine < 1e-12 {
        true if g[2] < 0.0 => UNIT,
        true => about(X, PI),
        false => about(times(axis, 1.0 / sine), sine.atan2(-g[2])),
    };
    for joint in chain.joints.iter_mut().filter(|j| j.parent.is_none()) {
        joint.rotation = product(&turn, &joint.rotation);
        joint.origin = turned(&turn, joint.origin);
    }
    chain.gravity = GRAVITY;
}

/// Converts XX XY XZ YY YZ ZZ MX MY MZ M about the origin to a body about its centre of mass.
fn body_of(x: [f64; 10]) -> Body {
    let mass = x[9];
    if mass <= 0.0 {
        return Body { mass: 0.0, centre: [0.0; 3], inertia: [[0.0; 3]; 3] };
    }
    let c = [x[6] / mass, x[7] / mass, x[8] / mass];
    let square = c.iter().map(|x| x * x).sum::<f64>();
    let about_origin = [[x[0], x[1], x[2]], [x[1], x[3], x[4]], [x[2], x[4], x[5]]];
    let mut inertia = about_origin;
    for (i, row) in inertia.iter_mut().enumerate() {
        for (j, entry) in row.iter_mut().enumerate() {
            *entry -= mass * (if i == j { square } else { 0.0 } - c[i] * c[j]);
        }
    }
    Body { mass, centre: c, inertia }
}
