//! The friction torque G of a simulated joint, N m (N).
//!
//! G = s+ (Fv1 v + Fs1 m) + s- (Fv2 v + Fs2 m),  s+ = (1 + tanh(v/w))/2,  s- = 1 - s+,
//! m = 1 + stribeck exp(-(v/v_s)^2) + load |tau|.
//!
//! v: velocity, w: velocity over which the sign changes, tau: drive torque. Equation (5) of [Vandanjon, Gautier, Desbats 1995],
//! smoothed near rest; Stribeck and load terms from
//! [Bittencourt, Wernholt, Sander-Tavallaey, Brogardh 2010]. The columns for the identification of friction are in `terms` and
//! `periodic`.

/// The friction law of one simulated joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrictionLaw {
    /// Viscous friction Fv1, N m s/rad (N s/m), forward.
    pub viscous_positive: f64,
    /// Coulomb friction Fs1, N m (N), forward.
    pub coulomb_positive: f64,
    /// Viscous friction Fv2, N m s/rad (N s/m), backward.
    pub viscous_negative: f64,
    /// Coulomb friction Fs2, N m (N), backward; negative.
    pub coulomb_negative: f64,
    /// Velocity w over which the sign changes, rad/s.
    pub smoothing: f64,
    /// Excess of friction near rest over Coulomb friction, divided by Coulomb friction.
    pub stribeck: f64,
    /// Stribeck velocity v_s, rad/s, over which the excess of friction near rest decays.
    pub stribeck_velocity: f64,
    /// Relative growth of Coulomb friction per unit of drive torque, 1/(N m).
    pub load: f64,
}

impl FrictionLaw {
    /// The law of equation (5) of [Vandanjon, Gautier, Desbats 1995]: Fv1, Fs1 for positive velocity; Fv2, Fs2 (negative) for
    /// negative velocity.
    pub const fn asymmetric(fv1: f64, fs1: f64, fv2: f64, fs2: f64) -> FrictionLaw {
        FrictionLaw {
            viscous_positive: fv1,
            coulomb_positive: fs1,
            viscous_negative: fv2,
            coulomb_negative: fs2,
            smoothing: 0.005,
            stribeck: 0.0,
            stribeck_velocity: 0.1,
            load: 0.0,
        }
    }

    /// A copy of the law with all friction torques multiplied by `factor`.
    pub fn scaled(mut self, factor: f64) -> FrictionLaw {
        self.viscous_positive *= factor;
        self.coulomb_positive *= factor;
        self.viscous_negative *= factor;
        self.coulomb_negative *= factor;
        self
    }

    /// The slope dG/dv at rest without load, N m s/rad.
    pub fn slope_at_rest(&self) -> f64 {
        let turn = (1.0 + self.stribeck) * (self.coulomb_positive - self.coulomb_negative) / (2.0 * self.smoothing);
        turn + 0.5 * (self.viscous_positive + self.viscous_negative)
    }

    /// The friction torque G that opposes the motion, N m, at velocity `v`, rad/s, under the drive torque `tau`, N m.
    #[inline]
    pub fn torque(&self, v: f64, tau: f64) -> f64 {
        let positive = 0.5 * (1.0 + (v / self.smoothing).tanh());
        let mut m = 1.0 + self.load * tau.abs();
        if self.stribeck != 0.0 {
            m += self.stribeck * (-(v / self.stribeck_velocity).powi(2)).exp();
        }
        positive * (self.viscous_positive * v + self.coulomb_positive * m)
            + (1.0 - positive) * (self.viscous_negative * v + self.coulomb_negative * m)
    }

    /// The slope dG/dv, N m s/rad, at velocity `v`, rad/s, under the drive torque `tau`, N m.
    pub fn slope(&self, v: f64, tau: f64) -> f64 {
        let turn = (v / self.smoothing).tanh();
        let (positive, by_v) = (0.5 * (1.0 + turn), 0.5 * (1.0 - turn * turn) / self.smoothing);
        let slow =
            if self.stribeck == 0.0 { 0.0 } else { self.stribeck * (-(v / self.stribeck_velocity).powi(2)).exp() };
        let m = 1.0 + self.load * tau.abs() + slow;
        let m_by_v = -2.0 * v / self.stribeck_velocity.powi(2) * slow;
        by_v * ((self.viscous_positive - self.viscous_negative) * v
            + (self.coulomb_positive - self.coulomb_negative) * m)
            + positive * (self.viscous_positive + self.coulomb_positive * m_by_v)
            + (1.0 - positive) * (self.viscous_negative + self.coulomb_negative * m_by_v)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equation_5_away_from_rest() {
        let law = FrictionLaw::asymmetric(0.25, 0.6, 0.18, -0.75);
        assert!((law.torque(1.0, 3.0) - 0.85).abs() < 1e-12);
        assert!((law.torque(-1.0, 3.0) + 0.93).abs() < 1e-12);
        assert!((law.torque(0.0, 0.0) - 0.5 * (0.6 - 0.75)).abs() < 1e-15);
        let loaded = FrictionLaw { load: 0.05, ..law };
        assert!((loaded.torque(1.0, -2.0) - (0.25 + 0.6 * 1.1)).abs() < 1e-12);
        assert!((law.scaled(2.0).torque(1.0, 0.0) - 1.7).abs() < 1e-12);
    }

    #[test]
    fn the_slope_is_that_of_the_torque() {
        let law = FrictionLaw { load: 0.05, stribeck: 0.4, ..FrictionLaw::asymmetric(0.25, 0.6, 0.18, -0.75) };
        for (v, tau) in [(0.0, 0.0), (0.002, -3.0), (-0.004, 2.0), (0.03, 1.0), (-0.2, -5.0), (1.5, 4.0)] {
            let h = 1e-7;
            let difference = (law.torque(v + h, tau) - law.torque(v - h, tau)) / (2.0 * h);
            // The third derivative of G is up to 2 F / w^3 = 1e7. So the central difference with the step h has an error of
            // 1e-7 from the term in h^2, plus a rounding error of 1e-16 / h.
            assert!((law.slope(v, tau) - difference).abs() < 1e-6 * (1.0 + difference.abs()), "{v}");
        }
        assert!((law.slope(0.0, 0.0) - law.slope_at_rest()).abs() < 1e-12);
    }
}
