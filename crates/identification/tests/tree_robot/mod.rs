//! A plain f64 recursion for small trees of revolute joints, to test identification with, and the
//! arm of the benchmarks R3G (with gravity) and R3B (balanced).
//!
//! iTj = Rz(gamma) Tz(b) Rx(alpha) Tx(d) Rz(theta) Tz(r); joint variables are affine in q.

use identification::experiments::exciting_trajectory::{ExcitingTrajectory, MotionKind};
use identification::experiments::profile::Profile;
use identification::model::parameter::BaseParameter;
use identification::model::regressor::Regressor;
use identification::simulate::dynamics::Dynamics;

/// Of the arm: rad/s, rad/s^2, rad/s, and N m a sample.
pub const VELOCITY: [f64; 3] = [5.0, 5.0, 7.0];
pub const ACCELERATION: [f64; 3] = [30.0, 40.0, 60.0];
const SLOW: [f64; 3] = [0.5; 3];
pub const NOISE: [f64; 3] = [0.20, 0.15, 0.10];

type V = [f64; 3];

/// XX XY XZ YY YZ ZZ MX MY MZ M IA of a link, about the origin of its frame.
pub type Standard = [f64; 11];

pub const LETTERS: [&str; 11] = ["XX", "XY", "XZ", "YY", "YZ", "ZZ", "MX", "MY", "MZ", "M", "IA"];

#[derive(Clone)]
pub struct Link {
    pub antecedent: Option<usize>,
    /// gamma, b, alpha, d, constant part of theta, r.
    pub geometry: [f64; 6],
    /// theta = geometry theta + sum of coefficient times coordinate.
    pub variable: Vec<(usize, f64)>,
    pub standard: Standard,
    pub has_rotor: bool,
}

pub struct TreeRobot {
    pub links: Vec<Link>,
    pub gravity: V,
    coordinates: Vec<String>,
    names: Vec<BaseParameter>,
    /// Columns of Y kept, among 11 a link.
    kept: Vec<usize>,
    /// Values of the base parameters.
    pub truth: Vec<f64>,
}

#[derive(Clone, Copy, Default)]
struct Motion {
    r: [V; 3],
    p: V,
    w: V,
    dw: V,
    a: V,
    ddtheta: f64,
}

fn cross(a: V, b: V) -> V {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn add(a: V, b: V) -> V {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

fn turn(r: &[V; 3], v: V) -> V {
    [0, 1, 2].map(|i| r[i][0] * v[0] + r[i][1] * v[1] + r[i][2] * v[2])
}

fn turn_back(r: &[V; 3], v: V) -> V {
    [0, 1, 2].map(|i| r[0][i] * v[0] + r[1][i] * v[1] + r[2][i] * v[2])
}

/// Inertia about the centre of mass (xx xy xz yy yz zz) moved to the origin of the frame.
pub fn link_at(mass: f64, c: V, i: [f64; 6]) -> Standard {
    let cc = c[0] * c[0] + c[1] * c[1] + c[2] * c[2];
    let j = |k: usize, a: usize, b: usize| i[k] + mass * (if a == b { cc } else { 0.0 } - c[a] * c[b]);
    let (x, y, z) = (mass * c[0], mass * c[1], mass * c[2]);
    [j(0, 0, 0), j(1, 0, 1), j(2, 0, 2), j(3, 1, 1), j(4, 1, 2), j(5, 2, 2), x, y, z, mass, 0.0]
}

impl TreeRobot {
    /// `coordinates` names q; the base parameters are found by a left-to-right scan of a random
    /// observation matrix.
    pub fn new(links: Vec<Link>, gravity: V, coordinates: &[&str]) -> TreeRobot {
        let coordinates: Vec<String> = coordinates.iter().map(|s| s.to_string()).collect();
        let mut robot = TreeRobot { links, gravity, coordinates, names: vec![], kept: vec![], truth: vec![] };
        robot.reduce();
        robot
    }

    /// The three-axis benchmark arm; `gravity` false: balanced.
    pub fn r3(gravity: bool) -> TreeRobot {
        let half_pi = std::f64::consts::FRAC_PI_2;
        let link = |antecedent, geometry, k, standard| Link {
            antecedent,
            geometry,
            variable: vec![(k, 1.0)],
            standard,
            has_rotor: false,
        };
        let links = vec![
            link(None, [0.0; 6], 0, link_at(4.0, [0.0, 0.0, -0.1], [0.10, 0.0, 0.0, 0.10, 0.0, 0.134])),
            link(
                Some(0),
                [0.0, 0.0, half_pi, 0.0, 0.0, 0.0],
                1,
                link_at(1.0, [0.10, 0.012, 0.030], [0.0030, 0.0005, -0.0010, 0.0115, 0.0004, 0.0130]),
            ),
            link(
                Some(1),
                [0.0, 0.0, 0.0, 0.25, 0.0, 0.0],
                2,
                link_at(1.2, [0.20, -0.015, -0.020], [0.0040, -0.0010, 0.0015, 0.0130, 0.0012, 0.0145]),
            ),
        ];
        TreeRobot::new(links, [0.0, 0.0, if gravity { -9.81 } else { 0.0 }], &["q1", "q2", "q3"])
    }

    fn motion(&self, q: &[f64], dq: &[f64], ddq: &[f64], out: &mut [Motion]) {
        for (j, link) in self.links.iter().enumerate() {
            let [gamma, b, alpha, d, theta0, r] = link.geometry;
            let along = |x: &[f64]| link.variable.iter().map(|&(k, c)| c * x[k]).sum::<f64>();
            let (s, c) = (theta0 + along(q)).sin_cos();
            let (sa, ca) = alpha.sin_cos();
            let (sg, cg) = gamma.sin_cos();
            let inner = [[c, -s, 0.0], [ca * s, ca * c, -sa], [sa * s, sa * c, ca]];
            let rotation = [
                [0, 1, 2].map(|k| cg * inner[0][k] - sg * inner[1][k]),
                [0, 1, 2].map(|k| sg * inner[0][k] + cg * inner[1][k]),
                inner[2],
            ];
            let p = [cg * d + sg * sa * r, sg * d - cg * sa * r, b + ca * r];
            let (w, dw, a) = match link.antecedent {
                None => ([0.0; 3], [0.0; 3], self.gravity.map(|g| -g)),
                Some(i) => {
                    let m = &out[i];
                    (m.w, m.dw, add(m.a, add(cross(m.dw, p), cross(m.w, cross(m.w, p)))))
                }
            };
            let (dtheta, ddtheta) = (along(dq), along(ddq));
            let (mut w, mut dw, a) = (turn_back(&rotation, w), turn_back(&rotation, dw), turn_back(&rotation, a));
            dw = add(dw, [w[1] * dtheta, -w[0] * dtheta, ddtheta]);
            w[2] += dtheta;
            out[j] = Motion { r: rotation, p, w, dw, a, ddtheta };
        }
    }

    /// Wrench on link j per unit of its ten parameters: force and moment at its origin.
    fn unit_wrenches(m: &Motion) -> [(V, V); 10] {
        let ([w0, w1, w2], [d0, d1, d2], [a0, a1, a2]) = (m.w, m.dw, m.a);
        let z = [0.0; 3];
        [
            (z, [d0, w2 * w0, -w1 * w0]),
            (z, [d1 - w2 * w0, d0 + w2 * w1, w0 * w0 - w1 * w1]),
            (z, [d2 + w1 * w0, w2 * w2 - w0 * w0, d0 - w1 * w2]),
            (z, [-w2 * w1, d1, w0 * w1]),
            (z, [w1 * w1 - w2 * w2, d2 - w0 * w1, d1 + w0 * w2]),
            (z, [w1 * w2, -w0 * w2, d2]),
            ([-(w1 * w1 + w2 * w2), w0 * w1 + d2, w0 * w2 - d1], [0.0, -a2, a1]),
            ([w0 * w1 - d2, -(w0 * w0 + w2 * w2), w1 * w2 + d0], [a2, 0.0, -a0]),
            ([w0 * w2 + d1, w1 * w2 - d0, -(w0 * w0 + w1 * w1)], [-a1, a0, 0.0]),
            (m.a, z),
        ]
    }

    /// n x 11 links, row by row.
    fn standard_regressor(&self, q: &[f64], dq: &[f64], ddq: &[f64]) -> Vec<f64> {
        let (n, width) = (self.coordinates.len(), 11 * self.links.len());
        let mut motion = vec![Motion::default(); self.links.len()];
        self.motion(q, dq, ddq, &mut motion);
        let mut y = vec![0.0; n * width];
        for j in 0..self.links.len() {
            let mut wrenches = Self::unit_wrenches(&motion[j]);
            let mut i = j;
            loop {
                for &(k, coefficient) in &self.links[i].variable {
                    for c in 0..10 {
                        y[k * width + 11 * j + c] += coefficient * wrenches[c].1[2];
                    }
                }
                let Some(up) = self.links[i].antecedent else { break };
                let m = &motion[i];
                for (f, t) in &mut wrenches {
                    *f = turn(&m.r, *f);
                    *t = add(turn(&m.r, *t), cross(m.p, *f));
                }
                i = up;
            }
            if self.links[j].has_rotor {
                for &(k, coefficient) in &self.links[j].variable {
                    y[k * width + 11 * j + 10] += coefficient * motion[j].ddtheta;
                }
            }
        }
        y
    }

    /// Newton-Euler with the standard parameters.
    fn torque(&self, q: &[f64], dq: &[f64], ddq: &[f64], tau: &mut [f64]) {
        let count = self.links.len();
        let mut motion = [Motion::default(); 16];
        let mut wrench = [([0.0; 3], [0.0; 3]); 16];
        self.motion(q, dq, ddq, &mut motion);
        tau.fill(0.0);
        for j in (0..count).rev() {
            let (m, x) = (&motion[j], &self.links[j].standard);
            let inertia = |v: V| {
                [
                    x[0] * v[0] + x[1] * v[1] + x[2] * v[2],
                    x[1] * v[0] + x[3] * v[1] + x[4] * v[2],
                    x[2] * v[0] + x[4] * v[1] + x[5] * v[2],
                ]
            };
            let s = [x[6], x[7], x[8]];
            let force = add(m.a.map(|a| x[9] * a), add(cross(m.dw, s), cross(m.w, cross(m.w, s))));
            let moment = add(add(inertia(m.dw), cross(m.w, inertia(m.w))), cross(s, m.a));
            let (f, t) = (add(force, wrench[j].0), add(moment, wrench[j].1));
            let rotor = if self.links[j].has_rotor { x[10] * m.ddtheta } else { 0.0 };
            for &(k, coefficient) in &self.links[j].variable {
                tau[k] += coefficient * (t[2] + rotor);
            }
            if let Some(up) = self.links[j].antecedent {
                let f = turn(&m.r, f);
                let t = add(turn(&m.r, t), cross(m.p, f));
                wrench[up] = (add(wrench[up].0, f), add(wrench[up].1, t));
            }
        }
    }

    fn reduce(&mut self) {
        let (n, width) = (self.coordinates.len(), 11 * self.links.len());
        let mut random = identification::algebra::random::Random::new(1);
        let mut w = vec![Vec::new(); width];
        for _ in 0..60 {
            let mut draw = |scale: f64| (0..n).map(|_| scale * (2.0 * random.uniform() - 1.0)).collect::<Vec<_>>();
            let y = self.standard_regressor(&draw(3.1), &draw(2.0), &draw(5.0));
            for (c, column) in w.iter_mut().enumerate() {
                column.extend((0..n).map(|i| y[i * width + c]));
            }
        }
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
        // Gram-Schmidt, twice over: kept columns become basis; coefficients of the others follow
        // by back substitution through the triangle.
        let mut basis: Vec<Vec<f64>> = Vec::new();
        let mut triangle: Vec<Vec<f64>> = Vec::new();
        let mut grouping: Vec<Vec<f64>> = Vec::new();
        for c in 0..width {
            let norm = dot(&w[c], &w[c]).sqrt();
            let mut rest = w[c].clone();
            let mut on_basis = vec![0.0; basis.len()];
            for _ in 0..2 {
                for (k, b) in basis.iter().enumerate() {
                    let s = dot(b, &rest);
                    on_basis[k] += s;
                    rest.iter_mut().zip(b).for_each(|(r, b)| *r -= s * b);
                }
            }
            let left = dot(&rest, &rest).sqrt();
            if norm > 1e-9 && left > 1e-7 * norm {
                rest.iter_mut().for_each(|r| *r /= left);
                basis.push(rest);
                on_basis.push(left);
                triangle.push(on_basis);
                self.kept.push(c);
                let name = format!("{}{}", LETTERS[c % 11], c / 11 + 1);
                self.names.push(BaseParameter::turning(&name, c / 11).unwrap());
                let mut row = vec![0.0; width];
                row[c] = 1.0;
                grouping.push(row);
            } else {
                for k in (0..basis.len()).rev() {
                    let s = on_basis[k] / triangle[k][k];
                    for i in 0..k {
                        on_basis[i] -= s * triangle[k][i];
                    }
                    grouping[k][c] = if s.abs() > 1e-9 { s } else { 0.0 };
                }
            }
        }
        let standard: Vec<f64> = self.links.iter().flat_map(|l| l.standard).collect();
        self.truth = grouping.iter().map(|row| dot(row, &standard)).collect();
    }
}

impl Regressor for TreeRobot {
    fn coordinates(&self) -> &[String] {
        &self.coordinates
    }

    fn parameters(&self) -> &[BaseParameter] {
        &self.names
    }

    fn fill(&self, q: &[f64], dq: &[f64], ddq: &[f64], y: &mut [f64]) {
        let (width, p) = (11 * self.links.len(), self.kept.len());
        let full = self.standard_regressor(q, dq, ddq);
        for i in 0..self.coordinates.len() {
            for (c, &k) in self.kept.iter().enumerate() {
                y[i * p + c] = full[i * width + k];
            }
        }
    }
}

impl Dynamics for TreeRobot {
    fn n_coordinates(&self) -> usize {
        self.coordinates.len()
    }

    fn fill(&self, q: &[f64], dq: &[f64], inertia: &mut [f64], bias: &mut [f64]) {
        let n = self.coordinates.len();
        let (mut unit, mut tau) = ([0.0; 16], [0.0; 16]);
        self.torque(q, dq, &unit[..n], bias);
        for k in 0..n {
            unit[k] = 1.0;
            self.torque(q, dq, &unit[..n], &mut tau[..n]);
            unit[k] = 0.0;
            for i in 0..n {
                inertia[i * n + k] = tau[i] - bias[i];
            }
        }
    }
}

/// Four seconds of a bang-bang swing at the greatest acceleration that respects the velocity.
pub fn bang_bang(kind: MotionKind, fast: usize, slow: &[usize], centre: [f64; 3], period: usize) -> ExcitingTrajectory {
    let acceleration = ACCELERATION[fast].min(4.0 * VELOCITY[fast] / (period as f64 * 1e-3));
    ExcitingTrajectory::swing(kind, fast, slow, &centre, Profile::BangBang, period, acceleration, &SLOW, 4.0, 1e-3)
}
