//! What the numbers of a log of a force-torque sensor may mean instead: each meaning is tried, and said where it explains what is
//! left.

use crate::wrench_options::Corrections;
use crate::wrenches::Wrenches;
use claims::{Claim, Figure, Outcome, Remedy, Subject, Topic, Trial};
use numerics::vector::dot;

use crate::wrench_load::{WrenchLoad, wrench_load, wrench_load_under};
use crate::wrench_turn::sensor_turn;
use identification::estimate::identified::INTERVAL;
use identification::estimate::topics::LOG;

/// What is left is more than noise beyond so many times it; and an alternative explains it that divides it by as many.
pub(super) const NOISE_RATIO: f64 = 3.0;
/// What torques count beside forces, m.
pub(super) const ARM_M: f64 = 0.1;
/// A smaller turn is one of calibration, rad.
const SMALL_TURN: f64 = 3.0 * std::f64::consts::PI / 180.0;
/// What mends signals without weight.
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

/// What is left of what varies in a log.
pub(super) fn share_left(log: &Wrenches, found: &WrenchLoad) -> f64 {
    let spread = |signal: &[[f64; 3]]| {
        let n = signal.len() as f64;
        let of_axis = |i: usize| {
            let mean = signal.iter().map(|x| x[i]).sum::<f64>() / n;
            signal.iter().map(|x| (x[i] - mean).powi(2)).sum::<f64>() / (3.0 * n)
        };
        (0..3).map(of_axis).sum::<f64>().sqrt()
    };
    left(found) / spread(&log.force).hypot(spread(&log.torque) / ARM_M)
}

/// What the numbers mean instead, where that explains what is left; `as_given`: the share that is left.
pub(super) fn alternative(log: &Wrenches, as_given: f64) -> Option<Claim> {
    let plain = Corrections::default();
    let mut all = vec![
        ("the first number of the quaternions is w".into(), Corrections { scalar_first: true, ..plain }),
        (
            "the poses are those of the frame at rest in the sensor".into(),
            Corrections { inverted_poses: true, ..plain },
        ),
        ("forces and torques are in the axes of the frame at rest".into(), Corrections { base_axes: true, ..plain }),
        ("are the torques in N mm?".into(), Corrections { torque: 1e-3, ..plain }),
    ];
    if !log.in_degrees.is_empty() {
        let what = "the angles of the orientation are in degrees, taken for radians".into();
        all.push((what, Corrections { degrees: true, ..plain }));
    }
    if let Some(turn) = sensor_turn(log) {
        let degrees = turn.map(|x| format!("{:.1}", x.to_degrees())).join(", ");
        let what = format!("the sensor is turned against the frame of the poses, by roll, pitch, yaw of {degrees} deg");
        all.extend((dot(&turn, &turn).sqrt() > SMALL_TURN).then_some((what, Corrections { turn, ..plain })));
    }
    let is_load = |found: &WrenchLoad| found.determined[9] && found.parameters[9] > INTERVAL * found.sigma[9];
    let tried = all.into_iter().filter_map(|(what, corrections): (String, Corrections)| {
        let log = log.clone().corrected(&corrections);
        let found = wrench_load(&log).ok().filter(is_load)?;
        Some((what, in_options(&corrections), share_left(&log, &found)))
    });
    let weightless = wrench_load_under(log, 0.0).ok().filter(is_load).map(|found| {
        let what = "the weight of the load is not in the forces: the driver takes the weight out".into();
        (what, OWN_SIGNALS.into(), share_left(log, &found))
    });
    let (fault, advice, after) = tried.chain(weightless).min_by(|a, b| a.2.total_cmp(&b.2))?;
    let [before, shown] = [as_given, after].map(|x| Figure::new(100.0 * x, "% of what varies"));
    let trial = Trial::Tried { quantity: "what is left".into(), before, after: shown };
    (NOISE_RATIO * after < as_given).then(|| contradicted(LOG, fault, advice, trial))
}
