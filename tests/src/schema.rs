//! A result against its JSON Schema.

use serde_json::Value;

/// Deviations of `value` from the schema, each with its place. They are values of another type, missing keys, and
/// undeclared keys. It knows the part of JSON Schema that
/// `report::results::Schema` writes.
#[must_use]
pub fn check(schema: &Value, value: &Value) -> Vec<String> {
    let mut wrong = Vec::new();
    walk(schema, value, "", &mut wrong);
    wrong
}

fn walk(schema: &Value, value: &Value, place: &str, wrong: &mut Vec<String>) {
    let below =
        |part: &str| if place.is_empty() { part.to_owned() } else { format!("{place}.{part}") };
    if let Some(expected) = schema.get("const")
        && expected != value
    {
        wrong.push(format!("{place}: {value} is not {expected}"));
    }
    let types: Vec<&str> = match schema.get("type") {
        Some(Value::Array(types)) => types.iter().filter_map(Value::as_str).collect(),
        Some(Value::String(one)) => vec![one],
        _ => Vec::new(),
    };
    if !types.is_empty() && !types.iter().any(|kind| is_of(kind, value)) {
        wrong.push(format!("{place}: {value} is not of type {}", types[0]));
        return;
    }
    if let Value::Object(object) = value {
        let names = schema["required"].as_array().into_iter().flatten().filter_map(Value::as_str);
        for name in names.filter(|name| !object.contains_key(*name)) {
            wrong.push(format!("{}: missing", below(name)));
        }
        for (name, value) in object {
            match (schema["properties"].get(name), schema.get("additionalProperties")) {
                (Some(schema), _) => walk(schema, value, &below(name), wrong),
                (None, Some(schema)) => walk(schema, value, &below(name), wrong),
                // An object that may be null, or that has no declared keys, may have others.
                (None, None)
                    if schema.get("properties").is_some() && schema["type"] == "object" =>
                {
                    wrong.push(format!("{}: not declared", below(name)));
                }
                (None, None) => {}
            }
        }
    }
    if let (Value::Array(list), Some(items)) = (value, schema.get("items")) {
        for (index, value) in list.iter().enumerate() {
            walk(items, value, &below(&index.to_string()), wrong);
        }
    }
}

fn is_of(kind: &str, value: &Value) -> bool {
    match kind {
        "object" => value.is_object(),
        "array" => value.is_array(),
        "string" => value.is_string(),
        "boolean" => value.is_boolean(),
        "number" => value.is_number(),
        "integer" => value.as_f64().is_some_and(|number| number.fract() == 0.0),
        "null" => value.is_null(),
        _ => false,
    }
}
