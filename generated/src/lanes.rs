//! Lanes, the numbers with which the generated functions compute: several samples in one vector register, or one in a
//! scalar register. Every product that the generated file fuses with a sum is fused here by FMA. So a lane has, bit
//! for bit, the result of the scalar function and of the tape of crate `expr`. Sine and cosine equal the functions of the
//! generated files.
//!
//! All `unsafe` of this package is here. It is sound because only the functions of [`eight`] and [`scalar`] make lanes.
//! They are compiled for the instructions used, and called only where the processor has them.

#![allow(unsafe_code, reason = "vector registers")]

use core::arch::x86_64::*;
use core::ops::{Add, Div, Mul, Neg, Sub};

use crate::Eight;

macro_rules! lanes {
    ($(#[$doc:meta])* $lanes:ident($vector:ident), $splat:ident, $fused:ident,
     $($operator:ident $method:ident $instruction:ident),*) => {
        $(#[$doc])*
        #[derive(Clone, Copy)]
        #[repr(transparent)]
        pub(crate) struct $lanes(pub(crate) $vector);

        $(impl $operator for $lanes {
            type Output = $lanes;
            #[inline(always)]
            fn $method(self, other: $lanes) -> $lanes {
                unsafe { $lanes($instruction(self.0, other.0)) }
            }
        })*

        impl $lanes {
            #[inline(always)]
            pub(crate) fn splat(x: f64) -> $lanes {
                unsafe { $lanes($splat(x)) }
            }

            /// self b + c, rounded once.
            #[inline(always)]
            pub(crate) fn mul_add(self, b: $lanes, c: $lanes) -> $lanes {
                unsafe { $lanes($fused(self.0, b.0, c.0)) }
            }

            /// Sine and cosine of an angle, rad, by the operations of `f64::sin_cos` in the generated files.
            #[inline(always)]
            pub(crate) fn sin_cos(self) -> ($lanes, $lanes) {
                let k = $lanes::splat;
                // x = angle - n pi/2, with pi/2 in three parts; NaN for angles too large for them.
                let round = k(6755399441055744.0);
                let turns = self.mul_add(k(core::f64::consts::FRAC_2_PI), round);
                let n = -(turns - round);
                let x = n.mul_add(k(1.570796251296997), self);
                let x = n.mul_add(k(5.390302858158119e-15), n.mul_add(k(7.549789415861596e-8), x));
                let reach = self * k(1.3393857589828342e300);
                let x = x * k(0.0).mul_add(reach, k(1.0));
                // Minimax polynomials of fdlibm.
                let z = x * x;
                let s = z.mul_add(k(1.58969099521155e-10), k(-2.5050760253406863e-8));
                let s = z.mul_add(z.mul_add(s, k(2.7557313707070068e-6)), k(-1.984126982985795e-4));
                let s = z.mul_add(z.mul_add(s, k(8.33333333332249e-3)), k(-1.6666666666666632e-1));
                let s = (x * z).mul_add(s, x);
                let c = z.mul_add(k(-1.1359647557788195e-11), k(2.087572321298175e-9));
                let c = z.mul_add(z.mul_add(c, k(-2.7557314351390663e-7)), k(2.480158728947673e-5));
                let c = z.mul_add(z.mul_add(c, k(-1.388888888887411e-3)), k(4.16666666666666e-2));
                let c = (z * z).mul_add(c, k(-0.5).mul_add(z, k(1.0)));
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

/// The instructions of one lane.
mod one {
    macro_rules! one {
        ($($name:ident = |$($x:ident),*| $value:expr;)*) => {
            $(#[inline(always)]
            pub(super) unsafe fn $name($($x: f64),*) -> f64 {
                $value
            })*
        };
    }
    one! {
        same = |x| x;
        fused = |a, b, c| a.mul_add(b, c);
        add = |a, b| a + b;
        sub = |a, b| a - b;
        mul = |a, b| a * b;
        div = |a, b| a / b;
    }
}
use one::{add, div, fused, mul, same, sub};

lanes! {
    /// One sample: FMA.
    Lanes1(f64), same, fused,
    Add add add, Sub sub sub, Mul mul mul, Div div div
}
lanes! {
    /// Four samples: AVX2.
    Lanes4(__m256d), _mm256_set1_pd, _mm256_fmadd_pd,
    Add add _mm256_add_pd, Sub sub _mm256_sub_pd, Mul mul _mm256_mul_pd, Div div _mm256_div_pd
}
lanes! {
    /// Eight samples: AVX-512.
    Lanes8(__m512d), _mm512_set1_pd, _mm512_fmadd_pd,
    Add add _mm512_add_pd, Sub sub _mm512_sub_pd, Mul mul _mm512_mul_pd, Div div _mm512_div_pd
}

macro_rules! several {
    ($lanes:ident, $width:literal, $($i:literal)*) => {
        impl $lanes {
            /// Sines and cosines of up to eight angles, one after the other: a loop would keep its lanes in memory.
            #[inline(always)]
            pub(crate) fn sin_cos_of_each<const N: usize>(angles: [Self; N]) -> ([Self; N], [Self; N]) {
                const { assert!(N <= 8, "no group is larger") };
                let (mut sines, mut cosines) = (angles, angles);
                $(if $i < N {
                    (sines[$i], cosines[$i]) = angles[$i].sin_cos();
                })*
                (sines, cosines)
            }

            /// `states[0]`, `states[stride]`, ...
            #[inline(always)]
            pub(crate) fn gathered(states: &[f64], stride: usize) -> $lanes {
                let mut numbers = [0.0; $width];
                for lane in 0..$width {
                    numbers[lane] = states[lane * stride];
                }
                unsafe { core::mem::transmute::<[f64; $width], $lanes>(numbers) }
            }
        }
    };
}
several!(Lanes4, 4, 0 1 2 3 4 5 6 7);
several!(Lanes8, 8, 0 1 2 3 4 5 6 7);

impl Lanes4 {
    /// The four numbers of the register.
    #[inline(always)]
    pub(crate) fn numbers(self) -> [f64; 4] {
        // SAFETY: a register is four numbers and nothing else.
        unsafe { core::mem::transmute(self) }
    }
}

impl Lanes8 {
    /// `entries` seen as lanes.
    #[inline(always)]
    pub(crate) fn of<const E: usize>(entries: &mut [Eight; E]) -> &mut [Lanes8; E] {
        // SAFETY: a register is eight numbers at a multiple of 64 bytes and nothing else; so is Eight.
        unsafe { &mut *(&raw mut *entries).cast() }
    }
}

/// Arrays of numbers; `Lanes` is the array of the same shape with lanes as entries.
pub(crate) trait Numbers {
    type Lanes;
}
impl<const E: usize> Numbers for [f64; E] {
    type Lanes = [Lanes1; E];
}
impl<const P: usize, const N: usize> Numbers for [[f64; P]; N] {
    type Lanes = [[Lanes1; P]; N];
}

impl Lanes1 {
    /// The numbers `x` seen as lanes.
    #[inline(always)]
    pub(crate) fn of<const N: usize>(x: &[f64; N]) -> &[Lanes1; N] {
        // SAFETY: one lane is one number and nothing else.
        unsafe { &*(&raw const *x).cast() }
    }

    /// The numbers `y` seen as lanes.
    #[inline(always)]
    pub(crate) fn within<Y: Numbers>(y: &mut Y) -> &mut Y::Lanes {
        // SAFETY: one lane is one number and nothing else, and `Numbers` are arrays of both of the same shape.
        unsafe { &mut *(&raw mut *y).cast() }
    }

    /// Sines and cosines, four at a time.
    #[inline(always)]
    pub(crate) fn sin_cos_of_each<const N: usize>(angles: [Lanes1; N]) -> ([Lanes1; N], [Lanes1; N]) {
        let (mut sines, mut cosines) = (angles, angles);
        // No closure: it would not be compiled for the instructions of the caller.
        for at in (0..N).step_by(4) {
            let mut four = [0.0; 4];
            for i in at..N.min(at + 4) {
                four[i - at] = angles[i].0;
            }
            let (s, c) = Lanes4::gathered(&four, 1).sin_cos();
            let (s, c) = (s.numbers(), c.numbers());
            for i in at..N.min(at + 4) {
                (sines[i].0, cosines[i].0) = (s[i - at], c[i - at]);
            }
        }
        (sines, cosines)
    }

    /// Sine and cosine in the quadrant of `turns`, from sine and cosine in the first, `self` and `c`.
    #[inline(always)]
    fn turned(self, c: Lanes1, turns: Lanes1) -> (Lanes1, Lanes1) {
        let quadrant = turns.0.to_bits();
        let (s, c) = if quadrant & 1 == 0 { (self, c) } else { (c, self) };
        let sign = |bits: u64| Lanes1(f64::from_bits((bits & 2) << 62));
        (s.with_signs_of(sign(quadrant)), c.with_signs_of(sign(quadrant.wrapping_add(1))))
    }

    #[inline(always)]
    fn with_signs_of(self, signs: Lanes1) -> Lanes1 {
        Lanes1(f64::from_bits(self.0.to_bits() ^ signs.0.to_bits()))
    }
}

impl Lanes4 {
    /// Sine and cosine in the quadrant of `turns`, from sine and cosine in the first, `self` and `c`. Bit 0 of the quadrant
    /// exchanges them. Their signs are bit 1 of the quadrant and bit 1 of the next quadrant.
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
    /// Sine and cosine in the quadrant of `turns`, from sine and cosine in the first, `self` and `c`.
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

/// Writes entries into eight samples of `size` numbers, each entry at its place. Places ascend, and the other numbers of
/// `samples` do not change. Four entries with consecutive places are written at a time.
pub(crate) fn scatter(entries: &[Eight], places: impl Fn(usize) -> usize, size: usize, samples: &mut [f64]) {
    assert_eq!(samples.len(), 8 * size);
    let by_four = std::is_x86_feature_detected!("avx2");
    let mut k = 0;
    while k < entries.len() {
        let place = places(k);
        if let Some(four) = entries[k..].first_chunk::<4>()
            && by_four
            && places(k + 3) == place + 3
            && place + 3 < size
        {
            // SAFETY: the processor has AVX2, and place + 3 is within a sample.
            unsafe { four_to_samples(four, &mut samples[place..], size) };
            k += 4;
        } else {
            for l in 0..8 {
                samples[l * size + place] = entries[k].0[l];
            }
            k += 1;
        }
    }
}

/// Writes four consecutive entries to the beginning of each of eight samples, which begin every `size` numbers.
///
/// # Safety
/// `samples` has more than 7 size + 3 numbers.
#[target_feature(enable = "avx2")]
unsafe fn four_to_samples(four: &[Eight; 4], samples: &mut [f64], size: usize) {
    debug_assert!(samples.len() > 7 * size + 3);
    let to = samples.as_mut_ptr();
    for lane in [0, 4] {
        // SAFETY: four numbers from `lane` on are within an Eight; the caller guarantees the length of `samples`.
        unsafe {
            let row = |i: usize| _mm256_loadu_pd(four[i].0.as_ptr().add(lane));
            // A 4 x 4 transposition: entries of four lanes become four entries of each sample.
            let (a, b, c, d) = (row(0), row(1), row(2), row(3));
            let (ab0, ab1) = (_mm256_unpacklo_pd(a, b), _mm256_unpackhi_pd(a, b));
            let (cd0, cd1) = (_mm256_unpacklo_pd(c, d), _mm256_unpackhi_pd(c, d));
            let place = |l: usize| to.add((lane + l) * size);
            _mm256_storeu_pd(place(0), _mm256_permute2f128_pd::<0x20>(ab0, cd0));
            _mm256_storeu_pd(place(1), _mm256_permute2f128_pd::<0x20>(ab1, cd1));
            _mm256_storeu_pd(place(2), _mm256_permute2f128_pd::<0x31>(ab0, cd0));
            _mm256_storeu_pd(place(3), _mm256_permute2f128_pd::<0x31>(ab1, cd1));
        }
    }
}

/// A function from eight states to the entries that are not always zero; false where the processor has no lanes.
macro_rules! eight {
    ($robot:ident, $n:ident, $e:ident) => {{
        /// Two passes of four samples; each entry is stored when it is computed.
        #[target_feature(enable = "avx2,fma")]
        fn by_four(states: &[f64], entries: &mut [$crate::Eight; $e]) {
            use $crate::lanes::Lanes4;
            for half in 0..2 {
                let states = &states[half * 4 * 3 * $n..];
                let mut inputs = [[Lanes4::splat(0.0); $n]; 3];
                for i in 0..3 * $n {
                    inputs[i / $n][i % $n] = Lanes4::gathered(&states[i..], 3 * $n);
                }
                $robot::base_regressor_entries(&inputs[0], &inputs[1], &inputs[2], |k, _, _, x: Lanes4| {
                    entries[k].0[half * 4..half * 4 + 4].copy_from_slice(&x.numbers());
                });
            }
        }

        /// One pass of eight samples, written directly into `entries`.
        #[target_feature(enable = "avx512f")]
        fn by_eight(states: &[f64], entries: &mut [$crate::Eight; $e]) {
            use $crate::lanes::Lanes8;
            let mut inputs = [[Lanes8::splat(0.0); $n]; 3];
            for i in 0..3 * $n {
                inputs[i / $n][i % $n] = Lanes8::gathered(&states[i..], 3 * $n);
            }
            $robot::base_regressor_non_zeros(&inputs[0], &inputs[1], &inputs[2], Lanes8::of(entries));
        }

        #[allow(unsafe_code, reason = "the processor has been asked")]
        fn eight(states: &[f64], entries: &mut [$crate::Eight]) -> bool {
            let Ok(entries) = entries.try_into() else { return false };
            // SAFETY: each is called only where the processor has the instructions that it is compiled for.
            if !std::is_x86_feature_detected!("avx2") || !std::is_x86_feature_detected!("fma") {
                return false;
            } else if std::is_x86_feature_detected!("avx512f") {
                unsafe { by_eight(states, entries) }
            } else {
                unsafe { by_four(states, entries) }
            }
            true
        }
        eight
    }};
}
pub(crate) use eight;

/// A function of one sample: the scalar function, with fused, three-operand instructions where the processor has them.
macro_rules! scalar {
    ($robot:ident, $function:ident, $n:expr, $y:ty) => {{
        #[target_feature(enable = "avx2,fma")]
        fn fused(q: &[f64; $n], dq: &[f64; $n], ddq: &[f64; $n], y: &mut $y) {
            use $crate::lanes::Lanes1;
            $robot::$function(Lanes1::of(q), Lanes1::of(dq), Lanes1::of(ddq), Lanes1::within(y));
        }

        #[allow(unsafe_code, reason = "the processor has been asked")]
        fn fill(q: &[f64; $n], dq: &[f64; $n], ddq: &[f64; $n], y: &mut $y) {
            if std::is_x86_feature_detected!("avx2") && std::is_x86_feature_detected!("fma") {
                // SAFETY: the processor has the instructions that `fused` is compiled for.
                unsafe { fused(q, dq, ddq, y) }
            } else {
                $robot::$function(q, dq, ddq, y);
            }
        }
        fill
    }};
}
pub(crate) use scalar;

/// Implements the trait `Real` of a robot's file for lanes; with `sqrt` where that trait has it.
macro_rules! real {
    ($robot:ident $($sqrt:ident)?) => {
        $crate::lanes::real!(@ $robot Lanes1 (f64::sqrt) $($sqrt)?);
        $crate::lanes::real!(@ $robot Lanes4 (core::arch::x86_64::_mm256_sqrt_pd) $($sqrt)?);
        $crate::lanes::real!(@ $robot Lanes8 (core::arch::x86_64::_mm512_sqrt_pd) $($sqrt)?);
    };
    (@ $robot:ident $lanes:ident ($instruction:expr) $($sqrt:ident)?) => {
        impl $robot::Real for $crate::lanes::$lanes {
            #[inline(always)]
            fn from_f64(x: f64) -> Self {
                Self::splat(x)
            }
            #[inline(always)]
            fn mul_add(self, b: Self, c: Self) -> Self {
                self.mul_add(b, c)
            }
            #[inline(always)]
            fn sin_cos(self) -> (Self, Self) {
                self.sin_cos()
            }
            #[inline(always)]
            fn sin_cos_of_each<const N: usize>(angles: [Self; N]) -> ([Self; N], [Self; N]) {
                Self::sin_cos_of_each(angles)
            }
            $(#[inline(always)]
            #[allow(unsafe_code, unused_unsafe, reason = "vector registers")]
            fn $sqrt(self) -> Self {
                unsafe { Self($instruction(self.0)) }
            })?
        }
    };
}
pub(crate) use real;
