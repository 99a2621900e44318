//! Writes the trait `Real` of numbers. Every generated Rust file contains it, so that the file needs no other file and no
//! library.

use proc_macro2::TokenStream;
use quote::{format_ident, quote};

use crate::sine::statements;

/// The operations of the trait `Real` that only some files need, and whether this file needs them.
#[derive(Clone, Copy)]
pub(crate) struct Operations {
    pub div: bool,
    pub sqrt: bool,
}

/// Tokens of the trait `Real`, its implementations for f64 and f32, and a sine and cosine that need no std.
pub(crate) fn real_trait(operations: Operations) -> TokenStream {
    // The trait has only the operations that this file uses: without `sqrt` or `/`, more types can implement it.
    let div = operations.div.then(|| quote!(+ core::ops::Div<Output = Self>));
    let [sqrt, sqrt_f64, sqrt_f32] = square_root(operations.sqrt);
    let of_f64 = real_of_f64(sqrt_f64);
    let (mul_add_f32, sin_cos_f32) = (mul_add(quote!(f32)), sin_cos("f32"));
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

            /// Within 1e-7 of the sine and cosine of x for |x| < 8192, NaN beyond: as for f64, with the parts and the polynomials
            /// of Cephes for f32.
            #sin_cos_f32

            #sqrt_f32
        }
    }
}

/// Tokens of the method `mul_add` of f64 or f32. `core` does not have this method. In `std`, it is a slow call if the target
/// has no instruction for it.
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

/// Tokens of the implementation of `Real` for f64. `sqrt_f64`: its method `sqrt`, or empty if the file needs no square roots.
fn real_of_f64(sqrt_f64: TokenStream) -> TokenStream {
    let (mul_add, sin_cos, of_each) = (mul_add(quote!(f64)), sin_cos("f64"), sin_cos_of_each());
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
            #sin_cos

            #of_each

            #sqrt_f64
        }
    }
}

/// Tokens of the method `sin_cos` of f64 or f32.
fn sin_cos(number: &str) -> TokenStream {
    let statements = statements(number).replace("angle", "self");
    let (numbers, operations) = statements.split_at(statements.find("let turns").unwrap_or(0));
    let (number, numbers, operations) = (format_ident!("{number}"), tokens(numbers), tokens(operations));
    quote! {
        #[inline(always)]
        fn sin_cos(self) -> (#number, #number) {
            #numbers
            let fused = <#number as Real>::mul_add;
            #operations
        }
    }
}

/// Parses a Rust text of this crate into tokens.
fn tokens(text: &str) -> TokenStream {
    text.parse().expect("a text of our own is Rust")
}

/// Tokens of the method `sin_cos_of_each` of f64. It is faster than single calls, because several angles in one vector register
/// cost little more than one angle.
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

/// Tokens of the method `sqrt`: in the trait, of f64 and of f32. All are empty if it is not needed. `core` has no square root.
fn square_root(needed: bool) -> [TokenStream; 3] {
    if !needed {
        return Default::default();
    }
    let method = quote! {
        /// Square root; NaN below zero, infinity of infinity.
        fn sqrt(self) -> Self;
    };
    let of_f32 = ROOT_OF_F32.iter().fold(ROOT.to_string(), |text, (of_f64, of_f32)| text.replace(of_f64, of_f32));
    [method, tokens(ROOT), tokens(&of_f32)]
}

/// Rust text of the method `sqrt` of f64.
const ROOT: &str = "
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
";

/// Pairs of a text in `ROOT` and its replacement for f32. One Newton step less is enough, because f32 has half the digits.
const ROOT_OF_F32: [(&str, &str); 7] = [
    ("0x5fe6eb50c7b537a9_u64", "0x5f3759df_u32"),
    ("    r = r * (1.5 - half * r * r);\n    let y", "    let y"),
    ("134217729.0", "4097.0"),
    ("if self == f64::INFINITY {\n        self\n    } else ", ""),
    ("f64", "f32"),
    ("1e-290 < x < 1e290. Newton's method for 1/sqrt(x) from a guess in\n", "1e-30 < x < 1e30, as for f64.\n"),
    ("/// the exponent, then one step with the exact residual x - y^2 (Dekker 1971).\n", ""),
];
