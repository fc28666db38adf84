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

pub(super) const NAMES: [&str; 11] = [
    "no-collision",
    "no-avoidable-collision",
    "no-red-light",
    "min-gap",
    "ttc",
    "time-gap",
    "jerk",
    "braking",
    "lateral",
    "comfort",
    "string-stable",
];

/// Time gap above which a vehicle ahead is not followed, s.
const FOLLOWED_S: f64 = 6.0;

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

/// A name with wrong values: the form that it needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct WrongForm(pub(super) &'static str);

/// The name that `text` seems to mean, if it is not a known one. A word without operators and signals is not a formula.
pub(super) fn unknown(text: &str) -> Option<&str> {
    let name = text.split(':').next().unwrap_or_default().trim();
    let is_word = !name.is_empty() && name.bytes().all(|b| b.is_ascii_lowercase() || b == b'-');
    (is_word && !NAMES.contains(&name)).then_some(name)
}

/// The meaning of a named requirement; `None` if `text` is not one.
pub(super) fn named(text: &str) -> Option<Result<Named, WrongForm>> {
    let (name, value) = match text.split_once(':') {
        Some((name, value)) => (name.trim(), Some(value.trim())),
        None => (text.trim(), None),
    };
    let number = || value.and_then(positive);
    let rule = |rule| match value {
        None => Ok(Named::Rule(rule)),
        Some(_) => Err(WrongForm("the name without a value")),
    };
    let formula = match name {
        "no-collision" => return Some(rule(Rule::Collision)),
        "no-avoidable-collision" => return Some(rule(Rule::AvoidableCollision)),
        "no-red-light" => return Some(rule(Rule::RedLight)),
        "lateral" => {
            let limit = number().map(|a| Named::Rule(Rule::Lateral(a)));
            return Some(limit.ok_or(WrongForm("lateral:LIMIT in m/s²")));
        }
        "string-stable" => Err("it in `timegap string`, which drives strings of cars"),
        "min-gap" => number().map(|m| format!("always gap_m >= {m}")).ok_or("min-gap:METRES"),
        "ttc" => number().map(|s| format!("always ttc_s >= {s}")).ok_or("ttc:SECONDS"),
        "jerk" => number().map(|j| format!("always abs(jerk_mps3) <= {j}")).ok_or("jerk:LIMIT in m/s³"),
        "braking" => {
            number().map(|a| format!("always acceleration_mps2 >= -{a}")).ok_or("braking:LIMIT in m/s²")
        }
        "time-gap" => band(value).map(time_gap).ok_or("time-gap:LEAST..MOST in s"),
        "comfort" => match value {
            None => Ok("always (acceleration_mps2 >= -3.5 and acceleration_mps2 <= 2 and abs(jerk_mps3) <= 5)".to_owned()),
            Some(_) => Err("comfort, without a value"),
        },
        _ => return None,
    };
    Some(formula.map(Named::Formula).map_err(WrongForm))
}

fn time_gap((least_s, most_s): (f64, f64)) -> String {
    format!(
        "always (time_gap_s >= {least_s} and (time_gap_s <= {most_s} or time_gap_s > {FOLLOWED_S}))"
    )
}

fn band(value: Option<&str>) -> Option<(f64, f64)> {
    let (least, most) = value?.split_once("..")?;
    let (least, most) = (positive(least)?, positive(most)?);
    (least <= most && most < FOLLOWED_S).then_some((least, most))
}

fn positive(text: &str) -> Option<f64> {
    text.trim().parse().ok().filter(|number: &f64| number.is_finite() && *number >= 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_is_known_and_no_formula_is_a_name() {
        for name in NAMES {
            assert!(named(name).is_some() && unknown(name).is_none(), "{name}");
        }
        assert_eq!(unknown("min-gop:2"), Some("min-gop"));
        assert_eq!(unknown("confort"), Some("confort"));
        for formula in ["always gap_m > 2", "is_red", "gap_m>2", "(is_red)", "not is_red", ""] {
            assert_eq!(unknown(formula), None, "{formula}");
        }
    }
}
