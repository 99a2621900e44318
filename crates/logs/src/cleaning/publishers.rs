//! Finds rows of a second source between the rows of the first, for example from two publishers on one topic.
//!
//! A signal x jumps at row r and returns if x_r is far from x_(r-1) and x_(r+1), and these two are near each other. A row is
//! foreign (from another source) if at least half of all torques and velocities jump there and return. Other causes are
//! excluded: a spike is rare, a coarse encoder affects one joint at a time, and a limit cycle of the controller affects only
//! the torques.

/// Smallest jump of a signal, in standard deviations of the signal.
const MIN_JUMP_SIGMAS: f64 = 0.5;
/// After the return, the signal differs from its value before the jump by at most this fraction of the jump.
const MAX_RETURN_SHARE: f64 = 0.1;
/// Smallest share of foreign rows. Noise alone gives up to 5 % in one signal, and less in several signals together.
const FOREIGN_ROWS_SHARE: f64 = 0.15;
/// If the torques are zero in more than this share of the foreign rows, the second source writes zeros.
const ZERO_SHARE: f64 = 0.9;
/// Smallest number of rows for a decision.
const MIN_ROWS_FOR_SOURCES: usize = 100;

/// Number of foreign rows, and whether their torques are all zero. The number is zero if it is too small for a second source.
///
/// If the rows of two sources alternate, every row differs from its neighbours, so half of the rows are counted.
///
/// Without velocities, a row counts only if its torques are all zero, because torques may also alternate for other reasons.
pub(crate) fn foreign_rows(velocities: Option<&[Vec<f64>]>, efforts: &[Vec<f64>]) -> (usize, bool) {
    let rows = efforts.first().map_or(0, Vec::len);
    if rows < MIN_ROWS_FOR_SOURCES {
        return (0, false);
    }
    let are_zero = |r: usize| efforts.iter().all(|x| x[r] == 0.0);
    let torques = leaving(efforts);
    // A foreign row is always visible in the torques, so these are tested first.
    if (torques.iter().filter(|count| **count > 0).count() as f64) < FOREIGN_ROWS_SHARE * rows as f64 {
        return (0, false);
    }
    let speeds = velocities.map(|group| (leaving(group), group.len()));
    let is_foreign = |r: &usize| match &speeds {
        Some((speeds, count)) => {
            let [torque, speed] = [torques[*r], speeds[*r]];
            torque > 0 && speed > 0 && 2 * (torque + speed) >= efforts.len() + count
        }
        None => 2 * torques[*r] >= efforts.len() && are_zero(*r),
    };
    let foreign: Vec<usize> = (1..rows - 1).filter(is_foreign).collect();
    if (foreign.len() as f64) < FOREIGN_ROWS_SHARE * rows as f64 {
        return (0, false);
    }
    let zeros = foreign.iter().filter(|r| are_zero(**r)).count();
    let count = foreign.len().min(rows / 2);
    // If the rows of two sources alternate, half of the foreign rows are zero.
    if zeros as f64 > ZERO_SHARE * count as f64 { (zeros, true) } else { (count, false) }
}

/// For each row, the number of signals that jump there and return.
fn leaving(group: &[Vec<f64>]) -> Vec<usize> {
    let mut leaving = vec![0; group.first().map_or(0, Vec::len)];
    for x in group {
        let n = x.len() as f64;
        let mean = sum(x, |x| x) / n;
        let far = MIN_JUMP_SIGMAS * (sum(x, |x| (x - mean) * (x - mean)) / n).sqrt();
        for (w, count) in x.windows(3).zip(&mut leaving[1..]) {
            let (before, after) = (w[1] - w[0], w[1] - w[2]);
            let left = before.abs().min(after.abs());
            *count += usize::from(before * after > 0.0 && left > far && (w[2] - w[0]).abs() < MAX_RETURN_SHARE * left);
        }
    }
    leaving
}

/// The sum of `of(x)` in eight SIMD lanes. In a single sum, each addition would wait for the previous one.
fn sum(x: &[f64], of: impl Fn(f64) -> f64) -> f64 {
    let (eights, rest) = x.as_chunks::<8>();
    let mut lanes = [0.0; 8];
    for eight in eights {
        lanes.iter_mut().zip(eight).for_each(|(lane, x)| *lane += of(*x));
    }
    lanes.iter().sum::<f64>() + rest.iter().map(|x| of(*x)).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chance(i: usize, seed: f64) -> f64 {
        2.0 * ((12.9898 * i as f64 + seed).sin() * 43_758.545_3).rem_euclid(1.0) - 1.0
    }

    /// Two signals of a motion, with added noise.
    fn signals(seed: f64) -> Vec<Vec<f64>> {
        let of =
            |k: usize, i: usize| (0.01 * (k + 1) as f64 * i as f64 + seed).sin() + 0.02 * chance(i, seed + k as f64);
        (0..2).map(|k| (0..2000).map(|i| of(k, i)).collect()).collect()
    }

    #[test]
    fn rows_of_a_second_source_are_counted() {
        let (speed, torque) = (signals(1.0), signals(2.0));
        assert_eq!(foreign_rows(Some(&speed), &torque), (0, false));
        // In every second or third row, the values are replaced by zeros, or by scaled values with an offset.
        for every in [2, 3] {
            for (scale, offset) in [(0.0, 0.0), (0.1, 3.0)] {
                let mixed = |x: &Vec<Vec<f64>>| -> Vec<Vec<f64>> {
                    let row = |(i, x): (usize, &f64)| if i % every == 1 { scale * x + offset } else { *x };
                    x.iter().map(|x| x.iter().enumerate().map(row).collect()).collect()
                };
                let (found, are_zero) = foreign_rows(Some(&mixed(&speed)), &mixed(&torque));
                assert_eq!(are_zero, scale == 0.0, "{every} {scale}");
                assert!((1000 / every..=2000 / every).contains(&found), "{every} {scale}: {found}");
                let (alone, _) = foreign_rows(None, &mixed(&torque));
                assert_eq!(alone > 1000 / every, scale == 0.0, "{every} {scale}: {alone}");
            }
        }
    }

    #[test]
    fn other_signals_are_of_one_source() {
        let (speed, torque) = (signals(1.0), signals(2.0));
        let noise: Vec<Vec<f64>> = (0..2).map(|k| (0..2000).map(|i| chance(i, k as f64)).collect()).collect();
        let changed = |by: fn((usize, &f64)) -> f64| -> Vec<Vec<f64>> {
            torque.iter().map(|x| x.iter().enumerate().map(by).collect()).collect()
        };
        let spikes = changed(|(i, x)| if i % 20 == 3 { 9.0 } else { *x });
        let chatter = changed(|(i, x)| x + if i % 2 == 0 { 2.0 } else { -2.0 });
        let coarse = |slope: f64| {
            (0..2000).map(|i| (slope * f64::from(i)).floor() - (slope * f64::from(i - 1)).floor()).collect()
        };
        let coarse: Vec<Vec<f64>> = [0.3, 0.23].map(coarse).to_vec();
        for (speed, torque) in
            [(&noise, &noise), (&speed, &spikes), (&speed, &chatter), (&coarse, &torque), (&coarse, &noise)]
        {
            assert_eq!(foreign_rows(Some(speed), torque).0, 0);
        }
        assert_eq!([&chatter[..], &noise, &[]].map(|x| foreign_rows(None, x).0), [0; 3]);
    }
}
