//! Three-vectors in f64.

pub(crate) type Vector3 = [f64; 3];

pub(crate) fn dot(a: Vector3, b: Vector3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn cross(a: Vector3, b: Vector3) -> Vector3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(crate) fn minus(a: Vector3, b: Vector3) -> Vector3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(crate) fn plus(a: Vector3, b: Vector3) -> Vector3 {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

pub(crate) fn scaled(a: Vector3, factor: f64) -> Vector3 {
    a.map(|x| factor * x)
}

pub(crate) fn norm(a: Vector3) -> f64 {
    dot(a, a).sqrt()
}

/// R v of a rotation by rows.
pub(crate) fn turned(rotation: &[Vector3; 3], v: Vector3) -> Vector3 {
    rotation.map(|row| dot(row, v))
}

/// R' v of a rotation by rows.
pub(crate) fn turned_back(rotation: &[Vector3; 3], v: Vector3) -> Vector3 {
    [0, 1, 2].map(|k| rotation[0][k] * v[0] + rotation[1][k] * v[1] + rotation[2][k] * v[2])
}
