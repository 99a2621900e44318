//! Sine and cosine as Rust statements, which compute them from `angle` and `fused` (multiply-add). The f64 statements are the
//! source text of the sine in the crate `expr`, with which this program evaluates functions. The f32 statements have other
//! numbers and shorter polynomials. The C text takes its numbers and polynomials from both.

/// The numbers of the f32 statements, from the library Cephes. None of them is an f64, because a processor without double
/// precision computes with f64 by slow library calls.
const NUMBERS_OF_F32: &str = "
    const ROUND: f32 = 12582912.0;
    const REACH: f32 = 4.1538375e34;
    const PARTS: [f32; 3] = [1.5703125, 4.837513e-4, 7.54979e-8];
";
const POLYNOMIALS_OF_F32: &str = "
    let s = fused(z, fused(z, -1.9515296e-4, 8.332161e-3), -1.6666655e-1);
    let s = fused(x * z, s, x);
    let c = fused(z, fused(z, 2.4433157e-5, -1.3887316e-3), 4.1666646e-2);
    let c = fused(z * z, c, fused(-0.5, z, 1.0));
";

/// The Rust statements that compute sine and cosine for the number type `f64` or `f32`.
pub(crate) fn statements(number: &str) -> String {
    let of_f64 = between(expr::SINE_SOURCE, "-> (f64, f64) {\n", "\n}\n");
    if number == "f64" {
        return of_f64.into();
    }
    let numbers = between(of_f64, "", "    let turns");
    let of_f32 = of_f64.replace(numbers, NUMBERS_OF_F32).replace(polynomials(of_f64), POLYNOMIALS_OF_F32);
    of_f32.replace("f64", "f32").replace("u64", "u32").replace("<< 62", "<< 30")
}

/// The part of `statements` that evaluates the polynomials: it computes s and c from x and z = x^2.
pub(crate) fn polynomials(statements: &str) -> &str {
    between(statements, "let z = x * x;\n", "    let (s, c)").trim_start_matches('\n')
}

/// The part of `text` between the first `before` and the next `behind`.
pub(crate) fn between<'a>(text: &'a str, before: &str, behind: &str) -> &'a str {
    let rest = text.split_once(before).map(|(_, rest)| rest);
    rest.and_then(|rest| rest.split_once(behind)).expect("a text of our own has both").0
}
