//! Runs the experiments of spectrum analysis in simulation: plan, simulate, identify, validate.
//!
//! `cargo run --release --package rist --example plan_and_validate`

use std::path::PathBuf;

use logs::Effort;
use rist::fit::experiments::ExperimentLogs;
use rist::fit::validation::validate_experiments;
use rist::request::{HarmonicRequest, PaperRequest, PlanRequest, SimulateRequest, ValidateRequest};
use rist::{Error, Model, identify_experiments, plan, simulate};

fn main() -> Result<(), Error> {
    let models = concat!(env!("CARGO_MANIFEST_DIR"), "/../../models");
    let model = Model::read(format!("{models}/race.yaml"))?;
    let request = PlanRequest { experiments: 3, starts: 2, ..PlanRequest::default() };
    let planned = plan(&model, &request, &|_, _, _| ())?;
    println!("{}", planned.plan);

    // A real robot would run the plan. Here the robot is simulated, with friction, noise and drive gains that the plan does not
    // know.
    let folder = std::env::temp_dir().join(format!("rist-plan-{}", std::process::id()));
    std::fs::create_dir_all(&folder).map_err(Error::new)?;
    let gains = vec![("q1".to_string(), 2.393), ("q2".to_string(), 0.870)];
    let asked = SimulateRequest { validation: 2, gain: gains.clone(), ..SimulateRequest::default() };
    let mut motions: Vec<PathBuf> = Vec::new();
    simulate(&model, &planned.plan, &asked, &mut |name, record| {
        let file = folder.join(format!("{name}.csv"));
        let text = record.to_csv(model.regressor().coordinates(), Effort::Current);
        std::fs::write(&file, text).map_err(Error::new)?;
        motions.extend(name.starts_with('v').then_some(file));
        Ok(())
    })?;

    let logs = ExperimentLogs { directory: &folder, plan: &planned.plan };
    let paper = PaperRequest { gain: vec![("q3".to_string(), 1.0)], ..PaperRequest::default() };
    let estimate = identify_experiments(&model, logs, &HarmonicRequest { paper, ..HarmonicRequest::default() })?;
    println!("{estimate}");
    let validation = validate_experiments(&model, &estimate, &motions, &ValidateRequest::default())?;
    println!("{validation}");
    std::fs::remove_dir_all(&folder).map_err(Error::new)
}
