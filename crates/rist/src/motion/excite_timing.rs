//! The period and the blend of an exciting motion.

use experiments::excitation::fourier_series::FourierSeries;
use experiments::excitation::limits::CoordinateLimits;
use experiments::excitation::motion::Shape;
use experiments::excitation::quintic_spline::QuinticSpline;
use experiments::motion::sample_count::check_samples;

use crate::error::Error;
use crate::request::{ExciteRequest, Family};

/// Instants a period, for each harmonic. They are enough to distinguish products of three harmonics.
const SAMPLED_INSTANTS: usize = 30;
/// The highest frequency over the rate: ten samples a period.
const HIGHEST_SHARE_OF_RATE: f64 = 0.1;
/// Instants a span of a spline: what its limits do in between costs less than a hundredth.
const SPAN_INSTANTS: usize = 10;

/// The median over the joints that move.
fn middle(limits: &[CoordinateLimits], of: impl Fn(&CoordinateLimits) -> f64) -> f64 {
    let mut all: Vec<f64> = limits.iter().filter(|l| l.locked.is_none()).map(of).collect();
    all.sort_by(f64::total_cmp);
    all.get(all.len() / 2).copied().unwrap_or(0.0)
}

/// The period by the limits, s: 5 to 20 s, the longer of two periods, each the median of the joints. In one the
/// fundamental fills the range of positions at the greatest velocity. In the other the highest harmonic reaches the
/// greatest velocity and acceleration together.
pub fn default_period(limits: &[CoordinateLimits], harmonics: usize) -> f64 {
    let turn = std::f64::consts::TAU;
    let room = middle(limits, |l| turn * 0.5 * (l.position.1 - l.position.0) / l.velocity);
    let speed = middle(limits, |l| turn * harmonics as f64 * l.velocity / l.acceleration);
    room.max(speed).clamp(5.0, 20.0)
}

/// Harmonics by which the default period is told, and the least by default.
const FEW_HARMONICS: usize = 5;
/// The most by default.
const MANY_HARMONICS: usize = 8;
/// With more joints that move a search with many harmonics takes minutes.
const FEW_JOINTS: usize = 8;
/// Beyond the harmonic at which velocity and acceleration reach their limits together, others still tell something.
const BEYOND_CORNER: f64 = 1.5;

/// Harmonics by the limits, 5 to 8: as many as the median joint makes use of in this period. On a UR5 eight tell a quarter
/// more than five.
fn default_harmonics(limits: &[CoordinateLimits], period: f64, rate: f64) -> usize {
    if limits.iter().filter(|l| l.locked.is_none()).count() > FEW_JOINTS {
        return FEW_HARMONICS;
    }
    let corner = middle(limits, |l| l.acceleration / (std::f64::consts::TAU * l.velocity));
    let told = (BEYOND_CORNER * corner * period).min(HIGHEST_SHARE_OF_RATE * rate * period);
    (told.round() as usize).clamp(FEW_HARMONICS, MANY_HARMONICS)
}

/// Spans of a spline by the limits, 8 to 30. Each is one and a half times as long as the median joint takes from rest
/// to its greatest velocity. The limits would leave more spans nearly idle, and the time of a search grows with their
/// cube.
fn default_spans(limits: &[CoordinateLimits], period: f64) -> usize {
    let rise = middle(limits, |l| l.velocity / l.acceleration);
    (period / (1.5 * rise)).round().clamp(8.0, 30.0) as usize
}

/// The blend by the limits, s: the longest time from rest to the greatest velocity at four tenths of the greatest
/// acceleration.
fn default_blend(limits: &[CoordinateLimits]) -> f64 {
    let moving = limits.iter().filter(|l| l.locked.is_none());
    moving.map(|l| 2.5 * l.velocity / l.acceleration).fold(0.5, f64::max)
}

/// The shape, its times rounded to whole numbers of samples, and the number of instants a period that the search looks
/// at.
///
/// Fails where the rate is too low for the highest frequency of the shape, and where there are more samples than a file
/// holds.
pub(crate) fn timing(request: &ExciteRequest, limits: &[CoordinateLimits]) -> Result<(Shape, usize), Error> {
    let tenths = |x: f64| (10.0 * x).ceil() / 10.0;
    let whole = |x: f64| (x * request.rate).round().max(1.0) / request.rate;
    let or_default = |harmonics| whole(request.seconds().unwrap_or_else(|| tenths(default_period(limits, harmonics))));
    let usual_period = or_default(FEW_HARMONICS);
    // (shape, instants, name of the fastest part, its frequency in Hz).
    let (shape, samples, quickest, highest) = match request.family()? {
        Family::Fourier { blend, harmonics } => {
            let period = harmonics.map_or(usual_period, or_default);
            let harmonics = harmonics.unwrap_or_else(|| default_harmonics(limits, period, request.rate));
            let blend = whole(blend.unwrap_or_else(|| tenths(default_blend(limits))));
            let series = FourierSeries { period, blend, harmonics };
            let samples = (SAMPLED_INSTANTS * harmonics).max(100);
            (Shape::Fourier(series), samples, "the highest harmonic", harmonics as f64 / period)
        }
        Family::Spline { spans } => {
            let period = usual_period;
            let spans = spans.unwrap_or_else(|| default_spans(limits, period));
            // There and back takes four spans.
            let highest = spans as f64 / (4.0 * period);
            (Shape::Spline(QuinticSpline { period, spans }), SPAN_INSTANTS * spans, "a swing of four spans", highest)
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
