//! Drive gains by RIST-MH. `search` chooses the friction columns as if the gains were known; `estimators::drive_gains`
//! estimates the gains.
//!
//! With the present gains, `search` finds the friction of each joint, its drift, and the weights of the rows. Friction, drift
//! and ends (jumps from the end of the record to its start) are eliminated from these rows, and the remaining equations give
//! new gains. The initial gains are found with asymmetric viscous and Coulomb friction. The iteration ends if the choice of
//! friction is unchanged and no gain changes by more than a hundredth of its standard deviation, which is below the printed
//! digits.
//!
//! A row of `fit` is w (k I + u C f) = w (D X + t + (1 + u) C f' + C f u' + ..), k: present gain, I: current, t: torque of a
//! known load (other symbols: see `fit`). `estimators::drive_gains` needs a row (coefficients) X + (known) = k' (current) with
//! the new gain k'. This row is obtained from the row of `fit` as follows: D and t are multiplied by k, and the right-hand
//! side, which is w k I apart from the term with u, is used as the current.

use linear_model::friction::periodic::FrictionShape;
use logs::Error;

use crate::estimators::drive_gains::equations::JointEquations;
use crate::estimators::drive_gains::likelihood::{DriveGains, Gain, drive_gains};
use crate::spectrum::rist_mh::data::{HarmonicData, HarmonicOptions};
use crate::spectrum::rist_mh::fit::{IterationState, Owner};
use crate::spectrum::rist_mh::search::HarmonicEstimate;

/// The estimated gains and parameters, and the friction that was chosen with these gains.
#[derive(Clone, Debug)]
pub struct HarmonicGains {
    /// The gains and parameters with their standard deviations.
    pub gains: DriveGains,
    /// The equations from which the gains were estimated, after elimination of friction.
    pub equations: Vec<JointEquations>,
    /// The estimate whose friction is used in `equations`. This estimate was computed with the gains of the previous round.
    /// After convergence, these previous gains differ from `gains` by at most a hundredth of a standard deviation. `None` if
    /// the gains are not determined or not positive; friction is then asymmetric viscous and Coulomb friction.
    pub friction: Option<HarmonicEstimate>,
    /// Number of rounds (choice of friction, then gains) of the iteration. `None` if the iteration did not converge.
    pub rounds: Option<usize>,
}

/// Largest number of rounds. A round chooses the friction, then estimates the gains.
const MAX_FRICTION_CHOICES: usize = 8;
/// Largest change of a gain after convergence, in standard deviations of the gain.
const SETTLED_GAIN_CHANGE_SIGMAS: f64 = 0.01;

impl HarmonicData<'_> {
    /// Estimates the drive gains if not all are known. Afterwards `self` has the gains with which the friction was chosen last.
    /// So residuals that are computed from `self` belong to the fit with these gains.
    ///
    /// Fails if [`drive_gains`] fails.
    pub fn estimate_with_gains(&mut self, known: &[Gain], options: &HarmonicOptions) -> Result<HarmonicGains, Error> {
        // The initial gains are found with asymmetric viscous and Coulomb friction in every joint, and no drift.
        let plain = HarmonicOptions { band: options.band, ends: options.ends, ..HarmonicOptions::plain() };
        let fit = IterationState::new(self, &FrictionShape::ASYMMETRIC, &plain, self.deviations(None));
        let equations = fit.current_equations(self);
        let mut gains = drive_gains(&equations, known)?;
        fit.deviations_by_frequency(self, known, &mut gains);
        let mut found = HarmonicGains { gains, equations, friction: None, rounds: None };
        for round in 0..MAX_FRICTION_CHOICES {
            // Only positive gains give torques. Without torques no friction can be chosen.
            let is_usable = |(k, d): (&f64, &bool)| *d && *k > 0.0 && k.is_finite();
            if !found.gains.gain.iter().zip(&found.gains.gain_determined).all(is_usable) {
                found.friction = None;
                break;
            }
            // First, friction, drift and weights are found with the present gains. The rows that follow from them then give new
            // gains.
            self.gain = found.gains.gain.clone();
            let Some(fit) = self.fitted(options) else { break };
            let equations = fit.current_equations(self);
            let mut gains = drive_gains(&equations, known)?;
            fit.deviations_by_frequency(self, known, &mut gains);
            let moved = |j: usize| {
                (gains.gain[j] - found.gains.gain[j]).abs() > SETTLED_GAIN_CHANGE_SIGMAS * gains.gain_deviation[j]
            };
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

impl IterationState {
    /// The equations of each joint in currents. The unknowns of these equations are the gain and the inertial parameters. The
    /// other unknowns of the fit are eliminated: friction, its drift, jumps between end and start of a record (`ends`), and
    /// effects such as delay or ripple.
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
