//! The page section on each joint: the components of its torque, the residual, and a test whether the residual is noise.
//!
//! The components of a torque are, for example, inertia, gravity and friction. Data held out is a part of the logs that is left
//! out of the fit and predicted. The script of the page finds the data of a line by its key.

use identification::estimate::artefact::Estimate;
use identification::estimate::autocorrelation::{NOISE_MEMORY_PERIODS, filtered_noise};
use identification::estimate::identified::INTERVAL;
use identification::plot_data::envelope::Envelope;
use identification::plot_data::split::TORQUE_PART_NAMES;
use identification::plot_data::{JointPlotData, PlotData};
use serde::Serialize;

use crate::chart::Chart;
use crate::number::{percent, significant};
use crate::plot::Plot;
use crate::timeline::Timeline;

/// The section on one joint.
#[derive(Serialize)]
pub(crate) struct JointSection {
    name: String,
    /// Relative error of the torque on the plotted logs.
    relative: String,
    rms: String,
    held_out: String,
    memory: String,
    /// Components of the torque, each with its share in per cent of the sum of all components.
    shares: Vec<Share>,
    /// The plots of torque and residual, one below the other, as HTML.
    plot: String,
    charts: Vec<ChartFigure>,
}

#[derive(Serialize)]
struct Share {
    name: &'static str,
    class: &'static str,
    percent: f64,
    text: String,
}

/// A chart with its caption.
#[derive(Serialize)]
pub(crate) struct ChartFigure {
    pub caption: String,
    pub svg: String,
}

/// A residual counts as noise if its autocorrelation time, divided by the autocorrelation time of white noise after the same
/// filter, is below this value.
const NOISE_TIME_RATIO: f64 = 1.5;
/// Largest frequency of a drawn spectrum, divided by the cut-off frequency.
const SHOWN_FREQUENCY_RATIO: f64 = 1.3;

/// CSS classes of the torque components, in their order.
const PART_CLASSES: [&str; 4] = ["a", "b", "c", "d"];

/// The sections on all joints. `estimate` gives the errors on held-out data and the cut-off frequency.
pub(crate) fn joints(plot_data: &PlotData, estimate: Option<&Estimate>) -> Vec<JointSection> {
    plot_data.joints.iter().enumerate().map(|(k, joint)| one(k, joint, plot_data, estimate)).collect()
}

fn one(k: usize, joint: &JointPlotData, plot_data: &PlotData, estimate: Option<&Estimate>) -> JointSection {
    let of_estimate = estimate.and_then(|e| e.joints.iter().find(|j| j.coordinate == joint.coordinate));
    let sum: f64 = joint.part_rms.iter().sum();
    let share = |(k, rms): (usize, &f64)| Share {
        name: TORQUE_PART_NAMES[k],
        class: PART_CLASSES[k],
        percent: if sum > 0.0 { 100.0 * rms / sum } else { 0.0 },
        text: format!("{} {}", significant(*rms, 3), joint.unit),
    };
    let memory = of_estimate.and_then(|j| j.memory);
    JointSection {
        name: joint.coordinate.clone(),
        relative: if joint.torque_rms > 0.0 { percent(joint.residual_rms / joint.torque_rms) } else { "-".into() },
        rms: format!("{} {}", significant(joint.residual_rms, 3), joint.unit),
        held_out: of_estimate.and_then(|j| j.held_out).map_or("-".into(), percent),
        memory: memory.map_or("-".into(), |memory| likeness(memory, estimate.and_then(|e| e.cutoff))),
        shares: joint.part_rms.iter().enumerate().map(share).collect(),
        plot: plot(k, joint, plot_data),
        charts: charts(joint, plot_data, memory, estimate.and_then(|e| e.cutoff)),
    }
}

/// Describes the autocorrelation time of a residual, s, in comparison with white noise after the same filter. `cutoff`: cut-off
/// frequency, Hz.
fn likeness(memory: f64, cutoff: Option<f64>) -> String {
    let seconds = format!("{} s", significant(memory, 2));
    match cutoff.map(|hz| memory * hz / NOISE_MEMORY_PERIODS) {
        None => seconds,
        Some(times) if times < NOISE_TIME_RATIO => format!("{seconds}, as noise"),
        Some(times) => format!("{seconds}, {times:.1} × noise"),
    }
}

/// The charts of all joints as separate pictures: file name and chart of each.
pub(crate) fn pictures<'a>(plot_data: &'a PlotData, estimate: Option<&Estimate>) -> Vec<(String, Chart<'a>)> {
    let cutoff = estimate.and_then(|e| e.cutoff);
    let named = |joint| {
        let charts = torques(joint, plot_data).into_iter().chain(drawn(joint, plot_data, None, cutoff));
        charts.map(|(name, _, chart)| (format!("{name}_{}", joint.coordinate), chart)).collect::<Vec<_>>()
    };
    plot_data.joints.iter().flat_map(named).collect()
}

fn charts(joint: &JointPlotData, plot_data: &PlotData, memory: Option<f64>, cutoff: Option<f64>) -> Vec<ChartFigure> {
    let figure = |(_, caption, chart): (&str, String, Chart)| ChartFigure { caption, svg: chart.svg() };
    drawn(joint, plot_data, memory, cutoff).into_iter().map(figure).collect()
}

/// Name of the time axis of the logs, as used by the script of the page.
pub(crate) const LOG_TIME: &str = "log";

/// Torques, residual and position of each joint over time, encoded for the script of the page. `None` if there are no samples.
pub(crate) fn timeline(plot_data: &PlotData) -> Option<Timeline> {
    Timeline::new(plot_data.joints.iter().enumerate().flat_map(|(k, joint)| lines(k, joint)))
}

/// The lines of joint k, each with the key by which the script finds it.
fn lines(k: usize, joint: &JointPlotData) -> Vec<(String, &Envelope)> {
    let nominal = joint.nominal.as_ref().map(|line| (format!("d{k}"), line));
    let keys = ["m", "p", "r", "q"].map(|key| format!("{key}{k}"));
    let lines = [&joint.measured, &joint.predicted, &joint.residual, &joint.course];
    keys.into_iter().zip(lines).chain(nominal).collect()
}

/// The plots of torque and residual of joint k, as HTML for the script. The legend is a separate element of the page.
fn plot(k: usize, joint: &JointPlotData, plot_data: &PlotData) -> String {
    let key = |letter: &str| format!("{letter}{k}");
    let span = plot_data.logs.first().zip(plot_data.logs.last()).map_or((0.0, 1.0), |(a, b)| (a.from, b.to));
    let [torque, residual] = torques(joint, plot_data).map(|(_, _, chart)| chart.wide(span));
    let mut legend = vec![(key("m"), "a", "measured".to_string())];
    legend.extend(joint.nominal.as_ref().map(|_| (key("d"), "c", "description".to_string())));
    legend.push((key("p"), "b", "identified".to_string()));
    let of_torque = legend.iter().map(|(key, _, _)| key.clone()).collect();
    legend.push((key("r"), "d", "residual".to_string()));
    let svgs = vec![torque.live(of_torque).svg(), residual.low().live(vec![String::new(), key("r")]).svg()];
    let band = significant(INTERVAL * joint.residual_rms, 2);
    let caption = format!("Torque, and residual with its 95 % band of ±{band} {}", joint.unit);
    Plot { time: LOG_TIME, caption, legend, svgs }.html()
}

/// Two charts of a joint, of the torque and of the residual: file name, caption and chart of each.
fn torques<'a>(joint: &'a JointPlotData, plot_data: &PlotData) -> [(&'static str, String, Chart<'a>); 2] {
    let unit = joint.unit.as_str();
    let band = INTERVAL * joint.residual_rms;
    let mut torque = over_time("Torque", joint, plot_data).envelope("measured", "a", &joint.measured);
    if let Some(nominal) = &joint.nominal {
        torque = torque.envelope("description", "c", nominal);
    }
    let residual = over_time("Residual", joint, plot_data).band("95 % of it", -band, band);
    [
        ("torque", "Torque".to_string(), torque.envelope("identified", "b", &joint.predicted)),
        (
            "residual",
            format!("Residual, with its 95 % band of ±{} {unit}", significant(band, 2)),
            residual.envelope("measured − identified", "d", &joint.residual),
        ),
    ]
}

/// An empty chart of a joint over time, with vertical lines between the logs.
fn over_time<'a>(title: &str, joint: &JointPlotData, plot_data: &PlotData) -> Chart<'a> {
    let borders: Vec<f64> = plot_data.logs.iter().skip(1).map(|log| log.from).collect();
    Chart::new(format!("{title} of {}", joint.coordinate), ("time, s", &joint.unit)).with_zero().borders(borders)
}

/// All charts of a joint except torque and residual over time: file name, caption and chart of each.
fn drawn<'a>(
    joint: &'a JointPlotData,
    plot_data: &'a PlotData,
    memory: Option<f64>,
    cutoff: Option<f64>,
) -> Vec<(&'static str, String, Chart<'a>)> {
    let (name, unit) = (&joint.coordinate, joint.unit.as_str());
    let speed = if joint.is_prismatic { "speed, m/s" } else { "speed, rad/s" };
    let mut split = over_time("Parts of the torque", joint, plot_data);
    for (k, part) in joint.parts.iter().enumerate() {
        split = split.envelope(TORQUE_PART_NAMES[k], PART_CLASSES[k], part);
    }
    let mut charts = vec![
        ("parts", "What the torque is made of".to_string(), split),
        ("friction", friction_caption(joint), friction(joint, name, unit, speed)),
    ];
    // A log that is too short has no spectrum.
    if !joint.residual_spectrum.is_empty() {
        charts.push(("spectrum", spectrum_caption(joint, unit), spectrum(joint, name, unit, cutoff)));
    }
    if joint.autocorrelation.len() > 1 {
        let (caption, chart) = autocorrelation(joint, name, memory, cutoff);
        charts.push(("autocorrelation", caption, chart));
    }
    charts
}

fn friction<'a>(joint: &'a JointPlotData, name: &str, unit: &str, speed: &str) -> Chart<'a> {
    let law = &joint.friction_law;
    let middle = law.iter().position(|p| p.0 > 0.0).unwrap_or(law.len());
    let pieces = vec![law[..middle].to_vec(), law[middle..].to_vec()];
    let chart = Chart::new(format!("Friction of {name}"), (speed, unit)).with_zero().dots("data", "a", &joint.friction);
    if law.is_empty() { chart } else { chart.pieces("law", "b", pieces) }
}

fn friction_caption(joint: &JointPlotData) -> String {
    match joint.friction_law.is_empty() {
        true => "Measured torque less inertia and gravity; no friction is in the model".into(),
        false => "Friction: measured torque less inertia and gravity".into(),
    }
}

fn spectrum<'a>(joint: &JointPlotData, name: &str, unit: &str, cutoff: Option<f64>) -> Chart<'a> {
    let density = format!("{unit}/√Hz");
    let shown = |points: &[(f64, f64)]| -> Vec<(f64, f64)> {
        // Frequencies far above the cut-off are omitted, because the filter removes the signal there.
        points.iter().copied().filter(|p| cutoff.is_none_or(|hz| p.0 <= SHOWN_FREQUENCY_RATIO * hz)).collect()
    };
    let residual = shown(&joint.residual_spectrum);
    let mut chart = Chart::new(format!("Spectrum of {name}"), ("frequency, Hz", &density))
        .logarithmic()
        .line("torque", "a", &shown(&joint.torque_spectrum))
        .line("residual", "d", &residual);
    if let (Some(level), Some(first), Some(last)) = (joint.noise, residual.first(), residual.last()) {
        chart = chart.line("noise", "c", &[(first.0, level), (last.0, level)]);
    }
    chart
}

fn spectrum_caption(joint: &JointPlotData, unit: &str) -> String {
    match joint.noise {
        Some(level) => format!(
            "Spectrum; the noise is that of the torque far above the cut-off, {} {unit}/√Hz",
            significant(level, 2)
        ),
        None => "Spectrum; the log holds nothing above the cut-off that would show its noise".into(),
    }
}

fn autocorrelation<'a>(
    joint: &JointPlotData,
    name: &str,
    memory: Option<f64>,
    cutoff: Option<f64>,
) -> (String, Chart<'a>) {
    let band = joint.autocorrelation_band;
    let found = &joint.autocorrelation;
    let mut chart = Chart::new(format!("Autocorrelation of {name}"), ("lag, s", ""))
        .with_zero()
        .band("95 % of white noise", -band, band)
        .line("residual", "d", found);
    let mut caption = "Autocorrelation of the residual".to_string();
    if let Some(cutoff) = cutoff {
        let noise: Vec<(f64, f64)> = found.iter().map(|p| (p.0, filtered_noise(cutoff, p.0))).collect();
        chart = chart.line("filtered noise", "c", &noise);
        if let Some(memory) = memory {
            let times = memory * cutoff / NOISE_MEMORY_PERIODS;
            caption += &match times < NOISE_TIME_RATIO {
                true => format!(": {} s, not longer than noise behind the filter", significant(memory, 2)),
                false => format!(": {} s, {times:.1} times as long as noise behind the filter", significant(memory, 2)),
            };
        }
    }
    (caption, chart)
}
