//! Reads `<default>` classes, which supply the attributes that an element does not have itself.
//!
//! A class inherits the attributes of the class around it and replaces some of them. The class of an element is its `class`,
//! otherwise the nearest `childclass` above it, otherwise `main`.

use std::collections::BTreeMap;

use super::element::MjcfElement;
use crate::error::Error;
use crate::format::shown::shown;
use gate::suggestion::did_you_mean;

/// The attributes that can give an orientation. If an element has one of them, the orientations of its class do not count.
pub(super) const ORIENTATIONS: [&str; 5] = ["quat", "axisangle", "euler", "xyaxes", "zaxis"];

type Attributes = BTreeMap<String, String>;

/// The classes of a model: for each name, the attributes of each kind of element.
pub(super) struct Defaults {
    classes: BTreeMap<String, BTreeMap<&'static str, Attributes>>,
}

/// Name of the class for elements without a class.
const MAIN: &str = "main";

/// The kind of an element. Elements of the same kind share their defaults. `None` for an element without defaults.
fn kind(tag: &str) -> Option<&'static str> {
    const ACTUATORS: &str = "general motor position velocity intvelocity pid damper cylinder muscle adhesion dcmotor";
    match tag {
        "joint" => Some("joint"),
        "geom" => Some("geom"),
        "mesh" => Some("mesh"),
        "site" => Some("site"),
        "equality" | "connect" | "weld" => Some("equality"),
        _ => ACTUATORS.split_whitespace().any(|known| known == tag).then_some("actuator"),
    }
}

impl Defaults {
    pub(super) fn new(root: &MjcfElement) -> Result<Defaults, Error> {
        let mut defaults = Defaults { classes: BTreeMap::from([(MAIN.to_string(), BTreeMap::new())]) };
        for element in root.children("default") {
            // The outermost class is `main`. It may have a second name, which elements can also use.
            let name = element.attribute("class").unwrap_or(MAIN).to_string();
            defaults.class(element, MAIN)?;
            let main = defaults.classes.get(MAIN).cloned().unwrap_or_default();
            defaults.classes.insert(name, main);
        }
        Ok(defaults)
    }

    /// Adds the attributes of a `<default>` element to a class, then reads the classes inside the element.
    fn class(&mut self, element: &MjcfElement, name: &str) -> Result<(), Error> {
        let mut attributes = self.classes.get(name).cloned().unwrap_or_default();
        for child in element.children.iter().filter(|child| child.tag != "default") {
            let Some(kind) = kind(&child.tag) else { continue };
            let known: &mut Attributes = attributes.entry(kind).or_default();
            if child.attributes.iter().any(|a| ORIENTATIONS.contains(&a.0.as_str())) {
                known.retain(|key, _| !ORIENTATIONS.contains(&key.as_str()));
            }
            known.extend(child.attributes.iter().cloned());
        }
        self.classes.insert(name.to_string(), attributes.clone());
        for child in element.children("default") {
            let own = child.attribute("class").ok_or_else(|| child.error("a <default> in another has no `class`"))?;
            self.classes.insert(own.to_string(), attributes.clone());
            self.class(child, own)?;
        }
        Ok(())
    }

    /// The element with the defaults of its class. `inherited`: the nearest `childclass` above it. Fails if the class
    /// does not exist.
    pub(super) fn view<'a>(&'a self, element: &'a MjcfElement, inherited: Option<&'a str>) -> Result<View<'a>, Error> {
        let class = element.attribute("class").or(inherited).unwrap_or(MAIN);
        let Some(kinds) = self.classes.get(class) else {
            let meant = did_you_mean(class, self.classes.keys().map(String::as_str));
            return Err(element.error(format!("no <default> has the class `{}`{meant}", shown(class))));
        };
        Ok(View { element, default: kind(&element.tag).and_then(|kind| kinds.get(kind)) })
    }
}

/// An element of the model together with the defaults of its class.
#[derive(Clone, Copy)]
pub(super) struct View<'a> {
    pub element: &'a MjcfElement,
    default: Option<&'a Attributes>,
}

impl<'a> View<'a> {
    /// A view of an element that ignores the defaults of its class.
    pub(super) fn bare(element: &'a MjcfElement) -> View<'a> {
        View { element, default: None }
    }

    pub(super) fn get(&self, name: &str) -> Option<&'a str> {
        let own = self.element.attribute(name);
        // If the element itself has an orientation, all orientations of its class are ignored.
        let has_own = || self.element.attributes.iter().any(|a| ORIENTATIONS.contains(&a.0.as_str()));
        if own.is_none() && ORIENTATIONS.contains(&name) && has_own() {
            return None;
        }
        own.or_else(|| self.default?.get(name).map(String::as_str))
    }
}
