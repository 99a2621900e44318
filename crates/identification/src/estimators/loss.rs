//! Loss functions of robust regression: Huber's and Tukey's (bisquare).
//!
//! u = residual / s_j, s_j: scale of the residuals of joint j; psi(u) = w(u) u: influence function, psi': its derivative. k and
//! c are the bounds beyond which a row counts as an outlier.
//!
//! | loss | weight w(u) | psi'(u), psi = w u | bound |
//! |---|---|---|---|
//! | Huber | 1, beyond k: k / abs u | 1, beyond k: 0 | k = 1.345 |
//! | bisquare | (1 - (u/c)^2)^2, beyond c: 0 | (1 - (u/c)^2)(1 - 5 (u/c)^2), beyond c: 0 | c = 4.685 |
//!
//! Both have 95 % of the efficiency of least squares for normal noise. Huber's loss bounds the influence of a row: one-sided
//! outliers shift the estimate by k times their share. Tukey's loss removes outliers completely. The sum of Tukey's losses has
//! several minima; the minimum nearest to Huber's solution is taken. [Huber 1981, 7.6; Holland, Welsch 1977; Yohai 1987]

/// A loss function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Loss {
    /// Huber's loss: the square of u up to the bound, then proportional to |u|.
    Huber,
    /// Tukey's bisquare loss: like the square near zero, constant beyond the bound. Rows beyond the bound have weight zero.
    Bisquare,
}

impl Loss {
    /// Words for the output that say how much a row beyond the bound counts.
    pub fn beyond(self) -> &'static str {
        match self {
            Loss::Huber => "less than fully",
            Loss::Bisquare => "nothing",
        }
    }

    /// The bound of |u|. If |u| is larger, the weight is below 1 (Huber) or zero (bisquare).
    pub fn bound(self) -> f64 {
        match self {
            Loss::Huber => 1.345,
            Loss::Bisquare => 4.685,
        }
    }

    /// The weight w(u) of a row, between 0 and 1.
    pub fn weight(self, u: f64) -> f64 {
        let v = (u / self.bound()).abs();
        match self {
            _ if !u.is_finite() => 1.0,
            Loss::Huber => 1.0 / v.max(1.0),
            Loss::Bisquare => (1.0 - v * v).max(0.0).powi(2),
        }
    }

    /// The derivative psi'(u) of the influence function psi(u) = w(u) u.
    pub fn slope(self, u: f64) -> f64 {
        let v = (u / self.bound()).abs();
        match self {
            _ if v > 1.0 => 0.0,
            Loss::Huber => 1.0,
            Loss::Bisquare => (1.0 - v * v) * (1.0 - 5.0 * v * v),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks that psi' is the derivative of psi, and that the efficiency for normal noise, (mean psi')^2 / mean psi^2, is 95 %.
    #[test]
    fn the_bounds_are_those_of_95_percent() {
        for loss in [Loss::Huber, Loss::Bisquare] {
            let psi = |u: f64| loss.weight(u) * u;
            let (h, mut slope, mut square) = (1e-3, 0.0, 0.0);
            for i in -8000..8000 {
                let u = (f64::from(i) + 0.5) * h;
                let density = (-0.5 * u * u).exp() / std::f64::consts::TAU.sqrt() * h;
                slope += loss.slope(u) * density;
                square += psi(u) * psi(u) * density;
                let difference = (psi(u + 1e-7) - psi(u - 1e-7)) / 2e-7;
                assert!((difference - loss.slope(u)).abs() < 1e-6, "{loss:?} {u}");
            }
            let efficiency = slope * slope / square;
            assert!((efficiency - 0.95).abs() < 1e-3, "{loss:?} {efficiency}");
        }
    }
}
