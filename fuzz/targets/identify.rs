//! A log of a two-link arm, as text: columns, identification by least squares and Huber, the verdict and the artefact.
#![no_main]

use std::cell::OnceCell;

use identification::estimate::options::Options;
use identification::estimators::weighted::Weights;
use libfuzzer_sys::fuzz_target;
use logs::{ColumnNames, Table};
use rist::{IdentifyRequest, Model, ModelOptions};

const ARM: &str = include_str!("../../models/planar2r_vertical.yaml");

thread_local! {
    static MODEL: OnceCell<Model> = const { OnceCell::new() };
}

fuzz_target!(|data: &[u8]| {
    let Ok(table) = Table::from_bytes("log.csv", data) else { return };
    MODEL.with(|model| {
        let options = ModelOptions::default();
        let model = model.get_or_init(|| Model::parse(ARM, "arm.yaml", &options).expect("the shipped arm is read"));
        let Ok((log, _)) = model.log_of_table(table, &ColumnNames::default()) else { return };
        for weights in [Weights::Joint, Weights::Huber] {
            let options = Options { weights, ..Options::default() };
            let request = IdentifyRequest { options, ..IdentifyRequest::default() };
            let Ok(found) = rist::identify(model, std::slice::from_ref(&log), &request) else { continue };
            let _ = (found.verdict(None).to_string(), found.estimate.to_string());
            let text = found.estimate.to_yaml().expect("an estimate is written");
            // One that holds what is no number is refused when it is read, which is an answer.
            let _ = rist::Estimate::from_yaml("estimate.yaml", &text);
        }
    });
});
