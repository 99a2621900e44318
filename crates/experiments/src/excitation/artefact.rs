//! motion.yaml: an exciting motion, the limits it was made with, its certificate, and what it makes visible.
//!
//! The coefficients and times are the motion: a Fourier series where there is a blend, else a spline. Everything below
//! them can be found again from it and the model, and `rist check` does so.

use std::fmt;

use claims::significant;
use linear_model::artefact::{self, Kind, Seal};
use linear_model::reference::ModelReference;
use logs::Error;
use serde::{Deserialize, Serialize};

use crate::excitation::certificate_text::parameters_text;
pub use crate::excitation::certificate_text::{LimitSummary, certificate_summary, certificate_text};
use crate::excitation::criterion::Aim;
use crate::excitation::fourier_series::FourierSeries;
use crate::excitation::ledger::{LowestPoint, MotionLedger};
use crate::excitation::limits::CoordinateLimits;
use crate::excitation::margins::Margins;
use crate::excitation::motion::{Motion, Shape};
use crate::excitation::proof::{CertificateRow, IdentifiedTorque};
use crate::excitation::quintic_spline::QuinticSpline;
use crate::excitation::space_limits::{Floor, SpaceLimits};
use crate::excitation::visibility::VisibleParameter;
use crate::motion::sample_count::check_samples;
use claims::LeftOut;

/// The artefact.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ExcitingMotion {
    /// Whether the file that it was read from is as rist wrote it.
    #[serde(skip)]
    pub seal: Seal,
    /// The robot it was made for.
    pub model: ModelReference,
    /// Hz, of the controller.
    pub rate_hz: f64,
    /// s of one period; of a spline from rest to rest.
    pub period_s: f64,
    /// s from rest into the periods of a series, and out of them; a spline has none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub blend_s: Option<f64>,
    /// Periods played.
    pub repetitions: usize,
    /// One per coordinate, in the order of the model.
    pub joints: Vec<MotionJoint>,
    /// Share of the limits of effort and power that the described torque may use.
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
    /// What it has of det^(1/p) (or of 1/cond) of the best motion of the search, before that was made to keep its limits.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub kept_share: Option<f64>,
    /// N m (N) a sample, one per coordinate.
    pub torque_noise: Vec<f64>,
    /// N m (N) a sample, one per coordinate: what the noise of the encoders adds to the residuals of an identification.
    #[serde(default)]
    pub encoder_noise: Vec<f64>,
    /// Whether every row below is proven, and all that was asked for is looked at.
    pub proven: bool,
    /// What else is to be known, in sentences.
    pub notes: Vec<String>,
    /// What the certificate leaves out; a motion of an earlier version does not say.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub left_out: Option<Vec<LeftOut>>,
    /// The lowest point of the links that move, as far as instants show.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lowest: Option<LowestPoint>,
    /// What the certificate has room for, and what stopping takes; a motion of an earlier version does not say.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub margins: Option<Margins>,
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
    /// Centre of a series, or the pose where a spline starts and ends, rad (m).
    pub centre: f64,
    /// Amplitudes of the velocity that go with the cosine, rad/s (m/s), harmonic by harmonic.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub cosine: Vec<f64>,
    /// Those that go with the sine.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sine: Vec<f64>,
    /// Of a spline: its control points between the first and the last three, less the centre, rad (m).
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub control_points: Vec<f64>,
    /// The limits it was made for.
    pub limits: CoordinateLimits,
}

impl MotionJoint {
    /// From the coefficients of a shape.
    pub fn new(coordinate: String, shape: &Shape, coefficients: &[f64], limits: CoordinateLimits) -> MotionJoint {
        let centre = coefficients.first().copied().unwrap_or(0.0);
        let swing = coefficients.get(1..).unwrap_or_default();
        let nothing = MotionJoint { coordinate, centre, cosine: vec![], sine: vec![], control_points: vec![], limits };
        match shape {
            Shape::Fourier(_) => MotionJoint {
                cosine: swing.iter().copied().step_by(2).collect(),
                sine: swing.iter().copied().skip(1).step_by(2).collect(),
                ..nothing
            },
            Shape::Spline(_) => MotionJoint { control_points: swing.to_vec(), ..nothing },
        }
    }

    /// The coefficients; `None` where they are not those of the shape.
    fn coefficients(&self, shape: &Shape) -> Option<Vec<f64>> {
        let pairs = self.cosine.iter().zip(&self.sine).flat_map(|(a, b)| [*a, *b]);
        let swing: Vec<f64> = match shape {
            Shape::Fourier(_) if self.cosine.len() == self.sine.len() && self.control_points.is_empty() => {
                pairs.collect()
            }
            Shape::Spline(_) if self.cosine.is_empty() && self.sine.is_empty() => self.control_points.clone(),
            _ => return None,
        };
        let all: Vec<f64> = std::iter::once(self.centre).chain(swing).collect();
        (all.len() == shape.size() && all.iter().all(|x| x.is_finite())).then_some(all)
    }
}

impl ExcitingMotion {
    /// The shape, as its first joint has it.
    fn shape(&self) -> Shape {
        let size = |of: &dyn Fn(&MotionJoint) -> &Vec<f64>| self.joints.first().map_or(0, |j| of(j).len());
        match self.blend_s {
            Some(blend) => {
                let harmonics = size(&|j| &j.cosine);
                Shape::Fourier(FourierSeries { period: self.period_s, blend, harmonics })
            }
            None => Shape::Spline(QuinticSpline { period: self.period_s, spans: size(&|j| &j.control_points) + 1 }),
        }
    }

    /// The motion itself.
    ///
    /// Fails where its numbers describe no motion.
    pub fn motion(&self, file: &str) -> Result<Motion, Error> {
        let fail = |what: String| Err(Error::at(file, 0, what));
        // A file may be edited: each number is checked before the motion is made from it.
        let times = [("rate_hz", Some(self.rate_hz)), ("period_s", Some(self.period_s)), ("blend_s", self.blend_s)];
        let given = times.iter().filter_map(|(name, x)| Some((name, (*x)?)));
        if let Some((name, x)) = given.into_iter().find(|(_, x)| !(x.is_finite() && *x > 0.0)) {
            return fail(format!("{name} is {x}; a motion needs a positive one"));
        }
        if !(self.effort_share > 0.0 && self.effort_share <= 1.0) || self.repetitions == 0 {
            return fail(format!(
                "effort_share {} and repetitions {}: expected a share above 0 and at most 1, and one period at least",
                self.effort_share, self.repetitions
            ));
        }
        // The number of samples is checked before anybody makes them.
        let shape = self.shape();
        let duration = 2.0 * shape.blend() + self.repetitions as f64 * shape.period();
        check_samples(duration * self.rate_hz).map_err(|what| Error::at(file, 0, what))?;
        let mut joints = Vec::new();
        for joint in &self.joints {
            let Some(coefficients) = joint.coefficients(&shape).filter(|x| x.len() > 1) else {
                let expected = match shape {
                    Shape::Fourier(_) => "as many finite cosine and sine as the first joint has",
                    Shape::Spline(_) => {
                        "as many finite control_points as the first joint has, and nothing else; a motion of cosine and \
                         sine has blend_s"
                    }
                };
                return fail(format!("joint {}: expected {expected}", joint.coordinate));
            };
            joints.push(coefficients);
        }
        Ok(Motion { rate: self.rate_hz, repetitions: self.repetitions, shape, joints })
    }

    /// Its certificate with what it leaves out, as the file says.
    pub fn ledger(&self) -> MotionLedger<'_> {
        MotionLedger {
            rows: &self.certificate,
            left_out: self.left_out.as_deref().unwrap_or_default(),
            floor: self.space.floor.and_then(Floor::height),
            lowest: self.lowest.as_ref(),
        }
    }

    /// Its shape and its times.
    pub fn in_words(&self) -> String {
        let (period, rate) = (seconds(self.period_s), self.rate_hz);
        let shape = self.shape();
        let duration = seconds(2.0 * shape.blend() + self.repetitions as f64 * self.period_s);
        let text = match shape {
            Shape::Fourier(series) => {
                let repeated = counted(self.repetitions, "period", "periods");
                let (harmonics, frequency, blend) = (series.harmonics, 1.0 / self.period_s, seconds(series.blend));
                format!(
                    "{harmonics} harmonics of {frequency:.4} Hz, {repeated} of {period} s between blends of {blend} s"
                )
            }
            Shape::Spline(spline) => {
                let repeated = counted(self.repetitions, "time", "times");
                format!("a quintic spline of {} spans, {repeated} {period} s from rest to rest", spline.spans)
            }
        };
        format!("{text}: {duration} s at {rate} Hz")
    }

    /// The text of motion.yaml.
    pub fn to_yaml(&self) -> Result<String, Error> {
        artefact::write(Kind::Motion, self.seal, self).map_err(Error::new)
    }

    /// Reads motion.yaml.
    pub fn from_yaml(file: &str, text: &str) -> Result<ExcitingMotion, Error> {
        let motion: ExcitingMotion = artefact::read(Kind::Motion, text).map_err(|e| Error::at(file, 0, e))?;
        motion.check_size().map_err(|e| Error::at(file, 0, e))?;
        Ok(ExcitingMotion { seal: Seal::of(text), ..motion })
    }

    /// Fails where playing or proving it would take without end: no `rist excite` writes such a motion.
    fn check_size(&self) -> Result<(), String> {
        if !RATES_HZ.contains(&self.rate_hz) {
            let (low, high) = (RATES_HZ.start(), RATES_HZ.end());
            return Err(format!("rate_hz is {:?}; a controller has {low} to {high} Hz", self.rate_hz));
        }
        if self.period_s > 0.0 && self.period_s * self.rate_hz < 1.0 {
            let (period, rate) = (seconds(self.period_s), self.rate_hz);
            return Err(format!("period_s is {period:e}, less than a sample at {rate} Hz: a longer one is expected"));
        }
        for joint in &self.joints {
            let count = joint.cosine.len().max(joint.sine.len());
            if count > MOST_HARMONICS {
                return Err(format!("{} has {count} harmonics; at most {MOST_HARMONICS} are read", joint.coordinate));
            }
            let numbers = joint.cosine.iter().chain(&joint.sine).chain([&joint.centre]);
            if let Some(x) = numbers.into_iter().find(|x| x.is_nan() || x.abs() > LARGEST_NUMBER) {
                return Err(format!(
                    "{} moves by {x:e} rad (m); no robot goes as far as {LARGEST_NUMBER:e}",
                    joint.coordinate
                ));
            }
        }
        Ok(())
    }
}

/// Sample rates of controllers, Hz.
const RATES_HZ: std::ops::RangeInclusive<f64> = 1.0..=2e4;
/// Harmonics of a joint. The search takes at most 40.
const MOST_HARMONICS: usize = 100;
/// rad (m).
const LARGEST_NUMBER: f64 = 1e6;

/// Seconds without the digits that rounding left: 38.8, not 38.800000000000004.
fn seconds(x: f64) -> f64 {
    let micros = (x * 1e6).round();
    // What is less than a microsecond is no digit of rounding.
    if micros != 0.0 && micros.abs() < 1e15 { micros / 1e6 } else { x }
}

/// `1 period`, `3 periods`.
fn counted(count: usize, one: &str, several: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { several })
}

impl ExcitingMotion {
    /// The motion for people. `is_prismatic` is as of [`certificate_text`].
    pub fn text(&self, is_prismatic: &dyn Fn(&str) -> Option<bool>) -> String {
        let (determinant, condition) = (significant(self.determinant, 4), significant(self.condition_number, 3));
        let kept = self.kept_share.map_or(String::new(), |share| {
            format!("; {:.1} % of what the search found before the proof", 100.0 * share)
        });
        let margins = self.margins.as_ref().map_or(String::new(), |margins| format!("margins:\n{}\n", margins.text()));
        format!(
            "{}: {}\ndet^(1/p) {determinant}, condition number {condition}{kept}\n\n{}{}\n{}\n{margins}{}\n",
            self.model.name,
            self.in_words(),
            certificate_text(&self.certificate, is_prismatic),
            self.ledger().left_out_text(),
            parameters_text(&self.parameters),
            self.ledger()
        )
    }
}

impl fmt::Display for ExcitingMotion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text(&|_| None))
    }
}
