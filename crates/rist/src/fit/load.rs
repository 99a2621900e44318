//! Identifies the load on a link, from logs with the load and logs without it.
//!
//! The ten parameters of the load are the differences between the body with load and the body without it. Two errors are
//! considered: noise, and the scale of the torques (if all torques are 2 % too large, so is the load). T transforms the
//! parameters from the link frame to the frame of the user's file.

use std::fmt;

use identification::estimate::claims::common_factor_shown;
use identification::estimate::claims::hypotheses::{Hypothesis, HypothesisTest};
use identification::estimate::identified::INTERVAL;
use identification::estimate::identify::{Fit, with_deviations};
use identification::estimate::log_check::LogCheck;
use identification::estimate::options::Options;
use identification::estimators::drive_gains::likelihood::DriveGains;
use identification::estimators::payload::payload;
use identification::rows::observation::Observation;
use identification::signals::records::SourceRecords;
use linear_model::pseudo_inertia::{Centroidal, Ten, centroidal, smallest_eigenvalue};
use linear_model::standard_map::StandardMap;
use logs::LogSource;
use nalgebra::DMatrix;
use robot::{Inertial, LinkId, transform_inertial};

use crate::describe::model::Model;
use crate::error::Error;

/// An identified load with its uncertainty.
pub struct Load {
    /// The link that carries the load.
    pub link: String,
    /// Whether all ten parameters are determined. If so, the parameters are in the link frame of the robot's file; otherwise in
    /// the modified DH frame of the link.
    pub is_whole: bool,
    /// The parameters XX XY XZ YY YZ ZZ (kg m^2), MX MY MZ (kg m), M (kg) about the frame's origin.
    pub parameters: Ten,
    /// Standard deviations of the parameters. They include the autocorrelation of the residuals.
    pub sigma: Ten,
    /// For each parameter, whether the logs determine it.
    pub determined: [bool; 10],
    /// How the scale of the parameters is known.
    pub scale: LoadScale,
    /// Whether all parameters that are determined are in the frame of the user's file, even if some are not determined.
    pub in_file_frame: bool,
}

/// The source of the scale of a load. If the scale of the torques is wrong by some per cent, all ten parameters of the load are
/// wrong by the same percentage.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LoadScale {
    /// The scale comes from a force sensor. The verdict on the sensor also covers its scale.
    Sensor,
    /// The scale comes from torques as logged, or from given gains. The number is the smallest common factor that the log check
    /// would have detected; `None` if the log check would have detected no factor.
    AsLogged(Option<f64>),
    /// The scale comes from estimated drive gains. The standard deviation of the load includes the standard deviations of these
    /// gains.
    Gains,
}

/// Evidence on scale errors of the torques in a fit: estimated gains, tested faults, and the log check.
pub(crate) struct Scales<'a> {
    pub(crate) gains: Option<&'a DriveGains>,
    pub(crate) faults: &'a [HypothesisTest],
    pub(crate) log_check: &'a LogCheck,
}

impl Scales<'_> {
    /// Covariance (n x n) of the relative scale errors of the joints' torques: from the estimated gains, or else, joint by
    /// joint, from the scales that the fit tested.
    fn covariance(&self, n: usize) -> DMatrix<f64> {
        if let Some(gains) = self.gains {
            let sigma: Vec<f64> = gains.gain_deviation.iter().zip(&gains.gain).map(|(s, k)| s / k.abs()).collect();
            let rows = with_deviations(&gains.gain_covariance, &sigma);
            return DMatrix::from_fn(n, n, |i, j| rows[i][j]);
        }
        let square = |k: usize| {
            let tested_scale = self.faults.iter().find(|f| f.of == Hypothesis::Scale(k) && f.deviation.is_finite());
            tested_scale.map_or(0.0, |f| f.value.powi(2) + f.deviation.powi(2))
        };
        DMatrix::from_fn(n, n, |i, j| if i == j { square(i) } else { 0.0 })
    }
}

/// Identifies the load in the logs `loaded`. The covariance of the load is the sum of two terms: noise in the residuals, and
/// scale errors of the joints' torques.
///
/// Fails if the link does not exist or is ambiguous, or if the logs cannot be read.
pub(crate) fn load(
    model: &Model,
    map: &StandardMap,
    link: Option<&str>,
    fit: &Fit,
    loaded: &[LogSource],
    options: &Options,
    scales: &Scales,
) -> Result<Load, Error> {
    let index = body(model, link)?;
    let linear = options.linear_model(model.regressor());
    let of_scales = scales.covariance(linear.n());
    let records = SourceRecords::new(model.regressor(), loaded, &options.preparation())?;
    let with = Observation::of_records(&linear, &records, None)?.joints(|_| true);
    let without = fit.observation.joints(|_| true);
    let found = payload(&without, &with, &fit.weights, map, index)?;
    let carrier = model.robot.link(model.body_links()[index]);

    // In the file's frame, the parameters are x' = T x. Column k of T is the transformed unit vector k.
    let is_whole = found.determined.iter().all(|d| *d);
    let to_file = carrier.file_frame.inverse();
    let unit = |k: usize| -> Ten { std::array::from_fn(|i| f64::from(i == k)) };
    let turned: Vec<Ten> = (0..10).map(|k| transform_inertial(&unit(k), &to_file)).collect();
    let frame = if is_whole { DMatrix::from_fn(10, 10, |i, k| turned[k][i]) } else { DMatrix::identity(10, 10) };
    let parameters = std::array::from_fn(|i| (0..10).map(|k| frame[(i, k)] * found.parameters[k]).sum());
    // Cov = T (C d + S R S^T) T^T. T: transformation of the ten parameters into the file's frame (`frame`); C: covariance for
    // white noise; d: discount for the autocorrelation of the residuals; S: derivatives of the parameters with respect to the
    // torque scales; R: covariance of these scales.
    let by_scale = DMatrix::from_fn(10, found.by_scale.len(), |i, j| found.by_scale[j][i]);
    let of_scales = &by_scale * of_scales * by_scale.transpose();
    let covariance = &frame * (&found.covariance * fit.estimate.discount() + of_scales) * frame.transpose();
    let sigma = std::array::from_fn(|i| covariance[(i, i)].max(0.0).sqrt());
    let scale = match scales.gains {
        Some(_) => LoadScale::Gains,
        None => LoadScale::AsLogged(common_factor_shown(scales.log_check)),
    };
    let determined = std::array::from_fn(|i| found.determined[i]);
    Ok(Load { link: carrier.name.clone(), is_whole, parameters, sigma, determined, scale, in_file_frame: is_whole })
}

/// Index of the body that carries the load: the named body, or the body to which a link of this name is fixed. Without a name,
/// the last body of the chain carries the load; this fails if the robot has several last bodies.
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
    let last = last_bodies(model);
    let ends: Vec<LinkId> = last.iter().map(|body| ids[*body]).collect();
    match last.as_slice() {
        [end] => Ok(*end),
        _ => Err(Error::new(format_args!(
            "which link carries the load? the robot ends in {}; name one with [loaded_link], of {}",
            listed(&ends),
            listed(&ids)
        ))),
    }
}

/// Indices of the bodies at the ends of the chains, to which no other link is attached.
pub(crate) fn last_bodies(model: &Model) -> Vec<usize> {
    let ids = model.body_links();
    let is_last = |body: &usize| model.robot.links.iter().all(|other| other.antecedent != Some(ids[*body]));
    (0..ids.len()).filter(is_last).collect()
}

impl Load {
    /// The 95 % interval of the mass, kg, including a common factor of the torques that the log check would not detect. `None`
    /// if this factor has no bound.
    pub fn mass_interval(&self) -> Option<[f64; 2]> {
        let factor = match self.scale {
            LoadScale::AsLogged(factor) => factor?,
            LoadScale::Sensor | LoadScale::Gains => 1.0,
        };
        let (mass, certain) = (self.parameters[9], INTERVAL * self.sigma[9]);
        Some([(mass - certain) / factor, (mass + certain) * factor])
    }

    /// A sentence on how the load's scale is known; `None` for a force sensor.
    fn of_scale(&self) -> Option<String> {
        let logged = "in the units of the torques as logged: a common factor";
        Some(match (self.scale, self.mass_interval()) {
            (LoadScale::Sensor, _) => return None,
            (LoadScale::Gains, _) => {
                "these include sigma of the drive gains; all rest on the gains that were given".into()
            }
            (LoadScale::AsLogged(Some(factor)), Some([from, to])) => format!(
                "{logged} below {} would not have shown, by which the mass is between {from:.3} and {to:.3} kg",
                claims::significant(factor, 3)
            ),
            (LoadScale::AsLogged(_), _) => format!("{logged} of any size would not have shown"),
        })
    }

    /// Mass (kg), centre of mass (m) and inertia about the centre of mass (kg m^2), in the axes of the link frame of the robot's
    /// file. `None` if a parameter is not determined, if the mass is not significant, or if the body is physically impossible.
    pub fn body(&self) -> Option<Centroidal> {
        let is_determined = self.is_whole && self.parameters[9].abs() > INTERVAL * self.sigma[9];
        let can_exist = smallest_eigenvalue(&self.parameters) >= 0.0;
        centroidal(&self.parameters).filter(|_| is_determined && can_exist)
    }
}

/// Writes a load in the syntax of robot controllers. Each takes the centre of mass (m) and the inertia about it (kg m^2), in
/// the axes of its flange. If the inertia is unknown, only controllers that do not need it are listed.
///
/// UR: set_target_payload(m, cog, [Ixx, Iyy, Izz, Ixy, Ixz, Iyz]). Franka: setLoad with the nine entries by columns. KUKA:
/// centre in mm. xArm: set_tcp_load with kg and mm, without an inertia. The last line is the file of rist's own `load`.
fn words_of_controllers(
    f: &mut fmt::Formatter<'_>,
    link: &str,
    mass: f64,
    centre: [f64; 3],
    inertia: Option<[f64; 6]>,
) -> fmt::Result {
    // Rounded to the printed digits. Adding 0 turns -0 into 0.
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
    /// Writes the parameters and the centre of mass. If `may_be_used`, also writes the load in the syntax of controllers.
    pub fn tell(&self, f: &mut fmt::Formatter<'_>, may_be_used: bool) -> fmt::Result {
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
            writeln!(
                f,
                "zero is within the 95 % interval of its mass: there is no load, or the logs do not identify it"
            )?;
        } else if self.is_whole && smallest_eigenvalue(x) < 0.0 {
            writeln!(f, "no body has these parameters: its inertia is not known well enough")?;
        }
        let is_point = self.determined[6..].iter().all(|d| *d) && mass > certain;
        let centre = [6, 7, 8].map(|k| x[k] / mass);
        if is_point {
            let [x, y, z] = centre;
            writeln!(f, "{mass:.4} kg, centre of mass ({x:.4}, {y:.4}, {z:.4}) m")?;
        }
        let is_there = self.determined[9] && mass > certain;
        self.of_scale().filter(|_| is_there).iter().try_for_each(|sentence| writeln!(f, "{sentence}"))?;
        match self.body() {
            _ if !may_be_used => Ok(()),
            Some(body) => words_of_controllers(f, &self.link, body.mass, body.centre, Some(body.inertia)),
            // If not all ten parameters are determined, the load cannot be transformed into the file's frame. Mass and centre
            // of mass are then written only if they are already in that frame.
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
        self.tell(f, true)
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
            scale: LoadScale::AsLogged(Some(1.25)),
            in_file_frame: true,
        }
    }

    /// Load: 2 kg at (0.1, 0, 0.2) m with inertias 0.01, 0.02 and 0.025 kg m^2 about the centre of mass. Each syntax has its
    /// own order of these values.
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
            "a common factor below 1.25 would not have shown, by which the mass is between 1.600 and 2.500 kg\n",
        ] {
            assert!(shown.contains(line), "{line}\n{shown}");
        }
        // If estimated gains or a sensor give the scale of the load, no common factor is mentioned.
        for scale in [LoadScale::Gains, LoadScale::Sensor] {
            let other = Load { scale, ..load([xx, xy, xz, yy, yz, zz, m * x, 0.0, m * z, m]) };
            assert!(!other.to_string().contains("factor"), "{other}");
            assert!(other.mass_interval().unwrap()[0] > 1.999);
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
