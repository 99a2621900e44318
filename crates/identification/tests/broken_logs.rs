//! Broken logs, as data: each is refused with its message, and none panics.

use std::path::Path;

mod log_files;
mod log_formats;

use identification::{Log, Options, Regressor, Signal, identify};

/// Joints that do not couple: tau_j = ZZ_j ddq_j.
struct Wheels {
    coordinates: Vec<String>,
    parameters: Vec<String>,
}

impl Regressor for Wheels {
    fn coordinates(&self) -> &[String] {
        &self.coordinates
    }

    fn parameters(&self) -> &[String] {
        &self.parameters
    }

    fn fill(&self, _: &[f64], _: &[f64], ddq: &[f64], y: &mut [f64]) {
        let n = ddq.len();
        y.fill(0.0);
        (0..n).for_each(|j| y[j * n + j] = ddq[j]);
    }
}

fn wheels(names: &str) -> Wheels {
    let coordinates: Vec<String> = names.split_whitespace().map(Into::into).collect();
    let parameters = (1..=coordinates.len()).map(|i| format!("ZZ{i}")).collect();
    Wheels { coordinates, parameters }
}

fn expanded(text: &str) -> String {
    let mut out = String::new();
    for line in text.lines() {
        match line.strip_prefix('@').and_then(|l| l.split_once(' ')) {
            Some((n, row)) => {
                (0..n.parse().unwrap())
                    .for_each(|i: usize| out += &format!("{}\n", row.replace("{i}", &format!("{i:02}"))));
            }
            None => out += &format!("{line}\n"),
        }
    }
    out
}

fn message(wheels: &Wheels, path: &Path) -> String {
    let signal = Signal { cutoff: Some(40.0), ..Signal::default() };
    let options = Options { signal, ..Options::default() };
    let outcome =
        Log::read(path, wheels.coordinates(), &options.columns).and_then(|(log, _)| identify(wheels, &log, &options));
    match outcome {
        Ok(estimate) => format!("no error, but {estimate}"),
        Err(error) => error.to_string(),
    }
}

#[test]
fn every_broken_log_has_its_message() {
    let data = include_str!("broken_logs.txt");
    let folder = std::env::temp_dir().join(format!("rist-broken-logs-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join("broken.csv");
    let mut tried = 0;
    for entry in data.split("\n=== ").skip(1) {
        let (head, text) = entry.split_once('\n').unwrap_or((entry, ""));
        let (coordinates, expected) = head.split_once(" | ").unwrap();
        std::fs::write(&path, expanded(text)).unwrap();
        let found = message(&wheels(coordinates), &path);
        assert!(found.contains(expected), "expected: {expected}\nfound: {found}");
        tried += 1;
    }
    std::fs::remove_dir_all(&folder).unwrap();
    assert!(tried >= 20, "{tried}");
}

/// Cut off anywhere, or with any byte changed, a log is read or refused, never a panic.
#[test]
fn mutilated_logs_do_not_panic() {
    let row = |i: usize| format!("{},{},{}\n", 0.01 * i as f64, (0.05 * i as f64).sin(), (0.05 * i as f64).cos());
    let whole: String = std::iter::once("t,q1,tau1\n".to_string()).chain((0..80).map(row)).collect();
    let wheels = wheels("a");
    let folder = std::env::temp_dir().join(format!("rist-mutilated-logs-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join("log.csv");
    for k in 0..120 {
        let mut bytes = whole.clone().into_bytes();
        let at = (k * 7919) % bytes.len();
        if k % 2 == 0 {
            bytes.truncate(at);
        } else {
            bytes[at] = (k * 31 % 256) as u8;
        }
        std::fs::write(&path, bytes).unwrap();
        let _ = message(&wheels, &path);
    }
    std::fs::remove_dir_all(&folder).unwrap();
}
