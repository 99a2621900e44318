//! The page section on an exciting motion: coordinates within their limits, path of the end effector, and the parameters that
//! the motion makes identifiable.
//!
//! The certificate is the list of proven bounds, one row per limit. The script of the page redraws the charts; it finds the
//! data of a line by its key.

use experiments::excitation::artefact::{ExcitingMotion, certificate_summary};
use experiments::excitation::limits::LimitKind;
use experiments::excitation::proof::{CertificateRow, LimitProof};
use experiments::excitation::space_limits::{Floor, SpaceLimits};
use experiments::excitation::visibility::VisibleParameter;
use identification::plot_data::envelope::Envelope;
use identification::plot_data::motion_plot_data::{EndEffectorPath, JointCourse, MotionPlotData};
use serde::Serialize;

use crate::chart::Chart;
use crate::joints::ChartFigure;
use crate::number::{percent, significant, unit};
use crate::plot::Plot;
use crate::timeline::Timeline;

/// An exciting motion with the data of its plots.
#[derive(Clone, Copy)]
pub struct ShownMotion<'a> {
    /// The motion as it is stored in its file.
    pub artefact: &'a ExcitingMotion,
    /// The trajectories of the motion and its certificate.
    pub plot_data: &'a MotionPlotData,
}

/// The section on the motion: sentences, table rows and charts.
#[derive(Serialize)]
pub struct MotionPart {
    summary: String,
    proof: String,
    is_proven: bool,
    limits: Vec<LimitRow>,
    notes: Vec<String>,
    joints: Vec<JointCharts>,
    tip: Option<String>,
    path: Vec<ChartFigure>,
    scale: String,
    parameters: Vec<Visible>,
}

/// A table row for one kind of limit, over all coordinates.
#[derive(Serialize)]
struct LimitRow {
    limit: String,
    proven: String,
    nearest: String,
    faults: Vec<String>,
}

#[derive(Serialize)]
struct JointCharts {
    name: String,
    locked: String,
    plots: Vec<String>,
}

/// A table row for one parameter that the motion makes identifiable.
#[derive(Serialize)]
struct Visible {
    name: String,
    described: String,
    deviation: String,
    relative: String,
    /// Length of the bar for the standard deviation, 0 to 100; `None` without a bar.
    bar: Option<f64>,
    remark: String,
    is_doubtful: bool,
}

/// Makes the section on an exciting motion.
pub fn motion(shown: ShownMotion) -> MotionPart {
    let ShownMotion { artefact, plot_data } = shown;
    let rows = &plot_data.certificate;
    let claims = plot_data.claims();
    let proof = match plot_data.is_found_anew {
        true => format!("{claims}. The certificate is found from the motion and the model."),
        false => format!(
            "The file says: {claims}. Nobody proved it for this page; [:check] does, from the motion and the model."
        ),
    };
    // The text on the safety margins of the proof is split into lines, and each line becomes a note.
    let margins = plot_data.margins.as_ref().map(|margins| margins.text()).unwrap_or_default();
    let margins: Vec<String> = margins.lines().map(str::to_string).collect();
    let in_words = |row: &CertificateRow| {
        let joint = plot_data.joints.iter().find(|joint| joint.coordinate == row.subject);
        row.in_words(joint.and_then(|joint| joint.is_prismatic))
    };
    let limits = certificate_summary(rows).into_iter().map(|summary| LimitRow {
        limit: summary.limit.to_string(),
        proven: format!("{} of {}", summary.proven, summary.count),
        nearest: summary.nearest.map_or("-".into(), in_words),
        faults: summary.faults.iter().map(|row| in_words(row)).collect(),
    });
    let charts = |(k, joint): (usize, &JointCourse)| JointCharts {
        name: joint.coordinate.clone(),
        locked: joint.limits.locked.map_or(String::new(), |q| format!("locked at {}", significant(q, 4))),
        plots: drawn(joint, plot_data).iter().map(|course| course.plot(k)).collect(),
    };
    let (scale, parameters) = visible(&artefact.parameters);
    MotionPart {
        summary: artefact.in_words(),
        proof,
        is_proven: claims.is_kept(),
        limits: limits.collect(),
        notes: [&plot_data.notes[..], &claims.left_out_sentences(), &margins].concat(),
        joints: plot_data.joints.iter().enumerate().map(charts).collect(),
        tip: plot_data.tip.as_ref().map(|tip| tip.name.clone()),
        path: of_tip(shown).map(|(_, plane, chart)| figure(plane, chart)).collect(),
        scale,
        parameters,
    }
}

fn figure(caption: String, chart: Chart) -> ChartFigure {
    ChartFigure { caption, svg: chart.svg() }
}

/// The charts of the motion as SVG for a folder of pictures: file name and SVG of each.
pub fn pictures(shown: ShownMotion) -> Vec<(String, String)> {
    let of_joint = |joint: &JointCourse| {
        let file = |c: QuantityOverTime| (format!("motion_{}_{}", c.kind, joint.coordinate), c.chart().alone());
        drawn(joint, shown.plot_data).into_iter().map(file).collect::<Vec<_>>()
    };
    let of_joints = shown.plot_data.joints.iter().flat_map(of_joint);
    let of_tip = of_tip(shown).map(|(name, _, chart)| (format!("motion_{name}"), chart.alone()));
    of_joints.chain(of_tip).collect()
}

/// The charts of the path of the end effector, if this path is known: file name, caption and chart of each.
fn of_tip<'a>(shown: ShownMotion<'a>) -> impl Iterator<Item = (&'static str, String, Chart<'a>)> {
    shown.plot_data.tip.iter().flat_map(move |tip| paths(tip, &shown.artefact.space))
}

/// One quantity of a coordinate (position, velocity, ..) over the time of the motion, with its limits.
struct QuantityOverTime<'a> {
    kind: LimitKind,
    title: String,
    axis: String,
    caption: String,
    course: &'a Envelope,
    /// Start and end of the motion, s.
    span: (f64, f64),
    bounds: Option<(f64, f64)>,
    nearest: Option<(f64, f64)>,
    borders: Vec<f64>,
}

/// Name of the time axis of the exciting motion, as used by the script of the page.
pub(crate) const MOTION_TIME: &str = "motion";

/// The trajectories of the motion, encoded for the script of the page; `None` if there are no trajectories.
pub(crate) fn timeline(shown: ShownMotion) -> Option<Timeline> {
    let joints = shown.plot_data.joints.iter().enumerate();
    Timeline::new(joints.flat_map(|(k, joint)| joint.positions.iter().map(move |(kind, line)| (key(*kind, k), line))))
}

/// The key under which the script finds a trajectory of coordinate k. The page moves the robot by the trajectories with the
/// letter q.
fn key(kind: LimitKind, k: usize) -> String {
    let letter = match kind {
        LimitKind::Position => "q",
        LimitKind::Velocity => "v",
        LimitKind::Acceleration => "a",
        LimitKind::Jerk => "j",
        LimitKind::Effort => "e",
        _ => "w",
    };
    format!("{letter}{k}")
}

impl QuantityOverTime<'_> {
    /// The chart of coordinate k with its legend, as HTML for the script of a page.
    fn plot(&self, k: usize) -> String {
        let (key, none) = (key(self.kind, k), String::new);
        let limits = self.bounds.map(|_| (none(), "b", "limits".to_string()));
        let nearest = self.nearest.map(|_| (none(), "d", "nearest to a limit".to_string()));
        // One key per layer of the chart, in drawing order; an empty key for layers without a trajectory.
        let keys = limits.iter().map(|_| none()).chain([key.clone()]).chain(nearest.iter().map(|_| none())).collect();
        let legend = [(key, "a", "motion".to_string())].into_iter().chain(limits).chain(nearest).collect();
        let svgs = vec![self.chart().live(keys).svg()];
        Plot { time: MOTION_TIME, caption: self.caption.clone(), legend, svgs }.html()
    }

    fn chart(&self) -> Chart<'_> {
        let (from, to) = self.span;
        let chart = Chart::new(self.title.clone(), ("time, s", &self.axis)).low().borders(self.borders.clone());
        let chart = match self.bounds {
            Some((low, high)) => {
                chart.pieces("limits", "b", vec![vec![(from, high), (to, high)], vec![(from, low), (to, low)]])
            }
            None => chart.with_zero(),
        };
        let chart = chart.envelope("motion", "a", self.course);
        self.nearest.into_iter().fold(chart, |chart, point| chart.mark("nearest to a limit", "d", point))
    }
}

fn drawn<'a>(joint: &'a JointCourse, plot_data: &MotionPlotData) -> Vec<QuantityOverTime<'a>> {
    let one = |(kind, course): &'a (LimitKind, Envelope)| {
        let row = plot_data.certificate.iter().find(|r| r.limit == *kind && r.subject == joint.coordinate);
        let bounds = match kind {
            // For torque and power, the drawn limit is the bound in the certificate: the allowed share of the limit, minus dry
            // friction.
            LimitKind::Effort | LimitKind::Power => row.map(|r| (-r.bound.abs(), r.bound.abs())),
            _ => joint.limits.bounds(*kind),
        };
        let unit = unit_of(*kind, joint.is_prismatic);
        let name = if *kind == LimitKind::Effort { "torque without dry friction" } else { &kind.to_string() };
        let spans = course.spans();
        QuantityOverTime {
            kind: *kind,
            title: format!("{name} of {}", joint.coordinate),
            axis: unit.clone(),
            caption: caption(name, &unit, row),
            course,
            span: (spans.first().map_or(0.0, |s| s.t), spans.last().map_or(0.0, |s| s.t)),
            bounds,
            nearest: row.map(|r| (r.time_s, r.value)),
            borders: plot_data.borders.clone(),
        }
    };
    joint.positions.iter().map(one).collect()
}

/// The unit of a quantity. If the type of the joint is not known, both units are named: `rad/s (m/s)`.
fn unit_of(kind: LimitKind, is_prismatic: Option<bool>) -> String {
    let (turns, slides) = (kind.unit(false), kind.unit(true));
    unit(&match is_prismatic {
        Some(is_prismatic) => kind.unit(is_prismatic).to_string(),
        None if turns == slides => turns.to_string(),
        None => format!("{turns} ({slides})"),
    })
}

/// Values below this share of their limit are printed as zero.
const ZERO_SHARE_OF_LIMIT: f64 = 1e-9;

/// The caption of a chart: the statement of the certificate (list of proven limits) on this quantity.
fn caption(name: &str, unit: &str, row: Option<&CertificateRow>) -> String {
    let Some(CertificateRow { time_s, value, bound, nowhere_beyond, kept, .. }) = row else {
        return format!("{name}: no limit is looked at");
    };
    let limit = bound.abs();
    // Rounding errors of a coordinate at rest are printed as zero.
    let digits = |x: f64| significant(if x.abs() < ZERO_SHARE_OF_LIMIT * limit { 0.0 } else { x }, 4);
    let (value, bound, proved) = (digits(*value), digits(*bound), digits(*nowhere_beyond));
    let at = format!("{name}: {value} of {bound} {unit} at {} s", significant(*time_s, 3));
    match kept {
        LimitProof::Proven => format!("{at}; proven nowhere beyond {proved}"),
        LimitProof::Violated => format!("{at}: BEYOND its limit"),
        LimitProof::Open => format!("{at}; NOT proven: nowhere beyond {proved}"),
    }
}

/// The path of the end effector in views along the three axes of the base frame, with floor, walls and boxes. Each view has a
/// file name, a caption and a chart.
fn paths(tip: &EndEffectorPath, space: &SpaceLimits) -> Vec<(&'static str, String, Chart<'static>)> {
    let planes = [
        ("path_xy", "x and y: from above", 0, 1),
        ("path_xz", "x and z: from the side", 0, 2),
        ("path_yz", "y and z: from the front", 1, 2),
    ];
    let axes = ["x, m", "y, m", "z, m"];
    let plane = |(name, caption, a, b): (&'static str, &str, usize, usize)| {
        let points: Vec<(f64, f64)> = tip.points.iter().map(|p| (p[a], p[b])).collect();
        let chart = Chart::new(format!("Path of {}, {caption}", tip.name), (axes[a], axes[b]))
            .true_to_scale()
            .line("path", "a", &points);
        let edges = edges(space, [a, b], &points);
        let chart = if edges.is_empty() { chart } else { chart.pieces("floor, walls, boxes", "c", edges) };
        (name, caption.to_string(), points.first().into_iter().fold(chart, |chart, p| chart.mark("start", "b", *p)))
    };
    planes.map(plane).into_iter().collect()
}

/// Lines of floor, walls and boxes in a view along an axis of the base frame. Boxes are outlines. A plane is drawn only if the
/// view direction lies in the plane. It is then a line over the extent of `path`. `axes`: the two axes of the view.
fn edges(space: &SpaceLimits, axes: [usize; 2], path: &[(f64, f64)]) -> Vec<Vec<(f64, f64)>> {
    let [a, b] = axes;
    let extent = |of: fn(&(f64, f64)) -> f64| {
        path.iter().map(of).fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)))
    };
    let ((left, right), (low, high)) = (extent(|p| p.0), extent(|p| p.1));
    let (centre, radius) = ((0.5 * (left + right), 0.5 * (low + high)), 0.5 * (right - left).hypot(high - low));
    let floor = space.floor.and_then(Floor::height).map(|z| ([0.0, 0.0, z], [0.0, 0.0, 1.0]));
    let planes = floor.into_iter().chain(space.walls.iter().map(|wall| (wall.point, wall.normal)));
    let line = |(point, normal): ([f64; 3], [f64; 3])| {
        let (size, seen) = (normal.iter().fold(0.0, |sum: f64, x| sum.hypot(*x)), normal[a].hypot(normal[b]));
        let n = (normal[a] / seen, normal[b] / seen);
        let beyond = (centre.0 - point[a]) * n.0 + (centre.1 - point[b]) * n.1;
        let foot = (centre.0 - beyond * n.0, centre.1 - beyond * n.1);
        let end = |side: f64| (foot.0 - side * radius * n.1, foot.1 + side * radius * n.0);
        (seen > EDGE_ON_SINE * size).then(|| vec![end(-1.0), end(1.0)])
    };
    let cells = space.boxes.iter().map(|cell| {
        let ((left, low), (right, high)) = ((cell.low[a], cell.low[b]), (cell.high[a], cell.high[b]));
        vec![(left, low), (right, low), (right, high), (left, high), (left, low)]
    });
    planes.filter_map(line).chain(cells).collect()
}

/// A plane is drawn as a line if the sine of the angle between the normal of the plane and the view direction is at least this
/// value.
const EDGE_ON_SINE: f64 = 0.9999;

/// Shortest length of a bar, per cent of the longest bar. It keeps every bar visible.
const SHORTEST_BAR_PERCENT: f64 = 2.0;

/// Table rows for the parameters, in the given order, and a sentence that explains the bars. A bar shows the relative standard
/// deviation (or the absolute one, if no parameter has a relative one), on a logarithmic scale between powers of ten.
fn visible(parameters: &[VisibleParameter]) -> (String, Vec<Visible>) {
    let is_relative = parameters.iter().any(|p| p.relative_deviation.is_some());
    let shown = |p: &VisibleParameter| if is_relative { p.relative_deviation } else { p.deviation };
    let logarithms = parameters.iter().filter_map(shown).filter(|x| *x > 0.0 && x.is_finite()).map(f64::log10);
    let (low, high) = logarithms.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
    // The scale ends at 100 %, because a parameter with a larger relative standard deviation is not significant anyway.
    let high = if is_relative { high.ceil().min(0.0) } else { high.ceil() };
    let low = low.floor().min(high - 1.0);
    let scale = match (low.is_finite() && high.is_finite(), is_relative) {
        (false, _) => String::new(),
        (true, true) => format!(
            "A bar is the relative sigma, logarithmic from {} % to {} % and full beyond; a parameter with the nominal value zero has none",
            power_of_ten(low + 2.0),
            power_of_ten(high + 2.0)
        ),
        (true, false) => format!(
            "No parameter has a nominal value, so a bar is sigma in its unit, logarithmic from {} to {}",
            power_of_ten(low),
            power_of_ten(high)
        ),
    };
    let row = |p: &VisibleParameter| {
        let remark = p.remark().unwrap_or_default();
        let unit = unit(&p.unit.to_string());
        let place = |x: f64| (100.0 * (x.log10() - low) / (high - low)).clamp(SHORTEST_BAR_PERCENT, 100.0);
        Visible {
            name: p.id.to_string(),
            described: p.described.map_or("-".into(), |x| significant(x, 3)),
            deviation: p.deviation.map_or("-".into(), |x| format!("{} {unit}", significant(x, 2)).trim().to_string()),
            relative: p.relative_deviation.map_or("-".into(), percent),
            bar: shown(p).filter(|x| x.is_finite()).map(place),
            is_doubtful: !remark.is_empty(),
            remark,
        }
    };
    (scale, parameters.iter().map(row).collect())
}

/// Formats a power of ten as a decimal number: `0.001`, `100`.
fn power_of_ten(exponent: f64) -> String {
    let digits = (-exponent).max(0.0) as usize;
    format!("{:.digits$}", 10f64.powf(exponent))
}

#[cfg(test)]
mod tests {
    use experiments::excitation::space_limits::{SpaceBox, Wall};

    use super::*;

    #[test]
    fn planes_are_lines_where_they_are_seen_edge_on() {
        let wall = |normal| Wall { point: [0.5, 0.0, 0.0], normal, links: None };
        let path = [(0.0, 0.2), (0.4, 0.5)];
        // The line of a plane extends beyond the path by half of the path's diagonal.
        let radius = 0.25;
        let of = |space: SpaceLimits, axes| edges(&space, axes, &path);
        let floor = SpaceLimits { floor: Some(Floor::At(-0.1)), ..Default::default() };
        assert_eq!(of(floor.clone(), [0, 1]), Vec::<Vec<_>>::new());
        let line = &of(floor, [0, 2])[0];
        assert!(line.iter().all(|p| (p.1 + 0.1).abs() < 1e-12), "{line:?}");
        let mut ends = [line[0].0, line[1].0];
        ends.sort_by(f64::total_cmp);
        assert!((ends[0] - (0.2 - radius)).abs() < 1e-12 && (ends[1] - (0.2 + radius)).abs() < 1e-12, "{line:?}");
        // The plane x + y = 0.5 is a line only from above. The plane x = 0.5 is a line from above and from the side, for any
        // length of its normal.
        let slanting = SpaceLimits { walls: vec![wall([-2.0, -2.0, 0.0])], ..Default::default() };
        let line = &of(slanting.clone(), [0, 1])[0];
        assert!(line.iter().all(|p| (p.0 + p.1 - 0.5).abs() < 1e-12), "{line:?}");
        assert!(of(slanting, [0, 2]).is_empty());
        let nowhere = SpaceLimits { walls: vec![wall([0.0; 3])], ..Default::default() };
        assert!(of(nowhere, [0, 1]).is_empty());
        let upright = SpaceLimits { walls: vec![wall([-3.0, 0.0, 0.0])], ..Default::default() };
        assert_eq!([[0, 1], [0, 2], [1, 2]].map(|axes| of(upright.clone(), axes).len()), [1, 1, 0]);
        let cell = SpaceBox { low: [-1.0, -2.0, 0.0], high: [1.0, 2.0, 1.5], links: None };
        let cells = SpaceLimits { boxes: vec![cell], ..Default::default() };
        assert_eq!(of(cells, [1, 2])[0], [(-2.0, 0.0), (2.0, 0.0), (2.0, 1.5), (-2.0, 1.5), (-2.0, 0.0)]);
    }
}
