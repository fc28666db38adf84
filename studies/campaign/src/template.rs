//! The faults of a run, drawn from the tables of the campaign's file.
//!
//! A value is one of a list of words, tables or ranges, or a number in a range. `[0.0, 0.0, [0.0, 0.5]]` is 0 in two runs
//! of three, and in the third a number up to 0.5.

use rand_core::Rng;
use rand_pcg::Pcg64;
use scenario::Problem;
use scenario::faults::{self, Fault};
use supervise::UsageError;
use toml::{Table, Value};

/// Draw of a run's faults.
#[derive(Debug)]
pub enum Drawing {
    /// The run has no faults.
    None,
    /// One template, as often as it states.
    One(Template),
    /// A number of faults, each from any of the templates.
    Mixed {
        templates: Vec<Template>,
        /// Least number of draws.
        least: u32,
        /// Largest number of draws.
        most: u32,
    },
}

impl Drawing {
    /// The ways in which the runs of a campaign draw their faults. With `per_run`, all tables but those `alone` are mixed.
    pub fn all(tables: &[Table], per_run: Option<[u32; 2]>) -> Result<Vec<Self>, UsageError> {
        let templates = tables.iter().map(Template::of).collect::<Result<Vec<_>, _>>()?;
        if templates.is_empty() {
            return Ok(vec![Self::None]);
        }
        let Some([least, most]) = per_run else {
            return Ok(templates.into_iter().map(Self::One).collect());
        };
        let (alone, templates): (Vec<_>, Vec<_>) =
            templates.into_iter().partition(|template| template.is_alone);
        let mixed = (!templates.is_empty()).then_some(Self::Mixed { templates, least, most });
        Ok(mixed.into_iter().chain(alone.into_iter().map(Self::One)).collect())
    }

    /// Words on the faults, for results.
    pub fn label(&self) -> &str {
        match self {
            Self::None => "none",
            Self::One(template) => &template.label,
            Self::Mixed { .. } => "mixed",
        }
    }

    /// The faults of a run, by its seed and the random stream of its scenario and drawing.
    pub fn draw(&self, seed: u32, stream: u128) -> Result<Vec<Fault>, UsageError> {
        let mut random = Pcg64::new(seed.into(), stream);
        // The first number of a stream is almost the same for all small seeds.
        random.next_u64();
        match self {
            Self::None => Ok(Vec::new()),
            Self::One(template) => template.draw(&mut random),
            Self::Mixed { templates, least, most } => {
                let span = f64::from(most - least + 1);
                let count = least + (random::uniform(&mut random) * span) as u32;
                let mut all = Vec::new();
                for _ in 0..count {
                    let which = random::uniform(&mut random) * templates.len() as f64;
                    all.extend(templates[which as usize].draw(&mut random)?);
                }
                Ok(all)
            }
        }
    }
}

/// A fault with values that are drawn for each run.
#[derive(Debug)]
pub struct Template {
    label: String,
    /// It has runs of its own, also in a campaign that mixes its faults.
    is_alone: bool,
    count: usize,
    /// All of them begin at the same instant, and no two act on the same service.
    is_together: bool,
    keys: Table,
}

impl Template {
    fn of(table: &Table) -> Result<Self, UsageError> {
        let mut keys = table.clone();
        let mut whole = |key: &str| match keys.remove(key) {
            None => Ok(None),
            Some(Value::Integer(count @ 1..=64)) => Ok(Some(count as usize)),
            Some(value) => {
                let why = format_args!("{key} = {value}");
                Err(UsageError::at("faults", why, "a whole number from 1 to 64"))
            }
        };
        let (count, together) = (whole("count")?, whole("together")?);
        let is_alone = match keys.remove("alone") {
            None => false,
            Some(Value::Boolean(alone)) => alone,
            Some(other) => {
                let why = format_args!("alone = {other}");
                return Err(UsageError::at("faults", why, "true or false"));
            }
        };
        let services = keys.get("service").and_then(Value::as_array).map_or(0, Vec::len);
        if together.is_some_and(|together| together > services || count.is_some()) {
            let why = "together strikes more services than are listed, or stands beside count";
            let expected = "`service` as a list of as many or more, and no `count`";
            return Err(UsageError::at("faults", why, expected));
        }
        for (key, value) in &keys {
            check(key, value)?;
        }
        let word = |key: &str| match keys.get(key) {
            Some(Value::String(word)) => Some(word.clone()),
            _ => None,
        };
        let parts = ["kind", "service", "topic", "field"].into_iter().filter_map(word);
        Ok(Self {
            label: parts.collect::<Vec<_>>().join(" "),
            is_alone,
            count: count.or(together).unwrap_or(1),
            is_together: together.is_some(),
            keys,
        })
    }

    /// As many faults as the template says.
    fn draw(&self, random: &mut Pcg64) -> Result<Vec<Fault>, UsageError> {
        let shared = |key: &str| self.is_together && matches!(key, "at_s" | "when");
        let mut keys = self.keys.clone();
        for (_, value) in keys.iter_mut().filter(|(key, _)| shared(key)) {
            *value = drawn(value, random);
        }
        let mut draw = |_| {
            let mut fault = Table::new();
            for (key, value) in &mut keys {
                let one = if shared(key) { value.clone() } else { drawn(value, random) };
                if self.is_together
                    && key == "service"
                    && let Value::Array(left) = value
                {
                    left.retain(|other| *other != one);
                }
                fault.insert(key.clone(), one);
            }
            faults::read(fault).map_err(|problem| self.refuse(&problem))
        };
        (0..self.count).map(&mut draw).collect()
    }

    fn refuse(&self, Problem { path, message, expected, .. }: &Problem) -> UsageError {
        let key = path.strip_prefix("fault.").map(|key| format!(", {key}")).unwrap_or_default();
        UsageError::at(format_args!("faults, {}{key}", self.label), message, expected)
    }
}

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
