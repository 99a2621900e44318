//! Usual mistakes in logs, which are added to a correct log.
//!
//! Each mistake comes with a function that tests whether a finding of the log check (`rist doctor`) names it.

use identification::estimate::hypothesis::Hypothesis;
use identification::estimate::log_check::finding::{ColumnKind, Fault};

use crate::joint_log::JointLog;

/// A log with a mistake, and a function that tests whether a finding names this mistake.
pub struct Injected {
    pub name: &'static str,
    pub log: JointLog,
    /// Indices of the coordinates with the mistake; empty: all coordinates.
    pub joints: Vec<usize>,
    pub is_named: Box<dyn Fn(&Fault) -> bool>,
}

pub fn changed(log: &JointLog, change: impl FnOnce(&mut JointLog)) -> JointLog {
    let mut log = log.clone();
    change(&mut log);
    log
}

pub fn each(series: &mut [Vec<f64>], change: impl Fn(f64) -> f64) {
    series.iter_mut().flatten().for_each(|x| *x = change(*x));
}

/// The log with reversed signs for joint k: of positions and velocities (`motion`), of torques (`torque`).
pub fn mirrored(log: &JointLog, k: usize, motion: bool, torque: bool) -> JointLog {
    let minus = |series: &mut [f64]| series.iter_mut().for_each(|x| *x = -*x);
    changed(log, |log| {
        if motion {
            minus(&mut log.q[k]);
            minus(&mut log.dq[k]);
        }
        if torque {
            minus(&mut log.tau[k]);
        }
    })
}

/// The log with currents instead of torques. The drive gains are about 12 N m/A.
pub fn amperes(log: &JointLog) -> JointLog {
    const PER_NEWTON_METRE: [f64; 7] = [0.08, 0.075, 0.09, 0.1, 0.09, 0.1, 0.1];
    changed(log, |l| {
        let gains = l.tau.iter_mut().zip(PER_NEWTON_METRE);
        gains.for_each(|(tau, gain)| tau.iter_mut().for_each(|x| *x *= gain));
    })
}

/// The first `seconds` of the log. This may be too short for a check.
pub fn cut(log: &JointLog, seconds: f64) -> JointLog {
    let rows = log.t.iter().position(|t| t - log.t[0] >= seconds).unwrap_or(log.t.len());
    changed(log, |l| {
        l.t.truncate(rows);
        l.q.iter_mut().chain(&mut l.dq).chain(&mut l.tau).for_each(|x| x.truncate(rows));
    })
}

/// The log with torques that are delayed by this number of rows.
fn late(log: &JointLog, rows: usize) -> JointLog {
    let n = log.t.len();
    changed(log, |l| {
        l.tau.iter_mut().for_each(|tau| {
            tau.truncate(n - rows);
        });
        l.t.drain(..rows);
        l.q.iter_mut().chain(&mut l.dq).for_each(|x| {
            x.drain(..rows);
        });
    })
}

/// The log in which the torque of joint k is limited to a fraction of its largest magnitude.
fn saturated(log: &JointLog, k: usize, share: f64) -> JointLog {
    changed(log, |l| {
        let most = share * l.tau[k].iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        l.tau[k].iter_mut().for_each(|x| *x = x.clamp(-most, most));
    })
}

/// Logs with fifteen mistakes that are possible in any log, made from the correct log `good`. `heavy`: two joints with large
/// torques of gravity or inertia. `weight(log, row)`: nominal gravity torques of the joints at the position of a row. `rows`:
/// delay of the torques in rows.
pub fn injected(
    good: &JointLog,
    heavy: [usize; 2],
    weight: impl Fn(&JointLog, usize) -> Vec<f64>,
    rows: usize,
) -> Vec<Injected> {
    let (n, [a, b]) = (good.q.len(), heavy);
    let right = std::f64::consts::FRAC_PI_2;
    let delay = rows as f64 * (good.t[good.t.len() - 1] - good.t[0]) / (good.t.len() - 1) as f64;
    let mut all = Vec::new();
    let mut add = |name, log, joints: &[usize], is_named: Box<dyn Fn(&Fault) -> bool>| {
        all.push(Injected { name, log, joints: joints.to_vec(), is_named });
    };
    let is = |fault: Fault| -> Box<dyn Fn(&Fault) -> bool> { Box::new(move |f| *f == fault) };
    add("N mm", changed(good, |l| each(&mut l.tau, |x| 1e3 * x)), &[], is(Fault::TorqueUnit(3)));
    add("amperes", amperes(good), &[], is(Fault::NoTorque));
    add("all torque signs", changed(good, |l| each(&mut l.tau, |x| -x)), &[], is(Fault::TorqueSigns));
    add("a torque sign", mirrored(good, a, false, true), &[a], is(Fault::Of(Hypothesis::TorqueSign(a), 0.0)));
    add("a joint's sign", mirrored(good, b, true, false), &[b], is(Fault::Of(Hypothesis::MotionSign(b), 0.0)));
    let turned = changed(good, |l| each(&mut l.q[b..=b], |x| x + right));
    add("a quarter turn", turned, &[b], is(Fault::Of(Hypothesis::Zero(b), -right)));
    let degrees = changed(good, |l| {
        each(&mut l.q, f64::to_degrees);
        each(&mut l.dq, f64::to_degrees);
    });
    add("degrees", degrees, &(0..n).collect::<Vec<_>>(), is(Fault::Of(Hypothesis::Degrees, 0.0)));
    let swapped = changed(good, |l| [&mut l.q, &mut l.dq].into_iter().for_each(|x| x.swap(a, b)));
    let pair = [a.min(b), a.max(b)];
    add("two joints swapped", swapped, &pair, is(Fault::Of(Hypothesis::SwappedMotions(pair[0], pair[1]), 0.0)));
    let permuted = changed(good, |l| [&mut l.q, &mut l.dq, &mut l.tau].into_iter().for_each(|x| x[..3].rotate_left(1)));
    add("three joints permuted", permuted, &[0, 1, 2], is(Fault::Permuted(ColumnKind::All)));
    // The log check (`rist doctor`) computes the delay from differences over 20 ms and more. So it may be wrong by up to a
    // third.
    let is_late = move |f: &Fault| matches!(f, Fault::Of(Hypothesis::Late(None), s) if (s - delay).abs() < delay / 3.0);
    add("late torques", late(good, rows), &[], Box::new(is_late));
    let weightless = changed(good, |l| {
        for r in 0..l.t.len() {
            let weight = weight(l, r);
            l.tau.iter_mut().zip(weight).for_each(|(tau, w)| tau[r] -= w);
        }
    });
    add("no gravity", weightless, &[], is(Fault::Of(Hypothesis::GravityCompensated, 0.0)));
    add("another joint's velocity", changed(good, |l| l.dq[b] = l.dq[a].clone()), &[b], is(Fault::Velocity));
    add("a dead torque", changed(good, |l| each(&mut l.tau[b..=b], |_| 0.0)), &[b], is(Fault::DeadTorque));
    let unwritten = changed(good, |l| each(&mut l.tau, |x| 1e-309 * x));
    add("memory nobody wrote", unwritten, &(0..n).collect::<Vec<_>>(), Box::new(|f| matches!(f, Fault::Nothing(_))));
    add("a saturated torque", saturated(good, a, 0.7), &[a], Box::new(|f| matches!(f, Fault::Saturated(_))));
    all
}
