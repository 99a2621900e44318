//! The motions of the machines: sums of harmonics, and slow moves from point to point with rests.

use std::f64::consts::TAU;

use super::arms::Arm;
use crate::random::State;
use crate::random_situations::draw::Draw;

const HARMONICS: usize = 5;
/// Share of its range that a joint uses at most.
const REACH: f64 = 0.9;
/// The largest speed of the fifth-degree polynomial from 0 to 1 within 1 s.
const PEAK_OF_MOVE: f64 = 1.875;

enum Track {
    /// About a middle, of a first frequency, rad/s: sine and cosine amplitude of each harmonic.
    Harmonics(f64, f64, Vec<[f64; 2]>),
    /// From point to point within so many s, then a rest up to so many s.
    Points(Vec<f64>, f64, f64),
}

pub struct Motion {
    tracks: Vec<Track>,
    /// s.
    pub duration: f64,
    pub said: String,
}

impl Motion {
    /// A sum of five harmonics within the limits of the joints, up to a half of their speeds.
    pub fn harmonics(arm: &Arm, duration: f64, draw: &mut Draw) -> Motion {
        let (period, speed) = (draw.uniform(4.0, 10.0), draw.uniform(0.2, 0.5));
        let track = |k: usize| {
            let raw: Vec<[f64; 2]> =
                (1..=HARMONICS).map(|h| [0, 1].map(|_: usize| draw.uniform(-1.0, 1.0) / h as f64)).collect();
            let raw = Track::Harmonics(0.0, TAU / period, raw);
            let grid = || (0..400).map(|i| raw.at(period * f64::from(i) / 400.0));
            let reach = grid().map(|x| x[0].abs()).fold(0.0, f64::max);
            let rate = grid().map(|x| x[1].abs()).fold(0.0, f64::max);
            let (low, high) = arm.range(k);
            let half = 0.5 * (high - low);
            let scale = (REACH * half / reach).min(speed * arm.speed(k) / rate);
            let free = REACH * half - scale * reach;
            let middle = 0.5 * (low + high) + draw.uniform(-1.0, 1.0) * free.max(0.0);
            let Track::Harmonics(_, w, amplitudes) = raw else { unreachable!("made above") };
            Track::Harmonics(middle, w, amplitudes.into_iter().map(|a| a.map(|x| scale * x)).collect())
        };
        let tracks = (0..arm.n()).map(track).collect();
        let said =
            format!("{HARMONICS} harmonics of {period:.1} s for {duration:.0} s, speed {speed:.2} of the limits");
        Motion { tracks, duration, said }
    }

    /// Moves from point to point at a tenth to three tenths of the speeds, each with a rest behind it.
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

    /// q, dq, ddq at t, s.
    pub fn at(&self, t: f64) -> State {
        let of: Vec<[f64; 3]> = self.tracks.iter().map(|track| track.at(t)).collect();
        let pick = |i: usize| of.iter().map(|x| x[i]).collect();
        State { q: pick(0), dq: pick(1), ddq: pick(2) }
    }
}

impl Track {
    fn at(&self, t: f64) -> [f64; 3] {
        match self {
            Track::Harmonics(middle, base, amplitudes) => {
                let mut sum = [*middle, 0.0, 0.0];
                for (h, [a, b]) in amplitudes.iter().enumerate() {
                    let w = base * (h + 1) as f64;
                    let (s, c) = (w * t).sin_cos();
                    sum[0] += a * s + b * c;
                    sum[1] += w * (a * c - b * s);
                    sum[2] -= w * w * (a * s + b * c);
                }
                sum
            }
            Track::Points(points, travel, step) => {
                let i = ((t / step).floor().max(0.0) as usize).min(points.len() - 1);
                let Some(next) = points.get(i + 1) else { return [points[i], 0.0, 0.0] };
                let (a, way) = (points[i], next - points[i]);
                let x = ((t - i as f64 * step) / travel).clamp(0.0, 1.0);
                let q = x * x * x * (10.0 + x * (6.0 * x - 15.0));
                let dq = 30.0 * x * x * (1.0 - x) * (1.0 - x) / travel;
                let ddq = 60.0 * x * (1.0 - x) * (1.0 - 2.0 * x) / (travel * travel);
                [a + way * q, way * dq, way * ddq]
            }
        }
    }
}
