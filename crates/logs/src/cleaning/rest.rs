//! How long a robot rests in a log.

/// At rest: no joint is faster than this, rad/s, over [`REST_SPAN_S`].
const REST_SPEED_RAD_S: f64 = 1e-3;
/// Span over which the speed at rest is taken, s.
const REST_SPAN_S: f64 = 0.05;

/// s at rest at the start, at the end, and in all, measured in spans of [`REST_SPAN_S`]. The remainder behind the
/// last span counts as a continuation of it.
pub(crate) fn time_at_rest(t: &[f64], q: &[Vec<f64>]) -> (f64, f64, f64) {
    let (mut before, mut after, mut total, mut r0) = (None, 0.0, 0.0, 0);
    for r in 1..t.len() {
        let span = t[r] - t[r0];
        if span < REST_SPAN_S {
            continue;
        }
        if q.iter().any(|q| (q[r] - q[r0]).abs() > REST_SPEED_RAD_S * span) {
            before.get_or_insert(t[r0] - t[0]);
            after = 0.0;
        } else {
            total += span;
            after += span;
        }
        r0 = r;
    }
    let behind = t[t.len() - 1] - t[r0];
    if after > 0.0 {
        (after, total) = (after + behind, total + behind);
    }
    let all = t[t.len() - 1] - t[0];
    match before {
        Some(before) => (before, after, total),
        None if total > 0.0 => (all, all, all),
        // Shorter than a span: nothing is known.
        None => (0.0, 0.0, 0.0),
    }
}
