//! Identification from a robot at rest: gravity parameters; with the nominal bodies also zero errors and the base orientation
//! (mount).
//!
//! ```text
//! tau_j = sum_c G_jc(q) X_c + OFF_j                            gravity parameters X, one offset OFF per joint
//! tau_j = sum_i g_i T_ij(q + z) + OFF_j     |g| nominal        zero errors z and gravity g, nominal bodies
//! ```
//! G is the base regressor at rest, without columns that are zero or linear combinations of other columns at every posture. The
//! parameters of such columns are combined with other parameters. T_i is the torque of the nominal bodies under gravity along
//! axis i of the base. The rows of a joint are weighted by the standard deviation of its residual, which includes friction at
//! rest. Standard deviations are from least squares. In the first equation, with free parameters X, no zero error is
//! identifiable, because rotated first moments are equivalent to a rotated joint.

mod fit;
mod mistakes;
mod placement;
mod turned_joint;

use std::fmt;

use claims::significant;
use identification::estimate::options::Options;
use identification::signals::transmission::Transmission;
use linear_model::parameter::Parameter;
use logs::{Effort, Postures};
use modeling::independent_columns;
use nalgebra::{DMatrix, DVector};
use random::Random;
use serde_json::{Value, json};

use crate::postures::fit::PostureFit;
pub use crate::postures::fit::ValueWithSigma;
pub use crate::postures::mistakes::Mistake;
pub use crate::postures::placement::ZerosAndMount;
use crate::postures::placement::{looks_for_mistakes, placed};
use rist::Error;
use rist::Model;

/// A dependent column of the regressor is a linear combination of other columns. A coefficient of this combination counts as
/// zero if it is below this value.
const ZERO_SHARE: f64 = 1e-8;
/// A direction in the space of the parameters is not identifiable if its singular value is below this fraction of the largest
/// one.
const NOT_IDENTIFIABLE: f64 = 1e-6;
/// Least number of random postures at which the independent columns of the regressor are found. `ROWS_PER_PARAMETER`: rows per
/// parameter.
const MIN_RANDOM_POSTURES: usize = 20;
const ROWS_PER_PARAMETER: usize = 4;
/// Range of prismatic joints at the random postures, m.
const SLIDING_RANGE_M: f64 = 0.5;

/// A gravity parameter: a base parameter, or a combination of base parameters.
pub struct GravityParameter {
    /// The base parameter, then the parameters that no posture can separate from it, with their factors.
    pub name: String,
    /// The SI unit: `kg m` or `kg`.
    pub unit: String,
    column: usize,
    /// Indices of the other columns in the combination, with their factors.
    with: Vec<(usize, f64)>,
}

/// The gravity parameters of a model: all parameters that holding torques at rest can determine.
///
/// Fails if the base regressor has no finite value at rest.
pub fn gravity_parameters(model: &Model) -> Result<Vec<GravityParameter>, Error> {
    let regressor = model.regressor();
    let (n, p) = (regressor.coordinates().len(), regressor.parameters().len());
    // Columns that are dependent at random postures are dependent at all postures.
    let mut random = Random::new(1);
    let mut rows = Vec::new();
    for _ in 0..MIN_RANDOM_POSTURES + ROWS_PER_PARAMETER * p.div_ceil(n.max(1)) {
        let range = |k: usize| if regressor.is_prismatic(k) { SLIDING_RANGE_M } else { std::f64::consts::PI };
        let q: Vec<f64> = (0..n).map(|k| random.between(-range(k), range(k))).collect();
        let y = at_rest(model, &q);
        if y.iter().all(|x| x.is_finite()) {
            rows.extend(y);
        }
    }
    if rows.is_empty() && p > 0 {
        return Err(Error::new("the torques at rest are no numbers at any posture that was tried"));
    }
    let matrix = DMatrix::from_row_slice(rows.len() / p.max(1), p, &rows);
    let columns = independent_columns(&matrix).map_err(|_| {
        Error::new("the torques at rest exceed the range of floating-point numbers at postures that were tried")
    })?;
    let name = |c: usize| Parameter::from(&regressor.parameters()[c]).id.to_string();
    let unit = |c: usize| Parameter::from(&regressor.parameters()[c]).unit().to_string();
    let kept = columns.kept.iter().map(|&c| GravityParameter { name: name(c), unit: unit(c), column: c, with: vec![] });
    let mut kept: Vec<GravityParameter> = kept.collect();
    // A dependent column c of the regressor is the sum of the kept columns, each times a share. So its parameter, times these
    // shares, is added to the parameters of the kept columns.
    for (c, shares) in &columns.dependent {
        for (parameter, share) in kept.iter_mut().zip(shares).filter(|(_, share)| share.abs() > ZERO_SHARE) {
            let sign = if *share < 0.0 { '-' } else { '+' };
            parameter.name += &format!(" {sign} {} {}", significant(share.abs(), 4), name(*c));
            parameter.with.push((*c, *share));
        }
    }
    Ok(kept)
}

/// The base regressor at rest, Y(q, 0, 0), row by row.
fn at_rest(model: &Model, q: &[f64]) -> Vec<f64> {
    let (n, p) = (q.len(), model.regressor().parameters().len());
    let (mut y, rest) = (vec![0.0; n * p], vec![0.0; n]);
    model.regressor().fill(q, &rest, &rest, &mut y);
    y
}

/// The estimate from postures.
pub struct PostureEstimate {
    /// The gravity parameters.
    pub parameters: Vec<GravityParameter>,
    /// Value and standard deviation of each gravity parameter.
    pub values: Vec<ValueWithSigma>,
    /// Nominal value of each gravity parameter; `None` if the model has no inertial parameters.
    pub described: Option<Vec<f64>>,
    /// Names of the joints.
    pub coordinates: Vec<String>,
    /// For each joint, whether it is prismatic. The torque of a prismatic joint is a force (N), and its zero error is a length
    /// (m).
    pub slides: Vec<bool>,
    /// Offset of each joint's torque, with its standard deviation, N m (N).
    pub offsets: Vec<ValueWithSigma>,
    /// Rms residual of each joint's torques, N m (N).
    pub residuals: Vec<f64>,
    /// Rms of each joint's torques, N m (N).
    pub torques: Vec<f64>,
    /// Number of postures.
    pub postures: usize,
    /// Whether the postures are plateaus of a log: intervals in which the robot is at rest.
    pub are_plateaus: bool,
    /// Zero errors and base orientation, estimated with the nominal bodies; `None` if this is not possible.
    pub placed: Option<ZerosAndMount>,
    /// Mistakes in the columns. Each of them alone explains the postures. Empty if there are none.
    pub mistakes: Vec<Mistake>,
}

/// Identifies gravity parameters, zero errors and the base orientation. `options`: the transmission between the table and the
/// joints.
///
/// Fails if there are too few postures, if currents have no gains, or if joints are coupled.
pub fn identify_postures(model: &Model, postures: &Postures, options: &Options) -> Result<PostureEstimate, Error> {
    let parameters = gravity_parameters(model)?;
    let torques = torques(model, postures, options.transmission.drive_gains.as_deref())?;
    let (postures, torques) = at_the_joints(postures, torques, &options.transmission)?;
    let postures = &postures;
    let (n, count) = (model.regressor().coordinates().len(), postures.q.len());
    let p = parameters.len();
    // Each posture gives n rows; at least two rows per unknown are needed.
    if count * n < 2 * (p + n) || count < 4 {
        return Err(Error::new(format_args!(
            "{}: {count} postures of {n} joints for {p} gravity parameters and {n} offsets: at least {} are needed",
            postures.name,
            (2 * (p + n)).div_ceil(n.max(1)).max(4)
        )));
    }
    let fit = free_bodies(model, &parameters, &postures.q, &torques)?;
    let shares = |q: &[Vec<f64>], torques: &[DVector<f64>]| {
        let share =
            |(residual, torque): (&DVector<f64>, &DVector<f64>)| residual.norm_squared() / torque.norm_squared();
        let fit = free_bodies(model, &parameters, q, torques).ok();
        fit.map_or_else(Vec::new, |fit| fit.residuals.iter().zip(torques).map(share).collect())
    };
    // Nominal value of a gravity parameter: X_c of its own column, plus the sum of share times X over the dependent columns.
    let described = model.nominal_parameters().map(|x| {
        let value = |k: &GravityParameter| x[k.column] + k.with.iter().map(|(c, share)| share * x[*c]).sum::<f64>();
        parameters.iter().map(value).collect()
    });
    let size = |x: &DVector<f64>| (x.norm_squared() / count as f64).sqrt();
    // Large zero errors are accepted only if no large zero errors remain after they are corrected.
    let mut placed = placed(model, postures, &torques, &fit.deviations, options)?;
    if let Some(placed) = placed.as_mut().filter(|placed| placed.explains && !placed.is_near()) {
        placed.explains = mends(model, &parameters, (postures, &torques), placed, options)?;
    }
    let mistakes = looks_for_mistakes(model, (postures, &torques), &shares, options, placed.as_ref())?;
    Ok(PostureEstimate {
        values: fit.identified[..p].to_vec(),
        offsets: fit.identified[p..].to_vec(),
        placed,
        mistakes,
        residuals: fit.residuals.iter().map(size).collect(),
        torques: torques.iter().map(size).collect(),
        coordinates: postures.coordinates.clone(),
        slides: (0..n).map(|k| model.regressor().is_prismatic(k)).collect(),
        described,
        postures: count,
        are_plateaus: postures.are_plateaus,
        parameters,
    })
}

/// Whether no large zero error remains after the zeros in `found` are corrected. The standard deviations of the joints come from
/// a fit of bodies with free parameters. Such bodies explain a large zero error badly, so these standard deviations are too large
/// before the correction; they are computed again here.
fn mends(
    model: &Model,
    parameters: &[GravityParameter],
    (postures, torques): (&Postures, &[DVector<f64>]),
    found: &ZerosAndMount,
    options: &Options,
) -> Result<bool, Error> {
    let mut held = postures.clone();
    let zeros: Vec<f64> = found.zeros.iter().map(|value| value.map_or(0.0, |value| value.0)).collect();
    held.q.iter_mut().for_each(|q| q.iter_mut().zip(&zeros).for_each(|(q, zero)| *q += zero));
    let deviations = free_bodies(model, parameters, &held.q, torques)?.deviations;
    let again = placed(model, &held, torques, &deviations, options)?;
    Ok(again.is_some_and(|again| again.explains && again.is_near()))
}

/// Fits gravity parameters and one offset per joint to the torques at the positions `q`.
fn free_bodies(
    model: &Model,
    parameters: &[GravityParameter],
    q: &[Vec<f64>],
    torques: &[DVector<f64>],
) -> Result<PostureFit, Error> {
    let (n, p, all) = (torques.len(), parameters.len(), model.regressor().parameters().len());
    let mut joints: Vec<DMatrix<f64>> = vec![DMatrix::zeros(q.len(), p + n); n];
    for (r, q) in q.iter().enumerate() {
        let y = at_rest(model, q);
        for j in 0..n {
            parameters.iter().enumerate().for_each(|(c, one)| joints[j][(r, c)] = y[j * all + one.column]);
            joints[j][(r, p + j)] = 1.0;
        }
    }
    PostureFit::of(&joints, torques, NOT_IDENTIFIABLE)
}

/// Converts motor values of the table to joint positions and torques: q = q_m / r + q_0, tau = r tau_m / s. r: gear ratio; s:
/// torque scale.
///
/// Fails if a motor moves several joints.
fn at_the_joints(
    postures: &Postures,
    mut torques: Vec<DVector<f64>>,
    transmission: &Transmission,
) -> Result<(Postures, Vec<DVector<f64>>), Error> {
    let n = postures.coordinates.len();
    if !transmission.couplings.is_empty() {
        return Err(Error::new(
            "[options.transmission]: couplings are not known to postures; take a log, and `[:identify]`",
        ));
    }
    transmission.check(n)?;
    let of = |list: &Option<Vec<f64>>, k: usize, none: f64| list.as_ref().map_or(none, |all| all[k]);
    let mut found = postures.clone();
    for k in 0..n {
        let ratio = of(&transmission.ratios, k, 1.0);
        torques[k] *= ratio / of(&transmission.scales, k, 1.0);
        let ratio = if transmission.joint_side_positions { 1.0 } else { ratio };
        found.q.iter_mut().for_each(|q| q[k] = q[k] / ratio + of(&transmission.offsets, k, 0.0));
    }
    Ok((found, torques))
}

/// For each joint, its torques at all postures (N m or N) from the torques or currents in the table.
fn torques(model: &Model, postures: &Postures, gains: Option<&[f64]>) -> Result<Vec<DVector<f64>>, Error> {
    let n = postures.coordinates.len();
    let gains = match (postures.effort_is, gains) {
        (Effort::Torque, _) => vec![1.0; n],
        (_, Some(gains)) => gains.to_vec(),
        (effort, None) => {
            let known: Option<Vec<f64>> = model.drive_gains().into_iter().collect();
            known.ok_or_else(|| {
                Error::new(format_args!(
                    "{}: {} need the gain of each drive: [gain={}=NUMBER], in {}",
                    postures.name,
                    effort.words(),
                    postures.coordinates[0],
                    effort.gain_unit()
                ))
            })?
        }
    };
    let count = postures.effort.len();
    Ok((0..n).map(|j| DVector::from_fn(count, |r, _| gains[j] * postures.effort[r][j])).collect())
}

impl PostureEstimate {
    /// The estimate as JSON.
    pub fn to_json(&self) -> Value {
        let value = |value: &ValueWithSigma| json!({"value": value.map(|t| t.0), "sigma": value.map(|t| t.1)});
        let parameters = self.parameters.iter().zip(&self.values).enumerate().map(|(k, (parameter, value))| {
            json!({
                "name": parameter.name,
                "unit": parameter.unit,
                "value": value.map(|v| v.0),
                "sigma": value.map(|v| v.1),
                "described": self.described.as_ref().map(|d| d[k]),
            })
        });
        json!({
            "postures": self.postures,
            "plateaus": self.are_plateaus,
            "parameters": parameters.collect::<Vec<_>>(),
            "joints": self.coordinates.iter().enumerate().map(|(j, name)| json!({
                "coordinate": name,
                "offset": value(&self.offsets[j]),
                "residual": self.residuals[j],
                "torque": self.torques[j],
            })).collect::<Vec<_>>(),
            // "left" is the relative residual of the torques, in [0, 1].
            "mistakes": self.mistakes.iter().map(|mistake| json!({
                "fault": mistake.fault,
                "remedy": mistake.remedy,
                "left_before": mistake.left[0],
                "left": mistake.left[1],
                "by_free_bodies": mistake.by_free_bodies,
            })).collect::<Vec<_>>(),
            "with_described_bodies": self.placed.as_ref().map(|placed| json!({
                "zeros": placed.zeros.iter().map(value).collect::<Vec<_>>(),
                "tilt": value(&placed.tilt),
                "base": placed.base,
                "left_before": placed.left[0],
                "left": placed.left[1],
                "explains": placed.explains,
            })),
        })
    }
}

/// A text list of the parameters that postures can determine.
pub fn gravity_text(parameters: &[GravityParameter]) -> String {
    let mut text = format!("{} gravity parameters: all that a robot at rest can identify\n", parameters.len());
    parameters.iter().for_each(|parameter| text += &format!("  {} [{}]\n", parameter.name, parameter.unit));
    text
}

impl fmt::Display for PostureEstimate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let kind = if self.are_plateaus { "plateaus of the log" } else { "rows, each a posture" };
        writeln!(f, "{} {kind}\n", self.postures)?;
        let shown = |value: &ValueWithSigma| match value {
            Some((value, sigma)) => format!("{:>10} +- {}", significant(*value, 4), significant(*sigma, 2)),
            None => "not identifiable from these postures:".into(),
        };
        // First the gravity parameters, then offsets and residuals of the joints.
        let width = self.parameters.iter().map(|p| p.name.len()).chain([8]).max().unwrap_or(8);
        for (k, (parameter, value)) in self.parameters.iter().zip(&self.values).enumerate() {
            let described =
                self.described.as_ref().map_or(String::new(), |d| format!("  nominal {}", significant(d[k], 4)));
            writeln!(f, "  {:width$}  {} {}{described}", parameter.name, shown(value), parameter.unit)?;
        }
        writeln!(f)?;
        for (j, name) in self.coordinates.iter().enumerate() {
            let left = 100.0 * self.residuals[j] / self.torques[j].max(f64::MIN_POSITIVE);
            let unit = if self.slides[j] { "N" } else { "N m" };
            let of = format!(
                "residual {} {unit}, {} % of its torques",
                significant(self.residuals[j], 2),
                significant(left, 2)
            );
            writeln!(f, "  {name:width$}  {} {unit} offset of its torque; {of}", shown(&self.offsets[j]))?;
        }
        // Mistakes in the columns. If there are any, zero errors and base orientation have no meaning.
        for (k, mistake) in self.mistakes.iter().enumerate() {
            let [before, after] = mistake.left.map(|share| significant(100.0 * share, 2));
            let bodies =
                if mistake.by_free_bodies { "with free bodies the residual is" } else { "the nominal residual is" };
            let (head, instead) = (if k == 0 { "\n" } else { "" }, if k == 0 { "" } else { "or else " });
            writeln!(
                f,
                "{head}{instead}{}: {bodies} {before} % of the torques (joints alike); corrected: {after} %; {}",
                mistake.fault, mistake.remedy
            )?;
        }
        if !self.mistakes.is_empty() {
            return Ok(());
        }
        let Some(placed) = &self.placed else { return Ok(()) };
        // Zero errors and base orientation, estimated with the nominal bodies.
        let [before, after] = placed.left.map(|share| significant(100.0 * share, 2));
        writeln!(
            f,
            "\nwith the nominal bodies the residual is {before} % of the torques, with zeros and mount of their own {after} %"
        )?;
        if !placed.explains {
            return writeln!(f, "these bodies do not explain the postures: neither zeros nor mount are identifiable");
        }
        for ((name, zero), slides) in self.coordinates.iter().zip(&placed.zeros).zip(&self.slides) {
            let unit = if *slides { "m" } else { "rad" };
            writeln!(f, "  {name:width$}  {} zero, {unit} to be added to its positions", shown(zero))?;
        }
        writeln!(f, "  {:width$}  {} turn of gravity, rad", "mount", shown(&placed.tilt))?;
        match placed.differs() {
            true => writeln!(f, "to hold them, if its bodies are nominal: {}", placed.remedy()),
            false => writeln!(f, "zeros and mount are nominal"),
        }
    }
}
