//! The columns of a record by what they hold, with their units: `t=stamp, v=speed:km/h`.

use crate::{Problem, accepted};
use bags::Motion;

/// Units of a quantity with their factor to SI. The first is the unit of a name without unit.
type Units = &'static [(&'static str, f64)];

const TIME: Units = &[("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9), ("min", 60.0)];
const SPEED: Units = &[
    ("m/s", 1.0),
    ("km/h", 1.0 / 3.6),
    ("mph", 0.447_04),
    ("kn", 1852.0 / 3600.0),
    ("ft/s", 0.304_8),
    ("cm/s", 0.01),
];
const LENGTH: Units = &[("m", 1.0), ("km", 1e3), ("cm", 0.01), ("ft", 0.304_8), ("mi", 1609.344)];
// Degrees are what receivers write.
const ANGLE: Units = &[("deg", std::f64::consts::PI / 180.0), ("rad", 1.0)];

const LETTERS: [(&str, Units); 7] = [
    ("t", TIME),
    ("v", SPEED),
    ("s", LENGTH),
    ("x", LENGTH),
    ("y", LENGTH),
    ("lat", ANGLE),
    ("lon", ANGLE),
];

/// A column and the factor that makes SI of its numbers.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Column {
    pub(super) name: String,
    pub(super) factor: f64,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) struct Columns {
    /// Time; absent only for a bag, whose messages have one.
    pub(super) time: Option<Column>,
    pub(super) motion: Motion,
    pub(super) of_motion: Vec<Column>,
}

/// The right form, for errors.
const EXPECTED: &str = "t=NAME with one of v=NAME, s=NAME, x=NAME and y=NAME, lat=NAME and lon=NAME; \
    a unit behind a colon, as in v=speed:km/h";

impl Columns {
    /// Parses the key. Only a bag's time has a default.
    pub(super) fn parse(text: &str, is_bag: bool) -> Result<Self, Problem> {
        let mut found: [Option<Column>; LETTERS.len()] = Default::default();
        for part in text.split(',').map(str::trim) {
            let (letter, rest) = part.split_once('=').ok_or_else(|| {
                Problem::new("columns", format!("`{part}` names no column"), EXPECTED)
            })?;
            let letter = letter.trim();
            let letters = LETTERS.iter().map(|(letter, _)| *letter);
            let index = letters.clone().position(|known| known == letter).ok_or_else(|| {
                let message = format!("`{letter}` is not a quantity of a motion");
                Problem::new("columns", message, accepted(letter, letters))
            })?;
            if found[index].is_some() {
                let message = format!("`{letter}` stands here twice");
                return Err(Problem::new("columns", message, "it once"));
            }
            found[index] = Some(column(rest.trim(), LETTERS[index].1)?);
        }
        let [time, speed, distance, x, y, latitude, longitude] = found;
        let (motion, of_motion) = match (speed, distance, (x, y), (latitude, longitude)) {
            (Some(v), None, (None, None), (None, None)) => (Motion::Speed, vec![v]),
            (None, Some(s), (None, None), (None, None)) => (Motion::Distance, vec![s]),
            (None, None, (Some(x), Some(y)), (None, None)) => (Motion::Plane, vec![x, y]),
            (None, None, (None, None), (Some(lat), Some(lon))) => {
                (Motion::Geodetic, vec![lat, lon])
            }
            _ => {
                let message = format!("`{text}` does not give one motion");
                return Err(Problem::new("columns", message, EXPECTED));
            }
        };
        if time.is_none() && !is_bag {
            return Err(Problem::new("columns", "no column of times", EXPECTED));
        }
        Ok(Self { time, motion, of_motion })
    }
}

fn column(text: &str, units: Units) -> Result<Column, Problem> {
    let (name, unit) = text.rsplit_once(':').unwrap_or((text, units[0].0));
    let (name, unit) = (name.trim(), unit.trim());
    let known = units.iter().find(|(known, _)| *known == unit);
    let (_, factor) = *known.ok_or_else(|| {
        let message = format!("unknown unit `{unit}` of `{name}`");
        Problem::new("columns", message, accepted(unit, units.iter().map(|(unit, _)| *unit)))
    })?;
    if name.is_empty() {
        return Err(Problem::new("columns", "a column without a name", EXPECTED));
    }
    Ok(Column { name: name.to_owned(), factor })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_stand_behind_the_last_colon() {
        let columns = Columns::parse("t=stamp:ms, v = can:speed:km/h", false).expect("right");
        assert_eq!(columns.time, Some(Column { name: "stamp".into(), factor: 1e-3 }));
        assert_eq!(columns.of_motion, [Column { name: "can:speed".into(), factor: 1.0 / 3.6 }]);
        let columns = Columns::parse("lat=a,lon=b", true).expect("a bag has times");
        assert_eq!((columns.motion, columns.time), (Motion::Geodetic, None));
        assert!((columns.of_motion[0].factor - 0.017_453_292_519_943_295).abs() < 1e-18);
    }

    #[test]
    fn refusals_name_what_is_known() {
        for (text, message, expected) in [
            ("t=a, v=b:kmh", "unknown unit `kmh` of `b`", "did you mean `km/h`?"),
            ("t=a, w=b", "`w` is not a quantity of a motion", "`lat`"),
            ("v=b", "no column of times", "t=NAME"),
            ("t=a, x=b", "does not give one motion", "x=NAME and y=NAME"),
            ("t=a, v=b, s=c", "does not give one motion", "one of"),
            ("t=a, t=b", "`t` stands here twice", "it once"),
            ("t=a, v", "`v` names no column", "v=speed:km/h"),
            ("t=:ms, v=b", "a column without a name", "t=NAME"),
        ] {
            let error = Columns::parse(text, false).expect_err(text).to_string();
            assert!(error.contains(message) && error.contains(expected), "{text}: {error}");
        }
    }
}
