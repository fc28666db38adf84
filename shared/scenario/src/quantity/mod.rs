//! Physical quantities, each with its unit and its plausible range.
//!
//! A scenario key has one of these types. A value outside the range is refused while the document is read, because its
//! position is still known then. NaN and infinities are outside every range.
//!
//! ```
//! use scenario::quantity::Speed;
//!
//! assert_eq!(Speed::of(30.0).value(), 30.0);
//! let refused = Speed::try_from(-1.0).expect_err("below the range");
//! assert_eq!(refused.to_string(), "-1 is out of range, expected a speed from 0 to 100 m/s");
//! ```

mod range;

pub use range::{OutOfRange, Range};

use range::quantities;

quantities! {
    f64, "f64", false, ():
    Speed: f64, "a speed", 0.0, 100.0, "m/s";
    Acceleration: f64, "an acceleration", -30.0, 30.0, "m/s²";
    AccelerationMagnitude: f64, "an acceleration", 0.01, 30.0, "m/s²", ", without a sign";
    JerkMagnitude: f64, "a rate", 0.1, 1000.0, "m/s³", ", without a sign";
    SpeedDifference: f64, "a difference of speeds", -200.0, 200.0, "m/s";
    Distance: f64, "a distance", 0.0, 1e6, "m";
    Length: f64, "a length", 0.1, 1000.0, "m";
    /// A range that a sensor or radio reaches, m.
    Reach: f64, "a range", 1.0, 1e5, "m";
    /// A lateral position, m, left positive.
    Lateral: f64, "a lateral position", -50.0, 50.0, "m";
    Time: f64, "a time", 0.0, 86_400.0, "s";
    TimeShift: f64, "a time", -86_400.0, 86_400.0, "s";
    Duration: f64, "a duration", 1e-3, 86_400.0, "s";
    LoopMs: f64, "a time", 0.05, 60_000.0, "ms";
    LoadUs: f64, "a processor time", 0.0, 1e7, "µs";
    TimeConstant: f64, "a time constant", 1e-3, 100.0, "s";
    Sigma: f64, "a standard deviation", 0.0, 100.0, "";
    SigmaMultiple: f64, "a multiple of sigma", 1.0, 100.0, "";
    Probability: f64, "a probability", 0.0, 1.0, "";
    Share: f64, "a share", 0.0, 1.0, "";
    Angle: f64, "an angle", 0.1, 360.0, "degrees";
    Height: f64, "a height", -500.0, 9000.0, "m";
    /// A grade, percent, positive uphill.
    GradePercent: f64, "a grade", -20.0, 20.0, "%";
    GradeMagnitude: f64, "a grade", 0.01, 20.0, "%", ", without a sign";
    RoadLength: f64, "a length", 1.0, 500.0, "km";
    PieceLength: f64, "a length", 0.1, 1e6, "m";
    CurveRadius: f64, "a radius", 20.0, 1e10, "m";
    Coordinate: f64, "a coordinate", -1e6, 1e6, "m";
    /// A heading in the plane, degrees counter-clockwise from x.
    HeadingDeg: f64, "a heading", -360.0, 360.0, "degrees";
    Inertia: f64, "a moment of inertia", 10.0, 1e7, "kg m²";
    /// A compliance of tyres: slip angle by lateral acceleration, rad per m/s².
    SlipCompliance: f64, "a slip angle by acceleration", 1e-4, 0.1, "rad per m/s²";
    /// A gradient of understeer, rad per m/s²; negative: oversteer.
    Understeer: f64, "a gradient", -0.002, 0.05, "rad per m/s²";
    AngularFrequency: f64, "a frequency", 0.01, 20.0, "rad/s";
    Damping: f64, "a damping", 0.1, 5.0, "";
    InnerShare: f64, "a share", 0.1, 0.9, "";
    /// An error in the position of a map, m, positive when the map is too far ahead.
    MapShift: f64, "a shift", -1000.0, 1000.0, "m";
    Latitude: f64, "a latitude", -89.0, 89.0, "degrees";
    Longitude: f64, "a longitude", -180.0, 180.0, "degrees";
    /// A heading, degrees clockwise from north.
    Heading: f64, "a heading", 0.0, 360.0, "degrees";
    /// A torque at the crankshaft, N m.
    Torque: f64, "a torque", -5000.0, 5000.0, "N m";
    TorqueRate: f64, "a rate", 10.0, 1e6, "N m/s";
    Percent: f64, "a number", 0.0, 100.0, "%";
    MassFactor: f64, "a factor", 0.5, 2.0, "";
    Mass: f64, "a mass", 100.0, 100_000.0, "kg";
    Power: f64, "a power", 1.0, 10_000.0, "kW";
    /// A deviation, in the unit of the figure that deviates.
    Shift: f64, "a number", -1e4, 1e4, "";
    Decibels: f64, "a level", -100.0, 100.0, "dB";
    Loss: f64, "a loss", 0.0, 100.0, "dB";
    CrossSection: f64, "a radar cross section", -40.0, 60.0, "dBsm";
    MeanCount: f64, "a mean number", 0.0, 2000.0, "";
    PerKilometre: f64, "a number", 0.0, 2000.0, "per km";
    Weight: f64, "a weight", 0.0, 1e12, "";
    PositiveWeight: f64, "a weight", 1e-9, 1e12, "";
}

quantities! {
    i64, "i64", true, (Eq, Ord):
    PeriodMs: u32, "a period", 1, 10_000, "ms", ", a whole number";
    DelayMs: u32, "a delay", 0, 10_000, "ms", ", a whole number";
    OffsetMs: i32, "an offset", -60_000, 60_000, "ms", ", a whole number";
    /// The rate by which a clock is too fast, millionths.
    DriftPpm: i32, "a drift", -1000, 1000, "millionths", ", a whole number";
    StationId: u32, "a station id", 1, 4_294_967_295, "";
    LaneCount: u8, "a number of lanes", 0, 20, "";
    /// The id of a lane in OpenDRIVE: positive on the left of the reference line, negative on the right.
    LaneId: i32, "a lane id", -1000, 1000, "";
    Seed: u64, "a whole number", 0, i64::MAX, "";
    Count: u16, "a whole number", 1, 10_000, "";
    Megabytes: u32, "a size", 1, 1_000_000, "MiB", ", a whole number";
    MessageBytes: u32, "a size", 1, 16_777_216, "bytes", ", a whole number";
    Steps: u16, "a whole number", 2, 1000, "";
    /// A real-time priority as SCHED_FIFO counts them.
    Priority: u8, "a priority", 1, 99, "", " (highest)";
    Core: u16, "a CPU id", 0, 1023, "";
    IntersectionId: u16, "an intersection id", 0, 65_535, "";
    /// A signal group; the standards reserve 0 (not available) and 255 (permanently green).
    SignalGroupId: u8, "a signal group id", 1, 254, "";
}

macro_rules! nanoseconds {
    ($($name:ident: |$value:ident| $nanoseconds:expr;)+) => {$(
        impl $name {
            /// The time in nanoseconds, rounded to the nearest.
            #[inline]
            pub const fn nanoseconds(self) -> u64 {
                let $value = self.0;
                $nanoseconds
            }
        }
    )+};
}

nanoseconds! {
    PeriodMs: |ms| ms as u64 * 1_000_000;
    DelayMs: |ms| ms as u64 * 1_000_000;
    LoopMs: |ms| (ms * 1e6).round() as u64;
    LoadUs: |us| (us * 1e3).round() as u64;
    Time: |s| (s * 1e9).round() as u64;
    Duration: |s| (s * 1e9).round() as u64;
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
        let refusal = PeriodMs::try_from(0).expect_err("a loop takes time");
        assert_eq!(refusal.range.to_string(), "a period from 1 to 10000 ms, a whole number");
        assert_eq!(Weight::RANGE.to_string(), "a weight from 0 to 1e12");
        assert_eq!(PositiveWeight::RANGE.to_string(), "a weight from 1e-9 to 1e12");
        assert_eq!(TimeConstant::RANGE.to_string(), "a time constant from 0.001 to 100 s");
    }

    #[test]
    fn seconds_become_nanoseconds_without_drift() {
        assert_eq!(Duration::of(0.1).nanoseconds(), 100_000_000);
        assert_eq!(Time::of(86_400.0).nanoseconds(), 86_400_000_000_000);
        assert_eq!(PeriodMs::of(10).nanoseconds(), 10_000_000);
    }
}
