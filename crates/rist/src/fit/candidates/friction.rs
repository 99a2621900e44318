//! Chooses the friction terms of an identification: for all joints, and additional ones for single joints.
//!
//! | request | terms |
//! |---|---|
//! | terms | the given terms |
//! | `auto` | the set for all joints with the smallest error on held-out data, and additional terms of single joints |
//! | nothing | viscous and Coulomb friction, an offset, and terms of single joints that predict held-out data far better |

use identification::estimate::claims::hypotheses::HypothesisTest;
use identification::estimate::consistent::identify_consistent;
use identification::estimate::identified::Status;
use identification::estimate::identify::Fit;
use identification::estimate::joint_terms::{JointTerms, choose_joint_terms, joint_candidates};
use identification::estimate::options::Options;
use identification::estimate::selection::{FrictionSelection, friction_candidates, preparation, select_friction};
use identification::estimators::huber::Robust;
use identification::rows::observation::Observation;
use identification::signals::records::SourceRecords;
use linear_model::friction::terms::{FrictionTerm, JointTerm, check_terms};
use linear_model::parameter::{FrictionParameter, ParameterId};
use logs::LogSource;

use crate::describe::model::Model;
use crate::error::Error;
use crate::fit::search::{
    Decisions, Evidence, Fitted, KeptParameters, Proposal, TriedVariant, Variant, WORTHWHILE_ERROR_RATIO,
};

/// Proposes the friction terms of the request. If the request says `auto`, chooses the terms. Friction that grows with the load
/// also gets the base parameters that predict the load.
pub(crate) fn asked_friction(tried: &mut TriedVariant<'_>) -> Result<Option<Proposal>, Error> {
    let (model, logs, request, kept) = (tried.model, tried.asked.logs, tried.asked.request, tried.asked.kept);
    let (mut options, mut found) = (tried.options.clone(), Decisions::default());
    if request.finds_friction() {
        found.friction = Some(found_friction(model, logs, &mut options)?);
    }
    check_terms(&options.friction, model.regressor().coordinates().len()).map_err(Error::new)?;
    if request.finds_friction() {
        let Predicted { load, speed, x, robust } = predicted_load(model, logs, kept, &options)?;
        let robust_rows = robust.as_ref().map(|rows| (x.as_slice(), rows));
        found.joint_terms = Some(found_joint_terms(model, logs, load, &speed, &mut options, robust_rows)?);
    } else if options.friction_load.is_empty() && grows_with_load(&options) {
        options.friction_load = predicted_load(model, logs, kept, &options)?.load;
    }
    Ok(Some(Proposal::given(options, found)))
}

/// Proposes additional friction terms of single joints, if the request does not mention friction. They must lower the error on
/// held-out data by far, and much more than any log fault that would explain the residual.
pub(crate) fn joint_friction(tried: &mut TriedVariant<'_>) -> Result<Option<Proposal>, Error> {
    let (model, logs) = (tried.model, tried.asked.logs);
    if !tried.asked.request.leaves_friction_open() {
        return Ok(None);
    }
    // Logs that are too long for memory are skipped, because such logs would have to be read again.
    if logs.iter().any(|log| matches!(log, LogSource::Streamed(_))) {
        let sentence = "friction of single joints was not looked for, since the logs are too long to be held in memory \
                        ([friction=auto] looks for it)";
        let found = Decisions { sentences: vec![sentence.into()], ..Decisions::default() };
        return Ok(Some(Proposal::given(tried.options.clone(), found)));
    }
    let mut options = tried.options.clone();
    let Fitted { fit, faults } = tried.fitted()?;
    let load = fit.solution.x[..model.regressor().parameters().len()].to_vec();
    // If a joint moves too little to identify viscous and Coulomb friction, additional terms would fit noise.
    let coordinates = model.regressor().coordinates();
    let is_weak = |name: &String| {
        let ids = [FrictionParameter::Viscous, FrictionParameter::Coulomb].map(|f| ParameterId::friction(f, name));
        fit.estimate
            .parameters
            .iter()
            .any(|p| ids.contains(&p.id) && [Status::Weak, Status::NotIdentifiable].contains(&p.status))
    };
    let speed: Vec<f64> =
        coordinates.iter().zip(&fit.observation.speed).map(|(k, v)| if is_weak(k) { 0.0 } else { *v }).collect();
    let found = found_joint_terms(model, logs, load, &speed, &mut options, fit.of_rows())?;
    let with = found.error * found.taken.last().map_or(1.0, |taken| taken.ratio);
    // A log fault has one parameter, but the friction terms have several. So the logarithm of the error ratio must be twice as
    // large for the terms as for any fault.
    let of_faults = faults.iter().filter_map(HypothesisTest::gain).fold(1.0, f64::min);
    let terms: Vec<String> = found.taken.iter().map(|taken| in_words(&taken.term, coordinates)).collect();
    let sentence = format!(
        "{}: the held-out error is {with:.4} instead of {:.4} ([friction=viscous,coulomb,offset] omits them)",
        terms.join(", "),
        found.error
    );
    Ok(Some(Proposal {
        variant: Variant { model: None, options },
        evidence: Evidence::Errors {
            errors: [found.error, with],
            limit: WORTHWHILE_ERROR_RATIO.min(of_faults * of_faults),
        },
        found: Decisions { sentences: vec![sentence], ..Decisions::default() },
    }))
}

/// Names a friction term in a sentence to the user.
fn in_words(term: &FrictionTerm, coordinates: &[String]) -> String {
    match term {
        FrictionTerm::At(number, term) => term.sentence(&coordinates[number - 1]),
        term => format!("friction {term}"),
    }
}

/// Chooses the friction terms for all joints by the smallest error on held-out data, and writes them into the options.
///
/// Fails if a log cannot be read.
fn found_friction(model: &Model, logs: &[LogSource], options: &mut Options) -> Result<FrictionSelection, Error> {
    let records = SourceRecords::new(model.regressor(), logs, &options.preparation())?;
    let seen = Observation::of_records(&options.linear_model_with(model.regressor(), &[]), &records, None)?;
    let candidates = friction_candidates(seen.speed.iter().copied().fold(0.0, f64::max));
    let records = SourceRecords::new(model.regressor(), logs, &preparation(options, &candidates))?;
    let selection = select_friction(model.regressor(), &records, options, &candidates)?;
    options.friction = selection.candidates[selection.chosen].terms.clone();
    Ok(selection)
}

/// Whether a friction term in the options grows with the load of its joint.
fn grows_with_load(options: &Options) -> bool {
    options.friction.iter().any(|term| matches!(term, FrictionTerm::At(_, JointTerm::Load)))
}

/// Results of a fit without load-dependent friction. The load is predicted from these results.
struct Predicted {
    /// The base parameters from which the load (torque) of each joint is predicted.
    load: Vec<f64>,
    /// The largest speed of each joint, rad/s or m/s.
    speed: Vec<f64>,
    /// All parameters of the fit without load-dependent friction.
    x: Vec<f64>,
    robust: Option<Robust>,
}

fn predicted_load(
    model: &Model,
    logs: &[LogSource],
    kept: KeptParameters,
    options: &Options,
) -> Result<Predicted, Error> {
    let mut options = options.clone();
    options.friction.retain(|term| !matches!(term, FrictionTerm::At(_, JointTerm::Load)));
    let records = SourceRecords::new(model.regressor(), logs, &options.preparation())?;
    let names = logs.iter().map(LogSource::name).collect();
    let fit = Fit::of_records(model.regressor(), &records, names, &options)?;
    let (speed, robust, x) = (fit.observation.speed.clone(), fit.robust.clone(), fit.solution.x.clone());
    let load = match kept {
        KeptParameters::All | KeptParameters::Free | KeptParameters::Essential => fit.solution.x,
        KeptParameters::Consistent => {
            let (map, known) = (model.standard_map(), model.reference_bodies());
            identify_consistent(model.regressor(), &map, &known, &fit, &options, &Default::default())?.consistent.x
        }
    };
    Ok(Predicted { load: load[..model.regressor().parameters().len()].to_vec(), speed, x, robust })
}

/// Chooses additional friction terms of single joints, and writes them into the options. `load`: the base parameters that
/// predict the load; `speed`: the largest speed of each joint, rad/s or m/s; `robust_rows`: parameters and row weights of a
/// robust fit.
fn found_joint_terms(
    model: &Model,
    logs: &[LogSource],
    load: Vec<f64>,
    speed: &[f64],
    options: &mut Options,
    robust_rows: Option<(&[f64], &Robust)>,
) -> Result<JointTerms, Error> {
    let with_load = Options { friction_load: load, ..options.clone() };
    let records = SourceRecords::new(model.regressor(), logs, &with_load.preparation())?;
    let is_new = |term: &FrictionTerm| !options.friction.iter().any(|own| own.parameters() == term.parameters());
    let candidates: Vec<FrictionTerm> = joint_candidates(speed).into_iter().filter(is_new).collect();
    let found = choose_joint_terms(model.regressor(), &records, options, &candidates, robust_rows)?;
    options.friction.extend(found.taken.iter().map(|taken| taken.term));
    if found.has_load() {
        options.friction_load = with_load.friction_load;
    }
    Ok(found)
}
