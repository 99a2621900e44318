//! Fuzz target for logs of a two-link arm: finding of columns, log check, identification by every method, sums of logs, and the
//! HTML page.
#![no_main]

use std::cell::OnceCell;

use fleet::SumsRequest;
use identification::estimate::options::Options;
use identification::estimators::drive_gains::likelihood::Gain;
use identification::estimators::weighted::Weights;
use libfuzzer_sys::fuzz_target;
use logs::{ColumnNames, LogSource, Table};
use rist::fit::samples::identify_essential;
use rist::page::{PageRequest, page};
use rist::request::{Delay, FrictionChoice};
use rist::{Estimate, IdentifyRequest, Model, ModelOptions};

const ARM: &str = include_str!("../../models/planar2r_vertical.yaml");

/// Number of identification requests. Each input is tested with request 0 and with one of the others.
const REQUESTS: usize = 7;

thread_local! {
    static MODEL: OnceCell<Model> = const { OnceCell::new() };
}

fuzz_target!(|data: &[u8]| {
    rist::wings::register(vec![foreign::wing()]);
    let Ok(table) = Table::from_bytes("log.csv", data) else { return };
    let which = data.iter().fold(0_usize, |sum, byte| sum + usize::from(*byte)) % REQUESTS;
    MODEL.with(|model| {
        let model = model
            .get_or_init(|| Model::parse(ARM, "arm.yaml", &ModelOptions::default()).expect("the shipped arm is read"));
        let Ok((log, _)) = model.log_of_table(table, &ColumnNames::default()) else { return };
        let logs = [log];
        if let Ok(log_check) = rist::examine(model, &logs, &Options::default()) {
            let _ = log_check.to_string();
        }
        identified(model, &logs, 0);
        identified(model, &logs, which);
        if let Ok(mut sums) = fleet::accumulator(model, &SumsRequest::default()) {
            let _ = fleet::update(model, &mut sums, &logs[0], true);
            let _ = sums.to_bytes().expect("sums are written");
        }
    });
});

fn identified(model: &Model, logs: &[LogSource], which: usize) {
    let mut request = IdentifyRequest { consistent: which == 6, ..IdentifyRequest::default() };
    let samples = &mut request.samples;
    samples.covariance = which == 1;
    samples.rows.weights = (which == 1).then_some(Weights::Huber);
    samples.gain = if which == 2 { vec![("q1".into(), Gain::Known(11.5))] } else { Vec::new() };
    samples.rows.signals.delay = (which == 3).then_some(Delay::Auto);
    samples.rows.friction = (which == 4).then_some(FrictionChoice::Auto);
    let found = match which {
        5 => identify_essential(model, logs, &[], &request.samples),
        _ => rist::identify(model, logs, &request),
    };
    let Ok(found) = found else { return };
    let Ok(verdict) = rist::fit::verdict::fitted_verdict(model, &found.estimate, logs) else { return };
    let _ = (verdict.to_string(), found.estimate.to_string());
    let _ = page(&PageRequest {
        model: Some(model),
        estimate: Some(&found.estimate),
        verdict: Some(&verdict),
        ..PageRequest::default()
    });
    let text = found.estimate.to_yaml().expect("an estimate is written");
    // An estimate that contains NaN or infinity is refused by the reader. This is correct, so it is no finding.
    if let Ok(again) = Estimate::from_yaml("estimate.yaml", &text) {
        let _ = rist::validate(model, &again, logs);
    }
}
