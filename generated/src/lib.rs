//! Regressors of known robots, written by `cargo xtask gen`, compiled once.
//!
//! `robots/` is generated: one file per robot, which needs no other file. This crate gives all robots one interface.

#![no_std]

#[cfg(feature = "std")]
extern crate std;

#[cfg(all(feature = "std", target_arch = "x86_64"))]
mod lanes;
/// Without lanes, the scalar function computes every sample.
#[cfg(not(all(feature = "std", target_arch = "x86_64")))]
mod lanes {
    macro_rules! eight {
        ($robot:ident, $n:ident, $e:ident) => {{
            fn eight(_: &[f64], _: &mut [$crate::Eight]) -> bool {
                const { $n + $e == 0 }
            }
            eight
        }};
    }
    macro_rules! real {
        ($($_:tt)*) => {};
    }
    macro_rules! scalar {
        ($robot:ident, $function:ident, $n:expr, $y:ty) => {{
            let one: fn(&[f64; $n], &[f64; $n], &[f64; $n], &mut $y) = $robot::$function;
            one
        }};
    }
    pub(crate) use {eight, real, scalar};

    pub(crate) fn scatter(entries: &[crate::Eight], places: impl Fn(usize) -> usize, size: usize, samples: &mut [f64]) {
        for (k, eight) in entries.iter().enumerate() {
            for l in 0..8 {
                samples[l * size + places(k)] = eight.0[l];
            }
        }
    }
}
#[rustfmt::skip]
#[allow(clippy::too_many_lines, reason = "straight lines that a machine wrote")]
pub mod robots;

/// One number of each of eight samples, with the layout of a vector register.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(64))]
pub struct Eight(pub [f64; 8]);

/// The compiled base regressor of one robot: tau = Y(q, dq, ddq) X.
#[derive(Clone, Copy, Debug)]
pub struct Compiled {
    pub name: &'static str,
    /// Names of the coordinates, in the order of q.
    pub coordinates: &'static [&'static str],
    /// The base parameters, in the order of the columns of Y.
    pub parameters: &'static [&'static str],
    /// Row and column of each entry of Y that is not always zero, row by row.
    pub non_zeros: &'static [(usize, usize)],
    /// Identifies the function of this robot and geometry: `expr::Function::fingerprint`.
    pub fingerprint: u64,
    fill: Fill,
    fill_non_zeros: Fill,
    fill_eight: FillEight,
}

/// q, dq, ddq -> y; false when a length is wrong.
type Fill = fn(&[f64], &[f64], &[f64], &mut [f64]) -> bool;

/// Eight states -> the entries that are not always zero; false where the processor has no lanes.
type FillEight = fn(&[f64], &mut [Eight]) -> bool;

impl Compiled {
    /// Writes Y, row by row: `y[i * p + c]`. False, and nothing written, when a length is wrong: n
    /// for q, dq and ddq, n p for y.
    #[must_use]
    pub fn fill(&self, q: &[f64], dq: &[f64], ddq: &[f64], y: &mut [f64]) -> bool {
        (self.fill)(q, dq, ddq, y)
    }

    /// Writes the entries of Y that are not always zero, in the order of `non_zeros`. False, and nothing written, when
    /// a length is wrong.
    #[must_use]
    pub fn fill_non_zeros(&self, q: &[f64], dq: &[f64], ddq: &[f64], entries: &mut [f64]) -> bool {
        (self.fill_non_zeros)(q, dq, ddq, entries)
    }

    /// Writes the entries of Y of eight samples, in the order of `non_zeros` and bit for bit as `fill` does: `states` holds
    /// q, dq, ddq of one sample after the other. Several samples are computed at a time where the processor can, if the
    /// feature `std` is on, which is needed to detect it. False, and nothing written, when a length is wrong.
    #[must_use]
    pub fn fill_eight(&self, states: &[f64], entries: &mut [Eight]) -> bool {
        let n = self.coordinates.len();
        if states.len() != 8 * 3 * n || entries.len() != self.non_zeros.len() {
            return false;
        }
        if (self.fill_eight)(states, entries) {
            return true;
        }
        let mut one = [0.0; MAX_ENTRIES];
        let Some(one) = one.get_mut(..entries.len()) else { return false };
        for (l, s) in states.chunks_exact(3 * n).enumerate() {
            if !self.fill_non_zeros(&s[..n], &s[n..2 * n], &s[2 * n..], one) {
                return false;
            }
            for (eight, x) in entries.iter_mut().zip(&*one) {
                eight.0[l] = *x;
            }
        }
        true
    }

    /// Writes Y of many samples, one after the other, bit for bit as `fill` writes it. `states` holds q, dq, ddq of one
    /// sample after the other. False, and nothing written, when a length is wrong. `fill_eight` is faster for callers
    /// that can use the entries eight samples at a time, without the zeros: more than half of the time here goes into
    /// putting the entries in their places.
    #[must_use]
    pub fn fill_many(&self, states: &[f64], y: &mut [f64]) -> bool {
        let (n, p) = (self.coordinates.len(), self.parameters.len());
        let size = n * p;
        if size == 0 {
            return y.is_empty();
        }
        let samples = y.len() / size;
        if y.len() != samples * size || states.len() != samples * 3 * n {
            return false;
        }
        let done = if samples < 8 { 0 } else { self.fill_eights(states, y) };
        let rest = states.chunks_exact(3 * n).zip(y.chunks_exact_mut(size)).skip(done);
        rest.into_iter().all(|(s, y)| self.fill(&s[..n], &s[n..2 * n], &s[2 * n..], y))
    }

    /// Writes Y of samples in groups of eight; returns how many it wrote.
    fn fill_eights(&self, states: &[f64], y: &mut [f64]) -> usize {
        let (n, p) = (self.coordinates.len(), self.parameters.len());
        let mut entries = [Eight::default(); MAX_ENTRIES];
        let Some(entries) = entries.get_mut(..self.non_zeros.len()) else { return 0 };
        let place = |k: usize| self.non_zeros[k].0 * p + self.non_zeros[k].1;
        let mut done = 0;
        for (states, y) in states.chunks_exact(8 * 3 * n).zip(y.chunks_exact_mut(8 * n * p)) {
            if !self.fill_eight(states, entries) {
                return done;
            }
            y.fill(0.0);
            lanes::scatter(entries, place, n * p, y);
            done += 8;
        }
        done
    }
}

/// The largest number of entries that are not always zero, over all robots.
const MAX_ENTRIES: usize = {
    let (mut most, mut k) = (0, 0);
    while k < robots::ALL.len() {
        if robots::ALL[k].non_zeros.len() > most {
            most = robots::ALL[k].non_zeros.len();
        }
        k += 1;
    }
    most
};

/// All compiled robots, by name.
pub fn all() -> &'static [Compiled] {
    robots::ALL
}

/// The compiled robot with this fingerprint.
pub fn find(fingerprint: u64) -> Option<&'static Compiled> {
    robots::ALL.iter().find(|c| c.fingerprint == fingerprint)
}

/// The table of the robots of these modules; `(sqrt)` follows a robot whose functions take roots.
macro_rules! compiled {
    ($($robot:ident $(($sqrt:ident))?),* $(,)?) => {
        $($crate::lanes::real!($robot $($sqrt)?);)*

        pub const ALL: &[$crate::Compiled] = &[$($crate::Compiled {
            name: $robot::NAME,
            coordinates: &$robot::COORDINATES,
            parameters: &$robot::PARAMETERS,
            non_zeros: &$robot::NON_ZEROS,
            fingerprint: $robot::FINGERPRINT,
            fill: {
                const N: usize = $robot::COORDINATES.len();
                const P: usize = $robot::PARAMETERS.len();
                fn fill(q: &[f64], dq: &[f64], ddq: &[f64], y: &mut [f64]) -> bool {
                    let (Ok(q), Ok(dq), Ok(ddq)) = (q.try_into(), dq.try_into(), ddq.try_into()) else { return false };
                    let (rows, rest) = y.as_chunks_mut::<P>();
                    let (Ok(rows), true) = (<&mut [[f64; P]; N]>::try_from(rows), rest.is_empty()) else { return false };
                    $crate::lanes::scalar!($robot, base_regressor, N, [[f64; P]; N])(q, dq, ddq, rows);
                    true
                }
                fill
            },
            fill_non_zeros: {
                const N: usize = $robot::COORDINATES.len();
                const E: usize = $robot::NON_ZEROS.len();
                fn fill(q: &[f64], dq: &[f64], ddq: &[f64], y: &mut [f64]) -> bool {
                    let (Ok(q), Ok(dq), Ok(ddq)) = (q.try_into(), dq.try_into(), ddq.try_into()) else { return false };
                    let Ok(entries) = <&mut [f64; E]>::try_from(y) else { return false };
                    $crate::lanes::scalar!($robot, base_regressor_non_zeros, N, [f64; E])(q, dq, ddq, entries);
                    true
                }
                fill
            },
            fill_eight: {
                const N: usize = $robot::COORDINATES.len();
                const E: usize = $robot::NON_ZEROS.len();
                $crate::lanes::eight!($robot, N, E)
            },
        }),*];
    };
}
pub(crate) use compiled;
