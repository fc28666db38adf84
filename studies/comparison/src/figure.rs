//! The figures of a drive that are followed over keys and compared between laws, and how several seeds become one.

use report::results::{Column, Good, count, number};
use report::summary::{Control, Summary, Timing};
use serde_json::Value;
use statistics::Spread;

/// Way from a figure of several seeds to one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fold {
    /// The mean, with its spread.
    Mean,
    /// The smallest: the worst of what must not be small.
    Least,
    /// The largest: the worst of what must not be large.
    Most,
}

/// A figure of a run.
pub struct Figure {
    /// Its column.
    pub column: Column<Value>,
    /// Panel of the picture that shows it.
    pub panel: &'static str,
    /// Name in the legend of its panel.
    pub label: &'static str,
    /// Fold of the seeds.
    pub fold: Fold,
    /// Its value; none where it does not apply.
    pub of: Of,
}

type Of = fn(Measured<'_>) -> Option<f64>;

/// The parts of a run's summary that have figures.
#[derive(Clone, Copy)]
pub struct Measured<'a> {
    /// Figures of the drive.
    pub control: &'a Control,
    /// Latencies and deadlines.
    pub timing: &'a Timing,
    /// Interventions of the emergency brake; none without it.
    pub interventions: Option<u64>,
}

impl<'a> From<&'a Summary> for Measured<'a> {
    fn from(summary: &'a Summary) -> Self {
        let Summary { control, timing, aebs, .. } = summary;
        Self { control, timing, interventions: aebs.interventions }
    }
}

/// A figure whose seeds become their mean; `(panel, label)` are its names in the picture.
const fn mean(
    column: Column<Value>,
    (panel, label): (&'static str, &'static str),
    of: Of,
) -> Figure {
    Figure { column, panel, label, fold: Fold::Mean, of }
}

/// A figure whose seeds become the smallest one.
const fn least(
    column: Column<Value>,
    (panel, label): (&'static str, &'static str),
    of: Of,
) -> Figure {
    Figure { column, panel, label, fold: Fold::Least, of }
}

/// A figure whose seeds become the largest one.
const fn most(
    column: Column<Value>,
    (panel, label): (&'static str, &'static str),
    of: Of,
) -> Figure {
    Figure { column, panel, label, fold: Fold::Most, of }
}

impl Figure {
    /// Name in results.
    pub fn name(&self) -> &str {
        &self.column.head.name
    }

    /// Less or more of it is better, so that laws can be compared by it.
    pub fn has_direction(&self) -> bool {
        self.column.head.good != Good::Neither
    }
}

/// Name of the number of interventions of the emergency brake.
pub const INTERVENTIONS: &str = "interventions";
/// Number of figures.
pub const COUNT: usize = 19;
const KWH: &str = "kWh/100 km";

/// All figures, in the order of the columns. None of them depends on the wall clock in lockstep.
pub static ALL: [Figure; COUNT] = [
    mean(
        number("rms_gap_error_m", "gap error rms", "m", 2, "Root mean square of the gap error")
            .less(),
        ("gap error", "rms"),
        |s| s.control.figures.rms_gap_error_m,
    ),
    most(
        number("max_abs_gap_error_m", "max gap error", "m", 2, "Largest gap error")
            .less()
            .weight(3),
        ("gap error", "largest"),
        |s| s.control.figures.max_abs_gap_error_m,
    ),
    mean(
        number("rms_jerk_mps3", "jerk rms", "m/s³", 2, "Root mean square of the jerk")
            .less()
            .weight(1),
        ("jerk", "rms"),
        |s| s.control.figures.rms_jerk_mps3,
    ),
    most(
        number("max_abs_jerk_mps3", "max jerk", "m/s³", 2, "Largest magnitude of the jerk")
            .less()
            .weight(3),
        ("jerk", "largest"),
        |s| s.control.figures.max_abs_jerk_mps3,
    ),
    least(
        number("min_gap_m", "min gap", "m", 2, "Smallest gap to the vehicle ahead").more(),
        ("smallest gap", "smallest gap"),
        |s| s.control.figures.min_gap_m,
    ),
    least(
        number("min_ttc_s", "min TTC", "s", 2, "Smallest time to collision").more().weight(1),
        ("smallest time to collision", "smallest"),
        |s| s.control.figures.min_ttc_s,
    ),
    mean(
        number("impact_speed_mps", "impact", "m/s", 2, "Speed difference at the contact")
            .less()
            .weight(2),
        ("impact speed", "impact"),
        |s| s.control.figures.impact_speed_mps,
    ),
    least(
        number("min_time_gap_s", "min time gap", "s", 2, "Smallest time gap").more().weight(1),
        ("time gap", "shortest"),
        |s| s.control.following.min_time_gap_s,
    ),
    least(
        number("min_accel_mps2", "hardest braking", "m/s²", 2, "Smallest acceleration")
            .more()
            .weight(2),
        ("hardest braking", "hardest"),
        |s| s.control.figures.min_accel_mps2,
    ),
    mean(
        number(
            "trip_over_fastest_s",
            "trip over the fastest",
            "s",
            2,
            "Trip time beyond the fastest legal trip",
        )
        .less()
        .weight(2),
        ("trip over the fastest", "time"),
        |s| s.control.trip.over_fastest_s(),
    ),
    mean(
        number("median_time_gap_s", "median time gap", "s", 2, "Median time gap").weight(3),
        ("time gap", "median"),
        |s| s.control.following.median_time_gap_s,
    ),
    mean(
        number("stop_line_crossing_s", "crossing", "s", 2, "Time at which a stop line was crossed")
            .weight(1),
        ("stop line crossed", "crossed"),
        |s| s.control.figures.stop_line_crossing_s,
    ),
    mean(
        number("fuel_l_per_100km", "fuel", "L/100 km", 2, "Fuel").less().weight(2),
        ("fuel", "fuel"),
        |s| s.control.figures.fuel_l_per_100km,
    ),
    mean(
        number("wheel_energy_kwh_per_100km", "wheels", KWH, 2, "Energy at the wheels")
            .less()
            .weight(2),
        ("energy at the wheels", "energy"),
        |s| s.control.figures.wheel_energy_kwh_per_100km,
    ),
    most(
        count(INTERVENTIONS, "emergency brakings", "Interventions of the emergency brake")
            .less()
            .weight(1),
        ("emergency brakings", "brakings"),
        |s| s.interventions.map(|times| times as f64),
    ),
    mean(
        number("stops", "stops", "", 2, "Times that the vehicle came to a stand").less().weight(3),
        ("stops", "stops"),
        |s| s.control.figures.stops.map(|stops| stops as f64),
    ),
    mean(
        number(
            "data_age_p50_ms",
            "data age",
            "ms",
            2,
            "Median age of the radar data behind an actuation",
        )
        .weight(2),
        ("median data age", "median"),
        |s| s.timing.data_age_us.map(|age| age.p50 / 1e3),
    ),
    mean(
        number("deadline_misses", "deadlines missed", "", 2, "Control cycles that ended late")
            .less()
            .weight(1),
        ("deadlines missed", "missed"),
        |s| s.timing.deadline_misses.map(|misses| misses as f64),
    ),
    mean(
        number(
            "undelivered_commands",
            "undelivered",
            "",
            2,
            "Commands that did not reach the plant",
        )
        .less()
        .weight(2),
        ("commands not delivered", "commands"),
        |s| s.timing.undelivered_commands.map(|commands| commands as f64),
    ),
];

/// The figures of one run or point, in the order of [`ALL`].
pub type Values = [Option<f64>; COUNT];

/// The figures of a run.
pub fn values<'a>(measured: impl Into<Measured<'a>>) -> Values {
    let measured = measured.into();
    std::array::from_fn(|index| (ALL[index].of)(measured))
}

/// Several seeds as one figure.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Folded {
    /// The mean, or the worst.
    pub value: Option<f64>,
    /// Spread over the seeds in which the figure applies.
    pub spread: Spread,
}

impl Fold {
    /// The figure that stands for those of several seeds. A seed in which it does not apply is left out.
    pub fn over(self, values: impl Iterator<Item = Option<f64>>) -> Folded {
        let values: Vec<f64> = values.flatten().collect();
        let spread = Spread::of(&values);
        let value = match self {
            Self::Mean => spread.mean,
            Self::Least => values.into_iter().reduce(f64::min),
            Self::Most => values.into_iter().reduce(f64::max),
        };
        Folded { value, spread }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seeds_are_folded_to_the_mean_with_its_spread_or_to_the_worst() {
        let seeds = [Some(1.0), None, Some(4.0)];
        let mean = Fold::Mean.over(seeds.into_iter());
        assert_eq!((mean.value, mean.spread.n), (Some(2.5), 2));
        assert_eq!(Fold::Least.over(seeds.into_iter()).value, Some(1.0));
        assert_eq!(Fold::Most.over(seeds.into_iter()).value, Some(4.0));
        assert_eq!(Fold::Mean.over([None].into_iter()), Folded::default());
    }

    #[test]
    fn names_are_different() {
        for (index, figure) in ALL.iter().enumerate() {
            assert!(ALL[..index].iter().all(|other| other.name() != figure.name()));
        }
    }
}
