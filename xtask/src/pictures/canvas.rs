//! An SVG picture with lines, bars, dots and texts. The colours follow the light or dark scheme of the reader.
//!
//! Coordinates are in pixels, rounded to one decimal, so that rounding errors of a computation do not change the file.

use std::fmt::Write as _;

/// Colours, named by their use, as in the pages of `rist report`.
#[derive(Clone, Copy)]
pub(crate) enum Ink {
    /// Colour of texts and axes.
    Word,
    /// Colour of auxiliary lines and remarks.
    Faint,
    /// Colour of the first of two quantities.
    Blue,
    /// Colour of the second of two quantities.
    Orange,
    /// Colour of a good result.
    Green,
}

impl Ink {
    fn class(self) -> &'static str {
        match self {
            Ink::Word => "w",
            Ink::Faint => "f",
            Ink::Blue => "b",
            Ink::Orange => "o",
            Ink::Green => "g",
        }
    }
}

/// Which point of a text is at the given coordinates.
#[derive(Clone, Copy)]
pub(crate) enum Anchor {
    Start,
    Middle,
    End,
}

const STYLE: &str = "\
svg{--w:#222;--f:#b8bcc2;--b:#0072b2;--o:#d55e00;--g:#00805f;--p:#fff;font:14px system-ui,sans-serif}
@media(prefers-color-scheme:dark){svg{--w:#ddd;--f:#555b63;--b:#6cb8ee;--o:#f0a03c;--g:#3fcf9f;--p:#15181c}}
.paper{fill:var(--p)}.w{stroke:var(--w)}.f{stroke:var(--f)}.b{stroke:var(--b)}.o{stroke:var(--o)}.g{stroke:var(--g)}
path,line{fill:none;stroke-linejoin:round}
text{stroke:none!important;fill:var(--w)}text.f{fill:var(--f)}text.b{fill:var(--b)}text.o{fill:var(--o)}text.g{fill:var(--g)}
.fill.w{fill:var(--w)}.fill.f{fill:var(--f)}.fill.b{fill:var(--b)}.fill.o{fill:var(--o)}.fill.g{fill:var(--g)}
.fill{stroke:none}.head{font-weight:600}";

/// A picture to which elements are added.
pub(crate) struct Canvas {
    text: String,
}

impl Canvas {
    /// Makes an empty picture. `title`: description for screen readers.
    pub(crate) fn new(width: f64, height: f64, title: &str) -> Canvas {
        let text = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" role=\"img\">\n\
             <title>{}</title>\n<style>{STYLE}</style>\n<rect class=\"paper\" width=\"{width}\" height=\"{height}\"/>\n",
            escaped(title)
        );
        Canvas { text }
    }

    /// Adds a text at a point.
    pub(crate) fn words(&mut self, (x, y): (f64, f64), anchor: Anchor, ink: Ink, words: &str) {
        self.written((x, y), anchor, ink.class(), words);
    }

    /// Adds a heading at a point.
    pub(crate) fn heading(&mut self, (x, y): (f64, f64), words: &str) {
        self.written((x, y), Anchor::Start, "w head", words);
    }

    fn written(&mut self, (x, y): (f64, f64), anchor: Anchor, class: &str, words: &str) {
        let anchor = match anchor {
            Anchor::Start => "",
            Anchor::Middle => " text-anchor=\"middle\"",
            Anchor::End => " text-anchor=\"end\"",
        };
        self.push(format_args!("<text class=\"{class}\" x=\"{x:.1}\" y=\"{y:.1}\"{anchor}>{}</text>", escaped(words)));
    }

    /// Adds a line between two points.
    pub(crate) fn line(&mut self, a: (f64, f64), b: (f64, f64), ink: Ink, width: f64) {
        self.path(&[a, b], ink, width);
    }

    /// Adds a line through several points.
    pub(crate) fn path(&mut self, points: &[(f64, f64)], ink: Ink, width: f64) {
        let mut d = String::new();
        for (k, (x, y)) in points.iter().enumerate() {
            let _ = write!(d, "{}{:.1} {:.1}", if k == 0 { "M" } else { "L" }, x + 0.0, y + 0.0);
        }
        self.push(format_args!("<path class=\"{}\" stroke-width=\"{width}\" d=\"{d}\"/>", ink.class()));
    }

    /// Adds a dashed line between two points.
    pub(crate) fn dashed(&mut self, a: (f64, f64), b: (f64, f64), ink: Ink) {
        let class = ink.class();
        self.push(format_args!(
            "<path class=\"{class}\" stroke-width=\"1.5\" stroke-dasharray=\"5 4\" d=\"M{:.1} {:.1}L{:.1} {:.1}\"/>",
            a.0, a.1, b.0, b.1
        ));
    }

    /// Adds a filled rectangle, given by its upper left corner, width and height.
    pub(crate) fn bar(&mut self, (x, y): (f64, f64), width: f64, height: f64, ink: Ink) {
        let class = ink.class();
        self.push(format_args!(
            "<rect class=\"fill {class}\" x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{height:.1}\"/>"
        ));
    }

    /// Adds a dot.
    pub(crate) fn dot(&mut self, (x, y): (f64, f64), radius: f64, ink: Ink) {
        let class = ink.class();
        self.push(format_args!("<circle class=\"fill {class}\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius}\"/>"));
    }

    fn push(&mut self, element: std::fmt::Arguments) {
        let _ = writeln!(self.text, "{element}");
    }

    /// The text of the SVG file.
    pub(crate) fn finish(self) -> String {
        self.text + "</svg>\n"
    }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
