//! Changes the columns of a simulated log as a mistake of a user would.
//!
//! Examples: exchanged columns, a wrong sign, degrees instead of radians.

use std::f64::consts::TAU;

use super::arms::Arm;
use super::kinds::{Kind, Mistake};
use crate::joint_log::JointLog;
use crate::random_situations::draw::Draw;
use crate::random_situations::sensors::low_pass;

/// Adds a mistake to the columns of a log. Mistakes of the machine (such as a load) are not added here; the simulated log already
/// contains them.
pub fn spoil(arm: &Arm, mistake: &Mistake, log: &mut JointLog) {
    let Mistake { kind, a, b, more } = *mistake;
    let JointLog { t, q, dq, tau } = log;
    match kind {
        Kind::Zero(degrees) => {
            let off = if more < 0.5 { degrees } else { -degrees }.to_radians();
            q[a].iter_mut().for_each(|q| *q += off);
        }
        Kind::MotionSign => [&mut q[a], &mut dq[a]].into_iter().for_each(|x| scale(x, -1.0)),
        Kind::TorqueSign => scale(&mut tau[a], -1.0),
        Kind::Reversed => [&mut q[a], &mut dq[a], &mut tau[a]].into_iter().for_each(|x| scale(x, -1.0)),
        Kind::AllTorqueSigns => tau.iter_mut().for_each(|tau| scale(tau, -1.0)),
        Kind::SwappedMotions => [q, dq].into_iter().for_each(|x| x.swap(a, b)),
        Kind::SwappedVelocities => dq.swap(a, b),
        Kind::SwappedTorques => tau.swap(a, b),
        Kind::SwappedColumns => [q, dq, tau].into_iter().for_each(|x| x.swap(a, b)),
        Kind::Rotated => [q, dq, tau].into_iter().for_each(|x| x.rotate_left(1)),
        Kind::Degrees => {
            let angles = (0..arm.n()).filter(|k| !arm.slides(*k));
            angles.for_each(|k| [&mut q[k], &mut dq[k]].into_iter().for_each(|x| scale(x, 360.0 / TAU)));
        }
        Kind::AllScaled(factor) => tau.iter_mut().for_each(|tau| scale(tau, factor)),
        Kind::Scaled(factor) => scale(&mut tau[a], factor),
        Kind::TwoScaled => {
            scale(&mut tau[a], 0.5);
            scale(&mut tau[b], 3.0);
        }
        Kind::Currents => {
            let draw = &mut Draw::of((more * 1e6) as u64, 1);
            tau.iter_mut().for_each(|tau| scale(tau, 1.0 / draw.log(8.0, 150.0)));
        }
        Kind::DeadTorque => {
            let first = tau[a][0];
            tau[a].fill(first);
        }
        Kind::Saturated => {
            let limit = 0.6 * tau[a].iter().fold(0.0, |m: f64, x| m.max(x.abs()));
            tau[a].iter_mut().for_each(|x| *x = x.clamp(-limit, limit));
        }
        Kind::FilteredVelocities(cutoff) => {
            let period = t[1] - t[0];
            dq.iter_mut().for_each(|dq| *dq = low_pass(dq, cutoff, 1.0 / period));
        }
        Kind::Normalised => {
            for k in 0..arm.n() {
                let (low, high) = arm.range(k);
                q[k].iter_mut().for_each(|q| *q = 200.0 * (*q - low) / (high - low) - 100.0);
                scale(&mut dq[k], 200.0 / (high - low));
            }
        }
        Kind::Drift => {
            let whole = t[t.len() - 1];
            tau[a].iter_mut().zip(t).for_each(|(tau, t)| *tau *= 1.0 + 0.25 * *t / whole);
        }
        Kind::Late(_) | Kind::Base(_) | Kind::GravityOut | Kind::Spring | Kind::Payload | Kind::LoadPickedUp => {}
        Kind::OtherRobot | Kind::Contact | Kind::Computed => {}
    }
}

fn scale(series: &mut [f64], factor: f64) {
    series.iter_mut().for_each(|x| *x *= factor);
}
