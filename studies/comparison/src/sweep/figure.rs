//! The figures that a sweep follows, and how several seeds become one.

use report::results::{Column, count, number};
use report::summary::Summary;
use serde_json::Value;

/// How a figure of several seeds becomes one.
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
    /// How seeds are folded.
    pub fold: Fold,
    /// Its value; none where it does not apply.
    pub of: fn(&Summary) -> Option<f64>,
}

impl Figure {
    /// Name in results.
    pub fn name(&self) -> &str {
        &self.column.head.name
    }
}

/// Name of the number of interventions of the emergency brake.
pub const INTERVENTIONS: &str = "interventions";
/// Number of figures.
pub const COUNT: usize = 16;
const KWH: &str = "kWh/100 km";

/// All figures, in the order of the columns. None of them depends on the wall clock in lockstep.
pub static ALL: [Figure; COUNT] = [
    Figure {
        column: number(
            "rms_gap_error_m",
            "gap error rms",
            "m",
            2,
            "Root mean square of the gap error",
        )
        .less(),
        panel: "gap error",
        label: "rms",
        fold: Fold::Mean,
        of: |s| s.control.figures.rms_gap_error_m,
    },
    Figure {
        column: number("max_abs_gap_error_m", "max gap error", "m", 2, "Largest gap error")
            .less()
            .weight(3),
        panel: "gap error",
        label: "largest",
        fold: Fold::Most,
        of: |s| s.control.figures.max_abs_gap_error_m,
    },
    Figure {
        column: number("rms_jerk_mps3", "jerk rms", "m/s³", 2, "Root mean square of the jerk")
            .less()
            .weight(1),
        panel: "jerk",
        label: "rms",
        fold: Fold::Mean,
        of: |s| s.control.figures.rms_jerk_mps3,
    },
    Figure {
        column: number("max_abs_jerk_mps3", "max jerk", "m/s³", 2, "Largest magnitude of the jerk")
            .less()
            .weight(3),
        panel: "jerk",
        label: "largest",
        fold: Fold::Most,
        of: |s| s.control.figures.max_abs_jerk_mps3,
    },
    Figure {
        column: number("min_gap_m", "min gap", "m", 2, "Smallest gap to the vehicle ahead").more(),
        panel: "smallest gap",
        label: "smallest gap",
        fold: Fold::Least,
        of: |s| s.control.figures.min_gap_m,
    },
    Figure {
        column: number("min_ttc_s", "min TTC", "s", 2, "Smallest time to collision")
            .more()
            .weight(1),
        panel: "smallest time to collision",
        label: "smallest",
        fold: Fold::Least,
        of: |s| s.control.figures.min_ttc_s,
    },
    Figure {
        column: number("min_time_gap_s", "min time gap", "s", 2, "Smallest time gap")
            .more()
            .weight(1),
        panel: "time gap",
        label: "shortest",
        fold: Fold::Least,
        of: |s| s.control.following.min_time_gap_s,
    },
    Figure {
        column: number("median_time_gap_s", "median time gap", "s", 2, "Median time gap").weight(3),
        panel: "time gap",
        label: "median",
        fold: Fold::Mean,
        of: |s| s.control.following.median_time_gap_s,
    },
    Figure {
        column: number(
            "stop_line_crossing_s",
            "crossing",
            "s",
            2,
            "Time at which a stop line was crossed",
        )
        .weight(1),
        panel: "stop line crossed",
        label: "crossed",
        fold: Fold::Mean,
        of: |s| s.control.figures.stop_line_crossing_s,
    },
    Figure {
        column: number("fuel_l_per_100km", "fuel", "L/100 km", 2, "Fuel").less().weight(2),
        panel: "fuel",
        label: "fuel",
        fold: Fold::Mean,
        of: |s| s.control.figures.fuel_l_per_100km,
    },
    Figure {
        column: number("wheel_energy_kwh_per_100km", "wheels", KWH, 2, "Energy at the wheels")
            .less()
            .weight(2),
        panel: "energy at the wheels",
        label: "energy",
        fold: Fold::Mean,
        of: |s| s.control.figures.wheel_energy_kwh_per_100km,
    },
    Figure {
        column: count(INTERVENTIONS, "emergency brakings", "Interventions of the emergency brake")
            .less()
            .weight(1),
        panel: "emergency brakings",
        label: "brakings",
        fold: Fold::Most,
        of: |s| s.aebs.interventions.map(|times| times as f64),
    },
    Figure {
        column: number("stops", "stops", "", 2, "Times that the vehicle came to a stand")
            .less()
            .weight(3),
        panel: "stops",
        label: "stops",
        fold: Fold::Mean,
        of: |s| s.control.figures.stops.map(|stops| stops as f64),
    },
    Figure {
        column: number(
            "data_age_p50_ms",
            "data age",
            "ms",
            2,
            "Median age of the radar data behind an actuation",
        )
        .weight(2),
        panel: "median data age",
        label: "median",
        fold: Fold::Mean,
        of: |s| s.timing.data_age_us.map(|age| age.p50 / 1e3),
    },
    Figure {
        column: number(
            "deadline_misses",
            "deadlines missed",
            "",
            2,
            "Control cycles that ended late",
        )
        .less()
        .weight(1),
        panel: "deadlines missed",
        label: "missed",
        fold: Fold::Mean,
        of: |s| s.timing.deadline_misses.map(|misses| misses as f64),
    },
    Figure {
        column: number(
            "undelivered_commands",
            "undelivered",
            "",
            2,
            "Commands that did not reach the plant",
        )
        .less()
        .weight(2),
        panel: "commands not delivered",
        label: "commands",
        fold: Fold::Mean,
        of: |s| s.timing.undelivered_commands.map(|commands| commands as f64),
    },
];

/// The figures of one run or point, in the order of [`ALL`].
pub type Values = [Option<f64>; COUNT];

/// The figures of a run.
pub fn values(summary: &Summary) -> Values {
    std::array::from_fn(|index| (ALL[index].of)(summary))
}

/// Several seeds as one figure.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Folded {
    /// The mean, or the worst.
    pub value: Option<f64>,
    /// Standard deviation over the seeds, of a sample; none of fewer than two seeds.
    pub deviation: Option<f64>,
    /// Seeds in which the figure applies.
    pub n: usize,
}

impl Fold {
    /// The figure that stands for those of several seeds. A seed in which it does not apply is left out.
    pub fn over(self, values: impl Iterator<Item = Option<f64>>) -> Folded {
        let values: Vec<f64> = values.flatten().collect();
        let n = values.len();
        if n == 0 {
            return Folded::default();
        }
        let mean = values.iter().sum::<f64>() / n as f64;
        let squares = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>();
        let value = match self {
            Self::Mean => mean,
            Self::Least => values.iter().copied().fold(f64::INFINITY, f64::min),
            Self::Most => values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        };
        let deviation = (n > 1).then(|| (squares / (n - 1) as f64).sqrt());
        Folded { value: Some(value), deviation, n }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seeds_are_folded_to_the_mean_with_its_spread_or_to_the_worst() {
        let seeds = [Some(1.0), None, Some(4.0)];
        let mean = Fold::Mean.over(seeds.into_iter());
        assert_eq!((mean.value, mean.n), (Some(2.5), 2));
        assert!((mean.deviation.expect("two seeds") - 4.5_f64.sqrt()).abs() < 1e-12);
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
