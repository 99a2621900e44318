//! A figure as HTML: charts over one time axis that the script of the page redraws, with their legend.

use serde::Serialize;

use crate::template::rendered;

/// A figure with charts over one time axis.
#[derive(Serialize)]
pub(crate) struct Plot {
    /// Name of the time axis of the charts.
    pub(crate) time: &'static str,
    pub(crate) caption: String,
    /// Key, CSS class and name of each line in the legend. The key is empty for a line without data over the time axis.
    pub(crate) legend: Vec<(String, &'static str, String)>,
    /// The charts as SVG, one below the other.
    pub(crate) svgs: Vec<String>,
}

impl Plot {
    /// Renders the figure as HTML.
    pub(crate) fn html(&self) -> String {
        rendered(include_str!("../templates/plot.html"), self)
    }
}
