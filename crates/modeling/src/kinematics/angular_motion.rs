//! The angular motion of a link (w w^T, dw, U = [dw]x + [w]x^2), with as few operations as its joint allows. w: angular
//! velocity, dw: angular acceleration.
//!
//! U z is the second derivative of the unit vector z along the joint axis. The axis is also fixed in the antecedent. So U z
//! follows from the U of the antecedent and only has to be rotated with the joint:
//!
//! ```text
//! U z = (w_x w_z + dw_y, w_y w_z - dw_x, -(w_x^2 + w_y^2))
//! ```
//! U z gives dw_x and dw_y without products with the joint's rate, and w_x^2 + w_y^2 without a square.

use expr::{Expr, Graph};

use crate::kinematics::vector::{Vector, ZRotation};

/// The second derivative U z of the unit vector z along a joint axis, in axes before the rotation of the joint.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bend {
    pub x: Expr,
    pub y: Expr,
    /// w_x^2 + w_y^2 (w: angular velocity) if this sum follows from the antecedent's U; `None` if two squares must be computed.
    pub across: Option<Expr>,
}

impl Bend {
    /// The second derivative U z = 0 of an axis at rest.
    pub(crate) const STILL: Bend = Bend { x: Expr::ZERO, y: Expr::ZERO, across: Some(Expr::ZERO) };

    /// Makes the bend from the three components of U z.
    pub(crate) fn of_column([x, y, z]: Vector) -> Bend {
        Bend { x, y, across: Some(-z) }
    }

    /// Makes the bend U z from dw (angular acceleration) and the products w_x w_z and w_y w_z.
    pub(crate) fn of_rates(g: &mut Graph, dw: Vector, [xz, yz]: [Expr; 2]) -> Bend {
        Bend { x: g.add(xz, dw[1]), y: g.sub(yz, dw[0]), across: None }
    }

    /// The same vector U z in axes rotated about z by `turn`.
    pub(crate) fn turned(self, g: &mut Graph, turn: ZRotation) -> Bend {
        let [x, y, _] = turn.turned(g, [self.x, self.y, Expr::ZERO]);
        Bend { x, y, ..self }
    }
}

/// The angular motion of a link, in the link's frame; all entries in rad/s^2.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AngularMotion {
    pub dw: Vector,
    /// The products w w^T of the angular velocity, row by row.
    pub ww: [Vector; 3],
    /// Differences of squares of the angular velocity: w_y^2 - w_z^2, w_z^2 - w_x^2, w_x^2 - w_y^2.
    pub differences: Vector,
    /// The matrix U = [dw]x + [w]x^2, row by row.
    pub U: [Vector; 3],
}

impl AngularMotion {
    /// The angular motion of a link from the bend U z of its joint axis, from dw_z, and from `product(i, k)` = w_i w_k.
    pub(crate) fn new(
        g: &mut Graph,
        bend: Bend,
        dw_z: Expr,
        mut product: impl FnMut(&mut Graph, usize, usize) -> Expr,
    ) -> AngularMotion {
        let (xx, zz) = (product(g, 0, 0), product(g, 2, 2));
        let [xy, xz, yz] = [(0, 1), (0, 2), (1, 2)].map(|(i, k)| product(g, i, k));
        let dw = [g.sub(yz, bend.y), g.sub(bend.x, xz), dw_z];

        // The diagonal entries of U are w_i^2 - |w|^2. So the differences of these entries equal the differences of the squares
        // w_i^2.
        let (yy, across) = match bend.across {
            Some(across) => (g.sub(across, xx), across),
            None => {
                let yy = product(g, 1, 1);
                (yy, g.add(xx, yy))
            }
        };
        let z_x = g.sub(zz, xx);
        let u_yy = -g.add(xx, zz);
        let (u_xx, y_z, x_y) = match bend.across {
            Some(_) => {
                let u_xx = -g.add(across, z_x);
                (u_xx, g.add(u_yy, across), g.sub(u_xx, u_yy))
            }
            None => (-g.add(yy, zz), g.sub(yy, zz), g.sub(xx, yy)),
        };
        let U = [
            [u_xx, g.sub(xy, dw[2]), bend.x],
            [g.add(xy, dw[2]), u_yy, bend.y],
            [g.sub(xz, dw[1]), g.add(yz, dw[0]), -across],
        ];
        AngularMotion { dw, ww: [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]], differences: [y_z, z_x, x_y], U }
    }
}
