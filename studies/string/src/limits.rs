//! The value of a key at which a law stops to be string stable.

use schemars::JsonSchema;
use serde::{Serialize, Serializer};

use super::STABLE_GAIN;
use super::wave::{Response, peak};

/// A law over the values of a key.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Limits {
    /// Name of the law.
    pub controller: String,
    /// The key.
    pub key: String,
    /// The stable value of the first two neighbours that differ in stability.
    #[schemars(with = "serde_json::Value")]
    pub stable: Option<Value>,
    /// The unstable value of these two.
    #[schemars(with = "serde_json::Value")]
    pub unstable: Option<Value>,
    /// Value between the two at which the peak of the gain passes the limit, if they are numbers.
    pub ceases_at: Option<f64>,
    /// Every value: numbers in their order, others as they were given.
    pub points: Vec<Point>,
}

/// A law at one value of the key.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Point {
    /// The value.
    #[schemars(with = "serde_json::Value")]
    pub value: Value,
    /// The largest gain at any frequency; none if a run did not reach its end.
    pub peak_gain: Option<f64>,
    /// The frequency of that gain, Hz.
    pub peak_hz: Option<f64>,
    /// No frequency is amplified.
    pub string_stable: bool,
    /// The gain curve.
    pub frequencies: Vec<Response>,
}

/// A value as it was given: a number where it is one.
#[derive(Clone, Debug, PartialEq)]
pub struct Value(pub String);

impl Value {
    pub fn number(&self) -> Option<f64> {
        self.0.parse().ok().filter(|number: &f64| number.is_finite())
    }
}

impl Serialize for Value {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.number() {
            Some(number) => serializer.serialize_f64(number),
            None => serializer.serialize_str(&self.0),
        }
    }
}

impl Point {
    /// A value with its gain curve.
    pub fn new(value: &str, frequencies: Vec<Response>) -> Self {
        let peak = peak(&frequencies);
        Self {
            value: Value(value.to_owned()),
            peak_gain: peak.map(|peak| peak.1),
            peak_hz: peak.map(|peak| peak.0),
            string_stable: peak.is_some_and(|peak| peak.1 <= STABLE_GAIN),
            frequencies,
        }
    }
}

impl Limits {
    /// The points of one law. Numbers are put in their order: the limit is between two neighbours.
    pub fn new(controller: &str, key: &str, mut points: Vec<Point>) -> Self {
        if points.iter().all(|point| point.value.number().is_some()) {
            let number = |point: &Point| point.value.number().unwrap_or(f64::NAN);
            points.sort_by(|a, b| number(a).total_cmp(&number(b)));
        }
        let change = points.windows(2).find(|pair| pair[0].string_stable != pair[1].string_stable);
        let sides = change.map(|pair| match pair[0].string_stable {
            true => (&pair[0], &pair[1]),
            false => (&pair[1], &pair[0]),
        });
        let ceases_at = sides.and_then(|(stable, unstable)| {
            let (from, to) = (stable.value.number()?, unstable.value.number()?);
            let (low, high) = (stable.peak_gain?, unstable.peak_gain?);
            Some(from + (to - from) * (STABLE_GAIN - low) / (high - low))
        });
        Self {
            controller: controller.to_owned(),
            key: key.to_owned(),
            stable: sides.map(|sides| sides.0.value.clone()),
            unstable: sides.map(|sides| sides.1.value.clone()),
            ceases_at,
            points,
        }
    }

    pub fn sentence(&self) -> String {
        let Self { controller, key, stable, unstable, ceases_at, points } = self;
        match (stable, unstable) {
            (Some(stable), Some(unstable)) => {
                let between = ceases_at.map_or_else(String::new, |at| {
                    format!("; the peak of its gain passes {STABLE_GAIN} at {at:.4}")
                });
                format!(
                    "{controller} is string stable at {key} = {}, and no longer at {}{between}",
                    stable.0, unstable.0
                )
            }
            _ if points.iter().all(|point| point.string_stable) => {
                format!("{controller} is string stable at every value of {key}")
            }
            _ => format!("{controller} is string stable at no value of {key}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(value: &str, gain: Option<f64>) -> Point {
        let response = Response { hz: 0.1, gain, head_to_tail_gain: gain, gains: vec![gain] };
        Point::new(value, vec![response])
    }

    #[test]
    fn the_limit_lies_between_the_last_stable_value_and_the_first_other() {
        let points = vec![
            point("0", Some(0.9)),
            point("100", Some(0.995)),
            point("200", Some(1.015)),
            point("300", None),
        ];
        let limits = Limits::new("acc-mpc", "runtime.extra_delay_ms", points);
        assert_eq!((limits.stable.clone(), limits.unstable.clone()), {
            (Some(Value("100".into())), Some(Value("200".into())))
        });
        assert!((limits.ceases_at.expect("two numbers") - 150.0).abs() < 1e-6);
        assert!(limits.sentence().contains("100, and no longer at 200"), "{}", limits.sentence());
        let json = serde_json::to_value(&limits).expect("plain data");
        assert_eq!(json["unstable"], 200.0);
        assert_eq!(json["points"][3]["string_stable"], false);
    }

    #[test]
    fn the_order_in_which_numbers_are_given_moves_no_limit() {
        let of = |values: [(&str, f64); 3]| {
            let points = values.map(|(value, gain)| point(value, Some(gain)));
            Limits::new("acc-mpc", "runtime.extra_delay_ms", points.into()).ceases_at
        };
        let (low, middle, high) = (("0", 0.965), ("200", 1.015), ("1e3", 1.5));
        assert_eq!(of([high, low, middle]), of([low, middle, high]));
    }

    #[test]
    fn a_law_that_gets_stable_with_the_key_has_its_limit_too() {
        let points = vec![point("0.5", Some(1.2)), point("1.0", Some(0.9))];
        let limits = Limits::new("acc-mpc", "controller.time_headway_s", points);
        assert_eq!(limits.stable, Some(Value("1.0".into())));
        assert!(limits.ceases_at.is_some_and(|at| (0.5..1.0).contains(&at)));
    }

    #[test]
    fn a_law_that_is_always_or_never_stable_is_said_to_be() {
        let always = Limits::new("a", "k", vec![point("1", Some(0.9)), point("2", Some(0.9))]);
        assert!(always.sentence().contains("at every value"));
        let never = Limits::new("a", "k", vec![point("x", Some(1.9)), point("y", None)]);
        assert!(never.sentence().contains("at no value"));
    }
}
