//! Tests other interpretations of the numbers in a force-torque log, for example other units or axes. Each interpretation is a
//! correction of the log (`wrench_options::Corrections`); the load is fitted to the corrected log. An interpretation is
//! reported if it makes the residual of the fitted load small.

use crate::wrench_options::Corrections;
use crate::wrenches::Wrenches;
use claims::{Claim, Figure, Outcome, Remedy, Subject, Topic, Trial};
use numerics::vector::dot;

use crate::wrench_load::{WrenchLoad, wrench_load, wrench_load_under};
use crate::wrench_turn::sensor_turn;
use identification::estimate::identified::INTERVAL;
use identification::estimate::topics::LOG;

/// A residual above this multiple of the noise is not only noise. Another interpretation of the log explains the residual if it
/// divides the residual by at least this factor.
pub(super) const NOISE_RATIO: f64 = 3.0;
/// Lever arm that converts torques to forces if both are combined in one number, m.
pub(super) const ARM_M: f64 = 0.1;
/// A rotation of the sensor smaller than this value counts as a calibration error, rad.
const SMALL_TURN_RAD: f64 = 3.0 * std::f64::consts::PI / 180.0;
/// Metres per millimetre.
const MILLI: f64 = 1e-3;
/// Advice if the signals do not contain the weight of the load.
pub(super) const OWN_SIGNALS: &str = "log the sensor's own signals, without its driver's compensation of gravity";

pub(super) fn contradicted(topic: Topic, fault: String, advice: String, trial: Trial) -> Claim {
    Claim::new(Subject::whole(topic), Outcome::Contradicted { fault, remedy: Remedy::new("wrench", advice), trial })
}

pub(super) fn in_options(corrections: &Corrections) -> String {
    format!("in the file of [options]: {corrections}")
}

pub(super) fn left(found: &WrenchLoad) -> f64 {
    found.residuals[0].hypot(found.residuals[1] / ARM_M)
}

/// The residual of the fitted load, divided by the standard deviation of the signals.
pub(super) fn residual_share(log: &Wrenches, found: &WrenchLoad) -> f64 {
    let deviation = |signal: &[[f64; 3]]| {
        let n = signal.len() as f64;
        let of_axis = |i: usize| {
            let mean = signal.iter().map(|x| x[i]).sum::<f64>() / n;
            signal.iter().map(|x| (x[i] - mean).powi(2)).sum::<f64>() / (3.0 * n)
        };
        (0..3).map(of_axis).sum::<f64>().sqrt()
    };
    left(found) / deviation(&log.force).hypot(deviation(&log.torque) / ARM_M)
}

/// A claim that names another interpretation of the numbers in the log, if it explains the residual; otherwise `None`.
/// `as_given`: relative residual of the log without a change.
pub(super) fn alternative(log: &Wrenches, as_given: f64) -> Option<Claim> {
    let plain = Corrections::default();
    // Drivers of sensors usually differ in the following conventions. Each convention is tested as one correction.
    let mut all = vec![
        ("the first number of the quaternions is w".into(), Corrections { scalar_first: true, ..plain }),
        (
            "the poses are those of the frame at rest in the sensor".into(),
            Corrections { inverted_poses: true, ..plain },
        ),
        ("forces and torques are in the axes of the frame at rest".into(), Corrections { base_axes: true, ..plain }),
        ("are the torques in N mm?".into(), Corrections { torque: MILLI, ..plain }),
    ];
    if !log.in_degrees.is_empty() {
        let what = "the angles of the orientation are in degrees, taken for radians".into();
        all.push((what, Corrections { degrees: true, ..plain }));
    }
    if let Some(turn) = sensor_turn(log) {
        let degrees = turn.map(|x| format!("{:.1}", x.to_degrees())).join(", ");
        let what = format!("the sensor is turned against the frame of the poses, by roll, pitch, yaw of {degrees} deg");
        all.extend((dot(&turn, &turn).sqrt() > SMALL_TURN_RAD).then_some((what, Corrections { turn, ..plain })));
    }
    // Fits a load for each interpretation. An interpretation counts only if the mass of its load is significant.
    let is_load = |found: &WrenchLoad| found.determined[9] && found.parameters[9] > INTERVAL * found.sigma[9];
    let tried = all.into_iter().filter_map(|(what, corrections): (String, Corrections)| {
        let log = log.clone().corrected(&corrections);
        let found = wrench_load(&log).ok().filter(is_load)?;
        Some((what, in_options(&corrections), residual_share(&log, &found)))
    });
    // If the driver subtracts the weight, the load must be fitted with zero gravity.
    let weightless = wrench_load_under(log, 0.0).ok().filter(is_load).map(|found| {
        let what = "the weight of the load is not in the forces: the driver takes the weight out".into();
        (what, OWN_SIGNALS.into(), residual_share(log, &found))
    });
    let (fault, advice, after) = tried.chain(weightless).min_by(|a, b| a.2.total_cmp(&b.2))?;
    // The best interpretation must reduce the residual by the factor NOISE_RATIO.
    let [before, shown] = [as_given, after].map(|x| Figure::new(100.0 * x, "% of what varies"));
    let trial = Trial::Tried { quantity: "residual".into(), before, after: shown };
    (NOISE_RATIO * after < as_given).then(|| contradicted(LOG, fault, advice, trial))
}
