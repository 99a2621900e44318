//! Time to read a description, and time to read the URDF of the same robot. Both are printed; no test asserts them.

use std::path::Path;
use std::time::{Duration, Instant};

use robot::format::{AngleSnapping, Mimic, ReadOptions, parse_with, write_urdf};
use robot::{Error, Robot};

/// Processor time of this thread if the system counts it, otherwise elapsed time. Other processes do not change processor time.
fn now() -> Duration {
    let counted = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let nanoseconds = counted.and_then(|text| text.split(' ').next()?.parse().ok());
    static START: std::sync::OnceLock<Instant> = std::sync::OnceLock::new();
    nanoseconds.map_or_else(|| START.get_or_init(Instant::now).elapsed(), Duration::from_nanos)
}

/// A description is read repeatedly for at least this time, because the system updates its time counter only every few
/// milliseconds.
const ENOUGH: Duration = Duration::from_millis(100);

/// Mean time to read a description once, ms. `None` if it cannot be read.
fn milliseconds(read: &dyn Fn() -> Result<Robot, Error>) -> Option<f64> {
    let (before, mut readings) = (now(), 0);
    while now() - before < ENOUGH {
        read().ok()?;
        readings += 1;
    }
    Some((now() - before).as_secs_f64() * 1e3 / f64::from(readings))
}

/// A table row `| name | coordinates | difference | ms | ms of the URDF |`. `urdf`: the robot as a URDF; if `None`, it is
/// written.
pub(super) fn row(
    name: &str,
    robot: &Robot,
    difference: f64,
    read: &dyn Fn() -> Result<Robot, Error>,
    urdf: Option<&str>,
) -> Option<String> {
    let urdf = urdf.map_or_else(|| write_urdf(robot).0, str::to_string);
    let options = ReadOptions { mimic: Mimic::Independent, angles: AngleSnapping::AsGiven, ..ReadOptions::default() };
    let theirs = milliseconds(&|| parse_with(&urdf, Path::new("arm.urdf"), options))?;
    let ours = milliseconds(read)?;
    Some(format!("| {name} | {} | {difference:.0e} | {ours:.2} | {theirs:.2} |", robot.n_coordinates()))
}
