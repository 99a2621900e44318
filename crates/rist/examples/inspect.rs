//! Prints the base parameters of a robot: names, units and regrouping rules.
//!
//! `cargo run --package rist --example inspect -- models/race.yaml`

use rist::{Error, Model};

fn main() -> Result<(), Error> {
    let file = std::env::args().nth(1).unwrap_or("models/planar2r_vertical.yaml".into());
    let model = Model::read(&file)?;
    println!("{}: {} base parameters", model.robot.name, model.parameters.base.len());
    for rule in &model.parameters.rules().base {
        println!("  {rule}");
    }

    // The first row of the regressor at one state: the torque of the first joint per unit of each parameter.
    let regressor = model.regressor();
    let (n, p) = (regressor.coordinates().len(), regressor.parameters().len());
    let (q, dq, ddq) = (vec![0.3; n], vec![0.1; n], vec![1.0; n]);
    let mut y = vec![0.0; n * p];
    regressor.fill(&q, &dq, &ddq, &mut y);
    for (parameter, torque) in regressor.parameters().iter().zip(&y[..p]) {
        println!("  {:<8} {torque:>9.5}", parameter.name.to_string());
    }
    Ok(())
}
