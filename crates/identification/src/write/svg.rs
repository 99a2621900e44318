//! Pictures: lines over time, and a table of values with their intervals, as SVG.
//!
//! Nothing is loaded from elsewhere. The colours are those of Okabe and Ito, which everybody can tell apart; lines
//! differ in their dashes too.

use std::fmt::Write;

/// A line of a chart.
#[derive(Clone, Debug)]
pub struct Line<'a> {
    /// In the legend.
    pub name: &'a str,
    /// Abscissas.
    pub x: &'a [f64],
    /// Ordinates.
    pub y: &'a [f64],
}

const COLOURS: [&str; 4] = ["#0072b2", "#d55e00", "#009e73", "#cc79a7"];
const DASHES: [&str; 4] = ["", "7 4", "2 3", "9 3 2 3"];
const FONT: &str = "font-family=\"system-ui, sans-serif\"";

/// Lines over a common axis, 720 x 260.
pub fn chart(title: &str, x_name: &str, y_name: &str, lines: &[Line]) -> String {
    let (width, height) = (720.0, 260.0);
    let (left, right, top, bottom) = (62.0, 14.0, 34.0, 42.0);
    let all = |f: &dyn Fn(&Line) -> Vec<f64>| lines.iter().flat_map(f).filter(|x| x.is_finite()).collect::<Vec<f64>>();
    let (x_low, x_high) = range(&all(&|l| l.x.to_vec()), 0.0);
    let (y_low, y_high) = range(&all(&|l| l.y.to_vec()), 0.06);
    let px = |x: f64| left + (x - x_low) / (x_high - x_low) * (width - left - right);
    let py = |y: f64| height - bottom - (y - y_low) / (y_high - y_low) * (height - top - bottom);
    let mut s = open(width, height, title);
    // A String never fails to grow.
    let _ = writeln!(s, "<text x=\"{left}\" y=\"18\" font-size=\"14\" font-weight=\"600\">{}</text>", escaped(title));
    for y in ticks(y_low, y_high) {
        let at = py(y);
        let end = width - right;
        let _ = writeln!(s, "<line x1=\"{left}\" x2=\"{end}\" y1=\"{at:.1}\" y2=\"{at:.1}\" stroke=\"#ddd\"/>");
        let _ = writeln!(
            s,
            "<text x=\"{}\" y=\"{:.1}\" font-size=\"11\" text-anchor=\"end\">{}</text>",
            left - 6.0,
            at + 4.0,
            number(y)
        );
    }
    for x in ticks(x_low, x_high) {
        let y = height - bottom + 16.0;
        let _ = writeln!(
            s,
            "<text x=\"{:.1}\" y=\"{y}\" font-size=\"11\" text-anchor=\"middle\">{}</text>",
            px(x),
            number(x)
        );
    }
    for (i, line) in lines.iter().enumerate() {
        let points: Vec<String> =
            line.x.iter().zip(line.y).map(|(&x, &y)| format!("{:.1},{:.1}", px(x), py(y))).collect();
        let (colour, dash) = (COLOURS[i % 4], DASHES[i % 4]);
        let _ = writeln!(
            s,
            "<polyline fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.5\" stroke-dasharray=\"{dash}\" points=\"{}\"/>",
            points.join(" ")
        );
        let x = width - right - 130.0 * (lines.len() - i) as f64;
        let _ = writeln!(
            s,
            "<line x1=\"{x}\" x2=\"{}\" y1=\"14\" y2=\"14\" stroke=\"{colour}\" stroke-width=\"2\" stroke-dasharray=\"{dash}\"/>",
            x + 26.0
        );
        let _ = writeln!(s, "<text x=\"{}\" y=\"18\" font-size=\"12\">{}</text>", x + 32.0, escaped(line.name));
    }
    let middle = 0.5 * (left + width - right);
    let _ = writeln!(
        s,
        "<text x=\"{middle}\" y=\"{}\" font-size=\"12\" text-anchor=\"middle\">{}</text>",
        height - 8.0,
        escaped(x_name)
    );
    let half = 0.5 * (top + height - bottom);
    let _ = writeln!(
        s,
        "<text x=\"14\" y=\"{half}\" font-size=\"12\" text-anchor=\"middle\" transform=\"rotate(-90 14 {half})\">{}</text>",
        escaped(y_name)
    );
    s.push_str("</svg>\n");
    s
}

/// A row of the table: a value with its 95 % interval, or none.
#[derive(Clone, Debug)]
pub struct Row<'a> {
    /// Name of the parameter.
    pub name: &'a str,
    /// Unit of its value.
    pub unit: &'a str,
    /// Value and half the width of the interval; `None`: not identifiable.
    pub value: Option<(f64, f64)>,
    /// Behind the interval.
    pub remark: &'a str,
}

/// Figure 2(d): names, values, intervals, each with a bar of the interval relative to the value.
pub fn table(title: &str, rows: &[Row]) -> String {
    let (width, line, top) = (720.0, 22.0, 58.0);
    let height = top + line * rows.len() as f64 + 10.0;
    let mut s = open(width, height, title);
    let _ = writeln!(s, "<text x=\"14\" y=\"20\" font-size=\"14\" font-weight=\"600\">{}</text>", escaped(title));
    for (x, anchor, head) in
        [(14, "start", "parameter"), (230, "end", "value"), (410, "end", "95 % interval"), (424, "start", "unit")]
    {
        let _ = writeln!(
            s,
            "<text x=\"{x}\" y=\"42\" font-size=\"12\" fill=\"#555\" text-anchor=\"{anchor}\">{head}</text>"
        );
    }
    for (i, row) in rows.iter().enumerate() {
        let y = top + line * i as f64;
        if i % 2 == 0 {
            let _ = writeln!(s, "<rect x=\"8\" y=\"{}\" width=\"704\" height=\"{line}\" fill=\"#f4f6f8\"/>", y - 6.0);
        }
        let base = y + 9.0;
        let mut text = |x: f64, anchor: &str, content: &str| {
            let _ = writeln!(
                s,
                "<text x=\"{x}\" y=\"{base}\" font-size=\"12\" text-anchor=\"{anchor}\">{}</text>",
                escaped(content)
            );
        };
        text(14.0, "start", row.name);
        text(424.0, "start", row.unit);
        match row.value {
            Some((value, half)) => {
                text(230.0, "end", &format!("{value:.5}"));
                text(410.0, "end", &format!("[{:.5}, {:.5}]", value - half, value + half));
                text(520.0, "start", row.remark);
            }
            None => {
                text(410.0, "end", "(-\u{221e}, \u{221e})");
                text(520.0, "start", "not identifiable");
            }
        }
    }
    s.push_str("</svg>\n");
    s
}

fn open(width: f64, height: f64, title: &str) -> String {
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" role=\"img\" {FONT}>\n\
         <title>{}</title>\n<rect width=\"{width}\" height=\"{height}\" fill=\"#fff\"/>\n",
        escaped(title)
    )
}

/// Smallest and largest value, widened by a share of their difference; never empty.
fn range(x: &[f64], margin: f64) -> (f64, f64) {
    let low = x.iter().copied().fold(f64::INFINITY, f64::min);
    let high = x.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    match high - low {
        d if d > 0.0 => (low - margin * d, high + margin * d),
        _ if low.is_finite() => (low - 0.5, low + 0.5),
        _ => (0.0, 1.0),
    }
}

/// Some four to eight round numbers.
fn ticks(low: f64, high: f64) -> Vec<f64> {
    let rough = (high - low) / 5.0;
    let power = 10.0_f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].into_iter().map(|f| f * power).find(|s| *s >= rough).unwrap_or(10.0 * power);
    let first = (low / step).ceil() as i64;
    (first..first + 12).map(|i| i as f64 * step).take_while(|x| *x <= high + 1e-9 * step).collect()
}

/// A number without the digits that rounding adds.
fn number(x: f64) -> String {
    let text = format!("{x:.6}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".into() } else { text.into() }
}

/// The text, escaped for text and attributes of XML and HTML.
pub fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn charts_hold_their_lines() {
        let (x, y) = ([0.0, 1.0, 2.0], [5.0, -5.0, f64::NAN]);
        let line = Line { name: "a < b", x: &x, y: &y[..2] };
        let svg = chart("torque & time", "t, s", "N m", &[line.clone(), line]);
        assert!(svg.starts_with("<svg ") && svg.ends_with("</svg>\n"));
        assert_eq!(svg.matches("<polyline").count(), 2);
        assert!(svg.contains("a &lt; b") && svg.contains("torque &amp; time") && !svg.contains("NaN"));
        assert!(chart("", "", "", &[]).contains("</svg>"));
    }

    #[test]
    fn ticks_are_round_and_inside() {
        assert_eq!(ticks(0.0, 1.0), [0.0, 0.2, 0.4, 0.6000000000000001, 0.8, 1.0]);
        assert_eq!(number(0.6000000000000001), "0.6");
        assert!(ticks(-7.3, 12.9).iter().all(|t| (-7.3..=12.9).contains(t)));
    }

    #[test]
    fn a_table_says_what_is_not_identifiable() {
        let rows = [
            Row { name: "ZZR1", unit: "kg m^2", value: Some((0.293, 0.056)), remark: "" },
            Row { name: "D8MY9", unit: "kg m^2", value: None, remark: "" },
        ];
        let svg = table("parameters", &rows);
        assert!(svg.contains("[0.23700, 0.34900]") && svg.contains("not identifiable"));
    }
}
