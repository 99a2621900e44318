//! Encodes lines over one time axis for the script of a page. The script draws a range of them and shows their values.
//!
//! ```text
//! v = low + step c,  c = 0 .. 4094;  c = 4095: no value        two letters per value
//! t = from + (to - from) c / (64^4 - 1)                        four letters per time
//! ```
//! A letter is one of `>` to `~` without the backslash, so it needs no escape in JSON or in a page. The rounding error of a
//! value is at most half a step: 1 / 8188 of the range of the line. The script `templates/plot.js` decodes the letters.
//!
//! A span is a short time interval; each line has its smallest and its largest value in every span.

use std::collections::BTreeMap;

use identification::plot_data::envelope::{Envelope, Span};
use serde::Serialize;

/// Number of steps between the smallest and the largest value of a line. The next code, 4095, means "no value".
const STEPS: f64 = 4094.0;
/// Number of letters that encode a time.
const LETTERS_OF_A_TIME: usize = 4;

/// Several lines over the same spans of time.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub(crate) struct Timeline {
    from: f64,
    to: f64,
    /// Encoded start time of each span.
    times: String,
    /// Segments of the time axis without a gap: index of the first span, and end time of the segment, s.
    pieces: Vec<(usize, f64)>,
    curves: BTreeMap<String, Curve>,
}

/// One encoded line.
#[derive(Clone, Debug, PartialEq, Serialize)]
struct Curve {
    low: f64,
    step: f64,
    /// Encoded smallest value of each span.
    lows: String,
    /// Encoded largest value of each span; `None` if each span is one sample.
    #[serde(skip_serializing_if = "Option::is_none")]
    highs: Option<String>,
}

impl Timeline {
    /// Encodes lines, each given by its key and its data. Lines with other time spans than the first line are omitted. `None`
    /// without a span.
    pub(crate) fn new<'a>(lines: impl IntoIterator<Item = (String, &'a Envelope)>) -> Option<Timeline> {
        let mut lines = lines.into_iter().peekable();
        let spans = lines.peek()?.1.spans();
        let (from, to) = (spans.first()?.t, spans.last()?.end);
        let fits = |other: &Envelope| {
            let pairs = || spans.iter().zip(other.spans());
            spans.len() == other.spans().len() && pairs().all(|(a, b)| (a.t, a.end) == (b.t, b.end))
        };
        let largest = 64f64.powi(LETTERS_OF_A_TIME as i32) - 1.0;
        let code = |t: f64| if to > from { ((t - from) / (to - from) * largest).round() as u32 } else { 0 };
        let mut pieces: Vec<(usize, f64)> = Vec::new();
        for (i, span) in spans.iter().enumerate() {
            if span.is_first || pieces.is_empty() {
                pieces.push((i, span.end));
            }
            if let Some(piece) = pieces.last_mut() {
                piece.1 = span.end;
            }
        }
        Some(Timeline {
            from,
            to,
            times: spans.iter().map(|span| letters(code(span.t), LETTERS_OF_A_TIME)).collect(),
            pieces,
            curves: lines.filter(|(_, line)| fits(line)).map(|(key, line)| (key, curve(line))).collect(),
        })
    }

    /// The lines as JSON. It contains no `<`, so it can be inserted into a page.
    pub(crate) fn to_json(&self) -> String {
        // Serialising cannot fail, because the data has only numbers and texts, with texts as keys.
        serde_json::to_string(self).unwrap_or_default().replace('<', "\\u003c")
    }
}

fn curve(line: &Envelope) -> Curve {
    let finite = || line.spans().iter().filter(|span| span.low.is_finite() && span.high.is_finite());
    let low = finite().map(|span| span.low).fold(f64::INFINITY, f64::min);
    let high = finite().map(|span| span.high).fold(f64::NEG_INFINITY, f64::max);
    let (low, high) = if low <= high { (low, high) } else { (0.0, 0.0) };
    let step = (high - low) / STEPS;
    let code = |value: f64| match value.is_finite() {
        true if step > 0.0 => ((value - low) / step).round().clamp(0.0, STEPS) as u32,
        true => 0,
        false => STEPS as u32 + 1,
    };
    let text = |of: fn(&Span) -> f64| line.spans().iter().map(|span| letters(code(of(span)), 2)).collect();
    let highs = line.is_thinned().then(|| text(|span| span.high));
    Curve { low, step, lows: text(|span| span.low), highs }
}

/// Encodes a number in `count` letters of 6 bits each, the highest digit first.
pub(crate) fn letters(number: u32, count: usize) -> String {
    let digit = |k: usize| (number >> (6 * (count - 1 - k))) as u8 & 63;
    // The alphabet skips the backslash.
    (0..count).map(digit).map(|d| char::from(62 + d + u8::from(d >= 30))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn number(text: &str) -> u32 {
        text.bytes().map(|b| u32::from(b - 62 - u8::from(b > 92))).fold(0, |sum, digit| 64 * sum + digit)
    }

    #[test]
    fn letters_are_numbers_and_no_markup() {
        for i in 0..4096 {
            let text = letters(i, 2);
            assert!(number(&text) == i && !text.contains(['<', '&', '"', '\\']), "{i} {text}");
        }
        assert_eq!(number(&letters(16_777_215, 4)), 16_777_215);
    }

    #[test]
    fn lines_are_read_again() {
        let (mut line, mut other) = (Envelope::default(), Envelope::default());
        for i in 0..600 {
            if i == 300 {
                line.interrupt();
            }
            let t = f64::from(i) * 0.01;
            line.push(t, if (100..110).contains(&i) { f64::NAN } else { 30.0 * t.sin() });
            other.push(f64::from(i), 0.0);
        }
        let timeline = Timeline::new([("a".to_string(), &line), ("b".to_string(), &other)]).unwrap();
        assert_eq!((timeline.curves.len(), timeline.from, timeline.to), (1, 0.0, 5.99));
        assert_eq!(timeline.pieces, [(0, 2.99), (300, 5.99)]);
        let curve = &timeline.curves["a"];
        let pair = |i: usize| number(&curve.lows[2 * i..2 * i + 2]);
        for (i, span) in line.spans().iter().enumerate() {
            let found = curve.low + curve.step * f64::from(pair(i));
            match span.low.is_nan() {
                true => assert_eq!(pair(i), 4095),
                false => assert!((found - span.low).abs() <= 0.5001 * curve.step, "{found} {span:?}"),
            }
        }
        assert!(Timeline::new([]).is_none() && curve.highs.is_none());
    }
}
