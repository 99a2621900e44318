//! The axes of a chart, and the conversion of values into SVG paths.
//!
//! Lengths are in tenths of a pixel. An envelope is a signal over time, given by the smallest and the largest value in each
//! time span.

use std::fmt::Write;

use identification::plot_data::envelope::Envelope;

use crate::scale::Scale;
use crate::text::escaped;

/// The two possible widths of a chart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Width {
    /// Width for several charts in a row.
    Usual,
    /// Width of the whole page.
    Wide,
}

impl Width {
    /// Width of the chart with its margins, tenths of a pixel.
    pub(crate) fn whole(self) -> f64 {
        if self == Width::Usual { 4800.0 } else { 7200.0 }
    }

    /// Left margin, which contains the tick labels, tenths of a pixel. It is larger for a wide chart, whose letters are larger on
    /// a narrow screen.
    pub(crate) fn left(self) -> f64 {
        if self == Width::Usual { 560.0 } else { 760.0 }
    }
}

/// Right margin of a chart, tenths of a pixel.
const RIGHT_MARGIN: f64 = 120.0;

/// The area between the axes of a chart: its scales, and its position, tenths of a pixel.
pub(crate) struct AxesFrame {
    pub(crate) x: Scale,
    pub(crate) y: Scale,
    pub(crate) left: f64,
    pub(crate) right: f64,
    pub(crate) top: f64,
    pub(crate) bottom: f64,
}

impl AxesFrame {
    /// The axes of a chart with the given width. `top`, `bottom`: ends of the vertical axis, tenths of a pixel from the top.
    pub(crate) fn new(scales: (Scale, Scale), width: Width, top: f64, bottom: f64) -> AxesFrame {
        let (x, y) = scales;
        AxesFrame { x, y, left: width.left(), right: width.whole() - RIGHT_MARGIN, top, bottom }
    }

    /// Horizontal position of the value `x`, tenths of a pixel from the left edge of the chart.
    pub(crate) fn px(&self, x: f64) -> i64 {
        (self.left + self.x.place(x) * (self.right - self.left)).round() as i64
    }

    /// Vertical position of the value `y`, tenths of a pixel from the top. Values far outside are clamped to one axis length
    /// beyond the axis, because browsers fail on huge coordinates.
    pub(crate) fn py(&self, y: f64) -> i64 {
        (self.bottom - self.y.place(y).clamp(-1.0, 2.0) * (self.bottom - self.top)).round() as i64
    }

    /// Attribute with data for the script that draws inside the axes: the lower left and the upper right corner of the area,
    /// tenths of a pixel, and the values at both ends of the vertical axis.
    pub(crate) fn for_script(&self) -> String {
        let AxesFrame { left, right, top, bottom, .. } = self;
        let (low, high) = self.y.ends();
        format!(" data-frame=\"[{left},{bottom},{right},{top},{low},{high}]\"")
    }

    /// Writes the grid, the tick labels and the names of the axes.
    pub(crate) fn axes(&self, s: &mut String, (x_name, y_name): &(String, String)) {
        let AxesFrame { left, right, .. } = self;
        let below = self.bottom + 180.0;
        // Writing to a `String` cannot fail, so the results are ignored.
        for (y, text) in self.y.ticks() {
            let at = self.py(y);
            let class = if text == "0" { "zero" } else { "grid" };
            let _ = writeln!(s, "<path class=\"{class}\" d=\"M{left} {at}H{right}\"/>");
            let _ = writeln!(s, "<text x=\"{}\" y=\"{}\" class=\"end\">{text}</text>", left - 60.0, at + 40);
        }
        s.push_str("<g class=\"ticks\">\n");
        for (x, text) in self.x.ticks() {
            let at = self.px(x);
            let _ = writeln!(s, "<path class=\"grid\" d=\"M{at} {}v40\"/>", self.bottom);
            let _ = writeln!(s, "<text x=\"{at}\" y=\"{below}\" class=\"middle\">{text}</text>");
        }
        s.push_str("</g>\n");
        let _ =
            writeln!(s, "<text x=\"{right}\" y=\"{}\" class=\"end name\">{}</text>", below + 170.0, escaped(x_name));
        let _ = writeln!(s, "<text x=\"60\" y=\"{}\" class=\"name\">{}</text>", self.top - 110.0, escaped(y_name));
    }

    /// The SVG path of several lines. A line with a single point is drawn as a dot.
    pub(crate) fn path(&self, pieces: &[Vec<(f64, f64)>]) -> String {
        let mut s = String::new();
        for piece in pieces {
            let mut last: Option<(i64, i64)> = None;
            for &(x, y) in piece.iter().filter(|(x, y)| x.is_finite() && y.is_finite()) {
                let at = (self.px(x), self.py(y));
                let _ = match last {
                    None => write!(s, "M{} {}", at.0, at.1),
                    Some(before) if before == at => continue,
                    Some(before) => relative(&mut s, at.0 - before.0, at.1 - before.1),
                };
                last = Some(at);
            }
            if piece.len() == 1 {
                s.push_str("h0");
            }
        }
        s
    }

    /// The SVG path of an envelope's area. Each segment is one outline: forward along the largest values, back along the
    /// smallest.
    pub(crate) fn area(&self, envelope: &Envelope) -> String {
        let mut s = String::new();
        for piece in envelope.pieces() {
            let Some(last) = piece.last() else { continue };
            let forth = piece.iter().map(|s| (s.t, s.high)).chain([(last.end, last.high), (last.end, last.low)]);
            s += &self.path(&[forth.chain(piece.iter().rev().map(|s| (s.t, s.low))).collect()]);
            s.push('z');
        }
        s
    }
}

fn relative(s: &mut String, dx: i64, dy: i64) -> std::fmt::Result {
    // Before a negative number no space is needed, because the minus sign separates the numbers.
    if dy < 0 { write!(s, "l{dx}{dy}") } else { write!(s, "l{dx} {dy}") }
}

/// Converts each segment of an envelope to a line. Each span of the envelope must contain one sample.
pub(crate) fn broken(envelope: &Envelope) -> Vec<Vec<(f64, f64)>> {
    envelope.pieces().iter().map(|piece| piece.iter().map(|span| (span.t, span.low)).collect()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_cut_at_the_frame() {
        let page = include_str!("../templates/identification.html");
        for (name, width) in [("usual", Width::Usual), ("wide", Width::Wide)] {
            let (left, right) = (width.left(), width.whole() - RIGHT_MARGIN);
            let frame = format!("<clipPath id=\"{name}-frame\"><rect x=\"{left}\" width=\"{}\"", right - left);
            assert!(page.contains(&frame), "{frame}");
        }
    }
}
