//! The files that one step leaves for the next: estimates, plans, motions, validations, options, loads.
//!
//! Law: what is read is written, and what was written is read again as the same.
#![no_main]

use identification::estimate::options::Options;
use identification::model::known_load::KnownLoad;
use libfuzzer_sys::fuzz_target;
use rist::{Estimate, ExcitingMotion, ExperimentPlan, Validation};

fuzz_target!(|data: &[u8]| {
    let Ok(text) = std::str::from_utf8(data) else { return };
    if let Ok(estimate) = Estimate::from_yaml("estimate.yaml", text) {
        let written = estimate.to_yaml().expect("an estimate that was read is written");
        let again = Estimate::from_yaml("again.yaml", &written).expect("an estimate that was written is read");
        assert!(again == estimate, "{written}");
    }
    if let Ok(plan) = ExperimentPlan::from_yaml("plan.yaml", text) {
        let _ = plan.trajectories("plan.yaml");
    }
    if let Ok(motion) = ExcitingMotion::from_yaml("motion.yaml", text) {
        let _ = motion.motion("motion.yaml");
    }
    let _ = Validation::from_yaml("validation.yaml", text);
    let _ = Options::parse("options.yaml", text);
    let _ = KnownLoad::from_yaml("load.yaml", text);
});
