//! The profile (position over time) of a swing of one joint: bang-bang as in the paper cited below, or smooth with the same
//! symmetry.
//!
//! Both profiles are antisymmetric about each quarter period and about each half period. Therefore the friction of the moving
//! joint is orthogonal to its acceleration at odd harmonics (`exciting_trajectory`).
//!
//! [Vandanjon, Gautier, Desbats 1995, section 3.2, for the bang-bang profile]

/// The profile of a swing (periodic motion of a joint): position over time from a point A to a point B and back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Profile {
    /// Piecewise constant acceleration: +a or -a.
    BangBang,
    /// A polynomial of degree seven in each direction; acceleration and jerk are zero at A and B.
    Smooth,
}

impl Profile {
    /// Peak velocity v_peak and acceleration a_peak of a swing (periodic motion) with stroke L and period T, dimensionless:
    /// (v_peak T / L, a_peak T^2 / L).
    pub fn peaks(self) -> (f64, f64) {
        match self {
            Profile::BangBang => (4.0, 16.0),
            // The polynomial p(u) = 35u^4 - 84u^5 + 70u^6 - 20u^7 over the half period T/2 has the peak derivatives 35/16 and 84
            // sqrt(5)/25.
            Profile::Smooth => (4.375, 4.0 * 84.0 * 5.0_f64.sqrt() / 25.0),
        }
    }

    /// Position in [-1, 1], and its first and second derivative by u = t/T, at u in [0, 1); T: period. Where the acceleration
    /// jumps, the result is the mean of both sides, like the value of a Fourier series.
    pub fn at(self, u: f64) -> (f64, f64, f64) {
        match self {
            Profile::BangBang => {
                let (s, sign, rest) = match u {
                    u if u < 0.25 => (u, 1.0, -1.0),
                    u if u < 0.75 => (u - 0.5, -1.0, 1.0),
                    u => (u - 1.0, 1.0, -1.0),
                };
                let corner = u == 0.25 || u == 0.75;
                (rest + sign * 16.0 * s * s, sign * 32.0 * s, if corner { 0.0 } else { sign * 32.0 })
            }
            Profile::Smooth => {
                let (s, sign) = if u < 0.5 { (2.0 * u, 1.0) } else { (2.0 * u - 1.0, -1.0) };
                let c = 1.0 - s;
                let p = s.powi(4) * (35.0 - 84.0 * s + 70.0 * s * s - 20.0 * s.powi(3));
                let dp = 140.0 * (s * c).powi(3);
                let ddp = 420.0 * (s * c).powi(2) * (1.0 - 2.0 * s);
                (sign * (2.0 * p - 1.0), sign * 4.0 * dp, sign * 8.0 * ddp)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn peaks_are_those_announced() {
        for profile in [Profile::BangBang, Profile::Smooth] {
            let fine = (0..4000).map(|i| profile.at(f64::from(i) / 4000.0));
            let (v, a) = fine.fold((0.0_f64, 0.0_f64), |m, p| (m.0.max(p.1.abs()), m.1.max(p.2.abs())));
            let (v_peak, a_peak) = profile.peaks();
            // The unit profile has the stroke L = 2. The samples miss a maximum by at most half of 1/4000 of a period.
            assert!((v / 2.0 - v_peak).abs() < 1e-4 * v_peak && (a / 2.0 - a_peak).abs() < 1e-4 * a_peak);
        }
    }
}
