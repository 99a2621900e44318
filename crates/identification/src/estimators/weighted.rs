//! Ordinary and weighted least squares from the triangles of the joints.
//!
//! OLS weighs all rows alike. WLS multiplies the rows of joint j by 1 / std(residual of joint j), three times over
//! [Gautier 1997]. Both follow from the same triangles. The robust weights (`huber`) need the rows again.

use numerics::least_squares::{Solution, solve};
use numerics::triangle::Triangle;
use serde::{Deserialize, Serialize};

use crate::estimators::loss::Loss;
use crate::rows::observation::weighted;

/// The weights of the rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Weights {
    /// All alike: ordinary least squares.
    None,
    /// By the standard deviation of the joint's residual: weighted least squares.
    Joint,
    /// As `Joint`, and rows that do not fit count less: robust regression.
    Huber,
    /// As `Huber`, and from there on rows that do not fit at all do not count.
    Bisquare,
}

/// The texts and the losses of a choice of weights.
struct Choice {
    word: &'static str,
    method: &'static str,
    help: &'static str,
    losses: &'static [Loss],
}

impl Weights {
    /// All of them.
    pub const ALL: [Weights; 4] = [Weights::None, Weights::Joint, Weights::Huber, Weights::Bisquare];

    /// The word of flags and option files.
    pub fn word(self) -> &'static str {
        self.choice().word
    }

    /// The weights of a word.
    pub fn of_word(word: &str) -> Option<Weights> {
        Weights::ALL.into_iter().find(|w| w.word() == word)
    }

    /// The method that an estimate names.
    pub fn method(self) -> &'static str {
        self.choice().method
    }

    /// One line of help on what the rows weigh.
    pub fn help(self) -> &'static str {
        self.choice().help
    }

    /// The losses that weigh the rows, one after the other, from the solution by joint on; empty where the triangles
    /// are enough.
    pub fn losses(self) -> &'static [Loss] {
        self.choice().losses
    }

    fn choice(self) -> Choice {
        match self {
            Weights::None => {
                Choice { word: "none", method: "ordinary least squares", help: "all alike (OLS)", losses: &[] }
            }
            Weights::Joint => Choice {
                word: "joint",
                method: "least squares weighted by joint",
                help: "by the residual of their joint (WLS)",
                losses: &[],
            },
            Weights::Huber => Choice {
                word: "huber",
                method: "robust least squares (Huber), weighted by joint",
                help: "as joint, and less where they do not fit",
                losses: &[Loss::Huber],
            },
            Weights::Bisquare => Choice {
                word: "bisquare",
                method: "robust least squares (bisquare from Huber's), weighted by joint",
                help: "as huber, and nothing where they do not fit at all",
                losses: &[Loss::Huber, Loss::Bisquare],
            },
        }
    }
}

/// Number of reweightings of WLS.
const REWEIGHTING_ROUNDS: usize = 3;

/// Solves with the weights asked for; also returns the weights.
pub fn fit(joints: &[Triangle], weights: Weights) -> (Solution, Vec<f64>) {
    let mut w = vec![1.0; joints.len()];
    if weights != Weights::None {
        for _ in 0..REWEIGHTING_ROUNDS {
            // Any solution will do, because all of them leave the same residuals.
            let x = weighted(joints, &w).solution();
            w = joints.iter().map(|joint| inverse_std(joint, &x)).collect();
        }
    }
    (solve(&weighted(joints, &w)), w)
}

/// 1 / root mean square of the residual; 1 for a joint without rows or without torque.
fn inverse_std(joint: &Triangle, x: &[f64]) -> f64 {
    let (total, residual) = joint.squares(x);
    // A residual at the level of rounding would give the joint all the weight there is.
    let floor = 1e-20 * total;
    if joint.rows == 0 || total == 0.0 { 1.0 } else { (joint.rows as f64 / residual.max(floor)).sqrt() }
}

/// |residual| / |total| from squares; 0 where the total is 0.
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
        // The reader of options ends its line with the words it knows.
        let words = Weights::ALL.map(Weights::word).join(", ");
        assert!(refused.contains(&format!("one of {words}\n")), "{refused}");
    }
}
