//! Ordinary and weighted least squares from the triangles of the joints.
//!
//! OLS gives all rows equal weight. WLS multiplies the rows of joint j by 1 / std(residual of joint j), in three iterations
//! [Gautier 1997]. OLS and WLS need only the triangles (R of the QR decomposition of the rows). Robust weights (`huber`) need
//! the rows again.

use numerics::least_squares::{Solution, solve};
use numerics::triangle::Triangle;
use serde::{Deserialize, Serialize};

use crate::estimators::loss::Loss;
use crate::rows::observation::weighted;

/// The choice of the weights of the rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Weights {
    /// Equal weights: ordinary least squares.
    None,
    /// Rows are divided by the standard deviation of the residual of their joint: weighted least squares.
    Joint,
    /// As `Joint`, but outliers have smaller weights: robust regression with Huber's loss.
    Huber,
    /// Starts from the solution of `Huber`, and continues with Tukey's bisquare loss, which gives large outliers weight zero.
    Bisquare,
}

/// The words and losses of one choice of weights.
struct WeightsChoice {
    word: &'static str,
    method: &'static str,
    help: &'static str,
    losses: &'static [Loss],
}

impl Weights {
    /// All choices of weights.
    pub const ALL: [Weights; 4] = [Weights::None, Weights::Joint, Weights::Huber, Weights::Bisquare];

    /// The word for the choice in flags and option files.
    pub fn word(self) -> &'static str {
        self.choice().word
    }

    /// The choice with the word `word`. `None` if no choice has this word.
    pub fn of_word(word: &str) -> Option<Weights> {
        Weights::ALL.into_iter().find(|w| w.word() == word)
    }

    /// The name of the method, which is written into an estimate.
    pub fn method(self) -> &'static str {
        self.choice().method
    }

    /// One line of help on the choice.
    pub fn help(self) -> &'static str {
        self.choice().help
    }

    /// The losses of robust regression, applied one after the other from the WLS solution. Empty if no robust regression is
    /// needed.
    pub fn losses(self) -> &'static [Loss] {
        self.choice().losses
    }

    fn choice(self) -> WeightsChoice {
        match self {
            Weights::None => {
                WeightsChoice { word: "none", method: "ordinary least squares", help: "all equal (OLS)", losses: &[] }
            }
            Weights::Joint => WeightsChoice {
                word: "joint",
                method: "least squares weighted by joint",
                help: "rows weigh by the residual of their joint (WLS)",
                losses: &[],
            },
            Weights::Huber => WeightsChoice {
                word: "huber",
                method: "robust least squares (Huber), weighted by joint",
                help: "as joint, but rows with large residuals weigh less",
                losses: &[Loss::Huber],
            },
            Weights::Bisquare => WeightsChoice {
                word: "bisquare",
                method: "robust least squares (bisquare from Huber's), weighted by joint",
                help: "as huber, but rows with very large residuals weigh nothing",
                losses: &[Loss::Huber, Loss::Bisquare],
            },
        }
    }
}

/// Number of iterations of WLS: each solves the rows and computes new weights from the residuals.
const REWEIGHTING_ROUNDS: usize = 3;
/// Least mean square residual that is used for a weight, divided by the mean square torque. Smaller residuals are only rounding.
const ROUNDING_SQUARE_SHARE: f64 = 1e-20;

/// Solves the triangles of the joints with these weights. Returns the solution, and the weight of each joint, 1/(N m) (1/N), or
/// 1 for OLS.
pub fn fit(joints: &[Triangle], weights: Weights) -> (Solution, Vec<f64>) {
    let mut w = vec![1.0; joints.len()];
    if weights != Weights::None {
        for _ in 0..REWEIGHTING_ROUNDS {
            // Any least-squares solution is sufficient here, because all solutions have the same residuals.
            let x = weighted(joints, &w).solution();
            w = joints.iter().map(|joint| inverse_std(joint, &x)).collect();
        }
    }
    (solve(&weighted(joints, &w)), w)
}

/// 1 / rms of the residual of a joint, 1/(N m) (1/N); 1 for a joint without rows or without torque.
fn inverse_std(joint: &Triangle, x: &[f64]) -> f64 {
    let (total, residual) = joint.squares(x);
    // Without this lower limit, a residual at the level of rounding would give the joint a huge weight.
    let floor = ROUNDING_SQUARE_SHARE * total;
    if joint.rows == 0 || total == 0.0 { 1.0 } else { (joint.rows as f64 / residual.max(floor)).sqrt() }
}

/// The relative error |residual| / |total|. `total`, `residual`: squared norms. 0 if `total` is 0.
pub fn relative(total: f64, residual: f64) -> f64 {
    if total > 0.0 { (residual / total).sqrt() } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_those_of_the_options_file() {
        for weights in Weights::ALL {
            assert_eq!(serde_yaml::to_string(&weights).unwrap().trim(), weights.word());
        }
        let refused = serde_yaml::from_str::<Weights>("unknown").unwrap_err().to_string();
        // The error of the options parser ends with the list of known words.
        let words = Weights::ALL.map(Weights::word).join(", ");
        assert!(refused.contains(&format!("one of {words}\n")), "{refused}");
    }
}
