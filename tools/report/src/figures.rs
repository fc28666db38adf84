//! The figures of a drive: one table for every command that shows or compares them.
//!
//! ```text
//! Summary ─ Measured ─► Figure::value ─► Values ─┬─ columns of a study, tiles and console of a run
//!                                                ├─ runs.csv
//!                                                └─ Fold over seeds ─ compare, sweep, Python
//! ```
//!
//! A [`Figure`] has name, heading, unit, meaning, good values, and the way in which several runs become one number. A
//! study takes the columns that it shows from here, and adds columns of its own:
//!
//! ```
//! use report::figures::{self, MIN_GAP_M, MIN_TTC_S, Values};
//! use report::results::{Column, Table, word};
//!
//! #[derive(serde::Serialize)]
//! struct Row { law: &'static str, figures: Values }
//!
//! let columns: [Column<Row>; 3] = [
//!     word("law", "law", "Control law that drove"),
//!     MIN_GAP_M.of(|row| &row.figures),
//!     MIN_TTC_S.of(|row| &row.figures),
//! ];
//! let rows = [Row { law: "mine", figures: Values::default().with(&MIN_GAP_M, 8.25) }];
//! let table = Table::new("Laws", &columns, &rows);
//! assert_eq!(table.console(80), "  law   min gap, m\n  mine        8.25\n");
//! assert_eq!(figures::named("min_gap_m").expect("it is a figure").unit, "m");
//! ```
//!
//! Rows whose JSON has a figure at its own name use [`Figure::column`]. A row of folded runs uses [`Figure::folded`].

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Deserialize, Deserializer};
use serde::ser::{Serialize, SerializeMap, Serializer};
use statistics::Spread;
use std::borrow::Cow;
use std::collections::BTreeMap;

use crate::results::Good;
use crate::summary::{Control, LawAccount, Summary, Timing};

#[derive(Clone, Copy, Debug)]
pub struct Figure {
    /// Name in results, with its unit.
    pub name: &'static str,
    /// Heading, without the unit.
    pub heading: &'static str,
    /// Unit; empty for a count.
    pub unit: &'static str,
    /// Decimals for people; 0 for a count.
    pub decimals: usize,
    /// Weight of its column: the heaviest ones are left out where there is no room.
    pub weight: u8,
    pub meaning: &'static str,
    pub good: Good,
    /// Way from several runs to one number.
    pub fold: Fold,
    /// Title of the chart that shows it over a key; empty where keys and laws are not compared by it.
    pub panel: &'static str,
    of: fn(&Measured<'_>) -> Option<f64>,
}

/// Way from a figure of several runs to one number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fold {
    Mean,
    /// The smallest: the worst of a figure that must not be small.
    Least,
    /// The largest: the worst of a figure that must not be large.
    Most,
}

/// A figure of several runs as one number.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Folded {
    /// The mean, or the worst.
    pub value: Option<f64>,
    /// Spread over the runs in which the figure applies.
    pub spread: Spread,
}

impl Fold {
    /// Folds values. A run in which the figure does not apply is left out.
    pub fn over(self, values: impl IntoIterator<Item = Option<f64>>) -> Folded {
        let values: Vec<f64> = values.into_iter().flatten().collect();
        let spread = Spread::of(&values);
        let value = match self {
            Self::Mean => spread.mean,
            Self::Least => values.into_iter().reduce(f64::min),
            Self::Most => values.into_iter().reduce(f64::max),
        };
        Folded { value, spread }
    }
}

/// The parts of a run's summary that have figures. A study may keep these parts alone.
#[derive(Clone, Copy, Debug)]
pub struct Measured<'a> {
    /// Figures from ground truth.
    pub control: &'a Control,
    /// Latencies and deadlines.
    pub timing: &'a Timing,
    /// Cycles by who commanded.
    pub law: Option<&'a LawAccount>,
    /// Warnings of the emergency brake; none without it.
    pub warnings: Option<u64>,
    pub interventions: Option<u64>,
    pub braking_s: Option<f64>,
}

impl<'a> From<&'a Summary> for Measured<'a> {
    fn from(summary: &'a Summary) -> Self {
        let Summary { control, timing, law, aebs, .. } = summary;
        Self {
            control,
            timing,
            law: law.as_ref(),
            warnings: aebs.warnings,
            interventions: aebs.interventions,
            braking_s: aebs.braking_s,
        }
    }
}

impl Figure {
    /// Its value in a run; none where it does not apply.
    pub fn value<'a>(&self, run: impl Into<Measured<'a>>) -> Option<f64> {
        (self.of)(&run.into())
    }

    /// Laws and keys are compared by it.
    pub fn is_compared(&self) -> bool {
        !self.panel.is_empty()
    }

    /// A value with its unit.
    ///
    /// ```
    /// assert_eq!(report::figures::MIN_GAP_M.text(8.249), "8.25 m");
    /// ```
    pub fn text(&self, value: f64) -> String {
        format!("{} {}", crate::chart::number(value, self.decimals), self.unit)
            .trim_end()
            .to_owned()
    }
}

pub fn named(name: &str) -> Option<&'static Figure> {
    ALL.iter().find(|figure| figure.name == name)
}

/// The figures by which laws and keys are compared. Those of one chart stand together.
pub fn compared() -> impl Iterator<Item = &'static Figure> {
    ALL.iter().filter(|figure| figure.is_compared())
}

/// The figures of one drive, in JSON an object of all names.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Values(pub [Option<f64>; COUNT]);

impl Default for Values {
    fn default() -> Self {
        Self([None; COUNT])
    }
}

impl Values {
    pub fn of<'a>(run: impl Into<Measured<'a>>) -> Self {
        let run = run.into();
        Self(std::array::from_fn(|place| (ALL[place].of)(&run)))
    }

    pub fn get(&self, figure: &Figure) -> Option<f64> {
        self.iter().find(|(one, _)| one.name == figure.name)?.1
    }

    pub fn with(mut self, figure: &Figure, value: f64) -> Self {
        for (one, kept) in ALL.iter().zip(&mut self.0) {
            if one.name == figure.name {
                *kept = Some(value);
            }
        }
        self
    }

    pub fn iter(&self) -> impl Iterator<Item = (&'static Figure, Option<f64>)> {
        ALL.iter().zip(self.0)
    }
}

impl Serialize for Values {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(COUNT))?;
        for (figure, value) in self.iter() {
            map.serialize_entry(figure.name, &value)?;
        }
        map.end()
    }
}

impl<'de> Deserialize<'de> for Values {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let mut kept: BTreeMap<String, Option<f64>> = BTreeMap::deserialize(deserializer)?;
        Ok(Self(std::array::from_fn(|place| kept.remove(ALL[place].name).flatten())))
    }
}

impl JsonSchema for Values {
    fn schema_name() -> Cow<'static, str> {
        "FiguresOfADrive".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let figures = ALL.iter().map(|figure| {
            let meaning = match figure.unit {
                "" => figure.meaning.to_owned(),
                unit => format!("{}, {unit}", figure.meaning),
            };
            let figure_of = serde_json::json!({"type": ["number", "null"], "description": meaning});
            (figure.name.to_owned(), figure_of)
        });
        let properties: serde_json::Map<String, serde_json::Value> = figures.collect();
        let required: Vec<&str> = ALL.iter().map(|figure| figure.name).collect();
        json_schema!({"type": "object", "properties": properties, "required": required})
    }
}

/// Declares the figures and [`ALL`]: `CONSTANT "name": "heading" "unit" decimals / weight, good, fold,
/// "chart"; "meaning", run -> value;`.
macro_rules! figures {
    ($($figure:ident $name:literal: $heading:literal $unit:literal $decimals:literal / $weight:literal, $good:ident, $fold:ident,
        $panel:literal; $meaning:literal, $of:expr;)+) => {
        $(
            #[doc = $meaning]
            pub const $figure: Figure = Figure {
                name: $name,
                heading: $heading,
                unit: $unit,
                decimals: $decimals,
                weight: $weight,
                meaning: $meaning,
                good: Good::$good,
                fold: Fold::$fold,
                panel: $panel,
                of: $of,
            };
        )+

        /// All figures. In lockstep they do not depend on the wall clock.
        pub static ALL: [Figure; COUNT] = [$($figure),+];
        /// Number of figures.
        pub const COUNT: usize = [$($name),+].len();
    };
}

fn count(number: Option<u64>) -> Option<f64> {
    number.map(|number| number as f64)
}

figures! {
    RMS_GAP_ERROR_M "rms_gap_error_m": "gap error rms" "m" 2 / 0, Less, Mean, "gap error";
        "Root mean square of the gap error", |m| m.control.figures.rms_gap_error_m;
    MAX_ABS_GAP_ERROR_M "max_abs_gap_error_m": "max gap error" "m" 2 / 3, Less, Most, "gap error";
        "Largest magnitude of the gap error", |m| m.control.figures.max_abs_gap_error_m;
    FINAL_GAP_ERROR_M "final_gap_error_m": "gap error at the end" "m" 2 / 5, Neither, Mean, "";
        "Gap error at the end of the run", |m| m.control.figures.final_gap_error_m;
    RMS_JERK_MPS3 "rms_jerk_mps3": "jerk rms" "m/s³" 2 / 1, Less, Mean, "jerk";
        "Root mean square of the jerk", |m| m.control.figures.rms_jerk_mps3;
    MAX_ABS_JERK_MPS3 "max_abs_jerk_mps3": "max jerk" "m/s³" 2 / 3, Less, Most, "jerk";
        "Largest magnitude of the jerk", |m| m.control.figures.max_abs_jerk_mps3;
    MIN_GAP_M "min_gap_m": "min gap" "m" 2 / 0, More, Least, "smallest gap";
        "Smallest gap to the vehicle ahead", |m| m.control.figures.min_gap_m;
    MIN_TTC_S "min_ttc_s": "min TTC" "s" 2 / 1, More, Least, "smallest time to collision";
        "Smallest time to collision", |m| m.control.figures.min_ttc_s;
    IMPACT_SPEED_MPS "impact_speed_mps": "impact" "m/s" 2 / 2, Less, Mean, "impact speed";
        "Speed difference at the contact", |m| m.control.figures.impact_speed_mps;
    MIN_TIME_GAP_S "min_time_gap_s": "min time gap" "s" 2 / 1, More, Least, "time gap";
        "Smallest time gap to the vehicle ahead", |m| m.control.following.min_time_gap_s;
    MEDIAN_TIME_GAP_S "median_time_gap_s": "median time gap" "s" 2 / 3, Neither, Mean, "time gap";
        "Median time gap", |m| m.control.following.median_time_gap_s;
    FINAL_SPEED_ERROR_MPS "final_speed_error_mps": "speed error at the end" "m/s" 2 / 5, Neither, Mean, "";
        "Speed error at the end of the run", |m| m.control.figures.final_speed_error_mps;
    MIN_ACCEL_MPS2 "min_accel_mps2": "hardest braking" "m/s²" 2 / 2, More, Least, "hardest braking";
        "Smallest acceleration", |m| m.control.figures.min_accel_mps2;
    MAX_ACCEL_MPS2 "max_accel_mps2": "max acceleration" "m/s²" 2 / 4, Neither, Most, "";
        "Largest acceleration", |m| m.control.figures.max_accel_mps2;
    MAX_ABS_LATERAL_ACCEL_MPS2 "max_abs_lateral_accel_mps2": "max lateral acceleration" "m/s²" 2 / 4, Neither, Most, "";
        "Largest magnitude of the lateral acceleration", |m| m.control.figures.max_abs_lateral_accel_mps2;
    MAX_ABS_LATERAL_JERK_MPS3 "max_abs_lateral_jerk_mps3": "max lateral jerk" "m/s³" 2 / 4, Neither, Most, "";
        "Largest magnitude of the lateral jerk", |m| m.control.figures.max_abs_lateral_jerk_mps3;
    OUTSIDE_LANE_S "outside_lane_s": "outside the lane" "s" 1 / 4, Less, Most, "";
        "Time with a part of the body outside the lane", |m| m.control.figures.outside_lane_s;
    TRIP_TIME_S "trip_time_s": "trip" "s" 1 / 3, Neither, Mean, "";
        "Time at which the last stop line was passed", |m| m.control.trip.trip_time_s;
    FASTEST_LEGAL_TRIP_S "fastest_legal_trip_s": "fastest legal trip" "s" 1 / 5, Neither, Mean, "";
        "Lower bound of the trip's time", |m| m.control.trip.fastest_legal_trip_s;
    TRIP_OVER_FASTEST_S "trip_over_fastest_s": "trip over the fastest" "s" 2 / 2, Less, Mean, "trip over the fastest";
        "Trip time beyond the fastest legal trip", |m| m.control.trip.over_fastest_s();
    STOP_LINE_CROSSING_S "stop_line_crossing_s": "crossing" "s" 2 / 1, Neither, Mean, "stop line crossed";
        "Time at which a stop line was crossed", |m| m.control.figures.stop_line_crossing_s;
    PAST_STOP_LINE_AT_SWITCH_M "past_stop_line_at_switch_m": "past the line at the change" "m" 1 / 5, Neither, Mean, "";
        "Way past the stop line when the light changed", |m| m.control.figures.past_stop_line_at_switch_m;
    STOPS "stops": "stops" "" 0 / 3, Less, Mean, "stops";
        "Times that the vehicle came to a stand", |m| count(m.control.figures.stops);
    FUEL_L_PER_100KM "fuel_l_per_100km": "fuel" "L/100 km" 2 / 2, Less, Mean, "fuel";
        "Fuel", |m| m.control.figures.fuel_l_per_100km;
    WHEEL_ENERGY_KWH_PER_100KM "wheel_energy_kwh_per_100km": "wheels" "kWh/100 km" 2 / 2, Less, Mean,
        "energy at the wheels"; "Energy at the wheels", |m| m.control.figures.wheel_energy_kwh_per_100km;
    GEAR_SHIFTS "gear_shifts": "gear shifts" "" 0 / 5, Neither, Mean, "";
        "Gear shifts", |m| count(m.control.figures.gear_shifts);
    SERVICE_BRAKE_S "service_brake_s": "service brakes" "s" 1 / 5, Neither, Mean, "";
        "Time with the service brakes applied", |m| m.control.figures.service_brake_s;
    WARNINGS "warnings": "warnings" "" 0 / 5, Neither, Most, "";
        "Warnings of the emergency brake", |m| count(m.warnings);
    INTERVENTIONS "interventions": "emergency brakings" "" 0 / 1, Less, Most, "emergency brakings";
        "Interventions of the emergency brake", |m| count(m.interventions);
    BRAKING_S "braking_s": "emergency braking" "s" 1 / 4, Neither, Most, "";
        "Time for which the emergency brake braked", |m| m.braking_s;
    CYCLES_BY_BACKUP "cycles_by_backup": "cycles by backup" "" 0 / 2, Less, Most, "";
        "Cycles that the backup of the law commanded", |m| count(m.law.map(|law| law.backup));
    DATA_AGE_P50_MS "data_age_p50_ms": "data age" "ms" 2 / 2, Neither, Mean, "median data age";
        "Median age of the radar data behind an actuation", |m| m.timing.data_age_us.map(|age| age.p50 / 1e3);
    REACTION_TIME_P50_MS "reaction_time_p50_ms": "reaction time" "ms" 2 / 4, Neither, Mean, "";
        "Median time from the radar to an actuation", |m| m.timing.reaction_time_us.map(|time| time.p50 / 1e3);
    DEADLINE_MISSES "deadline_misses": "deadlines missed" "" 0 / 1, Less, Mean, "deadlines missed";
        "Control cycles that ended late", |m| count(m.timing.deadline_misses);
    UNDELIVERED_COMMANDS "undelivered_commands": "undelivered" "" 0 / 2, Less, Mean, "commands not delivered";
        "Commands that did not reach the plant", |m| count(m.timing.undelivered_commands);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn several_runs_are_folded_to_the_mean_with_its_spread_or_to_the_worst() {
        let seeds = [Some(1.0), None, Some(4.0)];
        let mean = Fold::Mean.over(seeds);
        assert_eq!((mean.value, mean.spread.n), (Some(2.5), 2));
        assert_eq!(Fold::Least.over(seeds).value, Some(1.0));
        assert_eq!(Fold::Most.over(seeds).value, Some(4.0));
        assert_eq!(Fold::Mean.over([None]), Folded::default());
    }

    #[test]
    fn names_are_different_and_the_figures_of_a_chart_stand_together() {
        for (place, figure) in ALL.iter().enumerate() {
            assert!(ALL[..place].iter().all(|other| other.name != figure.name), "{}", figure.name);
        }
        let mut panels: Vec<&str> = compared().map(|figure| figure.panel).collect();
        panels.dedup();
        for (place, panel) in panels.iter().enumerate() {
            assert!(!panels[..place].contains(panel), "{panel}");
        }
    }

    #[test]
    fn the_figures_of_a_drive_are_an_object_of_their_names() {
        let values = Values::default().with(&MIN_GAP_M, 2.5);
        let json = serde_json::to_value(values).expect("plain data");
        assert_eq!((json["min_gap_m"].as_f64(), json["stops"].is_null()), (Some(2.5), true));
        let back: Values = serde_json::from_value(json).expect("the same object");
        assert_eq!(back, values);
        assert_eq!((back.get(&MIN_GAP_M), back.get(&STOPS)), (Some(2.5), None));
    }
}
