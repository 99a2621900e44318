//! Runs `rist excite` with default settings for known arms and for the serial robots of models/. It prints the time, what was
//! proven, and the violations of limits at a hundred times the sampling rate: `cargo bench -p tests --bench excite`. Arguments
//! select robots by name.
//!
//! A motion is violated at a sample if position, velocity, acceleration or jerk of a joint exceeds its limit.

use std::path::Path;
use std::time::Instant;

use rist::Model;
use rist::request::ExciteRequest;
use tests::dense_samples::violations;
use tests::known_arms::KNOWN_ARMS;
use tests::model_path;

/// The robots of models/ whose links form a single chain.
const SERIAL: [&str; 12] = [
    "cartesian3p.yaml",
    "kuka_lwr.yaml",
    "panda.yaml",
    "planar2r.yaml",
    "planar2r_vertical.yaml",
    "puma560.yaml",
    "race.yaml",
    "rx90.yaml",
    "scara.yaml",
    "stanford.yaml",
    "tx40.yaml",
    "ur5.urdf",
];

fn main() {
    let words: Vec<String> = std::env::args().skip(1).filter(|w| !w.starts_with("--")).collect();
    let wanted = |name: &str| words.is_empty() || words.iter().any(|w| w == name);
    println!("{:<24} {:>6} {:>9} {:>7} {:>12} of samples", "arm", "joints", "s", "proven", "violations");
    for arm in KNOWN_ARMS.iter().filter(|arm| wanted(arm.name)) {
        let model = Model::parse(&arm.urdf(), Path::new(arm.name).with_extension("urdf"), &Default::default());
        row(arm.name, &model.expect("a description"));
    }
    for file in SERIAL.into_iter().filter(|file| wanted(file)) {
        row(file, &Model::read(model_path(file)).expect("a description"));
    }
}

fn row(name: &str, model: &Model) {
    let clock = Instant::now();
    match rist::excite(model, &ExciteRequest::default(), &|_, _, _| ()) {
        Ok(found) => {
            let seconds = clock.elapsed().as_secs_f64();
            let (beyond, samples) = violations(&found, 100.0);
            println!(
                "{name:<24} {:>6} {seconds:>9.1} {:>7} {beyond:>12} of {samples}",
                found.joints.len(),
                found.proven
            );
        }
        Err(error) => println!("{name:<24} {error}"),
    }
}
