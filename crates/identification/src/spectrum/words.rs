//! Texts for reports of RIST-MH on effects other than friction (`rist_mh::effects`): the size of an effect, and the option that
//! adds a missing effect to the model.

use linear_model::regressor::Regressor;

use crate::estimate::claims::{LACKING_MODEL_CHI_SQUARE, NOISE_CHI_SQUARE};
use crate::estimate::digits::significant;
use crate::spectrum::rist_mh::cause::Cause;
use crate::spectrum::rist_mh::effects::{Effect, EffectSize};
use crate::spectrum::rist_mh::misfit::Misfit;

/// A text with the effect, its joint and its size: `q2 bends: 3.4e3 N m/rad`. `frequency`: natural frequency of an elastic
/// joint, Hz; `with_deviation`: whether standard deviations are added.
pub(crate) fn size_words(
    size: &EffectSize,
    regressor: &dyn Regressor,
    frequency: Option<f64>,
    with_deviation: bool,
) -> String {
    let name = |joint: usize| regressor.coordinates().get(joint).map_or("", String::as_str);
    let unit = |joint: usize, slide: &'static str, turn: &'static str| {
        if regressor.is_prismatic(joint) { slide } else { turn }
    };
    let value = |i: usize| size.values.get(i).copied().unwrap_or(0.0);
    let deviation = size.deviations.first().copied().unwrap_or(0.0);
    let both = |scale: f64, decimals: usize| match with_deviation {
        true => format!("{:.decimals$} +- {:.decimals$}", scale * value(0).abs(), scale * deviation),
        false => format!("{:.decimals$}", scale * value(0).abs()),
    };
    match size.effect {
        Effect::Delay => {
            let side = if value(0) < 0.0 { "early" } else { "late" };
            format!("the torques are {side} by {} ms", both(1e3, if with_deviation { 3 } else { 2 }))
        }
        Effect::Ripple { joint, periods } => format!(
            "{} has ripple of {:.1} % and of {} {} with {periods} periods a turn",
            name(joint),
            100.0 * value(2).hypot(value(3)),
            significant(value(0).hypot(value(1))),
            unit(joint, "N", "N m")
        ),
        Effect::Spring { joint } => {
            let unit = unit(joint, "N/m", "N m/rad");
            let spread = if with_deviation { format!(" +- {}", significant(deviation)) } else { String::new() };
            format!("a spring of {}{spread} {unit} acts on {}", significant(value(0)), name(joint))
        }
        Effect::Eccentric { joint } => format!(
            "the encoder of {} is off by {} {} once a turn",
            name(joint),
            significant(1e3 * value(0).hypot(value(1))),
            unit(joint, "mm", "mrad")
        ),
        Effect::Elastic { joint } => {
            let at = frequency.map_or(String::new(), |hz| format!(", {hz:.0} Hz with the motor held"));
            let stiffness = 1.0 / value(0);
            let spread = if with_deviation {
                format!(" +- {}", significant(deviation / value(0).powi(2)))
            } else {
                String::new()
            };
            // A damping that is not positive is noise and is not printed.
            let damping = if with_deviation && value(1) > 0.0 {
                let unit = unit(joint, "N s/m", "N m s/rad");
                format!(", damping {} {unit}", significant(value(1) / value(0).powi(2)))
            } else {
                String::new()
            };
            let unit = unit(joint, "N/m", "N m/rad");
            format!("{} bends: {}{spread} {unit}{damping}{at}", name(joint), significant(stiffness))
        }
        Effect::Play { joint } => {
            format!("{} has backlash of {} {}", name(joint), both(1e3, 2), unit(joint, "mm", "mrad"))
        }
    }
}

/// The option of the command line that adds the effects of a cause to the model. Empty without effects.
fn remedy(cause: &Cause, regressor: &dyn Regressor) -> String {
    let name = |joint: usize| regressor.coordinates().get(joint).map_or("", String::as_str);
    let mut words: Vec<String> = Vec::new();
    for size in &cause.effects {
        let (field, word) = match size.effect {
            Effect::Delay => ("delay", "auto".to_string()),
            Effect::Ripple { joint, periods } => ("ripple", format!("{}={periods}", name(joint))),
            Effect::Spring { joint } => ("spring", name(joint).to_string()),
            Effect::Eccentric { joint } => ("eccentric", name(joint).to_string()),
            Effect::Elastic { joint } => ("elastic", name(joint).to_string()),
            Effect::Play { joint } => ("backlash", name(joint).to_string()),
        };
        match words.first_mut() {
            Some(first) => first.push_str(&format!(",{word}")),
            None => words.push(format!("[{field}={word}")),
        }
    }
    if words.is_empty() { String::new() } else { words.concat() + "]" }
}

/// A sentence on the effect that the model lacks, with the option that adds it.
pub fn cause_sentence(cause: &Cause, regressor: &dyn Regressor) -> String {
    let sizes = cause.effects.iter().zip(&cause.frequency);
    let sizes: Vec<String> = sizes.map(|(size, hz)| size_words(size, regressor, *hz, false)).collect();
    format!(
        "{}: that explains {:.0} % of it; {} estimates it with the rest",
        sizes.join(", "),
        100.0 * cause.explained,
        remedy(cause, regressor)
    )
}

/// Sentences for the user if the model does not fit: the joints whose chi^2 per degree of freedom exceeds the noise, and the
/// cause.
pub(crate) fn misfit_remarks(misfit: &Misfit, cause: Option<&Cause>, regressor: &dyn Regressor) -> Vec<String> {
    let cause = cause.map(|cause| cause_sentence(cause, regressor));
    let beside = format!("where noise alone gives up to {NOISE_CHI_SQUARE}");
    if !misfit.is_lacking() {
        let said = |cause| format!("chi^2 per freedom is {:.1} {beside}; {cause}", misfit.total);
        return cause.map(said).into_iter().collect();
    }
    let named = |(name, x): (&String, &f64)| (*x > LACKING_MODEL_CHI_SQUARE).then(|| format!("{name} {x:.1}"));
    let joints: Vec<String> = regressor.coordinates().iter().zip(&misfit.joints).filter_map(named).collect();
    let lacks = format!(
        "the model lacks something that these experiments show: chi^2 per freedom is {:.1} {beside} ({}); sigma allows for it",
        misfit.total,
        joints.join(", ")
    );
    let unidentified = "the cause is not identified: late torques, ripple, springs, eccentric encoders, joints that bend and backlash each \
                  explain less than half of it";
    vec![lacks, cause.unwrap_or_else(|| unidentified.into())]
}
