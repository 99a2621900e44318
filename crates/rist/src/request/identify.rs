//! The options of an identification: one struct (request) per family of methods. Common fields are defined once and shared.
//!
//! | method | request |
//! |---|---|
//! | `ls` | [`IdentifyRequest`] |
//! | `essential` | [`SamplesRequest`] |
//! | `rist` | [`PaperRequest`] |
//! | `rist-mh` | [`HarmonicRequest`] |
//! | `iv`, `didim` | [`ClosedLoopRequest`] |
//!
//! A method has exactly the options that its request has as fields.
//!
//! Samples are the rows of logs; a plan is a list of experiments, for which `rist`, `rist-mh`, `iv` and `didim` are made.

use std::path::PathBuf;

use identification::estimate::options::Options;
use identification::estimators::drive_gains::likelihood::Gain;
use identification::estimators::weighted::Weights;
use identification::spectrum::rist_mh::data::HarmonicOptions;
use linear_model::friction::terms::FrictionTerm;
use linear_model::known_load::KnownLoad;
use logs::ColumnNames;

use super::effect::{Delay, JointSelector};
use super::friction::words;
use super::unknowns::UnknownKind;
use super::{FrictionChoice, Range};
use crate::error::Error;

/// Heading in the help for options of the method.
pub const METHOD: &str = "Method";
/// Other headings in the help.
const SIGNALS: &str = "Signals";
const BODIES: &str = "Bodies and loads";

request! {
    /// Options for processing logged signals: filter, sample rate, decimation, delay.
    pub struct SignalRequest {
        /// Cut-off of the zero-phase low-pass, Hz [default: from the frequency content of the logs].
        cutoff: Option<f64> = None, range(Range::Positive), value_name("HZ"), heading(SIGNALS);
        /// Order of the Butterworth low-pass; 0: no low-pass [default: Signal::order].
        order: Option<usize> = None, default_from(Options::default().signal.order), heading(SIGNALS);
        /// Rows per second (Hz) of a log without a clock.
        rate: Option<f64> = None, range(Range::Positive), value_name("HZ"), heading(SIGNALS);
        /// Keep every N-th filtered sample [default: from the cut-off].
        decimate: Option<usize> = None, range(1..), value_name("N"), heading(SIGNALS);
        /// Delay of the torques behind the positions, s; negative if the torques come first [default: Signal::delay]. auto: the
        /// delay within +-0.25 s with the smallest residual, on rows away from reversals of their joint. With this delay, the
        /// residual of all rows may be larger than without.
        delay: Option<Delay> = None, default_from(Options::default().signal.delay), value_name("SECONDS"), heading(SIGNALS);
        /// YAML with any option of an identification. Other options that are given here replace those of the file.
        options: Option<Options> = None, value_name("FILE"), heading(METHOD);
    }
}

request! {
    /// Options for the regression rows that are built from logs.
    pub struct RowsRequest {
        /// Friction terms of every joint: viscous, coulomb, offset, asymmetric, load, rotor, smooth-coulomb=V, stribeck=V (V in
        /// rad/s), none; or auto, which chooses the terms that best predict held-out parts of the logs [default:
        /// FrictionTerm::STANDARD].
        friction: Option<FrictionChoice> = None, default_from(words(&FrictionTerm::STANDARD)), value_name("TERMS"), heading(METHOD);
        /// Weights of the rows in the fit [default: Options::weights].
        weights: Option<Weights> = None, default_from(Options::default().weights.word()), heading(METHOD);
        ..
        /// Options for processing logged signals: filter, sample rate, decimation, delay.
        signals: SignalRequest;
    }
}

request! {
    /// Options of least squares on samples, shared by the methods `ls` and `essential`.
    pub struct SamplesRequest {
        /// Drive gain (torque per current), N m/A [default: as in the file]. If only some gains are given, the others are
        /// estimated. q5=11+-2: a gain near 11 is expected, with standard deviation 2.
        gain: Vec<(String, Gain)> = Vec::new(), range(Range::NonZero), value_name("COORDINATE=GAIN"), heading(METHOD);
        /// A hobby arm or its servo: so101, koch, wx250s, vx300s, openmanipulator-x, xm430-w350 and others. Units, zeros and
        /// gains of this arm are used where nothing else gives them. The form of the positions may follow the name:
        /// so101:degrees, :normalised, :counts or :radians.
        arm: Option<String> = None, value_name("ARM[:FORM]"), heading(SIGNALS);
        /// What to identify in addition to the parameters, for all joints: mount (of the base), zeros (of the positions),
        /// scales (of the torques), springs. The estimate gives each value with its deviation, and the option or the line of
        /// the URDF that corrects it.
        unknowns: Vec<UnknownKind> = Vec::new(), value_name("KINDS"), heading(METHOD);
        /// Leave out the rows of intervals in which the residual is an outlier, for example during a contact. The estimate
        /// lists these intervals.
        leave_out_contact: bool = false, heading(METHOD);
        /// Keep the covariance of the parameters in the estimate.
        covariance: bool = false, heading(METHOD);
        /// The link that carries the load in the logs of [loaded] [default: the last link].
        loaded_link: Option<String> = None, value_name("LINK"), heading(BODIES);
        ..
        /// Options for the regression rows that are built from logs.
        rows: RowsRequest;
    }
}

request! {
    /// Options of least squares on samples. Default: weighted by joint, with viscous and Coulomb friction and an offset.
    pub struct IdentifyRequest {
        /// Identify physically consistent parameters: every link is a body that can exist. A body that the logs do not
        /// determine stays near the body of the description.
        consistent: bool = false, heading(BODIES);
        /// Never constrain the links to bodies that can exist. Without this option, the links are constrained if a log is poor
        /// and held-out parts of it are then predicted better.
        free_bodies: bool = false, heading(BODIES);
        ..
        /// Options shared with the method `essential`.
        samples: SamplesRequest;
    }
}

request! {
    /// Options of the estimator of [Vandanjon, Gautier, Desbats 1995]. Its equations are rows of the operator Sp.
    pub struct PaperRequest {
        /// Drive gain (torque per current), N m/A [default: as in the file; with [load], none]. If only some gains are given,
        /// the others are estimated.
        gain: Vec<(String, f64)> = Vec::new(), range(Range::Positive), value_name("COORDINATE=GAIN"), heading(METHOD);
        /// A known load: YAML with link, mass (kg), centre_of_mass (m) and inertia about the centre of mass (kg m^2). The logs
        /// of the experiments with the load, e01_loaded.csv, .., are in the folder of the other logs. With a load, no gain
        /// needs to be known.
        load: Option<(PathBuf, KnownLoad)> = None, value_name("FILE"), heading(METHOD);
        /// YAML with the columns of the logs.
        options: Option<Options> = None, value_name("FILE"), heading(METHOD);
    }
}

request! {
    /// Options of RIST-MH (the spectrum method with all harmonics of the motion, and with friction).
    pub struct HarmonicRequest {
        /// Highest frequency of the equations, Hz [default: Band::equations].
        cutoff: Option<f64> = None, default_from(HarmonicOptions::default().band.equations), range(Range::Positive), value_name("HZ"), heading(SIGNALS);
        /// Delay of the torques behind the positions, s; or auto, which estimates the remaining delay together with the
        /// parameters [default: Band::delay].
        delay: Option<Delay> = None, default_from(HarmonicOptions::default().band.delay), value_name("SECONDS"), heading(SIGNALS);
        /// Estimate ripple of torque and gain with this number of periods per turn of the joint, for one coordinate or for all.
        ripple: Vec<(JointSelector, f64)> = Vec::new(), value_name("[COORDINATE=]PERIODS"), heading(METHOD);
        /// Estimate a spring in parallel with the motor, for example one that balances gravity, for these coordinates or for
        /// all.
        spring: Vec<JointSelector> = Vec::new(), value_name("COORDINATE|all"), heading(METHOD);
        /// Estimate the error that an encoder has once per turn, for these coordinates or for all.
        eccentric: Vec<JointSelector> = Vec::new(), value_name("COORDINATE|all"), heading(METHOD);
        /// Estimate a spring between motor and link, for these coordinates or for all. It is assumed that the encoders are at
        /// the motors. The equations then end at 10 Hz, unless [cutoff] is given.
        elastic: Vec<JointSelector> = Vec::new(), value_name("COORDINATE|all"), heading(METHOD);
        /// Estimate the backlash between motor and link, for these coordinates or for all. The assumption and the equations are
        /// as for [elastic].
        backlash: Vec<JointSelector> = Vec::new(), value_name("COORDINATE|all"), heading(METHOD);
        ..
        /// Options shared with the paper's equations.
        paper: PaperRequest;
    }
}

request! {
    /// Options of the methods that simulate the experiments in closed loop.
    pub struct ClosedLoopRequest {
        /// Gain of every drive (torque per current), N m/A [default: as in the file].
        gain: Vec<(String, f64)> = Vec::new(), range(Range::Positive), value_name("COORDINATE=GAIN"), heading(METHOD);
        ..
        /// Options for processing logged signals: filter, sample rate, decimation, delay.
        signals: SignalRequest;
    }
}

impl SignalRequest {
    /// The options of the YAML file `options`. A field of the request replaces the same option of the file.
    pub fn options(&self) -> Options {
        let mut options = self.options.clone().unwrap_or_default();
        let signal = &mut options.signal;
        signal.cutoff = self.cutoff.or(signal.cutoff);
        signal.order = self.order.unwrap_or(signal.order);
        signal.decimate = self.decimate.or(signal.decimate);
        options.columns.rate = self.rate.or(options.columns.rate);
        if let Some(Delay::Seconds(seconds)) = self.delay {
            options.signal.delay = seconds;
        }
        options
    }
}

impl RowsRequest {
    /// A request with the options `options`; other fields have their defaults.
    pub fn of_options(options: Options) -> RowsRequest {
        let signals = SignalRequest { options: Some(options), ..SignalRequest::default() };
        RowsRequest { signals, ..RowsRequest::default() }
    }

    /// The options of the YAML file. A field of the request replaces the same option of the file. If the request asks to estimate
    /// the delay or to choose the friction terms, the option of the file stays.
    pub fn options(&self) -> Options {
        let mut options = self.signals.options();
        options.weights = self.weights.unwrap_or(options.weights);
        if let Some(terms) = self.friction.as_ref().and_then(FrictionChoice::terms) {
            options.friction = terms.to_vec();
        }
        options
    }

    /// The options for `rist accumulate`, which adds up regression rows and reads each row only once.
    ///
    /// Fails if an option needs the rows more than once.
    pub fn options_of_sums(&self) -> Result<Options, Error> {
        if self.signals.delay == Some(Delay::Auto) {
            return Err(Error::new(
                "[delay=auto]: the search goes over the rows many times, and sums have no rows: let [:identify] \
                 [delay=auto] find it on some of the logs, and give it here",
            ));
        }
        if self.friction == Some(FrictionChoice::Auto) {
            return Err(Error::new(
                "[friction=auto]: it goes over the rows once for each candidate, and sums have no rows; let [:identify] \
                 choose it on some of the logs, and give here what it chose",
            ));
        }
        if let Some(weights) = self.weights.filter(|weights| !weights.losses().is_empty()) {
            return Err(Error::new(format_args!(
                "[weights={}]: these weights follow from the residual of each row, and sums have no rows: take joint or \
                 none, or identify these logs in one go",
                Weights::word(weights)
            )));
        }
        Ok(self.options())
    }
}

impl IdentifyRequest {
    /// A request with the options `options`; other fields have their defaults.
    pub fn of_options(options: Options) -> IdentifyRequest {
        IdentifyRequest { samples: SamplesRequest::of_options(options), ..IdentifyRequest::default() }
    }
}

impl SamplesRequest {
    /// A request with the options `options`; other fields have their defaults.
    pub fn of_options(options: Options) -> SamplesRequest {
        SamplesRequest { rows: RowsRequest::of_options(options), ..SamplesRequest::default() }
    }

    /// The options of the YAML file. A field of the request replaces the same option of the file. If the request asks to estimate
    /// the delay or to choose the friction terms, the option of the file stays.
    pub fn options(&self) -> Options {
        let mut options = self.rows.options();
        options.covariance |= self.covariance;
        options
    }

    /// Whether the delay is estimated.
    pub fn finds_delay(&self) -> bool {
        self.rows.signals.delay == Some(Delay::Auto)
    }

    /// Whether neither the request nor its options file names friction terms, so that the standard terms apply.
    pub(crate) fn leaves_friction_open(&self) -> bool {
        self.rows.friction.is_none() && self.options().friction == FrictionTerm::STANDARD
    }

    /// Whether the friction terms are chosen automatically.
    pub fn finds_friction(&self) -> bool {
        self.rows.friction == Some(FrictionChoice::Auto)
    }
}

impl ClosedLoopRequest {
    /// The options of the closed-loop simulation and of the fit.
    ///
    /// Fails if the request asks to estimate the delay, or if its friction terms are not those of the joints in the simulation.
    pub fn options(&self) -> Result<Options, Error> {
        if self.signals.delay == Some(Delay::Auto) {
            return Err(Error::new("[delay=auto]: for [method=ls] and rist-mh; give the seconds that they find"));
        }
        let options = self.signals.options();
        match options.friction == FrictionTerm::STANDARD {
            true => Ok(options),
            false => Err(Error::new(
                "the simulated joints have viscous, Coulomb and offset friction alone: remove other terms from [options]",
            )),
        }
    }
}

impl PaperRequest {
    /// The column names of the logs, from the options.
    ///
    /// Fails if the options contain anything else, because the methods in closed loop would ignore it.
    pub fn columns(&self) -> Result<ColumnNames, Error> {
        let Some(given) = &self.options else { return Ok(ColumnNames::default()) };
        match *given == (Options { columns: given.columns.clone(), ..Options::default() }) {
            true => Ok(given.columns.clone()),
            false => Err(Error::new("[options]: the experiments of a plan take no options but columns")),
        }
    }
}
