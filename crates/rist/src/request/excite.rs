//! The options (request) of `rist excite`, which searches an exciting motion and proves its limits.
//!
//! A request is a struct with all options of a command; each field is one option. A motion is a Fourier series with blends
//! (transitions from rest to the series and back), or a spline from rest to rest.

use experiments::excitation::criterion::SearchObjective;
use experiments::excitation::limits::LimitsFile;
use experiments::excitation::motion::{Motion, MotionShape};
use experiments::excitation::search::SearchOptions;
use experiments::excitation::space_limits::SpaceLimits;
use identification::estimate::artefact::Estimate;
use linear_model::friction::terms::FrictionTerm;

use super::friction::terms_without_torque;
use super::{FrictionChoice, Range, Request};
use crate::error::Error;

words! {
    /// The family of functions of which a motion consists.
    pub enum MotionSeries {
        /// A finite Fourier series between blends: its periods can be averaged, and its spectrum is known.
        Fourier = "fourier" "Whole periods of a few frequencies between two blends: the periods can be averaged, or filtered without loss",
        /// A quintic spline from rest to rest: it needs no time for blends, and its speed may vary along the motion.
        Spline = "spline" "From rest to rest: more information in a short time or within narrow limits; the speed may vary along the motion",
    }
}

request! {
    /// Options for the search of an exciting motion.
    pub struct ExciteRequest {
        /// The form of the motion.
        motion: MotionSeries = MotionSeries::Fourier;
        /// Period of the series, or duration of a spline from rest to rest, s [default: from the limits, 5 to 20].
        period: Option<f64> = None, range(Range::Positive), value_name("SECONDS");
        /// Base frequency of the series, Hz: the inverse of [period]. Give only one of the two options.
        frequency: Option<f64> = None, range(Range::Positive), value_name("HZ");
        /// Number of harmonics of the base frequency [default: from the limits and the period, 5 to 8; 5 for more than 8
        /// joints].
        harmonics: Option<usize> = None, range(1..=40);
        /// Number of polynomial segments (spans) of a spline. With more spans the motion is freer, and the search is longer
        /// [default: from the limits, 8 to 30].
        spans: Option<usize> = None, range(4..=80);
        /// Number of whole periods between the blends, or of repetitions of a spline.
        repetitions: usize = 3, range(1..);
        /// Duration of the blend from rest to the series, and of the blend back to rest, s [default: from the limits].
        blend: Option<f64> = None, range(Range::Positive), value_name("SECONDS");
        /// Sample rate of the file to play and of the log, Hz.
        rate: f64 = 200.0, range(Range::Positive), value_name("HZ");
        /// YAML with tighter limits. `coordinates: {NAME: {position: [LOW, HIGH], velocity, acceleration, jerk, effort, power,
        /// locked: POSITION, slowed: FACTOR}}` limits single coordinates; `all:` limits every coordinate in the same way.
        /// `space:` limits the bodies, in the base frame, m: `{floor: Z or none, walls: [{point, normal, links}], boxes: [{low,
        /// high, links}], distance: 0.01, own_links: true, accept: [[LINK, LINK, REASON]]}`. `margins:` has the errors for
        /// which the proof must hold too: `{encoder_zero, tracking, calibration, mesh, payload: {link, mass, centre_of_mass}}`.
        limits: Option<LimitsFile> = None, value_name("FILE");
        /// Share of the limits of effort and power that the computed torque may use.
        effort_share: f64 = 0.9, range(Range::Share), value_name("SHARE");
        /// Friction terms of every joint in the later identification. The words and the default are those of [friction] of
        /// `rist identify`; auto is not possible.
        friction: Option<FrictionChoice> = None, value_name("TERMS");
        /// What the search of the motion optimises.
        criterion: SearchObjective = SearchObjective::Determinant;
        /// Standard deviation of the noise of a torque sample, as a share of the effort limit.
        noise: f64 = 0.01, range(Range::Positive), value_name("SHARE");
        /// Number of starts of the search. A third of them are random; the others begin near the best motion so far.
        starts: usize = 12, range(1..);
        /// Maximum number of iterations of each start, at each weight of the barrier function for the limits.
        iterations: usize = 100;
        /// Seed of the random starts; the same seed gives the same motion.
        seed: u64 = 1;
        /// An earlier estimate of this model. The motion excites the parameters that this estimate leaves uncertain, and the
        /// torques follow from its parameters. This estimate should contain its covariance (`covariance: true` in the [options]
        /// of `rist identify`).
        after: Option<Estimate> = None, value_name("ESTIMATE");
    }
}

/// The family of functions that a motion consists of, with the options of this family only.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MotionFamily {
    /// A Fourier series, see [`MotionSeries::Fourier`].
    Fourier {
        /// Time of the blend from rest to the series, s; if `None`, it is chosen from the limits.
        blend: Option<f64>,
        /// Number of harmonics; `None`: chosen from the limits.
        harmonics: Option<usize>,
    },
    /// A spline, see [`MotionSeries::Spline`].
    Spline {
        /// Number of polynomial segments per period; `None`: chosen from the limits.
        spans: Option<usize>,
    },
}

impl ExciteRequest {
    /// The family of functions that the request selects, with its options.
    ///
    /// Fails if the request sets an option that only the other family has.
    pub fn family(&self) -> Result<MotionFamily, Error> {
        let stray = match self.motion {
            MotionSeries::Fourier => [self.spans.map(|_| "spans"), None],
            MotionSeries::Spline => [self.harmonics.map(|_| "harmonics"), self.blend.map(|_| "blend")],
        };
        match (stray.into_iter().flatten().next(), self.motion) {
            (Some(field), MotionSeries::Fourier) => {
                Err(Error::new(format_args!("[{field}] is of splines: add [motion=spline], or ask for [harmonics]")))
            }
            (Some(field), MotionSeries::Spline) => Err(Error::new(format_args!(
                "[{field}] is of Fourier series: a spline starts and ends at rest, and [spans] says how free it is"
            ))),
            (None, MotionSeries::Fourier) => Ok(MotionFamily::Fourier { blend: self.blend, harmonics: self.harmonics }),
            (None, MotionSeries::Spline) => Ok(MotionFamily::Spline { spans: self.spans }),
        }
    }

    /// The period, s; `None` if the request gives none. It is then chosen by [`crate::motion::exciting::default_period`].
    pub fn seconds(&self) -> Option<f64> {
        self.period.or(self.frequency.map(|hz| 1.0 / hz))
    }

    /// The friction terms of the later identification. The search for a motion includes their regressor columns.
    ///
    /// Fails if a term needs a log or a measured torque.
    pub fn friction_terms(&self) -> Result<Vec<FrictionTerm>, Error> {
        terms_without_torque(self.friction.as_ref())
    }

    /// Checks the request, and returns the friction terms of the later identification.
    ///
    /// Fails if a number is out of its range, or if both `period` and `frequency` are given.
    pub(crate) fn check_motion(&self) -> Result<Vec<FrictionTerm>, Error> {
        self.check()?;
        match (self.period, self.frequency) {
            (Some(_), Some(_)) => Err(Error::new("[frequency] is one over [period]: give one of them")),
            _ => self.friction_terms(),
        }
    }

    /// The options of the search.
    pub(crate) fn search(&self) -> SearchOptions {
        let threads = processor::threads();
        SearchOptions { starts: self.starts, iterations: self.iterations, seed: self.seed, threads }
    }

    /// The limits in space for the bodies of the robot; empty if the request gives none.
    pub(crate) fn space(&self) -> SpaceLimits {
        self.limits.as_ref().and_then(|limits| limits.space.clone()).unwrap_or_default()
    }

    /// The motion with the functions `shape` and the coefficients `joints` (one list per joint). Sample rate and number of
    /// repetitions come from the request.
    pub(crate) fn motion(&self, shape: MotionShape, joints: Vec<Vec<f64>>) -> Motion {
        Motion { rate: self.rate, repetitions: self.repetitions, shape, joints }
    }
}
