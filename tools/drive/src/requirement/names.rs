//! Named requirements.
//!
//! | name | formula |
//! | --- | --- |
//! | `no-collision` | the least gap in m; after a contact minus the impact speed in m/s |
//! | `no-avoidable-collision` | the same, unless a [reference driver](super::reference) has a contact too |
//! | `no-red-light` | way past a stop line, or before it, when its signal turned red, in m |
//! | `min-gap:M` | `always gap_m >= M` |
//! | `ttc:S` | `always ttc_s >= S` |
//! | `time-gap:A..B` | `always (time_gap_s >= A and (time_gap_s <= B or time_gap_s > 6))` |
//! | `jerk:J` | `always abs(jerk_mps3) <= J` |
//! | `braking:A` | `always acceleration_mps2 >= -A` |
//! | `lateral:A` | the lateral acceleration on a road with a plan stays within A m/s² |
//! | `comfort` | `always (acceleration_mps2 >= -3.5 and acceleration_mps2 <= 2 and abs(jerk_mps3) <= 5)` |
//!
//! A vehicle whose time gap is above 6 s is not followed. Comfort's accelerations are ISO 15622's limits above 20 m/s,
//! and its jerk is the limit below 5 m/s. All come from secondary sources.

/// Time gap above which a vehicle ahead is not followed, s.
const FOLLOWED_S: f64 = 6.0;

/// The form of a rule that takes no value.
const ALONE: &str = "the name without a value";

/// Makes the requirement of a name from the number behind it.
type Make = fn(Option<&str>) -> Option<Named>;

/// Every name, the form that it needs, and its meaning with what stands behind the colon.
const KNOWN: [(&str, &str, Make); 11] = [
    ("no-collision", ALONE, |value| alone(value, Named::Rule(Rule::Collision))),
    ("no-avoidable-collision", ALONE, |value| alone(value, Named::Rule(Rule::AvoidableCollision))),
    ("no-red-light", ALONE, |value| alone(value, Named::Rule(Rule::RedLight))),
    ("min-gap", "min-gap:METRES", |value| limited(value, |m| format!("always gap_m >= {m}"))),
    ("ttc", "ttc:SECONDS", |value| limited(value, |s| format!("always ttc_s >= {s}"))),
    ("time-gap", "time-gap:LEAST..MOST in s", time_gap),
    ("jerk", "jerk:LIMIT in m/s³", |value| {
        limited(value, |j| format!("always abs(jerk_mps3) <= {j}"))
    }),
    ("braking", "braking:LIMIT in m/s²", |value| {
        limited(value, |a| format!("always acceleration_mps2 >= -{a}"))
    }),
    ("lateral", "lateral:LIMIT in m/s²", |value| {
        Some(Named::Rule(Rule::Lateral(positive(value?)?)))
    }),
    ("comfort", "comfort, without a value", |value| {
        alone(value, Named::Formula(COMFORT.to_owned()))
    }),
    ("string-stable", "it in `timegap string`, which drives strings of cars", |_| None),
];

const COMFORT: &str =
    "always (acceleration_mps2 >= -3.5 and acceleration_mps2 <= 2 and abs(jerk_mps3) <= 5)";

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Named {
    /// A formula over the signals.
    Formula(String),
    /// A rule on the ground truth.
    Rule(Rule),
}

/// A rule that a formula over the signals cannot express: the event that must not happen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Rule {
    Collision,
    AvoidableCollision,
    RedLight,
    /// A lateral acceleration beyond this one, m/s².
    Lateral(f64),
}

impl Rule {
    pub(super) const fn words(self) -> &'static str {
        match self {
            Self::Collision => "least gap, or minus the impact speed",
            Self::AvoidableCollision => {
                "least gap, or minus the impact speed, where the reference avoids"
            }
            Self::RedLight => "way to a stop line when its signal turned red",
            Self::Lateral(_) => "largest lateral acceleration",
        }
    }
}

/// The name that `text` seems to mean, if it is not a known one. A word without operators and signals is not a formula.
pub(super) fn unknown(text: &str) -> Option<&str> {
    let name = text.split(':').next().unwrap_or_default().trim();
    let is_word = !name.is_empty() && name.bytes().all(|b| b.is_ascii_lowercase() || b == b'-');
    (is_word && !names().contains(&name)).then_some(name)
}

pub(super) fn names() -> [&'static str; 11] {
    KNOWN.map(|(name, ..)| name)
}

/// The meaning of a named requirement, or the form that its value needs; `None` if `text` is not one.
pub(super) fn named(text: &str) -> Option<Result<Named, &'static str>> {
    let (name, value) = match text.split_once(':') {
        Some((name, value)) => (name.trim(), Some(value.trim())),
        None => (text.trim(), None),
    };
    let (_, form, meaning) = KNOWN.iter().find(|(known, ..)| *known == name)?;
    Some(meaning(value).ok_or(*form))
}

fn alone(value: Option<&str>, meaning: Named) -> Option<Named> {
    value.is_none().then_some(meaning)
}

fn limited(value: Option<&str>, formula: fn(f64) -> String) -> Option<Named> {
    Some(Named::Formula(formula(positive(value?)?)))
}

fn time_gap(value: Option<&str>) -> Option<Named> {
    let (least, most) = value?.split_once("..")?;
    let (least_s, most_s) = (positive(least)?, positive(most)?);
    let formula = format!(
        "always (time_gap_s >= {least_s} and (time_gap_s <= {most_s} or time_gap_s > {FOLLOWED_S}))"
    );
    (least_s <= most_s && most_s < FOLLOWED_S).then_some(Named::Formula(formula))
}

fn positive(text: &str) -> Option<f64> {
    text.trim().parse().ok().filter(|number: &f64| number.is_finite() && *number >= 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_is_known_and_no_formula_is_a_name() {
        for name in names() {
            assert!(named(name).is_some() && unknown(name).is_none(), "{name}");
        }
        assert_eq!(unknown("min-gop:2"), Some("min-gop"));
        assert_eq!(unknown("confort"), Some("confort"));
        for formula in ["always gap_m > 2", "is_red", "gap_m>2", "(is_red)", "not is_red", ""] {
            assert_eq!(unknown(formula), None, "{formula}");
        }
    }
}
