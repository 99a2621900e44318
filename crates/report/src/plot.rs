//! A figure as HTML: charts over one time axis, with a legend. The script of the page redraws them.
//!
//! The script finds the data of a line by its key.

use serde::Serialize;

use crate::template::rendered;

/// A figure of charts over one time axis.
#[derive(Serialize)]
pub(crate) struct Plot {
    /// Name of the time axis.
    pub(crate) time: &'static str,
    pub(crate) caption: String,
    /// Key, CSS class and name of each line in the legend. The key is empty for a line that the script does not redraw.
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
