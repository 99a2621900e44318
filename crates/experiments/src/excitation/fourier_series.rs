//! A finite Fourier series of one coordinate, with blends from rest to the series and back to rest.
//!
//! ```text
//! q(t) = c + sum_l a_l / (w l) sin(w l t) - b_l / (w l) cos(w l t),   l = 1 .. H,   w = 2 pi / T
//! ```
//! [Swevers, Ganseman, Tukel, De Schutter, Van Brussel 1997], over whole periods. a and b are amplitudes of the velocity. A blend
//! of D seconds leads from rest to the series, and another one from the series to rest. Each blend is a polynomial of at most
//! fifth degree. At one end it has the position, velocity v and acceleration a of the series; at the other end velocity and
//! acceleration are zero. The first blend starts at the position s = q(0) - D v/2 + D^2 a/12, for which the term of fifth degree
//! vanishes. Its Bernstein control points are s, s, s, q(0) - D v/4, q(0). The acceleration is continuous and the jerk is
//! bounded. Every quantity is linear in (c, a_1, b_1, a_2, b_2, ..).

/// Period, number of harmonics, and duration of the blends (polynomials from rest to the series and back) of a motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FourierSeries {
    /// Period T, s.
    pub period: f64,
    /// Duration D of a blend (polynomial from rest to the series, or back), s.
    pub blend: f64,
    /// Number of harmonics H.
    pub harmonics: usize,
}

impl FourierSeries {
    /// Factors of the coefficients (c, a_1, b_1, ..) in the k-th derivative of the series, at time `t` in a period, s.
    pub fn row(&self, t: f64, k: usize) -> Vec<f64> {
        let w = std::f64::consts::TAU / self.period;
        let mut row = vec![f64::from(u8::from(k == 0))];
        for l in 1..=self.harmonics {
            let wl = w * l as f64;
            let (s, c) = libm::sincos(wl * t);
            let scale = wl.powi(k as i32 - 1);
            // Factors of the sine and cosine amplitudes: d^k sin x / dx^k and d^k (-cos x) / dx^k.
            let (a, b) = match k % 4 {
                0 => (s, -c),
                1 => (c, s),
                2 => (-s, c),
                _ => (-c, -s),
            };
            row.extend([scale * a, scale * b]);
        }
        row
    }

    /// Bernstein control points of the k-th derivative of a blend (polynomial of degree 4 from rest to the series, or back), k <=
    /// 3. The derivative has degree 4 - k. Each control point is given by its factors of the coefficients (c, a_1, b_1, ..).
    pub(crate) fn blend_control(&self, k: usize, is_start: bool) -> Vec<Vec<f64>> {
        let blend = self.blend;
        let [q, v, a] = [0, 1, 2].map(|k| self.row(0.0, k));
        let along = |sv: f64, sa: f64| -> Vec<f64> { (0..q.len()).map(|j| q[j] + sv * v[j] + sa * a[j]).collect() };
        let sign = if is_start { -1.0 } else { 1.0 };
        let (rest, near) = (along(0.5 * sign * blend, blend * blend / 12.0), along(0.25 * sign * blend, 0.0));
        let mut points = vec![rest.clone(), rest.clone(), rest, near, q];
        if !is_start {
            points.reverse();
        }
        for degree in (4 - k + 1..=4).rev() {
            let difference = |p: &[Vec<f64>]| -> Vec<f64> {
                p[0].iter().zip(&p[1]).map(|(x, y)| degree as f64 / blend * (y - x)).collect()
            };
            points = points.windows(2).map(difference).collect();
        }
        points
    }

    /// Factors of the coefficients (c, a_1, b_1, ..) in the k-th derivative of a blend (polynomial from rest to the series, or
    /// back), at the fraction u in [0, 1] of its duration.
    pub(crate) fn blend_row(&self, k: usize, is_start: bool, u: f64) -> Vec<f64> {
        casteljau(self.blend_control(k, is_start), u)
    }
}

/// The value at u in [0, 1] of the Bernstein polynomial with these control points, by de Casteljau's algorithm.
fn casteljau(mut points: Vec<Vec<f64>>, u: f64) -> Vec<f64> {
    while points.len() > 1 {
        let between =
            |p: &[Vec<f64>]| -> Vec<f64> { p[0].iter().zip(&p[1]).map(|(x, y)| (1.0 - u) * x + u * y).collect() };
        points = points.windows(2).map(between).collect();
    }
    points.pop().unwrap_or_default()
}
