//! Chooses the timing of an exciting motion: period, blend (time from rest to the motion), number of harmonics or spans.
//!
//! A Fourier motion consists of harmonics of a base frequency; a spline consists of spans (polynomial segments). The defaults
//! follow from the limits of the joints; `middle` takes the median over the joints. Instants are the times at which the search
//! evaluates the motion.

use experiments::excitation::fourier_series::FourierSeries;
use experiments::excitation::limits::CoordinateLimits;
use experiments::excitation::motion::MotionShape;
use experiments::excitation::quintic_spline::QuinticSpline;
use experiments::motion::sample_count::check_samples;

use crate::error::Error;
use crate::request::{ExciteRequest, MotionFamily};

/// Number of instants per period of the highest harmonic. With this number, products of three harmonics are resolved.
const INSTANTS_PER_HARMONIC: usize = 30;
/// Least number of instants per period of a Fourier series.
const LEAST_INSTANTS: usize = 100;
/// Highest allowed frequency divided by the sample rate: at least ten samples per period.
const HIGHEST_SHARE_OF_RATE: f64 = 0.1;
/// Number of instants per span of a spline. Between the instants, limits are exceeded by less than one per cent.
const INSTANTS_PER_SPAN: usize = 10;

/// The median of the quantity `of` over the joints that move.
fn middle(limits: &[CoordinateLimits], of: impl Fn(&CoordinateLimits) -> f64) -> f64 {
    let mut all: Vec<f64> = limits.iter().filter(|l| l.locked.is_none()).map(of).collect();
    all.sort_by(f64::total_cmp);
    all.get(all.len() / 2).copied().unwrap_or(0.0)
}

/// Range of the default period, s.
const SHORTEST_PERIOD_S: f64 = 5.0;
const LONGEST_PERIOD_S: f64 = 20.0;

/// The default period, s: the longer of two periods (each the median over the joints), limited to 5 to 20 s. With the first
/// period, the fundamental reaches the position limits and the velocity limit at once. With the second period, the highest
/// harmonic reaches the velocity limit and the acceleration limit at once.
pub fn default_period(limits: &[CoordinateLimits], harmonics: usize) -> f64 {
    let turn = std::f64::consts::TAU;
    let room = middle(limits, |l| turn * 0.5 * (l.position.1 - l.position.0) / l.velocity);
    let speed = middle(limits, |l| turn * harmonics as f64 * l.velocity / l.acceleration);
    room.max(speed).clamp(SHORTEST_PERIOD_S, LONGEST_PERIOD_S)
}

/// Number of harmonics with which the default period is computed, and the smallest default number.
const FEW_HARMONICS: usize = 5;
/// Largest number of harmonics by default.
const MANY_HARMONICS: usize = 8;
/// Largest number of moving joints for which more harmonics than the minimum are used by default. With more joints, the search
/// would take minutes.
const FEW_JOINTS: usize = 8;
/// Highest useful frequency, divided by the frequency at which a joint reaches its velocity limit and its acceleration limit at
/// once.
const CORNER_FREQUENCY_FACTOR: f64 = 1.5;

/// The default number of harmonics, 5 to 8: the number that the median joint can use in this period. On a UR5, eight harmonics
/// give a quarter more information than five.
fn default_harmonics(limits: &[CoordinateLimits], period: f64, rate: f64) -> usize {
    if limits.iter().filter(|l| l.locked.is_none()).count() > FEW_JOINTS {
        return FEW_HARMONICS;
    }
    let corner = middle(limits, |l| l.acceleration / (std::f64::consts::TAU * l.velocity));
    let useful_harmonics = (CORNER_FREQUENCY_FACTOR * corner * period).min(HIGHEST_SHARE_OF_RATE * rate * period);
    (useful_harmonics.round() as usize).clamp(FEW_HARMONICS, MANY_HARMONICS)
}

/// Duration of a span, divided by the time from rest to the largest velocity.
const SPAN_OVER_RISE: f64 = 1.5;
/// Range of the default number of spans.
const LEAST_SPANS: f64 = 8.0;
const LARGEST_SPANS: f64 = 30.0;

/// The default number of spans of a spline, 8 to 30. A span takes 1.5 times the time in which the median joint reaches its
/// largest velocity from rest. More spans would make the motion in each span small, and the search time grows with the cube of
/// the number of spans.
fn default_spans(limits: &[CoordinateLimits], period: f64) -> usize {
    let rise = middle(limits, |l| l.velocity / l.acceleration);
    (period / (SPAN_OVER_RISE * rise)).round().clamp(LEAST_SPANS, LARGEST_SPANS) as usize
}

/// Duration of the blend (time from rest to the motion), divided by the time from rest to the largest velocity at the largest
/// acceleration.
const BLEND_OVER_RISE: f64 = 2.5;
/// Shortest default blend (time from rest to the motion), s.
const SHORTEST_BLEND_S: f64 = 0.5;

/// The default duration of the blend (time from rest to the motion), s: each joint needs some time from rest to its largest
/// velocity, at 0.4 of its largest acceleration; the longest of these times is taken, but at least 0.5 s.
fn default_blend(limits: &[CoordinateLimits]) -> f64 {
    let moving = limits.iter().filter(|l| l.locked.is_none());
    moving.map(|l| BLEND_OVER_RISE * l.velocity / l.acceleration).fold(SHORTEST_BLEND_S, f64::max)
}

/// The shape of the motion, with times rounded to whole samples, and the number of instants per period that the search
/// evaluates.
///
/// Fails if the sample rate is too low for the highest frequency of the shape, or if the motion has more samples than a file
/// can hold.
pub(crate) fn timing(request: &ExciteRequest, limits: &[CoordinateLimits]) -> Result<(MotionShape, usize), Error> {
    let tenths = |x: f64| (10.0 * x).ceil() / 10.0;
    let whole = |x: f64| (x * request.rate).round().max(1.0) / request.rate;
    let or_default = |harmonics| whole(request.seconds().unwrap_or_else(|| tenths(default_period(limits, harmonics))));
    let usual_period = or_default(FEW_HARMONICS);
    // Each entry: (shape, number of instants, name of the fastest component, frequency of this component in Hz).
    let (shape, samples, quickest, highest) = match request.family()? {
        MotionFamily::Fourier { blend, harmonics } => {
            let period = harmonics.map_or(usual_period, or_default);
            let harmonics = harmonics.unwrap_or_else(|| default_harmonics(limits, period, request.rate));
            let blend = whole(blend.unwrap_or_else(|| tenths(default_blend(limits))));
            let series = FourierSeries { period, blend, harmonics };
            let samples = (INSTANTS_PER_HARMONIC * harmonics).max(LEAST_INSTANTS);
            (MotionShape::Fourier(series), samples, "the highest harmonic", harmonics as f64 / period)
        }
        MotionFamily::Spline { spans } => {
            let period = usual_period;
            let spans = spans.unwrap_or_else(|| default_spans(limits, period));
            // The fastest oscillation of a spline has a period of four spans.
            let highest = spans as f64 / (4.0 * period);
            let shape = MotionShape::Spline(QuinticSpline { period, spans });
            (shape, INSTANTS_PER_SPAN * spans, "a swing of four spans", highest)
        }
    };
    if highest > HIGHEST_SHARE_OF_RATE * request.rate {
        return Err(Error::new(format_args!(
            "{quickest}, {highest:.3} Hz, needs ten samples a period: raise [rate] ({} Hz) or [period] ({} s)",
            request.rate,
            shape.period()
        )));
    }
    check_samples((2.0 * shape.blend() + request.repetitions as f64 * shape.period()) * request.rate).map_err(|what| {
        Error::new(format_args!(
            "{what}; a period takes {:.4e} s and a blend {:.4e} s (by the limits of velocity and acceleration where [period] \
             and [blend] do not say it): lower [rate], [period], [blend] or [repetitions]",
            shape.period(),
            shape.blend()
        ))
    })?;
    Ok((shape, samples))
}
