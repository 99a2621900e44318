//! Charts over one time axis that the script of the page redraws, with their legend: a figure of HTML.

use serde::Serialize;

use crate::template::rendered;

/// The figure.
#[derive(Serialize)]
pub(crate) struct Plot {
    /// Name of the time axis.
    pub(crate) time: &'static str,
    pub(crate) caption: String,
    /// Key, class and name of each line; a line without data on the axis has no key.
    pub(crate) legend: Vec<(String, &'static str, String)>,
    /// Charts below one another.
    pub(crate) svgs: Vec<String>,
}

impl Plot {
    /// The figure as HTML.
    pub(crate) fn html(&self) -> String {
        rendered(include_str!("../templates/plot.html"), self)
    }
}
