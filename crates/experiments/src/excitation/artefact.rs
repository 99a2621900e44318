//! Contents of the file motion.yaml: an exciting motion, the limits of its search, its certificate (every limit with the result
//! of its proof) and the identifiable parameters.
//!
//! The coefficients and times define the motion: a Fourier series if the file has `blend_s`, else a spline. All other entries can
//! be recomputed from the motion and the model; `rist check` recomputes them.

use std::fmt;

use claims::significant;
use linear_model::artefact::{self, ArtefactKind, Checksum};
use linear_model::reference::ModelReference;
use logs::Error;
use serde::{Deserialize, Serialize};

use crate::excitation::certificate_text::parameters_text;
pub use crate::excitation::certificate_text::{LimitSummary, certificate_summary, certificate_text};
use crate::excitation::criterion::SearchObjective;
use crate::excitation::fourier_series::FourierSeries;
use crate::excitation::limits::CoordinateLimits;
use crate::excitation::margins::Margins;
use crate::excitation::motion::{Motion, MotionShape};
use crate::excitation::motion_claims::{LowestPoint, MotionClaims};
use crate::excitation::proof::{CertificateRow, IdentifiedTorque};
use crate::excitation::quintic_spline::QuinticSpline;
use crate::excitation::space_limits::{Floor, SpaceLimits};
use crate::excitation::visibility::VisibleParameter;
use crate::motion::sample_count::check_samples;
use claims::LeftOut;

/// The contents of motion.yaml, which describes one exciting motion.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ExcitingMotion {
    /// Whether the checksum in the file matches its contents.
    #[serde(skip)]
    pub checksum: Checksum,
    /// Name and fingerprint of the robot model for which the motion was computed.
    pub model: ModelReference,
    /// Rate at which the controller samples the motion, Hz.
    pub rate_hz: f64,
    /// Period of the Fourier series, s. For a spline: its duration from rest to rest, s.
    pub period_s: f64,
    /// Duration of each of the two blends, s: from rest to the Fourier series, and back to rest. `None` for a spline.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub blend_s: Option<f64>,
    /// Number of times that the robot repeats the period (or the spline).
    pub repetitions: usize,
    /// Coefficients and limits of each coordinate, in the order of the coordinates in the model.
    pub joints: Vec<MotionJoint>,
    /// Share of the effort and power limits of the drives that the nominal torque may use, above 0 and at most 1.
    pub effort_share: f64,
    /// The identified torque parameters that the search used. `None`: it used the nominal parameters of the description.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub identified: Option<IdentifiedTorque>,
    /// Limits of the bodies in space: floor, walls, boxes and distances.
    #[serde(default)]
    pub space: SpaceLimits,
    /// The criterion that the search optimised.
    pub aim: SearchObjective,
    /// Determinant criterion det(W'W / samples)^(1/p); W: regressor of the motion with its p parameters, each row divided by the
    /// torque noise of its joint.
    pub determinant: f64,
    /// Condition number of the regressor of the motion, after scaling each column to unit norm.
    pub condition_number: f64,
    /// Criterion value of this motion (det^(1/p) or 1/cond), divided by the value of the best motion that the search found. It is
    /// below 1 if the motion was scaled down afterwards to keep its limits. `None`: not stored.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub kept_share: Option<f64>,
    /// Standard deviation of the noise of one torque sample, N m (N), one per coordinate.
    pub torque_noise: Vec<f64>,
    /// Torque error that the noise of the encoders causes: standard deviation, N m (N), one per coordinate. It is determined from
    /// the residuals of an identification.
    #[serde(default)]
    pub encoder_noise: Vec<f64>,
    /// Whether every row of the certificate is proven and every requested check was made.
    pub proven: bool,
    /// Further remarks on the motion for users, one sentence each.
    pub notes: Vec<String>,
    /// Checks that were not made. `None`: the file is of an earlier version, which did not list them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub left_out: Option<Vec<LeftOut>>,
    /// The lowest point of the moving links over all sampled instants. `None`: not stored.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lowest: Option<LowestPoint>,
    /// Margins to the limits, and the distance and time that the robot needs to stop. `None`: the file is of an earlier version.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub margins: Option<Margins>,
    /// Every limit of the motion, each with the result of its proof.
    pub certificate: Vec<CertificateRow>,
    /// All parameters of the model, with the standard deviations predicted for an identification from this motion.
    pub parameters: Vec<VisibleParameter>,
}

/// Coefficients and limits of one coordinate of the motion.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MotionJoint {
    /// Name of the coordinate.
    pub coordinate: String,
    /// Centre of the Fourier series, or the position at which the spline starts and ends, rad (m).
    pub centre: f64,
    /// Cosine amplitudes of the velocity, rad/s (m/s), one per harmonic. Empty for a spline.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub cosine: Vec<f64>,
    /// Sine amplitudes of the velocity, rad/s (m/s), one per harmonic. Empty for a spline.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sine: Vec<f64>,
    /// Control points of the spline minus `centre` (rad or m) without the first three and the last three, which equal `centre`.
    /// Empty for a Fourier series.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub control_points: Vec<f64>,
    /// The limits of this coordinate that the search used.
    pub limits: CoordinateLimits,
}

impl MotionJoint {
    /// Makes the entry of one coordinate from its coefficients, the centre first, in the order of the basis functions of `shape`.
    pub fn new(coordinate: String, shape: &MotionShape, coefficients: &[f64], limits: CoordinateLimits) -> MotionJoint {
        let centre = coefficients.first().copied().unwrap_or(0.0);
        let swing = coefficients.get(1..).unwrap_or_default();
        let nothing = MotionJoint { coordinate, centre, cosine: vec![], sine: vec![], control_points: vec![], limits };
        match shape {
            MotionShape::Fourier(_) => MotionJoint {
                cosine: swing.iter().copied().step_by(2).collect(),
                sine: swing.iter().copied().skip(1).step_by(2).collect(),
                ..nothing
            },
            MotionShape::Spline(_) => MotionJoint { control_points: swing.to_vec(), ..nothing },
        }
    }

    /// The coefficients of this coordinate, the centre first. `None` if their number does not fit the shape, or one is not
    /// finite.
    fn coefficients(&self, shape: &MotionShape) -> Option<Vec<f64>> {
        let pairs = self.cosine.iter().zip(&self.sine).flat_map(|(a, b)| [*a, *b]);
        let swing: Vec<f64> = match shape {
            MotionShape::Fourier(_) if self.cosine.len() == self.sine.len() && self.control_points.is_empty() => {
                pairs.collect()
            }
            MotionShape::Spline(_) if self.cosine.is_empty() && self.sine.is_empty() => self.control_points.clone(),
            _ => return None,
        };
        let all: Vec<f64> = std::iter::once(self.centre).chain(swing).collect();
        (all.len() == shape.size() && all.iter().all(|x| x.is_finite())).then_some(all)
    }
}

impl ExcitingMotion {
    /// The basis functions of the motion. Their number is the number of coefficients of the first joint.
    fn shape(&self) -> MotionShape {
        let size = |of: &dyn Fn(&MotionJoint) -> &Vec<f64>| self.joints.first().map_or(0, |j| of(j).len());
        match self.blend_s {
            Some(blend) => {
                let harmonics = size(&|j| &j.cosine);
                MotionShape::Fourier(FourierSeries { period: self.period_s, blend, harmonics })
            }
            None => {
                MotionShape::Spline(QuinticSpline { period: self.period_s, spans: size(&|j| &j.control_points) + 1 })
            }
        }
    }

    /// Converts the contents of the file to a motion that can be evaluated.
    ///
    /// Fails if the numbers of the file describe no motion. `file`: name of the file, for error messages.
    pub fn motion(&self, file: &str) -> Result<Motion, Error> {
        let fail = |what: String| Err(Error::at(file, 0, what));
        // A file may be edited by hand, so each number is checked before the motion is made from it.
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
        // The number of samples is checked before they are computed, because too many would exceed the memory.
        let shape = self.shape();
        let duration = 2.0 * shape.blend() + self.repetitions as f64 * shape.period();
        check_samples(duration * self.rate_hz).map_err(|what| Error::at(file, 0, what))?;
        let mut joints = Vec::new();
        for joint in &self.joints {
            let Some(coefficients) = joint.coefficients(&shape).filter(|x| x.len() > 1) else {
                let expected = match shape {
                    MotionShape::Fourier(_) => "as many finite cosine and sine as the first joint has",
                    MotionShape::Spline(_) => {
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

    /// The claims of the motion: one for each certificate row and for each omitted check of this file.
    pub fn claims(&self) -> MotionClaims<'_> {
        MotionClaims {
            rows: &self.certificate,
            left_out: self.left_out.as_deref().unwrap_or_default(),
            floor: self.space.floor.and_then(Floor::height),
            lowest: self.lowest.as_ref(),
        }
    }

    /// Describes the shape, the times and the rate of the motion in words.
    pub fn in_words(&self) -> String {
        let (period, rate) = (seconds(self.period_s), self.rate_hz);
        let shape = self.shape();
        let duration = seconds(2.0 * shape.blend() + self.repetitions as f64 * self.period_s);
        let text = match shape {
            MotionShape::Fourier(series) => {
                let repeated = counted(self.repetitions, "period", "periods");
                let (harmonics, frequency, blend) = (series.harmonics, 1.0 / self.period_s, seconds(series.blend));
                format!(
                    "{harmonics} harmonics of {frequency:.4} Hz, {repeated} of {period} s between blends of {blend} s"
                )
            }
            MotionShape::Spline(spline) => {
                let repeated = counted(self.repetitions, "time", "times");
                format!("a quintic spline of {} spans, {repeated} {period} s from rest to rest", spline.spans)
            }
        };
        format!("{text}: {duration} s at {rate} Hz")
    }

    /// Writes the motion as the text of motion.yaml.
    pub fn to_yaml(&self) -> Result<String, Error> {
        artefact::write(ArtefactKind::Motion, self.checksum, self).map_err(Error::new)
    }

    /// Reads motion.yaml from its text. `file`: name of the file, for error messages.
    pub fn from_yaml(file: &str, text: &str) -> Result<ExcitingMotion, Error> {
        let motion: ExcitingMotion = artefact::read(ArtefactKind::Motion, text).map_err(|e| Error::at(file, 0, e))?;
        motion.check_size().map_err(|e| Error::at(file, 0, e))?;
        Ok(ExcitingMotion { checksum: Checksum::of(text), ..motion })
    }

    /// Fails if numbers of the file are so extreme that running or proving the motion would take too long. `rist excite` never
    /// writes such a motion.
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
            if count > MAX_HARMONICS_READ {
                return Err(format!(
                    "{} has {count} harmonics; at most {MAX_HARMONICS_READ} are read",
                    joint.coordinate
                ));
            }
            let numbers = joint.cosine.iter().chain(&joint.sine).chain([&joint.centre]);
            if let Some(x) = numbers.into_iter().find(|x| x.is_nan() || x.abs() > LARGEST_POSITION) {
                return Err(format!(
                    "{} moves by {x:e} rad (m); no robot goes as far as {LARGEST_POSITION:e}",
                    joint.coordinate
                ));
            }
        }
        Ok(())
    }
}

/// Accepted sample rates of controllers, Hz.
const RATES_HZ: std::ops::RangeInclusive<f64> = 1.0..=2e4;
/// Greatest accepted number of harmonics of a joint in motion.yaml. The search uses at most 40.
const MAX_HARMONICS_READ: usize = 100;
/// Greatest accepted magnitude of a centre (rad or m) or of a harmonic's velocity amplitude (rad/s or m/s).
const LARGEST_POSITION: f64 = 1e6;

/// Rounds a time to microseconds, s: 38.8, not 38.800000000000004.
fn seconds(x: f64) -> f64 {
    let micros = (x * 1e6).round();
    // A time that rounds to zero microseconds is returned unrounded.
    if micros != 0.0 && micros.abs() < 1e15 { micros / 1e6 } else { x }
}

/// A count with its noun: `1 period`, `3 periods`.
fn counted(count: usize, one: &str, several: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { several })
}

impl ExcitingMotion {
    /// The motion as text for users. `is_prismatic`: whether the coordinate of a name slides; `None`: unknown.
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
            self.claims().left_out_text(),
            parameters_text(&self.parameters),
            self.claims()
        )
    }
}

impl fmt::Display for ExcitingMotion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text(&|_| None))
    }
}
