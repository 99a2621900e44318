//! The motion of a frame per unit of an error of the geometry of each link before it, for a kinematic calibration.
//!
//! Link k follows its antecedent i by Rz(gamma) Tz(b) Ry(beta) Rx(alpha) Tx(d) Rz(theta) Tz(r), where beta = 0 is the angle of
//! Hayati for nearly parallel axes [Khalil, Dombre 2002, chapter 11; Hayati, Mirmirani 1985]. A turn about the axis a through the
//! point o, and a slide along a, move the origin p of the frame by
//! ```text
//! turn:  v = a x (p - o),  w = a        slide:  v = a,  w = 0
//! ```
//! The axes are z of frame i for gamma and b; y and x of frame i after the turn by gamma for beta, and for alpha and d; z of link k
//! for theta and r. The derivatives are exact. A passive joint keeps its position.

use expr::{Expr, Function, Output};
use robot::LinkId;

use crate::derivation::Derivation;
use crate::dynamics::link_frame::LinkFrame;
use crate::dynamics::reference_frame::{ReferenceFrame, constants, in_axes_of, suffix, turned_to};
use crate::kinematics::links::Geometry;
use crate::kinematics::vector::{NULL, Vector, add, cross};

/// Velocity of the origin of a frame, then angular velocity, per unit of an error.
type Twist = [Vector; 2];

impl Derivation<'_> {
    /// Derivatives of the pose of a frame by the errors of gamma, b, beta, alpha, d, theta and r of each link from the base to the
    /// frame, as a function: input `q`, output `j` (6 x 7 per link): velocity of the origin of the frame, then angular velocity,
    /// in the axes of `reference`, or of the frame itself for `None`.
    pub fn geometric_error_jacobian(
        &mut self,
        frame: impl Into<LinkFrame>,
        reference: Option<&ReferenceFrame>,
    ) -> Function {
        let frame = &frame.into();
        let columns = self.error_columns(frame, reference).into_iter().flat_map(|of_link| of_link.1).collect();
        self.twists_function("geometric_error_jacobian", frame, reference, columns)
    }

    /// The derivatives of [`Derivation::geometric_error_jacobian`] in the axes of the link, with six more columns before the
    /// seven of each link: slides along x, y and z of the frame of its antecedent, then turns about x, y and z of this frame.
    pub(crate) fn geometric_twists(&mut self, link: LinkId) -> Function {
        let frame = &LinkFrame::from(link);
        let of_link = |(frame, errors): ([Twist; 6], [Twist; 7])| frame.into_iter().chain(errors);
        let columns = self.error_columns(frame, None).into_iter().flat_map(of_link).collect();
        self.twists_function("geometric_twists", frame, None, columns)
    }

    /// A function with these twists as the columns of its output `j`.
    fn twists_function(
        &self,
        name: &str,
        frame: &LinkFrame,
        reference: Option<&ReferenceFrame>,
        columns: Vec<Twist>,
    ) -> Function {
        let entries = (0..6).flat_map(|row| columns.iter().map(move |twist| twist[row / 3][row % 3])).collect();
        let output = Output { name: "j".into(), rows: 6, columns: columns.len(), entries };
        let name = frame.function(name) + &suffix(reference);
        Function::new(&name, &self.graph, self.motion.configuration(), vec![output])
    }

    /// For each link from the base to the frame: the twists of the frame of its antecedent, and of its seven errors.
    fn error_columns(
        &mut self,
        frame: &LinkFrame,
        reference: Option<&ReferenceFrame>,
    ) -> Vec<([Twist; 6], [Twist; 7])> {
        let robot = self.robot;
        let chain: Vec<LinkId> = std::iter::successors(Some(frame.link), |&j| robot.link(j).antecedent).collect();
        let mut p = constants(&mut self.graph, frame.pose.position);
        let mut columns = Vec::new();
        for (place, &k) in chain.iter().enumerate() {
            let (of_frame, errors, in_antecedent) = self.twists_of(k, p);
            p = in_antecedent;
            let mut expressed = |twist: Twist| twist.map(|v| self.expressed(v, &chain[..=place], frame, reference));
            columns.push((of_frame.map(&mut expressed), errors.map(&mut expressed)));
        }
        columns.reverse();
        columns
    }

    /// Velocity of the point p and angular velocity, in frame k, per unit of: the slides and turns of the frame of the antecedent;
    /// the seven errors of link k. Third result: p in the frame of the antecedent. `p`: the point, in frame k.
    fn twists_of(&mut self, k: LinkId, p: Vector) -> ([Twist; 6], [Twist; 7], Vector) {
        let b = Geometry::of(&mut self.graph, &mut self.constants, self.robot.link(k)).b;
        let (placement, g) = (self.links[k.0].placement.clone(), &mut self.graph);
        let from_origin = placement.to_antecedent(g, p);
        let from_origin = add(g, from_origin, placement.p);
        let mut from_b = from_origin;
        from_b[2] = g.sub(from_b[2], b);
        let [x, y, z] = [0, 1, 2].map(|c| [0, 1, 2].map(|r| if r == c { Expr::ONE } else { Expr::ZERO }));
        let turned = |g: &mut _, axis| placement.gamma.unturned(g, axis);
        let (across, along) = (turned(g, y), turned(g, x));
        let turn = |g: &mut _, axis: Vector, from: Vector| [cross(g, axis, from), axis];
        let before =
            [turn(g, z, from_origin), [z, NULL], turn(g, across, from_b), turn(g, along, from_b), [along, NULL]];
        let of_frame = [
            [x, NULL],
            [y, NULL],
            [z, NULL],
            turn(g, x, from_origin),
            turn(g, y, from_origin),
            turn(g, z, from_origin),
        ];
        let mut to_link = |twist: Twist| twist.map(|v| placement.to_link(g, v));
        let ([gamma, b, beta, alpha, d], of_frame) = (before.map(&mut to_link), of_frame.map(&mut to_link));
        (of_frame, [gamma, b, beta, alpha, d, turn(g, z, p), [z, NULL]], from_origin)
    }

    /// The vector v, in the axes of the last link of `chain`, in the axes of `reference`, or of the frame for `None`. `chain`: the
    /// links from the link of the frame inwards.
    fn expressed(
        &mut self,
        v: Vector,
        chain: &[LinkId],
        frame: &LinkFrame,
        reference: Option<&ReferenceFrame>,
    ) -> Vector {
        let Derivation { robot, graph: g, links, .. } = self;
        match (reference, chain.split_last()) {
            (Some(reference), Some((k, _))) => in_axes_of(g, robot, links, v, *k, reference),
            (_, Some((_, outer))) => {
                let v = outer.iter().rev().fold(v, |v, j| links[j.0].placement.to_link(g, v));
                turned_to(g, &frame.pose, v)
            }
            (_, None) => v,
        }
    }
}
