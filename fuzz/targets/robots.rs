//! A description in any format: read, derived, evaluated. The first byte says the format: `u` URDF, `p` .par, else YAML.
//!
//! Law: Y_s X_s = Y X with random X, as long as both are numbers.
#![no_main]

use libfuzzer_sys::fuzz_target;
use rist::{Evaluation, ManyStates, Model, ModelOptions, Quantity};

/// Bodies of this many coordinates are derived; the time of larger ones is a test of its own.
const COORDINATES: usize = 6;

fuzz_target!(|data: &[u8]| {
    let Some((format, text)) = data.split_first() else { return };
    let Ok(text) = std::str::from_utf8(text) else { return };
    let path = match format {
        b'u' => "robot.urdf",
        b'p' => "robot.par",
        _ => "robot.yaml",
    };
    let options = ModelOptions::default();
    let Ok(robot) = rist::parse_robot(text, path.as_ref(), &options) else { return };
    if robot.coordinates.len() > COORDINATES || robot.links.len() > 2 * COORDINATES {
        return;
    }
    let Ok(model) = Model::parse(text, path, &options) else { return };
    let n = model.regressor().coordinates().len();
    let (q, dq, ddq) = (vec![0.3; n], vec![-0.2; n], vec![1.1; n]);
    let states = ManyStates { q: &q, dq: &dq, ddq: &ddq, parameters: &[] };
    for quantity in [Quantity::Regressor, Quantity::BaseRegressor] {
        let Ok(evaluation) = Evaluation::new(&model, quantity) else { continue };
        let (rows, columns) = evaluation.shape();
        let mut y = vec![0.0; rows * columns];
        // A refusal is an answer; a panic is none.
        let _ = evaluation.fill(&model, &states, &mut y);
    }
    let _ = model.described_parameters();
});
