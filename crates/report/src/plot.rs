//! Charts over one axis of time that a script of the page draws anew, with their legend: a figure of HTML.

use serde::Serialize;

use crate::template::rendered;

/// The figure.
#[derive(Serialize)]
pub(crate) struct Plot {
    /// Name of the axis of time.
    pub(crate) time: &'static str,
    pub(crate) caption: String,
    /// Key, class and name of each line; what is no line of the axis has no key.
    pub(crate) legend: Vec<(String, &'static str, String)>,
    /// Charts below one another.
    pub(crate) svgs: Vec<String>,
}

impl Plot {
    /// As HTML.
    pub(crate) fn html(&self) -> String {
        rendered(include_str!("../templates/plot.html"), self)
    }
}
