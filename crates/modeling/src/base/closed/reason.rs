//! Why there is no exact rank of a robot with loops.

use std::fmt;

/// Why the rank of a robot with loops is known only numerically, although its loops are closed by a search in the field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoCertificate {
    /// A joint turns by a factor that is no ratio of small integers.
    Ratio,
    /// The equations of the loops have none of the forms that are solved in the field.
    OtherForm,
    /// If lengths with the same symbol stay equal, the loops close in the field only with some length zero.
    EqualLengths,
    /// The points that were found are singular: the coordinates do not determine the passive joints there.
    Singular,
    /// The points that were found have special lengths, or the loops do not move there.
    Overconstrained,
    /// The loops have assemblies of several ranks, and no evaluated assembly has the numeric rank.
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
