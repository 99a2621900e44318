//! Householder reflections that annihilate a block of rows below a triangle (R of a QR decomposition), four at a time.
//!
//! Reflection k annihilates the column x_k of the rows below the diagonal entry R_kk:
//! v_k = [e_k (R_kk - beta_k); x_k], beta_k = -sign(R_kk) sqrt(R_kk^2 + |x_k|^2), H_k = I - v_k v_k' / (beta_k (beta_k - R_kk)).
//! Four reflections are combined to one update of the later columns [Schreiber, Van Loan 1989]: H_4 H_3 H_2 H_1 = I - V T' V', T
//! upper triangular, T_kk = 1 / (beta_k (beta_k - R_kk)), T_ik = -T_kk sum_l T_il x_l . x_k. A column is read twice and written
//! once for four reflections. The v_k are stored in place of the annihilated columns, which are not needed later.
//!
//! | symbol | code | shape | |
//! |---|---|---|---|
//! | R | `r` | upper, column by column | unit of a row times unit of its column |
//! | x_k | entries of a [`RowBlock`] | up to 128 | as the rows |
//! | R_kk - beta_k | `lead` | 4 | |
//!
//! This file also computes W'W, the products of the columns with one another, and the combinations W M of columns. These two
//! computations need no triangle.
//!
//! On every processor a sum has four partial sums (lanes): row 4 i + l is added to lane l; the sum of a norm has eight lanes.
//! With AVX2 and FMA the lanes are in vector registers, and each multiplication with addition is rounded once. All `unsafe`
//! code of this crate is in this file. This code is sound because only `reflect_fused`, `add_products_fused` and
//! `combine_fused` use the vector registers. These functions are compiled for AVX2 and FMA, and are called only if the
//! processor has both.

#![allow(unsafe_code, reason = "vector registers")]

use generated::Eight;

use crate::row_block::RowBlock;

/// A column with a smaller sum of squares is treated as zero, because the reciprocal would be infinite. For a joint at rest, the
/// filtered sign of the velocity decays to such values.
const NEGLIGIBLE_SQUARES: f64 = 1e-280;

/// Where the columns of the triangle R are stored: in the array of R, and in a row of a block.
#[derive(Clone, Copy)]
pub struct ColumnPlaces<'a> {
    /// Index in R of each column, in the order of elimination.
    pub index: &'a [usize],
    /// Index in a row of each column, in the same order.
    pub places: &'a [usize],
}

/// Updates the triangle `r` (R of a QR decomposition) with the rows of `block`: reflections annihilate these rows. Entry (i, j)
/// of r is at j n + i. The entries of the block at `places` are overwritten.
pub(crate) fn reflect(r: &mut [f64], n: usize, columns: ColumnPlaces, block: &mut RowBlock) {
    let stride = block.stride();
    let rows = RowGroups { numbers: block.numbers(), stride };
    #[cfg(target_arch = "x86_64")]
    if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
        // SAFETY: the processor has the features that `reflect_fused` is compiled for.
        return unsafe { reflect_fused(r, n, columns, rows) };
    }
    reflect_with::<[f64; 4]>(r, n, columns, rows);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn reflect_fused(r: &mut [f64], n: usize, columns: ColumnPlaces, rows: RowGroups) {
    reflect_with::<Register>(r, n, columns, rows);
}

/// Adds W'W to `products`, where W are the columns at `places` of the rows of `block`. `products` is m x m; entry (i, j) with i
/// <= j is at j m + i.
pub fn add_products(products: &mut [f64], places: &[usize], block: &mut RowBlock) {
    let stride = block.stride();
    let rows = RowGroups { numbers: block.numbers(), stride };
    #[cfg(target_arch = "x86_64")]
    if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
        // SAFETY: the processor has the features that `add_products_fused` is compiled for.
        return unsafe { add_products_fused(products, places, rows) };
    }
    add_products_with::<[f64; 4]>(products, places, rows);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn add_products_fused(products: &mut [f64], places: &[usize], rows: RowGroups) {
    add_products_with::<Register>(products, places, rows);
}

/// Writes linear combinations of the first m columns of a block into its next m columns. Column m + b is the sum over a of
/// factors\[b m + a\] times column a.
pub fn combine(factors: &[f64], m: usize, block: &mut RowBlock) {
    let stride = block.stride();
    let rows = RowGroups { numbers: block.numbers(), stride };
    #[cfg(target_arch = "x86_64")]
    if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
        // SAFETY: the processor has the features that `combine_fused` is compiled for.
        return unsafe { combine_fused(factors, m, rows) };
    }
    combine_with::<[f64; 4]>(factors, m, rows);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn combine_fused(factors: &[f64], m: usize, rows: RowGroups) {
    combine_with::<Register>(factors, m, rows);
}

/// The rows of a block, in groups of eight; `stride` is the number of entries from one group to the next.
struct RowGroups<'a> {
    numbers: &'a mut [Eight],
    stride: usize,
}

/// Four numbers of a column, stored in an array or in a vector register.
trait Four: Copy {
    fn splat(x: f64) -> Self;
    /// The first (`half` = 0) or the second half of eight numbers.
    fn read(eight: &Eight, half: usize) -> Self;
    fn write(self, eight: &mut Eight, half: usize);
    /// Computes self * b + c. The result is rounded once if the numbers are in a vector register, and twice in an array.
    fn mul_add(self, b: Self, c: Self) -> Self;
    fn numbers(self) -> [f64; 4];
}

impl Four for [f64; 4] {
    fn splat(x: f64) -> [f64; 4] {
        [x; 4]
    }
    fn read(eight: &Eight, half: usize) -> [f64; 4] {
        eight.0.as_chunks().0[half]
    }
    fn write(self, eight: &mut Eight, half: usize) {
        eight.0.as_chunks_mut().0[half] = self;
    }
    fn mul_add(self, b: [f64; 4], c: [f64; 4]) -> [f64; 4] {
        std::array::from_fn(|l| self[l] * b[l] + c[l])
    }
    fn numbers(self) -> [f64; 4] {
        self
    }
}

#[cfg(target_arch = "x86_64")]
#[derive(Clone, Copy)]
struct Register(std::arch::x86_64::__m256d);

#[cfg(target_arch = "x86_64")]
impl Four for Register {
    #[inline(always)]
    fn splat(x: f64) -> Register {
        unsafe { Register(std::arch::x86_64::_mm256_set1_pd(x)) }
    }
    #[inline(always)]
    fn read(eight: &Eight, half: usize) -> Register {
        let four: &[f64; 4] = &eight.0.as_chunks().0[half];
        unsafe { Register(std::arch::x86_64::_mm256_loadu_pd(four.as_ptr())) }
    }
    #[inline(always)]
    fn write(self, eight: &mut Eight, half: usize) {
        let four: &mut [f64; 4] = &mut eight.0.as_chunks_mut().0[half];
        unsafe { std::arch::x86_64::_mm256_storeu_pd(four.as_mut_ptr(), self.0) }
    }
    #[inline(always)]
    fn mul_add(self, b: Register, c: Register) -> Register {
        unsafe { Register(std::arch::x86_64::_mm256_fmadd_pd(self.0, b.0, c.0)) }
    }
    #[inline(always)]
    fn numbers(self) -> [f64; 4] {
        let mut numbers = [0.0; 4];
        unsafe { std::arch::x86_64::_mm256_storeu_pd(numbers.as_mut_ptr(), self.0) };
        numbers
    }
}

#[inline(always)]
fn sum(x: impl Four) -> f64 {
    let [a, b, c, d] = x.numbers();
    (a + c) + (b + d)
}

/// The dot products of columns x_a and y_b over all rows; result `[b][a]`.
#[inline(always)]
fn dots<V: Four, const X: usize, const Y: usize>(rows: &RowGroups, x: [usize; X], y: [usize; Y]) -> [[f64; X]; Y] {
    let mut sums = [[V::splat(0.0); X]; Y];
    for group in rows.numbers.chunks_exact(rows.stride) {
        for half in 0..2 {
            for b in 0..Y {
                let column = V::read(&group[y[b]], half);
                for a in 0..X {
                    sums[b][a] = V::read(&group[x[a]], half).mul_add(column, sums[b][a]);
                }
            }
        }
    }
    let mut dots = [[0.0; X]; Y];
    for b in 0..Y {
        for a in 0..X {
            dots[b][a] = sum(sums[b][a]);
        }
    }
    dots
}

/// The sum of squares of column x. The halves of eight rows have separate sums, because in one sum each addition waits for the
/// previous one.
#[inline(always)]
fn square<V: Four>(rows: &RowGroups, x: usize) -> f64 {
    let mut sums = [V::splat(0.0); 2];
    for group in rows.numbers.chunks_exact(rows.stride) {
        for half in 0..2 {
            let column = V::read(&group[x], half);
            sums[half] = column.mul_add(column, sums[half]);
        }
    }
    sum(sums[0]) + sum(sums[1])
}

/// Subtracts sum_a f_ba x_a from each column y_b.
#[inline(always)]
fn subtract<V: Four, const X: usize, const Y: usize>(
    rows: &mut RowGroups,
    x: [usize; X],
    y: [usize; Y],
    f: [[f64; X]; Y],
) {
    let mut factors = [[V::splat(0.0); X]; Y];
    for b in 0..Y {
        for a in 0..X {
            factors[b][a] = V::splat(-f[b][a]);
        }
    }
    for group in rows.numbers.chunks_exact_mut(rows.stride) {
        for half in 0..2 {
            for b in 0..Y {
                let mut column = V::read(&group[y[b]], half);
                for a in 0..X {
                    column = V::read(&group[x[a]], half).mul_add(factors[b][a], column);
                }
                column.write(&mut group[y[b]], half);
            }
        }
    }
}

#[inline(always)]
fn reflect_with<V: Four>(r: &mut [f64], n: usize, columns: ColumnPlaces, mut rows: RowGroups) {
    let ColumnPlaces { index, places } = columns;
    let at = |i: usize, j: usize| index[j] * n + index[i];
    let m = places.len();
    for first in (0..m).step_by(4) {
        let width = (m - first).min(4);
        let (mut lead, mut t) = ([0.0; 4], [[0.0; 4]; 4]);
        // Computes four reflections. Each reflection is also applied to the later ones of the four columns.
        for k in 0..width {
            let x = places[first + k];
            let below = square::<V>(&rows, x);
            if below <= NEGLIGIBLE_SQUARES {
                continue;
            }
            let pivot = r[at(first + k, first + k)];
            let beta = -pivot.signum() * (pivot * pivot + below).sqrt();
            r[at(first + k, first + k)] = beta;
            (lead[k], t[k][k]) = (pivot - beta, 1.0 / (beta * (beta - pivot)));
            let one = (lead[k], t[k][k], x);
            let rest = |b: usize| (at(first + k, first + k + 1 + b), places[first + k + 1 + b]);
            match width - k {
                4 => reflect_columns::<V, 3>(r, &mut rows, one, [rest(0), rest(1), rest(2)]),
                3 => reflect_columns::<V, 2>(r, &mut rows, one, [rest(0), rest(1)]),
                2 => reflect_columns::<V, 1>(r, &mut rows, one, [rest(0)]),
                _ => {}
            }
        }
        if first + 4 >= m {
            break;
        }
        // The matrix T of the combined reflections, column by column: T_ik = -T_kk sum_l T_il x_l . x_k.
        let x = [places[first], places[first + 1], places[first + 2], places[first + 3]];
        for k in 1..4 {
            let [products] = dots::<V, 4, 1>(&rows, x, [x[k]]);
            for i in 0..k {
                t[i][k] = -t[k][k] * (i..k).map(|l| t[i][l] * products[l]).sum::<f64>();
            }
        }
        // All four reflections together are applied to the later columns, two columns at a time.
        let four = Reflections { lead, t, x };
        let mut j = first + 4;
        while j + 1 < m {
            four.apply::<V, 2>(r, &mut rows, |k, b| at(first + k, j + b), [places[j], places[j + 1]]);
            j += 2;
        }
        if j < m {
            four.apply::<V, 1>(r, &mut rows, |k, _| at(first + k, j), [places[j]]);
        }
    }
}

#[inline(always)]
fn add_products_with<V: Four>(products: &mut [f64], places: &[usize], rows: RowGroups) {
    let m = places.len();
    // If fewer than four columns are left, the last column is repeated to fill up four. The additional products are not read.
    let at = |k: usize| places[k.min(m - 1)];
    for i in (0..m).step_by(4) {
        for j in (i..m).step_by(2) {
            let found = dots::<V, 4, 2>(&rows, [at(i), at(i + 1), at(i + 2), at(i + 3)], [at(j), at(j + 1)]);
            for (j, found) in (j..m).zip(found) {
                (i..=j).zip(found).for_each(|(i, product)| products[j * m + i] += product);
            }
        }
    }
}

#[inline(always)]
fn combine_with<V: Four>(factors: &[f64], m: usize, rows: RowGroups) {
    for group in rows.numbers.chunks_exact_mut(rows.stride) {
        let (columns, combined) = group.split_at_mut(m);
        let mut b = 0;
        while b < m {
            // Four combinations are computed at a time, and the last three or fewer one by one.
            let width = if b + 4 <= m { 4 } else { 1 };
            match width {
                4 => combined_columns::<V, 4>(&factors[b * m..], columns, &mut combined[b..]),
                _ => combined_columns::<V, 1>(&factors[b * m..], columns, &mut combined[b..]),
            }
            b += width;
        }
    }
}

#[inline(always)]
fn combined_columns<V: Four, const Y: usize>(factors: &[f64], columns: &[Eight], combined: &mut [Eight]) {
    let m = columns.len();
    let factors: [&[f64]; Y] = std::array::from_fn(|b| &factors[b * m..][..m]);
    let mut sums = [[V::splat(0.0); 2]; Y];
    for a in 0..m {
        let halves = [V::read(&columns[a], 0), V::read(&columns[a], 1)];
        for b in 0..Y {
            let factor = V::splat(factors[b][a]);
            for half in 0..2 {
                sums[b][half] = halves[half].mul_add(factor, sums[b][half]);
            }
        }
    }
    for b in 0..Y {
        for half in 0..2 {
            sums[b][half].write(&mut combined[b], half);
        }
    }
}

/// Applies one reflection to columns of the triangle and of the rows. The reflection is given by `lead` = R_kk - beta_k,
/// `factor` = T_kk, and column x of the rows. `columns`: index of each column in R and in the rows.
#[inline(always)]
fn reflect_columns<V: Four, const Y: usize>(
    r: &mut [f64],
    rows: &mut RowGroups,
    (lead, factor, x): (f64, f64, usize),
    columns: [(usize, usize); Y],
) {
    let mut y = [0; Y];
    for b in 0..Y {
        y[b] = columns[b].1;
    }
    let products = dots::<V, 1, Y>(rows, [x], y);
    let mut f = [[0.0]; Y];
    for b in 0..Y {
        let top = columns[b].0;
        f[b][0] = factor * (lead * r[top] + products[b][0]);
        r[top] -= f[b][0] * lead;
    }
    subtract::<V, 1, Y>(rows, [x], y, f);
}

/// Four combined reflections. `lead`: R_kk - beta_k; `t`: T; `x`: places in a row of the columns x_k.
struct Reflections {
    lead: [f64; 4],
    t: [[f64; 4]; 4],
    x: [usize; 4],
}

impl Reflections {
    /// Applies the four reflections to the columns `y` of the rows, and to the rows of the triangle. `top(k, b)`: index in `r`
    /// of the entry for reflection k and column b of `y`.
    #[inline(always)]
    fn apply<V: Four, const Y: usize>(
        &self,
        r: &mut [f64],
        rows: &mut RowGroups,
        top: impl Fn(usize, usize) -> usize,
        y: [usize; Y],
    ) {
        let products = dots::<V, 4, Y>(rows, self.x, y);
        let mut f = [[0.0; 4]; Y];
        for b in 0..Y {
            let mut s = [0.0; 4];
            for k in 0..4 {
                s[k] = self.lead[k] * r[top(k, b)] + products[b][k];
                for l in 0..=k {
                    f[b][k] += self.t[l][k] * s[l];
                }
                r[top(k, b)] -= self.lead[k] * f[b][k];
            }
        }
        subtract::<V, 4, Y>(rows, self.x, y, f);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use random::Random;

    /// Combinations of seven columns are right with and without vector registers.
    #[test]
    fn combinations_of_columns() {
        let (m, mut random) = (7, Random::new(6));
        let factors: Vec<f64> = (0..m * m).map(|_| random.normal()).collect();
        let rows: Vec<Vec<f64>> = (0..21).map(|_| (0..m).map(|_| random.normal()).collect()).collect();
        let mut block = RowBlock::new(2 * m);
        rows.iter().for_each(|row| block.push(row.iter().copied()));
        let mut plain = block.clone();
        combine(&factors, m, &mut block);
        let stride = plain.stride();
        combine_with::<[f64; 4]>(&factors, m, RowGroups { numbers: plain.numbers(), stride });
        for (r, row) in rows.iter().enumerate() {
            for b in 0..m {
                let sum: f64 = (0..m).map(|a| factors[b * m + a] * row[a]).sum();
                for block in [&mut block, &mut plain] {
                    // Allowed error: rounding of sums of seven products of unit size.
                    assert!((block.group(r / 8)[m + b].0[r % 8] - sum).abs() < 1e-13, "{r} {b}");
                }
            }
        }
    }

    /// R'R = W'W holds with and without vector registers, for 11 columns, one of them zero, and twice 128 rows.
    #[test]
    fn the_products_of_the_rows_are_kept() {
        let (m, places): (usize, Vec<usize>) = (11, vec![3, 4, 5, 0, 1, 2, 12, 11, 10, 9, 8]);
        let index: Vec<usize> = (0..m).collect();
        let mut random = Random::new(5);
        let mut triangles = [vec![0.0; m * m], vec![0.0; m * m]];
        let mut sums = triangles.clone();
        let mut products = vec![0.0; m * m];
        for _ in 0..2 {
            let mut block = RowBlock::new(13);
            while !block.is_full() {
                let row: Vec<f64> = (0..13).map(|c| if c == 4 { 0.0 } else { random.normal() }).collect();
                for (k, product) in products.iter_mut().enumerate() {
                    *product += row[places[k % m]] * row[places[k / m]];
                }
                block.push(row.into_iter());
            }
            let mut plain = block.clone();
            add_products(&mut sums[0], &places, &mut plain);
            let rows = RowGroups { stride: plain.stride(), numbers: plain.numbers() };
            add_products_with::<[f64; 4]>(&mut sums[1], &places, rows);
            let columns = ColumnPlaces { index: &index, places: &places };
            reflect(&mut triangles[0], m, columns, &mut block);
            let stride = plain.stride();
            let rows = RowGroups { numbers: plain.numbers(), stride };
            reflect_with::<[f64; 4]>(&mut triangles[1], m, columns, rows);
        }
        for (sums, (k, product)) in sums.iter().flat_map(|sums| products.iter().enumerate().map(move |p| (sums, p))) {
            // Allowed error: rounding of sums of 256 products of unit size, 256 eps.
            assert!(k % m > k / m || (sums[k] - product).abs() < 1e-12, "{k}: {} {product}", sums[k]);
        }
        for r in &triangles {
            for (k, product) in products.iter().enumerate() {
                let (i, j) = (k % m, k / m);
                let of_r: f64 = (0..=i.min(j)).map(|l| r[i * m + l] * r[j * m + l]).sum();
                // Allowed error: rounding of sums of 256 products of unit size, 256 eps.
                assert!((of_r - product).abs() < 1e-12, "{i} {j}: {of_r} {product}");
            }
        }
    }
}
