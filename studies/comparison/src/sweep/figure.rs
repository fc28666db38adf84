//! The figures that a sweep follows, and what several seeds make of each.

use report::summary::Summary;

/// How a figure of several seeds becomes one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fold {
    /// The mean.
    Mean,
    /// The smallest: the worst of what must not be small.
    Least,
    /// The largest: the worst of what must not be large.
    Most,
}

/// A figure of a run.
pub struct Figure {
    /// Name in results.
    pub name: &'static str,
    /// Heading of its column, with the unit.
    pub heading: &'static str,
    /// Panel of the picture that it is drawn in, with the unit; a count has none.
    pub panel: &'static str,
    /// Name in the legend of its panel.
    pub label: &'static str,
    /// How seeds are folded.
    pub fold: Fold,
    /// Its value; none where it does not apply.
    pub of: fn(&Summary) -> Option<f64>,
}

/// Name of how often the emergency brake had to help.
pub const INTERVENTIONS: &str = "interventions";
const GAP_ERROR: &str = "gap error, m";
const TIME_GAP: &str = "time gap, s";
const JERK: &str = "jerk, m/s³";

/// All figures, in the order of the columns. None of them depends on the wall clock in lockstep.
pub const ALL: [Figure; 16] = [
    figure("rms_gap_error_m", "gap error rms, m", GAP_ERROR, "rms", Fold::Mean, |summary| {
        summary.control.figures.rms_gap_error_m
    }),
    figure("max_abs_gap_error_m", "largest, m", GAP_ERROR, "largest", Fold::Most, |summary| {
        summary.control.figures.max_abs_gap_error_m
    }),
    figure("rms_jerk_mps3", "jerk rms, m/s³", JERK, "rms", Fold::Mean, |summary| {
        summary.control.figures.rms_jerk_mps3
    }),
    figure("max_abs_jerk_mps3", "largest, m/s³", JERK, "largest", Fold::Most, |summary| {
        summary.control.figures.max_abs_jerk_mps3
    }),
    figure("min_gap_m", "min gap, m", "smallest gap, m", "smallest gap", Fold::Least, |summary| {
        summary.control.figures.min_gap_m
    }),
    figure(
        "min_ttc_s",
        "min TTC, s",
        "smallest time to collision, s",
        "smallest",
        Fold::Least,
        |s| s.control.figures.min_ttc_s,
    ),
    figure("min_time_gap_s", "min time gap, s", TIME_GAP, "shortest", Fold::Least, |summary| {
        summary.control.following.min_time_gap_s
    }),
    figure("median_time_gap_s", "median, s", TIME_GAP, "median", Fold::Mean, |summary| {
        summary.control.following.median_time_gap_s
    }),
    figure(
        "stop_line_crossing_s",
        "crossing, s",
        "stop line crossed, s",
        "crossed",
        Fold::Mean,
        |s| s.control.figures.stop_line_crossing_s,
    ),
    figure("fuel_l_per_100km", "L/100 km", "fuel, L/100 km", "fuel", Fold::Mean, |summary| {
        summary.control.figures.fuel_l_per_100km
    }),
    figure(
        "wheel_energy_kwh_per_100km",
        "kWh/100 km",
        "energy at the wheels, kWh/100 km",
        "energy",
        Fold::Mean,
        |s| s.control.figures.wheel_energy_kwh_per_100km,
    ),
    figure(
        INTERVENTIONS,
        "emergency brakings",
        "emergency brakings",
        "brakings",
        Fold::Most,
        |s| s.aebs.interventions.map(|times| times as f64),
    ),
    figure("stops", "stops", "stops", "stops", Fold::Mean, |summary| {
        summary.control.figures.stops.map(|stops| stops as f64)
    }),
    figure("data_age_p50_ms", "data age, ms", "median data age, ms", "median", Fold::Mean, |s| {
        s.timing.data_age_us.map(|age| age.p50 / 1e3)
    }),
    figure("deadline_misses", "missed", "deadlines missed", "missed", Fold::Mean, |summary| {
        summary.timing.deadline_misses.map(|misses| misses as f64)
    }),
    figure(
        "undelivered_commands",
        "undelivered",
        "commands not delivered",
        "commands",
        Fold::Mean,
        |s| s.timing.undelivered_commands.map(|commands| commands as f64),
    ),
];

const fn figure(
    name: &'static str,
    heading: &'static str,
    panel: &'static str,
    label: &'static str,
    fold: Fold,
    of: fn(&Summary) -> Option<f64>,
) -> Figure {
    Figure { name, heading, panel, label, fold, of }
}

/// The figures of one run or point, in the order of [`ALL`].
pub type Values = [Option<f64>; ALL.len()];

/// The figures of a run.
pub fn values(summary: &Summary) -> Values {
    std::array::from_fn(|index| (ALL[index].of)(summary))
}

impl Fold {
    /// The one figure that stands for those of several seeds; a seed in which it does not apply is
    /// left out.
    pub fn over(self, values: impl Iterator<Item = Option<f64>>) -> Option<f64> {
        let (mut count, mut folded) = (0_u32, None);
        for value in values.flatten() {
            count += 1;
            folded = Some(match (self, folded) {
                (_, None) => value,
                (Self::Mean, Some(sum)) => sum + value,
                (Self::Least, Some(least)) => value.min(least),
                (Self::Most, Some(most)) => value.max(most),
            });
        }
        if self == Self::Mean { folded.map(|sum: f64| sum / f64::from(count)) } else { folded }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seeds_are_folded_to_the_mean_or_the_worst() {
        let seeds = [Some(1.0), None, Some(4.0)];
        assert_eq!(Fold::Mean.over(seeds.into_iter()), Some(2.5));
        assert_eq!(Fold::Least.over(seeds.into_iter()), Some(1.0));
        assert_eq!(Fold::Most.over(seeds.into_iter()), Some(4.0));
        assert_eq!(Fold::Mean.over([None].into_iter()), None);
    }

    #[test]
    fn names_are_different() {
        for (index, figure) in ALL.iter().enumerate() {
            assert!(ALL[..index].iter().all(|other| other.name != figure.name));
        }
    }
}
