//! When a joint stands still.
//!
//! Stiction is not in the model. A joint at rest carries any torque up to its Coulomb friction, so its rows are wrong.
//! A reversal is no standstill, because it is over in less than `STANDSTILL_SPAN_S`.

/// Time for which a joint must stay within [`STANDSTILL_BAND`], s.
const STANDSTILL_SPAN_S: f64 = 0.2;

/// Width of the band, rad (m). It is 1e-3 rad/s over the span.
const STANDSTILL_BAND: f64 = 2e-4;

/// Tells for each sample of a position whether it belongs to a span in which the position stays within the band.
pub fn standstill(q: &[f64], period: f64) -> Vec<bool> {
    let span = ((STANDSTILL_SPAN_S / period).ceil() as usize).max(2);
    let mut still = vec![false; q.len()];
    let mut first = 0;
    while first + span <= q.len() {
        if (q[first + span - 1] - q[first]).abs() > STANDSTILL_BAND {
            first += 1;
            continue;
        }
        let (mut low, mut high) = (q[first], q[first]);
        let mut stays = |&x: &f64| {
            (low, high) = (low.min(x), high.max(x));
            high - low <= STANDSTILL_BAND
        };
        let length = q[first..].iter().take_while(|x| stays(x)).count();
        if length >= span {
            still[first..first + length].fill(true);
            first += length;
        } else {
            first += 1;
        }
    }
    still
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rest_is_found_and_reversals_are_not() {
        let period = 0.01;
        // At rest for 1 s, a swing of 2 s at up to 0.05 rad/s, at rest again.
        let position = |i: usize| {
            let t = (i as f64 * period - 1.0).clamp(0.0, 2.0);
            0.3 + 0.05 / std::f64::consts::PI * (1.0 - (std::f64::consts::PI * t).cos())
        };
        let q: Vec<f64> = (0..400).map(position).collect();
        let still = standstill(&q, period);
        let moving = |r: std::ops::Range<usize>| still[r].iter().filter(|s| !**s).count();
        assert_eq!(moving(0..100), 0);
        // The reversal at 2 s is no standstill. The start and the end of the swing hardly move and are not checked.
        assert_eq!(moving(120..280), 160);
        assert_eq!(moving(300..400), 0);
        // At ten times the speed of the band nothing stands still, nor does a record shorter than the span.
        let slow: Vec<f64> = (0..500).map(|i| 1e-2 * period * i as f64).collect();
        assert!(!standstill(&slow, period).contains(&true));
        assert!(!standstill(&[1.0; 10], period).contains(&true));
    }
}
