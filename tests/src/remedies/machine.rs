//! A machine (the true robot) whose parameters differ slightly from its description, and its sensors.
//!
//! A body is given by its ten inertial parameters. The size of a joint is its rms torque.

use robot::{Inertial, LinkId, Robot, StandardParameter};

use super::arms::Arm;
use crate::by_link;
use crate::joint_log::described;
use crate::random::State;
use crate::random_situations::draw::Draw;
use crate::random_situations::motion::Motion;
use crate::recursion;

/// Number of samples of a motion from which the rms torques and the mean inertias are computed.
const LOOKS: usize = 200;
/// Largest relative error of mass, first moments and inertia in the description. `CENTRES`: largest error of the centres of mass,
/// m.
const BODIES: f64 = 0.15;
const CENTRES: f64 = 0.01;

/// XX XY XZ YY YZ ZZ MX MY MZ M of a body, about the origin of its link frame.
type Body = [f64; 10];

pub struct Machine {
    /// Standard parameters of bodies and rotors, in the order of [`StandardParameter::all`].
    pub parameters: Vec<f64>,
    /// The standard parameters with a load on the last link.
    pub loaded: Vec<f64>,
    /// Mass of this load, kg.
    pub load: f64,
    /// Viscous friction of each joint, N m s/rad (N s/m). `coulomb`: Coulomb friction, N m (N).
    pub viscous: Vec<f64>,
    pub coulomb: Vec<f64>,
    /// Offset of each measured torque, N m (N).
    pub offset: Vec<f64>,
    /// Rms torque of bodies and rotors of each joint, N m (N).
    pub size: Vec<f64>,
    pub sensors: Sensors,
}

pub struct Sensors {
    /// Standard deviation of the torque noise, as a fraction of the rms torque.
    pub noise: f64,
    /// Encoder resolution, bits per turn (for a prismatic joint: per 0.1 m).
    pub bits: i32,
    pub speeds: bool,
}

impl Machine {
    /// A machine for this robot, with random errors and sensors. The rms torques of the machine are computed for this motion.
    pub fn of(arm: &Arm, motion: &Motion, draw: &mut Draw) -> Machine {
        let robot = &arm.robot;
        let n = robot.n_coordinates();
        let mut bodies: Vec<Body> = by_link(robot, &described(robot)).iter().map(|(body, _)| *body).collect();
        bodies.iter_mut().for_each(|body| *body = unlike(body, draw));
        let states: Vec<State> = (0..LOOKS).map(|i| motion.at(motion.duration * i as f64 / LOOKS as f64)).collect();
        let mut rotors = vec![0.0; robot.links.len()];
        let inertias = mean_inertias(robot, &parameters(robot, &bodies, &rotors), &states);
        for (link, rotor) in robot.links.iter().zip(&mut rotors) {
            if let Some((k, _)) = link.joint.variable.terms.first() {
                *rotor = 0.1 * draw.uniform(0.5, 3.0) * inertias[k.0];
            }
        }
        let x = parameters(robot, &bodies, &rotors);
        let (load, loaded) = loaded(robot, &mut bodies, &rotors, draw);
        let size = sizes(n, states.iter().map(|state| recursion::torque(robot, state, &x)));
        let speed = sizes(n, states.iter().map(|state| state.dq.clone()));
        let mut share = || draw.uniform(0.05, 0.2);
        let viscous = (0..n).map(|k| share() * size[k] / speed[k]).collect();
        let coulomb = (0..n).map(|k| share() * size[k]).collect();
        let offset = (0..n).map(|k| draw.uniform(-0.01, 0.01) * size[k]).collect();
        let (noise, bits, speeds) = (draw.uniform(0.002, 0.01), 16 + draw.below(5) as i32, draw.chance(0.6));
        let sensors = Sensors { noise, bits, speeds };
        Machine { parameters: x, loaded, load, viscous, coulomb, offset, size, sensors }
    }

    /// The motor torques at a state, N m (N), with friction. `x`: present parameters of bodies and rotors.
    pub fn torque(&self, robot: &Robot, state: &State, x: &[f64]) -> Vec<f64> {
        let mut tau = recursion::torque(robot, state, x);
        for (k, tau) in tau.iter_mut().enumerate() {
            let sign = if state.dq[k] == 0.0 { 0.0 } else { state.dq[k].signum() };
            *tau += self.viscous[k] * state.dq[k] + self.coulomb[k] * sign;
        }
        tau
    }
}

/// A body with random errors: mass, first moments and inertia get the same factor, then the centre of mass moves. If the body was
/// physically possible, it remains so.
fn unlike(body: &Body, draw: &mut Draw) -> Body {
    let factor = 1.0 + draw.uniform(-BODIES, BODIES);
    let shift = [0, 1, 2].map(|_: usize| draw.uniform(-CENTRES, CENTRES) / 3f64.sqrt());
    let m = factor * body[9];
    if m <= 0.0 {
        return *body;
    }
    let centre = [6, 7, 8].map(|i: usize| body[i] / body[9]);
    let moved = [0, 1, 2].map(|i: usize| centre[i] + shift[i]);
    let (before, behind) = (of_point(m, centre), of_point(m, moved));
    std::array::from_fn(|i| factor * body[i] - before[i] + behind[i])
}

/// The parameters XX XY XZ YY YZ ZZ MX MY MZ M of a point mass m at the given position.
fn of_point(m: f64, [x, y, z]: [f64; 3]) -> Body {
    [y * y + z * z, -x * y, -x * z, x * x + z * z, -y * z, x * x + y * y, x, y, z, 1.0].map(|a| m * a)
}

/// The mass of a random load on the last link, kg, and the standard parameters with this load. The mass is between half of the
/// link's mass and 2 kg, at 5 to 15 cm from the origin of the last frame.
fn loaded(robot: &Robot, bodies: &mut [Body], rotors: &[f64], draw: &mut Draw) -> (f64, Vec<f64>) {
    let last = bodies.iter().rposition(|body| body[9] > 0.0).unwrap_or(0);
    let least = (0.5 * bodies[last][9]).clamp(0.05, 1.9);
    let mass = draw.uniform(least, 2.0);
    let place = [0, 1, 2].map(|_: usize| draw.sign() * draw.uniform(0.03, 0.09));
    let load = of_point(mass, place);
    bodies[last].iter_mut().zip(load).for_each(|(x, more)| *x += more);
    (mass, parameters(robot, bodies, rotors))
}

/// The vector of standard parameters for these bodies and rotors.
fn parameters(robot: &Robot, bodies: &[Body], rotors: &[f64]) -> Vec<f64> {
    let value = |parameter: &StandardParameter| {
        let LinkId(j) = parameter.link;
        match parameter.inertial {
            Inertial::Ia => rotors[j],
            inertial => bodies[j][inertial as usize],
        }
    };
    StandardParameter::all(robot).iter().map(value).collect()
}

/// The mean of each diagonal entry of the inertia matrix over some states.
fn mean_inertias(robot: &Robot, x: &[f64], states: &[State]) -> Vec<f64> {
    let n = robot.n_coordinates();
    let few: Vec<&State> = states.iter().step_by(20).collect();
    let at = |state: &State, k: usize| {
        let still = |ddq: Vec<f64>| State { q: state.q.clone(), dq: vec![0.0; n], ddq };
        let unit = (0..n).map(|i| if i == k { 1.0 } else { 0.0 }).collect();
        recursion::torque(robot, &still(unit), x)[k] - recursion::torque(robot, &still(vec![0.0; n]), x)[k]
    };
    (0..n).map(|k| few.iter().map(|state| at(state, k)).sum::<f64>() / few.len() as f64).collect()
}

/// The rms of the torque of each joint, but at least 1/1000 of the largest rms.
fn sizes(n: usize, series: impl Iterator<Item = Vec<f64>>) -> Vec<f64> {
    let (mut sums, mut count) = (vec![0.0; n], 0);
    for values in series {
        sums.iter_mut().zip(values).for_each(|(sum, x)| *sum += x * x);
        count += 1;
    }
    let sizes: Vec<f64> = sums.iter().map(|sum| (sum / f64::from(count.max(1))).sqrt()).collect();
    let largest = sizes.iter().fold(f64::MIN_POSITIVE, |m, x| m.max(*x));
    sizes.into_iter().map(|x| x.max(1e-3 * largest)).collect()
}
