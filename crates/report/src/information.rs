//! A map of the correlations between parameters, and a table of leverages. A leverage is the share of one joint, or of one
//! joint and time interval, in the information on a parameter.
//!
//! Numbers are encoded as letters, to keep the page small; the script of the page decodes them.

use identification::plot_data::PlotData;
use identification::plot_data::information::{Information, PARTS_OF_TIME};
use serde::Serialize;
use std::fmt::Write;

use crate::number::significant;
use crate::timeline::letters;

/// The correlation map and the table of leverages for the page. `templates/map.js` makes them interactive.
#[derive(Serialize)]
pub(crate) struct MapPart {
    /// Names of the parameters, in the order of the map.
    names: Vec<String>,
    svg: String,
    json: String,
    /// The most correlated pairs of parameters: two names and the correlation.
    pairs: Vec<(String, String, String)>,
    /// Index of the parameter that is shown first. The next field `rows` has for each joint: its name, its leverage in this
    /// parameter, and the leverage levels of the time intervals, 0 to 1.
    picked: usize,
    rows: Vec<(String, String, Vec<String>)>,
    /// The step n: every n-th sample is evaluated.
    every: usize,
    /// Length of a time interval, as text.
    part: String,
}

/// The data of the map that the script reads.
#[derive(Serialize)]
struct Data<'a> {
    names: &'a [String],
    joints: Vec<&'a str>,
    parts: usize,
    /// Correlation rho of each pair i > j as the number 2047 (rho + 1), written in two letters.
    rho: String,
    /// Leverage of each time interval as the number 63 sqrt(leverage / largest leverage in the parameter), written as one letter.
    /// Order: parameter, joint, interval.
    shares: String,
    /// For each parameter, the leverage of each joint.
    sums: Vec<Vec<f64>>,
}

/// Lower ends of the levels of |rho| that the map distinguishes. Below the first level, a square is white.
const CORRELATION_LEVELS: [f64; 5] = [0.1, 0.3, 0.5, 0.7, 0.9];
/// Largest number that one letter can encode.
const LARGEST_LETTER: f64 = 63.0;
/// Number of steps between rho = 0 and rho = 1 in the two-letter code.
const RHO_STEPS: f64 = 2047.0;
/// Largest number of correlated pairs that are listed by name.
const PAIRS_IN_WORDS: usize = 6;
/// Smallest |rho| of a pair that is listed by name.
const NAMED_CORRELATION: f64 = 0.5;

/// The map of the correlations; `None` if fewer than two parameters are identifiable.
pub(crate) fn map(plot_data: &PlotData) -> Option<MapPart> {
    let found = &plot_data.information;
    let names: Vec<String> = found.parameters.iter().map(ToString::to_string).collect();
    if names.len() < 2 {
        return None;
    }
    let joints: Vec<&str> = plot_data.joints.iter().map(|j| j.coordinate.as_str()).collect();
    let of_joint = joints.len() * PARTS_OF_TIME;
    let by_parameter: Vec<&[f64]> = found.shares.chunks(of_joint.max(1)).collect();
    // Leverages are rounded to four decimals.
    let sum = |shares: &[f64]| (1e4 * shares.iter().sum::<f64>()).round() / 1e4;
    let sums: Vec<Vec<f64>> = by_parameter.iter().map(|of| of.chunks(PARTS_OF_TIME).map(sum).collect()).collect();
    let level = |share: &f64, largest: f64| if largest > 0.0 { (share / largest).sqrt() } else { 0.0 };
    let text = |of: &&[f64]| -> String {
        let largest = of.iter().copied().fold(0.0, f64::max);
        of.iter().map(|share| letters((LARGEST_LETTER * level(share, largest)).round() as u32, 1)).collect()
    };
    let rho = found.correlation.iter().map(|rho| letters((RHO_STEPS * (rho + 1.0)).round() as u32, 2)).collect();
    let shares = by_parameter.iter().map(text).collect();
    // The page first shows a parameter of the most correlated pair.
    let pairs = strongest(found);
    let picked = pairs.first().map_or(0, |pair| pair.1);
    let (first, of_first) = (by_parameter.get(picked)?, sums.get(picked)?);
    let largest = first.iter().copied().fold(0.0, f64::max);
    let row = |((name, sum), shares): ((&&str, &f64), &[f64])| {
        let cells = shares.iter().map(|share| format!("{:.2}", level(share, largest).powi(2))).collect();
        (name.to_string(), per_cent(*sum), cells)
    };
    let rows = joints.iter().zip(of_first).zip(first.chunks(PARTS_OF_TIME)).map(row).collect();
    let data = Data { names: &names, joints: joints.clone(), parts: PARTS_OF_TIME, rho, shares, sums: sums.clone() };
    // Serialising cannot fail, because the data has only texts and numbers. `<` is escaped, so that no text can end the script
    // element.
    let json = gate::shown::json(&serde_json::to_string(&data).unwrap_or_default()).replace('<', "\\u003c");
    let named = |(rho, i, j): &(f64, usize, usize)| (names[*i].clone(), names[*j].clone(), format!("{rho:.2}"));
    Some(MapPart {
        svg: svg(found),
        json,
        pairs: pairs.iter().filter(|p| p.0.abs() >= NAMED_CORRELATION).take(PAIRS_IN_WORDS).map(named).collect(),
        picked,
        rows,
        every: found.every,
        part: format!("{} s", significant(found.duration / PARTS_OF_TIME as f64, 2)),
        names,
    })
}

/// A share in per cent, formatted as the script formats it.
fn per_cent(share: f64) -> String {
    let digits = usize::from(share < 0.1);
    format!("{:.digits$} %", 100.0 * share)
}

/// All pairs of parameters as (rho, i, j), sorted by |rho|, the largest first.
fn strongest(found: &Information) -> Vec<(f64, usize, usize)> {
    let below = (0..found.parameters.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
    let mut pairs: Vec<_> = found.correlation.iter().zip(below).map(|(rho, (i, j))| (*rho, i, j)).collect();
    pairs.sort_by(|a, b| b.0.abs().total_cmp(&a.0.abs()));
    pairs
}

/// The map as SVG: one row per parameter, one square per pair. All squares with the same level and sign form one path.
fn svg(found: &Information) -> String {
    let p = found.parameters.len();
    let mut paths = vec![[String::new(), String::new()]; CORRELATION_LEVELS.len()];
    for (rho, i, j) in strongest(found) {
        let Some(level) = CORRELATION_LEVELS.iter().rposition(|least| rho.abs() >= *least) else { break };
        let path = &mut paths[level][usize::from(rho < 0.0)];
        // Writing to a `String` cannot fail, so the result is ignored.
        let _ = write!(path, "M{j} {i}.5h1M{i} {j}.5h1");
    }
    let mut s = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {p} {p}\" role=\"img\">\n<title>Correlations of {p} \
         parameters</title>\n<path class=\"same\" d=\"M0 0L{p} {p}\"/>\n"
    );
    for (level, [positive, negative]) in paths.iter().enumerate() {
        for (sign, path) in [("a", positive), ("b", negative)].into_iter().filter(|(_, path)| !path.is_empty()) {
            let _ = writeln!(s, "<path class=\"{sign} l{level}\" d=\"{path}\"/>");
        }
    }
    s.push_str("<path class=\"picked\" d=\"\"/>\n</svg>\n");
    s
}
