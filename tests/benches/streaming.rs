//! Time and memory of an identification from up to a million samples of an arm with seven joints, for logs of increasing length:
//! `cargo bench -p tests --bench streaming`.
//!
//! Each log is written, and identified in a separate process. The peak memory of the process (VmHWM of /proc/self/status) is
//! compared with the memory for all numbers of the log, and with the memory for the whole observation matrix W.

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;
use std::time::Instant;

use linear_model::compiled::compiled;
use linear_model::parameter::BaseParameter;
use linear_model::regressor::{Coordinate, Regressor};
use logs::LogSource;
use random::Random;
use rist::describe::model::Model;
use rist::fit::samples::{IdentifyRequest, identify};

fn panda() -> impl Regressor {
    let function = generated::all().iter().find(|f| f.name == "panda").expect("a model of the repository");
    let coordinate = |name: &&str| Coordinate { name: name.to_string(), is_prismatic: false };
    let coordinates = function.coordinates.iter().map(coordinate).collect();
    let base = |name: &&str| BaseParameter::turning(name, 0).expect("a name of a base parameter");
    let parameters = function.parameters.iter().map(base).collect();
    compiled(function.fingerprint, coordinates, parameters).expect("it is compiled in")
}

/// Writes a log at 1 kHz: each joint moves by three sines, and the torques are from random parameters with friction and noise.
fn write_log(path: &Path, rows: usize) -> std::io::Result<()> {
    let arm = panda();
    let (n, p) = (arm.coordinates().len(), arm.parameters().len());
    let mut random = Random::new(1);
    let x: Vec<f64> = (0..p).map(|_| random.normal()).collect();
    let waves: Vec<(f64, f64)> =
        (0..3 * n).map(|i| (0.1 + 0.13 * (i % 3) as f64 + 0.007 * i as f64, random.normal())).collect();
    let mut out = std::io::BufWriter::new(std::fs::File::create(path)?);
    let names = |stem: &str| arm.coordinates().iter().map(|c| format!(",{stem}_{c}")).collect::<String>();
    writeln!(out, "t{}{}{}", names("q"), names("dq"), names("tau"))?;
    let (mut q, mut dq, mut ddq) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
    let mut y = vec![0.0; n * p];
    for r in 0..rows {
        let t = 1e-3 * r as f64;
        for j in 0..n {
            (q[j], dq[j], ddq[j]) = (0.0, 0.0, 0.0);
            for (f, phase) in &waves[3 * j..3 * j + 3] {
                let w = 2.0 * std::f64::consts::PI * f;
                let (s, c) = (w * t + phase).sin_cos();
                (q[j], dq[j], ddq[j]) = (q[j] + 0.5 * s, dq[j] + 0.5 * w * c, ddq[j] - 0.5 * w * w * s);
            }
        }
        arm.fill(&q, &dq, &ddq, &mut y);
        let mut line = format!("{t:.3}");
        for x in q.iter().chain(&dq) {
            let _ = write!(line, ",{x:.6}");
        }
        for j in 0..n {
            let tau: f64 = y[j * p..(j + 1) * p].iter().zip(&x).map(|(y, x)| y * x).sum();
            let _ = write!(line, ",{:.5}", tau + 0.3 * dq[j] + 0.5 * dq[j].signum() + 0.1 * random.normal());
        }
        writeln!(out, "{line}")?;
    }
    out.flush()
}

/// CPU time of all threads of this process so far, s, with a resolution of 0.01 s; 0 if there is no /proc.
fn cpu_seconds() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    // User and system time are fields 14 and 15. Field 2 may contain blanks, so the text after its parenthesis is used.
    let words = stat.rsplit(')').next().unwrap_or_default().split_whitespace();
    words.skip(11).take(2).filter_map(|ticks| ticks.parse::<f64>().ok()).sum::<f64>() / 100.0
}

/// Identifies as `rist identify` does. `every`: every sample becomes a row; otherwise the default decimation is used.
fn measure(path: &Path, every: bool) -> Result<(), Box<dyn std::error::Error>> {
    let start = Instant::now();
    let model = Model::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("../models/panda.yaml"))?;
    let mut request = IdentifyRequest::default();
    if every {
        let signals = &mut request.samples.rows.signals;
        (signals.cutoff, signals.decimate) = (Some(40.0), Some(1));
    }
    let (log, _) = model.open_log(path, &Default::default())?;
    let rows = log.report().kept;
    let held = if matches!(log, LogSource::Held(_)) { "one block" } else { "blocks" };
    let estimate = identify(&model, &[log], &request)?.estimate;
    let (seconds, cpu) = (start.elapsed().as_secs_f64(), cpu_seconds());
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let peak = status.lines().find_map(|l| l.strip_prefix("VmHWM:")).and_then(|l| l.split_whitespace().next());
    let peak = peak.and_then(|kib| kib.parse::<f64>().ok()).map_or("unknown".into(), |k| format!("{:.0}", k / 1024.0));
    let columns = estimate.parameters.len();
    let mebibytes = |numbers: usize| (8 * numbers) as f64 / f64::from(1 << 20);
    let samples = if every { "every" } else { "defaults" };
    println!(
        "{rows:>9} {held:>9} {samples:>9} {cpu:>8.1} {seconds:>8.1} {peak:>9} {:>8.0} {:>8.0} {:>9.4}",
        mebibytes(rows * 22),
        mebibytes(estimate.rows * columns),
        estimate.total.unwrap_or(f64::NAN)
    );
    Ok(())
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let words: Vec<String> = std::env::args().skip(1).filter(|w| !w.starts_with("--")).collect();
    if let [path, samples] = words.as_slice() {
        return measure(Path::new(path), samples == "every");
    }
    println!(
        "{:>9} {:>9} {:>9} {:>8} {:>8} {:>9} {:>8} {:>8} {:>9}",
        "rows", "", "samples", "CPU s", "wall s", "peak MiB", "log MiB", "W MiB", "residual"
    );
    for rows in [100_000, 300_000, 1_000_000, 2_000_000] {
        let path = std::env::temp_dir().join(format!("rist-streaming-{}.csv", std::process::id()));
        write_log(&path, rows)?;
        let mut measured = Ok(());
        for samples in ["defaults", "every"] {
            let status = std::process::Command::new(std::env::current_exe()?).arg(&path).arg(samples).status()?;
            if !status.success() {
                measured = Err("the measuring process failed");
            }
        }
        std::fs::remove_file(&path)?;
        measured?;
    }
    Ok(())
}
