//! Values that are drawn: one of a list of words, tables or ranges, or a number in a range.
//!
//! `[0.0, 0.0, [0.0, 0.5]]` is 0 in two runs of three, and in the third a number up to 0.5.

use rand_pcg::Pcg64;
use supervise::UsageError;
use toml::Value;

/// Checks that a value, or each value of a table, can be drawn from.
pub fn check(key: &str, value: &Value) -> Result<(), UsageError> {
    match value {
        Value::Table(table) => table.iter().try_for_each(|(key, value)| check(key, value)),
        Value::Array(values) if is_choice(values) => {
            let mut parts = values.iter().filter(|value| value.is_table() || value.is_array());
            parts.try_for_each(|part| check(key, part))
        }
        Value::Array(values) if range(values).is_none() => {
            let place = format_args!("{key} = {value}");
            let expected =
                "two numbers, the smaller first, or a list of words, of tables or with ranges";
            Err(UsageError::at(place, "it cannot be drawn from", expected))
        }
        _ => Ok(()),
    }
}

/// True for a list of which one element is drawn.
fn is_choice(values: &[Value]) -> bool {
    let all = |is: fn(&Value) -> bool| !values.is_empty() && values.iter().all(is);
    all(Value::is_str) || all(Value::is_table) || values.iter().any(Value::is_array)
}

/// The ends of a range: two numbers, in order.
fn range(values: &[Value]) -> Option<(f64, f64)> {
    let number = |value: &Value| value.as_float().or(value.as_integer().map(|i| i as f64));
    let [from, to] = values else { return None };
    let (from, to) = (number(from)?, number(to)?);
    (from < to && (to - from).is_finite()).then_some((from, to))
}

/// A fixed value, one of a list, or a number in a range. The number is whole if both ends are, else it has three
/// decimals. In a table each value is drawn.
pub fn drawn(value: &Value, random: &mut Pcg64) -> Value {
    if let Value::Table(table) = value {
        let each = table.iter().map(|(key, value)| (key.clone(), drawn(value, random)));
        return Value::Table(each.collect());
    }
    let Value::Array(values) = value else { return value.clone() };
    let uniform = random::uniform(random);
    match range(values) {
        Some((from, to)) if values.iter().all(Value::is_integer) => {
            Value::Integer((from + uniform * (to - from + 1.0)).floor() as i64)
        }
        Some((from, to)) => Value::Float(((from + uniform * (to - from)) * 1e3).round() / 1e3),
        None => drawn(&values[(uniform * values.len() as f64) as usize], random),
    }
}
