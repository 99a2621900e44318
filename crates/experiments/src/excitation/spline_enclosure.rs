//! Proved bounds of a quintic spline and its derivatives on an interval of time.
//!
//! The k-th derivative is a spline of degree p = 5 - k on the same knots t_i (in spans; K spans in T seconds). Its control points
//! Q give the control points Q' of the next derivative, k + 1:
//!
//! Q_i' = p (Q_{i+1} - Q_i) / (t_{i+6} - t_{i+k+1}) K/T   [Piegl, Tiller 1997, section 3.3]
//!
//! On an interval [a, b] inside a span, the derivative is between the least and the greatest of its p + 1 control points on [a,
//! b], which knot insertion gives. Control point j (0 to p) is the polar form with p - j arguments a and j arguments b
//! [Ramshaw 1989]. All computations use interval arithmetic.

use numerics::interval::Interval;

use crate::excitation::quintic_spline::{QuinticSpline, SPLINE_DEGREE};

/// A spline motion with precomputed data for enclosures of its positions and derivatives.
pub struct EnclosedSpline {
    shape: QuinticSpline,
    /// Number of spans per second K/T, 1/s: K spans in T seconds.
    rate: Interval,
    /// For each coordinate, the control points of its position and of its first four time derivatives.
    joints: Vec<[Vec<Interval>; 5]>,
}

impl EnclosedSpline {
    /// Precomputes the data for enclosures. `joints`: coefficients (c, d_1, d_2, ..) of each coordinate: centre, then control
    /// points minus centre.
    pub fn new(shape: QuinticSpline, joints: &[Vec<f64>]) -> EnclosedSpline {
        let rate = Interval::point(shape.spans as f64).over(Interval::point(shape.period));
        let joints = joints.iter().map(|x| {
            let rest = Interval::point(x[0]);
            let moved = x[1..].iter().map(|d| rest + Interval::point(*d));
            let mut points: Vec<Interval> = [rest; 3].into_iter().chain(moved).chain([rest; 3]).collect();
            std::array::from_fn(|k| {
                let next = points.windows(2).enumerate().map(|(i, p)| {
                    let width = shape.knot(i + SPLINE_DEGREE + 1) - shape.knot(i + k + 1);
                    ((p[1] - p[0]) * (SPLINE_DEGREE - k) as f64).over(Interval::point(width)) * rate
                });
                let next = next.collect();
                std::mem::replace(&mut points, next)
            })
        });
        EnclosedSpline { shape, rate, joints: joints.collect() }
    }

    /// Encloses position and first four derivatives of each coordinate on the time interval `part` of the spline, s.
    pub fn on(&self, part: Interval) -> Vec<[Interval; 5]> {
        let spans = self.shape.spans;
        let [from, to] = [part.low, part.high].map(|t| Interval::point(t) * self.rate);
        // Rounding may put an end of the interval into the neighbouring span, so that span is covered too.
        let [first, last] = [from.low, to.high].map(|u| (u.max(0.0) as usize).min(spans.saturating_sub(1)));
        let of = |points: &[Vec<Interval>; 5]| -> [Interval; 5] {
            std::array::from_fn(|k| {
                let on_span = |span: usize| {
                    let within = |u: Interval| {
                        let [low, high] = [u.low, u.high].map(|u| u.clamp(span as f64, (span + 1) as f64));
                        Interval::new(low, high)
                    };
                    self.restricted(&points[k], SPLINE_DEGREE - k, span, within(from), within(to))
                };
                (first..=last).map(on_span).reduce(Interval::hull).unwrap_or(Interval::ALL)
            })
        };
        self.joints.iter().map(of).collect()
    }

    /// Hull of the control points of a spline of degree `degree` after restriction to the interval from a to b (in spans), which
    /// lies inside span number `span`.
    fn restricted(&self, points: &[Interval], degree: usize, span: usize, a: Interval, b: Interval) -> Interval {
        let polar = |j: usize| {
            let mut left = points[span..=span + degree].to_vec();
            for step in 1..=degree {
                let u = if step <= j { b } else { a };
                let between = |(i, p): (usize, &[Interval])| {
                    let (before, after) = (
                        self.shape.knot(span + SPLINE_DEGREE - degree + step + i),
                        self.shape.knot(span + SPLINE_DEGREE + 1 + i),
                    );
                    let share = (u - Interval::point(before)).over(Interval::point(after - before));
                    p[0] + (p[1] - p[0]) * share
                };
                left = left.windows(2).enumerate().map(between).collect();
            }
            left[0]
        };
        // If a equals b, all control points are equal, so one suffices.
        let last = if a == b { 0 } else { degree };
        (0..=last).map(polar).reduce(Interval::hull).unwrap_or(Interval::ALL)
    }
}
