//! A sampled reference motion (the commanded positions, velocities and accelerations), and its interpolation between the
//! samples.

use std::ops::Range;

/// A sampled reference motion: `q[k][i]`, `dq[k][i]`, `ddq[k][i]` of coordinate k at sample i.
#[derive(Clone, Debug, Default)]
pub struct Reference {
    /// Time between samples, s.
    pub sample_time: f64,
    /// Positions, rad (m), one series per coordinate.
    pub q: Vec<Vec<f64>>,
    /// Velocities, rad/s (m/s), one series per coordinate.
    pub dq: Vec<Vec<f64>>,
    /// Accelerations, rad/s^2 (m/s^2), one series per coordinate.
    pub ddq: Vec<Vec<f64>>,
    /// Ranges of sample indices that an identification uses: whole periods of a periodic motion, or the two sections of constant
    /// velocity of a slow motion there and back (sweep).
    pub windows: Vec<Range<usize>>,
}

impl Reference {
    /// The motion with `parts` times as many samples, interpolated by quintic polynomials that match q, dq and ddq at every
    /// sample.
    ///
    /// The windows of the result are in numbers of the new samples. If `parts` is one, the motion is unchanged.
    pub fn refined(&self, parts: usize) -> Reference {
        let count = self.q.first().map_or(0, Vec::len);
        if parts <= 1 || count == 0 {
            return self.clone();
        }
        let h = self.sample_time;
        let mut fine = Reference {
            sample_time: h / parts as f64,
            windows: self.windows.iter().map(|w| w.start * parts..w.end * parts).collect(),
            ..Reference::default()
        };
        for ((q, dq), ddq) in self.q.iter().zip(&self.dq).zip(&self.ddq) {
            let mut series: [Vec<f64>; 3] = Default::default();
            for i in 0..(count - 1) * parts + 1 {
                let (from, s) = (i / parts, (i % parts) as f64 / parts as f64);
                let to = (from + 1).min(count - 1);
                let ends = [from, to].map(|i| [q[i], h * dq[i], h * h * ddq[i]]);
                let [x, dx, ddx] = if i % parts == 0 { ends[0] } else { quintic(ends, s) };
                for (series, x) in series.iter_mut().zip([x, dx / h, ddx / (h * h)]) {
                    series.push(x);
                }
            }
            let [q, dq, ddq] = series;
            fine.q.push(q);
            fine.dq.push(dq);
            fine.ddq.push(ddq);
        }
        fine
    }
}

/// Value, first and second derivative at s in [0, 1] of a quintic polynomial. `ends`: these three quantities at s = 0 and at s =
/// 1.
fn quintic(ends: [[f64; 3]; 2], s: f64) -> [f64; 3] {
    let [[x0, v0, a0], [x1, v1, a1]] = ends;
    // The end values minus the values at s = 1 of the parabola with the given start values.
    let (x, v, a) = (x1 - x0 - v0 - 0.5 * a0, v1 - v0 - a0, a1 - a0);
    let (c3, c4, c5) = (10.0 * x - 4.0 * v + 0.5 * a, -15.0 * x + 7.0 * v - a, 6.0 * x - 3.0 * v + 0.5 * a);
    [
        x0 + s * (v0 + s * (0.5 * a0 + s * (c3 + s * (c4 + s * c5)))),
        v0 + s * (a0 + s * (3.0 * c3 + s * (4.0 * c4 + s * 5.0 * c5))),
        a0 + s * (6.0 * c3 + s * (12.0 * c4 + s * 20.0 * c5)),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn between_samples_it_is_the_motion() {
        let sampled = |h: f64, count: usize| {
            let at = |f: fn(f64) -> f64| vec![(0..count).map(|i| f(h * i as f64)).collect::<Vec<f64>>()];
            Reference {
                sample_time: h,
                q: at(|t| (3.0 * t).sin()),
                dq: at(|t| 3.0 * (3.0 * t).cos()),
                ddq: at(|t| -9.0 * (3.0 * t).sin()),
                windows: std::iter::once(10..90).collect(),
            }
        };
        let (coarse, fine) = (sampled(5e-3, 101), sampled(1e-3, 501));
        let refined = coarse.refined(5);
        assert_eq!(refined.windows.first(), Some(&(50..450)));
        // Errors of the quintic interpolation: in q, h^6 max|q^(6)| / 46080 = 2.5e-16, less than rounding; in ddq, h^4 max|q^(6)|
        // / 384 = 1.2e-9. h: sample time; q^(6): sixth derivative.
        for (series, bound) in
            [(|r| &r.q, 1e-14), (|r| &r.dq, 1e-11), (|r| &r.ddq, 5e-9)] as [(fn(&Reference) -> &Vec<Vec<f64>>, f64); 3]
        {
            let (a, b) = (&series(&refined)[0], &series(&fine)[0]);
            assert_eq!(a.len(), b.len());
            let worst = a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(worst < bound, "{worst} {bound}");
        }
    }
}
