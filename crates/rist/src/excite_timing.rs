//! The period and the blend of an exciting motion.

use identification::experiments::excitation::fourier_series::FourierSeries;
use identification::experiments::excitation::limits::CoordinateLimits;
use identification::experiments::excitation::motion::Shape;
use identification::experiments::excitation::quintic_spline::QuinticSpline;

use crate::error::Error;
use crate::excite_request::{ExciteRequest, Family};

/// Instants a period, for each harmonic: products of three harmonics are still told apart.
const INSTANTS: usize = 30;
/// Instants a span of a spline: what its limits do in between costs less than a hundredth.
const SPAN_INSTANTS: usize = 10;

/// The period by the limits, s: the fundamental fills the room at the greatest velocity, or as many half-waves take the
/// greatest velocity and acceleration together, whichever is longer; the middle one of the joints, 5 to 20 s.
pub fn default_period(limits: &[CoordinateLimits], half_waves: usize) -> f64 {
    let moving = || limits.iter().filter(|l| l.locked.is_none());
    let middle = |of: &dyn Fn(&CoordinateLimits) -> f64| {
        let mut all: Vec<f64> = moving().map(of).collect();
        all.sort_by(f64::total_cmp);
        all.get(all.len() / 2).copied().unwrap_or(0.0)
    };
    let turn = std::f64::consts::TAU;
    let room = middle(&|l| turn * 0.5 * (l.position.1 - l.position.0) / l.velocity);
    let speed = middle(&|l| turn * (0.5 * half_waves as f64) * l.velocity / l.acceleration);
    room.max(speed).clamp(5.0, 20.0)
}

/// The blend by the limits, s: from rest to the greatest velocity at four tenths of the greatest acceleration.
fn default_blend(limits: &[CoordinateLimits]) -> f64 {
    let moving = limits.iter().filter(|l| l.locked.is_none());
    moving.map(|l| 2.5 * l.velocity / l.acceleration).fold(0.5, f64::max)
}

/// The shape, its times whole numbers of samples, and the instants of a period at which the search looks.
///
/// Fails where the rate is too low for the quickest that the shape can be.
pub(crate) fn timing(request: &ExciteRequest, limits: &[CoordinateLimits]) -> Result<(Shape, usize), Error> {
    let tenths = |x: f64| (10.0 * x).ceil() / 10.0;
    let whole = |x: f64| (x * request.rate).round().max(1.0) / request.rate;
    let half_waves = request.family.half_waves();
    let period = whole(request.period.unwrap_or_else(|| tenths(default_period(limits, half_waves))));
    let highest = 0.5 * half_waves as f64 / period;
    if highest > 0.1 * request.rate {
        let what = match request.family {
            Family::Fourier { .. } => "the highest harmonic",
            Family::Spline { .. } => "the quickest swing of four spans",
        };
        return Err(Error::new(format_args!(
            "{what}, {highest:.3} Hz, needs ten samples a period: raise --rate ({} Hz) or --period ({period} s)",
            request.rate
        )));
    }
    Ok(match request.family {
        Family::Fourier { blend, harmonics } => {
            let blend = whole(blend.unwrap_or_else(|| tenths(default_blend(limits))));
            let series = FourierSeries { period, blend, harmonics };
            (Shape::Fourier(series), (INSTANTS * harmonics).max(100))
        }
        Family::Spline { spans } => (Shape::Spline(QuinticSpline { period, spans }), SPAN_INSTANTS * spans),
    })
}
