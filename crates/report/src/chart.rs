//! Small charts as SVG: lines, envelopes, bands and dots over two axes.
//!
//! Coordinates are whole tenths of a pixel, relative to the previous point. This takes a third of the bytes of decimal numbers.
//! Colours are CSS classes, so a page can define them for light and dark mode; [`Chart::alone`] includes the definitions.
//! Colour-blind readers can distinguish the colours (palette of Okabe and Ito), and lines also differ in their dashes.

use std::borrow::Cow;
use std::fmt::Write;

use identification::plot_data::envelope::{DRAWN_SPANS, Envelope};

use crate::frame::{AxesFrame, Width, broken};
use crate::scale::Scale;
pub use crate::text::escaped;

/// Height of the margin below the lower axis, for tick labels and axis names, tenths of a pixel.
const BOTTOM_MARGIN: f64 = 420.0;
/// Height of a row of the legend, tenths of a pixel.
const LEGEND_ROW_HEIGHT: f64 = 190.0;
/// Mean width of a letter in the legend, tenths of a pixel.
const LEGEND_LETTER_WIDTH: f64 = 68.0;
/// Attribute that lets a chart get the keyboard focus, because only an element with the focus receives keys.
const FOCUS: &str = " tabindex=\"0\"";

/// One layer of a chart. The layers are drawn from back to front.
#[derive(Clone, Debug)]
enum Layer<'a> {
    /// Lines through points; each inner vector is a separate line.
    Line(Vec<Vec<(f64, f64)>>),
    /// A signal over time: the smallest and the largest value in each time span.
    Envelope(Cow<'a, Envelope>),
    /// A horizontal band between two values, over the whole width of the chart.
    Band(f64, f64),
    /// Separate points without lines.
    Dots(&'a [(f64, f64)]),
    /// One highlighted point.
    Mark((f64, f64)),
}

/// A chart: its title, axes and layers.
#[derive(Clone, Debug)]
pub struct Chart<'a> {
    title: String,
    axes: (String, String),
    height: f64,
    is_logarithmic: bool,
    is_true_to_scale: bool,
    layers: Vec<(String, &'static str, Layer<'a>)>,
    width: Width,
    /// Ends of the horizontal axis; `None`: the ends of the data.
    span: Option<(f64, f64)>,
    /// For a chart that a script redraws: the key of the data of each layer. Empty for other charts.
    keys: Vec<String>,
    /// Horizontal positions of vertical lines, in units of the horizontal axis, for example between two logs.
    borders: Vec<f64>,
    has_zero: bool,
}

impl<'a> Chart<'a> {
    /// An empty chart with a width of 480 pixels. `axes`: names of the horizontal and the vertical axis, with units.
    pub fn new(title: impl Into<String>, axes: (&str, &str)) -> Chart<'a> {
        Chart {
            title: title.into(),
            axes: (axes.0.into(), axes.1.into()),
            height: 2000.0,
            is_logarithmic: false,
            is_true_to_scale: false,
            layers: Vec::new(),
            width: Width::Usual,
            span: None,
            keys: Vec::new(),
            borders: Vec::new(),
            has_zero: false,
        }
    }

    /// Makes both axes logarithmic.
    pub fn logarithmic(self) -> Chart<'a> {
        Chart { is_logarithmic: true, ..self }
    }

    /// Makes the chart higher, and gives both axes the same scale so that shapes are not distorted.
    pub fn true_to_scale(self) -> Chart<'a> {
        Chart { is_true_to_scale: true, height: 3000.0, ..self }
    }

    /// Makes the chart lower than usual.
    pub fn low(self) -> Chart<'a> {
        Chart { height: 1500.0, ..self }
    }

    /// Makes the chart small, for many charts in a row.
    pub fn small(self) -> Chart<'a> {
        Chart { height: 1100.0, ..self }
    }

    /// Extends the vertical axis so that it includes zero.
    pub fn with_zero(self) -> Chart<'a> {
        Chart { has_zero: true, ..self }
    }

    /// Adds a line through points. `class`: the CSS class a, b, c or d.
    pub fn line(self, name: impl Into<String>, class: &'static str, points: &[(f64, f64)]) -> Chart<'a> {
        self.pieces(name, class, vec![points.to_vec()])
    }

    /// Adds several lines with one common name in the legend.
    pub fn pieces(self, name: impl Into<String>, class: &'static str, pieces: Vec<Vec<(f64, f64)>>) -> Chart<'a> {
        self.layer(name, class, Layer::Line(pieces))
    }

    /// Adds a signal over time, drawn as a band between its smallest and largest values in each time span.
    pub fn envelope(self, name: impl Into<String>, class: &'static str, envelope: &'a Envelope) -> Chart<'a> {
        let drawn = match envelope.spans().len() > DRAWN_SPANS {
            true => Cow::Owned(envelope.thinned_to(DRAWN_SPANS)),
            false => Cow::Borrowed(envelope),
        };
        self.layer(name, class, Layer::Envelope(drawn))
    }

    /// Adds a horizontal band between two values, over the whole width.
    pub fn band(self, name: impl Into<String>, low: f64, high: f64) -> Chart<'a> {
        self.layer(name, "band", Layer::Band(low, high))
    }

    /// Adds separate points.
    pub fn dots(self, name: impl Into<String>, class: &'static str, points: &'a [(f64, f64)]) -> Chart<'a> {
        self.layer(name, class, Layer::Dots(points))
    }

    /// Adds one highlighted point.
    pub fn mark(self, name: impl Into<String>, class: &'static str, point: (f64, f64)) -> Chart<'a> {
        self.layer(name, class, Layer::Mark(point))
    }

    /// Sets the horizontal positions at which vertical lines are drawn.
    pub fn borders(self, borders: Vec<f64>) -> Chart<'a> {
        Chart { borders, ..self }
    }

    /// Makes the chart as wide as the page. `span`: start and end of the time axis, s.
    pub(crate) fn wide(self, span: (f64, f64)) -> Chart<'a> {
        Chart { width: Width::Wide, span: Some(span), ..self }
    }

    /// Lets the script of a page redraw the chart. `keys`: for each layer the key of its data, empty for a layer without
    /// data. The page then contains the legend.
    pub(crate) fn live(self, keys: Vec<String>) -> Chart<'a> {
        Chart { keys, ..self }
    }

    fn layer(mut self, name: impl Into<String>, class: &'static str, layer: Layer<'a>) -> Chart<'a> {
        self.layers.push((name.into(), class, layer));
        self
    }

    /// The chart as SVG for a page that defines the CSS classes.
    pub fn svg(&self) -> String {
        self.drawn("")
    }

    /// The chart as SVG for a separate file, which includes the CSS classes.
    pub fn alone(&self) -> String {
        self.drawn(concat!("<style>", include_str!("../templates/chart.css"), "</style>\n"))
    }

    fn drawn(&self, style: &str) -> String {
        let is_live = !self.keys.is_empty();
        let legend = if is_live { Legend::default() } else { self.legend() };
        let top = 160.0 + LEGEND_ROW_HEIGHT * (1.0 + legend.rows as f64);
        let (width, height) = (self.width.whole(), top + self.height);
        let frame = AxesFrame::new(self.scales(), self.width, top, top + self.height - BOTTOM_MARGIN);
        let (class, data) = match (is_live, self.width) {
            (true, Width::Usual) => (" live", FOCUS.to_string() + &frame.for_script()),
            (true, Width::Wide) => (" live wide-chart", FOCUS.to_string() + &frame.for_script()),
            (false, _) => ("", String::new()),
        };
        let mut s = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"chart{class}\" viewBox=\"0 0 {width} {height}\" role=\"img\"{data}>\n\
             <title>{}</title>\n{style}",
            escaped(&self.title)
        );
        s += &legend.text;
        frame.axes(&mut s, &self.axes);
        // Writing to a `String` cannot fail, so the results are ignored.
        for border in &self.borders {
            let at = frame.px(*border);
            let _ = writeln!(s, "<path class=\"border\" d=\"M{at} {}V{}\"/>", frame.top, frame.bottom);
        }
        for (k, (_, class, layer)) in self.layers.iter().enumerate() {
            let key = self.keys.get(k).filter(|key| !key.is_empty());
            let key = key.map_or(String::new(), |key| format!(" data-curve=\"{}\"", escaped(key)));
            let _ = match layer {
                Layer::Band(low, high) => {
                    let (a, b) = (frame.py(*high), frame.py(*low));
                    let (left, width, height) = (frame.left, frame.right - frame.left, (b - a).max(0));
                    let place = format!("x=\"{left}\" y=\"{a}\" width=\"{width}\" height=\"{height}\"");
                    writeln!(s, "<rect class=\"band\" {place}/>")
                }
                _ => {
                    let (kind, path) = drawn_layer(&frame, layer);
                    writeln!(s, "<path class=\"{kind} {class}\"{key} d=\"{path}\"/>")
                }
            };
        }
        if is_live {
            s.push_str("<path class=\"cursor\"/>\n<path class=\"chosen\"/>\n");
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
        if let Some((from, to)) = self.span {
            x = vec![from, to];
        }
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
        // Both axes get the same scale: one axis fills its side of the chart, and the range of the other axis is extended
        // equally at both ends.
        let (x, y) = (Scale::linear(x.into_iter(), 0.06), Scale::linear(y.into_iter(), 0.06));
        let place = AxesFrame::new((x, y), self.width, 0.0, self.height - BOTTOM_MARGIN);
        let (width, height) = (place.right - place.left, place.bottom);
        let unit = (x.length() / width).max(y.length() / height);
        (x.of_length(unit * width), y.of_length(unit * height))
    }

    /// The legend: the names of the layers with samples of their lines, in several rows if necessary.
    fn legend(&self) -> Legend {
        let mut legend = Legend::default();
        let named: Vec<_> = self.layers.iter().filter(|(name, _, _)| !name.is_empty()).collect();
        let mut x = self.width.left();
        for (i, (name, class, layer)) in named.iter().enumerate() {
            let width = 420.0 + LEGEND_LETTER_WIDTH * name.chars().count() as f64;
            if i == 0 {
                legend.rows = 1;
            } else if x + width > self.width.whole() {
                (x, legend.rows) = (self.width.left(), legend.rows + 1);
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

#[derive(Default)]
struct Legend {
    text: String,
    rows: usize,
}

/// The CSS class and the SVG path of a layer. A band has no path.
fn drawn_layer(frame: &AxesFrame, layer: &Layer) -> (&'static str, String) {
    match layer {
        Layer::Line(pieces) => ("line", frame.path(pieces)),
        Layer::Envelope(envelope) if envelope.is_thinned() => ("area", frame.area(envelope)),
        Layer::Envelope(envelope) => ("line", frame.path(&broken(envelope))),
        Layer::Dots(points) => ("dots", frame.path(&points.iter().map(|p| vec![*p]).collect::<Vec<_>>())),
        Layer::Mark(point) => ("mark", frame.path(&[vec![*point]])),
        Layer::Band(..) => ("band", String::new()),
    }
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

    #[test]
    fn charts_that_hear_keys_can_have_the_focus() {
        let points = [(0.0, 5.0), (1.0, -5.0)];
        let chart = || Chart::new("torque", ("s", "N m")).line("", "a", &points);
        assert!(chart().live(vec!["tau".into()]).svg().contains(" tabindex=\"0\""));
        assert!(!chart().svg().contains("tabindex"));
    }

    #[test]
    fn shapes_keep_their_proportions() {
        let circle: Vec<(f64, f64)> = (0..=100).map(|i| (0.0628 * f64::from(i)).sin_cos()).collect();
        let chart = Chart::new("", ("m", "m")).true_to_scale().line("", "a", &circle);
        let (x, y) = chart.scales();
        let frame = AxesFrame::new((x, y), chart.width, 0.0, chart.height - BOTTOM_MARGIN);
        let (across, up) = (frame.px(1.0) - frame.px(-1.0), frame.py(-1.0) - frame.py(1.0));
        assert!(across > 2000 && (across - up).abs() <= 2, "{across} {up}");
    }

    #[test]
    fn a_long_signal_is_small() {
        let mut signal = Envelope::default();
        (0..1_000_000).for_each(|i| signal.push(f64::from(i), f64::from(i).sin()));
        let svg = Chart::new("", ("", "")).envelope("x", "a", &signal).svg();
        assert!(svg.len() < 20_000, "{}", svg.len());
    }
}
