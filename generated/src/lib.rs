//! Regressors of known robots, written by `cargo xtask gen`, compiled once.
//!
//! `robots/` is machine-owned: one file a robot, none of which needs any other. This shell gives all
//! of them one face.

#![no_std]

#[cfg(feature = "std")]
extern crate std;

#[cfg(all(feature = "std", target_arch = "x86_64"))]
mod lanes;
/// Without lanes: every sample is done by the scalar function.
#[cfg(not(all(feature = "std", target_arch = "x86_64")))]
mod lanes {
    macro_rules! kernel {
        ($($_:tt)*) => {
            |_, _| 0
        };
    }
    macro_rules! real {
        ($($_:tt)*) => {};
    }
    macro_rules! scalar {
        ($robot:ident, $n:expr, $p:expr) => {
            $robot::base_regressor::<f64>
        };
    }
    pub(crate) use {kernel, real, scalar};
}
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
    fill_lanes: FillLanes,
}

/// q, dq, ddq -> y; false when a length is wrong.
type Fill = fn(&[f64], &[f64], &[f64], &mut [f64]) -> bool;

/// States and y, both sample after sample -> the number of samples done, from the first; the rest,
/// less than the lanes of the processor, is left.
type FillLanes = fn(&[f64], &mut [f64]) -> usize;

impl Compiled {
    /// Writes Y, row by row: `y[i * p + c]`. False, and nothing written, when a length is wrong: n
    /// for q, dq and ddq, n p for y.
    #[must_use]
    pub fn fill(&self, q: &[f64], dq: &[f64], ddq: &[f64], y: &mut [f64]) -> bool {
        (self.fill)(q, dq, ddq, y)
    }

    /// Writes Y of many samples, one after the other as `fill` writes it, and bit for bit as `fill`
    /// does: `states` holds q, dq, ddq of one sample after the other. Several samples at a time where
    /// the processor can (the feature `std` asks it). False, and nothing written, when a length is
    /// wrong.
    #[must_use]
    pub fn fill_many(&self, states: &[f64], y: &mut [f64]) -> bool {
        let n = self.coordinates.len();
        let size = n * self.parameters.len();
        if size == 0 {
            return y.is_empty();
        }
        let samples = y.len() / size;
        if y.len() != samples * size || states.len() != samples * 3 * n {
            return false;
        }
        let done = (self.fill_lanes)(states, y);
        let rest = states.chunks_exact(3 * n).zip(y.chunks_exact_mut(size)).skip(done);
        rest.into_iter().all(|(s, y)| self.fill(&s[..n], &s[n..2 * n], &s[2 * n..], y))
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

/// The table of the robots of these modules; `(sqrt)` after one whose functions take roots.
macro_rules! compiled {
    ($($robot:ident $(($sqrt:ident))?),* $(,)?) => {
        $($crate::lanes::real!($robot $($sqrt)?);)*

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
                    $crate::lanes::scalar!($robot, N, P)(q, dq, ddq, rows);
                    true
                }
                fill
            },
            fill_lanes: {
                const N: usize = $robot::COORDINATES.len();
                const P: usize = $robot::PARAMETERS.len();
                $crate::lanes::kernel!($robot, N, P)
            },
        }),*];
    };
}
pub(crate) use compiled;
