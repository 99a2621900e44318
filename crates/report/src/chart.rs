//! Small charts as SVG: lines, envelopes, bands and dots over two axes.
//!
//! Coordinates are whole tenths of a pixel and relative to the point before, which takes a third of the space of
//! decimals. Colours are classes, so that a page defines them for light and dark; [`Chart::alone`] includes
//! definitions. The colours are those of Okabe and Ito, which everybody can tell apart, and lines differ in dashes.

use std::fmt::Write;

use identification::portrait::envelope::Envelope;

use crate::scale::Scale;

/// Width of a chart, tenths of a pixel.
const CHART_WIDTH: f64 = 4800.0;
/// What the axes take of a chart on the left, tenths of a pixel.
const LEFT_MARGIN: f64 = 560.0;
/// What is left free on the right.
const RIGHT_MARGIN: f64 = 120.0;
/// What the axes take of it below.
const BOTTOM_MARGIN: f64 = 420.0;
/// Height of a row of the legend, tenths of a pixel.
const LEGEND_ROW_HEIGHT: f64 = 190.0;
/// Width of a letter in the legend, tenths of a pixel.
const LEGEND_LETTER_WIDTH: f64 = 68.0;

/// A layer of the drawing. Layers are drawn from back to front.
#[derive(Clone, Debug)]
enum Layer<'a> {
    /// Points joined by lines; a new piece at each inner vector.
    Line(Vec<Vec<(f64, f64)>>),
    /// Signals over time.
    Envelope(&'a Envelope),
    /// Between two ordinates, over the whole width.
    Band(f64, f64),
    /// Points.
    Dots(&'a [(f64, f64)]),
    /// A point to be noticed.
    Mark((f64, f64)),
}

/// A chart that is being put together.
#[derive(Clone, Debug)]
pub struct Chart<'a> {
    title: String,
    axes: (String, String),
    height: f64,
    is_logarithmic: bool,
    is_true_to_scale: bool,
    layers: Vec<(String, &'static str, Layer<'a>)>,
    /// Abscissas of vertical lines.
    borders: Vec<f64>,
    has_zero: bool,
}

impl<'a> Chart<'a> {
    /// An empty chart 480 wide; `axes`: names with units.
    pub fn new(title: impl Into<String>, axes: (&str, &str)) -> Chart<'a> {
        Chart {
            title: title.into(),
            axes: (axes.0.into(), axes.1.into()),
            height: 2000.0,
            is_logarithmic: false,
            is_true_to_scale: false,
            layers: Vec::new(),
            borders: Vec::new(),
            has_zero: false,
        }
    }

    /// Both axes logarithmic.
    pub fn logarithmic(self) -> Chart<'a> {
        Chart { is_logarithmic: true, ..self }
    }

    /// A high chart with the same length per unit on both axes, for shapes.
    pub(crate) fn true_to_scale(self) -> Chart<'a> {
        Chart { is_true_to_scale: true, height: 3000.0, ..self }
    }

    /// Lower than others.
    pub fn low(self) -> Chart<'a> {
        Chart { height: 1500.0, ..self }
    }

    /// Small, for many charts beside each other.
    pub fn small(self) -> Chart<'a> {
        Chart { height: 1100.0, ..self }
    }

    /// With the ordinate zero inside.
    pub(crate) fn with_zero(self) -> Chart<'a> {
        Chart { has_zero: true, ..self }
    }

    /// A line through points; `class`: a, b, c or d.
    pub fn line(self, name: impl Into<String>, class: &'static str, points: &[(f64, f64)]) -> Chart<'a> {
        self.pieces(name, class, vec![points.to_vec()])
    }

    /// Lines that belong together.
    pub fn pieces(self, name: impl Into<String>, class: &'static str, pieces: Vec<Vec<(f64, f64)>>) -> Chart<'a> {
        self.layer(name, class, Layer::Line(pieces))
    }

    /// A signal over time.
    pub fn envelope(self, name: impl Into<String>, class: &'static str, envelope: &'a Envelope) -> Chart<'a> {
        self.layer(name, class, Layer::Envelope(envelope))
    }

    /// A band between two ordinates.
    pub fn band(self, name: impl Into<String>, low: f64, high: f64) -> Chart<'a> {
        self.layer(name, "band", Layer::Band(low, high))
    }

    /// Points by themselves.
    pub fn dots(self, name: impl Into<String>, class: &'static str, points: &'a [(f64, f64)]) -> Chart<'a> {
        self.layer(name, class, Layer::Dots(points))
    }

    /// A point to be noticed.
    pub fn mark(self, name: impl Into<String>, class: &'static str, point: (f64, f64)) -> Chart<'a> {
        self.layer(name, class, Layer::Mark(point))
    }

    /// Vertical lines.
    pub fn borders(self, borders: Vec<f64>) -> Chart<'a> {
        Chart { borders, ..self }
    }

    fn layer(mut self, name: impl Into<String>, class: &'static str, layer: Layer<'a>) -> Chart<'a> {
        self.layers.push((name.into(), class, layer));
        self
    }

    /// The SVG for a page that defines the classes.
    pub fn svg(&self) -> String {
        self.drawn("")
    }

    /// The SVG for a file of its own.
    pub fn alone(&self) -> String {
        self.drawn(concat!("<style>", include_str!("../templates/chart.css"), "</style>\n"))
    }

    fn drawn(&self, style: &str) -> String {
        let legend = self.legend();
        let top = 160.0 + LEGEND_ROW_HEIGHT * (1.0 + legend.rows as f64);
        let height = top + self.height;
        let (x, y) = self.scales();
        let frame = Frame { x, y, top, bottom: top + self.height - BOTTOM_MARGIN };
        let mut s = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"chart\" viewBox=\"0 0 {CHART_WIDTH} {height}\" role=\"img\">\n\
             <title>{}</title>\n{style}",
            escaped(&self.title)
        );
        s += &legend.text;
        frame.axes(&mut s, &self.axes);
        // Writing to a String cannot fail.
        for border in &self.borders {
            let at = frame.px(*border);
            let _ = writeln!(s, "<path class=\"border\" d=\"M{at} {}V{}\"/>", frame.top, frame.bottom);
        }
        for (_, class, layer) in &self.layers {
            match layer {
                Layer::Line(pieces) => {
                    let _ = writeln!(s, "<path class=\"line {class}\" d=\"{}\"/>", frame.path(pieces));
                }
                Layer::Envelope(envelope) if envelope.is_thinned() => {
                    let _ = writeln!(s, "<path class=\"area {class}\" d=\"{}\"/>", frame.area(envelope));
                }
                Layer::Envelope(envelope) => {
                    let _ = writeln!(s, "<path class=\"line {class}\" d=\"{}\"/>", frame.path(&broken(envelope)));
                }
                Layer::Band(low, high) => {
                    let (a, b) = (frame.py(*high), frame.py(*low));
                    let width = CHART_WIDTH - LEFT_MARGIN - RIGHT_MARGIN;
                    let _ = writeln!(
                        s,
                        "<rect class=\"band\" x=\"{LEFT_MARGIN}\" y=\"{a}\" width=\"{width}\" height=\"{}\"/>",
                        (b - a).max(0)
                    );
                }
                Layer::Dots(points) => {
                    let dots: Vec<Vec<(f64, f64)>> = points.iter().map(|p| vec![*p]).collect();
                    let _ = writeln!(s, "<path class=\"dots {class}\" d=\"{}\"/>", frame.path(&dots));
                }
                Layer::Mark(point) => {
                    let _ = writeln!(s, "<path class=\"mark {class}\" d=\"{}\"/>", frame.path(&[vec![*point]]));
                }
            }
        }
        s.push_str("</svg>\n");
        s
    }

    fn scales(&self) -> (Scale, Scale) {
        let (mut x, mut y): (Vec<f64>, Vec<f64>) = (Vec::new(), Vec::new());
        let mut points: Vec<(f64, f64)> = Vec::new();
        for (_, _, layer) in &self.layers {
            match layer {
                Layer::Line(pieces) => points.extend(pieces.iter().flatten()),
                Layer::Envelope(envelope) => envelope.spans().iter().for_each(|span| {
                    x.push(span.t);
                    y.extend([span.low, span.high]);
                }),
                Layer::Band(low, high) => y.extend([*low, *high]),
                Layer::Dots(dots) => points.extend(dots.iter()),
                Layer::Mark(point) => points.push(*point),
            }
        }
        x.extend(points.iter().map(|p| p.0));
        y.extend(points.iter().map(|p| p.1));
        if self.is_logarithmic {
            return (Scale::logarithmic(x.into_iter(), false), Scale::logarithmic(y.into_iter(), true));
        }
        if self.has_zero {
            y.push(0.0);
        }
        if !self.is_true_to_scale {
            return (Scale::linear(x.into_iter(), 0.0), Scale::linear(y.into_iter(), 0.06));
        }
        // One unit for both axes: the wider one fills its side, the other is widened about its middle.
        let (x, y) = (Scale::linear(x.into_iter(), 0.06), Scale::linear(y.into_iter(), 0.06));
        let (width, height) = (CHART_WIDTH - LEFT_MARGIN - RIGHT_MARGIN, self.height - BOTTOM_MARGIN);
        let unit = (x.length() / width).max(y.length() / height);
        (x.of_length(unit * width), y.of_length(unit * height))
    }

    /// Names with their lines, in as many rows as they need.
    fn legend(&self) -> Legend {
        let mut legend = Legend { text: String::new(), rows: 0 };
        let named: Vec<_> = self.layers.iter().filter(|(name, _, _)| !name.is_empty()).collect();
        let mut x = LEFT_MARGIN;
        for (i, (name, class, layer)) in named.iter().enumerate() {
            let width = 420.0 + LEGEND_LETTER_WIDTH * name.chars().count() as f64;
            if i == 0 {
                legend.rows = 1;
            } else if x + width > CHART_WIDTH {
                (x, legend.rows) = (LEFT_MARGIN, legend.rows + 1);
            }
            let y = 20.0 + LEGEND_ROW_HEIGHT * legend.rows as f64;
            let mark = match layer {
                Layer::Band(..) => {
                    format!("<rect class=\"band\" x=\"{x}\" y=\"{}\" width=\"220\" height=\"100\"/>", y - 95.0)
                }
                Layer::Dots(_) => {
                    format!("<path class=\"dots {class}\" d=\"M{} {}h0m60 0h0m60 0h0\"/>", x + 50.0, y - 45.0)
                }
                Layer::Mark(_) => format!("<path class=\"mark {class}\" d=\"M{} {}h0\"/>", x + 110.0, y - 45.0),
                _ => format!("<path class=\"line {class}\" d=\"M{x} {}h220\"/>", y - 45.0),
            };
            let _ = writeln!(legend.text, "{mark}<text x=\"{}\" y=\"{y}\">{}</text>", x + 270.0, escaped(name));
            x += width;
        }
        legend
    }
}

struct Legend {
    text: String,
    rows: usize,
}

/// Where the axes stand.
struct Frame {
    x: Scale,
    y: Scale,
    top: f64,
    bottom: f64,
}

impl Frame {
    fn px(&self, x: f64) -> i64 {
        (LEFT_MARGIN + self.x.place(x) * (CHART_WIDTH - LEFT_MARGIN - RIGHT_MARGIN)).round() as i64
    }

    /// Values far outside are clamped to one height of the frame beyond it, because browsers fail on huge coordinates.
    fn py(&self, y: f64) -> i64 {
        (self.bottom - self.y.place(y).clamp(-1.0, 2.0) * (self.bottom - self.top)).round() as i64
    }

    fn axes(&self, s: &mut String, (x_name, y_name): &(String, String)) {
        let right = CHART_WIDTH - RIGHT_MARGIN;
        let below = self.bottom + 180.0;
        // Writing to a String cannot fail.
        for (y, text) in self.y.ticks() {
            let at = self.py(y);
            let class = if text == "0" { "zero" } else { "grid" };
            let _ = writeln!(s, "<path class=\"{class}\" d=\"M{LEFT_MARGIN} {at}H{right}\"/>");
            let _ = writeln!(s, "<text x=\"{}\" y=\"{}\" class=\"end\">{text}</text>", LEFT_MARGIN - 60.0, at + 40);
        }
        for (x, text) in self.x.ticks() {
            let at = self.px(x);
            let _ = writeln!(s, "<path class=\"grid\" d=\"M{at} {}v40\"/>", self.bottom);
            let _ = writeln!(s, "<text x=\"{at}\" y=\"{below}\" class=\"middle\">{text}</text>");
        }
        let _ =
            writeln!(s, "<text x=\"{right}\" y=\"{}\" class=\"end name\">{}</text>", below + 170.0, escaped(x_name));
        let _ = writeln!(s, "<text x=\"60\" y=\"{}\" class=\"name\">{}</text>", self.top - 110.0, escaped(y_name));
    }

    /// Pieces of lines; a piece of one point is a dot.
    fn path(&self, pieces: &[Vec<(f64, f64)>]) -> String {
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

    /// Outlines of the pieces: forward along the largest values, back along the smallest.
    fn area(&self, envelope: &Envelope) -> String {
        let spans = envelope.spans();
        let mut s = String::new();
        let mut from = 0;
        while from < spans.len() {
            let to = (from + 1..spans.len()).find(|&i| spans[i].is_first).unwrap_or(spans.len());
            let (piece, last) = (&spans[from..to], spans[to - 1]);
            let forth = piece.iter().map(|s| (s.t, s.high)).chain([(last.end, last.high), (last.end, last.low)]);
            s += &self.path(&[forth.chain(piece.iter().rev().map(|s| (s.t, s.low))).collect()]);
            s.push('z');
            from = to;
        }
        s
    }
}

fn relative(s: &mut String, dx: i64, dy: i64) -> std::fmt::Result {
    // A minus divides as well as a blank.
    if dy < 0 { write!(s, "l{dx}{dy}") } else { write!(s, "l{dx} {dy}") }
}

/// The pieces of a line of single samples.
fn broken(envelope: &Envelope) -> Vec<Vec<(f64, f64)>> {
    let mut pieces: Vec<Vec<(f64, f64)>> = Vec::new();
    for span in envelope.spans() {
        match pieces.last_mut() {
            Some(piece) if !span.is_first => piece.push((span.t, span.low)),
            _ => pieces.push(vec![(span.t, span.low)]),
        }
    }
    pieces
}

/// The text, escaped for text and attributes of XML and HTML.
pub fn escaped(text: &str) -> String {
    gate::shown::line(text).replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn charts_hold_their_layers() {
        let points = [(0.0, 5.0), (1.0, -5.0), (2.0, f64::NAN)];
        let svg = Chart::new("torque & time", ("s", "N m"))
            .band("band", -1.0, 1.0)
            .line("a < b", "a", &points)
            .dots("dots", "b", &points)
            .svg();
        assert!(svg.starts_with("<svg ") && svg.ends_with("</svg>\n"));
        assert!(svg.contains("a &lt; b") && svg.contains("torque &amp; time") && !svg.contains("NaN"), "{svg}");
        assert!(svg.matches("<path class=\"line").count() == 2 && svg.contains("rect class=\"band\""));
        assert!(Chart::new("", ("", "")).alone().contains("<style>"));
        assert!(!Chart::new("", ("", "")).logarithmic().line("", "a", &[(0.0, 0.0)]).svg().contains("NaN"));
    }

    /// A circle is drawn as one, however the rest of the chart is shaped.
    #[test]
    fn shapes_keep_their_proportions() {
        let circle: Vec<(f64, f64)> = (0..=100).map(|i| (0.0628 * f64::from(i)).sin_cos()).collect();
        let chart = Chart::new("", ("m", "m")).true_to_scale().line("", "a", &circle);
        let (x, y) = chart.scales();
        let frame = Frame { x, y, top: 0.0, bottom: chart.height - BOTTOM_MARGIN };
        let (across, up) = (frame.px(1.0) - frame.px(-1.0), frame.py(-1.0) - frame.py(1.0));
        assert!(across > 2000 && (across - up).abs() <= 2, "{across} {up}");
    }

    /// A chart of a million samples is no larger than a picture.
    #[test]
    fn a_long_signal_is_small() {
        let mut signal = Envelope::default();
        (0..1_000_000).for_each(|i| signal.push(f64::from(i), f64::from(i).sin()));
        let svg = Chart::new("", ("", "")).envelope("x", "a", &signal).svg();
        assert!(svg.len() < 20_000, "{}", svg.len());
    }
}
