//! Vectors with three components and 3 x 3 matrices in f64; lengths in m.
//!
//! All functions are `#[inline]`, because the distance computations in another crate consist mainly of them.

/// A vector with three components.
pub type Vector3 = [f64; 3];
/// A 3 x 3 matrix, row by row.
pub type Matrix3 = [[f64; 3]; 3];

/// The scalar product a . b.
#[inline]
pub fn dot(a: Vector3, b: Vector3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The vector product a x b.
#[inline]
pub fn cross(a: Vector3, b: Vector3) -> Vector3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// The Euclidean norm of a.
#[inline]
pub fn norm(a: Vector3) -> f64 {
    dot(a, a).sqrt()
}

/// The vector a multiplied by a factor.
#[inline]
pub fn scaled(a: Vector3, factor: f64) -> Vector3 {
    a.map(|x| x * factor)
}

/// The sum a + b.
#[inline]
pub fn plus(a: Vector3, b: Vector3) -> Vector3 {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// The difference a - b.
#[inline]
pub fn minus(a: Vector3, b: Vector3) -> Vector3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// The sum a + factor b.
#[inline]
pub(crate) fn plus_scaled(a: Vector3, b: Vector3, factor: f64) -> Vector3 {
    [0, 1, 2].map(|i| a[i] + factor * b[i])
}

/// The matrix-vector product m v.
#[inline]
pub fn turned(m: &Matrix3, v: Vector3) -> Vector3 {
    m.map(|row| dot(row, v))
}

/// The product m' v with the transposed matrix.
#[inline]
pub fn turned_back(m: &Matrix3, v: Vector3) -> Vector3 {
    [0, 1, 2].map(|k| m[0][k] * v[0] + m[1][k] * v[1] + m[2][k] * v[2])
}

/// The matrix product a b.
#[inline]
pub(crate) fn product(a: &Matrix3, b: &Matrix3) -> Matrix3 {
    a.map(|row| [0, 1, 2].map(|j| row[0] * b[0][j] + row[1] * b[1][j] + row[2] * b[2][j]))
}

#[inline]
pub(crate) fn transposed(m: &Matrix3) -> Matrix3 {
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| m[j][i]))
}

/// The rotation matrix for a rotation by `angle` (rad) about the unit vector `axis` (Rodrigues' formula).
#[inline]
pub(crate) fn rotation_about(axis: Vector3, angle: f64) -> Matrix3 {
    rotation_by(axis, angle.sin_cos())
}

/// The rotation matrix for a rotation about a unit vector; the angle is given by its sine and cosine.
#[inline]
pub(crate) fn rotation_by([x, y, z]: Vector3, (s, c): (f64, f64)) -> Matrix3 {
    let v = 1.0 - c;
    [
        [c + x * x * v, x * y * v - z * s, x * z * v + y * s],
        [y * x * v + z * s, c + y * y * v, y * z * v - x * s],
        [z * x * v - y * s, z * y * v + x * s, c + z * z * v],
    ]
}
