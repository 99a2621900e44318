//! Detects signals with a lower sampling rate than the rows of their log, and finds their own samples.
//!
//! A row that repeats the previous value is not a sample: the value belongs to the time of the first row that has it. Such a
//! signal is sampled at these times, and its clock has its own rate. So cut-off, noise and number of rows do not depend on the
//! rate of the logger. Torques with a lower rate than the positions are interpolated between their own samples.

use logs::{Log, LogReport};

use crate::signals::signal_options::Signal;

/// Time between the samples of a prepared log, s: 1 / requested rate, or else the time between new positions.
pub(crate) fn sample_period(report: &LogReport, signal: &Signal) -> f64 {
    let seldom = report.refresh.seldom_motion(report.clock.period).filter(|_| !signal.own_clock);
    let period = seldom.unwrap_or(report.clock.period);
    signal.rate.map_or(period, |rate| 1.0 / rate)
}

/// The indices of the rows at which at least one series has a new value. `None` if `is_seldom` is false, because each row is then
/// a sample.
pub(crate) fn changes(group: &[&[f64]], is_seldom: bool) -> Option<Vec<usize>> {
    let rows = group.first().filter(|_| is_seldom)?.len();
    let places: Vec<usize> = (1..rows).filter(|&r| group.iter().any(|x| x[r] != x[r - 1])).collect();
    (places.len() > 1).then_some(places)
}

/// Two flags: whether the positions have a lower sampling rate than the rows of the log, and whether the torques have a lower
/// sampling rate than the rows.
pub(crate) fn are_seldom(log: &Log) -> [bool; 2] {
    let (refresh, period) = (&log.report.refresh, log.report.clock.period);
    [refresh.seldom_motion(period).is_some(), refresh.seldom_effort(period).is_some()]
}

/// The samples of a series at the indices `places`.
pub(crate) fn at_places(x: &[f64], places: &[usize]) -> Vec<f64> {
    places.iter().map(|&r| x[r]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signals::cutoff::MotionEnergy;
    use crate::signals::joint_signals::add_motion;
    use crate::signals::preparation::{Preparation, states};
    use crate::test_arm::Pendulum;
    use linear_model::regressor::Regressor;
    use logs::{ColumnNames, LogSource, Table};
    use std::fmt::Write as _;

    /// A log of a pendulum at 500 Hz with new positions every `motion` rows and new torques every `effort` rows.
    fn log(motion: usize, effort: usize) -> Log {
        let arm = Pendulum::new();
        // Angle and torque of the pendulum at the time of row r.
        let at = |r: usize| {
            let t = 2e-3 * r as f64;
            let (a, b) = ((2.0 * t).sin_cos(), (5.1 * t).sin_cos());
            let q = a.0 + 0.3 * b.1;
            let mut y = [0.0; 3];
            arm.fill(&[q], &[2.0 * a.1 - 1.53 * b.0], &[-4.0 * a.0 - 7.803 * b.1], &mut y);
            (q, y.iter().zip(arm.truth).map(|(y, x)| y * x).sum::<f64>())
        };
        let mut text = "t,q1,tau1\n".to_string();
        for r in 0..8000 {
            let _ = writeln!(text, "{},{:.9},{:.9}", 2e-3 * r as f64, at(r - r % motion).0, at(r - r % effort).1);
        }
        let table = Table::from_bytes("log.csv", text.as_bytes()).unwrap();
        match LogSource::from_table(table, &["q1".into()], &ColumnNames::default()).unwrap().0 {
            LogSource::Held(log) => log,
            LogSource::Streamed(_) => panic!("it is of one block"),
        }
    }

    #[test]
    fn a_held_log_is_taken_at_its_own_rate() {
        let arm = Pendulum::new();
        let (fresh, held) = (log(1, 1), log(4, 4));
        assert_eq!(sample_period(&fresh.report, &Signal::default()), fresh.report.clock.period);
        assert!((sample_period(&held.report, &Signal::default()) - 8e-3).abs() < 1e-9);
        let cutoff = |log: &Log| {
            let mut energy = MotionEnergy::default();
            add_motion(log, log.q.clone(), &Signal::default(), &mut energy).unwrap();
            energy.content()
        };
        let (a, b) = (cutoff(&fresh), cutoff(&held));
        // Allowed difference: one frequency bin in both directions. A bin is 1/16 Hz wide, because the record is 16 s long.
        assert!((a.f95[0] - b.f95[0]).abs() <= 0.126, "{a:?} {b:?}");
        let signal = Signal { cutoff: Some(10.0), decimate: Some(1), ..Signal::default() };
        let preparation = Preparation { signal, ..Preparation::default() };
        let found = &states(&arm, &held, &preparation).unwrap()[0];
        assert!((found.period - 8e-3).abs() < 1e-6, "{}", found.period);
        // The torques have no delay. A delay of half the time between new values would give an error of 0.1 N m. The errors of
        // the filter and of the fourth-order differences at 8 ms are below a hundredth of the largest torque.
        let mut y = [0.0; 3];
        for r in (0..found.len()).step_by(37) {
            arm.fill(&found.q[r..r + 1], &found.dq[r..r + 1], &found.ddq[r..r + 1], &mut y);
            let expected: f64 = y.iter().zip(arm.truth).map(|(y, x)| y * x).sum();
            assert!((found.tau[r] - expected).abs() < 0.02, "{r}: {} for {expected}", found.tau[r]);
        }
    }

    #[test]
    fn torques_that_come_seldom_bound_the_cutoff() {
        let held = log(1, 25);
        let mut energy = MotionEnergy::default();
        add_motion(&held, held.q.clone(), &Signal::default(), &mut energy).unwrap();
        assert!(energy.content().cutoff <= 4.0 * (1.0 + 1e-9));
        let own = Signal { own_clock: true, ..Signal::default() };
        assert_eq!(are_seldom(&held), [false, true]);
        assert!(changes(&[&held.effort[0]], true).is_some_and(|places| places.windows(2).all(|w| w[1] - w[0] == 25)));
        assert_eq!(sample_period(&held.report, &own), held.report.clock.period);
    }
}
