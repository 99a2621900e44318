//! motion.yaml: an exciting motion, the limits it was made with, its certificate, and what it makes visible.
//!
//! The coefficients and times are the motion; everything below them can be found again from it and the model, and
//! `rist check` does.

use std::fmt;

use logs::Error;
use serde::{Deserialize, Serialize};

use crate::experiments::excitation::criterion::Aim;
use crate::experiments::excitation::fourier_motion::{FourierJoint, FourierMotion};
use crate::experiments::excitation::limits::{CoordinateLimits, LimitKind};
use crate::experiments::excitation::proof::{CertificateRow, IdentifiedTorque, Kept};
use crate::experiments::excitation::space_limits::SpaceLimits;
use crate::experiments::excitation::visibility::{VisibleParameter, WEAK};
use crate::model::reference::ModelReference;

/// The artefact.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ExcitingMotion {
    /// The robot it was made for.
    pub model: ModelReference,
    /// Hz, of the controller.
    pub rate_hz: f64,
    /// s of one period.
    pub period_s: f64,
    /// s from rest into the periods, and out of them.
    pub blend_s: f64,
    /// Periods played.
    pub repetitions: usize,
    /// One a coordinate, in the order of the model.
    pub joints: Vec<MotionJoint>,
    /// Share of the effort limits that the described torque may use.
    pub effort_share: f64,
    /// The torques that it was made with, where they are not those of the description.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub identified: Option<IdentifiedTorque>,
    /// Where the bodies may be.
    #[serde(default)]
    pub space: SpaceLimits,
    /// The aim of the search.
    pub aim: Aim,
    /// det(W'W / samples)^(1/p), rows over the noise of their joint.
    pub determinant: f64,
    /// Of the columns scaled to unit norm.
    pub condition_number: f64,
    /// N m (N) a sample, one a coordinate.
    pub torque_noise: Vec<f64>,
    /// Whether every limit below is proven to be kept.
    pub proven: bool,
    /// What was not looked at or had to be assumed, in sentences.
    pub notes: Vec<String>,
    /// The limits with what proves them.
    pub certificate: Vec<CertificateRow>,
    /// What the motion makes visible.
    pub parameters: Vec<VisibleParameter>,
}

/// One coordinate of the motion.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MotionJoint {
    /// Name of the coordinate.
    pub coordinate: String,
    /// rad (m).
    pub centre: f64,
    /// Amplitudes of the velocity, rad/s (m/s), harmonic by harmonic.
    pub cosine: Vec<f64>,
    /// Amplitudes of the sines, rad (m).
    pub sine: Vec<f64>,
    /// The limits it was made for.
    pub limits: CoordinateLimits,
}

impl ExcitingMotion {
    /// The motion itself.
    ///
    /// Fails where its numbers are none of a motion.
    pub fn motion(&self, file: &str) -> Result<FourierMotion, Error> {
        let fail = |what: String| Err(Error::at(file, 0, what));
        let times = [("rate_hz", self.rate_hz), ("period_s", self.period_s), ("blend_s", self.blend_s)];
        if let Some((name, x)) = times.iter().find(|(_, x)| !(x.is_finite() && *x > 0.0)) {
            return fail(format!("{name} is {x}; a motion needs a positive one"));
        }
        if !(self.effort_share > 0.0 && self.effort_share <= 1.0) || self.repetitions == 0 {
            return fail(format!(
                "effort_share {} and repetitions {}: expected a share above 0 and at most 1, and one period at least",
                self.effort_share, self.repetitions
            ));
        }
        let harmonics = self.joints.first().map_or(0, |j| j.cosine.len());
        for joint in &self.joints {
            let coefficients = joint.cosine.iter().chain(&joint.sine).chain([&joint.centre]);
            let is_one = joint.cosine.len() == harmonics && joint.sine.len() == harmonics && harmonics > 0;
            if !is_one || coefficients.into_iter().any(|x| !x.is_finite()) {
                let name = &joint.coordinate;
                return fail(format!("joint {name}: expected as many finite cosine and sine as the first joint has"));
            }
        }
        let of = |j: &MotionJoint| FourierJoint { centre: j.centre, cosine: j.cosine.clone(), sine: j.sine.clone() };
        Ok(FourierMotion {
            rate: self.rate_hz,
            period: self.period_s,
            blend: self.blend_s,
            repetitions: self.repetitions,
            joints: self.joints.iter().map(of).collect(),
        })
    }

    /// The text of motion.yaml.
    pub fn to_yaml(&self) -> Result<String, Error> {
        serde_yaml::to_string(self).map_err(|e| Error::new(format!("the motion cannot be written: {e}")))
    }

    /// Reads motion.yaml.
    pub fn from_yaml(file: &str, text: &str) -> Result<ExcitingMotion, Error> {
        serde_yaml::from_str(text).map_err(|e| Error::at(file, 0, format!("this is no exciting motion: {e}")))
    }
}

/// What is said of a certificate whose rows are all proven, and of what no row of it speaks of.
pub fn proven_text(rows: &[CertificateRow]) -> String {
    let kinds = [(LimitKind::Effort, "torques"), (LimitKind::Distance, "distances of the robot's own links")];
    let absent = kinds.iter().filter(|(kind, _)| rows.iter().all(|row| row.limit != *kind));
    let absent: Vec<&str> = absent.map(|(_, what)| *what).collect();
    match absent.is_empty() {
        true => "every limit above is proven, between samples too".into(),
        false => format!("every limit above is proven, between samples too; NOT looked at: {}", absent.join(", ")),
    }
}

/// A certificate for people: violated and open limits in full, the others as the least room of each limit.
pub fn certificate_text(rows: &[CertificateRow]) -> String {
    let mut text = String::new();
    for limit in LimitKind::ALL {
        let own: Vec<&CertificateRow> = rows.iter().filter(|r| r.limit == limit).collect();
        let proven: Vec<&&CertificateRow> = own.iter().filter(|r| r.kept == Kept::Proven).collect();
        let share = |r: &CertificateRow| r.room() / r.bound.abs().max(f64::MIN_POSITIVE);
        if let Some(nearest) = proven.iter().min_by(|a, b| share(a).total_cmp(&share(b))) {
            let (kept, count) = (proven.len(), own.len());
            text.push_str(&format!("{limit:<13} proven for {kept} of {count}; nearest: {nearest}\n"));
        }
        for row in own.iter().filter(|r| r.kept != Kept::Proven) {
            text.push_str(&format!("{row}\n"));
        }
    }
    text
}

impl fmt::Display for ExcitingMotion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let harmonics = self.joints.first().map_or(0, |j| j.cosine.len());
        let duration = 2.0 * self.blend_s + self.repetitions as f64 * self.period_s;
        writeln!(
            f,
            "{}: {harmonics} harmonics of {:.4} Hz, {} of {} s between blends of {} s: {duration} s at {} Hz",
            self.model.name,
            1.0 / self.period_s,
            if self.repetitions == 1 { "1 period".into() } else { format!("{} periods", self.repetitions) },
            self.period_s,
            self.blend_s,
            self.rate_hz
        )?;
        writeln!(f, "det^(1/p) {:.4e}, condition number {:.1}\n", self.determinant, self.condition_number)?;
        write!(f, "{}", certificate_text(&self.certificate))?;
        let headline = if self.proven { proven_text(&self.certificate) } else { "NOT PROVEN".into() };
        writeln!(f, "{headline}\n")?;
        writeln!(f, "{:<26} {:>12} {:>12} {:>9}", "parameter", "described", "deviation", "relative")?;
        for p in &self.parameters {
            let number = |x: Option<f64>| x.map_or("-".into(), |x| format!("{x:.4e}"));
            let relative = p.relative_deviation.map_or("-".into(), |r| format!("{:.2} %", 100.0 * r));
            let blame = match (p.deviation, p.relative_deviation, &p.to_blame) {
                (None, _, Some(why)) => format!("  not visible ({why})"),
                (_, Some(r), Some(why)) if r > WEAK => format!("  weak ({why})"),
                _ => String::new(),
            };
            let (described, deviation) = (number(p.described), number(p.deviation));
            let line = format!("{:<26} {described:>12} {deviation:>12} {relative:>9}{blame}", p.id.to_string());
            writeln!(f, "{}", line.trim_end())?;
        }
        Ok(())
    }
}
