//! Draws the torque of one joint in a log that was not fitted: measured, predicted by the description, predicted by an
//! estimate.
//!
//! `cargo run --package rist --example description_and_estimate > docs/ur5/torque.svg` draws the picture of README.md.

use std::path::Path;

use identification::estimate::identified::Identified;
use report::chart::Chart;
use rist::fit::validation::predicted_torques;
use rist::{Error, Estimate, IdentifyRequest, LogSource, Model, identify};

fn main() -> Result<(), Error> {
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");
    let model = Model::read(format!("{root}/models/ur5.urdf"))?;
    let open = |name: &str| -> Result<LogSource, Error> {
        Ok(model.open_log(Path::new(&format!("{root}/docs/ur5/{name}.csv")), &Default::default())?.0)
    };
    let found = identify(&model, &[open("log")?], &IdentifyRequest::default())?.estimate;

    // The inertial parameters of the description, with the identified friction, because a URDF gives no friction.
    let mut described: Estimate = found.clone();
    let values = model.nominal_parameters().unwrap_or_default();
    for (parameter, value) in described.parameters.iter_mut().zip(values) {
        *parameter = Identified::given(parameter.id.clone(), parameter.unit, value);
    }

    let logs = [open("other")?];
    let [by_estimate, by_description] = [&found, &described].map(|e| predicted_torques(&model, e, &logs));
    let (by_estimate, by_description) = (by_estimate?, by_description?);
    let joint = model.coordinate("elbow")?;
    let n = model.regressor().coordinates().len();
    let of = |torques: &[f64]| -> Vec<(f64, f64)> {
        let of_joint = torques.iter().skip(joint).step_by(n).copied();
        by_estimate[0].t.iter().copied().zip(of_joint).filter(|(_, torque)| torque.is_finite()).collect()
    };
    let picture = Chart::new("Torque of the elbow of a UR5, on a log that was not fitted", ("time, s", "torque, N m"))
        .line("description", "b", &of(&by_description[0].predicted))
        .line("measured", "a", &of(&by_estimate[0].measured))
        .line("identified", "c", &of(&by_estimate[0].predicted));
    println!("{}", picture.alone());
    Ok(())
}
