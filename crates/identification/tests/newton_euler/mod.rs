#![allow(dead_code, reason = "each test binary uses its part")]
//! A regressor by an f64 Newton-Euler recursion, for serial arms in modified DH: the tests' own.
//!
//! The torque is linear in the standard parameters; column c is the torque of a unit parameter c.
//! Base columns are chosen left to right among random states by Gram-Schmidt.

use identification::algebra::random::Random;
use identification::model::parameter::BaseParameter;
use identification::model::regressor::Regressor;
use identification::model::standard_map::StandardMap;
use nalgebra::DMatrix;

type V = [f64; 3];

/// alpha, d, theta offset, r.
#[derive(Clone, Copy)]
pub struct Row(pub f64, pub f64, pub f64, pub f64);

pub struct Arm {
    rows: Vec<Row>,
    gravity: V,
    /// Joints with a rotor inertia of their own.
    rotor: bool,
    coordinates: Vec<String>,
    names: Vec<BaseParameter>,
    kept: Vec<usize>,
    /// Base values per standard parameter: X = B phi, kept x standard.
    pub grouping: Vec<Vec<f64>>,
    pub standard: Vec<String>,
}

const LETTERS: [&str; 11] = ["XX", "XY", "XZ", "YY", "YZ", "ZZ", "MX", "MY", "MZ", "M", "IA"];

impl Arm {
    pub fn new(rows: &[Row], gravity: V, rotor: bool) -> Arm {
        let n = rows.len();
        let per = if rotor { 11 } else { 10 };
        let standard: Vec<String> = (0..n * per).map(|c| format!("{}{}", LETTERS[c % per], c / per + 1)).collect();
        let coordinates = (1..=n).map(|i| format!("q{i}")).collect();
        let mut arm = Arm {
            rows: rows.to_vec(),
            gravity,
            rotor,
            coordinates,
            names: Vec::new(),
            kept: Vec::new(),
            grouping: Vec::new(),
            standard,
        };
        arm.choose();
        arm
    }

    pub fn panda() -> Arm {
        let h = std::f64::consts::FRAC_PI_2;
        let rows = [
            Row(0.0, 0.0, 0.0, 0.333),
            Row(-h, 0.0, 0.0, 0.0),
            Row(h, 0.0, 0.0, 0.316),
            Row(h, 0.0825, 0.0, 0.0),
            Row(-h, -0.0825, 0.0, 0.384),
            Row(h, 0.0, 0.0, 0.0),
            Row(h, 0.088, 0.0, 0.0),
        ];
        Arm::new(&rows, [0.0, 0.0, -9.81], false)
    }

    /// The arms of the measured sets, by the tables of their facts.md.
    pub fn tx40() -> Arm {
        let h = std::f64::consts::FRAC_PI_2;
        let rows = [
            Row(0.0, 0.0, 0.0, 0.0),
            Row(-h, 0.0, -h, 0.0),
            Row(0.0, 0.225, h, 0.035),
            Row(h, 0.0, 0.0, 0.225),
            Row(-h, 0.0, 0.0, 0.0),
            Row(h, 0.0, 2.0 * h, 0.0),
        ];
        Arm::new(&rows, [0.0, 0.0, -9.81], true)
    }

    pub fn ur10e() -> Arm {
        let h = std::f64::consts::FRAC_PI_2;
        let rows = [
            Row(0.0, 0.0, 0.0, 0.181),
            Row(h, 0.0, 0.0, 0.0),
            Row(0.0, -0.613, 0.0, 0.0),
            Row(0.0, -0.571, 0.0, 0.174),
            Row(h, 0.0, 0.0, 0.12),
            Row(-h, 0.0, 0.0, 0.117),
        ];
        Arm::new(&rows, [0.0, 0.0, -9.81], true)
    }

    pub fn cobot6() -> Arm {
        let h = std::f64::consts::FRAC_PI_2;
        let rows = [
            Row(0.0, 0.0, 0.0, 0.1181),
            Row(h, 0.0, 0.0, 0.0),
            Row(0.0, -0.416, 0.0, 0.0),
            Row(0.0, -0.4208, 0.0, 0.1301),
            Row(h, 0.0, 0.0, 0.1021),
            Row(-h, 0.0, 0.0, 0.0568),
        ];
        Arm::new(&rows, [0.0, 0.0, -9.80665], false)
    }

    pub fn kr300() -> Arm {
        let h = std::f64::consts::FRAC_PI_2;
        let rows = [
            Row(0.0, 0.0, 0.0, -0.675),
            Row(h, 0.35, 0.0, -0.189),
            Row(0.0, 1.15, h, 0.189),
            Row(-h, 0.041, 0.0, -1.0),
            Row(h, 0.0, 0.0, 0.0),
            Row(-h, 0.0, 0.0, -0.24),
        ];
        Arm::new(&rows, [0.0, 0.0, 9.81], false)
    }

    /// How the base parameters follow from the standard ones.
    pub fn map(&self) -> StandardMap {
        let (b, p, per) = (self.grouping.len(), self.standard.len(), self.per());
        let rotors = if self.rotor { (0..self.rows.len()).map(|j| j * per + 10).collect() } else { Vec::new() };
        StandardMap {
            standard: self.standard.clone(),
            matrix: DMatrix::from_fn(b, p, |i, j| self.grouping[i][j]),
            bodies: (0..self.rows.len()).map(|j| (format!("link{}", j + 1), j * per)).collect(),
            rotors,
        }
    }

    fn per(&self) -> usize {
        if self.rotor { 11 } else { 10 }
    }

    /// The n x (per n) regressor of the standard parameters, row by row.
    pub fn standard_rows(&self, q: &[f64], dq: &[f64], ddq: &[f64]) -> Vec<f64> {
        let (n, per) = (self.rows.len(), self.per());
        let mut y = vec![0.0; n * n * per];
        // Motion of each link frame, in the link: w, dw, acceleration of the origin minus gravity.
        let (mut w, mut dw, mut a) = ([0.0; 3], [0.0; 3], self.gravity.map(|g| -g));
        let mut rotations: Vec<[V; 3]> = Vec::new();
        let mut positions: Vec<V> = Vec::new();
        for j in 0..n {
            let Row(alpha, d, offset, r) = self.rows[j];
            let (st, ct) = (q[j] + offset).sin_cos();
            let (sa, ca) = alpha.sin_cos();
            // Orientation of frame j in frame j - 1, and its origin there.
            let rot = [[ct, -st, 0.0], [ca * st, ca * ct, -sa], [sa * st, sa * ct, ca]];
            let p = [d, -r * sa, r * ca];
            let lever = add(cross(dw, p), cross(w, cross(w, p)));
            a = back(&rot, add(a, lever));
            let carried = back(&rot, w);
            let turn = [0.0, 0.0, dq[j]];
            dw = add(back(&rot, dw), add(cross(carried, turn), [0.0, 0.0, ddq[j]]));
            w = add(carried, turn);
            rotations.push(rot);
            positions.push(p);
            for c in 0..10 {
                let (mut f, mut m) = wrench(c, w, dw, a);
                for i in (0..=j).rev() {
                    y[i * n * per + j * per + c] = m[2];
                    let force = forth(&rotations[i], f);
                    m = add(forth(&rotations[i], m), cross(positions[i], force));
                    f = force;
                }
            }
            if self.rotor {
                y[j * n * per + j * per + 10] = ddq[j];
            }
        }
        y
    }

    /// Left to right: a column is kept when the kept ones before it do not span it.
    fn choose(&mut self) {
        let (n, p) = (self.rows.len(), self.rows.len() * self.per());
        let mut random = Random::new(1);
        let mut columns: Vec<Vec<f64>> = vec![Vec::new(); p];
        for _ in 0..60 {
            let mut draw = || (0..n).map(|_| random.between(-3.0, 3.0)).collect::<Vec<f64>>();
            let y = self.standard_rows(&draw(), &draw(), &draw());
            for (c, column) in columns.iter_mut().enumerate() {
                column.extend((0..n).map(|i| y[i * p + c]));
            }
        }
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let mut basis: Vec<Vec<f64>> = Vec::new();
        let mut upper: Vec<Vec<f64>> = Vec::new(); // coefficients of each kept column in the basis
        let mut coefficients: Vec<(Vec<f64>, bool)> = Vec::new();
        for column in &columns {
            let mut rest = column.clone();
            let mut along = vec![0.0; basis.len()];
            for _ in 0..2 {
                for (k, b) in basis.iter().enumerate() {
                    let s = dot(b, &rest);
                    along[k] += s;
                    rest.iter_mut().zip(b).for_each(|(r, b)| *r -= s * b);
                }
            }
            let left = dot(&rest, &rest).sqrt();
            // Absolute: a cosine of pi/2 leaves columns of 1e-16 that must not be scaled up.
            let kept = left > 1e-8;
            if kept {
                rest.iter_mut().for_each(|r| *r /= left);
                basis.push(rest);
                along.push(left);
                upper.push(along.clone());
            }
            coefficients.push((along, kept));
        }
        let b = upper.len();
        self.grouping = vec![vec![0.0; p]; b];
        let mut k = 0;
        for (c, (along, kept)) in coefficients.into_iter().enumerate() {
            if kept {
                self.grouping[k][c] = 1.0;
                self.kept.push(c);
                let name = &self.standard[c];
                let number: usize = name.trim_start_matches(char::is_alphabetic).parse().unwrap();
                self.names.push(BaseParameter::turning(name, number - 1).unwrap());
                k += 1;
                continue;
            }
            let mut rest = along;
            for i in (0..rest.len()).rev() {
                let x = rest[i] / upper[i][i];
                self.grouping[i][c] = x;
                for l in 0..i {
                    rest[l] -= x * upper[i][l];
                }
            }
        }
    }
}

impl Regressor for Arm {
    fn coordinates(&self) -> &[String] {
        &self.coordinates
    }

    fn parameters(&self) -> &[BaseParameter] {
        &self.names
    }

    fn fill(&self, q: &[f64], dq: &[f64], ddq: &[f64], y: &mut [f64]) {
        let all = self.standard_rows(q, dq, ddq);
        let (p, b) = (self.standard.len(), self.kept.len());
        for i in 0..self.rows.len() {
            for (k, &c) in self.kept.iter().enumerate() {
                y[i * b + k] = all[i * p + c];
            }
        }
    }
}

/// A file of the reference data, where they stand beside the project or above it.
pub fn shared(path: &str) -> Option<std::path::PathBuf> {
    let start = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    let found = start.ancestors().map(|a| a.join("shared").join(path)).find(|p| p.exists());
    if found.is_none() {
        println!("skipped: ../shared absent");
    }
    found
}

/// Force and moment about the link's origin of one unit parameter.
fn wrench(c: usize, w: V, dw: V, a: V) -> (V, V) {
    let mut j = [[0.0; 3]; 3];
    let mut h = [0.0; 3];
    let mut m = 0.0;
    match c {
        0 => j[0][0] = 1.0,
        1 => (j[0][1], j[1][0]) = (1.0, 1.0),
        2 => (j[0][2], j[2][0]) = (1.0, 1.0),
        3 => j[1][1] = 1.0,
        4 => (j[1][2], j[2][1]) = (1.0, 1.0),
        5 => j[2][2] = 1.0,
        6..=8 => h[c - 6] = 1.0,
        _ => m = 1.0,
    }
    let f = add(a.map(|x| m * x), add(cross(dw, h), cross(w, cross(w, h))));
    let moment = add(add(forth(&j, dw), cross(w, forth(&j, w))), cross(h, a));
    (f, moment)
}

fn add(a: V, b: V) -> V {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

fn cross(a: V, b: V) -> V {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn forth(r: &[V; 3], v: V) -> V {
    [0, 1, 2].map(|i| r[i][0] * v[0] + r[i][1] * v[1] + r[i][2] * v[2])
}

fn back(r: &[V; 3], v: V) -> V {
    [0, 1, 2].map(|i| r[0][i] * v[0] + r[1][i] * v[1] + r[2][i] * v[2])
}
