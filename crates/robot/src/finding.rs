//! Suspicious values of a description, and their kinds.

/// One suspicious value of one link.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// Name of the link, or of the part of it.
    pub link: String,
    /// The kind of mistake.
    pub mistake: Mistake,
    /// The evidence, with numbers.
    pub text: String,
}

/// The usual mistakes in descriptions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mistake {
    /// The mass is below zero.
    NegativeMass,
    /// There is an inertia, but no mass.
    InertiaWithoutMass,
    /// A principal moment is negative.
    NotPositive,
    /// A principal moment is larger than the sum of the two others.
    TriangleInequality,
    /// The inertia would be physical with Ixz and Iyz exchanged.
    SwappedProducts,
    /// Values in Pinocchio's order were read in another order.
    SwappedOrder,
    /// The inertia is about the centre of mass where the origin is meant, or about the origin where the centre is meant.
    WrongPoint,
    /// The inertial frame is turned, and a program that ignores rpy reads another inertia.
    TurnedInertialFrame,
    /// g or mm where kg or m are meant.
    Units,
    /// There is a shape, but no mass.
    ShapeWithoutMass,
    /// There is a mass, but no inertia.
    MassWithoutInertia,
    /// A default value that an exporter writes for an unknown one.
    Placeholder,
    /// Most links have equal inertial parameters.
    Copied,
    /// The mass does not fit the collision shapes.
    Density,
    /// The centre of mass lies far outside the collision shapes.
    CentreOutside,
    /// Limits without effect, of zero, or in degrees.
    Limits,
    /// Orientations of more than a turn.
    Degrees,
    /// Other readers interpret the text differently, or refuse it.
    OtherReaders,
}
