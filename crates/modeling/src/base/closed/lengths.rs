//! Solves equations in a finite field that are affine in lengths, such as the position equations of a loop with known angles.

use crate::base::field::Residue;
use random::SplitMix;

/// A random x with n entries and f(x) = 0, for an affine function f. The leftmost entries that f determines are solved for, and
/// the other entries are random. `None` if f is not affine or has no zero.
pub(crate) fn random_zero(
    n: usize,
    mut f: impl FnMut(&[Residue]) -> Option<Vec<Residue>>,
    random: &mut SplitMix,
) -> Option<Vec<Residue>> {
    let constant = f(&vec![Residue::ZERO; n])?;
    let mut rows: Vec<Vec<Residue>> = vec![Vec::with_capacity(n + 1); constant.len()];
    for k in 0..n {
        let mut unit = vec![Residue::ZERO; n];
        unit[k] = Residue::ONE;
        let value = f(&unit)?;
        for (row, (value, constant)) in rows.iter_mut().zip(value.iter().zip(&constant)) {
            row.push(*value - *constant);
        }
    }
    rows.iter_mut().zip(&constant).for_each(|(row, c)| row.push(-*c));
    let mut x: Vec<Residue> = (0..n).map(|_| Residue::random(random)).collect();
    solve_first(rows, &mut x)?;
    // If f is not affine, x is no zero of f.
    f(&x)?.iter().all(|value| *value == Residue::ZERO).then_some(x)
}

/// Solves the linear equations with rows [a_1 .. a_n b], a x = b. The leftmost entries of x that the equations determine are
/// solved for; the other entries are given. `None` if the equations contradict each other.
fn solve_first(mut rows: Vec<Vec<Residue>>, x: &mut [Residue]) -> Option<()> {
    let n = x.len();
    let mut pivots: Vec<(usize, Vec<Residue>)> = Vec::new();
    for c in 0..n {
        let Some(place) = rows.iter().position(|row| row[c] != Residue::ZERO) else { continue };
        let pivot = rows.swap_remove(place);
        let scale = pivot[c].inverse();
        let pivot: Vec<Residue> = pivot.into_iter().map(|a| a * scale).collect();
        for row in rows.iter_mut().filter(|row| row[c] != Residue::ZERO) {
            let factor = row[c];
            for k in c..=n {
                row[k] = row[k] - factor * pivot[k];
            }
        }
        pivots.push((c, pivot));
    }
    if rows.iter().any(|row| row[n] != Residue::ZERO) {
        return None;
    }
    for (c, pivot) in pivots.into_iter().rev() {
        x[c] = (c + 1..n).fold(pivot[n], |rest, k| rest - pivot[k] * x[k]);
    }
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_random_zero_of_an_affine_function() {
        let n = Residue::integer;
        let f = |x: &[Residue]| Some(vec![x[0] + n(2) * x[1] - n(3), x[0] + n(2) * x[1] + x[2] - n(4)]);
        let x = random_zero(3, f, &mut SplitMix(1)).unwrap();
        assert_eq!((x[2], x[0]), (n(1), n(3) - n(2) * x[1]));
        // f does not determine x[1], so x[1] is random.
        assert_ne!(x[1], random_zero(3, f, &mut SplitMix(2)).unwrap()[1]);
    }

    #[test]
    fn what_is_not_affine_or_contradicts_has_none() {
        let square = |x: &[Residue]| Some(vec![x[0] * x[0] - Residue::integer(4)]);
        assert!(random_zero(1, square, &mut SplitMix(1)).is_none());
        let contradiction = |x: &[Residue]| Some(vec![x[0], x[0] - Residue::ONE]);
        assert!(random_zero(1, contradiction, &mut SplitMix(1)).is_none());
    }
}
