//! Identifies the load on a link, from logs with it and logs without.

use std::fmt;

use identification::estimate::identified::INTERVAL;
use identification::estimate::identify::Fit;
use identification::estimate::options::Options;
use identification::estimators::payload::payload;
use identification::rows::observation::Observation;
use identification::signals::records::SourceRecords;
use linear_model::pseudo_inertia::{Centroidal, Ten, centroidal, smallest_eigenvalue};
use logs::LogSource;
use nalgebra::DMatrix;
use robot::{Inertial, LinkId, transform_inertial};

use crate::error::Error;
use crate::model::Model;

/// A load with its uncertainty.
pub struct Load {
    /// The link that carries it.
    pub link: String,
    /// Whether all its parameters are determined. They are then in the link's frame as the model's file has it, else in
    /// the link's modified DH frame.
    pub is_whole: bool,
    /// XX XY XZ YY YZ ZZ MX MY MZ M about the frame's origin.
    pub parameters: Ten,
    /// Standard deviations that take the correlation of residuals in time into account.
    pub sigma: Ten,
    /// Whether the logs tell each of them.
    pub determined: [bool; 10],
    /// Whether they are in the frame that the user means, though not all are determined.
    pub(crate) in_file_frame: bool,
}

/// The load in the loaded logs.
///
/// Fails where the link does not exist or is ambiguous, or the logs cannot be read.
pub(crate) fn load(
    model: &Model,
    link: Option<&str>,
    fit: &Fit,
    loaded: &[LogSource],
    options: &Options,
) -> Result<Load, Error> {
    let index = body(model, link)?;
    let linear = options.linear_model(model.regressor());
    let records = SourceRecords::new(model.regressor(), loaded, &options.preparation())?;
    let with = Observation::of_records(&linear, &records, None)?.joints(|_| true);
    let without = fit.observation.joints(|_| true);
    let found = payload(&without, &with, &fit.weights, &model.standard_map(), index)?;
    let carrier = model.robot.link(model.body_links()[index]);

    // x' = T x: columns of T are the unit parameters in the other frame.
    let is_whole = found.determined.iter().all(|d| *d);
    let to_file = carrier.file_frame.inverse();
    let unit = |k: usize| -> Ten { std::array::from_fn(|i| f64::from(i == k)) };
    let turned: Vec<Ten> = (0..10).map(|k| transform_inertial(&unit(k), &to_file)).collect();
    let frame = if is_whole { DMatrix::from_fn(10, 10, |i, k| turned[k][i]) } else { DMatrix::identity(10, 10) };
    let parameters = std::array::from_fn(|i| (0..10).map(|k| frame[(i, k)] * found.parameters[k]).sum());
    let covariance = &frame * &found.covariance * frame.transpose();
    // Residuals of logs are correlated in time, so intervals are wider than for white noise.
    let widening = fit.estimate.discount().sqrt();
    let sigma = std::array::from_fn(|i| widening * covariance[(i, i)].max(0.0).sqrt());
    let determined = std::array::from_fn(|i| found.determined[i]);
    Ok(Load { link: carrier.name.clone(), is_whole, parameters, sigma, determined, in_file_frame: is_whole })
}

/// The body that carries the load: the named one (or one with a fixed link of that name), else the last one, if there
/// is only one last.
fn body(model: &Model, link: Option<&str>) -> Result<usize, Error> {
    let (robot, ids) = (&model.robot, model.body_links());
    let name = |id: &LinkId| robot.link(*id).name.as_str();
    let listed = |ids: &[LinkId]| ids.iter().map(name).collect::<Vec<_>>().join(", ");
    if let Some(wanted) = link {
        let carries = |id: &LinkId| name(id) == wanted || robot.link(*id).parts.iter().any(|p| p.name == wanted);
        return ids.iter().position(carries).ok_or_else(|| {
            Error::new(format_args!("[loaded_link]: there is no link `{wanted}`; there are {}", listed(&ids)))
        });
    }
    let is_last = |id: &LinkId| robot.links.iter().all(|other| other.antecedent != Some(*id));
    let ends: Vec<LinkId> = ids.iter().copied().filter(is_last).collect();
    match ends.as_slice() {
        [end] => Ok(ids.iter().position(|id| id == end).unwrap_or(0)),
        _ => Err(Error::new(format_args!(
            "which link carries the load? the robot ends in {}; name one with [loaded_link], of {}",
            listed(&ends),
            listed(&ids)
        ))),
    }
}

impl Load {
    /// Mass, centre of mass and the inertia about it, in the axes of the link's frame as the model's file has it; `None`
    /// where the logs do not tell a body that can exist.
    pub fn body(&self) -> Option<Centroidal> {
        let is_told = self.is_whole && self.parameters[9].abs() > INTERVAL * self.sigma[9];
        let can_exist = smallest_eigenvalue(&self.parameters) >= 0.0;
        centroidal(&self.parameters).filter(|_| is_told && can_exist)
    }
}

/// A load in the words of those who take one; each wants the centre of mass, and the inertia about it, in the axes of its
/// flange. `None` for the inertia leaves out those who cannot do without.
///
/// UR: set_target_payload(m, cog, [Ixx, Iyy, Izz, Ixy, Ixz, Iyz]). Franka: setLoad with the nine entries by columns. KUKA:
/// centre in mm. xArm: set_tcp_load with kg and mm, without an inertia. The last is the file of our own `load`.
fn words_of_controllers(
    f: &mut fmt::Formatter<'_>,
    link: &str,
    mass: f64,
    centre: [f64; 3],
    inertia: Option<[f64; 6]>,
) -> fmt::Result {
    // Rounded as printed, so that nothing is a negative zero.
    let rounded = |x: f64, digits: f64| (x * digits).round() / digits + 0.0;
    let [x, y, z] = centre.map(|x| rounded(x, 1e4));
    let [x_mm, y_mm, z_mm] = [x, y, z].map(|x| 1000.0 * x);
    let inertia = inertia.map(|inertia| inertia.map(|i| rounded(i, 1e5)));
    writeln!(f, "about its centre of mass, in the axes of that frame (that of the flange, for a controller):")?;
    let ur = inertia.map_or(String::new(), |[xx, xy, xz, yy, yz, zz]| {
        format!(", [{xx:.5}, {yy:.5}, {zz:.5}, {xy:.5}, {xz:.5}, {yz:.5}]")
    });
    writeln!(f, "UR      set_target_payload({mass:.4}, [{x:.4}, {y:.4}, {z:.4}]{ur})")?;
    if let Some([xx, xy, xz, yy, yz, zz]) = inertia {
        let franka = format!("{{{xx:.5}, {xy:.5}, {xz:.5}, {xy:.5}, {yy:.5}, {yz:.5}, {xz:.5}, {yz:.5}, {zz:.5}}}");
        writeln!(f, "Franka  setLoad({mass:.4}, {{{x:.4}, {y:.4}, {z:.4}}}, {franka})")?;
    }
    writeln!(f, "KUKA    M {mass:.4}, X {x_mm:.1}, Y {y_mm:.1}, Z {z_mm:.1} (mm)")?;
    writeln!(f, "xArm    set_tcp_load({mass:.4}, [{x_mm:.1}, {y_mm:.1}, {z_mm:.1}])")?;
    let own = inertia.map_or(String::new(), |[xx, xy, xz, yy, yz, zz]| {
        format!(", inertia: {{xx: {xx:.5}, xy: {xy:.5}, xz: {xz:.5}, yy: {yy:.5}, yz: {yz:.5}, zz: {zz:.5}}}")
    });
    writeln!(f, "rist    {{link: {link}, mass: {mass:.4}, centre_of_mass: [{x:.4}, {y:.4}, {z:.4}]{own}}}")
}

impl Load {
    /// The parameters, the centre of mass, and the words of controllers.
    pub(crate) fn tell(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (x, sigma) = (&self.parameters, &self.sigma);
        for (k, inertial) in Inertial::BODY.into_iter().enumerate() {
            let name = inertial.letters();
            let unit = ["kg m^2", "kg m", "kg"][usize::from(k > 5) + usize::from(k > 8)];
            if self.determined[k] {
                writeln!(f, "{name:<3} {:>12.5} +- {:.5} {unit}", x[k], sigma[k])?;
            } else {
                writeln!(f, "{name:<3} not identifiable from these logs")?;
            }
        }
        let (mass, certain) = (x[9], INTERVAL * sigma[9]);
        if self.determined[9] && mass.abs() <= certain {
            writeln!(f, "zero is within the 95 % interval of its mass: there is no load, or the logs do not tell")?;
        } else if self.is_whole && smallest_eigenvalue(x) < 0.0 {
            writeln!(f, "no body has these parameters: its inertia is not known well enough")?;
        }
        let is_point = self.determined[6..].iter().all(|d| *d) && mass > certain;
        let centre = [6, 7, 8].map(|k| x[k] / mass);
        if is_point {
            let [x, y, z] = centre;
            writeln!(f, "{mass:.4} kg, centre of mass ({x:.4}, {y:.4}, {z:.4}) m")?;
        }
        match self.body() {
            Some(body) => words_of_controllers(f, &self.link, body.mass, body.centre, Some(body.inertia)),
            // A centre of mass is told in the frame of the file, which takes all ten parameters to turn into.
            None if is_point && self.in_file_frame && !self.is_whole => {
                words_of_controllers(f, &self.link, mass, centre, None)
            }
            None => Ok(()),
        }
    }
}

impl fmt::Display for Load {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let frame = if self.is_whole { "the link as the model's file has it" } else { "the link's modified DH frame" };
        writeln!(f, "\nload on {}, in and about the frame of {frame}:", self.link)?;
        self.tell(f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn load(parameters: Ten) -> Load {
        Load {
            link: "tool0".into(),
            is_whole: true,
            parameters,
            sigma: [1e-4; 10],
            determined: [true; 10],
            in_file_frame: true,
        }
    }

    /// 2 kg at (0.1, 0, 0.2) with 0.01 0.02 0.025 about it: the blocks have it back, in each order.
    #[test]
    fn a_load_is_told_in_the_words_of_controllers() {
        let (m, [x, z]) = (2.0, [0.1, 0.2]);
        let about_origin = [0.01 + m * z * z, 0.0, -m * x * z, 0.02 + m * (x * x + z * z), 0.0, 0.025 + m * x * x];
        let [xx, xy, xz, yy, yz, zz] = about_origin;
        let shown = load([xx, xy, xz, yy, yz, zz, m * x, 0.0, m * z, m]).to_string();
        for line in [
            "UR      set_target_payload(2.0000, [0.1000, 0.0000, 0.2000], [0.01000, 0.02000, 0.02500, 0.00000, ",
            "Franka  setLoad(2.0000, {0.1000, 0.0000, 0.2000}, {0.01000, ",
            "KUKA    M 2.0000, X 100.0, Y 0.0, Z 200.0 (mm)",
            "xArm    set_tcp_load(2.0000, [100.0, 0.0, 200.0])",
            "rist    {link: tool0, mass: 2.0000, centre_of_mass: [0.1000, 0.0000, 0.2000], inertia: {xx: 0.01000, ",
        ] {
            assert!(shown.contains(line), "{line}\n{shown}");
        }
    }

    #[test]
    fn what_is_no_body_is_told_to_nobody() {
        for parameters in [[-0.1, 0.0, 0.0, 0.1, 0.0, 0.1, 0.0, 0.0, 0.0, 2.0], [0.0; 10]] {
            let shown = load(parameters).to_string();
            assert!(!shown.contains("set_target_payload"), "{shown}");
        }
    }
}
