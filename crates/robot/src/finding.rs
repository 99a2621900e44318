//! Suspicious values of a robot description, and the kinds of mistakes that they indicate.

/// One suspicious value of one link.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// Name of the link, or of a body that is fixed to it.
    pub link: String,
    /// The probable kind of mistake.
    pub mistake: Mistake,
    /// The evidence as a sentence with numbers.
    pub text: String,
}

/// The usual mistakes in robot descriptions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mistake {
    /// The mass is negative.
    NegativeMass,
    /// The inertia is not zero, but the mass is zero.
    InertiaWithoutMass,
    /// A principal moment of inertia is negative.
    NotPositive,
    /// A principal moment of inertia is larger than the sum of the two others.
    TriangleInequality,
    /// Ixz and Iyz are probably exchanged: with the exchange, the inertia is physically possible.
    SwappedProducts,
    /// The values are in the order of Pinocchio (Iyy before Ixz), but they were read in another order.
    SwappedOrder,
    /// The inertia is about the centre of mass instead of the origin, or about the origin instead of the centre of mass.
    WrongPoint,
    /// The inertial frame is rotated (rpy), so a program that ignores rpy reads a different inertia.
    TurnedInertialFrame,
    /// The values seem to be in g or mm instead of kg or m.
    Units,
    /// The link has a shape, but no mass.
    ShapeWithoutMass,
    /// The link has a mass, but no inertia.
    MassWithoutInertia,
    /// The value is a default that an exporter writes if the true value is unknown.
    Placeholder,
    /// Most links have the same inertial parameters, so they are probably copies.
    Copied,
    /// The mass does not fit the volume of the collision shapes.
    Density,
    /// The centre of mass lies far outside the collision shapes.
    CentreOutside,
    /// The joint limits have no effect, are zero, or are in degrees.
    Limits,
    /// Angles exceed a full turn, so they are probably in degrees.
    Degrees,
    /// Other programs interpret the text of the file differently, or refuse it.
    OtherReaders,
}
