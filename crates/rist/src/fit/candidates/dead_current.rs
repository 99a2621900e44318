//! Subtracts dead currents from the currents of a log. A dead current is the first part of a current, which gives no torque.
//!
//! The fit tests a dead current of each joint as one of its possible faults. Two conditions must hold before rist subtracts
//! dead currents: the dead current of one joint explains the residual better than any other fault, and the subtraction lowers
//! the error on held-out data. The significant dead currents of all joints are then subtracted together.

use identification::estimate::claims::hypotheses::{Hypothesis, HypothesisTest};
use identification::estimate::digits::significant;
use identification::estimate::topics::DEAD_CURRENT_TAKEN;

use crate::error::Error;
use crate::fit::search::{Evidence, Proposal, TriedVariant, Variant, WORTHWHILE_ERROR_RATIO, error_on_parts};

/// Number of rounds in which dead currents are subtracted and then fitted again.
const ROUNDS: usize = 2;

/// Proposes the dead currents of all joints. `None` if the options give some, or if another fault explains the residual better.
pub(crate) fn dead_currents(tried: &mut TriedVariant<'_>) -> Result<Option<Proposal>, Error> {
    let (model, logs) = (tried.model, tried.asked.logs);
    if tried.options.transmission.dead_currents.is_some() {
        return Ok(None);
    }
    let faults = &tried.fitted()?.faults;
    let strongest = faults.iter().filter_map(|fault| Some((fault.gain()?, fault)));
    let strongest = strongest.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, fault)| fault.of);
    if !matches!(strongest, Some(Hypothesis::DeadCurrent(_))) {
        return Ok(None);
    }
    let names = model.regressor().coordinates();
    let (mut options, mut found) = (tried.options.clone(), vec![(0.0, 0.0); names.len()]);
    // The fit of one dead current does not subtract the dead currents of other joints. So after all are subtracted, each is
    // fitted again.
    add_significant(&tried.fitted()?.faults, &mut found);
    for _ in 0..ROUNDS {
        options.transmission.dead_currents = Some(found.iter().map(|of| of.0).collect());
        add_significant(&tried.with_options(options.clone()).fitted()?.faults, &mut found);
    }
    options.transmission.dead_currents = Some(found.iter().map(|of| of.0).collect());
    let of_joint = |(name, (value, deviation)): (&String, &(f64, f64))| {
        (*value > 0.0).then(|| format!("{name} {} +- {} A", significant(*value), significant(*deviation)))
    };
    let said: Vec<String> = names.iter().zip(&found).filter_map(of_joint).collect();
    let errors = [error_on_parts(model, logs, &tried.options)?, error_on_parts(model, logs, &options)?];
    let option = options.remedy_added_to(&tried.options).unwrap_or_default();
    let sentence = format!(
        "dead current, which gives no torque, is taken off: {}: the held-out error is {:.4} instead of {:.4} ({option})",
        said.join(", "),
        errors[1],
        errors[0]
    );
    let evidence = Evidence::Errors { errors, limit: WORTHWHILE_ERROR_RATIO };
    let variant = Variant { model: None, options };
    Ok(Some(Proposal::mending(variant, evidence, DEAD_CURRENT_TAKEN, sentence)))
}

/// Adds the significant dead currents among the faults to `found`: the dead current of each coordinate with its standard
/// deviation, A.
fn add_significant(faults: &[HypothesisTest], found: &mut [(f64, f64)]) {
    for fault in faults.iter().filter(|fault| fault.is_significant()) {
        if let Hypothesis::DeadCurrent(k) = fault.of {
            found[k] = ((found[k].0 + fault.value).max(0.0), fault.deviation);
        }
    }
}
