//! Why a motion must be rich: a pendulum, tau = J ddq + k sin q, twice.
//!
//! Each instant is a point (ddq, sin q): a row of W. A slow swing of one frequency has ddq = -w^2 q, so that the rows almost lie
//! on a line and little more than one combination of J and k is told. The ellipse is what the same noise leaves: z' (W'W) z = const.

use super::canvas::{Anchor, Canvas, Ink};

/// The level of the ellipses: noise that makes the longer one as wide as its picture.
const NOISE: f64 = 2.1;

/// Position, rad, and acceleration, rad/s^2, of a sum of sines (amplitude, Hz) at t, s.
fn state(sines: &[(f64, f64)], t: f64) -> (f64, f64) {
    let turn = |hz: f64| std::f64::consts::TAU * hz;
    let q = sines.iter().map(|(a, hz)| a * libm::sin(turn(*hz) * t)).sum();
    let ddq = sines.iter().map(|(a, hz)| -a * turn(*hz) * turn(*hz) * libm::sin(turn(*hz) * t)).sum();
    (q, ddq)
}

/// Rows (ddq, sin q), each column over its scale.
fn rows(sines: &[(f64, f64)]) -> Vec<(f64, f64)> {
    (0..160).map(|i| state(sines, 0.025 * f64::from(i))).map(|(q, ddq)| (ddq / 40.0, libm::sin(q))).collect()
}

/// Points of the ellipse z' F z = level about the origin.
fn ellipse(rows: &[(f64, f64)], level: f64) -> Vec<(f64, f64)> {
    let sum = |f: &dyn Fn(&(f64, f64)) -> f64| rows.iter().map(f).sum::<f64>();
    let (aa, ab, bb) = (sum(&|r| r.0 * r.0), sum(&|r| r.0 * r.1), sum(&|r| r.1 * r.1));
    // Eigenvalues of [[aa, ab], [ab, bb]], and the angle of the first direction.
    let (mean, half) = ((aa + bb) / 2.0, libm::hypot((aa - bb) / 2.0, ab));
    let angle = 0.5 * libm::atan2(2.0 * ab, aa - bb);
    let axes = [mean + half, mean - half].map(|x| libm::sqrt(level / x.max(1e-9)));
    let point = |i: i32| {
        let turn = std::f64::consts::TAU * f64::from(i) / 72.0;
        let (u, v) = (axes[0] * libm::cos(turn), axes[1] * libm::sin(turn));
        (u * libm::cos(angle) - v * libm::sin(angle), u * libm::sin(angle) + v * libm::cos(angle))
    };
    (0..=72).map(point).collect()
}

pub(crate) fn draw() -> Result<String, String> {
    let title = "Rows of a poor and of a rich motion of a pendulum, and what each leaves open of its two parameters";
    let mut canvas = Canvas::new(760.0, 470.0, title);
    let motions: [(&str, &[(f64, f64)]); 2] =
        [("one slow swing", &[(1.4, 0.5)]), ("two frequencies", &[(0.9, 0.5), (0.35, 1.5)])];
    for (k, (name, sines)) in motions.into_iter().enumerate() {
        let x = 20.0 + 380.0 * k as f64;
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
        let below = 355.0;
        let within = |z: (f64, f64)| (left + 26.0 * z.0, below - 26.0 * z.1);
        let around: Vec<(f64, f64)> = ellipse(&rows, NOISE).into_iter().map(within).collect();
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
        "what the same noise leaves open: along a long ellipse, J and k trade against each other",
    );
    Ok(canvas.finish())
}
