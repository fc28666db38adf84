//! Physical quantities with a plausible range each.
//!
//! A scenario key has one of these types, so that a value outside its range is refused while the
//! document is read, where its position is still known. NaN and infinities are outside every range.

use serde::{Deserialize, Serialize};

/// A number outside the range of its quantity.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("{value} is out of range, expected {expected}")]
pub struct OutOfRange<T> {
    /// The number.
    pub value: T,
    /// The range in words.
    pub expected: &'static str,
}

/// Declares newtypes over `f64` that are always finite and inside their range.
macro_rules! quantity {
    ($($(#[$doc:meta])* $name:ident, $min:expr, $max:expr, $expected:literal;)+) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, PartialOrd, Serialize, Deserialize)]
        #[serde(try_from = "f64", into = "f64")]
        pub struct $name(f64);

        impl $name {
            /// Wraps a literal.
            ///
            /// # Panics
            /// When the value is outside the range of the type.
            #[must_use]
            pub const fn of(value: f64) -> Self {
                assert!(value >= $min, $expected);
                assert!(value <= $max, $expected);
                Self(value)
            }

            /// The number, in the unit that the key's name carries.
            #[must_use]
            pub const fn value(self) -> f64 {
                self.0
            }
        }

        impl TryFrom<f64> for $name {
            type Error = OutOfRange<f64>;

            fn try_from(value: f64) -> Result<Self, OutOfRange<f64>> {
                let is_inside = ($min..=$max).contains(&value);
                is_inside.then_some(Self(value)).ok_or(OutOfRange { value, expected: $expected })
            }
        }

        impl From<$name> for f64 {
            fn from(quantity: $name) -> f64 {
                quantity.0
            }
        }
    )+};
}

quantity! {
    /// A speed, m/s.
    Speed, 0.0, 100.0, "a speed from 0 to 100 m/s";
    /// A signed acceleration, m/s².
    Acceleration, -30.0, 30.0, "an acceleration from -30 to 30 m/s²";
    /// The magnitude of an acceleration, m/s², not zero.
    AccelerationMagnitude, 0.01, 30.0, "an acceleration from 0.01 to 30 m/s², without a sign";
    /// A rate of change of acceleration, m/s³, not zero.
    JerkMagnitude, 0.1, 1000.0, "a rate from 0.1 to 1000 m/s³, without a sign";
    /// A difference of two speeds, m/s.
    SpeedDifference, -200.0, 200.0, "a difference of speeds from -200 to 200 m/s";
    /// A distance along the road, m.
    Distance, 0.0, 1e6, "a distance from 0 to 1e6 m";
    /// A length of something that exists, m.
    Length, 0.1, 1000.0, "a length from 0.1 to 1000 m";
    /// A range that a sensor or radio reaches, m.
    Reach, 1.0, 1e5, "a range from 1 to 1e5 m";
    /// A lateral position, m, left positive.
    Lateral, -50.0, 50.0, "a lateral position from -50 to 50 m";
    /// A point in time or a waiting time, s.
    Time, 0.0, 86_400.0, "a time from 0 to 86400 s";
    /// A shift in time, s.
    TimeShift, -86_400.0, 86_400.0, "a time from -86400 to 86400 s";
    /// A time that passes, s.
    Duration, 1e-3, 86_400.0, "a duration from 0.001 to 86400 s";
    /// A time constant or a time headway, s.
    TimeConstant, 1e-3, 100.0, "a time constant from 0.001 to 100 s";
    /// A standard deviation, in the unit of the key.
    Sigma, 0.0, 100.0, "a standard deviation from 0 to 100";
    /// A multiple of a standard deviation.
    SigmaMultiple, 1.0, 100.0, "a multiple of sigma from 1 to 100";
    /// A probability.
    Probability, 0.0, 1.0, "a probability from 0 to 1";
    /// A share of a whole.
    Share, 0.0, 1.0, "a share from 0 to 1";
    /// An opening angle, degrees.
    Angle, 0.1, 360.0, "an angle from 0.1 to 360 degrees";
    /// A height above any level, m.
    Height, -500.0, 9000.0, "a height from -500 to 9000 m";
    /// A grade, percent, positive uphill.
    GradePercent, -20.0, 20.0, "a grade from -20 to 20 %";
    /// The magnitude of a grade, percent, not zero.
    GradeMagnitude, 0.01, 20.0, "a grade from 0.01 to 20 %, without a sign";
    /// The length of a road, km.
    RoadLength, 1.0, 500.0, "a length from 1 to 500 km";
    /// An error in the position of a map, m, positive when the map is too far ahead.
    MapShift, -1000.0, 1000.0, "a shift from -1000 to 1000 m";
    /// A latitude, degrees, north positive.
    Latitude, -89.0, 89.0, "a latitude from -89 to 89 degrees";
    /// A longitude, degrees, east positive.
    Longitude, -180.0, 180.0, "a longitude from -180 to 180 degrees";
    /// A heading, degrees clockwise from north.
    Heading, 0.0, 360.0, "a heading from 0 to 360 degrees";
    /// A torque at the crankshaft, N m.
    Torque, -5000.0, 5000.0, "a torque from -5000 to 5000 N m";
    /// A rate of change of torque, N m/s, not zero.
    TorqueRate, 10.0, 1e6, "a rate from 10 to 1e6 N m/s";
    /// A noise, percent.
    Percent, 0.0, 100.0, "a number from 0 to 100 %";
    /// A factor on a mass.
    MassFactor, 0.5, 2.0, "a factor from 0.5 to 2";
    /// A mass, kg.
    Mass, 100.0, 100_000.0, "a mass from 100 to 100000 kg";
    /// A power, kW.
    Power, 1.0, 10_000.0, "a power from 1 to 10000 kW";
    /// A deviation, in the unit of the figure that deviates.
    Shift, -1e4, 1e4, "a number from -10000 to 10000";
    /// A ratio of powers, dB.
    Decibels, -100.0, 100.0, "a level from -100 to 100 dB";
    /// A loss of power, dB.
    Loss, 0.0, 100.0, "a loss from 0 to 100 dB";
    /// A radar cross section, dB relative to 1 m².
    CrossSection, -40.0, 60.0, "a radar cross section from -40 to 60 dBsm";
    /// A mean number of events in a scan.
    MeanCount, 0.0, 2000.0, "a mean number from 0 to 2000";
    /// A number of objects on a kilometre.
    PerKilometre, 0.0, 2000.0, "a number from 0 to 2000 per km";
    /// A weight in a cost function.
    Weight, 0.0, 1e12, "a weight from 0 to 1e12";
    /// A weight in a cost function that must not vanish.
    PositiveWeight, 1e-9, 1e12, "a weight from 1e-9 to 1e12";
}

/// Declares newtypes over whole numbers inside a range.
macro_rules! whole {
    ($($(#[$doc:meta])* $name:ident, $repr:ty, $min:expr, $max:expr, $expected:literal;)+) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
        #[serde(try_from = "i64", into = "i64")]
        pub struct $name($repr);

        impl $name {
            /// Wraps a literal.
            ///
            /// # Panics
            /// When the value is outside the range of the type.
            #[must_use]
            pub const fn of(value: $repr) -> Self {
                assert!(value as i64 >= $min, $expected);
                assert!(value as i64 <= $max, $expected);
                Self(value)
            }

            /// The number, in the unit that the key's name carries.
            #[must_use]
            pub const fn value(self) -> $repr {
                self.0
            }
        }

        impl TryFrom<i64> for $name {
            type Error = OutOfRange<i64>;

            fn try_from(value: i64) -> Result<Self, OutOfRange<i64>> {
                let is_inside = ($min..=$max).contains(&value);
                let refused = OutOfRange { value, expected: $expected };
                is_inside.then_some(Self(value as $repr)).ok_or(refused)
            }
        }

        impl From<$name> for i64 {
            fn from(number: $name) -> i64 {
                number.0 as i64
            }
        }
    )+};
}

whole! {
    /// A period, ms.
    PeriodMs, u32, 1, 10_000, "a period from 1 to 10000, in whole milliseconds";
    /// A delay, ms.
    DelayMs, u32, 0, 10_000, "a delay from 0 to 10000, in whole milliseconds";
    /// A difference of two clocks, ms.
    OffsetMs, i32, -60_000, 60_000, "an offset from -60000 to 60000, in whole milliseconds";
    /// How much too fast a clock is, millionths.
    DriftPpm, i32, -1000, 1000, "a drift from -1000 to 1000 millionths";
    /// The id of a station that sends.
    StationId, u32, 1, 4_294_967_295, "a station id from 1 to 4294967295";
    /// A seed of the random numbers.
    Seed, u64, 0, i64::MAX, "a whole number from 0 to 9223372036854775807";
    /// How many, or how often.
    Count, u16, 1, 10_000, "a whole number from 1 to 10000";
    /// An amount of memory, MiB.
    Megabytes, u32, 1, 1_000_000, "a whole number of MiB from 1 to 1000000";
    /// A number of steps in a horizon.
    Steps, u16, 2, 1000, "a whole number from 2 to 1000";
    /// A real-time priority as SCHED_FIFO counts them.
    Priority, u8, 1, 99, "a priority from 1 (lowest) to 99";
    /// A CPU, by its id.
    Core, u16, 0, 1023, "the id of a CPU, from 0 to 1023";
    /// An intersection, by its id in the standards' 16 bits.
    IntersectionId, u16, 0, 65_535, "an intersection id from 0 to 65535";
    /// A signal group; the standards reserve 0 (not available) and 255 (permanently green).
    SignalGroupId, u8, 1, 254, "a signal group id from 1 to 254";
}

impl PeriodMs {
    /// The period in nanoseconds.
    #[must_use]
    pub const fn nanoseconds(self) -> u64 {
        self.0 as u64 * 1_000_000
    }
}

impl DelayMs {
    /// The delay in nanoseconds.
    #[must_use]
    pub const fn nanoseconds(self) -> u64 {
        self.0 as u64 * 1_000_000
    }
}

impl Time {
    /// The time in nanoseconds, rounded to the nearest.
    #[must_use]
    pub fn nanoseconds(self) -> u64 {
        seconds_to_nanoseconds(self.0)
    }
}

impl Duration {
    /// The duration in nanoseconds, rounded to the nearest.
    #[must_use]
    pub fn nanoseconds(self) -> u64 {
        seconds_to_nanoseconds(self.0)
    }
}

fn seconds_to_nanoseconds(seconds: f64) -> u64 {
    (seconds * 1e9).round() as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn not_a_number_and_infinities_are_outside_every_range() {
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert!(Speed::try_from(value).is_err());
            assert!(Acceleration::try_from(value).is_err());
            assert!(Weight::try_from(value).is_err());
        }
    }

    #[test]
    fn the_ends_of_a_range_belong_to_it() {
        assert_eq!(PeriodMs::try_from(1), Ok(PeriodMs::of(1)));
        assert_eq!(PeriodMs::try_from(10_000), Ok(PeriodMs::of(10_000)));
        assert!(PeriodMs::try_from(0).is_err());
        assert!(PeriodMs::try_from(10_001).is_err());
        assert_eq!(Probability::try_from(1.0), Ok(Probability::of(1.0)));
        assert!(Probability::try_from(1.0 + f64::EPSILON).is_err());
    }

    #[test]
    fn a_refusal_names_the_value_and_what_was_expected() {
        let refusal = Mass::try_from(0.0).expect_err("zero mass is not physical");
        assert_eq!(refusal.to_string(), "0 is out of range, expected a mass from 100 to 100000 kg");
    }

    #[test]
    fn seconds_become_nanoseconds_without_drift() {
        assert_eq!(Duration::of(0.1).nanoseconds(), 100_000_000);
        assert_eq!(Time::of(86_400.0).nanoseconds(), 86_400_000_000_000);
        assert_eq!(PeriodMs::of(10).nanoseconds(), 10_000_000);
    }
}
