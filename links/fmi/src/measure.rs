//! Units of measure: what a number of a unit is in SI.

use openscenario::xml::Element;

/// Exponents of metre, second and kilogram.
pub type Dimension = [i8; 3];

/// Dimensions of the quantities that timegap exchanges.
pub const NUMBER: Dimension = [0, 0, 0];
pub const LENGTH: Dimension = [1, 0, 0];
pub const TIME: Dimension = [0, 1, 0];
pub const SPEED: Dimension = [1, -1, 0];
pub const ACCELERATION: Dimension = [1, -2, 0];
pub const TORQUE: Dimension = [2, -2, 1];
pub const FORCE: Dimension = [1, -2, 1];

/// A unit of measure: the SI value is `factor` times the number, plus `offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measure {
    pub dimension: Dimension,
    pub factor: f64,
    pub offset: f64,
}

/// Names that units use without a definition, or as the end of a variable's name.
const KNOWN: [(&[&str], Dimension, f64); 16] = [
    (&["m/s", "m.s-1", "m s-1", "m*s^-1", "meter/second", "mps"], SPEED, 1.0),
    (&["km/h", "kph", "kmh", "kmph"], SPEED, 1.0 / 3.6),
    (&["mph", "mi/h", "mile/h"], SPEED, 0.447_04),
    (&["m/s2", "m/s^2", "m/s²", "m.s-2", "mps2", "ms2", "m/s/s"], ACCELERATION, 1.0),
    (&["m/(s2)", "m/(s^2)"], ACCELERATION, 1.0),
    // Standard gravity; `g` alone may be a gram.
    (&["g0", "gn", "g_n"], ACCELERATION, 9.806_65),
    (&["m", "meter", "metre"], LENGTH, 1.0),
    (&["km"], LENGTH, 1000.0),
    (&["cm"], LENGTH, 0.01),
    (&["ft"], LENGTH, 0.304_8),
    (&["s", "sec", "second"], TIME, 1.0),
    (&["ms", "msec"], TIME, 0.001),
    (&["1", "-", ""], NUMBER, 1.0),
    (&["%", "percent", "pct"], NUMBER, 0.01),
    (&["N.m", "N m", "Nm", "N*m", "nm"], TORQUE, 1.0),
    (&["N", "n"], FORCE, 1.0),
];

impl Measure {
    pub const fn si(dimension: Dimension) -> Self {
        Self { dimension, factor: 1.0, offset: 0.0 }
    }

    pub fn named(name: &str) -> Option<Self> {
        let (_, dimension, factor) = KNOWN.iter().find(|(names, ..)| names.contains(&name))?;
        Some(Self { factor: *factor, ..Self::si(*dimension) })
    }

    /// The measure that a unit defines (`Unit` of `UnitDefinitions`).
    pub fn defined(unit: &Element) -> Option<Self> {
        let base = unit.child("BaseUnit")?;
        let number = |name: &str, or: f64| {
            base.attribute(name).map_or(Some(or), |text| text.trim().parse::<f64>().ok())
        };
        let exponent = |name: &str| number(name, 0.0).map(|exponent| exponent as i8);
        Some(Self {
            dimension: [exponent("m")?, exponent("s")?, exponent("kg")?],
            factor: number("factor", 1.0)?,
            offset: number("offset", 0.0)?,
        })
    }

    pub fn to_si(self, number: f64) -> f64 {
        self.factor * number + self.offset
    }

    pub fn of_si(self, value: f64) -> f64 {
        (value - self.offset) / self.factor
    }
}

pub fn dimension_name(dimension: Dimension) -> &'static str {
    let mut si = KNOWN.iter().filter(|(_, known, factor)| *known == dimension && *factor == 1.0);
    let name = si.next().filter(|_| dimension != NUMBER);
    name.map_or("a number without unit", |(names, ..)| names[0])
}
