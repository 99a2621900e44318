//! A planar loop: a crank, a rod, and a rocker or slider. Its closure is solved independently of the program.
//!
//! The passive variables are the joint positions that the closure determines.

use nalgebra::{Matrix2, Vector2};

use crate::random::Random;

/// A closed loop of four bars, or of crank, rod and slider, in the complex plane. The closure equation is L1 exp(i
/// (q + crank)) + L2 exp(i (q + crank + p_1)) = third side. q: coordinate; L1, L2: `crank_length`, `rod`; p_1, p_2: passive
/// variables; the origin is the crank joint.
pub struct PlanarLoop {
    /// Index of the coordinate that moves the crank.
    pub coordinate: usize,
    /// Angle of the crank when the coordinate q is zero, rad.
    pub crank: f64,
    pub crank_length: f64,
    pub rod: f64,
    pub third: Third,
    /// The passive variables p_1 and p_2 when the coordinate q is zero.
    pub start: [f64; 2],
}

#[derive(Clone, Copy)]
pub enum Third {
    /// The third side is base + length exp(i p_2).
    Rocker { base: f64, length: f64 },
    /// The third side is p_2 along the real axis.
    Slider,
}

impl PlanarLoop {
    /// The gap e (left minus right side of the closure equation); its derivatives by q, p_1 and p_2; and its second derivative in
    /// time at the velocities dq, dp if the accelerations are zero.
    pub fn gap(&self, q: f64, p: [f64; 2], dq: f64, dp: [f64; 2]) -> ([f64; 2], [[f64; 2]; 3], [f64; 2]) {
        let at = |angle: f64, length: f64| [length * angle.cos(), length * angle.sin()];
        let across = |v: [f64; 2]| [-v[1], v[0]];
        let (phi, d_phi) = (q + self.crank, dq);
        let (crank, rod) = (at(phi, self.crank_length), at(phi + p[0], self.rod));
        let (third, by_third, third_bend) = match self.third {
            Third::Rocker { base, length } => {
                let side = at(p[1], length);
                ([base + side[0], side[1]], across(side), side.map(|x| -x * dp[1] * dp[1]))
            }
            Third::Slider => ([p[1], 0.0], [1.0, 0.0], [0.0, 0.0]),
        };
        let rate = d_phi + dp[0];
        let minus = |a: [f64; 2], b: [f64; 2]| [a[0] - b[0], a[1] - b[1]];
        let plus = |a: [f64; 2], b: [f64; 2]| [a[0] + b[0], a[1] + b[1]];
        let e = minus(plus(crank, rod), third);
        let by_rod = across(rod);
        let slopes = [plus(across(crank), by_rod), by_rod, by_third.map(|x| -x)];
        let bend = plus(crank.map(|x| -x * d_phi * d_phi), rod.map(|x| -x * rate * rate));
        (e, slopes, minus(bend, third_bend))
    }

    /// The passive variables p_1, p_2 for which the loop is closed at the coordinate q. They are followed continuously from their
    /// values at q = 0.
    pub fn closed(&self, q: f64) -> [f64; 2] {
        let mut p = self.start;
        let steps = (q.abs() / 0.02).ceil().max(1.0) as usize;
        for step in 0..=steps {
            let q = q * step as f64 / steps as f64;
            for _ in 0..20 {
                let (e, slopes, _) = self.gap(q, p, 0.0, [0.0; 2]);
                let j = Matrix2::from_columns(&[slopes[1].into(), slopes[2].into()]);
                let Some(x) = j.lu().solve(&Vector2::from(e)) else { break };
                p = [p[0] - x[0], p[1] - x[1]];
            }
        }
        p
    }
}

/// A loop of a random kind with random lengths, and the name of its kind. `coordinate`: index of the coordinate that moves it.
pub fn drawn_loop(random: &mut Random, coordinate: usize) -> (PlanarLoop, &'static str) {
    let crank = 0.7 + 0.2 * (100.0 * random.unit()).round() / 100.0;
    let two_digits = |low: f64, high: f64, random: &mut Random| {
        let x = low + (high - low) * (random.unit() + 1.0) / 2.0;
        (100.0 * x).round() / 100.0
    };
    let crank_length = two_digits(0.15, 0.2, random);
    let rod = two_digits(0.5, 0.55, random);
    let kind = ["four-bar", "parallelogram", "crossed", "slider"][random.below(4)];
    if kind == "slider" {
        let [x, y] = [crank_length * crank.cos(), crank_length * crank.sin()];
        // The angle at which the rod reaches from the end of the crank down to the rail of the slider.
        let fall = -(y / rod).asin();
        let start = [fall - crank, x + rod * fall.cos()];
        return (PlanarLoop { coordinate, crank, crank_length, rod, third: Third::Slider, start }, kind);
    }
    let (base, length) = match kind {
        "four-bar" => (two_digits(0.45, 0.5, random), two_digits(0.4, 0.45, random)),
        _ => (rod, crank_length),
    };
    // The vector from the rocker joint to the end of the crank. Rod, rocker and this vector form a triangle.
    let [x, y] = [crank_length * crank.cos() - base, crank_length * crank.sin()];
    let apart = x.hypot(y);
    let inner = ((apart * apart + length * length - rod * rod) / (2.0 * apart * length)).clamp(-1.0, 1.0).acos();
    let candidates = [1.0, -1.0].map(|side| {
        let p2 = y.atan2(x) + side * inner;
        let end = [base + length * p2.cos() - crank_length * crank.cos(), length * p2.sin() - y];
        [end[1].atan2(end[0]) - crank, p2]
    });
    // In a parallelogram, the rocker is parallel to the crank.
    let parallel = |p: &[f64; 2]| ((p[1] - crank).sin().abs() + (1.0 - (p[1] - crank).cos())).abs();
    let [near, far] = if parallel(&candidates[0]) < parallel(&candidates[1]) {
        [candidates[0], candidates[1]]
    } else {
        [candidates[1], candidates[0]]
    };
    let start = if kind == "crossed" { far } else { near };
    (PlanarLoop { coordinate, crank, crank_length, rod, third: Third::Rocker { base, length }, start }, kind)
}
