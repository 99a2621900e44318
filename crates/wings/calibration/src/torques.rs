//! Computes the holding torques, which bend the joints of a robot at rest, and calibrates a robot with these torques.
//!
//! A holding torque is the torque of a joint that holds the robot at rest against gravity. A compliance is the rotation of a
//! joint per holding torque.

use std::path::Path;

use rist::{Error, Estimate, KnownLoad, Model};

use crate::calibrate::{Calibration, calibrate, chain_of};
use crate::request::{CalibrateRequest, Calibrated};

/// Calibrates the robot of a model like [`calibrate`]. Compliances need holding torques. The estimate gives these torques;
/// without an estimate, the bodies of the description give them.
pub fn calibrate_model(
    model: &Model,
    estimate: Option<&Estimate>,
    path: &Path,
    request: &CalibrateRequest,
) -> Result<Calibration, Error> {
    if request.what != Calibrated::Stiffness {
        return calibrate(&model.robot, path, request, None);
    }
    let last = chain_of(&model.robot, request)?.links.last().map(|&j| model.robot.link(j).name.clone());
    let tip = request.tip.clone().or(last).unwrap_or_default();
    let load_position = request.options.as_ref().map_or([0.0; 3], |options| options.load_position);
    let torque = holding_torque(model, estimate, &tip, load_position)?;
    calibrate(&model.robot, path, request, Some(&torque))
}

/// The holding torques of a model at rest, as a function of the position and of the mass of a load, N m (N): Y(q, 0, 0) X. `X`: the
/// parameters of the estimate, or those of the description. `tip`: the link that carries the load; `load_position`: centre of mass of
/// the load in its frame, m.
///
/// Fails if the description has no bodies and there is no estimate, or if the estimate lacks a parameter.
pub fn holding_torque<'a>(
    model: &'a Model,
    estimate: Option<&Estimate>,
    tip: &str,
    load_position: [f64; 3],
) -> Result<impl Fn(&[f64], f64) -> Vec<f64> + use<'a>, Error> {
    let values = match estimate {
        Some(estimate) => model.values(estimate)?,
        None => model.nominal_parameters().ok_or_else(|| {
            Error::new(
                "[what=stiffness] needs torques, and the description has no bodies: give an estimate by [estimate]",
            )
        })?,
    };
    let unit =
        KnownLoad { link: tip.to_string(), mass: 1.0, centre_of_mass: load_position, inertia: Default::default() };
    let of_load = model.added_by(&unit)?;
    let (n, p) = (model.robot.n_coordinates(), values.len());
    Ok(move |q: &[f64], load: f64| {
        let (mut y, rest) = (vec![0.0; n * p], vec![0.0; n]);
        model.regressor().fill(q, &rest, &rest, &mut y);
        (0..n).map(|k| (0..p).map(|c| y[k * p + c] * (values[c] + load * of_load[c])).sum()).collect()
    })
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use random::Random;

    use super::*;
    use crate::calibrate::calibrate_table;
    use crate::chain::Convention;
    use crate::laws::table;
    use crate::measurement::MeasurementKind;
    use crate::parameter::{Parameter, ParameterGroup};
    use crate::request::{CalibrateRequest, Calibrated};
    use crate::simulated::{measured, problem, truth};
    use crate::write_back::zeros_table;

    /// An arm of 20 kg: a base that turns, upper arm, forearm and wrist.
    const HEAVY: &str = "convention: khalil-kleinfinger
name: heavy
gravity: [0, 0, -9.81]
coordinates: [q1, q2, q3, q4]
links:
  - {link: 1, antecedent: base, theta: q1}
  - {link: 2, antecedent: 1, alpha: pi/2, theta: q2}
  - {link: 3, antecedent: 2, d: 0.5, theta: q3}
  - {link: 4, antecedent: 3, d: 0.4, theta: q4}
standard_parameters:
  1: {XX: 0, XY: 0, XZ: 0, YY: 0, YZ: 0, ZZ: 0.1, MX: 0, MY: 0, MZ: 0, M: 4}
  2: {XX: 0, XY: 0, XZ: 0, YY: 0.7, YZ: 0, ZZ: 0.7, MX: 2.2, MY: 0, MZ: 0, M: 9}
  3: {XX: 0, XY: 0, XZ: 0, YY: 0.3, YZ: 0, ZZ: 0.3, MX: 0.9, MY: 0, MZ: 0, M: 5}
  4: {XX: 0, XY: 0, XZ: 0, YY: 0.05, YZ: 0, ZZ: 0.05, MX: 0.1, MY: 0, MZ: 0, M: 2}
";
    /// True compliances of the joints that gravity loads, rad/(N m).
    const COMPLIANCES: [f64; 3] = [1e-5, 3e-5, 6e-5];

    /// Loads of 1 to 10 kg bend the joints. About 95 % of the intervals contain the true compliances. With fitted compliances,
    /// the error on postures left out is at most a quarter of the error without them.
    #[test]
    fn compliances_of_a_heavy_arm_are_covered() {
        let model = Model::parse(HEAVY, "heavy.yaml", &rist::ModelOptions::default()).unwrap();
        let robot = rist::parse_robot(HEAVY, Path::new("heavy.yaml"), &rist::ModelOptions::default()).unwrap();
        let tip = robot.links[3].name.clone();
        let torque = holding_torque(&model, None, &tip, [0.1, 0.0, 0.05]).unwrap();
        // At rest with all links along x, the load of 1 kg is 1 m from the axis of joint 2.
        let lever = torque(&[0.0; 4], 1.0)[1] - torque(&[0.0; 4], 0.0)[1];
        assert!((lever - 9.81).abs() < 1e-12, "{lever}");
        let (mut inside, mut all) = (0u32, 0u32);
        for seed in 0..12 {
            let mut random = Random::new(600 + seed);
            let mut problem = problem(&robot, Convention::Dh, MeasurementKind::Pose, 40, &mut random);
            let loads: Vec<f64> = problem.postures.iter().map(|_| random.between(1.0, 10.0)).collect();
            for (posture, load) in problem.postures.iter_mut().zip(&loads) {
                posture.torque = torque(&posture.q, *load);
            }
            let mut truth = truth(&problem, 0.02, 0.0, &mut random);
            let count = truth.chain.len();
            truth.chain[count - 3..].copy_from_slice(&COMPLIANCES);
            // The noise is that of a laser tracker, 0.05 mm. The error on postures left out contains it too.
            let problem = measured(&problem, &truth, [5e-5; 2], &mut random);
            let mut table = table(&problem, &robot);
            table.header.push("load".into());
            table.columns.push(loads);
            table.texts.push(None);
            let request = CalibrateRequest { what: Calibrated::Stiffness, ..CalibrateRequest::default() };
            let found = calibrate_table(&robot, &table, &request, Some(&torque)).unwrap();
            let (zeros, stiff) = (&found.levels[1].left_out, &found.level().left_out);
            assert!(stiff.length < zeros.length.map(|x| 0.25 * x), "{found}");
            for p in found.parameters(found.level()) {
                let Parameter::Compliance { coordinate: k @ 1.. } = p.parameter else { continue };
                inside += u32::from((p.value - COMPLIANCES[k - 1]).abs() < p.interval);
                all += 1;
            }
            let zeros = zeros_table(&found, found.level());
            assert!(zeros.starts_with("joint,zero,interval,unit\nq1,,,rad\nq2,"), "{zeros}");
            assert!(found.parameters(found.level()).iter().any(|p| p.parameter.group() == ParameterGroup::Compliances));
        }
        // Expected are 95 % of 12 x 3 parameters; three standard deviations of this share are 11 %.
        assert!(all == 36 && f64::from(inside) / f64::from(all) >= 0.84, "{inside} of {all}");
    }
}
