//! Draws how harmonics separate inertia, friction and centrifugal torque in one oscillation [Vandanjon, Gautier, Desbats 1995].
//!
//! The joint oscillates with an acceleration of constant magnitude. The bars are magnitudes of Fourier coefficients. For each
//! harmonic there are two: in phase with the velocity (cosine), and in phase with the acceleration (sine).

use super::canvas::{Anchor, Canvas, Ink};

const SAMPLES: usize = 720;
const HARMONICS: usize = 8;

/// Acceleration, velocity and position at sample `i` of an oscillation with period 4, whose acceleration alternates between +1
/// and -1. It starts at the largest velocity.
fn swing(i: usize) -> (f64, f64, f64) {
    let t = 4.0 * (i as f64 + 0.5) / SAMPLES as f64;
    match t {
        // The first half moves from the middle to one end and back, the second half to the other end and back.
        t if t < 2.0 => (-1.0, 1.0 - t, t - t * t / 2.0),
        t => (1.0, t - 3.0, -(t - 2.0) + (t - 2.0) * (t - 2.0) / 2.0),
    }
}

/// The Fourier coefficients (cosine, sine) of all harmonics of a signal.
fn parts(signal: &[f64]) -> Vec<(f64, f64)> {
    let one = |h: usize| {
        let turn = |i: usize| {
            std::f64::consts::TAU * (h * i) as f64 / SAMPLES as f64 + std::f64::consts::PI * h as f64 / SAMPLES as f64
        };
        let sum = |f: fn(f64) -> f64| signal.iter().enumerate().map(|(i, x)| x * f(turn(i))).sum::<f64>();
        let scale = 2.0 / SAMPLES as f64;
        (scale * sum(libm::cos), scale * sum(libm::sin))
    };
    (1..=HARMONICS).map(one).collect()
}

pub(crate) fn draw() -> Result<String, String> {
    let title = "Inertia, friction and centrifugal torque of a periodic swing, over time and by harmonic";
    let mut canvas = Canvas::new(760.0, 480.0, title);
    canvas.heading((20.0, 28.0), "over one period");
    canvas.heading((400.0, 28.0), "by harmonic of the swing: 1 to 8");
    // The signals in arbitrary units: inertia torque ~ ddq, friction torque ~ sign(dq), centrifugal torque ~ dq^2.
    let states: Vec<(f64, f64, f64)> = (0..SAMPLES).map(swing).collect();
    let signals: [(&str, Vec<f64>, Ink); 4] = [
        ("position", states.iter().map(|s| 1.8 * s.2).collect(), Ink::Faint),
        ("inertia: the acceleration", states.iter().map(|s| 0.9 * s.0).collect(), Ink::Blue),
        ("dry friction: the sign of the velocity", states.iter().map(|s| 0.9 * s.1.signum()).collect(), Ink::Orange),
        ("centrifugal: the velocity squared", states.iter().map(|s| 1.8 * s.1 * s.1 - 0.9).collect(), Ink::Green),
    ];
    for (k, (name, signal, ink)) in signals.iter().enumerate() {
        let middle = 95.0 + 100.0 * k as f64;
        canvas.words((20.0, middle - 38.0), Anchor::Start, Ink::Word, name);
        canvas.line((20.0, middle), (340.0, middle), Ink::Faint, 1.0);
        let point = |(i, x): (usize, &f64)| (20.0 + 320.0 * i as f64 / SAMPLES as f64, middle - 28.0 * x);
        canvas.path(&signal.iter().enumerate().map(point).collect::<Vec<_>>(), *ink, 2.0);
        // The position is not a torque, so its harmonics are not drawn.
        if k == 0 {
            continue;
        }
        canvas.line((400.0, middle), (740.0, middle), Ink::Faint, 1.0);
        for (h, (cosine, sine)) in parts(signal).into_iter().enumerate() {
            let x = 412.0 + 41.0 * h as f64;
            for (shift, part) in [(0.0, cosine), (13.0, sine)] {
                let height = 32.0 * part.abs();
                canvas.bar((x + shift, if part > 0.0 { middle - height } else { middle }), 10.0, height.max(0.8), *ink);
            }
            canvas.words((x + 11.0, middle + 58.0), Anchor::Middle, Ink::Faint, &(h + 1).to_string());
        }
    }
    canvas.words((400.0, 58.0), Anchor::Start, Ink::Word, "left bar: in phase with the cosine");
    canvas.words((400.0, 78.0), Anchor::Start, Ink::Word, "right bar: a quarter period off");
    canvas.words(
        (20.0, 470.0),
        Anchor::Start,
        Ink::Word,
        "inertia and friction: odd harmonics, a quarter period apart; centrifugal torque: even harmonics",
    );
    Ok(canvas.finish())
}
