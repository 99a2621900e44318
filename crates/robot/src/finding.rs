//! What looks wrong in a description, and the kinds of it.

/// One suspicion about one link.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// Name of the link, or of the part of it.
    pub link: String,
    /// What looks wrong.
    pub mistake: Mistake,
    /// The evidence, with numbers.
    pub text: String,
}

/// The classic mistakes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mistake {
    /// The mass is below zero.
    NegativeMass,
    /// There is an inertia, but no mass that could have it.
    InertiaWithoutMass,
    /// A principal moment is negative.
    NotPositive,
    /// A principal moment is larger than the sum of the two others.
    TriangleInequality,
    /// Exchanging Ixz and Iyz would make it possible.
    SwappedProducts,
    /// Pinocchio's order read as another.
    SwappedOrder,
    /// About the centre of mass where the origin is meant, or the other way round.
    WrongPoint,
    /// The inertial frame is turned, and a program that ignores rpy reads another inertia.
    TurnedInertialFrame,
    /// g or mm where kg or m are meant.
    Units,
    /// There is a shape, but no mass.
    ShapeWithoutMass,
    /// There is a mass, but no inertia.
    MassWithoutInertia,
    /// What an exporter writes where it knows nothing.
    Placeholder,
    /// Most links have one inertial.
    Copied,
    /// The mass does not fit the collision shapes.
    Density,
    /// The centre of mass lies far outside the collision shapes.
    CentreOutside,
    /// Limits that are none, of zero, or in degrees.
    Limits,
    /// Orientations of more than a turn.
    Degrees,
    /// Other readers take the text otherwise, or refuse it.
    OtherReaders,
}
