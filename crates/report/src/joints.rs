//! The joints: the parts of each torque, the residual, and whether the residual is noise.

use identification::estimate::artefact::Estimate;
use identification::estimate::autocorrelation::{NOISE_MEMORY_PERIODS, filtered_noise};
use identification::estimate::identified::INTERVAL;
use identification::portrait::envelope::Envelope;
use identification::portrait::split::TORQUE_PART_NAMES;
use identification::portrait::{JointPortrait, Portrait};
use serde::Serialize;

use crate::chart::Chart;
use crate::number::{percent, significant};
use crate::plot::Plot;
use crate::timeline::Timeline;

/// A joint of the page.
#[derive(Serialize)]
pub(crate) struct Joint {
    name: String,
    /// Of the portrait's logs.
    relative: String,
    rms: String,
    held_out: String,
    memory: String,
    /// Shares of the parts, each with its word, in per cent of their sum.
    shares: Vec<Share>,
    /// Torque and what is left of it, one below the other.
    plot: String,
    charts: Vec<Figure>,
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
pub(crate) struct Figure {
    pub caption: String,
    pub svg: String,
}

/// Classes of the style sheet, of the parts of a torque in their order.
const PART_CLASSES: [&str; 4] = ["a", "b", "c", "d"];

/// The joints of a portrait. `estimate` gives the errors on parts left out and the cut-off.
pub(crate) fn joints(portrait: &Portrait, estimate: Option<&Estimate>) -> Vec<Joint> {
    portrait.joints.iter().enumerate().map(|(k, joint)| one(k, joint, portrait, estimate)).collect()
}

fn one(k: usize, joint: &JointPortrait, portrait: &Portrait, estimate: Option<&Estimate>) -> Joint {
    let of_estimate = estimate.and_then(|e| e.joints.iter().find(|j| j.coordinate == joint.coordinate));
    let sum: f64 = joint.part_rms.iter().sum();
    let share = |(k, rms): (usize, &f64)| Share {
        name: TORQUE_PART_NAMES[k],
        class: PART_CLASSES[k],
        percent: if sum > 0.0 { 100.0 * rms / sum } else { 0.0 },
        text: format!("{} {}", significant(*rms, 3), joint.unit),
    };
    let memory = of_estimate.and_then(|j| j.memory);
    Joint {
        name: joint.coordinate.clone(),
        relative: if joint.torque_rms > 0.0 { percent(joint.residual_rms / joint.torque_rms) } else { "-".into() },
        rms: format!("{} {}", significant(joint.residual_rms, 3), joint.unit),
        held_out: of_estimate.and_then(|j| j.held_out).map_or("-".into(), percent),
        memory: memory.map_or("-".into(), |memory| likeness(memory, estimate.and_then(|e| e.cutoff))),
        shares: joint.part_rms.iter().enumerate().map(share).collect(),
        plot: plot(k, joint, portrait),
        charts: charts(joint, portrait, memory, estimate.and_then(|e| e.cutoff)),
    }
}

/// The time over which a residual is correlated, compared with noise behind the same filter.
fn likeness(memory: f64, cutoff: Option<f64>) -> String {
    let seconds = format!("{} s", significant(memory, 2));
    match cutoff.map(|hz| memory * hz / NOISE_MEMORY_PERIODS) {
        None => seconds,
        Some(times) if times < 1.5 => format!("{seconds}, as noise"),
        Some(times) => format!("{seconds}, {times:.1} × noise"),
    }
}

/// The charts of a joint by their file names, for a folder of pictures.
pub(crate) fn pictures<'a>(portrait: &'a Portrait, estimate: Option<&Estimate>) -> Vec<(String, Chart<'a>)> {
    let cutoff = estimate.and_then(|e| e.cutoff);
    let named = |joint| {
        let charts = torques(joint, portrait).into_iter().chain(drawn(joint, portrait, None, cutoff));
        charts.map(|(name, _, chart)| (format!("{name}_{}", joint.coordinate), chart)).collect::<Vec<_>>()
    };
    portrait.joints.iter().flat_map(named).collect()
}

fn charts(joint: &JointPortrait, portrait: &Portrait, memory: Option<f64>, cutoff: Option<f64>) -> Vec<Figure> {
    let figure = |(_, caption, chart): (&str, String, Chart)| Figure { caption, svg: chart.svg() };
    drawn(joint, portrait, memory, cutoff).into_iter().map(figure).collect()
}

/// The axis of time of the logs.
pub(crate) const LOG_TIME: &str = "log";

/// The axis of time of a portrait's plots, with the torques of each joint, what is left of them, and its position; for
/// the script of a page. `None` without samples.
pub(crate) fn timeline(portrait: &Portrait) -> Option<Timeline> {
    Timeline::new(portrait.joints.iter().enumerate().flat_map(|(k, joint)| lines(k, joint)))
}

/// The lines of joint k by their keys.
fn lines(k: usize, joint: &JointPortrait) -> Vec<(String, &Envelope)> {
    let described = joint.described.as_ref().map(|line| (format!("d{k}"), line));
    let keys = ["m", "p", "r", "q"].map(|key| format!("{key}{k}"));
    let lines = [&joint.measured, &joint.predicted, &joint.residual, &joint.course];
    keys.into_iter().zip(lines).chain(described).collect()
}

/// The torques of joint k and what is left, for a script: the names of the lines are in the legend of the page.
fn plot(k: usize, joint: &JointPortrait, portrait: &Portrait) -> String {
    let key = |letter: &str| format!("{letter}{k}");
    let span = portrait.logs.first().zip(portrait.logs.last()).map_or((0.0, 1.0), |(a, b)| (a.from, b.to));
    let [torque, residual] = torques(joint, portrait).map(|(_, _, chart)| chart.wide(span));
    let mut legend = vec![(key("m"), "a", "measured".to_string())];
    legend.extend(joint.described.as_ref().map(|_| (key("d"), "c", "description".to_string())));
    legend.push((key("p"), "b", "identified".to_string()));
    let of_torque = legend.iter().map(|(key, _, _)| key.clone()).collect();
    legend.push((key("r"), "d", "what is left".to_string()));
    let svgs = vec![torque.live(of_torque).svg(), residual.low().live(vec![String::new(), key("r")]).svg()];
    let band = significant(INTERVAL * joint.residual_rms, 2);
    let caption = format!("Torque, and what is left of it with its 95 % band of ±{band} {}", joint.unit);
    Plot { time: LOG_TIME, caption, legend, svgs }.html()
}

/// File name, caption and chart of the torque and of what is left of it.
fn torques<'a>(joint: &'a JointPortrait, portrait: &Portrait) -> [(&'static str, String, Chart<'a>); 2] {
    let unit = joint.unit.as_str();
    let band = INTERVAL * joint.residual_rms;
    let mut torque = over_time("Torque", joint, portrait).envelope("measured", "a", &joint.measured);
    if let Some(described) = &joint.described {
        torque = torque.envelope("description", "c", described);
    }
    let residual = over_time("Residual", joint, portrait).band("95 % of it", -band, band);
    [
        ("torque", "Torque".to_string(), torque.envelope("identified", "b", &joint.predicted)),
        (
            "residual",
            format!("What is left, with its 95 % band of ±{} {unit}", significant(band, 2)),
            residual.envelope("measured − identified", "d", &joint.residual),
        ),
    ]
}

/// An empty chart of a joint over time, with a line where one log ends and the next begins.
fn over_time<'a>(title: &str, joint: &JointPortrait, portrait: &Portrait) -> Chart<'a> {
    let borders: Vec<f64> = portrait.logs.iter().skip(1).map(|log| log.from).collect();
    Chart::new(format!("{title} of {}", joint.coordinate), ("time, s", &joint.unit)).with_zero().borders(borders)
}

/// File name, caption and chart of all else.
fn drawn<'a>(
    joint: &'a JointPortrait,
    portrait: &'a Portrait,
    memory: Option<f64>,
    cutoff: Option<f64>,
) -> Vec<(&'static str, String, Chart<'a>)> {
    let (name, unit) = (&joint.coordinate, joint.unit.as_str());
    let speed = if joint.is_prismatic { "speed, m/s" } else { "speed, rad/s" };
    let mut split = over_time("Parts of the torque", joint, portrait);
    for (k, part) in joint.parts.iter().enumerate() {
        split = split.envelope(TORQUE_PART_NAMES[k], PART_CLASSES[k], part);
    }
    let mut charts = vec![
        ("parts", "What the torque is made of".to_string(), split),
        ("friction", friction_caption(joint), friction(joint, name, unit, speed)),
    ];
    // Only what the portrait has: a short log has no spectrum.
    if !joint.residual_spectrum.is_empty() {
        charts.push(("spectrum", spectrum_caption(joint, unit), spectrum(joint, name, unit, cutoff)));
    }
    if joint.autocorrelation.len() > 1 {
        let (caption, chart) = autocorrelation(joint, name, memory, cutoff);
        charts.push(("autocorrelation", caption, chart));
    }
    charts
}

fn friction<'a>(joint: &'a JointPortrait, name: &str, unit: &str, speed: &str) -> Chart<'a> {
    let law = &joint.friction_law;
    let middle = law.iter().position(|p| p.0 > 0.0).unwrap_or(law.len());
    let pieces = vec![law[..middle].to_vec(), law[middle..].to_vec()];
    let chart = Chart::new(format!("Friction of {name}"), (speed, unit)).with_zero().dots("data", "a", &joint.friction);
    if law.is_empty() { chart } else { chart.pieces("law", "b", pieces) }
}

fn friction_caption(joint: &JointPortrait) -> String {
    match joint.friction_law.is_empty() {
        true => "Measured torque less inertia and gravity; no friction is in the model".into(),
        false => "Friction: measured torque less inertia and gravity".into(),
    }
}

fn spectrum<'a>(joint: &JointPortrait, name: &str, unit: &str, cutoff: Option<f64>) -> Chart<'a> {
    let density = format!("{unit}/√Hz");
    let shown = |points: &[(f64, f64)]| -> Vec<(f64, f64)> {
        // Beyond the cut-off only the remainder of the filter is left.
        points.iter().copied().filter(|p| cutoff.is_none_or(|hz| p.0 <= 1.3 * hz)).collect()
    };
    let residual = shown(&joint.residual_spectrum);
    let mut chart = Chart::new(format!("Spectrum of {name}"), ("frequency, Hz", &density))
        .logarithmic()
        .line("torque", "a", &shown(&joint.torque_spectrum))
        .line("what is left", "d", &residual);
    if let (Some(level), Some(first), Some(last)) = (joint.noise, residual.first(), residual.last()) {
        chart = chart.line("noise", "c", &[(first.0, level), (last.0, level)]);
    }
    chart
}

fn spectrum_caption(joint: &JointPortrait, unit: &str) -> String {
    match joint.noise {
        Some(level) => format!(
            "Spectrum; the noise is that of the torque far above the cut-off, {} {unit}/√Hz",
            significant(level, 2)
        ),
        None => "Spectrum; the log holds nothing above the cut-off that would show its noise".into(),
    }
}

fn autocorrelation<'a>(
    joint: &JointPortrait,
    name: &str,
    memory: Option<f64>,
    cutoff: Option<f64>,
) -> (String, Chart<'a>) {
    let band = joint.autocorrelation_band;
    let found = &joint.autocorrelation;
    let mut chart = Chart::new(format!("Autocorrelation of {name}"), ("lag, s", ""))
        .with_zero()
        .band("95 % of white noise", -band, band)
        .line("what is left", "d", found);
    let mut caption = "How far what is left resembles itself".to_string();
    if let Some(cutoff) = cutoff {
        let noise: Vec<(f64, f64)> = found.iter().map(|p| (p.0, filtered_noise(cutoff, p.0))).collect();
        chart = chart.line("filtered noise", "c", &noise);
        if let Some(memory) = memory {
            let times = memory * cutoff / NOISE_MEMORY_PERIODS;
            caption += &match times < 1.5 {
                true => format!(": {} s, not longer than noise behind the filter", significant(memory, 2)),
                false => format!(": {} s, {times:.1} times as long as noise behind the filter", significant(memory, 2)),
            };
        }
    }
    (caption, chart)
}
