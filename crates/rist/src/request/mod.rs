//! Requests of the steps (commands such as `rist identify`). A request is a struct with all options of a step. The options are
//! defined only there.
//!
//! A field is defined once, with its doc, type, default and range:
//!
//! ```text
//! /// Sample rate of the controller, Hz
//! rate: f64 = 1000.0, range(1.0..=2e4), value_name("HZ");
//! ```
//!
//! | generated from it | by |
//! |---|---|
//! | the field of the struct and its default | `request!` |
//! | `--rate <HZ>` and its help | the program, from [`Request::fields`] |
//! | `rate=1000.0` of Python | crates/python |
//! | its stub, its signature, its line of the docstring, its row in docs/files.md | `cargo xtask stubs` |
//! | the JSON schema | `rist schema`, from [`schema::schema`] |
//! | the refusal of a rate of 0 | [`Request::check`] |
//!
//! Texts of the library name a field in brackets, `[rate]`, or with a value, `[delay=auto]`. The program that shows the text
//! replaces them by its own spelling ([`spelling`]). Texts of a library contain no flags.
//!
//! Checks that need a model are elsewhere, for example whether a coordinate exists.

// Modules with macros come first, because the modules below use them.
#[macro_use]
mod table;
#[macro_use]
pub mod words;

mod describe;
mod effect;
mod examine;
mod excite;
mod field;
pub mod file;
mod files;
mod friction;
mod gains;
mod generate;
mod identify;
mod method;
mod model;
mod plan;
mod play;
mod range;
pub mod schema;
mod shape;
mod simulate;
pub mod spelling;
mod types;
mod unknowns;

use std::sync::OnceLock;

pub use describe::{ConvertRequest, DescriptionFormat, EvaluateRequest, InspectRequest, SheetFormat, StateQuantity};
pub use effect::{Delay, JointSelector};
pub use examine::{CheckRequest, DoctorRequest, MOTION_CUTOFF, ObserverOrder, ReplayRequest, ValidateRequest};
pub use excite::{ExciteRequest, MotionFamily, MotionSeries};
pub use field::Field;
pub use files::{BodiesFiles, PlanFiles, PointsFiles, ReportFiles, SamplesFiles, TrajectoryFiles};
pub use friction::{FrictionChoice, terms_without_torque};
pub(crate) use generate::MONITOR;
pub use generate::{GenerateRequest, SourceLanguage, function_names};
pub use identify::{
    ClosedLoopRequest, HarmonicRequest, IdentifyRequest, METHOD, PaperRequest, RowsRequest, SamplesRequest,
    SignalRequest,
};
pub use method::{Method, MethodRequest};
pub use model::ModelOptions;
pub use plan::PlanRequest;
pub use play::{PlayRequest, PlayTarget};
pub use range::{Range, number};
pub use shape::{Flag, ValueShape};
pub use simulate::SimulateRequest;
pub use table::{Request, of_values, unknown};
pub use table::{has, in_range, value_of};
pub use types::FieldType;
pub use unknowns::UnknownKind;
pub use words::WordChoice;

/// The fields of all requests, each with the name of the request: the name of the step, or `identify-METHOD`.
pub fn requests() -> Vec<(String, Vec<Field>)> {
    let steps = [
        ("model", ModelOptions::fields()),
        ("inspect", InspectRequest::fields()),
        ("convert", ConvertRequest::fields()),
        ("evaluate", EvaluateRequest::fields()),
        ("generate", GenerateRequest::fields()),
        ("plan", PlanRequest::fields()),
        ("excite", ExciteRequest::fields()),
        ("simulate", SimulateRequest::fields()),
        ("doctor", DoctorRequest::fields()),
        ("validate", ValidateRequest::fields()),
        ("replay", ReplayRequest::fields()),
        ("check", CheckRequest::fields()),
        ("play", PlayRequest::fields()),
    ];
    let methods = Method::all().map(|method| (format!("identify-{}", method.word()), method.fields()));
    let of_wings = REGISTERED.get().into_iter().flatten().map(|(name, fields)| (*name, fields()));
    steps.into_iter().chain(of_wings).map(|(name, fields)| (name.to_string(), fields)).chain(methods).collect()
}

/// A request that a wing (an optional package) adds: its name and its fields.
pub type WingRequest = (&'static str, fn() -> Vec<Field>);

static REGISTERED: OnceLock<Vec<WingRequest>> = OnceLock::new();

/// Registers the requests of wings (optional packages). Only the first call has an effect.
pub(crate) fn register(requests: Vec<WingRequest>) {
    REGISTERED.get_or_init(|| requests);
}

/// All fields that a text may name in brackets: the fields of all requests, and the options for files.
pub fn all_fields() -> Vec<Field> {
    let requests: Vec<Field> = requests().into_iter().flat_map(|(_, fields)| fields).collect();
    let files = Method::all()
        .flat_map(Method::files)
        .chain(TrajectoryFiles::fields())
        .chain(PointsFiles::fields())
        .chain(ReportFiles::fields());
    let files: Vec<Field> = files.collect();
    [requests, MethodRequest::fields(), files].concat()
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::{Value, json};

    #[test]
    fn a_request_is_read_by_names_and_refuses_others() {
        let request: PlanRequest = of_values([("steps", &json!(3)), ("criterion", &json!("condition"))]).unwrap();
        assert_eq!(request.steps, 3);
        assert_eq!(request.given(), [("criterion", json!("condition")), ("steps", json!(3))]);
        let refused = |name: &str, value: Value| of_values::<PlanRequest>([(name, &value)]).unwrap_err().to_string();
        for (name, value, said) in [
            ("step", json!(3), "there is no option `step` (did you mean [steps]?); there are experiments, "),
            ("colour", json!(3), "there is no option `colour`; there are experiments, "),
            ("steps", json!("3"), "[steps] is \"3\"; expected is a whole number"),
            ("steps", json!(-3), "[steps] is -3; expected is a whole number"),
            ("steps", json!(0), "[steps] is 0; expected is a number from 1 to 1000"),
            ("criterion", json!("best"), "[criterion] is \"best\"; expected is one of determinant, condition"),
        ] {
            let refused = refused(name, value);
            assert!(refused == said || (said.ends_with(", ") && refused.starts_with(said)), "{refused}");
        }
    }

    #[test]
    fn the_table_agrees_with_itself() {
        PlanRequest::default().check().unwrap();
        for field in all_fields() {
            assert!(field.doc.len() > 8, "{}", field.name);
            assert!(!field.doc.contains("--"), "{}: {}", field.name, field.doc);
        }
    }
}
