//! The conversion between the numbers of the drives and the quantities of the joints.
//!
//! ```text
//! q   = P u_q x_q + q_0            dq = P u_v x_v
//! x_e = G^-1 R^-T s (tau + k q)    in the unit of the efforts of the log
//! ```
//! x_q, x_v, x_e: positions, velocities and efforts of the drives, in the units u of the log from which the model was
//! identified; P = R^-1, or 1 if the log has positions of the joints; R: gear ratios and couplings; q_0: offsets; G: drive
//! gains; s, k: scale and spring of each joint. This conversion is the inverse of the conversion by which the logs were read
//! (`identification::signals::transmission`). So the efforts that a package sends to the drives have the sign and the unit of
//! the efforts in the logs.

use logs::{Effort, Quantity};
use rist::{Error, Estimate, Model, Options};

/// The conversion between drives and joints.
#[derive(Clone, Debug, PartialEq)]
pub struct DriveUnits {
    /// The quantity that a drive receives as its command.
    pub effort: Effort,
    /// The units of positions, velocities and efforts of the drives, in words.
    pub units: [String; 3],
    /// Positions of the joints per position of a drive, rad (m) per unit, row by row.
    pub positions: Vec<f64>,
    /// Velocities of the joints per velocity of a drive, row by row.
    pub velocities: Vec<f64>,
    /// Position of each joint where its drive is at zero, rad (m).
    pub offsets: Vec<f64>,
    /// Efforts of the drives per torque of a joint, units per N m (N), row by row.
    pub efforts: Vec<f64>,
    /// Stiffness of the spring at each joint, N m/rad (N/m).
    pub springs: Vec<f64>,
    /// If efforts are offsets of goals (position errors): the unit of a position of a drive, divided by the unit of its effort.
    pub effort_per_position: f64,
    /// Whether each joint has a drive.
    pub is_driven: Vec<bool>,
}

impl DriveUnits {
    /// The conversion that follows from the options of an identification. Without options, all numbers are in SI units, and
    /// efforts are torques unless the estimate has drive gains.
    ///
    /// Fails if the options do not fit the model, or if a drive has no gain.
    pub fn of(model: &Model, estimate: &Estimate, options: &Options) -> Result<DriveUnits, Error> {
        let n = model.robot.n_coordinates();
        let (transmission, columns) = (&options.transmission, &options.columns);
        let told = |e: String| Error::new(format_args!("[options]: {e}"));
        let estimated = model.estimated_gains(estimate);
        let of_joint = |list: &Option<Vec<f64>>, otherwise: f64| list.clone().unwrap_or_else(|| vec![otherwise; n]);
        let effort = match (&columns.goal, &columns.current, &columns.units.current) {
            (Some(_), ..) => Effort::PositionError,
            (None, None, None) if transmission.drive_gains.is_none() && estimated.iter().all(Option::is_none) => {
                Effort::Torque
            }
            _ => Effort::Current,
        };
        let quantity = match effort {
            Effort::Torque => Quantity::Torque,
            Effort::Current => Quantity::Current,
            Effort::PositionError => Quantity::Goal,
        };
        let units: Vec<(String, f64)> = [Quantity::Position, Quantity::Velocity, quantity]
            .into_iter()
            .map(|of| columns.unit(of).map_err(told))
            .collect::<Result<_, _>>()?;
        let per_motor = transmission.joints_per_motor(n).map_err(|e| told(e.to_string()))?;
        let undriven = columns.undriven(model.regressor().coordinates()).map_err(told)?;
        let is_driven: Vec<bool> = undriven.iter().map(Option::is_none).collect();
        let gains = gains(model, &estimated, transmission.drive_gains.as_deref(), effort, &is_driven)?;
        let scales = of_joint(&transmission.scales, 1.0);
        // Row by row: factor * matrix[i][j].
        let matrix = |entry: &dyn Fn(usize, usize) -> f64| (0..n * n).map(|i| entry(i / n, i % n)).collect::<Vec<_>>();
        let is_joint_side = transmission.joint_side_positions;
        let position = |i: usize, j: usize| if is_joint_side { f64::from(i == j) } else { per_motor[i][j] };
        Ok(DriveUnits {
            effort,
            positions: matrix(&|i, j| position(i, j) * units[0].1),
            velocities: matrix(&|i, j| position(i, j) * units[1].1),
            offsets: of_joint(&transmission.offsets, 0.0),
            efforts: matrix(&|m, k| per_motor[k][m] * scales[k] / gains[m] / units[2].1),
            springs: of_joint(&transmission.springs, 0.0),
            effort_per_position: units[0].1 / units[2].1,
            is_driven,
            units: [units[0].0.clone(), units[1].0.clone(), units[2].0.clone()],
        })
    }
}

/// The gain of each drive, from the options, the estimate, or the description. It is 1 if efforts are torques.
fn gains(
    model: &Model,
    estimated: &[Option<f64>],
    given: Option<&[f64]>,
    effort: Effort,
    is_driven: &[bool],
) -> Result<Vec<f64>, Error> {
    if !effort.needs_gains() {
        return Ok(vec![1.0; is_driven.len()]);
    }
    let described = model.drive_gains();
    let gain = |k: usize| match given.and_then(|all| all.get(k).copied()).or(estimated[k]).or(described[k]) {
        _ if !is_driven[k] => Ok(1.0),
        Some(gain) if gain.is_finite() && gain != 0.0 => Ok(gain),
        _ => Err(Error::new(format_args!(
            "the drive of {} has no gain, {}: give `transmission: {{drive_gains: [..]}}` in [options]",
            model.regressor().coordinates()[k],
            effort.gain_unit()
        ))),
    };
    (0..is_driven.len()).map(gain).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn options(text: &str) -> Options {
        Options::parse("options.yaml", text).unwrap()
    }

    fn planar() -> Model {
        Model::read(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../models/planar2r_vertical.yaml")).unwrap()
    }

    /// The first drive measures at the motor: its encoder has 100 ticks a turn, its gear ratio is -50, its torque constant 0.1
    /// N m/A, and its current is in mA.
    #[test]
    fn numbers_of_drives_have_their_units_and_signs() {
        let text = "columns: {units: {position: ticks(100), velocity: deg/s, current: mA}}\n\
                    transmission: {ratios: [-50, 10], drive_gains: [0.1, 2], offsets: [0.5, 0], scales: [2, 1]}\n";
        let units = DriveUnits::of(&planar(), &Estimate::default(), &options(text)).unwrap();
        assert_eq!(units.effort, Effort::Current);
        let turn = std::f64::consts::TAU;
        // Allowed error: one rounding for each of a few products.
        let near = |a: f64, b: f64| assert!((a - b).abs() <= 1e-12 * b.abs(), "{a} {b}");
        near(units.positions[0], -turn / 100.0 / 50.0);
        near(units.velocities[3], turn / 360.0 / 10.0);
        near(units.efforts[0], 2.0 / -50.0 / 0.1 * 1e3);
        near(units.efforts[3], 1.0 / 10.0 / 2.0 * 1e3);
        assert_eq!((units.positions[1], units.efforts[2], units.offsets[0]), (0.0, 0.0, 0.5));
        assert_eq!(units.units, ["ticks(100)", "deg/s", "mA"]);
    }

    #[test]
    fn a_current_without_a_gain_is_refused() {
        let said =
            |text: &str| DriveUnits::of(&planar(), &Estimate::default(), &options(text)).unwrap_err().to_string();
        assert!(said("columns: {units: {current: mA}}").contains("the drive of q1 has no gain, N m/A"));
        assert!(said("columns: {goal: 'g_{}'}").contains("N m/rad"));
        assert!(said("transmission: {ratios: [1]}").contains("[options]: transmission: ratios needs 2"));
        assert!(said("columns: {free: [q9]}").contains("q9"));
    }
}
