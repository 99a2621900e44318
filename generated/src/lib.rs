//! Regressors of known robots, written by `cargo xtask gen`, compiled once.
//!
//! `robots/` is machine-owned: one file a robot, none of which needs any other. This shell gives all
//! of them one face.

#![no_std]

#[rustfmt::skip]
pub mod robots;

/// The compiled base regressor of one robot: tau = Y(q, dq, ddq) X.
#[derive(Clone, Copy, Debug)]
pub struct Compiled {
    pub name: &'static str,
    /// In the order of q.
    pub coordinates: &'static [&'static str],
    /// The base parameters, in the order of the columns of Y.
    pub parameters: &'static [&'static str],
    /// Tells this function from that of any other robot or geometry: `expr::Function::fingerprint`.
    pub fingerprint: u64,
    fill: Fill,
}

/// q, dq, ddq -> y; false when a length is wrong.
type Fill = fn(&[f64], &[f64], &[f64], &mut [f64]) -> bool;

impl Compiled {
    /// Writes Y, row by row: `y[i * p + c]`. False, and nothing written, when a length is wrong: n
    /// for q, dq and ddq, n p for y.
    #[must_use]
    pub fn fill(&self, q: &[f64], dq: &[f64], ddq: &[f64], y: &mut [f64]) -> bool {
        (self.fill)(q, dq, ddq, y)
    }
}

/// All compiled robots, by name.
pub fn all() -> &'static [Compiled] {
    robots::ALL
}

/// The compiled robot with this fingerprint.
pub fn find(fingerprint: u64) -> Option<&'static Compiled> {
    robots::ALL.iter().find(|c| c.fingerprint == fingerprint)
}

/// The table of the robots of these modules.
macro_rules! compiled {
    ($($robot:ident),* $(,)?) => {
        pub const ALL: &[$crate::Compiled] = &[$($crate::Compiled {
            name: $robot::NAME,
            coordinates: &$robot::COORDINATES,
            parameters: &$robot::PARAMETERS,
            fingerprint: $robot::FINGERPRINT,
            fill: {
                const N: usize = $robot::COORDINATES.len();
                const P: usize = $robot::PARAMETERS.len();
                fn fill(q: &[f64], dq: &[f64], ddq: &[f64], y: &mut [f64]) -> bool {
                    let (Ok(q), Ok(dq), Ok(ddq)) = (q.try_into(), dq.try_into(), ddq.try_into()) else { return false };
                    let (rows, rest) = y.as_chunks_mut::<P>();
                    let (Ok(rows), true) = (<&mut [[f64; P]; N]>::try_from(rows), rest.is_empty()) else { return false };
                    $robot::base_regressor(q, dq, ddq, rows);
                    true
                }
                fill
            },
        }),*];
    };
}
pub(crate) use compiled;
