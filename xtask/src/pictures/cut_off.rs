//! Draws the low-pass filter of an identification: the spectrum of a torque in docs/ur5/log.csv, and the cut-off frequency that
//! README shows for this log.
//!
//! Above the cut-off frequency, the torque is mostly noise.

use super::canvas::{Anchor, Canvas, Ink};
use crate::cargo::root;

const LOG: &str = "docs/ur5/log.csv";
const COLUMN: &str = "tau_elbow";
/// Width of the frequency bands over which the spectrum is averaged, so that the curve is smooth, Hz.
const BAND_HZ: f64 = 0.75;
const HIGHEST_HZ: f64 = 40.0;

/// The sampling period (s) and the values of the torque column in the log.
fn column() -> Result<(f64, Vec<f64>), String> {
    let text = std::fs::read_to_string(root().join(LOG)).map_err(|e| format!("{LOG}: {e}"))?;
    let mut lines = text.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let header = lines.next().ok_or(format!("{LOG} is empty"))?;
    let place = header.iter().position(|name| *name == COLUMN).ok_or(format!("{LOG} has no {COLUMN}"))?;
    let number =
        |cell: Option<&&str>| cell.and_then(|cell| cell.parse::<f64>().ok()).ok_or(format!("{LOG}: no number"));
    let cells: Vec<Vec<&str>> = lines.collect();
    let times: Vec<f64> = cells.iter().map(|row| number(row.first())).collect::<Result<_, _>>()?;
    let torques: Vec<f64> = cells.iter().map(|row| number(row.get(place))).collect::<Result<_, _>>()?;
    match times.as_slice() {
        [first, .., last] => Ok(((last - first) / (times.len() - 1) as f64, torques)),
        _ => Err(format!("{LOG} has no two rows")),
    }
}

/// The cut-off frequency that README shows, Hz.
fn cut_off() -> Result<f64, String> {
    let text = std::fs::read_to_string(root().join("README.md")).map_err(|e| format!("README.md: {e}"))?;
    let number = text.split("cut-off ").skip(1).find_map(|rest| rest.split(" Hz").next()?.parse().ok());
    number.ok_or("README.md shows no `cut-off .. Hz`".into())
}

/// For each band: frequency (Hz) and amplitude (N m). Computed by Fourier sums of the torque minus its mean, with a Hann
/// window.
fn spectrum(step: f64, torques: &[f64]) -> Vec<(f64, f64)> {
    let n = torques.len() as f64;
    let mean = torques.iter().sum::<f64>() / n;
    let window = |i: usize| 0.5 - 0.5 * libm::cos(std::f64::consts::TAU * i as f64 / n);
    let x: Vec<f64> = torques.iter().enumerate().map(|(i, tau)| (tau - mean) * window(i)).collect();
    let line = |k: usize| {
        let turn = |i: usize| std::f64::consts::TAU * ((k * i) % x.len()) as f64 / n;
        let sum = |f: fn(f64) -> f64| x.iter().enumerate().map(|(i, x)| x * f(turn(i))).sum::<f64>();
        let (a, b) = (sum(libm::cos), sum(libm::sin));
        (k as f64 / (n * step), (a * a + b * b) / (n * n))
    };
    let lines: Vec<(f64, f64)> = (1..).map(line).take_while(|(hz, _)| *hz < HIGHEST_HZ).collect();
    let mut bands: Vec<(f64, f64)> = Vec::new();
    let mut rest = lines.as_slice();
    while let Some((first, _)) = rest.first() {
        let count = rest.iter().take_while(|(hz, _)| hz - first < BAND_HZ).count();
        let power = rest[..count].iter().map(|(_, power)| power).sum::<f64>() / count as f64;
        bands.push((first + BAND_HZ / 2.0, libm::sqrt(power)));
        rest = &rest[count..];
    }
    bands
}

pub(crate) fn draw() -> Result<String, String> {
    let ((step, torques), cut_off) = (column()?, cut_off()?);
    let bands = spectrum(step, &torques);
    let title = format!("Spectrum of the torque of a UR5's elbow, and the cut-off at {cut_off} Hz");
    let mut canvas = Canvas::new(760.0, 400.0, &title);
    canvas.heading((20.0, 28.0), "torque of the elbow in docs/ur5/log.csv, N m by frequency");
    let x = |hz: f64| 80.0 + 650.0 * hz / HIGHEST_HZ;
    // The vertical axis is logarithmic with five decades; 10 N m is at the top.
    let y = |amplitude: f64| 60.0 + 270.0 * (1.0 - libm::log10(amplitude.max(1e-4))) / 5.0;
    for power in -4..=1 {
        let amplitude = libm::pow(10.0, f64::from(power));
        canvas.line((80.0, y(amplitude)), (730.0, y(amplitude)), Ink::Faint, 0.7);
        canvas.words((72.0, y(amplitude) + 5.0), Anchor::End, Ink::Word, &amplitude.to_string());
    }
    for hz in (0..=40).step_by(5) {
        canvas.words((x(f64::from(hz)), 352.0), Anchor::Middle, Ink::Word, &format!("{hz}"));
    }
    canvas.words((730.0, 372.0), Anchor::End, Ink::Word, "Hz");
    let (below, above): (Vec<_>, Vec<_>) =
        bands.iter().map(|(hz, amplitude)| (x(*hz), y(*amplitude))).partition(|p| p.0 <= x(cut_off));
    let joined: Vec<(f64, f64)> = below.last().copied().into_iter().chain(above).collect();
    canvas.path(&joined, Ink::Faint, 2.2);
    canvas.path(&below, Ink::Blue, 2.2);
    canvas.dashed((x(cut_off), 50.0), (x(cut_off), 330.0), Ink::Orange);
    canvas.words(
        (x(cut_off) + 8.0, 62.0),
        Anchor::Start,
        Ink::Orange,
        &format!("cut-off {cut_off} Hz: found from the log"),
    );
    canvas.words(
        (x(cut_off) + 8.0, 185.0),
        Anchor::Start,
        Ink::Word,
        "noise: filtered away, on both sides of the equation",
    );
    canvas.words((150.0, 100.0), Anchor::Start, Ink::Blue, "what the robot does");
    Ok(canvas.finish())
}
