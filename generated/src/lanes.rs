//! Lanes: the numbers of several samples in one vector register, for the generated functions to
//! compute with. No multiplication is fused with an addition, so that a lane holds, bit for bit,
//! what f64 gives; sine and cosine are those of the generated files.
//!
//! All `unsafe` of this package is here. What makes it sound: only [`kernel`]'s two functions make
//! lanes, they are compiled for the instructions used, and they are called where the processor has
//! them.

#![allow(unsafe_code, reason = "vector registers")]

use core::arch::x86_64::*;
use core::ops::{Add, Div, Mul, Neg, Sub};

macro_rules! lanes {
    ($(#[$doc:meta])* $lanes:ident($vector:ident) = [f64; $width:literal], $splat:ident,
     $($operator:ident $method:ident $instruction:ident),*) => {
        $(#[$doc])*
        #[derive(Clone, Copy)]
        #[repr(transparent)]
        pub struct $lanes(pub(crate) $vector);

        $(impl $operator for $lanes {
            type Output = $lanes;
            #[inline(always)]
            fn $method(self, other: $lanes) -> $lanes {
                unsafe { $lanes($instruction(self.0, other.0)) }
            }
        })*

        impl $lanes {
            pub const WIDTH: usize = $width;

            #[inline(always)]
            pub fn splat(x: f64) -> $lanes {
                unsafe { $lanes($splat(x)) }
            }

            /// `states[0]`, `states[stride]`, ...
            #[inline(always)]
            pub fn gathered(states: &[f64], stride: usize) -> $lanes {
                let mut numbers = [0.0; $width];
                for lane in 0..$width {
                    numbers[lane] = states[lane * stride];
                }
                unsafe { core::mem::transmute::<[f64; $width], $lanes>(numbers) }
            }

            /// The numbers of each entry.
            #[inline(always)]
            pub fn entries(lanes: &[$lanes]) -> &[f64] {
                // SAFETY: a register is $width numbers and nothing else.
                unsafe { core::slice::from_raw_parts(lanes.as_ptr().cast(), lanes.len() * $width) }
            }

            /// As `f64::sin_cos` of the generated files.
            #[inline(always)]
            pub fn sin_cos(self) -> ($lanes, $lanes) {
                let k = $lanes::splat;
                let round = k(6755399441055744.0);
                let turns = self * k(core::f64::consts::FRAC_2_PI) + round;
                let n = turns - round;
                let x = ((self - n * k(1.570796251296997)) - n * k(7.549789415861596e-8)) - n * k(5.390302858158119e-15);
                let reach = self * k(1.3393857589828342e300);
                let x = x * (k(1.0) + k(0.0) * reach);
                let z = x * x;
                let s = k(-2.5050760253406863e-8) + z * k(1.58969099521155e-10);
                let s = k(-1.984126982985795e-4) + z * (k(2.7557313707070068e-6) + z * s);
                let s = x + x * z * (k(-1.6666666666666632e-1) + z * (k(8.33333333332249e-3) + z * s));
                let c = k(2.087572321298175e-9) + z * k(-1.1359647557788195e-11);
                let c = k(2.480158728947673e-5) + z * (k(-2.7557314351390663e-7) + z * c);
                let c = k(4.16666666666666e-2) + z * (k(-1.388888888887411e-3) + z * c);
                let c = k(1.0) - k(0.5) * z + z * z * c;
                s.turned(c, turns)
            }
        }

        impl Neg for $lanes {
            type Output = $lanes;
            #[inline(always)]
            fn neg(self) -> $lanes {
                self.with_signs_of($lanes::splat(-0.0))
            }
        }
    };
}

lanes! {
    /// Four samples: AVX2.
    Lanes4(__m256d) = [f64; 4], _mm256_set1_pd,
    Add add _mm256_add_pd, Sub sub _mm256_sub_pd, Mul mul _mm256_mul_pd, Div div _mm256_div_pd
}
lanes! {
    /// Eight samples: AVX-512.
    Lanes8(__m512d) = [f64; 8], _mm512_set1_pd,
    Add add _mm512_add_pd, Sub sub _mm512_sub_pd, Mul mul _mm512_mul_pd, Div div _mm512_div_pd
}

impl Lanes4 {
    /// Sine and cosine in the quadrant of `turns`, from those in the first, `self` and `c`: bit 0
    /// exchanges them, bit 1 of the quadrant and of the next are their signs.
    #[inline(always)]
    fn turned(self, c: Lanes4, turns: Lanes4) -> (Lanes4, Lanes4) {
        unsafe {
            let quadrant = _mm256_castpd_si256(turns.0);
            let odd = _mm256_castsi256_pd(_mm256_slli_epi64::<63>(quadrant));
            let sign =
                |q| Lanes4(_mm256_castsi256_pd(_mm256_slli_epi64::<62>(_mm256_and_si256(q, _mm256_set1_epi64x(2)))));
            let next = _mm256_add_epi64(quadrant, _mm256_set1_epi64x(1));
            let (s, c) = (_mm256_blendv_pd(self.0, c.0, odd), _mm256_blendv_pd(c.0, self.0, odd));
            (Lanes4(s).with_signs_of(sign(quadrant)), Lanes4(c).with_signs_of(sign(next)))
        }
    }

    #[inline(always)]
    fn with_signs_of(self, signs: Lanes4) -> Lanes4 {
        unsafe { Lanes4(_mm256_xor_pd(self.0, signs.0)) }
    }
}

impl Lanes8 {
    /// As [`Lanes4::turned`].
    #[inline(always)]
    fn turned(self, c: Lanes8, turns: Lanes8) -> (Lanes8, Lanes8) {
        unsafe {
            let quadrant = _mm512_castpd_si512(turns.0);
            let odd = _mm512_test_epi64_mask(quadrant, _mm512_set1_epi64(1));
            let sign =
                |q| Lanes8(_mm512_castsi512_pd(_mm512_slli_epi64::<62>(_mm512_and_si512(q, _mm512_set1_epi64(2)))));
            let next = _mm512_add_epi64(quadrant, _mm512_set1_epi64(1));
            let (s, c) = (_mm512_mask_blend_pd(odd, self.0, c.0), _mm512_mask_blend_pd(odd, c.0, self.0));
            (Lanes8(s).with_signs_of(sign(quadrant)), Lanes8(c).with_signs_of(sign(next)))
        }
    }

    #[inline(always)]
    fn with_signs_of(self, signs: Lanes8) -> Lanes8 {
        let bits = |x: Lanes8| unsafe { _mm512_castpd_si512(x.0) };
        unsafe { Lanes8(_mm512_castsi512_pd(_mm512_xor_si512(bits(self), bits(signs)))) }
    }
}

/// Entry after entry, each of `lanes` samples -> sample after sample. Needs AVX.
#[inline(always)]
pub fn scatter(entries: &[f64], lanes: usize, samples: &mut [f64]) {
    let size = entries.len() / lanes;
    assert!(lanes.is_multiple_of(4) && entries.len() == size * lanes && samples.len() == entries.len());
    let (from, to) = (entries.as_ptr(), samples.as_mut_ptr());
    for lane in (0..lanes).step_by(4) {
        for k in (0..size / 4 * 4).step_by(4) {
            // SAFETY: k + 3 < size and lane + 3 < lanes.
            unsafe {
                let row = |i: usize| _mm256_loadu_pd(from.add((k + i) * lanes + lane));
                let (a, b, c, d) = (row(0), row(1), row(2), row(3));
                let (ab0, ab1) = (_mm256_unpacklo_pd(a, b), _mm256_unpackhi_pd(a, b));
                let (cd0, cd1) = (_mm256_unpacklo_pd(c, d), _mm256_unpackhi_pd(c, d));
                let place = |l: usize| to.add((lane + l) * size + k);
                _mm256_storeu_pd(place(0), _mm256_permute2f128_pd::<0x20>(ab0, cd0));
                _mm256_storeu_pd(place(1), _mm256_permute2f128_pd::<0x20>(ab1, cd1));
                _mm256_storeu_pd(place(2), _mm256_permute2f128_pd::<0x31>(ab0, cd0));
                _mm256_storeu_pd(place(3), _mm256_permute2f128_pd::<0x31>(ab1, cd1));
            }
        }
        for k in size / 4 * 4..size {
            for l in lane..lane + 4 {
                samples[l * size + k] = entries[k * lanes + l];
            }
        }
    }
}

/// A function states, y -> number of samples done: as many as fill whole lanes.
macro_rules! kernel {
    ($robot:ident, $n:ident, $p:ident) => {{
        #[target_feature(enable = "avx2")]
        fn four(states: &[f64], y: &mut [f64]) -> usize {
            $crate::lanes::body!($robot, $n, $p, Lanes4, states, y)
        }
        #[target_feature(enable = "avx512f")]
        fn eight(states: &[f64], y: &mut [f64]) -> usize {
            $crate::lanes::body!($robot, $n, $p, Lanes8, states, y)
        }
        #[allow(unsafe_code, reason = "the processor has been asked")]
        fn kernel(states: &[f64], y: &mut [f64]) -> usize {
            // SAFETY: each is called where the processor has what it is compiled for.
            let (mut done, has_avx2) = (0, std::is_x86_feature_detected!("avx2"));
            if has_avx2 && std::is_x86_feature_detected!("avx512f") {
                done = unsafe { eight(states, y) };
            }
            if has_avx2 {
                done += unsafe { four(&states[3 * $n * done..], &mut y[$n * $p * done..]) };
            }
            done
        }
        kernel
    }};
}
pub(crate) use kernel;

/// One sample: the scalar function in the processor's three-operand instructions where it has them; the
/// same operations in the same order, and so the same bits.
macro_rules! scalar {
    ($robot:ident, $n:expr, $p:expr) => {{
        #[target_feature(enable = "avx2")]
        fn wide(q: &[f64; $n], dq: &[f64; $n], ddq: &[f64; $n], y: &mut [[f64; $p]; $n]) {
            $robot::base_regressor(q, dq, ddq, y);
        }

        #[allow(unsafe_code, reason = "the processor has been asked")]
        fn fill(q: &[f64; $n], dq: &[f64; $n], ddq: &[f64; $n], y: &mut [[f64; $p]; $n]) {
            if std::is_x86_feature_detected!("avx2") {
                unsafe { wide(q, dq, ddq, y) }
            } else {
                $robot::base_regressor(q, dq, ddq, y);
            }
        }
        fill
    }};
}
pub(crate) use scalar;

macro_rules! body {
    ($robot:ident, $n:ident, $p:ident, $lanes:ident, $states:ident, $y:ident) => {{
        use $crate::lanes::$lanes as Lanes;
        const W: usize = Lanes::WIDTH;
        let mut inputs = [[Lanes::splat(0.0); $n]; 3];
        let mut out = [[Lanes::splat(0.0); $p]; $n];
        let mut done = 0;
        for (states, y) in $states.chunks_exact(3 * $n * W).zip($y.chunks_exact_mut($n * $p * W)) {
            for i in 0..3 * $n {
                inputs[i / $n][i % $n] = Lanes::gathered(&states[i..], 3 * $n);
            }
            $robot::base_regressor(&inputs[0], &inputs[1], &inputs[2], &mut out);
            $crate::lanes::scatter(Lanes::entries(out.as_flattened()), W, y);
            done += W;
        }
        done
    }};
}
pub(crate) use body;

/// Lets a robot's file compute with lanes; `sqrt` where its `Real` has it.
macro_rules! real {
    ($robot:ident $($sqrt:ident)?) => {
        $crate::lanes::real!(@ $robot Lanes4 _mm256_sqrt_pd $($sqrt)?);
        $crate::lanes::real!(@ $robot Lanes8 _mm512_sqrt_pd $($sqrt)?);
    };
    (@ $robot:ident $lanes:ident $instruction:ident $($sqrt:ident)?) => {
        impl $robot::Real for $crate::lanes::$lanes {
            #[inline(always)]
            fn from_f64(x: f64) -> Self {
                Self::splat(x)
            }
            #[inline(always)]
            fn sin_cos(self) -> (Self, Self) {
                self.sin_cos()
            }
            $(#[inline(always)]
            #[allow(unsafe_code, reason = "vector registers")]
            fn $sqrt(self) -> Self {
                unsafe { Self(core::arch::x86_64::$instruction(self.0)) }
            })?
        }
    };
}
pub(crate) use real;
