//! Motions for the logs: sums of harmonics, and slow moves from point to point with rests.
//!
//! The motions stay within the limits of the arm.

use std::f64::consts::TAU;

use super::arms::Arm;
use crate::random_situations::draw::Draw;
use crate::random_situations::motion::{Motion, Track};

const HARMONICS: usize = 5;
/// Largest fraction of its range that a joint uses.
const REACH: f64 = 0.9;
/// The largest speed of the polynomial of fifth degree that moves from 0 to 1 in 1 s.
const PEAK_OF_MOVE: f64 = 1.875;

/// A sum of five harmonics within the position limits, with up to half of the speed limits.
pub fn harmonics(arm: &Arm, duration: f64, draw: &mut Draw) -> Motion {
    let (period, speed) = (draw.uniform(4.0, 10.0), draw.uniform(0.2, 0.5));
    let track = |k: usize| {
        // a sin + b cos of each harmonic, as amplitude, angular frequency and phase.
        let sine = |h: usize| {
            let [a, b] = [0, 1].map(|_: usize| draw.uniform(-1.0, 1.0) / h as f64);
            (a.hypot(b), TAU * h as f64 / period, b.atan2(a))
        };
        let mut sines: Vec<(f64, f64, f64)> = (1..=HARMONICS).map(sine).collect();
        let raw = Track::Sines(0.0, sines.clone());
        let grid = || (0..400).map(|i| raw.at(period * f64::from(i) / 400.0));
        let reach = grid().map(|x| x[0].abs()).fold(0.0, f64::max);
        let rate = grid().map(|x| x[1].abs()).fold(0.0, f64::max);
        let (low, high) = arm.range(k);
        let half = 0.5 * (high - low);
        let scale = (REACH * half / reach).min(speed * arm.speed(k) / rate);
        let free = REACH * half - scale * reach;
        let middle = 0.5 * (low + high) + draw.uniform(-1.0, 1.0) * free.max(0.0);
        sines.iter_mut().for_each(|sine| sine.0 *= scale);
        Track::Sines(middle, sines)
    };
    let tracks = (0..arm.n()).map(track).collect();
    let said = format!("{HARMONICS} harmonics of {period:.1} s for {duration:.0} s, speed {speed:.2} of the limits");
    Motion { tracks, duration, said }
}

/// Moves from point to point at 10 to 30 % of the speed limits. A rest follows each move.
pub fn points(arm: &Arm, duration: f64, draw: &mut Draw) -> Motion {
    let (speed, travel, rest) = (draw.uniform(0.1, 0.3), draw.uniform(0.8, 2.5), draw.uniform(0.3, 1.5));
    let count = 2 + (duration / (travel + rest)).ceil() as usize;
    let track = |k: usize| {
        let (low, high) = arm.range(k);
        let middle = 0.5 * (low + high);
        let reach = (0.5 * REACH * (high - low)).min(0.5 * speed * arm.speed(k) * travel / PEAK_OF_MOVE);
        let points = (0..count).map(|_| middle + reach * draw.uniform(-1.0, 1.0)).collect();
        Track::Points(points, travel, travel + rest)
    };
    let tracks = (0..arm.n()).map(track).collect();
    let said = format!("point to point for {duration:.0} s, {travel:.1} s a move, {rest:.1} s a rest");
    Motion { tracks, duration, said }
}
