//! Converts the signals of a machine to a log, with sensor errors and defects.
//!
//! The machine is the true robot, simulated on a fine time grid; the log has a lower sampling rate.

use std::f64::consts::{PI, TAU};

use logs::Table;

use super::defects::{Defect, Kind};
use super::draw::Draw;
use super::robots::Machine;
use super::torque::{FINE, Series};

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Noise {
    None,
    White,
    /// Noise that is correlated in time, with this correlation time, s.
    Slow(f64),
    /// White noise; in addition, one row in a hundred has an error of twenty standard deviations.
    Spikes,
}

#[derive(Clone, Debug)]
pub struct Sensors {
    /// Sampling rate of the log, Hz. The rate of the fine time grid of the simulation is a multiple of it.
    pub rate: f64,
    pub noise: Noise,
    /// Standard deviation of a joint's torque noise, as a fraction of its rms torque.
    pub level: f64,
    /// Resolution of the encoders, bits per turn (for a prismatic joint: per 0.1 m). `None`: exact positions.
    pub bits: Option<u32>,
    /// Standard deviation of the logged velocities, as a fraction of the speed limit. `None`: velocities are not logged.
    pub speed: Option<f64>,
}

impl Sensors {
    pub fn some(draw: &mut Draw) -> Sensors {
        let noise = match draw.below(10) {
            0..=4 => Noise::White,
            5..=7 => Noise::Slow(draw.log(0.01, 1.0)),
            _ => Noise::Spikes,
        };
        Sensors {
            rate: [100.0, 200.0, 250.0, 500.0][draw.below(4)],
            noise,
            level: draw.log(0.0005, 0.02),
            bits: Some(13 + draw.below(8) as u32),
            speed: draw.chance(0.6).then(|| draw.log(1e-4, 5e-3)),
        }
    }

    pub fn log(&self, machine: &Machine, series: &Series, defects: &[Defect], draw: &mut Draw) -> Table {
        let of = |kind: Kind| defects.iter().find(|d| d.kind == kind);
        let step = (FINE / self.rate).round() as usize;
        let rows = (series.steps() - 1) / step + 1;
        let h = 1.0 / FINE;
        let jitter = of(Kind::ClockJitter).map_or(0.0, |d| d.size);
        let times: Vec<f64> = (0..rows)
            .map(|r| (r * step) as f64 * h + if jitter > 0.0 { jitter * draw.normal() } else { 0.0 })
            .collect();
        let mut columns = vec![(0..rows).map(|r| (r * step) as f64 * h).collect::<Vec<f64>>()];
        let mut header = vec!["t".to_string()];
        let names: Vec<String> = (1..=machine.chain.len()).map(|k| format!("joint_{k}")).collect();
        for k in 0..names.len() {
            columns.push(self.positions(machine, series, defects, k, &times));
            header.push(format!("q_{}", names[k]));
        }
        if let Some(level) = self.speed {
            for k in 0..names.len() {
                columns.push(self.speeds(machine, series, defects, k, &times, level, draw));
                header.push(format!("dq_{}", names[k]));
            }
        }
        let tau = self.torques(machine, series, defects, &times, draw);
        header.extend(names.iter().map(|name| format!("tau_{name}")));
        columns.extend(tau);
        if of(Kind::Sides).is_some() {
            let n = names.len();
            for signal in columns[1..].chunks_exact_mut(n) {
                let (left, right) = signal.split_at_mut(n / 2);
                left.swap_with_slice(right);
            }
        }
        lose_rows(&mut columns, defects, draw);
        let texts = vec![None; header.len()];
        Table { file: "situation.csv".into(), header, columns, texts, ..Table::default() }
    }

    fn positions(&self, machine: &Machine, series: &Series, defects: &[Defect], k: usize, times: &[f64]) -> Vec<f64> {
        let of = |kind: Kind| defects.iter().find(|d| d.kind == kind && d.joint == k);
        let slides = machine.chain.joints[k].slides;
        let turn = if slides { 0.1 } else { TAU };
        let wave = |theta: f64| {
            of(Kind::EncoderRipple).map_or(0.0, |d| d.size * turn / TAU * (TAU * theta / turn + 6.0 * d.more).sin())
        };
        let zero = zero(machine, defects, k);
        let degrees = if !slides && of(Kind::Degrees).is_some() { 180.0 / PI } else { 1.0 };
        let one = |&t: &f64| {
            let exact = at(&series.theta[k], t);
            let read = exact + wave(exact) - zero;
            let read = match self.bits {
                Some(bits) => {
                    let count = turn / f64::from(2u32.pow(bits));
                    (read / count).round() * count
                }
                None => read,
            };
            read * degrees
        };
        times.iter().map(one).collect()
    }

    fn speeds(
        &self,
        machine: &Machine,
        series: &Series,
        defects: &[Defect],
        k: usize,
        times: &[f64],
        level: f64,
        draw: &mut Draw,
    ) -> Vec<f64> {
        let joint = &machine.chain.joints[k];
        let filtered = defects
            .iter()
            .find(|d| d.kind == Kind::VelocityFiltered)
            .map(|d| low_pass(&series.dtheta[k], d.size, FINE));
        let speed = filtered.as_ref().unwrap_or(&series.dtheta[k]);
        let is_degrees = defects.iter().any(|d| d.kind == Kind::Degrees && d.joint == k) && !joint.slides;
        let unit = if is_degrees { 180.0 / PI } else { 1.0 };
        let noise = level * joint.speed;
        times.iter().map(|&t| unit * (at(speed, t) + if noise > 0.0 { noise * draw.normal() } else { 0.0 })).collect()
    }

    fn torques(
        &self,
        machine: &Machine,
        series: &Series,
        defects: &[Defect],
        times: &[f64],
        draw: &mut Draw,
    ) -> Vec<Vec<f64>> {
        let n = machine.chain.len();
        let of = |kind: Kind| defects.iter().find(|d| d.kind == kind);
        let late = of(Kind::Late).map_or(0.0, |d| d.size);
        let mut tau: Vec<Vec<f64>> = (0..n)
            .map(|k| {
                let lagged = of(Kind::TorqueLag).map(|d| low_pass(&series.tau[k], d.size, FINE));
                let exact = lagged.as_ref().unwrap_or(&series.tau[k]);
                times.iter().map(|&t| at(exact, t - late)).collect()
            })
            .collect();
        if let Some(mixed) = of(Kind::CrossTalk) {
            let from = tau[mixed.other].clone();
            tau[mixed.joint].iter_mut().zip(from).for_each(|(tau, other)| *tau += mixed.size * other);
        }
        for (k, tau) in tau.iter_mut().enumerate() {
            let largest = tau.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
            let mut noise = Noisy::new(self.noise, self.rate);
            for (r, tau) in tau.iter_mut().enumerate() {
                let mut x = *tau;
                for defect in defects.iter().filter(|d| d.joint == k || d.kind == Kind::ScaleOfAll) {
                    match defect.kind {
                        // The drive gain changes while the drive warms up, with a time constant of 15 to 60 s.
                        Kind::GainDrift => {
                            x *= 1.0 + defect.size * (1.0 - (-times[r] / (15.0 + 45.0 * defect.more)).exp())
                        }
                        Kind::ScaleOfJoint | Kind::ScaleOfAll => x *= defect.factor(),
                        Kind::Negated => x = -x,
                        Kind::Saturation => x = x.clamp(-defect.size * largest, defect.size * largest),
                        _ => {}
                    }
                }
                x += self.level * machine.size[k] * noise.next(draw);
                if let Some(step) = of(Kind::QuantisedTorque).map(|d| d.size * machine.size[k]) {
                    x = (x / step).round() * step;
                }
                *tau = x;
            }
        }
        if let Some(swapped) = of(Kind::Swapped) {
            tau.swap(swapped.joint, swapped.other);
        }
        tau
    }
}

/// Zero error of joint k: true position minus logged position, rad (m).
pub fn zero(machine: &Machine, defects: &[Defect], k: usize) -> f64 {
    let of_joint = defects.iter().find(|d| d.kind == Kind::Zero && d.joint == k);
    let unit = if machine.chain.joints[k].slides { 0.1 } else { 1.0 };
    of_joint.map_or(0.0, |d| unit * d.size * if d.more < 0.5 { 1.0 } else { -1.0 })
}

/// A generator of noise with standard deviation 1 (spikes excepted).
struct Noisy {
    noise: Noise,
    rate: f64,
    before: f64,
}

impl Noisy {
    fn new(noise: Noise, rate: f64) -> Noisy {
        Noisy { noise, rate, before: 0.0 }
    }

    fn next(&mut self, draw: &mut Draw) -> f64 {
        match self.noise {
            Noise::None => 0.0,
            Noise::White => draw.normal(),
            Noise::Slow(time) => {
                let keep = (-1.0 / (self.rate * time)).exp();
                self.before = keep * self.before + (1.0 - keep * keep).sqrt() * draw.normal();
                self.before
            }
            Noise::Spikes if draw.chance(0.01) => 20.0 * draw.sign(),
            Noise::Spikes => draw.normal(),
        }
    }
}

/// Removes some rows of the log
/// (`DroppedRows`), and replaces the values of other rows, except their time, by the values of the previous row (`RepeatedRows`).
fn lose_rows(columns: &mut [Vec<f64>], defects: &[Defect], draw: &mut Draw) {
    let share = |kind: Kind| defects.iter().find(|d| d.kind == kind).map_or(0.0, |d| d.size);
    let (dropped, repeated) = (share(Kind::DroppedRows), share(Kind::RepeatedRows));
    if dropped == 0.0 && repeated == 0.0 {
        return;
    }
    let rows = columns[0].len();
    let repeats: Vec<bool> = (0..rows).map(|r| r > 0 && draw.chance(repeated)).collect();
    let kept: Vec<bool> = (0..rows).map(|r| r == 0 || !draw.chance(dropped)).collect();
    for (c, column) in columns.iter_mut().enumerate() {
        for r in (1..rows).filter(|&r| c > 0 && repeats[r]) {
            column[r] = column[r - 1];
        }
        let mut r = 0;
        column.retain(|_| {
            r += 1;
            kept[r - 1]
        });
    }
}

/// The value at time t, s, of a signal that is given on the fine time grid, by linear interpolation.
fn at(series: &[f64], t: f64) -> f64 {
    let place = (t * FINE).clamp(0.0, (series.len() - 1) as f64);
    let nearest = place.round();
    if (place - nearest).abs() < 1e-6 {
        return series[nearest as usize];
    }
    let i = place.floor() as usize;
    series[i] + (place - i as f64) * (series[i + 1] - series[i])
}

/// A first-order low-pass, initially at rest at the first value. It is exact for a signal that is constant during each step.
/// `rate`: steps per second.
pub fn low_pass(series: &[f64], cutoff: f64, rate: f64) -> Vec<f64> {
    let keep = (-TAU * cutoff / rate).exp();
    let mut y = series[0];
    let step = |x: &f64| {
        y = keep * y + (1.0 - keep) * x;
        y
    };
    series.iter().map(step).collect()
}
