//! Motions as functions of time: sums of sines, and moves from point to point.
//!
//! Logged motions may be poor (slow, small, short), like motions that users record. The chain is the tree of links with the
//! limits of its joints.

use std::f64::consts::TAU;

use super::chain::Chain;
use super::draw::Draw;
use crate::random::State;

pub enum Track {
    /// Sines about a middle position: (amplitude, angular frequency in rad/s, phase) of each sine.
    Sines(f64, Vec<(f64, f64, f64)>),
    /// Moves from point to point by a polynomial of fifth degree, each followed by a rest. Fields: the points; duration of a
    /// move, s; duration of a move and its rest, s.
    Points(Vec<f64>, f64, f64),
}

pub struct Motion {
    pub tracks: Vec<Track>,
    /// Duration, s.
    pub duration: f64,
    pub said: String,
}

impl Motion {
    /// q, dq, ddq at time t, s.
    pub fn at(&self, t: f64) -> State {
        let of: Vec<[f64; 3]> = self.tracks.iter().map(|track| track.at(t)).collect();
        let pick = |i: usize| of.iter().map(|x| x[i]).collect();
        State { q: pick(0), dq: pick(1), ddq: pick(2) }
    }

    /// A motion as a user may record it. It may be slow and small, or reach the limits, and it may have few or many periods.
    pub fn recorded(chain: &Chain, draw: &mut Draw) -> Motion {
        // Some motions are poor: 20 % are small, and 20 % are slow.
        let (small, slow) = (draw.chance(0.2), draw.chance(0.2));
        let reach = if small { draw.log(0.1, 0.4) } else { draw.uniform(0.4, 0.95) };
        let speed = if slow { draw.log(0.08, 0.3) } else { draw.uniform(0.3, 1.0) };
        let still = if draw.chance(0.1) { draw.below(chain.len()) } else { usize::MAX };
        match draw.chance(0.65) {
            true => Motion::fourier(chain, reach, speed, |k| k == still, draw),
            false => Motion::points(chain, reach, speed, still, draw),
        }
    }

    /// A motion of a single joint. All other joints are at rest somewhere in their ranges.
    pub fn of_one_joint(chain: &Chain, draw: &mut Draw) -> Motion {
        let alone = draw.below(chain.len());
        let mut motion = Motion::fourier(chain, 0.7, 0.6, |k| k != alone, draw);
        motion.said += &format!(", joint_{} alone", alone + 1);
        motion
    }

    /// A motion for the evaluation of an estimate: 70 % of the position range, with up to 60 % of the speed limit.
    pub fn of_use(chain: &Chain, draw: &mut Draw) -> Motion {
        Motion::fourier(chain, 0.7, 0.6, |_| false, draw)
    }

    fn fourier(chain: &Chain, reach: f64, speed: f64, is_still: impl Fn(usize) -> bool, draw: &mut Draw) -> Motion {
        const GRID: usize = 200;
        let (period, periods) = (draw.log(3.0, 12.0), 1 + draw.below(6));
        let harmonics = 2 + draw.below(5);
        let duration = (period * periods as f64).clamp(6.0, 30.0);
        let tracks = chain.joints.iter().enumerate().map(|(k, joint)| {
            let mut sines: Vec<(f64, f64, f64)> = (1..=harmonics)
                .map(|h| (draw.uniform(0.2, 1.0) / h as f64, TAU * h as f64 / period, draw.uniform(0.0, TAU)))
                .collect();
            let raw = Track::Sines(0.0, sines.clone());
            let peak = |i: usize| {
                let at = |g: usize| raw.at(period * g as f64 / GRID as f64)[i].abs();
                (0..GRID).map(at).fold(0.0, f64::max)
            };
            let scale = (reach * joint.range / peak(0)).min(speed * joint.speed / peak(1));
            let scale = if is_still(k) { 0.0 } else { scale };
            let middle = draw.uniform(-1.0, 1.0) * (joint.range - scale * peak(0)).max(0.0) * 0.9;
            sines.iter_mut().for_each(|s| s.0 *= scale);
            Track::Sines(middle, sines)
        });
        let tracks = tracks.collect();
        let said = format!(
            "{harmonics} harmonics of {period:.1} s for {duration:.0} s, reach {reach:.2}, speed {speed:.2} of the limits"
        );
        Motion { tracks, duration, said }
    }

    fn points(chain: &Chain, reach: f64, speed: f64, still: usize, draw: &mut Draw) -> Motion {
        let count = 5 + draw.below(12);
        // The largest speed of a polynomial of fifth degree is 1.875 times its mean speed.
        let needed = |j: &super::chain::Joint| 1.875 * 1.3 * reach * j.range / (speed * j.speed);
        let travel = chain.joints.iter().map(needed).fold(0.3, f64::max).min(4.0);
        let rest = draw.uniform(0.05, 0.5);
        let tracks = chain.joints.iter().enumerate().map(|(k, joint)| {
            let scale = reach * joint.range.min(speed * joint.speed * travel / 2.5 / reach);
            let points = (0..count).map(|_| draw.uniform(-1.0, 1.0) * if k == still { 0.0 } else { scale });
            Track::Points(points.collect(), travel, travel + rest)
        });
        let tracks = tracks.collect();
        let duration = ((count - 1) as f64 * (travel + rest)).clamp(5.0, 30.0);
        let said = format!("{count} points, {travel:.2} s a move, reach {reach:.2}, speed {speed:.2} of the limits");
        Motion { tracks, duration, said }
    }
}

impl Track {
    pub fn at(&self, t: f64) -> [f64; 3] {
        match self {
            Track::Sines(middle, sines) => sines.iter().fold([*middle, 0.0, 0.0], |sum, &(a, w, phase)| {
                let (s, c) = (w * t + phase).sin_cos();
                [sum[0] + a * s, sum[1] + a * w * c, sum[2] - a * w * w * s]
            }),
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
