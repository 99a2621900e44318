//! Draws why excitation is needed: two motions of a pendulum, tau = J ddq + k sin q.
//!
//! Each sample gives a point (ddq, sin q), which is a row of the observation matrix W. J: inertia, k: gravity parameter. A slow
//! oscillation with one frequency w has ddq = -w^2 q, so its rows are nearly collinear, and only one combination of J and k is
//! accurately identified. The ellipse z' (W'W) z = const shows the uncertainty of z = (J, k) for the same noise.

use super::canvas::{Anchor, Canvas, Ink};

/// The constant in z' (W'W) z = const. It is chosen such that the longer ellipse fills its picture.
const ELLIPSE_LEVEL: f64 = 2.1;

/// Number of points of an ellipse.
const ELLIPSE_POINTS: i32 = 72;
/// Number of samples of a motion.
const INSTANTS: i32 = 160;
/// Sampling period, s.
const STEP_S: f64 = 0.025;
/// The acceleration that is drawn with the length 1, rad/s^2.
const ACCELERATION_SCALE: f64 = 40.0;

/// Position (rad) and acceleration (rad/s^2) at the time t, s. The motion is a sum of sines, each given by (amplitude,
/// frequency in Hz).
fn state(sines: &[(f64, f64)], t: f64) -> (f64, f64) {
    let turn = |hz: f64| std::f64::consts::TAU * hz;
    let q = sines.iter().map(|(a, hz)| a * libm::sin(turn(*hz) * t)).sum();
    let ddq = sines.iter().map(|(a, hz)| -a * turn(*hz) * turn(*hz) * libm::sin(turn(*hz) * t)).sum();
    (q, ddq)
}

/// The rows (ddq, sin q), with ddq divided by the scale of the picture.
fn rows(sines: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let states = (0..INSTANTS).map(|i| state(sines, STEP_S * f64::from(i)));
    states.map(|(q, ddq)| (ddq / ACCELERATION_SCALE, libm::sin(q))).collect()
}

/// Points of the ellipse z' (W'W) z = level around the origin. `rows`: the rows of W.
fn ellipse(rows: &[(f64, f64)], level: f64) -> Vec<(f64, f64)> {
    let sum = |f: &dyn Fn(&(f64, f64)) -> f64| rows.iter().map(f).sum::<f64>();
    let (aa, ab, bb) = (sum(&|r| r.0 * r.0), sum(&|r| r.0 * r.1), sum(&|r| r.1 * r.1));
    // The eigenvalues of [[aa, ab], [ab, bb]], and the angle of the first eigenvector.
    let (mean, half) = ((aa + bb) / 2.0, libm::hypot((aa - bb) / 2.0, ab));
    let angle = 0.5 * libm::atan2(2.0 * ab, aa - bb);
    let axes = [mean + half, mean - half].map(|x| libm::sqrt(level / x.max(1e-9)));
    let point = |i: i32| {
        let turn = std::f64::consts::TAU * f64::from(i) / f64::from(ELLIPSE_POINTS);
        let (u, v) = (axes[0] * libm::cos(turn), axes[1] * libm::sin(turn));
        (u * libm::cos(angle) - v * libm::sin(angle), u * libm::sin(angle) + v * libm::cos(angle))
    };
    (0..=ELLIPSE_POINTS).map(point).collect()
}

pub(crate) fn draw() -> Result<String, String> {
    let title =
        "Rows of a poor and of a rich motion of a pendulum, and the uncertainty of its two parameters with each";
    let mut canvas = Canvas::new(760.0, 470.0, title);
    let motions: [(&str, &[(f64, f64)]); 2] =
        [("one slow swing", &[(1.4, 0.5)]), ("two frequencies", &[(0.9, 0.5), (0.35, 1.5)])];
    for (k, (name, sines)) in motions.into_iter().enumerate() {
        let x = 20.0 + 380.0 * k as f64;
        // The upper half of the picture: the rows (ddq, sin q) of the motion.
        canvas.heading((x, 28.0), name);
        let (middle, left) = (135.0, x + 165.0);
        canvas.line((left - 150.0, middle), (left + 150.0, middle), Ink::Faint, 1.0);
        canvas.line((left, middle - 90.0), (left, middle + 90.0), Ink::Faint, 1.0);
        let rows = rows(sines);
        for (a, b) in &rows {
            canvas.dot((left + 140.0 * a, middle - 85.0 * b), 2.2, Ink::Blue);
        }
        canvas.words((left + 150.0, middle - 6.0), Anchor::End, Ink::Word, "ddq");
        canvas.words((left + 6.0, middle - 80.0), Anchor::Start, Ink::Word, "sin q");
        // The lower half of the picture: the uncertainty ellipse of (J, k).
        let below = 355.0;
        let within = |z: (f64, f64)| (left + 26.0 * z.0, below - 26.0 * z.1);
        let around: Vec<(f64, f64)> = ellipse(&rows, ELLIPSE_LEVEL).into_iter().map(within).collect();
        canvas.line((left - 150.0, below), (left + 150.0, below), Ink::Faint, 1.0);
        canvas.line((left, below - 90.0), (left, below + 90.0), Ink::Faint, 1.0);
        canvas.path(&around, Ink::Orange, 2.0);
        canvas.words((left + 150.0, below - 6.0), Anchor::End, Ink::Word, "J");
        canvas.words((left + 6.0, below - 80.0), Anchor::Start, Ink::Word, "k");
    }
    canvas.words((20.0, 246.0), Anchor::Start, Ink::Blue, "each dot: a row of the equations, one instant");
    canvas.words(
        (20.0, 462.0),
        Anchor::Start,
        Ink::Orange,
        "the same noise gives a long ellipse: J and k are correlated",
    );
    Ok(canvas.finish())
}
