//! Sine and cosine in C without a library: the operations of the Rust file (numbers.rs), so that the bits are the same
//! wherever both fuse or neither does.
//!
//! The inner loop is as wide as a vector register: gcc and clang put it into one at -O2. The library's functions stay for
//! compilers that were told to regroup sums, which would undo the rounding to an integer, and for the registers of 80 bits
//! of an old x86.

use expr::{Function, Node};

use crate::steps::Angle;

/// The largest number of angles to a vector register.
const WIDEST: usize = 4;

/// Whether some function takes a sine or cosine.
pub(crate) fn is_read(functions: &[&Function]) -> bool {
    functions.iter().any(|f| f.graph().nodes().iter().any(|node| matches!(node, Node::Sin(_) | Node::Cos(_))))
}

/// What a source file has before its functions; `fused` and `fusedf` are a b + c of double and of float.
pub(crate) const SIN_COS_OF_EACH: &str = r"
/* Angles to a vector register. */
#if defined(__AVX__)
#define LANES 4
#elif defined(__SSE2__) || defined(_M_X64) || defined(__ARM_NEON)
#define LANES 2
#else
#define LANES 1
#endif

#if defined(__FAST_MATH__) || defined(__ASSOCIATIVE_MATH__) || defined(_M_FP_FAST) || FLT_EVAL_METHOD != 0
/* Sums may be regrouped here, or kept with more digits than are stored: sine and cosine are the library's. */
static void sin_cos_of_each(int n, const real *angles, real *sines, real *cosines)
{
    int i;
    for (i = 0; i < n; i++) {
        const int is_float = sizeof(real) == sizeof(float);
        sines[i] = is_float ? (real)sinf((float)angles[i]) : (real)sin((double)angles[i]);
        cosines[i] = is_float ? (real)cosf((float)angles[i]) : (real)cos((double)angles[i]);
    }
}
#else
/*
 * Within 2e-16 of the sine and cosine of x for |x| < 2^27, NaN beyond. Reduction to [-pi/4, pi/4] by three parts of pi/2
 * (Cody and Waite 1980, the parts of Cephes), then the minimax polynomials of fdlibm (Sun Microsystems 1993).
 */
static inline void sin_cos_of_double(double angle, double *sine, double *cosine)
{
#if defined(__clang__)
#pragma clang fp reassociate(off)
#endif
    /* Adding 1.5 * 2^52 rounds to an integer and leaves it in the low bits. */
    const double round = 6755399441055744.0;
    const double turns = fused(angle, 0.6366197723675814, round);
    const double n = turns - round;
    /* Overflows from 2^27 on: n would have more digits than the parts leave to it. */
    const double reach = angle * 1.3393857589828342e300;
    /* The parts are negative, not n: clang may regroup a negation, whatever the pragma says. */
    double x = fused(n, -7.549789415861596e-8, fused(n, -1.570796251296997, angle));
    double z, s, c;
    union { double number; uint64_t bits; } turned, to_s, to_c;
    uint64_t quadrant, swapped;
    x = fused(n, -5.390302858158119e-15, x) * fused(0.0, reach, 1.0);
    z = x * x;
    s = fused(z, 1.58969099521155e-10, -2.5050760253406863e-8);
    s = fused(z, fused(z, s, 2.7557313707070068e-6), -1.984126982985795e-4);
    s = fused(z, fused(z, s, 8.33333333332249e-3), -1.6666666666666632e-1);
    s = fused(x * z, s, x);
    c = fused(z, -1.1359647557788195e-11, 2.087572321298175e-9);
    c = fused(z, fused(z, c, -2.7557314351390663e-7), 2.480158728947673e-5);
    c = fused(z, fused(z, c, -1.388888888887411e-3), 4.16666666666666e-2);
    c = fused(z * z, c, fused(-0.5, z, 1.0));
    /* An odd quadrant swaps the two; the signs follow from its second bit. */
    turned.number = turns;
    to_s.number = s;
    to_c.number = c;
    quadrant = turned.bits;
    swapped = (to_s.bits ^ to_c.bits) & (0 - (quadrant & 1));
    to_s.bits ^= swapped ^ (quadrant & 2) << 62;
    to_c.bits ^= swapped ^ ((quadrant + 1) & 2) << 62;
    *sine = to_s.number;
    *cosine = to_c.number;
}

/* Within 1e-7 for |x| < 8192, NaN beyond: as for double, with the parts and the polynomials of Cephes for float. */
static inline void sin_cos_of_float(float angle, float *sine, float *cosine)
{
#if defined(__clang__)
#pragma clang fp reassociate(off)
#endif
    const float round = 12582912.0f;
    const float turns = fusedf(angle, 0.63661975f, round);
    const float n = turns - round;
    const float reach = angle * 4.1538375e34f;
    float x = fusedf(n, -4.837513e-4f, fusedf(n, -1.5703125f, angle));
    float z, s, c;
    union { float number; uint32_t bits; } turned, to_s, to_c;
    uint32_t quadrant, swapped;
    x = fusedf(n, -7.54979e-8f, x) * fusedf(0.0f, reach, 1.0f);
    z = x * x;
    s = fusedf(z, fusedf(z, -1.9515296e-4f, 8.332161e-3f), -1.6666655e-1f);
    s = fusedf(x * z, s, x);
    c = fusedf(z, fusedf(z, 2.4433157e-5f, -1.3887316e-3f), 4.1666646e-2f);
    c = fusedf(z * z, c, fusedf(-0.5f, z, 1.0f));
    turned.number = turns;
    to_s.number = s;
    to_c.number = c;
    quadrant = turned.bits;
    swapped = (to_s.bits ^ to_c.bits) & (0 - (quadrant & 1));
    to_s.bits ^= swapped ^ (quadrant & 2) << 30;
    to_c.bits ^= swapped ^ ((quadrant + 1) & 2) << 30;
    *sine = to_s.number;
    *cosine = to_c.number;
}

/* Sines and cosines of n angles. The last vector may overlap the one before; where n < LANES it reads and writes LANES. */
static void sin_cos_of_each(int n, const real *restrict angles, real *restrict sines, real *restrict cosines)
{
    int i, k;
    for (i = 0; i < n; i += LANES) {
        const int first = i + LANES <= n || n < LANES ? i : n - LANES;
        for (k = first; k < first + LANES; k++) {
            if (sizeof(real) == sizeof(float)) {
                float s, c;
                sin_cos_of_float((float)angles[k], &s, &c);
                sines[k] = (real)s;
                cosines[k] = (real)c;
            } else {
                double s, c;
                sin_cos_of_double((double)angles[k], &s, &c);
                sines[k] = (real)s;
                cosines[k] = (real)c;
            }
        }
    }
}
#endif
";

/// The statements that give the read sines and cosines of `angles`, which are `of`, their names. `given` is where the angles
/// stand one after the other: a vector that is read from where numbers were written one by one waits for them.
pub(crate) fn statements(angles: &[Angle], of: &[String], names: &[String], given: Option<String>) -> String {
    let read = |node: fn(&Angle) -> Option<usize>| {
        angles.iter().enumerate().filter_map(move |(k, angle)| node(angle).map(|n| (k, &names[n])))
    };
    let (sines, cosines) = (|| read(|angle| angle.sine), || read(|angle| angle.cosine));
    let declared: Vec<&str> = sines().chain(cosines()).map(|(_, name)| name.as_str()).collect();
    let (n, room) = (angles.len(), angles.len().max(WIDEST));
    let mut text = format!("    real {};\n    {{\n        real sines[{room}], cosines[{room}];\n", declared.join(", "));
    let given = given.filter(|_| n >= WIDEST).unwrap_or_else(|| {
        text += &format!("        const real angles[{room}] = {{{}}};\n", of.join(", "));
        "angles".into()
    });
    text += &format!("        sin_cos_of_each({n}, {given}, sines, cosines);\n");
    sines().for_each(|(k, name)| text += &format!("        {name} = sines[{k}];\n"));
    cosines().for_each(|(k, name)| text += &format!("        {name} = cosines[{k}];\n"));
    text + "    }\n"
}
