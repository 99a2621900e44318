//! Drive gains by RIST-MH: friction and its drift chosen as with known gains, the gains as in `drive_gains`.
//!
//! Which friction a joint has, how it drifts and what its rows are worth is found by `harmonic_estimation` with the
//! gains at hand; those rows, friction, drift and ends projected out, then give the gains again. The first gains
//! come from equation (5). It ends when the friction stays and no gain moves by more than a hundredth of its
//! deviation, which no figure shows.
//!
//! A row of `harmonic_fit` is w (k I + u C f) = w (D X + t + (1 + u) C f' + C f u' + ..), its right-hand side
//! but for u proportional to k: with D and t times k it is the row in currents that `drive_gains` asks for.

use crate::Error;
use crate::drive_gains::{DriveGains, Gain, JointEquations, drive_gains};
use crate::friction_columns::FrictionShape;
use crate::harmonic_estimation::{HarmonicData, HarmonicOptions};
use crate::harmonic_fit::Fit;

/// Gains and parameters, and the friction they stand beside.
#[derive(Clone, Debug)]
pub struct HarmonicGains {
    pub gains: DriveGains,
    /// The equations behind them, friction projected out.
    pub equations: Vec<JointEquations>,
    pub shape: FrictionShape,
    /// Of the friction's drift from experiment to experiment, relative.
    pub drift_spread: f64,
    /// Times the friction was chosen; `None`: it did not settle.
    pub rounds: Option<usize>,
}

/// Choices of the friction that are tried.
const ROUNDS: usize = 8;

impl HarmonicData {
    /// The gains, where not all are known; those of the data serve as a start for the scale of the friction only.
    ///
    /// Fails as [`drive_gains`] does, and without equations. Friction is that of equation (5) where the first gains
    /// are not determined or not positive.
    pub fn estimate_with_gains(self, known: &[Gain], options: &HarmonicOptions) -> Result<HarmonicGains, Error> {
        let plain = HarmonicOptions { band: options.band, ends: options.ends, ..HarmonicOptions::plain() };
        let fit = Fit::new(&self, &FrictionShape::ASYMMETRIC, &plain, self.deviations(None));
        let equations = fit.current_equations(&self, &plain);
        let gains = drive_gains(&equations, known)?;
        let (shape, mut data) = (fit.shape, self);
        let mut found = HarmonicGains { gains, equations, shape, drift_spread: 0.0, rounds: None };
        for round in 0..ROUNDS {
            let is_usable = |(k, d): (&f64, &bool)| *d && *k > 0.0 && k.is_finite();
            if !found.gains.gain.iter().zip(&found.gains.gain_determined).all(is_usable) {
                break;
            }
            data = data.with_gains(&found.gains.gain);
            let Some((fit, _)) = data.best_fit(options) else {
                return Err(Error::new("the experiments give no equation"));
            };
            let equations = fit.current_equations(&data, options);
            let gains = drive_gains(&equations, known)?;
            let moved = |j: usize| (gains.gain[j] - found.gains.gain[j]).abs() > 0.01 * gains.gain_deviation[j];
            let is_settled = round > 0 && fit.shape == found.shape && !(0..gains.gain.len()).any(moved);
            let rounds = is_settled.then_some(round + 1);
            found = HarmonicGains { gains, equations, shape: fit.shape, drift_spread: fit.drift_spread(), rounds };
            if is_settled {
                break;
            }
        }
        Ok(found)
    }
}

impl Fit {
    /// The equations of each joint in currents, all but the parameters projected out.
    fn current_equations(&self, data: &HarmonicData, options: &HarmonicOptions) -> Vec<JointEquations> {
        let p = data.p;
        let mut of_joint = vec![(vec![], vec![], vec![]); data.n];
        let mut nuisance = 0;
        self.each_equation(data, options, |j, row, known, y| {
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
