//! Makes a kinematic calibration from a table of postures: fits the errors of the geometry, looks for mistakes in the table,
//! and judges the fit by its errors on postures that were left out.
//!
//! Three fits (levels) follow each other, each with more parameters: the frames of base and tool alone, then also the zeros of
//! the joints, then the geometry or the compliances, if the user asked for one of them.
//!
//! A posture is one row of the table: joint positions with a measurement of the tool. The tip is the measured link. A zero is
//! the error of a joint position; a compliance is the rotation of a joint per holding torque (the torque that holds the robot
//! at rest).

use std::path::Path;

use logs::Table;
use numerics::student::two_sided_quantile;
use rist::Error;
use robot::{Format, LinkId, Robot};

use crate::base_geometry::geometric_base;
use crate::chain::{Chain, Convention};
use crate::corrections::CalibrationOptions;
use crate::fit::Noise;
use crate::level::{Level, far_zeros};
use crate::measurement::{Posture, Problem};
use crate::mistakes::{Mistake, mistakes, share};
use crate::parameter::{Parameter, ParameterGroup, ParameterNames};
use crate::pose_table::{PoseTable, slides};
use crate::request::{CalibrateRequest, Calibrated, ErrorNames};
use crate::start::{ZERO_STARTS, start};
use crate::verdict::{CalibrationVerdict, verdict};

/// Noise that the first fit assumes, m and rad.
const FIRST_NOISE: Noise = Noise { length: 5e-3, angle: 5e-3 };
/// Largest number of links that are tried as the measured link.
const MAX_TIPS: usize = 30;
/// Level of the printed intervals.
const LEVEL: f64 = 0.95;

/// The holding torques of all coordinates at a position of all coordinates and a mass of the load, N m (N).
pub type HoldingTorque<'a> = &'a dyn Fn(&[f64], f64) -> Vec<f64>;

/// The result of a calibration.
pub struct Calibration {
    /// The measurements and the chain, with the corrections applied.
    pub problem: Problem,
    /// The names of the parameters.
    pub names: ParameterNames,
    /// Name of the measured link.
    pub tip: String,
    /// The fits (levels): frames alone, then with zeros, then with the geometry or the compliances if the user asked for one
    /// of them.
    pub levels: Vec<Level>,
    /// Mistakes in the table.
    pub mistakes: Vec<Mistake>,
    /// Number of rows that are not used, because a number is missing.
    pub left_out_rows: usize,
    /// Notes on how the table was read.
    pub notes: Vec<String>,
    /// Whether the result can be used, with the claims that support it.
    pub verdict: CalibrationVerdict,
}

/// A calibrated parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct CalibratedParameter {
    /// The parameter.
    pub parameter: Parameter,
    /// Printed name of the parameter.
    pub name: String,
    /// The fitted value; for frames the value is in [`crate::Fit::unknowns`], and this is 0.
    pub value: f64,
    /// Standard deviation.
    pub sigma: f64,
    /// Half of the 95 % interval.
    pub interval: f64,
    /// Unit of the value.
    pub unit: &'static str,
}

/// The link with most joints before it; the last one if there are several.
fn default_tip(robot: &Robot) -> Option<LinkId> {
    let depth = |&j: &LinkId| {
        let above = std::iter::successors(Some(j), |&j| robot.link(j).antecedent);
        above.filter(|&j| !robot.link(j).joint.variable.terms.is_empty()).count()
    };
    robot.link_ids().max_by_key(depth)
}

/// The link that carries a link or frame of this name.
fn named_tip(robot: &Robot, name: &str) -> Result<LinkId, Error> {
    let carries = |&j: &LinkId| {
        let link = robot.link(j);
        link.name == name || link.frames.iter().any(|(frame, _)| frame == name)
    };
    robot.link_ids().find(carries).ok_or_else(|| {
        let known: Vec<&str> = robot.links.iter().map(|link| link.name.as_str()).collect();
        Error::new(format_args!("[tip]: the robot has no link `{name}`; it has {}", known.join(", ")))
    })
}

/// The names of links, joints and coordinates that are needed to print parameters of a robot.
pub(crate) fn names_of(robot: &Robot, points: usize) -> ParameterNames {
    ParameterNames {
        coordinates: robot.coordinates.iter().map(|c| c.name.clone()).collect(),
        slides: (0..robot.n_coordinates()).map(|k| slides(robot, k)).collect(),
        labels: robot.links.iter().map(|link| link.label.clone()).collect(),
        joints: robot.links.iter().map(|link| link.joint.name.clone()).collect(),
        has_markers: points > 1,
    }
}

/// The chain that a request asks for.
///
/// Fails if the link is unknown, or if a loop moves the chain.
pub fn chain_of(robot: &Robot, request: &CalibrateRequest) -> Result<Chain, Error> {
    let tip = match &request.tip {
        Some(name) => named_tip(robot, name)?,
        None => default_tip(robot).ok_or_else(|| Error::new("the robot has no link"))?,
    };
    let by_format = if robot.format == Format::Urdf { ErrorNames::Frames } else { ErrorNames::Dh };
    let convention = match request.names.unwrap_or(by_format) {
        ErrorNames::Dh => Convention::Dh,
        ErrorNames::Frames => Convention::Frames,
    };
    Chain::new(robot, tip, convention)
}

/// Calibrates a robot from a file of postures. `torque`: holding torques, which only stiffness needs.
///
/// Fails if the file cannot be read, if columns are missing, or if there are too few postures.
pub fn calibrate(
    robot: &Robot,
    path: &Path,
    request: &CalibrateRequest,
    torque: Option<HoldingTorque>,
) -> Result<Calibration, Error> {
    calibrate_table(robot, &Table::read(path)?, request, torque)
}

/// Calibrates a robot from a table of postures; fails like [`calibrate`].
pub fn calibrate_table(
    robot: &Robot,
    table: &Table,
    request: &CalibrateRequest,
    torque: Option<HoldingTorque>,
) -> Result<Calibration, Error> {
    if request.design.is_some() {
        return Err(Error::new("[design] chooses postures that are still to be measured: leave the table out"));
    }
    let chain = chain_of(robot, request)?;
    let options = request.options.clone().unwrap_or_default();
    let read = PoseTable::of_table(table, robot, &chain.coordinates, &options, request.touched)?;
    let mut postures = read.postures(&options.corrections)?;
    // A compliance is the rotation per holding torque. So a fit of stiffness needs the holding torques at all postures.
    if request.what == Calibrated::Stiffness {
        let torque =
            torque.ok_or_else(|| Error::new("[what=stiffness] needs the bodies of the description, or [estimate]"))?;
        hold(robot, &chain, &read, &mut postures, torque);
    }
    let tip = chain.links.last().map_or(String::new(), |&j| robot.link(j).name.clone());
    let problem = Problem::new(chain, read.kind, postures);
    let names = names_of(robot, read.kind.points());
    // The table contains no information on the gear scale of a joint that does not move the measured link.
    if let Some(name) = request.gears.iter().find(|name| !read.coordinates.contains(name)) {
        let known = read.coordinates.join(", ");
        return Err(Error::new(format_args!("[gears]: no joint `{name}` moves the measured link; these do: {known}")));
    }
    // A wrong measured link is one of the possible mistakes. The other links are tried only if the errors are large.
    let tips = || other_tips(robot, table, &problem, &options, request);
    let (levels, found) = fitted(robot, &problem, &read, &tips, request)?;
    let verdict = verdict(robot, &problem, &names, &levels, &found);
    let (left_out_rows, notes) = (read.left_out, read.notes.clone());
    Ok(Calibration { problem, names, tip, levels, mistakes: found, left_out_rows, notes, verdict })
}

/// For each other link that could be the measured one: the same postures with this link as the measured link. Links with the
/// same joints before them as the measured link are left out.
fn other_tips<'a>(
    robot: &'a Robot,
    table: &Table,
    problem: &Problem,
    options: &CalibrationOptions,
    request: &CalibrateRequest,
) -> Vec<(&'a str, Problem)> {
    let of_tip = |tip: LinkId| {
        let chain = Chain::new(robot, tip, problem.chain.convention()).ok()?;
        let read = PoseTable::of_table(table, robot, &chain.coordinates, options, request.touched).ok()?;
        let is_other = chain.coordinates != problem.chain.coordinates;
        let postures = read.postures(&options.corrections).ok().filter(|_| is_other)?;
        Some((robot.link(tip).name.as_str(), Problem::new(chain, read.kind, postures)))
    };
    robot.link_ids().take(MAX_TIPS).filter_map(of_tip).collect()
}

/// Sets the holding torques of the postures.
fn hold(robot: &Robot, chain: &Chain, table: &PoseTable, postures: &mut [Posture], torque: HoldingTorque) {
    for (posture, load) in postures.iter_mut().zip(table.loads()) {
        let mut q = vec![0.0; robot.n_coordinates()];
        chain.coordinates.iter().zip(&posture.q).for_each(|(k, x)| q[*k] = *x);
        let all = torque(&q, load);
        posture.torque = chain.coordinates.iter().map(|&k| all[k]).collect();
    }
}

/// The groups of parameters of a level.
fn groups(what: &str) -> &'static [ParameterGroup] {
    use ParameterGroup::{Compliances, Frames, Geometry, Zeros};
    match what {
        "frames" => &[Frames],
        "zeros" => &[Frames, Zeros],
        "geometry" => &[Frames, Zeros, Geometry],
        _ => &[Frames, Zeros, Compliances],
    }
}

/// Fits the levels from a common start, and looks for mistakes in the table.
fn fitted<'a>(
    robot: &Robot,
    problem: &Problem,
    table: &PoseTable,
    tips: &dyn Fn() -> Vec<(&'a str, Problem)>,
    request: &CalibrateRequest,
) -> Result<(Vec<Level>, Vec<Mistake>), Error> {
    let is_gear = |p: Parameter| match p {
        Parameter::Gear { coordinate } => request.gears.contains(&robot.coordinates[coordinate].name),
        _ => false,
    };
    let base_of = |what: &str| {
        let is_fitted = |p: Parameter| groups(what).contains(&p.group()) || (what != "frames" && is_gear(p));
        geometric_base(robot, problem, is_fitted)
    };
    let of_zeros = base_of("zeros")?;
    let rows = problem.linearised(&problem.nominal()).residual.len();
    if rows <= of_zeros.kept.len() {
        let message = format!(
            "{}: {} postures give {rows} numbers, for {} unknowns of frames and zeros: measure more postures",
            table.name,
            problem.postures.len(),
            of_zeros.kept.len()
        );
        return Err(Error::new(message));
    }
    let first = start(problem, &of_zeros.kept, ZERO_STARTS);
    let corrections = request.options.clone().unwrap_or_default().corrections;
    // If a fitted zero is far off, the real cause may be a reversed sign. Then the search for mistakes starts from the error
    // of a fit whose zeros stay near the zeros of the description.
    let as_given = match far_zeros(problem, &first).is_empty() {
        true => share(problem, &first),
        false => share(problem, &start(problem, &of_zeros.kept, 0)),
    };
    let found = mistakes(robot, problem, table, tips, &corrections, as_given)?;
    let asked = match request.what {
        Calibrated::Zeros => None,
        Calibrated::Geometry => Some("geometry"),
        Calibrated::Stiffness => Some("stiffness"),
    };
    let (mut levels, mut from): (Vec<Level>, _) = (Vec::new(), (first.clone(), FIRST_NOISE));
    // In the level of the frames alone, the robot has no errors, so its start has no zero errors either.
    let nominal = start(problem, &base_of("frames")?.kept, 0);
    levels.push(Level::fitted(problem, "frames", base_of("frames")?, &(nominal, FIRST_NOISE))?);
    for what in ["zeros"].into_iter().chain(asked) {
        let next = Level::fitted(problem, what, base_of(what)?, &from)?;
        if what == "zeros" {
            from = (next.fit.unknowns.clone(), next.fit.noise);
        }
        levels.push(next);
    }
    Ok((levels, found))
}

impl Calibration {
    /// The fit that was asked for.
    ///
    /// # Panics
    /// Never: a calibration has at least two levels.
    pub fn level(&self) -> &Level {
        &self.levels[self.levels.len() - 1]
    }

    /// The fit that predicts best on postures that were left out.
    pub fn recommended(&self) -> &Level {
        &self.levels[self.verdict.recommended]
    }

    /// The fitted parameters of a level, with their intervals by Student's distribution.
    pub fn parameters(&self, level: &Level) -> Vec<CalibratedParameter> {
        let (fit, frames) = (&level.fit, self.problem.frames());
        let quantile = two_sided_quantile(1.0 - LEVEL, fit.freedom);
        let parameter = |(place, &k): (usize, &usize)| {
            let (parameter, sigma) = (self.problem.parameters[k], fit.covariance[(place, place)].max(0.0).sqrt());
            CalibratedParameter {
                parameter,
                name: self.names.of(parameter).to_string(),
                value: k.checked_sub(frames).map_or(0.0, |k| fit.unknowns.chain[k]),
                sigma,
                interval: quantile * sigma,
                unit: self.names.unit(parameter),
            }
        };
        fit.active.iter().enumerate().map(parameter).collect()
    }

    /// Lines of the file with the postures that the fit of a level leaves out.
    pub fn outliers(&self, level: &Level) -> Vec<usize> {
        let postures = self.problem.postures.iter().zip(&level.fit.used);
        postures.filter(|(_, used)| !**used).map(|(posture, _)| posture.line).collect()
    }
}
