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
    /// Heading of its column.
    pub heading: &'static str,
    /// Panel of the picture that it is drawn in.
    pub panel: &'static str,
    /// How seeds are folded.
    pub fold: Fold,
    /// Its value; none where it does not apply.
    pub of: fn(&Summary) -> Option<f64>,
}

/// All figures, in the order of the columns. None of them depends on the wall clock in lockstep.
pub const ALL: [Figure; 11] = [
    Figure {
        name: "rms_gap_error_m",
        heading: "gap off rms, m",
        panel: "gap error, m",
        fold: Fold::Mean,
        of: |summary| summary.control.figures.rms_gap_error_m,
    },
    Figure {
        name: "max_abs_gap_error_m",
        heading: "most, m",
        panel: "gap error, m",
        fold: Fold::Most,
        of: |summary| summary.control.figures.max_abs_gap_error_m,
    },
    Figure {
        name: "rms_jerk_mps3",
        heading: "jerk rms, m/s³",
        panel: "jerk, m/s³",
        fold: Fold::Mean,
        of: |summary| summary.control.figures.rms_jerk_mps3,
    },
    Figure {
        name: "max_abs_jerk_mps3",
        heading: "most, m/s³",
        panel: "jerk, m/s³",
        fold: Fold::Most,
        of: |summary| summary.control.figures.max_abs_jerk_mps3,
    },
    Figure {
        name: "min_gap_m",
        heading: "min gap, m",
        panel: "smallest gap, m",
        fold: Fold::Least,
        of: |summary| summary.control.figures.min_gap_m,
    },
    Figure {
        name: "min_ttc_s",
        heading: "min TTC, s",
        panel: "smallest time to collision, s",
        fold: Fold::Least,
        of: |summary| summary.control.figures.min_ttc_s,
    },
    Figure {
        name: "stop_line_crossing_s",
        heading: "crossing, s",
        panel: "stop line crossed, s",
        fold: Fold::Mean,
        of: |summary| summary.control.figures.stop_line_crossing_s,
    },
    Figure {
        name: "fuel_l_per_100km",
        heading: "L/100 km",
        panel: "fuel, L/100 km",
        fold: Fold::Mean,
        of: |summary| summary.control.figures.fuel_l_per_100km,
    },
    Figure {
        name: "data_age_p50_ms",
        heading: "data age, ms",
        panel: "median data age, ms",
        fold: Fold::Mean,
        of: |summary| summary.timing.data_age_us.map(|age| age.p50 / 1e3),
    },
    Figure {
        name: "deadline_misses",
        heading: "missed",
        panel: "deadlines missed",
        fold: Fold::Mean,
        of: |summary| summary.timing.deadline_misses.map(|misses| misses as f64),
    },
    Figure {
        name: "undelivered_commands",
        heading: "undelivered",
        panel: "commands not delivered",
        fold: Fold::Mean,
        of: |summary| summary.timing.undelivered_commands.map(|commands| commands as f64),
    },
];

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
