//! `rist identify --loaded`: what the last link carries, from logs with it beside logs without.

use std::fmt::Write as _;

use identification::estimate::identify::Fit;
use identification::estimate::options::Options;
use identification::estimators::payload::payload;
use identification::model::linear_model::Model;
use identification::model::pseudo_inertia::{Ten, centroidal, smallest_eigenvalue};
use identification::rows::observation::Observation;
use identification::signals::records::SourceRecords;
use logs::LogSource;
use nalgebra::DMatrix;
use robot::{LinkId, transform_inertial};

use crate::failure::Failure;
use crate::model::{body_links, standard_map};
use crate::spectrum::Subject;

/// The load in the loaded logs, in words and numbers: in the link's frame as the model's file has it where all of it is
/// known.
pub fn load(
    link: Option<&str>,
    subject: &Subject,
    fit: &Fit,
    loaded: &[LogSource],
    options: &Options,
) -> Result<String, Failure> {
    let (regressor, robot) = (subject.regressor.as_ref(), &subject.robot);
    let parameters = &subject.derived.parameters;
    let index = body(link, subject)?;
    let couplings = options.transmission.coupled();
    let model = Model::new(regressor, &options.friction, &couplings);
    let records = SourceRecords::new(regressor, loaded, &options.preparation())?;
    let with = Observation::of_records(&model, &records, None)?.joints(|_| true);
    let without = fit.observation.joints(|_| true);
    let found = payload(&without, &with, &fit.weights, &standard_map(robot, parameters), index)?;
    let id = body_links(parameters)[index];
    let whole = found.determined.iter().all(|d| *d);
    // x' = T x: columns of T are the unit parameters in the other frame.
    let to_file = robot.link(id).file_frame.inverse();
    let unit = |k: usize| -> Ten { std::array::from_fn(|i| f64::from(i == k)) };
    let turned: Vec<Ten> = (0..10).map(|k| transform_inertial(&unit(k), &to_file)).collect();
    let frame = if whole { DMatrix::from_fn(10, 10, |i, k| turned[k][i]) } else { DMatrix::identity(10, 10) };
    let x: Ten = std::array::from_fn(|i| (0..10).map(|k| frame[(i, k)] * found.parameters[k]).sum());
    let covariance = &frame * &found.covariance * frame.transpose();
    // Residuals of logs stay the same for a while: intervals are wider than for white noise.
    let widening = fit.estimate.discount().sqrt();
    let sigma: Ten = std::array::from_fn(|i| widening * covariance[(i, i)].max(0.0).sqrt());
    let name = &robot.link(id).name;
    let frame = if whole { "the link as the model's file has it" } else { "the link's modified DH frame" };
    let mut text = format!("\nload on {name}, in and about the frame of {frame}:\n");
    for (k, name) in ["XX", "XY", "XZ", "YY", "YZ", "ZZ", "MX", "MY", "MZ", "M"].iter().enumerate() {
        let unit = ["kg m^2", "kg m", "kg"][usize::from(k > 5) + usize::from(k > 8)];
        let _ = if found.determined[k] {
            writeln!(text, "{name:<3} {:>12.5} +- {:.5} {unit}", x[k], sigma[k])
        } else {
            writeln!(text, "{name:<3} not identifiable from these logs")
        };
    }
    if found.determined[9] && x[9].abs() <= 2.0 * sigma[9] {
        text.push_str("its mass is zero within two sigma: there is no load, or the logs do not tell\n");
    } else if whole && smallest_eigenvalue(&x) < 0.0 {
        text.push_str("no body has these parameters: its inertia is not known well enough\n");
    }
    if let Some(c) = centroidal(&x).filter(|_| whole && x[9] > 2.0 * sigma[9]) {
        let [x, y, z] = c.centre;
        let _ = writeln!(text, "{:.4} kg, centre of mass ({x:.4}, {y:.4}, {z:.4}) m", c.mass);
    }
    Ok(text)
}

/// The body that carries the load: the one named (or carrying a fixed link of that name), else the only last one.
fn body(link: Option<&str>, subject: &Subject) -> Result<usize, Failure> {
    let robot = &subject.robot;
    let ids = body_links(&subject.derived.parameters);
    let name = |id: &LinkId| robot.link(*id).name.as_str();
    let listed = |ids: &[LinkId]| ids.iter().map(name).collect::<Vec<_>>().join(", ");
    match link {
        Some(wanted) => {
            let carries = |id: &LinkId| name(id) == wanted || robot.link(*id).parts.iter().any(|p| p.name == wanted);
            ids.iter().position(carries).ok_or_else(|| {
                Failure::new(format_args!("--loaded-link: there is no link `{wanted}`; there are {}", listed(&ids)))
            })
        }
        None => {
            let last = |id: &LinkId| robot.links.iter().all(|other| other.antecedent != Some(*id));
            let ends: Vec<LinkId> = ids.iter().copied().filter(last).collect();
            match ends.as_slice() {
                [end] => Ok(ids.iter().position(|id| id == end).unwrap_or(0)),
                _ => Err(Failure::new(format_args!(
                    "which link carries the load? the robot ends in {}; name one with --loaded-link, of {}",
                    listed(&ends),
                    listed(&ids)
                ))),
            }
        }
    }
}
