//! The period and the blend of an exciting motion.

use identification::experiments::excitation::barrier::Timing;
use identification::experiments::excitation::limits::CoordinateLimits;

use crate::error::Error;
use crate::excite_request::ExciteRequest;

/// Instants a period, for each harmonic: products of three harmonics are still told apart.
const INSTANTS: usize = 30;

/// The period by the limits, s: the fundamental fills the room at the greatest velocity, or the highest harmonic takes
/// the greatest velocity and acceleration together, whichever is longer; the middle one of the joints, 5 to 20 s.
pub fn default_period(limits: &[CoordinateLimits], harmonics: usize) -> f64 {
    let moving = || limits.iter().filter(|l| l.locked.is_none());
    let middle = |of: &dyn Fn(&CoordinateLimits) -> f64| {
        let mut all: Vec<f64> = moving().map(of).collect();
        all.sort_by(f64::total_cmp);
        all.get(all.len() / 2).copied().unwrap_or(0.0)
    };
    let turn = std::f64::consts::TAU;
    let room = middle(&|l| turn * 0.5 * (l.position.1 - l.position.0) / l.velocity);
    let speed = middle(&|l| turn * harmonics as f64 * l.velocity / l.acceleration);
    room.max(speed).clamp(5.0, 20.0)
}

/// The blend by the limits, s: from rest to the greatest velocity at four tenths of the greatest acceleration.
fn default_blend(limits: &[CoordinateLimits]) -> f64 {
    let moving = limits.iter().filter(|l| l.locked.is_none());
    moving.map(|l| 2.5 * l.velocity / l.acceleration).fold(0.5, f64::max)
}

/// Times that are whole numbers of samples.
///
/// Fails where the rate is too low for the highest harmonic.
pub(crate) fn timing(request: &ExciteRequest, limits: &[CoordinateLimits]) -> Result<Timing, Error> {
    let tenths = |x: f64| (10.0 * x).ceil() / 10.0;
    let whole = |x: f64| (x * request.rate).round().max(1.0) / request.rate;
    let period = whole(request.period.unwrap_or_else(|| tenths(default_period(limits, request.harmonics))));
    let blend = whole(request.blend.unwrap_or_else(|| tenths(default_blend(limits))));
    let highest = request.harmonics as f64 / period;
    if highest > 0.1 * request.rate {
        return Err(Error::new(format_args!(
            "the highest harmonic, {highest:.3} Hz, needs ten samples a period: raise --rate ({} Hz) or --period ({period} s)",
            request.rate
        )));
    }
    Ok(Timing { period, blend, harmonics: request.harmonics, samples: (INSTANTS * request.harmonics).max(100) })
}
