//! One identified parameter: its value, its standard deviation sigma, and whether the value can be used (its status).
//!
//! White sigma: standard deviation under the assumption that the residuals are white noise.

use linear_model::parameter::ParameterId;
use linear_model::unit::Unit;
use serde::{Deserialize, Serialize};

/// Half width of a 95 % interval of a normal error, in standard deviations. A value is significant if |value| exceeds 1.96
/// sigma.
pub const INTERVAL: f64 = 1.96;

/// One identified parameter with its uncertainty.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Identified {
    /// Identity of the parameter.
    #[serde(rename = "name")]
    pub id: ParameterId,
    /// SI unit of the value.
    pub unit: Unit,
    /// The identified value; `None` if the data do not determine the parameter.
    pub value: Option<f64>,
    /// Standard deviation for correlated residuals, in the unit of the value. Use this standard deviation, not `white_sigma`.
    /// `None` if not known.
    pub sigma: Option<f64>,
    /// Standard deviation under the assumption of an exact model and white noise; too small for real robots. `None` if not
    /// computed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub white_sigma: Option<f64>,
    /// Relative standard deviation 100 sigma / |value|, %; `None` if sigma is unknown or the value is zero.
    #[serde(rename = "relative_sigma_percent", alias = "relative_sigma")]
    pub relative_sigma: Option<f64>,
    /// Whether the value can be used, and if not, why.
    pub status: Status,
    /// The value to use in torque predictions if the parameter is not identifiable; otherwise `None`.
    ///
    /// This value is not a result: many values give the same residual, and this value belongs to the solution with the smallest
    /// norm. Predictions need it because the data determine sums that contain this parameter.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub used_for_prediction: Option<f64>,
}

/// Whether the value of a parameter can be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Status {
    /// Significant: zero is outside the 95 % interval of the value.
    Identified,
    /// Not significant: zero is within the 95 % interval of the value.
    NotSignificant,
    /// The joints of the parameter hardly move, so the error of the value comes mainly from model errors and not from noise.
    Weak,
    /// The data do not determine the parameter.
    NotIdentifiable,
    /// The value was given, not estimated from data; for example the true value in a simulation.
    Given,
}

/// The standard deviations of the value of a parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deviations {
    /// Standard deviation for correlated residuals, in the unit of the value.
    pub sigma: f64,
    /// Standard deviation for white noise, in the unit of the value; `None` if unknown.
    pub white: Option<f64>,
    /// Whether the joints of the parameter hardly move.
    pub weak: bool,
}

impl Deviations {
    /// Makes the deviations from a single standard deviation, without a separate one for white noise.
    pub fn white(sigma: f64) -> Deviations {
        Deviations { sigma, white: None, weak: false }
    }
}

impl Identified {
    /// Makes a parameter from its value and standard deviations. Relative standard deviation and status follow from these.
    pub fn new(id: ParameterId, unit: Unit, value: f64, deviations: Deviations) -> Identified {
        let relative = 100.0 * deviations.sigma / value.abs();
        let status = if value.abs() <= INTERVAL * deviations.sigma {
            Status::NotSignificant
        } else if deviations.weak {
            Status::Weak
        } else {
            Status::Identified
        };
        Identified {
            id,
            unit,
            value: Some(value),
            sigma: Some(deviations.sigma),
            white_sigma: deviations.white,
            relative_sigma: relative.is_finite().then_some(relative),
            status,
            used_for_prediction: None,
        }
    }

    /// Makes a parameter that the data do not determine. `used_for_prediction`: the value for torque predictions; many other
    /// values give the same residual.
    pub fn unidentifiable(id: ParameterId, unit: Unit, used_for_prediction: f64) -> Identified {
        let (value, sigma, white_sigma, relative_sigma) = (None, None, None, None);
        let (status, used_for_prediction) = (Status::NotIdentifiable, Some(used_for_prediction));
        Identified { id, unit, value, sigma, white_sigma, relative_sigma, status, used_for_prediction }
    }

    /// The value to use in torque predictions; 0 if the parameter has no such value.
    pub fn prediction(&self) -> f64 {
        self.value.or(self.used_for_prediction).unwrap_or(0.0)
    }

    /// Makes a parameter with a given value that is not estimated from data.
    pub fn given(id: ParameterId, unit: Unit, value: f64) -> Identified {
        let exact = Identified::new(id, unit, value, Deviations::white(0.0));
        Identified { sigma: None, relative_sigma: None, status: Status::Given, ..exact }
    }

    /// The parameter with another value and unchanged standard deviations. A parameter that is not identifiable keeps this
    /// status.
    pub fn with_value(self, value: f64) -> Identified {
        match self.deviations() {
            Some(deviations) => Identified::new(self.id, self.unit, value, deviations),
            None => Identified::unidentifiable(self.id, self.unit, value),
        }
    }

    /// The parameter with its standard deviation raised to at least `deviation`; unchanged if the parameter is not
    /// identifiable.
    pub fn widened(self, deviation: f64) -> Identified {
        match (self.value, self.deviations()) {
            (Some(value), Some(found)) => {
                let sigma = found.sigma.max(deviation);
                Identified::new(self.id, self.unit, value, Deviations { sigma, ..found })
            }
            _ => self,
        }
    }

    /// The parameter with its standard deviation raised to at least `deviation`. The former standard deviation becomes the
    /// standard deviation for white noise.
    pub(crate) fn widened_beyond_white(self, deviation: f64) -> Identified {
        let white = self.sigma;
        let wide = self.widened(deviation);
        Identified { white_sigma: white.filter(|_| wide.sigma.is_some()), ..wide }
    }

    /// The standard deviation in the unit of the value; infinite if it is not known.
    pub fn sigma_or_infinity(&self) -> f64 {
        self.sigma.unwrap_or(f64::INFINITY)
    }

    fn deviations(&self) -> Option<Deviations> {
        let weak = self.status == Status::Weak;
        Some(Deviations { sigma: self.sigma?, white: self.white_sigma, weak })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(value: f64, deviations: Deviations) -> Identified {
        Identified::new("FV1".parse().unwrap(), Unit::VISCOUS, value, deviations)
    }

    #[test]
    fn the_deviation_decides() {
        let of = |sigma| found(1.0, Deviations { sigma, white: Some(0.05), weak: false });
        assert_eq!(of(0.51).status, Status::Identified);
        assert_eq!(of(0.52).status, Status::NotSignificant);
        assert_eq!(of(0.2).relative_sigma, Some(20.0));
        let wide = of(0.1).widened(0.6);
        assert_eq!((wide.status, wide.white_sigma), (Status::NotSignificant, Some(0.05)));
        assert_eq!(of(0.1).with_value(0.1).status, Status::NotSignificant);
        assert_eq!(found(0.0, Deviations::white(0.1)).relative_sigma, None);
    }

    #[test]
    fn what_is_given_is_not_identified() {
        for value in [0.0, 2.0] {
            let given = Identified::given("FV1".parse().unwrap(), Unit::VISCOUS, value);
            assert_eq!((given.status, given.value, given.sigma), (Status::Given, Some(value), None));
        }
    }

    #[test]
    fn weak_stays_weak_and_unidentifiable_gets_no_value() {
        let weak = found(1.0, Deviations { sigma: 0.1, white: None, weak: true });
        assert_eq!((weak.status, weak.clone().with_value(2.0).status), (Status::Weak, Status::Weak));
        let open = Identified::unidentifiable("FV1".parse().unwrap(), Unit::VISCOUS, 2.0);
        let other = open.clone().with_value(3.0);
        assert_eq!((other.value, other.status, other.prediction()), (None, Status::NotIdentifiable, 3.0));
        assert_eq!(open.clone().widened(3.0), open);
    }
}
