//! The reasons why the rank of a robot with loops cannot be determined exactly, at points of a finite field at which the loops
//! are closed.

use std::fmt;

/// The reason why the rank of a robot with loops is known only numerically and not from a finite field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoCertificate {
    /// A joint turns by a multiple of a variable, and the factor is no ratio of small integers.
    Ratio,
    /// The closure equations of the loops have none of the forms for which there is a solution method in the field.
    OtherForm,
    /// Because lengths with the same symbol stay equal, the loops close in the field only if some length is zero.
    EqualLengths,
    /// All points found in the field are singular: the coordinates do not determine the passive joints there.
    Singular,
    /// The points found in the field have special lengths, or the loops do not move there.
    Overconstrained,
    /// The loops have assemblies with different ranks, and no evaluated assembly has the numeric rank.
    OtherAssemblies,
}

impl fmt::Display for NoCertificate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            NoCertificate::Ratio => "a joint turns by a factor that is no ratio of small integers",
            NoCertificate::OtherForm => "the equations of the loops are of no form that is solved in a finite field",
            NoCertificate::EqualLengths => {
                "with the lengths that are equal on purpose there is no free assembly in a finite field"
            }
            NoCertificate::Singular => "every point found in a finite field is singular",
            NoCertificate::Overconstrained => {
                "in a finite field only assemblies were found that move at special lengths and angles alone, as overconstrained \
                 loops do"
            }
            NoCertificate::OtherAssemblies => {
                "the loops have assemblies of several ranks, and none that was found in a finite field has this one"
            }
        })
    }
}
