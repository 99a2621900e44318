//! Writes the requests as a JSON schema, for editors and for programs in other languages.
//!
//! A request is a struct with all options of a command; each field is one option.

use serde_json::{Map, Value, json};

use super::field::Field;
use super::range::Range;
use super::requests;
use super::spelling::{Audience, spelled};

/// A JSON schema of all requests under `$defs`. Each field is a property with type, default, range and text.
pub fn schema() -> Value {
    let of_request = |(name, fields): (String, Vec<Field>)| {
        let properties: Map<String, Value> = fields.iter().map(|f| (f.name.to_string(), property(f))).collect();
        (name, json!({"type": "object", "additionalProperties": false, "properties": properties}))
    };
    let requests: Map<String, Value> = requests().into_iter().map(of_request).collect();
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "The requests of rist",
        "$defs": requests,
    })
}

fn property(field: &Field) -> Value {
    let mut property = match &field.shape.json {
        Value::Object(of_type) => of_type.clone(),
        _ => Map::new(),
    };
    property.insert("description".into(), spelled(&field.doc, Audience::Json).into());
    if !field.default.is_null() {
        property.insert("default".into(), field.default.clone());
    }
    let limits: &[(&str, f64)] = match field.range {
        Range::Any | Range::NonZero => &[],
        Range::Between(from, to) => &[("minimum", from), ("maximum", to)],
        Range::From(from) => &[("minimum", from)],
        Range::Positive => &[("exclusiveMinimum", 0.0)],
        Range::Share => &[("exclusiveMinimum", 0.0), ("maximum", 1.0)],
    };
    property.extend(limits.iter().map(|(key, x)| (key.to_string(), json!(x))));
    Value::Object(property)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_field_is_there_with_its_type_default_and_range() {
        let schema = schema();
        for (name, fields) in requests() {
            let properties = schema["$defs"][&name]["properties"].as_object().unwrap();
            assert_eq!(properties.len(), fields.len(), "{name}");
            for field in fields {
                let property = &properties[field.name];
                let has_type = ["type", "anyOf", "enum"].iter().any(|key| property.get(key).is_some());
                assert!(has_type, "{name}.{}: {property}", field.name);
                assert!(property["description"].as_str().is_some_and(|text| text.len() > 8), "{name}.{}", field.name);
            }
        }
        let rate = &schema["$defs"]["excite"]["properties"]["rate"];
        assert_eq!(rate["type"], "number", "{rate}");
        let is_bounded = rate.get("minimum").or(rate.get("exclusiveMinimum")).is_some();
        assert!(rate["default"].is_number() && is_bounded, "{rate}");
        // The texts must spell a field as in JSON, not as a flag (`--limits`) or in brackets (`[limits]`).
        let text = schema.to_string();
        assert!(!text.contains("--") && !text.contains("[limits]"));
    }
}
