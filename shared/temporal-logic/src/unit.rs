//! Units as products of metres and seconds.

use std::fmt;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    Powers {
        metre: i8,
        second: i8,
    },
    /// A plain number's: it fits every unit, as 1.5 does in `1.5 * speed_mps` and in `gap_m > 1.5`.
    Any,
    /// Several units side by side: margins count tolerances.
    Mixed,
}

impl Unit {
    /// Counts and flags.
    pub const ONE: Self = Self::Powers { metre: 0, second: 0 };
    pub const METRE: Self = Self::Powers { metre: 1, second: 0 };
    pub const SECOND: Self = Self::Powers { metre: 0, second: 1 };
    pub const METRE_PER_SECOND: Self = Self::Powers { metre: 1, second: -1 };
    pub const METRE_PER_SECOND_SQUARED: Self = Self::Powers { metre: 1, second: -2 };
    pub const METRE_PER_SECOND_CUBED: Self = Self::Powers { metre: 1, second: -3 };

    /// Difference that a driver does not notice, in this unit: 0.5 m, 0.5 m/s, 0.1 s, 0.2 m/s², 1 m/s³. Other units
    /// have 1. Margins of different units are compared in multiples of it. It is chosen: only the order of margins
    /// depends on it, and never their sign.
    pub fn tolerance(self) -> f64 {
        match self {
            Self::METRE | Self::METRE_PER_SECOND => 0.5,
            Self::SECOND => 0.1,
            Self::METRE_PER_SECOND_SQUARED => 0.2,
            _ => 1.0,
        }
    }

    pub(crate) fn times(self, other: Self) -> Self {
        match (self, other) {
            (Self::Powers { metre: a, second: b }, Self::Powers { metre: c, second: d }) => {
                Self::Powers { metre: a.saturating_add(c), second: b.saturating_add(d) }
            }
            _ => Self::Any,
        }
    }

    /// The common unit of two quantities that are added or compared, if there is one.
    pub(crate) fn with(self, other: Self) -> Option<Self> {
        match (self, other) {
            (Self::Any, unit) | (unit, Self::Any) => Some(unit),
            (a, b) => (a == b).then_some(a),
        }
    }
}

impl fmt::Display for Unit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self::Powers { metre, second } = *self else {
            return f.write_str(if *self == Self::Any { "a plain number" } else { "tolerances" });
        };
        let power = |n: u8| match n {
            1 => String::new(),
            2 => "²".to_owned(),
            3 => "³".to_owned(),
            n => format!("^{n}"),
        };
        match (metre, second) {
            (0, 0) => f.write_str("1"),
            (0, s) if s > 0 => write!(f, "s{}", power(s.unsigned_abs())),
            (0, s) => write!(f, "1/s{}", power(s.unsigned_abs())),
            (m, 0) if m > 0 => write!(f, "m{}", power(m.unsigned_abs())),
            (m, s) if m > 0 && s > 0 => {
                write!(f, "m{} s{}", power(m.unsigned_abs()), power(s.unsigned_abs()))
            }
            (m, s) if m > 0 => {
                write!(f, "m{}/s{}", power(m.unsigned_abs()), power(s.unsigned_abs()))
            }
            (m, s) => write!(f, "m^{m} s^{s}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_read_as_engineers_write_them() {
        let names = [
            (Unit::METRE_PER_SECOND_SQUARED, "m/s²"),
            (Unit::METRE, "m"),
            (Unit::SECOND, "s"),
            (Unit::ONE, "1"),
            (Unit::METRE_PER_SECOND.times(Unit::METRE_PER_SECOND), "m²/s²"),
        ];
        for (unit, name) in names {
            assert_eq!(unit.to_string(), name);
        }
    }

    #[test]
    fn a_speed_times_a_time_is_a_length() {
        assert_eq!(Unit::METRE_PER_SECOND.times(Unit::SECOND), Unit::METRE);
        assert_eq!(Unit::METRE.with(Unit::SECOND), None);
        assert_eq!(Unit::METRE.with(Unit::Any), Some(Unit::METRE));
    }
}
