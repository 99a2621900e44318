//! The trait every generated file carries, so that it needs no other file and no library.

use proc_macro2::TokenStream;
use quote::quote;

/// Operations that not every file needs.
#[derive(Clone, Copy)]
pub(crate) struct Operations {
    pub div: bool,
    pub sqrt: bool,
}

/// `Real`, its implementations for f64 and f32, and a sine and cosine that need no std.
pub(crate) fn real_trait(operations: Operations) -> TokenStream {
    // Only what some function of the file uses: a trait without `sqrt` or `/` asks less of its types.
    let div = operations.div.then(|| quote!(+ core::ops::Div<Output = Self>));
    let [sqrt, sqrt_f64, sqrt_f32] = square_root(operations.sqrt);
    let of_f64 = real_of_f64(sqrt_f64);
    let (mul_add_f32, sin_cos_f32) = (mul_add(quote!(f32)), sin_cos_of_f32());
    quote! {
        /// The numbers this file computes with: f64, f32, or lanes of them.
        pub trait Real:
            Copy
            + core::ops::Add<Output = Self>
            + core::ops::Sub<Output = Self>
            + core::ops::Mul<Output = Self>
            #div
            + core::ops::Neg<Output = Self>
        {
            /// The nearest number to `x`.
            fn from_f64(x: f64) -> Self;
            /// self b + c: rounded once where the target has an instruction for it, else twice.
            fn mul_add(self, b: Self, c: Self) -> Self;
            /// Sine and cosine.
            fn sin_cos(self) -> (Self, Self);
            /// Sines and cosines of up to eight angles.
            #[inline(always)]
            fn sin_cos_of_each<const N: usize>(angles: [Self; N]) -> ([Self; N], [Self; N]) {
                let (mut sines, mut cosines) = (angles, angles);
                for ((s, c), x) in sines.iter_mut().zip(&mut cosines).zip(angles) {
                    (*s, *c) = x.sin_cos();
                }
                (sines, cosines)
            }
            #sqrt
        }

        #of_f64

        impl Real for f32 {
            #[inline(always)]
            fn from_f64(x: f64) -> f32 {
                x as f32
            }

            #mul_add_f32

            #sin_cos_f32

            #sqrt_f32
        }
    }
}

/// The method of f64 or f32. Only the standard library has it, and without an instruction it is a slow call.
fn mul_add(number: TokenStream) -> TokenStream {
    quote! {
        #[cfg(all(any(target_feature = "fma", target_arch = "aarch64"), any(unix, windows)))]
        #[inline(always)]
        fn mul_add(self, b: #number, c: #number) -> #number {
            extern crate std;
            #number::mul_add(self, b, c)
        }

        #[cfg(not(all(any(target_feature = "fma", target_arch = "aarch64"), any(unix, windows))))]
        #[inline(always)]
        fn mul_add(self, b: #number, c: #number) -> #number {
            self * b + c
        }
    }
}

/// `Real` for f64, with the method `sqrt_f64` where the file takes roots.
fn real_of_f64(sqrt_f64: TokenStream) -> TokenStream {
    let (mul_add, of_each) = (mul_add(quote!(f64)), sin_cos_of_each());
    quote! {
        impl Real for f64 {
            #[inline(always)]
            fn from_f64(x: f64) -> f64 {
                x
            }

            #mul_add

            /// Within 2e-16 of the sine and cosine of x for |x| < 2^27, NaN beyond. Reduction to [-pi/4, pi/4] by
            /// three parts of pi/2 (Cody and Waite 1980, the parts of Cephes), then the minimax
            /// polynomials of fdlibm (Sun Microsystems 1993).
            #[inline(always)]
            fn sin_cos(self) -> (f64, f64) {
                // Adding 1.5 * 2^52 rounds to an integer and leaves it in the low bits.
                const ROUND: f64 = 6755399441055744.0;
                const REACH: f64 = 1.3393857589828342e300;
                const PARTS: [f64; 3] = [1.570796251296997, 7.549789415861596e-8, 5.390302858158119e-15];
                let fused = <f64 as Real>::mul_add;
                let turns = fused(self, core::f64::consts::FRAC_2_PI, ROUND);
                let quadrant = turns.to_bits();
                let n = turns - ROUND;
                // Overflows from 2^27 on: n would have more digits than the parts leave to it.
                let reach = self * REACH;
                let x = fused(-n, PARTS[2], fused(-n, PARTS[1], fused(-n, PARTS[0], self)));
                let x = x * fused(0.0, reach, 1.0);
                let z = x * x;
                let s = fused(z, 1.58969099521155e-10, -2.5050760253406863e-8);
                let s = fused(z, fused(z, s, 2.7557313707070068e-6), -1.984126982985795e-4);
                let s = fused(z, fused(z, s, 8.33333333332249e-3), -1.6666666666666632e-1);
                let s = fused(x * z, s, x);
                let c = fused(z, -1.1359647557788195e-11, 2.087572321298175e-9);
                let c = fused(z, fused(z, c, -2.7557314351390663e-7), 2.480158728947673e-5);
                let c = fused(z, fused(z, c, -1.388888888887411e-3), 4.16666666666666e-2);
                let c = fused(z * z, c, fused(-0.5, z, 1.0));
                let (s, c) = if quadrant & 1 == 0 { (s, c) } else { (c, s) };
                let sign = |x: f64, bits: u64| f64::from_bits(x.to_bits() ^ (bits & 2) << 62);
                (sign(s, quadrant), sign(c, quadrant.wrapping_add(1)))
            }

            #of_each

            #sqrt_f64
        }
    }
}

/// The method of f32, without an f64: processors with floats alone compute doubles by slow calls.
fn sin_cos_of_f32() -> TokenStream {
    quote! {
        /// Within 1e-7 of the sine and cosine of x for |x| < 8192, NaN beyond: as for f64, with the parts and the polynomials
        /// of Cephes for f32.
        #[inline(always)]
        fn sin_cos(self) -> (f32, f32) {
            const ROUND: f32 = 12582912.0;
            const REACH: f32 = 4.1538375e34;
            const PARTS: [f32; 3] = [1.5703125, 4.837513e-4, 7.54979e-8];
            let fused = <f32 as Real>::mul_add;
            let turns = fused(self, core::f32::consts::FRAC_2_PI, ROUND);
            let quadrant = turns.to_bits();
            let n = turns - ROUND;
            let reach = self * REACH;
            let x = fused(-n, PARTS[2], fused(-n, PARTS[1], fused(-n, PARTS[0], self)));
            let x = x * fused(0.0, reach, 1.0);
            let z = x * x;
            let s = fused(z, fused(z, -1.9515296e-4, 8.332161e-3), -1.6666655e-1);
            let s = fused(x * z, s, x);
            let c = fused(z, fused(z, 2.4433157e-5, -1.3887316e-3), 4.1666646e-2);
            let c = fused(z * z, c, fused(-0.5, z, 1.0));
            let (s, c) = if quadrant & 1 == 0 { (s, c) } else { (c, s) };
            let sign = |x: f32, bits: u32| f32::from_bits(x.to_bits() ^ (bits & 2) << 30);
            (sign(s, quadrant), sign(c, quadrant.wrapping_add(1)))
        }
    }
}

/// The method of f64. Several angles in one vector register cost little more than one angle.
fn sin_cos_of_each() -> TokenStream {
    quote! {
        /// A function of its own, whose inner loop is as wide as a vector register: compilers put it into one.
        #[inline(never)]
        fn sin_cos_of_each<const N: usize>(angles: [f64; N]) -> ([f64; N], [f64; N]) {
            const { assert!(N <= 8) };
            const WIDTH: usize = if cfg!(target_feature = "avx") {
                4
            } else if cfg!(any(target_feature = "sse2", target_feature = "neon")) {
                2
            } else {
                1
            };
            let mut padded = [[0.0; WIDTH]; 8 / WIDTH];
            for (x, angle) in padded.as_flattened_mut().iter_mut().zip(angles) {
                *x = angle;
            }
            let (mut sines, mut cosines) = (padded, padded);
            for ((s, c), x) in sines.iter_mut().zip(&mut cosines).zip(padded).take(N.div_ceil(WIDTH)) {
                for ((s, c), x) in s.iter_mut().zip(c).zip(x) {
                    (*s, *c) = Real::sin_cos(x);
                }
            }
            let (mut s, mut c) = (angles, angles);
            for (s, sine) in s.iter_mut().zip(sines.as_flattened()) {
                *s = *sine;
            }
            for (c, cosine) in c.iter_mut().zip(cosines.as_flattened()) {
                *c = *cosine;
            }
            (s, c)
        }
    }
}

/// The square root of the trait, of f64 and of f32. They are written here because core has none.
fn square_root(needed: bool) -> [TokenStream; 3] {
    if !needed {
        return Default::default();
    }
    let method = quote! {
        /// Square root; NaN below zero, infinity of infinity.
        fn sqrt(self) -> Self;
    };
    let of_f64 = quote! {
        /// Within 0.51 ulp for 1e-290 < x < 1e290. Newton's method for 1/sqrt(x) from a guess in
        /// the exponent, then one step with the exact residual x - y^2 (Dekker 1971).
        #[inline(always)]
        fn sqrt(self) -> f64 {
            let mut r = f64::from_bits(0x5fe6eb50c7b537a9_u64.wrapping_sub(self.to_bits() >> 1));
            let half = 0.5 * self;
            r = r * (1.5 - half * r * r);
            r = r * (1.5 - half * r * r);
            r = r * (1.5 - half * r * r);
            r = r * (1.5 - half * r * r);
            let y = self * r;
            let c = 134217729.0 * y;
            let high = c - (c - y);
            let low = y - high;
            let residual = ((self - high * high) - 2.0 * high * low) - low * low;
            let root = y + 0.5 * r * residual;
            if self == f64::INFINITY {
                self
            } else if self > 0.0 {
                root
            } else if self == 0.0 {
                self
            } else {
                f64::NAN
            }
        }
    };
    let of_f32 = quote! {
        /// Within 0.51 ulp for 1e-30 < x < 1e30, as for f64.
        #[inline(always)]
        fn sqrt(self) -> f32 {
            let mut r = f32::from_bits(0x5f3759df_u32.wrapping_sub(self.to_bits() >> 1));
            let half = 0.5 * self;
            r = r * (1.5 - half * r * r);
            r = r * (1.5 - half * r * r);
            r = r * (1.5 - half * r * r);
            let y = self * r;
            let c = 4097.0 * y;
            let high = c - (c - y);
            let low = y - high;
            let residual = ((self - high * high) - 2.0 * high * low) - low * low;
            let root = y + 0.5 * r * residual;
            if self > 0.0 {
                root
            } else if self == 0.0 {
                self
            } else {
                f32::NAN
            }
        }
    };
    [method, of_f64, of_f32]
}
