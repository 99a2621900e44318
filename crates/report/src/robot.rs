//! Writes the data sheet of a robot (links, base parameters, regrouping rules) as text, Markdown, LaTeX and HTML.
//!
//! Input: the content of the sheet ([`crate::sheet`]). Only the HTML page draws the robot.

use std::fmt::Write;

use crate::compact::compact;
use crate::drawing::Drawing;
use crate::sheet::Sheet;
use crate::template::{self, rendered};
use crate::wrap::{table, wrapped};

/// The sheet as text for a terminal, with lines of at most `width` characters.
pub fn text(sheet: &Sheet, width: usize) -> String {
    let mut s = wrapped(&format!("{}: {}", sheet.name, sheet.summary), 0, 2, width);
    if let Some(source) = &sheet.source {
        s += &wrapped(&format!("source: {source}"), 0, 2, width);
    }
    sheet.notes.iter().for_each(|note| s += &wrapped(&format!("note: {note}"), 0, 2, width));
    if !sheet.symbols.is_empty() {
        let symbols: Vec<String> = sheet.symbols.iter().map(|(name, value)| format!("{name} = {value}")).collect();
        s += &wrapped(&format!("with {}", symbols.join(", ")), 0, 2, width);
    }
    s.push('\n');
    let heads = ["link", "name", "joint", "kind", "moves with", "on", "frame"];
    let row = |l: &crate::sheet::LinkLine| -> Vec<String> {
        let kind = l.kind.to_string();
        vec![
            l.number.to_string(),
            l.name.clone(),
            l.joint.clone(),
            kind,
            l.moves_with.clone(),
            l.on.clone(),
            l.frame.clone(),
        ]
    };
    s += &table(&heads, &sheet.links.iter().map(row).collect::<Vec<_>>(), width);
    s += "\n";
    let _ = writeln!(s, "{}:", sheet.count);
    for group in &sheet.groups {
        // Writing to a `String` cannot fail, so the results are ignored.
        let _ = writeln!(s, "{}", group.title);
        let names = group.rows.iter().map(|row| row.name.chars().count()).max().unwrap_or(0);
        let indent = names + 4;
        for row in &group.rows {
            let value = if row.value.is_empty() { String::new() } else { format!("{}: ", row.value) };
            s += &wrapped(&format!("  {:<names$}  {value}{}", row.name, row.meaning), 0, indent, width);
            if !row.rule.is_empty() {
                s += &wrapped(&row.rule, indent, indent + 2, width);
            }
        }
    }
    if !sheet.regrouped.is_empty() {
        s += "with these regrouped parameters, which are no base parameters:\n";
        sheet.regrouped.iter().for_each(|rule| s += &wrapped(rule, 2, 4, width));
    }
    if !sheet.no_effect.is_empty() {
        let text = format!("{} without effect: {}", sheet.no_effect.len(), sheet.no_effect.join(" "));
        s += &wrapped(&text, 0, 2, width);
    }
    s.push('\n');
    sheet.evidence.iter().for_each(|sentence| s += &wrapped(sentence, 0, 2, width));
    s += "\noperations a call       mul    add  sin_cos\n";
    for (name, mul, add, sin_cos) in &sheet.operations {
        let _ = writeln!(s, "  {name:<18} {mul:>6} {add:>6} {sin_cos:>8}");
    }
    s
}

/// The sheet as Markdown, with tables.
pub fn markdown(sheet: &Sheet) -> String {
    template::markdown(include_str!("../templates/robot.md"), sheet)
}

/// The sheet as a fragment of LaTeX: tables for a paper. It needs the packages `booktabs` and `longtable`.
pub fn latex(sheet: &Sheet) -> String {
    template::latex(include_str!("../templates/robot.tex"), sheet)
}

/// The sheet as an HTML page that draws the robot. If the reader selects a base parameter or a link, the page shows how its
/// parameters were regrouped.
pub fn html(sheet: &Sheet) -> String {
    #[derive(serde::Serialize)]
    struct RobotContext<'a> {
        style: &'static str,
        script: String,
        /// HTML content of the figure with the robot; `None` without a drawing.
        drawing: Option<String>,
        robot: &'a Sheet,
    }
    let style = concat!(include_str!("../templates/page.css"), include_str!("../templates/drawing.css"));
    let script = compact(concat!(
        include_str!("../templates/dom.js"),
        include_str!("../templates/drawing.js"),
        include_str!("../templates/loops.js"),
        include_str!("../templates/controls.js"),
        include_str!("../templates/robot.js")
    ));
    let drawing = sheet.drawing.as_ref().map(Drawing::html);
    rendered(include_str!("../templates/robot.html"), RobotContext { style, script, drawing, robot: sheet })
}
