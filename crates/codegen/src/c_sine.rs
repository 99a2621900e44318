//! Writes sine and cosine in C without a library. The operations equal the operations of the Rust file (sine.rs), so C and Rust
//! give the same bits if both fuse or neither does.
//!
//! The inner loop takes as many angles as a vector register holds: gcc and clang vectorise it at -O2. The library's functions are
//! used in two cases: if compiler options allow regrouped sums, which would undo the rounding to an integer, and with the 80-bit
//! registers of an old x86.

use expr::{Function, Node};

use crate::sine::{self, between, polynomials};
use crate::steps::Angle;

/// The largest number of angles that one vector register of a supported processor holds.
const MAX_ANGLES_PER_REGISTER: usize = 4;

/// Whether one of the functions needs a sine or a cosine.
pub(crate) fn is_read(functions: &[&Function]) -> bool {
    functions.iter().any(|f| f.graph().nodes().iter().any(|node| matches!(node, Node::Sin(_) | Node::Cos(_))))
}

/// The C text of `sin_cos_of_each` and of the functions that it calls. It uses `fused` and `fusedf`: a b + c of double and float.
pub(crate) fn sin_cos_of_each() -> String {
    let of_double = sin_cos_of_double(&sine::statements("f64"));
    let of_float = in_float(&sin_cos_of_double(&sine::statements("f32")));
    [LIBRARY, DOC_OF_DOUBLE, &of_double, DOC_OF_FLOAT, &of_float, LOOP].concat()
}

/// The C text of `sin_cos_of_double`, the sine and cosine of one angle. The numbers and polynomials come from the Rust
/// `statements`.
fn sin_cos_of_double(statements: &str) -> String {
    let number = |name: &str| between(statements, name, ";\n").rsplit(" = ").next().unwrap_or("");
    let parts = number("PARTS").trim_matches(['[', ']']).split(", ");
    let text = OF_DOUBLE.replace("ROUND", number("ROUND")).replace("REACH", number("REACH"));
    let text = ["PART0", "PART1", "PART2"].iter().zip(parts).fold(text, |text, (name, x)| text.replace(name, x));
    text.replace("POLYNOMIALS", &polynomials(statements).replace("let ", ""))
}

/// Changes the C text of a function of doubles into a function of floats. Lines with a comment are dropped.
fn in_float(function: &str) -> String {
    const ENDS: [char; 5] = [' ', ',', ')', ';', '\n'];
    // A number with a decimal point gets the suffix `f` of a float.
    let with_suffix = |piece: &str| {
        let (word, end) = piece.split_at(piece.trim_end_matches(ENDS).len());
        let is_number = word.contains('.') && word.ends_with(|c: char| c.is_ascii_digit());
        format!("{word}{}{end}", if is_number { "f" } else { "" })
    };
    let lines = function.split_inclusive('\n').filter(|line| !line.starts_with("    /*"));
    let text: String = lines.flat_map(|line| line.split_inclusive(ENDS)).map(with_suffix).collect();
    let changes = [("double", "float"), ("fused(", "fusedf("), ("uint64", "uint32"), ("<< 62", "<< 30")];
    let text = changes.iter().fold(text, |text, (of_double, of_float)| text.replace(of_double, of_float));
    text.replace("0.6366197723675814f", "0.63661975f")
}

const LIBRARY: &str = r"
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
";

const DOC_OF_DOUBLE: &str = "\
/*
 * Within 2e-16 of the sine and cosine of x for |x| < 2^27, NaN beyond. Reduction to [-pi/4, pi/4] by three parts of pi/2
 * (Cody and Waite 1980, the parts of Cephes), then the minimax polynomials of fdlibm (Sun Microsystems 1993).
 */
";

const OF_DOUBLE: &str = "\
static inline void sin_cos_of_double(double angle, double *sine, double *cosine)
{
#if defined(__clang__)
#pragma clang fp reassociate(off)
#endif
    /* Adding 1.5 * 2^52 rounds to an integer and leaves it in the low bits. */
    const double round = ROUND;
    const double turns = fused(angle, 0.6366197723675814, round);
    const double n = turns - round;
    /* Overflows from 2^27 on: n would have more digits than the parts leave to it. */
    const double reach = angle * REACH;
    /* The parts are negative, not n: clang may regroup a negation, whatever the pragma says. */
    double x = fused(n, -PART1, fused(n, -PART0, angle));
    double z, s, c;
    union { double number; uint64_t bits; } turned, to_s, to_c;
    uint64_t quadrant, swapped;
    x = fused(n, -PART2, x) * fused(0.0, reach, 1.0);
    z = x * x;
POLYNOMIALS    /* An odd quadrant swaps the two; the signs follow from its second bit. */
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
";

const DOC_OF_FLOAT: &str = "
/* Within 1e-7 for |x| < 8192, NaN beyond: as for double, with the parts and the polynomials of Cephes for float. */
";

const LOOP: &str = r"
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

/// C statements that assign sines and cosines of `angles` to variables. `of`: each angle as a C expression; `names`: the variable
/// of each node; `given`: an array that already holds the angles one after the other. Such an array saves time: a vector that is
/// read right after its numbers were written one by one must wait for these writes.
pub(crate) fn statements(angles: &[Angle], of: &[String], names: &[String], given: Option<String>) -> String {
    let read = |node: fn(&Angle) -> Option<usize>| {
        angles.iter().enumerate().filter_map(move |(k, angle)| node(angle).map(|n| (k, &names[n])))
    };
    let (sines, cosines) = (|| read(|angle| angle.sine), || read(|angle| angle.cosine));
    let declared: Vec<&str> = sines().chain(cosines()).map(|(_, name)| name.as_str()).collect();
    let (n, room) = (angles.len(), angles.len().max(MAX_ANGLES_PER_REGISTER));
    let mut text = format!("    real {};\n    {{\n        real sines[{room}], cosines[{room}];\n", declared.join(", "));
    let given = given.filter(|_| n >= MAX_ANGLES_PER_REGISTER).unwrap_or_else(|| {
        text += &format!("        const real angles[{room}] = {{{}}};\n", of.join(", "));
        "angles".into()
    });
    text += &format!("        sin_cos_of_each({n}, {given}, sines, cosines);\n");
    sines().for_each(|(k, name)| text += &format!("        {name} = sines[{k}];\n"));
    cosines().for_each(|(k, name)| text += &format!("        {name} = cosines[{k}];\n"));
    text + "    }\n"
}
