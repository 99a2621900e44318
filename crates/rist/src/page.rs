//! Writes the HTML page of an identification. It is one file.
//!
//! Input: [`PageRequest`], in which each part is optional. The plot data have the lines over time. The page names options as
//! its reader writes them (program or Python).

use report::comparison::OtherEstimate;
use report::identification::{Page, Subject};

pub use report::experiments::PlanProof;
pub use report::identification::Origin;

use crate::describe::model::Model;
use crate::error::Error;
use crate::fit::validation::{PlotData, Validation};
use crate::fit::verdict::Verdict;
use crate::motion::motion_plot_data::ShownMotion;
use crate::motion::planning::ExperimentPlan;
use crate::request::spelling::{Audience, spelled};
use identification::estimate::artefact::Estimate;

/// The content of the page. Sections for `None` are omitted.
#[derive(Clone, Copy, Default)]
pub struct PageRequest<'a> {
    /// The robot. It gives rules and meanings of parameters, limits, and the values of the description.
    pub model: Option<&'a Model>,
    /// The experiments that were planned.
    pub plan: Option<&'a ExperimentPlan>,
    /// The repeated proofs of these experiments: [`crate::motion::played_file::plan_proof`].
    pub plan_proof: Option<&'a PlanProof>,
    /// The exciting motion, with its plot data: [`crate::motion::motion_plot_data`].
    pub motion: Option<ShownMotion<'a>>,
    /// The estimated parameters.
    pub estimate: Option<&'a Estimate>,
    /// Another estimate of the same model, which is compared with `estimate`: the name of its file, and its content.
    pub against: Option<(&'a str, &'a Estimate)>,
    /// Plot data of predicted logs: [`crate::fit::validation::plot_data`].
    pub plot_data: Option<&'a PlotData>,
    /// The errors of the estimate on logs that were not fitted.
    pub validation: Option<&'a Validation>,
    /// Whether to trust the estimate.
    pub verdict: Option<&'a Verdict>,
    /// The date, the version of rist and the command, which the page shows.
    pub origin: Origin<'a>,
    /// The kind of reader. Names of options in sentences are spelled for this reader.
    pub reader: Audience,
}

/// Fails if two estimates were made with different models, because parameters of different models differ in meaning. `names`:
/// names of the files of the estimates.
pub fn check_comparable(names: [&str; 2], estimates: [&Estimate; 2]) -> Result<(), Error> {
    let [a, b] = estimates.map(|estimate| estimate.fingerprint.as_deref());
    match a.zip(b) {
        Some((a, b)) if a != b => {
            let [first, second] = names;
            Err(Error::new(format_args!(
                "{first} was made with the model {a}, and {second} with {b}: their parameters do not mean the same; identify \
                 both with one description"
            )))
        }
        _ => Ok(()),
    }
}

/// The text of the page; then its charts as SVG files, with the name and the text of each.
pub fn page(request: &PageRequest) -> (String, Vec<(String, String)>) {
    let described = request.model.and_then(Model::nominal_parameters);
    let subject = request.model.map(|model| Subject {
        robot: &model.robot,
        parameters: &model.parameters,
        described: described.as_deref(),
    });
    let path = request.model.map(|model| model.path.display().to_string());
    let PageRequest { plan, plan_proof, motion, estimate, plot_data, validation, verdict, origin, .. } = *request;
    let origin = Origin { model: path.as_deref(), ..origin };
    let against = request.against.map(|(name, estimate)| OtherEstimate { name, estimate });
    let page = Page { subject, plan, plan_proof, motion, estimate, against, plot_data, validation, verdict, origin };
    (spelled(&page.html(), request.reader), page.pictures())
}
