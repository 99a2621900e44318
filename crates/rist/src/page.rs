//! The page of an identification, with all parts that are given, as one file of HTML.

use report::identification::{Page, Subject};

pub use report::identification::Origin;

use crate::Estimate;
use crate::model::Model;
use crate::motion_portrait::ShownMotion;
use crate::planning::ExperimentPlan;
use crate::request::spelling::{Reader, spelled};
use crate::validation::{Portrait, Validation};
use crate::verdict::Verdict;

/// The content of the page. A part that is not given is left out.
#[derive(Clone, Copy, Default)]
pub struct PageRequest<'a> {
    /// The robot, for rules, meanings, limits and the values of the description.
    pub model: Option<&'a Model>,
    /// The experiments that were planned.
    pub plan: Option<&'a ExperimentPlan>,
    /// The exciting motion, with what is drawn of it: [`crate::motion_portrait`].
    pub motion: Option<ShownMotion<'a>>,
    /// The parameters.
    pub estimate: Option<&'a Estimate>,
    /// What they predict for logs: [`crate::validation::portrait`].
    pub portrait: Option<&'a Portrait>,
    /// How well they predict other logs.
    pub validation: Option<&'a Validation>,
    /// Whether to trust them.
    pub verdict: Option<&'a Verdict>,
    /// Date, version and command.
    pub origin: Origin<'a>,
    /// Who reads it: fields in its sentences are spelled so.
    pub reader: Reader,
}

/// The page, and its charts as files of SVG by name.
pub fn page(request: &PageRequest) -> (String, Vec<(String, String)>) {
    let described = request.model.and_then(Model::described_parameters);
    let subject = request.model.map(|model| Subject {
        robot: &model.robot,
        parameters: &model.parameters,
        described: described.as_deref(),
    });
    let path = request.model.map(|model| model.path.display().to_string());
    let PageRequest { plan, motion, estimate, portrait, validation, verdict, origin, .. } = *request;
    let origin = Origin { model: path.as_deref(), ..origin };
    let page = Page { subject, plan, motion, estimate, portrait, validation, verdict, origin };
    (spelled(&page.html(), request.reader), page.pictures())
}
