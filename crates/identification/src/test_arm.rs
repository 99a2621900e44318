//! Models and logs for the unit tests: the pendulum of `experiments`, regressors and logs.

use std::sync::LazyLock;

use linear_model::linear_model::Model;
use linear_model::parameter::BaseParameter;
use linear_model::regressor::Regressor;
use logs::{Effort, Log, LogReport};

pub(crate) use pendulum::Pendulum;

#[path = "../../experiments/src/pendulum.rs"]
mod pendulum;
#[path = "test_states.rs"]
mod test_states;

/// The pendulum of `experiments` (one joint, three base parameters) and its linear model without friction.
pub(crate) fn pendulum() -> (&'static Pendulum, Model<'static>) {
    static ARM: LazyLock<Pendulum> = LazyLock::new(Pendulum::new);
    (&ARM, Model::new(&*ARM, &[], &[]))
}

/// A regressor for tests. Fields: joint names, base parameters, whether each joint is prismatic, and the function that writes Y
/// from ddq (n x p, row by row).
pub(crate) struct Made(Vec<String>, Vec<BaseParameter>, Vec<bool>, fn(&[f64], &mut [f64]));

impl Made {
    pub(crate) fn new(slides: &[bool], parameters: usize, fill: fn(&[f64], &mut [f64])) -> Made {
        let name = |k: usize| format!("q{}", k + 1);
        let parameter = |k: usize| BaseParameter::turning(&format!("ZZ{}", k + 1), k.min(slides.len() - 1)).unwrap();
        let parameters = (0..parameters).map(parameter).collect();
        Made((0..slides.len()).map(name).collect(), parameters, slides.to_vec(), fill)
    }
}

impl Regressor for Made {
    fn coordinates(&self) -> &[String] {
        &self.0
    }

    fn parameters(&self) -> &[BaseParameter] {
        &self.1
    }

    fn is_prismatic(&self, k: usize) -> bool {
        self.2[k]
    }

    fn fill(&self, _: &[f64], _: &[f64], ddq: &[f64], y: &mut [f64]) {
        self.3(ddq, y);
    }
}

/// Makes a log of joints q1, q2, .. with a uniform clock. `q`, `effort`: one series per joint.
pub(crate) fn log(t: Vec<f64>, q: Vec<Vec<f64>>, effort: Vec<Vec<f64>>, effort_is: Effort) -> Log {
    let period = t.get(1).map_or(1.0, |second| second - t[0]);
    Log {
        name: "log.csv".into(),
        coordinates: (1..=q.len()).map(|i| format!("q{i}")).collect(),
        rows: (1..=t.len()).collect(),
        report: LogReport::uniform(t.len(), period),
        t,
        q,
        dq: None,
        ddq: None,
        effort,
        effort_is,
        window: None,
    }
}
