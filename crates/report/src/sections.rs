//! A page of a verdict and sections (sentences, charts, a table), for results that have no page of their own.

use serde::Serialize;

use crate::chart::Chart;
use crate::identification::Origin;
use crate::template::rendered;

/// A part of the page. The charts are drawn above the table.
#[derive(Clone, Debug, Default)]
pub struct Section<'a> {
    /// The heading.
    pub heading: String,
    /// Paragraphs below the heading.
    pub text: Vec<String>,
    /// Charts, in rows.
    pub charts: Vec<Chart<'a>>,
    /// Headings of the columns of the table.
    pub heads: Vec<&'static str>,
    /// Rows of the table; empty: no table.
    pub rows: Vec<Vec<String>>,
}

/// The content of the page.
#[derive(Clone, Debug)]
pub struct SectionsPage<'a> {
    /// Kind of the result, such as "calibration".
    pub kind: &'static str,
    /// Title of the page.
    pub title: String,
    /// CSS class of the verdict: yes, care or no.
    pub tone: &'static str,
    /// The verdict in words.
    pub verdict: String,
    /// Reasons of the verdict.
    pub reasons: Vec<String>,
    /// The parts, in this order.
    pub sections: Vec<Section<'a>>,
}

const STYLE: &str = concat!(include_str!("../templates/page.css"), include_str!("../templates/chart.css"));

#[derive(Serialize)]
struct SectionContext<'a> {
    heading: &'a str,
    text: &'a [String],
    charts: Vec<String>,
    heads: &'a [&'static str],
    rows: &'a [Vec<String>],
}

#[derive(Serialize)]
struct SectionsContext<'a> {
    style: &'static str,
    kind: &'static str,
    title: &'a str,
    tone: &'static str,
    verdict: &'a str,
    reasons: &'a [String],
    sections: Vec<SectionContext<'a>>,
    facts: Vec<(&'static str, String)>,
}

impl SectionsPage<'_> {
    /// The page as HTML. `origin`: the source of the result, for the end of the page.
    pub fn html(&self, origin: &Origin) -> String {
        let sections = self.sections.iter().map(|section| SectionContext {
            heading: &section.heading,
            text: &section.text,
            charts: section.charts.iter().map(Chart::svg).collect(),
            heads: &section.heads,
            rows: &section.rows,
        });
        let content = SectionsContext {
            style: STYLE,
            kind: self.kind,
            title: &self.title,
            tone: self.tone,
            verdict: &self.verdict,
            reasons: &self.reasons,
            sections: sections.collect(),
            facts: origin.facts(),
        };
        rendered(include_str!("../templates/sections.html"), content)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_holds_its_sections_and_escapes_texts() {
        let section = Section {
            heading: "Errors of <j1>".into(),
            text: vec!["one sentence".into()],
            charts: vec![Chart::new("errors", ("m", "m")).true_to_scale().line(
                "before",
                "b",
                &[(0.0, 1.0), (1.0, 2.0)],
            )],
            heads: vec!["name", "value"],
            rows: vec![vec!["r4".into(), "<0.5>".into()]],
        };
        let plain = Section { heading: "Nothing".into(), ..Section::default() };
        let page = SectionsPage {
            kind: "calibration",
            title: "arm".into(),
            tone: "no",
            verdict: "no".into(),
            reasons: vec!["too few postures".into()],
            sections: vec![section, plain],
        };
        let origin = Origin { model: Some("a.urdf"), date: None, version: "1", command: "rist calibrate" };
        let html = page.html(&origin);
        assert!(html.starts_with("<!doctype html>") && !html.contains("could not be made"), "{html}");
        assert!(
            html.contains("Errors of &lt;j1&gt;") && html.contains("<td>&lt;0.5&gt;</td>") && !html.contains("<j1>")
        );
        assert_eq!((html.matches("<table>").count(), html.matches("class=\"chart").count()), (1, 2), "{html}");
        assert!(html.contains("<dd>a.urdf</dd>") && !html.contains("<dt>date</dt>"));
    }
}
