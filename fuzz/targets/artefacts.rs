//! Fuzz target for files that one command writes and another reads (estimates, plans, motions, validations, comparisons), and
//! files that users write (options, limits, loads). Each file that can be read is used as in the program, on a two-link arm.
//!
//! Property: a file that was read is written, and the written text is read and written again without a change.
#![no_main]

use std::cell::OnceCell;
use std::path::Path;

use experiments::excitation::limits::LimitsFile;
use fleet::Comparison;
use identification::estimate::options::Options;
use libfuzzer_sys::fuzz_target;
use linear_model::known_load::KnownLoad;
use logs::Table;
use rist::motion::exciting::ExcitingMotion;
use rist::motion::planning::ExperimentPlan;
use rist::page::{PageRequest, page};
use rist::request::{CheckRequest, ExciteRequest};
use rist::{Estimate, IdentifyRequest, Model, ModelOptions, Validation};

const ARM: &str = include_str!("../../models/planar2r_vertical.yaml");
const LOG: &[u8] = include_bytes!("../corpus/identify/short.csv");

thread_local! {
    static MODEL: OnceCell<Model> = const { OnceCell::new() };
}

fuzz_target!(|data: &[u8]| {
    let Ok(text) = std::str::from_utf8(data) else { return };
    MODEL.with(|model| {
        let model = model
            .get_or_init(|| Model::parse(ARM, "arm.yaml", &ModelOptions::default()).expect("the shipped arm is read"));
        read(model, text);
    });
});

fn read(model: &Model, text: &str) {
    if let Ok(estimate) = Estimate::from_yaml("estimate.yaml", text) {
        again(estimate.to_yaml(), |text| Estimate::from_yaml("again.yaml", text).and_then(|x| x.to_yaml()));
        let _ = estimate.to_string();
        let verdict = rist::fit::verdict::estimate_verdict(&estimate);
        let told = PageRequest {
            model: Some(model),
            estimate: Some(&estimate),
            verdict: Some(&verdict),
            ..PageRequest::default()
        };
        let _ = page(&told);
        let _ = model.values(&estimate);
    }
    if let Ok(plan) = ExperimentPlan::from_yaml("plan.yaml", text) {
        again(plan.to_yaml(), |text| ExperimentPlan::from_yaml("again.yaml", text).and_then(|x| x.to_yaml()));
        let _ = plan.trajectories("plan.yaml");
        let _ = page(&PageRequest { plan: Some(&plan), ..PageRequest::default() });
    }
    if let Ok(motion) = ExcitingMotion::from_yaml("motion.yaml", text) {
        again(motion.to_yaml(), |text| ExcitingMotion::from_yaml("again.yaml", text).and_then(|x| x.to_yaml()));
        let _ = motion.to_string();
        let _ = rist::check(model, Path::new("motion.yaml"), &motion, &CheckRequest::default());
    }
    if let Ok(validation) = Validation::from_yaml("validation.yaml", text) {
        again(validation.to_yaml(), |text| Validation::from_yaml("again.yaml", text).and_then(|x| x.to_yaml()));
        let _ = page(&PageRequest { validation: Some(&validation), ..PageRequest::default() });
    }
    if let Ok(comparison) = Comparison::from_yaml("comparison.yaml", text) {
        again(comparison.to_yaml(), |text| Comparison::from_yaml("again.yaml", text).and_then(|x| x.to_yaml()));
        let _ = comparison.to_string();
    }
    if let Ok(options) = Options::parse("options.yaml", text) {
        let table = Table::from_bytes("log.csv", LOG).expect("the log is read");
        if let Ok((log, _)) = model.log_of_table(table, &options.columns) {
            let _ = rist::identify(model, &[log], &IdentifyRequest::of_options(options));
        }
    }
    if let Ok(limits) = LimitsFile::from_yaml("limits.yaml", text) {
        let little = ExciteRequest {
            limits: Some(limits),
            harmonics: Some(2),
            rate: 20.0,
            starts: 1,
            iterations: 1,
            ..ExciteRequest::default()
        };
        let _ = rist::excite(model, &little, &|_, _, _| {});
    }
    if let Ok(load) = KnownLoad::from_yaml("load.yaml", text) {
        let _ = model.added_by(&load);
    }
}

/// Checks that a written text can be read and written again without a change.
fn again<E: std::fmt::Debug>(written: Result<String, E>, read: impl Fn(&str) -> Result<String, E>) {
    let written = written.expect("what was read is written");
    assert_eq!(read(&written).expect("what was written is read"), written);
}
