//! Converts the joint effects of a request (ripple, springs, ..) into options of RIST-MH, the identification by harmonics.
//! Joint names become indices, and duplicates are removed.
//!
//! An effect is a term of the joint model, for example torque ripple.

use identification::signals::signal_options::possible_delay;
use identification::spectrum::rist_mh::data::HarmonicOptions;
use identification::spectrum::rist_mh::effects::Effect;

use crate::describe::model::Model;
use crate::error::Error;
use crate::request::{Delay, HarmonicRequest, JointSelector, Request};

/// Largest number of ripple periods per turn of a joint: a motor of a hundred poles with a gear ratio of one hundred.
const LARGEST_PERIODS_PER_TURN: f64 = 1e4;

impl HarmonicRequest {
    /// The options of RIST-MH for this request.
    ///
    /// Fails if the request names an unknown coordinate, or if a number is out of range.
    pub fn options(&self, model: &Model) -> Result<HarmonicOptions, Error> {
        let mut options = HarmonicOptions::default().with_effects(self.joint_effects(model)?);
        self.check()?;
        // The motion must be resolved up to at least twice the cut-off frequency of the equations.
        if let Some(hz) = self.cutoff {
            options.band.equations = hz;
            options.band.motion = options.band.motion.max(2.0 * hz);
        }
        match self.delay {
            Some(Delay::Seconds(seconds)) => options.band.delay = possible_delay(seconds).map_err(Error::new)?,
            Some(Delay::Auto) => options.effects.push(Effect::Delay),
            None => {}
        }
        Ok(options)
    }

    /// The requested effects on single joints: ripple, springs, eccentric encoders, elasticity and backlash; each once.
    fn joint_effects(&self, model: &Model) -> Result<Vec<Effect>, Error> {
        let n = model.regressor().coordinates().len();
        let joints = |whose: &JointSelector| match whose {
            JointSelector::All => Ok(0..n),
            JointSelector::Coordinate(name) => model.coordinate(name).map(|k| k..k + 1),
        };
        let of =
            |what: &str, whose: &JointSelector| joints(whose).map_err(|e| Error::new(format_args!("[{what}]: {e}")));
        // Ripple needs joints and a number of periods per turn. All other effects need only joints.
        let mut found = Vec::new();
        for (whose, periods) in &self.ripple {
            if !(*periods > 0.0 && *periods <= LARGEST_PERIODS_PER_TURN) {
                return Err(Error::new(format_args!(
                    "[ripple] of {periods} periods a turn: a number above 0 and up to {LARGEST_PERIODS_PER_TURN} is expected"
                )));
            }
            found.extend(of("ripple", whose)?.map(|joint| Effect::Ripple { joint, periods: *periods }));
        }
        for whose in &self.spring {
            found.extend(of("spring", whose)?.map(|joint| Effect::Spring { joint }));
        }
        for whose in &self.eccentric {
            found.extend(of("eccentric", whose)?.map(|joint| Effect::Eccentric { joint }));
        }
        for whose in &self.elastic {
            found.extend(of("elastic", whose)?.map(|joint| Effect::Elastic { joint }));
        }
        for whose in &self.backlash {
            found.extend(of("backlash", whose)?.map(|joint| Effect::Play { joint }));
        }
        // Remove duplicates: "all" and a single coordinate may name the same effect.
        let is_new = |i: &usize| !found[..*i].contains(&found[*i]);
        Ok((0..found.len()).filter(is_new).map(|i| found[i]).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn planar() -> Model {
        Model::read(concat!(env!("CARGO_MANIFEST_DIR"), "/../../models/planar2r_vertical.yaml")).unwrap()
    }

    fn named(name: &str) -> JointSelector {
        JointSelector::Coordinate(name.into())
    }

    #[test]
    fn effects_are_of_coordinates_and_asked_for_once() {
        let request = HarmonicRequest {
            delay: Some(Delay::Auto),
            ripple: vec![(JointSelector::All, 6.0), (named("q2"), 12.0)],
            elastic: vec![named("q2"), JointSelector::All],
            ..HarmonicRequest::default()
        };
        let options = request.options(&planar()).unwrap();
        let ripple = |joint, periods| Effect::Ripple { joint, periods };
        let elastic = |joint| Effect::Elastic { joint };
        let expected =
            [ripple(0, 6.0), ripple(1, 6.0), ripple(1, 12.0), elastic(1), elastic(0), Effect::Delay].to_vec();
        assert_eq!(options.effects, expected);
        // Springs limit the equations to 10 Hz, unless the request gives a cut-off frequency.
        assert_eq!(options.band.equations, 10.0);
        let cut = HarmonicRequest { cutoff: Some(25.0), ..request }.options(&planar()).unwrap();
        assert_eq!((cut.band.equations, cut.band.motion), (25.0, 50.0));
        assert_eq!(HarmonicRequest::default().options(&planar()).unwrap(), HarmonicOptions::default());
    }

    #[test]
    fn what_cannot_be_is_refused() {
        let message = |request: HarmonicRequest| request.options(&planar()).unwrap_err().to_string();
        let plain = HarmonicRequest::default;
        let unknown = message(HarmonicRequest { backlash: vec![named("q9")], ..plain() });
        assert_eq!(unknown, "[backlash]: there is no coordinate `q9`; there are q1, q2");
        for periods in [0.0, -3.0, f64::NAN, f64::INFINITY] {
            let said = message(HarmonicRequest { ripple: vec![(JointSelector::All, periods)], ..plain() });
            assert!(said.contains("above 0 and up to 10000 is expected"), "{said}");
        }
        for seconds in [1.0, f64::NAN] {
            let said = message(HarmonicRequest { delay: Some(Delay::Seconds(seconds)), ..plain() });
            assert!(said.contains("seconds between -1 and 1 are expected"), "{said}");
        }
        let said = message(HarmonicRequest { cutoff: Some(0.0), ..plain() });
        assert!(said.starts_with("[cutoff] must be a positive number"), "{said}");
    }
}
