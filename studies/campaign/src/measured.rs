//! The measured figures over some runs. Each has one row: its field, the name of its limits, its columns, and a run's
//! share. The counts stand in [`sums`](super::sums).

use super::record::Record;
use report::results::{Column, Object, count, micros, number};
use runtime::statistics::{Latencies, Percentiles};
use schemars::JsonSchema;
use serde::Serialize;

/// Weight of the columns of runs that are also among the totals.
pub const LEFT_OUT: u8 = 4;

/// All measured figures over some runs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct Measures {
    /// Least and largest values.
    #[serde(flatten)]
    pub extremes: Extremes,
    /// Times after process faults.
    #[serde(flatten)]
    pub times: Times,
}

/// A measured figure that campaigns can limit.
#[derive(Clone, Copy)]
pub struct MeasuredFigure {
    /// Name behind `max_` or `min_`.
    pub name: &'static str,
    /// Its value over some runs; `None` if no run measured it.
    pub of: fn(&Measures) -> Option<f64>,
    /// A single run cannot be to blame for it.
    pub is_median: bool,
}

/// Declares extremes: `field min or max, name of its limits (empty without), "heading", "unit", decimals, "meaning",
/// [shown how], record -> its value;`.
macro_rules! extremes {
    ($($field:ident $keep:ident, $limit:literal, $heading:literal, $unit:literal, $decimals:literal, $meaning:literal,
        [$($shown:tt)+], $of:expr;)+) => {
        /// Least and largest values over some runs; `None` if no run measured one.
        #[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
        pub struct Extremes {
            $(#[doc = $meaning] pub $field: Option<f64>,)+
        }

        impl Extremes {
            pub fn add(&mut self, record: &Record) {
                $(
                    let of: fn(&Record) -> Option<f64> = $of;
                    let (kept, found) = (self.$field, of(record));
                    self.$field = kept.zip(found).map(|(kept, found)| kept.$keep(found)).or(kept).or(found);
                )+
            }
        }

        /// Those that campaigns can limit, and those without a name.
        const EXTREMES: &[MeasuredFigure] =
            &[$(MeasuredFigure { name: $limit, of: |all| all.extremes.$field, is_median: false }),+];

        pub fn extreme_columns<R>() -> Vec<Column<R>> {
            vec![$(number(stringify!($field), $heading, $unit, $decimals, $meaning).$($shown)+),+]
        }
    };
}

extremes! {
    min_gap_m min, "gap_m", "min gap", "m", 1, "Smallest gap to the vehicle ahead", [weight(1)],
        |r| r.measured.min_gap_m;
    min_ttc_s min, "ttc_s", "min TTC", "s", 1, "Least time to collision", [weight(1)], |r| r.measured.min_ttc_s;
    command_overdue_ms max, "command_overdue_ms", "plant without a due command", "ms", 0, "Longest time", [hidden()],
        |r| r.measured.command_overdue_ms;
    all_memory_kib max, "", "memory of all services", "KiB", 0, "Largest of all runs", [hidden()],
        |r| Some(r.measured.growth.as_ref()?.all_memory_kib);
    all_descriptors max, "", "descriptors of all services", "", 0, "Largest of all runs", [hidden()],
        |r| Some(r.measured.growth.as_ref()?.all_descriptors);
    all_shared_memory_kib max, "", "shared memory", "KiB", 0, "Largest of all runs", [hidden()],
        |r| Some(r.measured.growth.as_ref()?.all_shared_memory_kib);
    memory_growth_kib max, "memory_growth_kib", "growth of memory", "KiB", 0, "Largest of a service in a run",
        [hidden()], |r| Some(r.measured.growth.as_ref()?.memory_kib);
    descriptor_growth max, "descriptor_growth", "growth of descriptors", "", 0, "Largest of a service in a run",
        [hidden()], |r| Some(r.measured.growth.as_ref()?.descriptors);
    shared_memory_growth_kib max, "shared_memory_growth_kib", "growth of shared memory", "KiB", 0, "Largest in a run",
        [hidden()], |r| Some(r.measured.growth.as_ref()?.shared_memory_kib);
    shared_memory_object_growth max, "shared_memory_object_growth", "growth of its objects", "", 0, "Largest in a run",
        [hidden()], |r| Some(r.measured.growth.as_ref()?.shared_memory_objects);
}

/// Declares times: `field "its name without the unit", "heading", "its plural", "what it is the time of", [p50 and max
/// shown how], "meaning of the whole", record -> its times in µs;`.
macro_rules! times {
    ($($field:ident $name:literal, $heading:literal, $plural:literal, $of_what:literal, [$($shown:tt)+],
        $meaning:literal, $of:expr;)+) => {
        /// Times over some runs; `None` if no run measured one.
        #[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
        pub struct Times {
            $(#[doc = $meaning] #[schemars(with = "Option<Object>")] pub $field: Option<Percentiles>,)+
        }

        /// Their histograms while runs are added. A histogram is large, and most campaigns do not need one.
        #[derive(Debug, Default)]
        pub struct Histograms {
            $(#[doc = $meaning] pub $field: Option<Latencies>,)+
        }

        impl Histograms {
            pub fn add(&mut self, record: &Record) {
                $(
                    let of: fn(&Record) -> &Vec<f64> = $of;
                    for us in of(record) {
                        self.$field.get_or_insert_default().record_ns((us * 1e3) as i64);
                    }
                )+
            }

            /// The times over the runs so far.
            pub fn times(&self) -> Times {
                let percentiles = |latencies: &Option<Latencies>| latencies.as_ref()?.percentiles_us();
                Times { $($field: percentiles(&self.$field),)+ }
            }
        }

        /// Their figures that campaigns can limit.
        const TIMES: &[MeasuredFigure] = &[$(
            MeasuredFigure {
                name: concat!($name, "_p50_ms"),
                of: |all| all.times.$field.map(|p| p.p50 / 1e3),
                is_median: true,
            },
            MeasuredFigure {
                name: concat!($name, "_p99_ms"),
                of: |all| all.times.$field.map(|p| p.p99 / 1e3),
                is_median: false,
            },
            MeasuredFigure {
                name: concat!($name, "_max_ms"),
                of: |all| all.times.$field.map(|p| p.max / 1e3),
                is_median: false,
            },
        )+];

        pub fn time_columns<R>() -> Vec<Column<R>> {
            vec![$(
                micros(concat!($name, "_us.p50"), concat!($heading, " p50"), concat!("Median time ", $of_what)).$($shown)+,
                micros(concat!($name, "_us.max"), concat!($heading, " max"), concat!("Longest time ", $of_what)).$($shown)+,
                count(concat!($name, "_us.count"), $plural, concat!("Timed ", $plural)).hidden(),
            )+]
        }
    };
}

times! {
    recovery_us "recovery", "recovery", "recoveries", "of a recovery", [weight(LEFT_OUT)],
        "From a fault to the next process's first message", |r| &r.measured.recovery_us;
    detection_us "detection", "detection", "detections", "until it was noticed", [hidden()],
        "From a fault until the launcher noticed it", |r| &r.measured.detection_us;
    take_over_us "take_over", "take-over", "take-overs", "of a take-over", [hidden()],
        "Recoveries by a standby that was ready", |r| &r.measured.take_over_us;
}

/// The measured figures that campaigns can limit.
pub fn limited() -> impl Iterator<Item = MeasuredFigure> {
    EXTREMES.iter().chain(TIMES).filter(|figure| !figure.name.is_empty()).copied()
}
