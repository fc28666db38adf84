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

/// Declares [`ALL`]. A row has the fold of the seeds, panel and label in the picture, the column, and a run's value.
macro_rules! figures {
    ($($fold:ident $panel:literal / $label:literal: $column:expr, $of:expr;)+) => {
        /// All figures, in the order of the columns. They do not depend on the wall clock in lockstep.
        pub static ALL: [Figure; COUNT] = [$(
            Figure { column: $column, panel: $panel, label: $label, fold: Fold::$fold, of: $of },
        )+];
    };
}

figures! {
    Mean "gap error" / "rms": number("rms_gap_error_m", "gap error rms", "m", 2, "Root mean square of the gap error").less(),
        |s| s.control.figures.rms_gap_error_m;
    Most "gap error" / "largest": number("max_abs_gap_error_m", "max gap error", "m", 2, "Largest gap error").less().weight(3),
        |s| s.control.figures.max_abs_gap_error_m;
    Mean "jerk" / "rms": number("rms_jerk_mps3", "jerk rms", "m/s³", 2, "Root mean square of the jerk").less().weight(1),
        |s| s.control.figures.rms_jerk_mps3;
    Most "jerk" / "largest": number("max_abs_jerk_mps3", "max jerk", "m/s³", 2, "Largest magnitude of the jerk").less().weight(3),
        |s| s.control.figures.max_abs_jerk_mps3;
    Least "smallest gap" / "smallest gap": number("min_gap_m", "min gap", "m", 2, "Smallest gap to the vehicle ahead").more(),
        |s| s.control.figures.min_gap_m;
    Least "smallest time to collision" / "smallest": number("min_ttc_s", "min TTC", "s", 2, "Smallest time to collision").more().weight(1),
        |s| s.control.figures.min_ttc_s;
    Mean "impact speed" / "impact": number("impact_speed_mps", "impact", "m/s", 2, "Speed difference at the contact").less().weight(2),
        |s| s.control.figures.impact_speed_mps;
    Least "time gap" / "shortest": number("min_time_gap_s", "min time gap", "s", 2, "Smallest time gap").more().weight(1),
        |s| s.control.following.min_time_gap_s;
    Least "hardest braking" / "hardest": number("min_accel_mps2", "hardest braking", "m/s²", 2, "Smallest acceleration").more().weight(2),
        |s| s.control.figures.min_accel_mps2;
    Mean "trip over the fastest" / "time": number("trip_over_fastest_s", "trip over the fastest", "s", 2, "Trip time beyond the fastest legal trip").less().weight(2),
        |s| s.control.trip.over_fastest_s();
    Mean "time gap" / "median": number("median_time_gap_s", "median time gap", "s", 2, "Median time gap").weight(3),
        |s| s.control.following.median_time_gap_s;
    Mean "stop line crossed" / "crossed": number("stop_line_crossing_s", "crossing", "s", 2, "Time at which a stop line was crossed").weight(1),
        |s| s.control.figures.stop_line_crossing_s;
    Mean "fuel" / "fuel": number("fuel_l_per_100km", "fuel", "L/100 km", 2, "Fuel").less().weight(2),
        |s| s.control.figures.fuel_l_per_100km;
    Mean "energy at the wheels" / "energy": number("wheel_energy_kwh_per_100km", "wheels", KWH, 2, "Energy at the wheels").less().weight(2),
        |s| s.control.figures.wheel_energy_kwh_per_100km;
    Most "emergency brakings" / "brakings": count(INTERVENTIONS, "emergency brakings", "Interventions of the emergency brake").less().weight(1),
        |s| s.interventions.map(|times| times as f64);
    Mean "stops" / "stops": number("stops", "stops", "", 2, "Times that the vehicle came to a stand").less().weight(3),
        |s| s.control.figures.stops.map(|stops| stops as f64);
    Mean "median data age" / "median": number("data_age_p50_ms", "data age", "ms", 2, "Median age of the radar data behind an actuation").weight(2),
        |s| s.timing.data_age_us.map(|age| age.p50 / 1e3);
    Mean "deadlines missed" / "missed": number("deadline_misses", "deadlines missed", "", 2, "Control cycles that ended late").less().weight(1),
        |s| s.timing.deadline_misses.map(|misses| misses as f64);
    Mean "commands not delivered" / "commands": number("undelivered_commands", "undelivered", "", 2, "Commands that did not reach the plant").less().weight(2),
        |s| s.timing.undelivered_commands.map(|commands| commands as f64);
}

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
