//! The passport of a log: whether it belongs to the robot of the description, before anything is fitted.
//!
//! The torque of each joint is regressed on what the description computes for its motion, beside what no description
//! has:
//! ```text
//! tau_j = s_j (Y(q, dq, ddq) X)_j + a ddq_j + b dq_j + c direction_j + d
//! ```
//! X are the base parameters of the description (p), s_j is the slope of the description: near 1 where log and
//! description speak of one robot in one unit; the sign of b and c is that of friction, which brakes. Where a slope is
//! not near 1, the usual mistakes are undone one by one, and the one that makes the description predict the torques is
//! the finding (`search`). A description without inertials has no slopes: what it leaves untold is said.
//!
//! It is a look, not an estimate: nominal inertials are wrong by tens of per cent, and a slope of 0.6 in a wrist is no
//! mistake of a log.

mod change;
mod delay;
mod diagnosis;
pub mod finding;
pub mod friction;
mod order;
mod regression;
mod samples;
mod search;
mod signals;

use std::fmt;

use logs::{Error, Suspect};

use crate::estimate::passport::change::{Description, FEWEST, column, partials, used};
use crate::estimate::passport::finding::{Fault, Finding};
use crate::estimate::passport::friction::{OwnFriction, own_friction};
use crate::estimate::passport::regression::{Basis, Partial, square};
use crate::estimate::passport::samples::Samples;
use crate::model::regressor::Regressor;
use crate::signals::records::Records;

/// What a joint's torque has to do with the description.
#[derive(Clone, Debug, PartialEq)]
pub struct JointPassport {
    /// Name of the coordinate.
    pub coordinate: String,
    /// Measured torque per torque of the description, beside rotor, friction and offset; `None` without inertials, or
    /// where the joint has too few samples.
    pub slope: Option<f64>,
    /// Share of the torque's variance that the description explains beyond rotor, friction and offset: what the slope
    /// stands on.
    pub share: Option<f64>,
    /// Share of the torque's variance that the description explains with rotor, friction and offset.
    pub explained: Option<f64>,
    /// Friction by the joint's own row of the regressor; `None` where it cannot be told.
    pub friction: Option<OwnFriction>,
    /// Distance between the ends of its motion, rad (m).
    pub range: f64,
}

/// What a log says of itself and of its description before anything is fitted.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Passport {
    /// One a coordinate.
    pub joints: Vec<JointPassport>,
    /// The worst first.
    pub findings: Vec<Finding>,
    /// What could not be looked at, in sentences.
    pub untold: Vec<String>,
}

/// Share of the torque beyond which a joint's slope is a number, and below which it is none.
const TELLING: f64 = 0.5;
const SLIGHT: f64 = 0.05;

/// Samples that are looked at, at least, where there are as many.
const TRIED: usize = 400;

/// Looks at a log: its records, what is odd about its columns, and the base parameters of the description where it has
/// inertials.
///
/// Fails when a record cannot be read.
pub fn passport<R: Records + ?Sized>(
    regressor: &dyn Regressor,
    records: &R,
    suspects: &[Suspect],
    described: Option<&[f64]>,
) -> Result<Passport, Error> {
    let n = regressor.coordinates().len();
    let samples = Samples::of(records, n)?;
    let rows = samples.every(samples.kept.len() / TRIED);
    let description = described.map(|parameters| Description { regressor, parameters });
    let slopes = description.as_ref().map(|d| partials(d, &samples.kept, &rows, &[]));
    let mut passport = Passport::default();
    for (j, coordinate) in regressor.coordinates().iter().enumerate() {
        let partial = slopes.as_ref().map(|s| s[j]).filter(|p| p.yy > 0.0);
        passport.joints.push(JointPassport {
            coordinate: coordinate.clone(),
            slope: partial.map(|p| p.slope()),
            share: partial.map(|p| p.share()),
            explained: partial.and_then(|p| explained(&samples, &rows, j, &p)),
            friction: own_friction(regressor, &samples.kept, &rows, j),
            range: samples.range[j].1 - samples.range[j].0,
        });
    }
    let look =
        diagnosis::Look { samples: &samples, rows: &rows, suspects, regressor, description: description.as_ref() };
    look.diagnose(slopes.as_deref(), &mut passport);
    Ok(passport)
}

/// The share of the torque's variance that description and own columns explain together.
fn explained(samples: &Samples, rows: &[usize], j: usize, partial: &Partial) -> Option<f64> {
    let places = used(&samples.kept, rows, j);
    let chosen: Vec<usize> = places.iter().map(|&i| rows[i]).collect();
    let mean = Basis::of(vec![vec![1.0; chosen.len()]]);
    let variance = square(&mean.without(column(&samples.kept.tau, samples.kept.n, j, &chosen)));
    (variance > 0.0 && chosen.len() >= FEWEST).then(|| 1.0 - partial.yy * (1.0 - partial.share()) / variance)
}

impl Passport {
    /// Whether a finding forbids to use an estimate from this log.
    pub fn is_gross(&self) -> bool {
        self.findings.iter().any(|f| f.fault.is_gross())
    }

    /// Says of efforts that are known to be currents what gains the description implies, which is no fault.
    pub fn efforts_are_currents(&mut self) {
        let is_unit = |f: &Finding| matches!(f.fault, Fault::NoTorque | Fault::TorqueUnit(_));
        let (unit, others) = std::mem::take(&mut self.findings).into_iter().partition(is_unit);
        let unit: Vec<Finding> = unit;
        self.findings = others;
        self.untold.extend(unit.iter().map(|f| format!("currents without gains: {}; {}", f.evidence, f.remedy)));
    }
}

impl fmt::Display for Passport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let width = self.joints.iter().map(|j| j.coordinate.chars().count()).max().unwrap_or(0).max(5);
        let head = ["slope", "by it", "explained", "friction"];
        writeln!(f, "{:<width$}  {:>8}  {:>6}  {:>9}  {:<9}", "joint", head[0], head[1], head[2], head[3])?;
        let percent = |x: Option<f64>| x.map_or("-".into(), |x| format!("{:.0} %", 100.0 * x));
        for j in &self.joints {
            // A slope that stands on little says little.
            let slope = match (j.slope, j.share) {
                (Some(slope), Some(share)) if share > TELLING => significant(slope),
                (Some(slope), Some(share)) if share > SLIGHT => format!("({})", significant(slope)),
                _ => "-".into(),
            };
            let friction = match j.friction {
                None => "-",
                Some(friction) if friction.drives => "drives",
                Some(friction) if friction.brakes > 0.0 => "brakes",
                Some(_) => "unclear",
            };
            let (share, explained) = (percent(j.share), percent(j.explained));
            writeln!(f, "{:<width$}  {slope:>8}  {share:>6}  {explained:>9}  {friction}", j.coordinate)?;
        }
        Ok(())
    }
}

/// Three digits that count, without an exponent where it can be read without.
pub(crate) fn significant(x: f64) -> String {
    let size = x.abs();
    match size {
        _ if size == 0.0 => "0".into(),
        _ if size >= 1e5 || size < 1e-3 => format!("{x:.2e}"),
        _ if size >= 100.0 => format!("{x:.0}"),
        _ if size >= 10.0 => format!("{x:.1}"),
        _ if size >= 0.1 => format!("{x:.2}"),
        _ => format!("{x:.4}"),
    }
}
