//! Drive gains by RIST-MH: friction and its drift are chosen as with known gains, the gains are estimated as in
//! `estimators::drive_gains`.
//!
//! With the gains at hand, `search` finds the friction of each joint, its drift, and the weights of the rows. Those
//! rows, with friction, drift and ends projected out, then give the gains again. The first gains come from equation
//! (5). The iteration ends when the friction stays and no gain moves by more than a hundredth of its deviation, which
//! no printed figure shows.
//!
//! A row of `fit` is w (k I + u C f) = w (D X + t + (1 + u) C f' + C f u' + ..). But for u, its right-hand side is
//! proportional to k: with D and t times k it is the row in currents that `estimators::drive_gains` takes.

use linear_model::friction::periodic::FrictionShape;
use logs::Error;

use crate::estimators::drive_gains::equations::JointEquations;
use crate::estimators::drive_gains::likelihood::{DriveGains, Gain, drive_gains};
use crate::spectrum::rist_mh::data::{HarmonicData, HarmonicOptions};
use crate::spectrum::rist_mh::fit::{Fit, Owner};
use crate::spectrum::rist_mh::search::HarmonicEstimate;

/// Gains and parameters, and the friction that was chosen with them.
#[derive(Clone, Debug)]
pub struct HarmonicGains {
    /// Gains and parameters with their deviations.
    pub gains: DriveGains,
    /// The equations behind them, friction projected out.
    pub equations: Vec<JointEquations>,
    /// The estimate that gave the friction of these equations, with the gains of the round before. Where the choice
    /// settled, no gain moved after it by more than a hundredth of its deviation. `None` where the gains are not
    /// determined or not positive, and the friction is that of equation (5).
    pub friction: Option<HarmonicEstimate>,
    /// How often the friction was chosen; `None`: it did not settle.
    pub rounds: Option<usize>,
}

/// Largest number of choices of the friction.
const MAX_FRICTION_CHOICES: usize = 8;

impl HarmonicData<'_> {
    /// Estimates the gains where not all are known. Afterwards the data have the gains that the friction was chosen
    /// with, so that its residuals are those of its own fit.
    ///
    /// Fails as [`drive_gains`] does.
    pub fn estimate_with_gains(&mut self, known: &[Gain], options: &HarmonicOptions) -> Result<HarmonicGains, Error> {
        // The first gains: with equation (5) for the friction of every joint, and no drift.
        let plain = HarmonicOptions { band: options.band, ends: options.ends, ..HarmonicOptions::plain() };
        let fit = Fit::new(self, &FrictionShape::ASYMMETRIC, &plain, self.deviations(None));
        let equations = fit.current_equations(self);
        let mut gains = drive_gains(&equations, known)?;
        fit.deviations_by_frequency(self, known, &mut gains);
        let mut found = HarmonicGains { gains, equations, friction: None, rounds: None };
        for round in 0..MAX_FRICTION_CHOICES {
            // Torques need positive gains; without them no friction can be chosen.
            let is_usable = |(k, d): (&f64, &bool)| *d && *k > 0.0 && k.is_finite();
            if !found.gains.gain.iter().zip(&found.gains.gain_determined).all(is_usable) {
                found.friction = None;
                break;
            }
            // Friction, drift and weights from the gains at hand, then the gains from those rows.
            self.gain = found.gains.gain.clone();
            let Some(fit) = self.fitted(options) else { break };
            let equations = fit.current_equations(self);
            let mut gains = drive_gains(&equations, known)?;
            fit.deviations_by_frequency(self, known, &mut gains);
            // Settled: the friction stays, and no gain moves by a hundredth of its deviation.
            let moved = |j: usize| (gains.gain[j] - found.gains.gain[j]).abs() > 0.01 * gains.gain_deviation[j];
            let is_same = found.friction.is_some_and(|f| f.shape == fit.shape);
            let is_settled = is_same && !(0..self.n).any(moved);
            let mut friction = self.finished(&fit, known);
            if is_settled || round + 1 == MAX_FRICTION_CHOICES {
                self.explain(&mut friction, &fit, options);
            }
            let rounds = is_settled.then_some(round + 1);
            found = HarmonicGains { gains, equations, friction: Some(friction), rounds };
            if is_settled {
                break;
            }
        }
        Ok(found)
    }
}

impl Fit {
    /// The equations of each joint in currents, all but the parameters projected out.
    fn current_equations(&self, data: &HarmonicData) -> Vec<JointEquations> {
        let p = data.p;
        let mut of_joint = vec![(vec![], vec![], vec![]); data.n];
        let mut nuisance = 0;
        self.each_equation(data, |Owner { joint: j, .. }, row, known, y| {
            nuisance = row.len() - p;
            let mut turned = row[p..].to_vec();
            turned.extend(row[..p].iter().map(|d| data.gain[j] * d));
            of_joint[j].0.push(turned);
            of_joint[j].1.push(data.gain[j] * known);
            of_joint[j].2.push(y);
        });
        let equations = |(rows, known, current): &(Vec<Vec<f64>>, Vec<f64>, Vec<f64>)| {
            JointEquations::without_nuisance(rows, known, current, nuisance)
        };
        of_joint.iter().map(equations).collect()
    }
}
